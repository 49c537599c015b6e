//! The index: one leaf per entity in an [`AabbTree`](crate::spatial::AabbTree) and in a
//! [`UniformGrid`](crate::spatial::UniformGrid), kept in step with the world.
//!
//! [`SpatialIndexPlugin`] keeps the [`SpatialIndex`] as of the last `PostUpdate`; [`SceneQuery`] asks it.
//!
//! # What is indexed
//!
//! Every entity with a `GlobalTransform` and bounds, unless it has [`NoSpatialIndex`] or is `Disabled` (other disabling
//! components are not followed, but what they disable is not found). Its bounds are
//! its `Aabb`, which Bevy computes for whatever it draws, with the box of its [`PickShape`]; an entity that has a mesh and
//! no `Aabb` (`NoFrustumCulling`, `NoAutoAabb`) gets the box of its mesh.
//!
//! # What a ray hits
//!
//! The entity's [`PickShape`], else its sprite (with the feature `sprite`), else the triangles of its [`SimplifiedMesh`], else of its `Mesh3d`, else of its `Mesh2d`.
//! An entity without any of these is found by its box ([`SceneQuery::overlap`]) and hit by no ray. Back faces are
//! passed through, except on sprites and `Mesh2d` and with [`RayCastBackfaces`].
//!
//! # Bad data
//!
//! An entity whose transform or bounds are NaN or infinite, or so large that its world box overflows, is left out, with
//! one warning that names it, and listed by [`SpatialIndex::refused`]; it comes back by itself when its data are good
//! again. A mesh without a surface gets one warning too, and [`MeshBvhs::status`] tells; its entities keep their boxes.
//! Skinned and morphed meshes are hit in their bind pose.

mod components;
mod hit;
mod mask;
mod mesh_slot;
mod meshes;
mod pick_shape;
mod scene_query;
mod settings;
mod spatial_index;
mod stats;
mod surface;
mod sync;

pub use crate::geometry::ray::triangle::Backfaces;
pub use components::{BoundedBy, NoSpatialIndex, RayCastBackfaces, SimplifiedMesh};
pub use hit::{HitTriangle, RayHit};
pub use meshes::{MeshBvhs, MeshStatus};
#[cfg(feature = "sprite")]
pub(crate) use pick_shape::DerivedShape;
pub use pick_shape::PickShape;
pub use scene_query::{MeshContact, SceneQuery, SweepHit};
pub use settings::{QueryVisibility, SceneQuerySettings, SpatialIndexSettings};
pub use spatial_index::{BrokenIndex, Refusal, SpatialIndex, SpatialIndexStats};
pub use stats::SyncStats;

use bevy::{
    app::{App, Plugin, PostUpdate},
    asset::{AssetEvent, AssetEventSystems, Assets},
    camera::visibility::VisibilitySystems,
    ecs::{
        message::Messages,
        schedule::{IntoScheduleConfigs, SystemSet, common_conditions::resource_exists},
    },
    mesh::Mesh,
    transform::TransformSystems,
};

/// When the index is brought up to date; all in `PostUpdate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub enum SpatialIndexSystems {
    /// The changes of this frame reach the index. After transforms, bounds and visibility have been propagated,
    /// before Bevy checks visibility.
    ///
    /// May be paused by a run condition, but not for more than two frames in which entities are despawned or lose
    /// components: Bevy forgets by then that they have, and the index does not learn of it until something else about
    /// them changes.
    Sync,
    /// The index is kept fast, after [`Sync`](Self::Sync). Changes no answer.
    Optimize,
}

/// Keeps the [`SpatialIndex`] and the [`MeshBvhs`] in step with the world.
///
/// Adding it again does nothing, so that every plugin that needs the index may add it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpatialIndexPlugin;

impl Plugin for SpatialIndexPlugin {
    fn build(&self, app: &mut App) {
        if app.world().contains_resource::<SpatialIndex>() {
            return;
        }
        app.insert_resource(SpatialIndex::new())
            .insert_resource(MeshBvhs::new())
            .init_resource::<SpatialIndexSettings>()
            .init_resource::<SyncStats>()
            .register_type::<BoundedBy>()
            .register_type::<NoSpatialIndex>()
            .register_type::<SpatialIndexSettings>()
            .register_type::<SpatialIndexStats>()
            .register_type::<SyncStats>()
            .configure_sets(
                PostUpdate,
                (SpatialIndexSystems::Sync, SpatialIndexSystems::Optimize)
                    .chain()
                    .after(TransformSystems::Propagate)
                    .after(AssetEventSystems)
                    .after(VisibilitySystems::CalculateBounds)
                    .after(VisibilitySystems::VisibilityPropagate)
                    .before(VisibilitySystems::CheckVisibility),
            )
            .add_systems(
                PostUpdate,
                (
                    sync::follow_mesh_assets
                        .run_if(resource_exists::<Assets<Mesh>>)
                        .run_if(resource_exists::<Messages<AssetEvent<Mesh>>>),
                    sync::follow_entities,
                )
                    .chain()
                    .in_set(SpatialIndexSystems::Sync),
            )
            .add_systems(PostUpdate, sync::optimize.in_set(SpatialIndexSystems::Optimize));
    }

    fn is_unique(&self) -> bool {
        false
    }
}
