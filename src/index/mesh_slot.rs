//! What is known of one mesh asset, and how rays are tested against it.

use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};

use bevy::{asset::AssetId, ecs::entity::Entity, math::Vec3A, mesh::Mesh};
use tracing::warn;

use super::{
    MeshSettings,
    meshes::{Loaded, MeshStatus, Role, Triangles, Volumes},
    triangles::TrianglesRef,
};
use crate::{
    geometry::{
        ray::Ray,
        surface::VolumeSurface,
        tolerance,
        volume::{AnyVolume, BoundingKind, Volume},
    },
    mesh::{MeshDeformer, MeshEdit, TriangleMesh},
};

/// What is known of one mesh asset.
#[derive(Debug, Default)]
pub(super) struct MeshSlot {
    content: Content,
    /// New whenever the vertices are.
    deformer: Option<Arc<MeshDeformer>>,
    /// How many indexed entities use the mesh.
    pub users: usize,
    /// The frame since which there are none.
    pub unused_since: u32,
    demand: Demand,
    /// Counts the hierarchies that there have been.
    generation: u32,
    volumes: Volumes,
    /// Whether the user has been told that the mesh is bad.
    warned: bool,
    /// The last frame in which a query asked for the triangles.
    last_use: AtomicU32,
    /// Whether a query has missed the hierarchy.
    is_missed: AtomicBool,
}

#[derive(Debug, Default)]
enum Content {
    /// The asset is not loaded, or gone.
    #[default]
    Missing,
    /// The asset has no surface.
    Unusable,
    Loaded(Loaded),
}

/// Whether a mesh is to have a hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Demand {
    /// No: rays hit but volumes of it.
    #[default]
    None,
    /// No: there was one that was not used for long, and memory was short.
    Evicted,
    Hierarchy,
}

impl MeshSlot {
    pub fn status(&self) -> MeshStatus {
        match &self.content {
            Content::Missing => MeshStatus::Missing,
            Content::Unusable => MeshStatus::Unusable,
            Content::Loaded(loaded) if loaded.has_hierarchy() => MeshStatus::Ready,
            Content::Loaded(loaded) if loaded.progress().is_some() => MeshStatus::Building,
            Content::Loaded(_) => MeshStatus::Dormant,
        }
    }

    /// New with each hierarchy that is taken over.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    pub fn progress(&self) -> Option<f32> {
        self.loaded().and_then(Loaded::progress)
    }

    pub fn memory(&self) -> usize {
        self.loaded().map_or(0, Loaded::memory)
    }

    pub fn triangles(&self) -> Option<&TriangleMesh> {
        self.loaded().map(|loaded| &*loaded.triangles)
    }

    pub fn shared_triangles(&self) -> Option<Triangles> {
        triangles_of(&self.content).cloned()
    }

    /// The kinds of volume that are kept.
    pub fn volumes(&self) -> impl Iterator<Item = BoundingKind> + '_ {
        self.volumes.kinds()
    }

    /// The volume that rays hit in place of the triangles, as far as it is built.
    pub fn surface(&self, kind: BoundingKind) -> Option<&VolumeSurface> {
        self.volumes.get(Role::Surface, kind)
    }

    /// What rays are tested against.
    pub fn tested(&self) -> Option<TrianglesRef<'_>> {
        self.loaded().map(|loaded| loaded.triangles.as_ref())
    }

    /// What poses the mesh, if it has joints or morph targets.
    pub fn deformer(&self) -> Option<&Arc<MeshDeformer>> {
        self.deformer.as_ref()
    }

    /// Takes over the triangles of `mesh`, and has a hierarchy fitted to them or built if there is a demand. `user` is
    /// named if they are bad.
    pub fn load(&mut self, id: AssetId<Mesh>, mesh: &Mesh, user: Option<Entity>, settings: MeshSettings) {
        let mut warn_once = |what: std::fmt::Arguments| {
            if !std::mem::replace(&mut self.warned, true) {
                let of_user = user.map_or(String::new(), |user| format!(" (used by {user})"));
                warn!("mesh {id}{of_user}: {what}");
            }
        };
        self.deformer = None;
        let edit = match TriangleMesh::from_mesh(mesh) {
            Ok(triangles) => {
                if triangles.left_out() > 0 {
                    warn_once(format_args!(
                        "rays cannot hit {} of its {} triangles: indices out of range, or positions NaN or infinite",
                        triangles.left_out(),
                        triangles.left_out() + triangles.len(),
                    ));
                }
                self.deformer = MeshDeformer::from_mesh(mesh, &triangles).map(Arc::new);
                if let Content::Loaded(loaded) = &mut self.content {
                    loaded.edit(triangles, settings)
                } else {
                    self.content = Content::Loaded(Loaded::new(triangles, settings.compact));
                    MeshEdit::Topology
                }
            }
            Err(why) => {
                warn_once(format_args!("rays cannot hit it: {why}"));
                self.content = Content::Unusable;
                MeshEdit::Topology
            }
        };
        self.build_on_demand();
        if edit > MeshEdit::Attributes {
            self.volumes.rebuild(triangles_of(&self.content));
        }
    }

    /// Forgets the triangles.
    pub fn unload(&mut self) {
        self.content = Content::Missing;
        self.deformer = None;
        self.volumes.rebuild(None);
    }

    /// Has a hierarchy built for a new user of the triangles. One that was evicted waits for a ray.
    pub fn demand_hierarchy(&mut self) {
        if self.demand == Demand::None {
            self.demand = Demand::Hierarchy;
            self.build_on_demand();
        }
    }

    /// Has the hierarchy built if a query has missed it; returns whether one has.
    pub fn build_if_missed(&mut self) -> bool {
        let is_missed = std::mem::take(self.is_missed.get_mut());
        if is_missed {
            self.demand = Demand::Hierarchy;
            self.build_on_demand();
        }
        is_missed
    }

    fn build_on_demand(&mut self) {
        if let (Content::Loaded(loaded), Demand::Hierarchy) = (&mut self.content, self.demand) {
            loaded.build();
        }
    }

    /// From now on hierarchies are built to take little memory, or not.
    pub fn set_compact(&mut self, compact: bool) {
        if let Content::Loaded(loaded) = &mut self.content {
            loaded.set_compact(compact);
        }
    }

    /// Drops the hierarchy until a query misses it.
    pub fn evict(&mut self) {
        if let Content::Loaded(loaded) = std::mem::take(&mut self.content) {
            self.content = Content::Loaded(loaded.without_hierarchy());
            self.demand = Demand::Evicted;
        }
    }

    /// Notes that a query asks for the triangles; returns whether it misses a hierarchy, which is to be built.
    #[inline]
    pub fn note_use(&self, frame: u32) -> bool {
        // Written once a frame, so that threads do not take the line from each other with every ray.
        if self.last_use.load(Relaxed) == frame {
            return false;
        }
        self.last_use.store(frame, Relaxed);
        let is_missed = self.status() == MeshStatus::Dormant;
        if is_missed {
            self.is_missed.store(true, Relaxed);
        }
        is_missed
    }

    /// How many frames ago a query last asked for the triangles, or the hierarchy was built.
    pub fn age(&self, frame: u32) -> u32 {
        frame.wrapping_sub(self.last_use.load(Relaxed))
    }

    /// Has a volume of the mesh built that is tested before its triangles are, or hit in their place.
    pub fn request_volume(&mut self, role: Role, kind: BoundingKind) {
        self.volumes.request(role, kind, triangles_of(&self.content));
    }

    /// Takes over what has been built.
    pub fn collect_built(&mut self, frame: u32) -> Built {
        let mut built = Built::default();
        if let Content::Loaded(loaded) = &mut self.content {
            built.hierarchy = loaded.collect_built();
        }
        if built.hierarchy {
            self.generation = self.generation.wrapping_add(1);
            *self.last_use.get_mut() = frame;
        }
        built.surface = self.volumes.collect_built(triangles_of(&self.content));
        built
    }

    pub fn is_building(&self) -> bool {
        self.progress().is_some() || self.volumes.is_building()
    }

    /// Whether the ray, in the space of the mesh, misses the volume of that kind, as far as it is built.
    pub fn misses(&self, bounded_by: BoundingKind, local: &Ray) -> bool {
        let Some(volume) = self.volumes.get(Role::Guard, bounded_by).map(VolumeSurface::volume) else {
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

    #[inline]
    fn loaded(&self) -> Option<&Loaded> {
        match &self.content {
            Content::Loaded(loaded) => Some(loaded),
            Content::Missing | Content::Unusable => None,
        }
    }
}

/// What has been built of one mesh.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Built {
    pub hierarchy: bool,
    /// A volume that rays hit.
    pub surface: bool,
}

/// Apart from the slot, of which something else may be borrowed.
fn triangles_of(content: &Content) -> Option<&Triangles> {
    match content {
        Content::Loaded(loaded) => Some(&loaded.triangles),
        Content::Missing | Content::Unusable => None,
    }
}
