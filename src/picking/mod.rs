//! A backend for `bevy_picking` that asks the index: a drop-in for Bevy's `MeshPickingPlugin`.
//!
//! Reports what Bevy's backend reports, for every pointer and camera: the same entities by the same rules
//! ([`Pickable`], [`MeshPickingSettings`], [`MeshPickingCamera`], render layers, camera order, `SimplifiedMesh`,
//! `RayCastBackfaces`, visibility), up to the first that blocks what is behind it: see [`SpatialPickingSettings`].
//! Beyond that it picks what Bevy's backend misses: triangle strips, tiny triangles, a
//! `SimplifiedMesh` that sticks out of the drawn mesh, and meshes without an `Aabb` (`NoFrustumCulling`). Normals have
//! unit length and are right under every scale, and the whole [`RayHit`] is in
//! [`HitData::extra`](bevy::picking::backend::HitData::extra):
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! fn on_click(click: On<Pointer<Click>>) {
//!     if let Some(hit) = click.hit.extra_as::<RayHit>() {
//!         println!("clicked {} at {} on triangle {:?}", hit.entity, hit.position, hit.triangle);
//!     }
//! }
//! ```

use std::time::Duration;

use bevy::{
    app::{App, Plugin, PreUpdate},
    camera::{Camera, visibility::RenderLayers},
    ecs::{
        change_detection::{Res, ResMut},
        entity::Entity,
        message::MessageWriter,
        query::Has,
        reflect::ReflectResource,
        resource::Resource,
        schedule::{IntoScheduleConfigs, common_conditions::resource_exists},
        system::{Local, Query},
    },
    picking::{
        Pickable, PickingSystems,
        backend::{HitData, PointerHits, ray::RayMap},
        mesh_picking::{MeshPickingCamera, MeshPickingPlugin, MeshPickingSettings, ray_cast::RayCastVisibility},
    },
    reflect::{Reflect, std_traits::ReflectDefault},
};
use tracing::warn;

use crate::{
    index::{DetailLevel, QueryVisibility, RayHit, SceneQuery, SceneQuerySettings, SpatialIndexPlugin},
    lod::LodChoices,
    phase::phase,
};

/// What [`SpatialPickingPlugin`] does differently from Bevy's `MeshPickingPlugin`; what the two have in common is in
/// [`MeshPickingSettings`].
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct SpatialPickingSettings {
    /// Whether to report hits behind an entity that has no [`Pickable`] too, as Bevy's backend does.
    ///
    /// Such an entity blocks what is behind it: no pointer event ever reaches that, and it is not in the `HoverMap`. So
    /// by default rays end there, which is what makes the cost of a pick independent of all that is hidden. Set this
    /// if you read [`PointerHits`] yourself and want to see through things.
    pub report_blocked: bool,
}

/// What picking did in the last frame, and how long it took.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SpatialPickingStats {
    /// The rays that were cast: one for each pointer and camera that it is over.
    pub rays: usize,
    /// The hits that were reported.
    pub hits: usize,
    /// The time that it took.
    pub time: Duration,
}

/// Picks meshes with the pointer. Add it in place of `MeshPickingPlugin`; adds [`SpatialIndexPlugin`] by itself.
///
/// Needs Bevy's `DefaultPickingPlugins`, which are among its `DefaultPlugins`; does nothing without them.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpatialPickingPlugin;

impl Plugin for SpatialPickingPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<MeshPickingSettings>()
            .init_resource::<SpatialPickingSettings>()
            .init_resource::<SpatialPickingStats>()
            .register_type::<SpatialPickingSettings>()
            .register_type::<SpatialPickingStats>()
            .add_systems(
                PreUpdate,
                update_hits
                    .run_if(resource_exists::<RayMap>)
                    .in_set(PickingSystems::Backend),
            );
    }

    fn finish(&self, app: &mut App) {
        if app.is_plugin_added::<MeshPickingPlugin>() {
            warn!("SpatialPickingPlugin replaces MeshPickingPlugin: with both, everything is picked twice");
        }
    }
}

/// Casts the ray of every pointer through every camera that it is over, and sends the hits.
pub fn update_hits(
    settings: Res<MeshPickingSettings>,
    own_settings: Res<SpatialPickingSettings>,
    rays: Res<RayMap>,
    cameras: Query<(&Camera, Has<MeshPickingCamera>, Option<&RenderLayers>)>,
    pickables: Query<&Pickable>,
    levels: Query<&DetailLevel>,
    lods: Option<Res<LodChoices>>,
    scene: SceneQuery,
    mut stats: ResMut<SpatialPickingStats>,
    mut hits: Local<Vec<RayHit>>,
    mut pointer_hits: MessageWriter<PointerHits>,
) {
    let phase = phase!("sightline/picking/backend");
    let (mut cast, mut reported) = (0, 0);
    for (id, ray) in rays.iter() {
        let Ok((camera, is_marked, layers)) = cameras.get(id.camera) else {
            continue;
        };
        if settings.require_markers && !is_marked {
            continue;
        }

        let is_shown = |entity: Entity| {
            let is_any_level = levels.get(entity) != Ok(&DetailLevel::AsShown);
            is_any_level || lods.as_deref().is_none_or(|lods| lods.shows(id.camera, entity))
        };
        let is_candidate = |entity: Entity| match pickables.get(entity) {
            Ok(pickable) => pickable.is_hoverable && is_shown(entity),
            Err(_) => !settings.require_markers && is_shown(entity),
        };
        let blocks = |entity: Entity| match pickables.get(entity) {
            Ok(pickable) => pickable.should_block_lower,
            Err(_) => !own_settings.report_blocked,
        };
        let query = SceneQuerySettings::default()
            .with_layers(layers.unwrap_or_default())
            .with_visibility(match settings.ray_cast_visibility {
                RayCastVisibility::Any => QueryVisibility::Any,
                RayCastVisibility::Visible => QueryVisibility::Visible,
                RayCastVisibility::VisibleInView => QueryVisibility::VisibleInView,
            })
            .filter(&is_candidate);
        scene.cast_ray_until(*ray, &query, blocks, &mut hits);
        cast += 1;
        reported += hits.len();

        if !hits.is_empty() {
            let picks = hits.iter().map(|hit| (hit.entity, hit_data(id.camera, hit)));
            pointer_hits.write(PointerHits::new(id.pointer, picks.collect(), camera.order as f32));
        }
    }
    *stats = SpatialPickingStats {
        rays: cast,
        hits: reported,
        time: phase.end(),
    };
}

fn hit_data(camera: Entity, hit: &RayHit) -> HitData {
    HitData::new_with_extra(camera, hit.distance, Some(hit.position), Some(hit.normal), *hit)
}
