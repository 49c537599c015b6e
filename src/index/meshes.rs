//! One bounding volume hierarchy per mesh asset, shared by all entities that use it.

use std::sync::Arc;

use bevy::{
    asset::{AssetId, Assets},
    ecs::{entity::Entity, resource::Resource},
    math::{Vec3A, bounding::Aabb3d},
    mesh::Mesh,
    platform::collections::{HashMap, HashSet},
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};
use tracing::warn;

use super::spatial_index::MeshSurface;
use crate::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBvh, TriangleHit, TriangleMesh},
};

/// The bounding volume hierarchies of all meshes that indexed entities use or have used, by asset.
///
/// They are built on the [`AsyncComputeTaskPool`], rebuilt when the asset changes, and dropped with it; one that no
/// entity uses any more is dropped when the asset changes. While one is being built, rays test every triangle of the
/// mesh instead: the answers are the same, only slower.
#[derive(Resource, Debug)]
pub struct MeshBvhs {
    slots: HashMap<AssetId<Mesh>, Slot>,
    building: HashSet<AssetId<Mesh>>,
    /// The meshes that were loaded, modified or unloaded since they were last asked for.
    changed: Vec<AssetId<Mesh>>,
}

#[derive(Debug)]
struct Slot {
    shape: Shape,
    /// How many indexed entities use the mesh.
    users: usize,
    /// Whether the user has been told that the mesh is bad.
    warned: bool,
}

#[derive(Debug)]
enum Shape {
    /// The asset is not loaded, or gone.
    Missing,
    /// The asset has no surface.
    Unusable,
    Building {
        mesh: Arc<TriangleMesh>,
        task: Task<MeshBvh>,
    },
    Ready(MeshBvh),
}

/// How far the hierarchy of a mesh has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MeshStatus {
    /// The asset is not loaded, or gone. Rays hit nothing.
    Missing,
    /// The asset has no surface, as a warning has said. Rays hit nothing.
    Unusable,
    /// Rays test all triangles.
    Building,
    /// Rays use the hierarchy.
    Ready,
}

impl MeshBvhs {
    pub(super) fn new() -> Self {
        Self {
            slots: HashMap::default(),
            building: HashSet::default(),
            changed: Vec::new(),
        }
    }

    /// How far the hierarchy of a mesh has come, or `None` if no indexed entity has used it.
    pub fn status(&self, id: impl Into<AssetId<Mesh>>) -> Option<MeshStatus> {
        self.slots.get(&id.into()).map(|slot| match slot.shape {
            Shape::Missing => MeshStatus::Missing,
            Shape::Unusable => MeshStatus::Unusable,
            Shape::Building { .. } => MeshStatus::Building,
            Shape::Ready(_) => MeshStatus::Ready,
        })
    }

    /// How many hierarchies are being built.
    pub fn building(&self) -> usize {
        self.building.len()
    }

    /// The triangles of a mesh, if an indexed entity uses it and it is usable.
    pub fn triangles(&self, id: impl Into<AssetId<Mesh>>) -> Option<&TriangleMesh> {
        self.slots.get(&id.into()).and_then(|slot| slot.shape.mesh())
    }

    /// The local box of a mesh that an entity uses, if it is loaded and usable.
    pub(super) fn aabb(&self, id: AssetId<Mesh>) -> Option<Aabb3d> {
        self.triangles(id).map(TriangleMesh::aabb)
    }

    /// Counts `entity` among the users of a mesh, and begins to build it for the first one.
    pub(super) fn acquire(&mut self, id: AssetId<Mesh>, entity: Entity, assets: Option<&Assets<Mesh>>) {
        let slot = self.slots.entry(id).or_insert_with(|| Slot {
            shape: Shape::Missing,
            users: 0,
            warned: false,
        });
        slot.users += 1;
        if let (Shape::Missing, Some(mesh)) = (&slot.shape, assets.and_then(|a| a.get(id))) {
            slot.load(id, mesh, Some(entity));
            self.note_building(id);
        }
    }

    /// Takes one user off a mesh.
    pub(super) fn release(&mut self, id: AssetId<Mesh>) {
        if let Some(slot) = self.slots.get_mut(&id) {
            slot.users -= 1;
            if slot.users == 0 && matches!(slot.shape, Shape::Missing) {
                self.slots.remove(&id);
            }
        }
    }

    /// Follows a mesh asset that was added, modified or removed.
    pub(super) fn follow(&mut self, id: AssetId<Mesh>, assets: &Assets<Mesh>) {
        self.changed.push(id);
        self.building.remove(&id);
        let Some(slot) = self.slots.get_mut(&id) else {
            return;
        };
        match assets.get(id) {
            _ if slot.users == 0 => {
                self.slots.remove(&id);
            }
            Some(mesh) => {
                slot.load(id, mesh, None);
                self.note_building(id);
            }
            None => slot.shape = Shape::Missing,
        }
    }

    /// Whether there is anything for [`drain_changed`](Self::drain_changed) to give.
    pub(super) fn has_changed(&self) -> bool {
        !self.changed.is_empty()
    }

    /// The meshes that were loaded, modified or unloaded since this was last called.
    pub(super) fn drain_changed(&mut self) -> impl Iterator<Item = AssetId<Mesh>> + '_ {
        self.changed.drain(..)
    }

    /// Takes over the hierarchies that have been built.
    pub(super) fn collect_built(&mut self) {
        let slots = &mut self.slots;
        self.building.retain(|id| {
            let Some(slot) = slots.get_mut(id) else {
                return false;
            };
            let Shape::Building { task, .. } = &mut slot.shape else {
                return false;
            };
            match check_ready(task) {
                Some(bvh) => {
                    slot.shape = Shape::Ready(bvh);
                    false
                }
                None => true,
            }
        });
    }

    /// The nearest hit on a mesh in the world, with the parameter of the ray.
    pub(super) fn closest_hit(&self, surface: &MeshSurface, ray: &Ray, backfaces: Backfaces) -> Option<TriangleHit> {
        let shape = &self.slots.get(&surface.mesh)?.shape;
        match (surface.ray_to_local(ray), shape) {
            (_, Shape::Missing | Shape::Unusable) => None,
            (Some(local), Shape::Building { mesh, .. }) => mesh.closest_hit(&local, backfaces),
            (Some(local), Shape::Ready(bvh)) => bvh.closest_hit(&local, backfaces),
            // The transform is flat, or so nearly flat that the ray overflows: take the triangles to the world.
            (None, shape) => {
                let place = |corner: Vec3A| surface.world_from_local.transform_point3a(corner);
                shape.mesh()?.closest_hit_of(ray, backfaces, place)
            }
        }
    }

    /// Whether the ray hits a mesh in the world anywhere.
    pub(super) fn any_hit(&self, surface: &MeshSurface, ray: &Ray, backfaces: Backfaces) -> bool {
        match (self.slots.get(&surface.mesh), surface.ray_to_local(ray)) {
            (
                Some(Slot {
                    shape: Shape::Ready(bvh),
                    ..
                }),
                Some(local),
            ) => bvh.any_hit(&local, backfaces),
            _ => self.closest_hit(surface, ray, backfaces).is_some(),
        }
    }

    fn note_building(&mut self, id: AssetId<Mesh>) {
        if matches!(self.slots[&id].shape, Shape::Building { .. }) {
            self.building.insert(id);
        }
    }
}

impl Slot {
    /// Takes over the triangles of `mesh`, and sends them to be built. `user` is named if they are bad.
    fn load(&mut self, id: AssetId<Mesh>, mesh: &Mesh, user: Option<Entity>) {
        let mut warn_once = |what: std::fmt::Arguments| {
            if !std::mem::replace(&mut self.warned, true) {
                let of_user = user.map_or(String::new(), |user| format!(" (used by {user})"));
                warn!("mesh {id}{of_user}: {what}");
            }
        };
        self.shape = match TriangleMesh::from_mesh(mesh) {
            Ok(mesh) => {
                if mesh.left_out() > 0 {
                    warn_once(format_args!(
                        "rays cannot hit {} of its {} triangles: indices out of range, or positions NaN or infinite",
                        mesh.left_out(),
                        mesh.left_out() + mesh.len(),
                    ));
                }
                Shape::build(mesh)
            }
            Err(why) => {
                warn_once(format_args!("rays cannot hit it: {why}"));
                Shape::Unusable
            }
        };
    }
}

impl Shape {
    fn build(mesh: TriangleMesh) -> Self {
        let mesh = Arc::new(mesh);
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn({
            let mesh = mesh.clone();
            async move { MeshBvh::build(&mesh) }
        });
        Self::Building { mesh, task }
    }

    fn mesh(&self) -> Option<&TriangleMesh> {
        match self {
            Self::Missing | Self::Unusable => None,
            Self::Building { mesh, .. } => Some(mesh),
            Self::Ready(bvh) => Some(bvh.mesh()),
        }
    }
}
