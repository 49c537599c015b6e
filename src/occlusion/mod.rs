//! Occlusion: what hides what is behind it.
//!
//! # What occludes
//!
//! An entity with an [`Occluder`], which says by what shape:
//!
//! | | shape | of what it is made | what is needed |
//! |---|---|---|---|
//! | [`Auto`](Occluder::Auto) | [boxes inside of the mesh](crate::mesh::InnerBoxes) | its `Mesh3d` | a closed mesh |
//! | [`Box`](Occluder::Box) | its box | its `Aabb`, also without a mesh | that it fills its box |
//! | [`Mesh`](Occluder::Mesh) | triangles | its `Mesh3d` | few triangles |
//! | [`Proxy`](Occluder::Proxy) | triangles | any mesh | that this lies within what is drawn |
//!
//! It occludes while it is shown (`InheritedVisibility`), has a `GlobalTransform` that is finite, and no
//! `VisibilityRange` in whose margins it is half there. `Auto` and `Mesh` follow the mesh asset; a mesh that is skinned
//! or morphed is not where its vertices are, and does not occlude by them. Nothing is known of materials: what is drawn
//! in part, blended, or by a shader that moves it must not have an `Occluder`. Nor is it known what the renderer cannot draw
//! yet: a mesh whose pipeline is being compiled, or an `Aabb` whose mesh is not loaded any more, hides already.
//!
//! An `Occluder` belongs on each entity with a mesh. On the root of a scene it does nothing.
//!
//! Where every mesh is opaque and stays where its box is, all may occlude:
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! # let mut app = App::new();
//! app.register_required_components::<Mesh3d, Occluder>();
//! ```
//!
//! # When
//!
//! Shapes are made of a mesh once, in the background, for all entities that use it. Until then, and from any change of
//! the asset to the next shape, they hide nothing. [`Occluders`] is brought up to date in
//! [`OcclusionSystems::FollowOccluders`], by what has changed.
//!
//! # What is hidden
//!
//! A camera with [`SoftwareOcclusion`] leaves out of its lists what is behind occluders, in the frame in which anything
//! moves. The tree of the index is descended from the nearest to the farthest. What is met is tested against the
//! [depth buffer](crate::raster) of the camera, and what occludes is drawn to it; below a node that is hidden nothing is
//! looked at. What was seen before something nearer hid it is tested once more in the end. As long as nothing moves,
//! nothing is drawn or tested.
//!
//! Lights see what is hidden from cameras, for it casts shadows. Never left out is what has [`NoOcclusionCulling`] or
//! `NoFrustumCulling`, and what is not in the index. [`VisibilityReasons`](crate::culling::VisibilityReasons) tells of an
//! entity that it is occluded, and [`OcclusionBuffer`] of a camera what hides.
//!
//! # What does not occlude
//!
//! If it should: an open mesh, a mesh without data, a pose. It is listed by [`Occluders::refused`], with one warning.
//!
//! For one camera: what it does not draw itself, what has a `VisibilityRange`, what is smaller than the
//! [budget](OcclusionBudget) wants it. Also what the eye is in, or the near plane cuts: one sees through the inside. And
//! what is mirrored, or seen by a camera with `invert_culling`, but not both: a renderer shows the inside of that. Cameras
//! whose depth is not reversed, or whose near plane is so oblique that it does not cross every line of sight, have nothing
//! hidden from them, with one warning.
//!
//! What is skinned or morphed, and hit by rays as something else than its mesh (`PickShape`, `SimplifiedMesh`, `HitSurface`),
//! is never left out either: the index knows the other thing.

mod camera;
mod follow;
mod hide;
mod occluder;
mod occluders;
mod shapes;
mod stats;

pub use camera::{NoOcclusionCulling, OcclusionBudget, OcclusionBuffer, OcclusionStats, SoftwareOcclusion};
pub(crate) use hide::{Surroundings, Viewpoint};
pub use occluder::{Occluder, OccluderSettings};
pub use occluders::{OccluderRefusal, OccluderShape, Occluders};
pub use stats::OccluderStats;

use bevy::{
    app::{App, Plugin, PostUpdate},
    camera::visibility::VisibilitySystems,
    ecs::schedule::{IntoScheduleConfigs, SystemSet},
};

use crate::index::{SpatialIndexPlugin, SpatialIndexSystems};

/// When it is found out what is hidden; all in `PostUpdate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub enum OcclusionSystems {
    /// [`Occluders`] are brought up to date: after the index, before views are culled.
    FollowOccluders,
}

/// Keeps the [`Occluders`]. Adds [`SpatialIndexPlugin`] by itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct OcclusionPlugin;

impl Plugin for OcclusionPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<Occluders>()
            .init_resource::<OccluderSettings>()
            .init_resource::<OccluderStats>()
            .register_type::<Occluder>()
            .register_type::<OccluderSettings>()
            .register_type::<OccluderStats>()
            .register_type::<NoOcclusionCulling>()
            .register_type::<SoftwareOcclusion>()
            .configure_sets(
                PostUpdate,
                OcclusionSystems::FollowOccluders
                    .after(SpatialIndexSystems::Sync)
                    .before(VisibilitySystems::CheckVisibility),
            )
            .add_systems(
                PostUpdate,
                follow::follow_occluders.in_set(OcclusionSystems::FollowOccluders),
            );
    }
}
