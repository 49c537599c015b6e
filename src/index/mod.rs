//! The index: one leaf per entity in an [`AabbTree`](crate::spatial::AabbTree), and in a
//! [`UniformGrid`](crate::spatial::UniformGrid) while that is asked for, kept in step with the world.
//!
//! [`SpatialIndexPlugin`] keeps the [`SpatialIndex`] as of the last `PostUpdate`; [`SceneQuery`] asks it.
//!
//! # What is indexed
//!
//! Every entity with a `GlobalTransform` and bounds, unless it has [`NoSpatialIndex`] or is `Disabled` (other disabling
//! components are not followed, but what they disable is not found). Its bounds are
//! its `Aabb`, which Bevy computes for whatever it draws, with the box of its [`PickShape`], of its [`SimplifiedMesh`] or of
//! the volume that is hit in place of its mesh; an entity that has a mesh and no `Aabb` (`NoFrustumCulling`, `NoAutoAabb`)
//! gets the box of its mesh.
//!
//! # What a ray hits
//!
//! The entity's [`PickShape`], else its sprite (with the feature `sprite`), else its [`SimplifiedMesh`], else its
//! `Mesh3d`, else its `Mesh2d`: of these meshes the triangles, or by [`HitSurface`] a volume around them. An entity
//! without any of these is found by its box ([`SceneQuery::overlap`]) and hit by no ray. Back faces are passed through,
//! except on sprites and `Mesh2d` and with [`RayCastBackfaces`].
//!
//! So each entity pays for the precision that it needs; what is beside its mesh costs the same for a mesh of any size:
//!
//! | rays hit | by | what a ray costs | what is built and kept | hits have |
//! |---|---|---|---|---|
//! | the triangles | default | O(log n) | a hierarchy for each mesh | all there is |
//! | those of a simpler mesh | [`SimplifiedMesh`] | O(log n) of fewer | one for each simpler mesh | all there is |
//! | the convex hull | `HitSurface::Volume(Hull)` | O(corners of the hull) | a hull for each mesh | distance, normal |
//! | a sphere or a box | `HitSurface::Volume(…)` | least | a volume for each mesh | distance, normal |
//! | an analytic shape | [`PickShape`] | what the shape does | what you share | distance, normal, uv |
//!
//! A sphere or a box takes 25 to 40 ns; a hull as much more as it has planes: with some hundred corners it is hardly
//! cheaper than the triangles of a large mesh.
//!
//! [`BoundedBy`] is none of these: it says what a ray must enter before the triangles are tested, and changes no answer.
//! All meshes keep a copy of their triangles; [`MeshBvhs`] tells how hierarchies come, follow edits and go.
//!
//! # Bad data
//!
//! An entity whose transform or bounds are NaN or infinite, or so large that its world box overflows, is left out, with
//! one warning that names it, and listed by [`SpatialIndex::refused`]; it comes back by itself when its data are good
//! again. A mesh without a surface gets one warning too, and [`MeshBvhs::status`] tells; its entities keep their boxes.
//! A joint, a morph weight or vertex data for them that are NaN or infinite leave an entity out in the same way.
//!
//! # Skinned and morphed meshes
//!
//! They are found and hit as they are [posed](PosedMeshes), vertex for vertex where Bevy's renderer draws them: a skinned
//! mesh where its joints are, wherever its own entity is. Their world boxes are around the pose, whatever their `Aabb`. A
//! skin on a mesh without joint indices and weights, and joint indices and weights without a skin, are of no effect; a
//! `Mesh2d` is not posed, nor is what rays hit in place of the triangles: a [`PickShape`], or a volume ([`HitSurface`]), is
//! where the entity is. Which faces are back faces, the triangles decide in their pose.
//!
//! # Scenes and remote tools
//!
//! All components, settings, stats and events of this crate are reflected and registered by their plugins, so that scene
//! files and Bevy's remote protocol carry them, but for [`PickShape`], which may be code of yours, and for what is made of
//! the rest in every frame: [`SpatialIndex`], [`MeshBvhs`] and their like. Each of those says so.

mod components;
mod hit;
pub(crate) mod mask;
mod mesh_slot;
mod meshes;
mod pick_shape;
mod placement;
mod pose;
mod scene_query;
mod settings;
#[cfg(feature = "gizmos")]
mod shown;
mod spatial_index;
mod stats;
mod surface;
mod sync;
pub(crate) mod ticks;
mod trace;
mod triangles;
mod views;

pub use crate::geometry::ray::triangle::Backfaces;
pub use components::{BoundedBy, DetailLevel, HitSurface, NoSpatialIndex, RayCastBackfaces, SimplifiedMesh};
pub use hit::{HitTriangle, RayHit};
pub use meshes::{MeshBvhs, MeshStatus};
#[cfg(feature = "sprite")]
pub(crate) use pick_shape::DerivedShape;
pub use pick_shape::PickShape;
pub use pose::{PosedMeshes, PosingStats};
pub(crate) use scene_query::{Candidate, CandidateSurface, CandidateTriangles};
pub use scene_query::{MeshContact, SceneQuery, SweepHit};
pub use settings::{MeshSettings, QueryVisibility, SceneQuerySettings, SpatialIndexSettings};
pub(crate) use spatial_index::Key;
pub use spatial_index::{BrokenIndex, Refusal, SpatialIndex, SpatialIndexStats};
pub use stats::SyncStats;
pub(crate) use sync::MeshSwaps;
pub use trace::{EntityTest, EntityTrace, RayTrace};
use views::CameraViews;
pub(crate) use views::clip_from_view;

use bevy::{
    app::{App, Plugin, PostUpdate},
    asset::{AssetEvent, AssetEventSystems, Assets},
    camera::{CameraUpdateSystems, visibility::VisibilitySystems},
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
    /// May be paused by a run condition. What has happened meanwhile is found out afterwards; if something was removed
    /// so long ago that Bevy has forgotten of it, by looking at every entity once.
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
            .init_resource::<PosedMeshes>()
            .init_resource::<CameraViews>()
            .init_resource::<SpatialIndexSettings>()
            .init_resource::<SyncStats>()
            .init_resource::<sync::Rebuilding>()
            .register_type::<BoundedBy>()
            .register_type::<DetailLevel>()
            .register_type::<HitSurface>()
            .register_type::<MeshStatus>()
            .register_type::<NoSpatialIndex>()
            .register_type::<QueryVisibility>()
            .register_type::<RayCastBackfaces>()
            .register_type::<SimplifiedMesh>()
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
            .add_systems(
                PostUpdate,
                views::follow_cameras
                    .after(CameraUpdateSystems)
                    .in_set(SpatialIndexSystems::Sync),
            )
            .add_systems(
                PostUpdate,
                sync::optimize
                    .run_if(sync::may_be_degraded)
                    .in_set(SpatialIndexSystems::Optimize),
            );
    }

    fn is_unique(&self) -> bool {
        false
    }
}
