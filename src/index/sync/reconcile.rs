//! Making the index agree with one entity, whatever has happened to it.

use bevy::{
    asset::{AssetId, Assets},
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, RenderLayers},
    },
    ecs::{
        entity::{Entity, EntityHashMap, EntityHashSet},
        name::NameOrEntity,
        query::{Has, QueryData},
    },
    math::bounding::Aabb3d,
    mesh::{Mesh, Mesh2d, Mesh3d, morph::MeshMorphWeights, skinning::SkinnedMesh},
    platform::collections::HashMap,
    transform::components::GlobalTransform,
};
use tracing::warn;

use crate::{
    geometry::{
        aabb::{Aabb3dExt, union},
        ray::triangle::Backfaces,
        volume::Volume,
    },
    index::{
        BoundedBy, DetailLevel, HitSurface, MeshBvhs, NoSpatialIndex, PickShape, PosedMeshes, RayCastBackfaces,
        Refusal, SimplifiedMesh, SpatialIndex,
        meshes::Role,
        pick_shape::DerivedShape,
        pose::{PoseId, PoseInputs},
        spatial_index::{Contents, Entry, Moves},
        surface::{PlacedSurface, Shape},
    },
};

/// Everything that the index reads of an entity.
#[derive(QueryData)]
pub(in crate::index) struct Indexed {
    name: NameOrEntity,
    transform: &'static GlobalTransform,
    aabb: Option<&'static Aabb>,
    mesh_2d: Option<&'static Mesh2d>,
    mesh_3d: Option<&'static Mesh3d>,
    simplified_mesh: Option<&'static SimplifiedMesh>,
    shape: Option<&'static PickShape>,
    derived: Option<&'static DerivedShape>,
    bounded_by: Option<&'static BoundedBy>,
    hit_surface: Option<&'static HitSurface>,
    visibility: Option<&'static InheritedVisibility>,
    layers: Option<&'static RenderLayers>,
    level: Option<&'static DetailLevel>,
    has_backfaces: Has<RayCastBackfaces>,
    has_skin: Has<SkinnedMesh>,
    has_morph_weights: Has<MeshMorphWeights>,
    is_left_out: Has<NoSpatialIndex>,
}

impl IndexedItem<'_, '_> {
    pub fn entity(&self) -> Entity {
        self.name.entity
    }
}

/// The entities whose box comes from a mesh asset rather than from an `Aabb`, alone or posed, or would if it were loaded.
#[derive(Default)]
pub(super) struct BoundedByMesh {
    entities: HashMap<AssetId<Mesh>, EntityHashSet>,
    mesh_of: EntityHashMap<AssetId<Mesh>>,
}

impl BoundedByMesh {
    fn insert(&mut self, entity: Entity, mesh: AssetId<Mesh>) {
        self.entities.entry(mesh).or_default().insert(entity);
        self.mesh_of.insert(entity, mesh);
    }

    fn remove(&mut self, entity: Entity) {
        // Mostly there is nothing to look up.
        if self.mesh_of.is_empty() {
            return;
        }
        if let Some(mesh) = self.mesh_of.remove(&entity)
            && let Some(entities) = self.entities.get_mut(&mesh)
        {
            entities.remove(&entity);
            if entities.is_empty() {
                self.entities.remove(&mesh);
            }
        }
    }

    pub fn entities(&self) -> impl Iterator<Item = Entity> + '_ {
        self.mesh_of.keys().copied()
    }

    pub fn of(&self, mesh: AssetId<Mesh>) -> impl Iterator<Item = Entity> + '_ {
        self.entities.get(&mesh).into_iter().flatten().copied()
    }
}

/// Makes the index agree with one entity at a time.
pub(super) struct Reconciler<'a> {
    pub assets: Option<&'a Assets<Mesh>>,
    pub meshes: &'a mut MeshBvhs,
    pub poses: &'a mut PosedMeshes,
    pub inputs: &'a PoseInputs<'a, 'a>,
    pub index: &'a mut SpatialIndex,
    pub bounded_by_mesh: &'a mut BoundedByMesh,
    /// Boxes to be stored together.
    pub moves: &'a mut Moves,
    /// Entities to be inserted together.
    pub new: &'a mut Vec<(Entity, Contents)>,
}

impl Reconciler<'_> {
    /// Makes the index agree with `entity`, which is gone, disabled or without a place in the world if there is no
    /// `item`.
    pub fn reconcile(&mut self, entity: Entity, item: Option<IndexedItem>) {
        self.bounded_by_mesh.remove(entity);
        let old_surface = self.index.surface_of(entity);
        let old_mesh = old_surface.and_then(PlacedSurface::mesh);
        let hit_triangles = old_surface.is_some_and(|old| matches!(old.shape, Shape::Mesh(..)));
        let item = item.filter(|item| !item.is_left_out);
        let shape = item.as_ref().and_then(pick_shape);
        let mesh = shape.as_ref().and_then(Shape::mesh);
        let acquired = mesh.filter(|_| mesh != old_mesh);
        if let Some(mesh) = acquired {
            self.meshes.acquire(mesh, entity, self.assets);
        }
        match shape {
            Some(Shape::Mesh(mesh, kind)) => {
                if acquired.is_some() || !hit_triangles {
                    self.meshes.demand_hierarchy(mesh);
                }
                self.meshes.request_volume(mesh, Role::Guard, kind);
            }
            Some(Shape::Volume(mesh, kind)) => self.meshes.request_volume(mesh, Role::Surface, kind),
            Some(Shape::Analytic(_)) | None => {}
        }

        let pose = item.as_ref().and_then(|item| self.pose(entity, item, shape.as_ref()));
        if pose.is_none() {
            self.poses.remove(entity);
        }
        let state = item
            .as_ref()
            .map_or(Ok(None), |item| self.state(entity, item, shape, pose));
        let refusal = state.as_ref().err().copied();
        if self.index.set_refused(entity, refusal)
            && let (Some(why), Some(item)) = (refusal, &item)
        {
            warn!("{} ({entity}) is left out of the spatial index: {why}", item.name);
        }

        let stays = match state.ok().flatten() {
            Some(contents) => {
                if self.index.contains(entity) {
                    self.index.update(entity, contents, self.moves);
                } else {
                    self.evict_namesake(entity);
                    self.new.push((entity, contents));
                }
                true
            }
            None => {
                self.index.remove(entity);
                false
            }
        };

        let kept = mesh.filter(|_| stays);
        for mesh in old_mesh.into_iter().chain(acquired) {
            if Some(mesh) != kept {
                self.meshes.release(mesh);
            }
        }
    }

    /// Takes out an entity of an earlier generation, of whose end nothing has been heard yet.
    fn evict_namesake(&mut self, entity: Entity) {
        if let Some(namesake) = self.index.namesake(entity) {
            self.reconcile(namesake, None);
        }
    }

    /// What the index should hold for an entity: `None` if the entity has no bounds, or none yet.
    fn state(
        &mut self,
        entity: Entity,
        item: &IndexedItem,
        shape: Option<Shape>,
        pose: Option<PoseId>,
    ) -> Result<Option<Contents>, Refusal> {
        if item.aabb.is_none() && shape.is_none() {
            return Ok(None);
        }
        let world_from_local = item.transform.affine();
        if !world_from_local.is_finite() {
            return Err(Refusal::Transform);
        }
        let (local, world, world_from_local) = match pose.and_then(|pose| self.poses.get(pose)) {
            Some(posed) => {
                let world = posed.world_aabb(&world_from_local)?;
                (world, world, posed.world_from_posed(world_from_local))
            }
            None => {
                let Some(local) = self.local_bounds(entity, item, shape.as_ref())? else {
                    return Ok(None);
                };
                let world = local.transformed_by_affine(&world_from_local);
                if !world.is_sound() {
                    return Err(Refusal::WorldBounds);
                }
                (local, world, world_from_local)
            }
        };
        let backfaces = if item.has_backfaces || item.mesh_2d.is_some() || item.derived.is_some() {
            Backfaces::Include
        } else {
            Backfaces::Cull
        };
        Ok(Some(Contents {
            local,
            world,
            surface: shape.map(|shape| {
                let mut surface = PlacedSurface::new(shape, backfaces, world_from_local);
                surface.pose = pose;
                surface
            }),
            entry: Entry {
                layers: item.layers.cloned().unwrap_or_default(),
                visible: item.visibility.is_none_or(|visibility| visibility.get()),
                level: item.level.copied(),
            },
        }))
    }

    /// How an entity is posed, if what rays hit is a mesh that it poses.
    fn pose(&mut self, entity: Entity, item: &IndexedItem, shape: Option<&Shape>) -> Option<PoseId> {
        if !item.has_skin && !item.has_morph_weights {
            return None;
        }
        let &Shape::Mesh(mesh, _) = shape? else {
            return None;
        };
        // It may be posed as soon as it is loaded.
        self.bounded_by_mesh.insert(entity, mesh);
        let is_drawn_posed = item.mesh_3d.is_some() || item.simplified_mesh.is_some();
        let deformer = self.meshes.slot(mesh)?.deformer().filter(|_| is_drawn_posed)?;
        self.poses.adopt(entity, mesh, deformer, self.inputs)
    }

    /// The local box of an entity: its `Aabb`, with the box of a simplified mesh, a volume or a `PickShape`, which may stick out;
    /// without an `Aabb`, the box of what rays hit.
    fn local_bounds(
        &mut self,
        entity: Entity,
        item: &IndexedItem,
        shape: Option<&Shape>,
    ) -> Result<Option<Aabb3d>, Refusal> {
        let own = item.aabb.map(|aabb| Aabb3d {
            min: aabb.center - aabb.half_extents,
            max: aabb.center + aabb.half_extents,
        });
        if own.is_some_and(|own| !own.is_sound()) {
            return Err(Refusal::Bounds);
        }
        let asks_mesh = own.is_none() || item.simplified_mesh.is_some();
        let of_shape = match shape {
            Some(&Shape::Mesh(mesh, _)) if asks_mesh => {
                self.bounded_by_mesh.insert(entity, mesh);
                self.meshes.aabb(mesh)
            }
            Some(&Shape::Volume(mesh, kind)) => {
                self.bounded_by_mesh.insert(entity, mesh);
                self.meshes.aabb_with_volume(mesh, kind)
            }
            Some(Shape::Analytic(shape)) => {
                let sound = shape.surface().aabb().filter(Aabb3dExt::is_sound);
                Some(sound.ok_or(Refusal::Shape)?)
            }
            _ => None,
        };
        Ok(match (own, of_shape) {
            (Some(own), Some(of_shape)) => Some(union(&own, &of_shape)),
            (own, of_shape) => own.or(of_shape),
        })
    }
}

/// What rays hit on an entity.
fn pick_shape(item: &IndexedItem) -> Option<Shape> {
    if let Some(shape) = item.shape.or(item.derived.map(|derived| &derived.0)) {
        return Some(Shape::Analytic(shape.clone()));
    }
    let simplified = item.simplified_mesh.map(|mesh| mesh.0.id());
    let mesh = simplified
        .or(item.mesh_3d.map(|mesh| mesh.0.id()))
        .or(item.mesh_2d.map(|mesh| mesh.0.id()))?;
    Some(match item.hit_surface.copied().unwrap_or_default() {
        HitSurface::Mesh => Shape::Mesh(mesh, item.bounded_by.copied().unwrap_or_default().0),
        HitSurface::Volume(kind) => Shape::Volume(mesh, kind),
    })
}
