//! A backend for `bevy_picking` that asks the index: a drop-in for Bevy's `MeshPickingPlugin`.
//!
//! Reports what Bevy's backend reports, for every pointer and camera: the same entities by the same rules
//! ([`Pickable`], [`MeshPickingSettings`], [`MeshPickingCamera`], render layers, camera order, `SimplifiedMesh`,
//! `RayCastBackfaces`, visibility). Beyond that it picks what Bevy's backend misses: triangle strips, tiny triangles, a
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

use bevy::{
    app::{App, Plugin, PreUpdate},
    camera::{Camera, visibility::RenderLayers},
    ecs::{
        change_detection::Res,
        entity::Entity,
        message::MessageWriter,
        query::Has,
        schedule::{IntoScheduleConfigs, common_conditions::resource_exists},
        system::{Local, Query},
    },
    picking::{
        Pickable, PickingSystems,
        backend::{HitData, PointerHits, ray::RayMap},
        mesh_picking::{MeshPickingCamera, MeshPickingPlugin, MeshPickingSettings, ray_cast::RayCastVisibility},
    },
};
use tracing::warn;

use crate::index::{QueryVisibility, RayHit, SceneQuery, SceneQuerySettings, SpatialIndexPlugin};

/// Picks meshes with the pointer. Add it in place of `MeshPickingPlugin`; adds [`SpatialIndexPlugin`] by itself.
///
/// Needs Bevy's `DefaultPickingPlugins`, which are among its `DefaultPlugins`; does nothing without them.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpatialPickingPlugin;

impl Plugin for SpatialPickingPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<MeshPickingSettings>()
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
    rays: Res<RayMap>,
    cameras: Query<(&Camera, Has<MeshPickingCamera>, Option<&RenderLayers>)>,
    pickables: Query<&Pickable>,
    scene: SceneQuery,
    mut hits: Local<Vec<RayHit>>,
    mut pointer_hits: MessageWriter<PointerHits>,
) {
    for (id, ray) in rays.iter() {
        let Ok((camera, is_marked, layers)) = cameras.get(id.camera) else {
            continue;
        };
        if settings.require_markers && !is_marked {
            continue;
        }

        let is_candidate = |entity: Entity| match pickables.get(entity) {
            Ok(pickable) => pickable.is_hoverable,
            Err(_) => !settings.require_markers,
        };
        let blocks = |entity: Entity| pickables.get(entity).is_ok_and(|p| p.should_block_lower);
        let query = SceneQuerySettings::default()
            .with_layers(layers.unwrap_or_default())
            .with_visibility(match settings.ray_cast_visibility {
                RayCastVisibility::Any => QueryVisibility::Any,
                RayCastVisibility::Visible => QueryVisibility::Visible,
                RayCastVisibility::VisibleInView => QueryVisibility::VisibleInView,
            })
            .filter(&is_candidate);
        scene.cast_ray_until(*ray, &query, blocks, &mut hits);

        if !hits.is_empty() {
            let picks = hits.iter().map(|hit| (hit.entity, hit_data(id.camera, hit)));
            pointer_hits.write(PointerHits::new(id.pointer, picks.collect(), camera.order as f32));
        }
    }
}

fn hit_data(camera: Entity, hit: &RayHit) -> HitData {
    HitData::new_with_extra(camera, hit.distance, Some(hit.position), Some(hit.normal), *hit)
}
