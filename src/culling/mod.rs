//! View culling: Bevy's own visibility, without touching what is not seen.
//!
//! [`ViewCullingPlugin`] takes the place of Bevy's frustum culling for cameras and for the shadow maps of lights, with
//! the same answers in the same places: [`VisibleEntities`], [`ViewVisibility`], and the lists of lights. Renderers,
//! extraction, picking and the code of games notice nothing but the time. [`VisibleSet`] tells games what each camera
//! sees.
//!
//! # What it costs
//!
//! Bevy tests every entity for every camera, cascade, cube face and spot light, in every frame. Here the tree of the
//! [`SpatialIndex`](crate::index::SpatialIndex) is asked: what lies wholly inside of a frustum is accepted as a whole,
//! what lies outside is never touched, and Bevy's tests, with their rounding, decide only what a plane of the frustum
//! cuts. Of what is seen, only what was not seen in the last frame, or has changed, is looked at and written: the sorted
//! lists are amended. While nothing moves, neither the world nor the view, the tree is not asked either.
//!
//! # What is not in the tree
//!
//! Skinned and morphed meshes, whose boxes in the index are those of their poses, entities with a `Sphere` and no
//! `Aabb`, and what is [left out of the index](crate::index) are tested one by one, as Bevy does. What has neither
//! bounds nor the wish to be culled costs nothing from frame to frame.
//!
//! # What is hidden
//!
//! Cameras with [`SoftwareOcclusion`](crate::occlusion::SoftwareOcclusion) leave out what is behind
//! [occluders](crate::occlusion). For these the tree is descended from the nearest to the farthest, node by node.
//! [`VisibilityReasons`] tells why something is not seen.
//!
//! # Marks of others
//!
//! Systems that mark entities by [`SetViewVisibility`] belong into [`VisibilitySystems::CheckVisibility`], as Bevy has
//! it, and are found out by the change ticks that they leave. From [`VisibilitySystems::CheckVisibility`] on every
//! `ViewVisibility` is as Bevy has it, and has changed when it changes there. Before, where Bevy has it tell of nothing
//! that it is visible, it tells here of the last frame, except for what no camera sees any more.
//!
//! # What it cannot know
//!
//! The index is of the time of [`SpatialIndexSystems::Sync`]: whoever moves `GlobalTransform`s or changes `Aabb`s after
//! that and before [`VisibilitySystems::CheckVisibility`] is seen where they were. While `Sync` is paused, everything
//! is tested one by one. A component that [disables](bevy::ecs::entity_disabling) entities, other than `Disabled`, is
//! noticed by the number of those that are left.
//!
//! [`SetViewVisibility`]: bevy::camera::visibility::SetViewVisibility
//! [`ViewVisibility`]: bevy::camera::visibility::ViewVisibility
//! [`VisibleEntities`]: bevy::camera::visibility::VisibleEntities

mod bits;
mod cameras;
mod candidates;
mod follow;
mod levels;
mod lights;
mod marks;
mod reasons;
mod replace;
mod shape;
mod sorted;
mod stats;
mod view;
mod visible_set;

pub use reasons::{VisibilityReason, VisibilityReasons};
pub use stats::ViewCullingStats;
pub use visible_set::{EnteredView, LeftView, ReportViewChanges, VisibleEntity, VisibleSet};

use bevy::{
    app::{App, Plugin, PostUpdate},
    camera::{
        Camera,
        visibility::{VisibilityPlugin, VisibilitySystems, check_visibility_cpu_culling, check_visibility_ranges},
    },
    ecs::{
        change_detection::{Res, ResMut},
        entity::Entity,
        reflect::ReflectResource,
        resource::Resource,
        schedule::{IntoScheduleConfigs, SystemSet},
        system::IntoSystem,
    },
    light::{SimulationLightSystems, check_dir_light_mesh_visibility, check_point_light_mesh_visibility},
    platform::collections::HashMap,
    reflect::{Reflect, std_traits::ReflectDefault},
};
use tracing::warn;

use crate::{
    index::{SpatialIndexPlugin, SpatialIndexSystems},
    lod::LodSystems,
    occlusion::OcclusionSystems,
    phase::phase,
};
use cameras::Looking;
use candidates::Candidates;
use marks::{Marks, Turnover, ViewVisibilities};
use view::View;

/// When views are culled; all in `PostUpdate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub enum ViewCullingSystems {
    /// What cameras have in sight is found. After frusta and the [`SpatialIndex`](crate::index::SpatialIndex) are
    /// brought up to date, before [`VisibilitySystems::CheckVisibility`].
    Find,
    /// It is written to `VisibleEntities`, [`VisibleSet`] and `ViewVisibility`. In
    /// [`VisibilitySystems::CheckVisibility`].
    Write,
    /// The same for the shadow maps of lights. In [`SimulationLightSystems::CheckLightVisibility`].
    Lights,
    /// What nothing sees any more is hidden: after the lights, and with
    /// [`VisibilitySystems::MarkNewlyHiddenEntitiesInvisible`].
    Hide,
}

/// How views are culled.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct ViewCullingSettings {
    /// Whether views are culled by the index. If not, Bevy's own systems do it, from this frame on: for comparison.
    pub enabled: bool,
}

impl Default for ViewCullingSettings {
    fn default() -> Self {
        Self { enabled: true }
    }
}

/// Culls for cameras and lights by the index, in the place of Bevy's own systems: see [`culling`](self).
///
/// Needs Bevy's `CameraPlugin`, and for lights its `LightPlugin`, which are among its `DefaultPlugins`; does nothing
/// without them. Adds [`SpatialIndexPlugin`] by itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct ViewCullingPlugin;

impl Plugin for ViewCullingPlugin {
    fn build(&self, app: &mut App) {
        // Cameras that are there already do without.
        let _ = app.try_register_required_components::<Camera, VisibleSet>();
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<ViewCulling>()
            .init_resource::<ViewCullingSettings>()
            .init_resource::<ViewCullingStats>()
            .register_type::<ViewCullingSettings>()
            .register_type::<ViewCullingStats>()
            .register_type::<VisibleSet>()
            .register_type::<ReportViewChanges>()
            .register_type::<EnteredView>()
            .register_type::<LeftView>()
            .register_type::<VisibilityReason>()
            .configure_sets(
                PostUpdate,
                (
                    ViewCullingSystems::Find
                        .after(SpatialIndexSystems::Sync)
                        .after(OcclusionSystems::FollowOccluders)
                        .after(LodSystems::Choose)
                        .after(VisibilitySystems::UpdateFrusta)
                        .after(VisibilitySystems::VisibilityPropagate)
                        .before(VisibilitySystems::CheckVisibility)
                        .run_if(culls_views),
                    ViewCullingSystems::Write
                        .in_set(VisibilitySystems::CheckVisibility)
                        .after(check_visibility_ranges)
                        .before(check_visibility_cpu_culling)
                        .run_if(culls_views),
                    ViewCullingSystems::Lights
                        .in_set(SimulationLightSystems::CheckLightVisibility)
                        .after(SimulationLightSystems::UpdateLightFrusta)
                        .after(VisibilitySystems::CheckVisibility)
                        .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible)
                        .run_if(culls_lights),
                    ViewCullingSystems::Hide
                        .in_set(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible)
                        .run_if(culls_views),
                    // A mesh that is swapped occludes as what it is now.
                    OcclusionSystems::FollowOccluders.after(LodSystems::Choose),
                    // Lights are given bounds there.
                    SpatialIndexSystems::Sync.after(SimulationLightSystems::UpdateBounds),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    // One system, for both are short, and to go from one to the next takes a while.
                    follow::follow_candidates
                        .pipe(cameras::find_visible)
                        .in_set(ViewCullingSystems::Find),
                    cameras::write_visible.in_set(ViewCullingSystems::Write),
                    lights::cull_lights
                        .run_if(lights::has_shadow_maps)
                        .in_set(ViewCullingSystems::Lights),
                    hide_unseen.run_if(has_set_back).in_set(ViewCullingSystems::Hide),
                    levels::leave_out_of_cameras
                        .in_set(VisibilitySystems::CheckVisibility)
                        .after(LodSystems::Choose)
                        .after(check_visibility_cpu_culling)
                        .run_if(is_left_to_bevy),
                    levels::leave_out_of_lights
                        .in_set(SimulationLightSystems::CheckLightVisibility)
                        .after(check_dir_light_mesh_visibility)
                        .after(check_point_light_mesh_visibility)
                        .run_if(is_left_to_bevy),
                ),
            );
    }

    fn finish(&self, app: &mut App) {
        let replaces_views = replace::replace_view_culling(app);
        let replaces_lights = replaces_views && replace::replace_light_culling(app);
        let mut culling = app.world_mut().resource_mut::<ViewCulling>();
        (culling.replaces_views, culling.replaces_lights) = (replaces_views, replaces_lights);
        // A server has no cameras, and nothing to be told of.
        if !replaces_views && app.is_plugin_added::<VisibilityPlugin>() {
            warn!("ViewCullingPlugin leaves the culling of views to Bevy: that is not as this version of Bevy has it");
        }
    }
}

/// What is known of views from frame to frame.
#[derive(Resource, Debug, Default)]
struct ViewCulling {
    candidates: Candidates,
    /// The views that are not looking now.
    views: HashMap<ViewKey, View>,
    /// The cameras that have found what they see and have not written it yet.
    looking: Vec<Looking>,
    turnover: Turnover,
    marks: Marks,
    /// Which synchronisation of the index is known.
    syncs: u64,
    /// Whether the index is of this frame.
    index_is_current: bool,
    replaces_views: bool,
    replaces_lights: bool,
}

/// Who looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum ViewKey {
    Camera(Entity),
    Cascade {
        light: Entity,
        camera: Entity,
        number: usize,
    },
    CubeFace {
        light: Entity,
        number: usize,
    },
    SpotLight(Entity),
}

impl ViewKey {
    fn viewer(self) -> Entity {
        match self {
            Self::Camera(viewer) | Self::SpotLight(viewer) => viewer,
            Self::Cascade { light, .. } | Self::CubeFace { light, .. } => light,
        }
    }
}

impl ViewCulling {
    /// Everything is to be found out anew.
    fn forget(&mut self) {
        self.candidates = Candidates::default();
        self.views.clear();
        self.looking.clear();
        self.marks.forget();
    }
}

fn culls_views(culling: Res<ViewCulling>, settings: Res<ViewCullingSettings>) -> bool {
    culling.replaces_views && settings.enabled
}

fn culls_lights(culling: Res<ViewCulling>, settings: Res<ViewCullingSettings>) -> bool {
    culling.replaces_lights && settings.enabled
}

fn is_left_to_bevy(settings: Res<ViewCullingSettings>) -> bool {
    !settings.enabled
}

/// Whether there may be something to hide.
fn has_set_back(culling: Res<ViewCulling>) -> bool {
    culling.marks.has_set_back()
}

/// Hides what nothing sees any more.
fn hide_unseen(
    mut culling: ResMut<ViewCulling>,
    mut stats: ResMut<ViewCullingStats>,
    mut visibilities: ViewVisibilities,
) {
    let phase = phase!("sightline/culling/hide");
    let ViewCulling { candidates, marks, .. } = &mut *culling;
    marks.hide_unseen(candidates, &mut visibilities);
    stats.hide = phase.end();
}
