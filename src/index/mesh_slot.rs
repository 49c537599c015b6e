//! What is known of one mesh asset, and how rays are tested against it.

use std::sync::Arc;

use bevy::{
    asset::AssetId,
    ecs::entity::Entity,
    math::Vec3A,
    mesh::Mesh,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};
use smallvec::SmallVec;
use tracing::warn;

use super::{meshes::MeshStatus, surface::PlacedSurface, triangles::Triangles};
use crate::{
    geometry::{
        ray::{Ray, triangle::Backfaces},
        tolerance,
        volume::{AnyVolume, BoundingKind, Volume},
    },
    mesh::{MeshBvh, MeshDeformer, TriangleHit, TriangleMesh},
};

/// What is known of one mesh asset.
#[derive(Debug, Default)]
pub(super) struct MeshSlot {
    content: Content,
    /// New whenever the vertices are.
    deformer: Option<Arc<MeshDeformer>>,
    /// How many indexed entities use the mesh.
    pub users: usize,
    /// Whether the user has been told that the mesh is bad.
    warned: bool,
    /// The bounding volumes that entities have asked for, one of each kind.
    volumes: SmallVec<[(BoundingKind, VolumeState); 1]>,
}

#[derive(Debug, Default)]
enum Content {
    /// The asset is not loaded, or gone.
    #[default]
    Missing,
    /// The asset has no surface.
    Unusable,
    Building {
        mesh: Arc<TriangleMesh>,
        task: Task<MeshBvh>,
    },
    Ready(Arc<MeshBvh>),
}

#[derive(Debug)]
enum VolumeState {
    /// There are no triangles to bound.
    Waiting,
    Building(Task<Option<AnyVolume>>),
    /// `None` if the volume would overflow.
    Ready(Option<AnyVolume>),
}

impl MeshSlot {
    pub fn status(&self) -> MeshStatus {
        match self.content {
            Content::Missing => MeshStatus::Missing,
            Content::Unusable => MeshStatus::Unusable,
            Content::Building { .. } => MeshStatus::Building,
            Content::Ready(_) => MeshStatus::Ready,
        }
    }

    /// What rays are tested against.
    pub fn surface(&self) -> Option<Triangles<'_>> {
        match &self.content {
            Content::Missing | Content::Unusable => None,
            Content::Building { mesh, .. } => Some(Triangles::Listed(mesh)),
            Content::Ready(bvh) => Some(Triangles::Hierarchy(bvh)),
        }
    }

    pub fn triangles(&self) -> Option<&TriangleMesh> {
        self.surface().map(Triangles::mesh)
    }

    /// What poses the mesh, if it has joints or morph targets.
    pub fn deformer(&self) -> Option<&Arc<MeshDeformer>> {
        self.deformer.as_ref()
    }

    /// The kinds of volume that are kept.
    pub fn volumes(&self) -> impl Iterator<Item = BoundingKind> + '_ {
        self.volumes.iter().map(|(kind, _)| *kind)
    }

    /// Takes over the triangles of `mesh`, and sends them to be built. `user` is named if they are bad.
    pub fn load(&mut self, id: AssetId<Mesh>, mesh: &Mesh, user: Option<Entity>) {
        let mut warn_once = |what: std::fmt::Arguments| {
            if !std::mem::replace(&mut self.warned, true) {
                let of_user = user.map_or(String::new(), |user| format!(" (used by {user})"));
                warn!("mesh {id}{of_user}: {what}");
            }
        };
        self.deformer = None;
        self.content = match TriangleMesh::from_mesh(mesh) {
            Ok(triangles) => {
                if triangles.left_out() > 0 {
                    warn_once(format_args!(
                        "rays cannot hit {} of its {} triangles: indices out of range, or positions NaN or infinite",
                        triangles.left_out(),
                        triangles.left_out() + triangles.len(),
                    ));
                }
                self.deformer = MeshDeformer::from_mesh(mesh, &triangles).map(Arc::new);
                Content::build(triangles)
            }
            Err(why) => {
                warn_once(format_args!("rays cannot hit it: {why}"));
                Content::Unusable
            }
        };
        for (kind, volume) in &mut self.volumes {
            *volume = self.content.build_volume(*kind);
        }
    }

    /// Forgets the triangles.
    pub fn unload(&mut self) {
        self.content = Content::Missing;
        self.deformer = None;
        for (_, volume) in &mut self.volumes {
            *volume = VolumeState::Waiting;
        }
    }

    /// Has rays tested against a volume of the mesh before its triangles are, as soon as the volume is built.
    pub fn bound_by(&mut self, kind: BoundingKind) {
        if self.volumes.iter().all(|(known, _)| *known != kind) {
            self.volumes.push((kind, self.content.build_volume(kind)));
        }
    }

    /// Takes over what has been built; returns whether anything is still being built.
    pub fn collect_built(&mut self) -> bool {
        if let Content::Building { task, .. } = &mut self.content
            && let Some(bvh) = check_ready(task)
        {
            self.content = Content::Ready(Arc::new(bvh));
        }
        for (_, volume) in &mut self.volumes {
            if let VolumeState::Building(task) = volume
                && let Some(built) = check_ready(task)
            {
                *volume = VolumeState::Ready(built);
            }
        }
        self.is_building()
    }

    pub fn is_building(&self) -> bool {
        let mut volumes = self.volumes.iter();
        matches!(self.content, Content::Building { .. })
            || volumes.any(|(_, volume)| matches!(volume, VolumeState::Building(_)))
    }

    /// The nearest hit on the mesh at its place in the world, with the parameter of the ray.
    pub fn closest_hit(
        &self,
        placed: &PlacedSurface,
        bounded_by: BoundingKind,
        ray: &Ray,
        backfaces: Backfaces,
    ) -> Option<TriangleHit> {
        let misses = |local: &Ray| self.misses(bounded_by, local);
        self.surface()?.closest_hit(placed, ray, backfaces, misses)
    }

    /// Whether the ray hits the mesh at its place in the world anywhere.
    pub fn any_hit(&self, placed: &PlacedSurface, bounded_by: BoundingKind, ray: &Ray, backfaces: Backfaces) -> bool {
        let misses = |local: &Ray| self.misses(bounded_by, local);
        self.surface()
            .is_some_and(|surface| surface.any_hit(placed, ray, backfaces, misses))
    }

    /// Whether the ray, in the space of the mesh, misses the volume of that kind, as far as it is built.
    fn misses(&self, bounded_by: BoundingKind, local: &Ray) -> bool {
        let mut volumes = self.volumes.iter();
        let volume = volumes.find(|(kind, _)| *kind == bounded_by);
        let Some((_, VolumeState::Ready(Some(volume)))) = volume else {
            return false;
        };
        // Triangles are tested in single precision, and hit by rays that pass them by so much. The tests of the other
        // volumes, in single precision too, allow for it themselves.
        let slack = |center: Vec3A, size: f32| tolerance::SLAB * ((local.origin() - center).abs().element_sum() + size);
        let entered = match volume {
            AnyVolume::Sphere(sphere) => {
                let grown = sphere.grown(slack(sphere.center, sphere.radius()));
                grown.ray_intersection_at(local)
            }
            AnyVolume::Obb(obb) => {
                let grown = obb.grown(slack(obb.center(), obb.half_size().element_sum()));
                grown.ray_intersection_at(local)
            }
            AnyVolume::Aabb(_) | AnyVolume::Hull(_) => volume.ray_intersection_at(local),
        };
        entered.is_none()
    }
}

impl Content {
    fn build(mesh: TriangleMesh) -> Self {
        let mesh = Arc::new(mesh);
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn({
            let mesh = mesh.clone();
            async move { MeshBvh::build(&mesh) }
        });
        Self::Building { mesh, task }
    }

    fn build_volume(&self, kind: BoundingKind) -> VolumeState {
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
        match self {
            Self::Missing | Self::Unusable => VolumeState::Waiting,
            Self::Building { mesh, .. } => {
                let mesh = mesh.clone();
                VolumeState::Building(pool.spawn(async move { mesh.bounding_volume(kind) }))
            }
            Self::Ready(bvh) => {
                let bvh = bvh.clone();
                VolumeState::Building(pool.spawn(async move { bvh.mesh().bounding_volume(kind) }))
            }
        }
    }
}
