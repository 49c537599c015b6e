//! The systems that keep the index in step with the world.
//!
//! Whatever happens to an entity, it ends in [`Reconciler::reconcile`], which looks at the entity as it is now and
//! makes the index agree. So every way in has its way out, and no order of changes within a frame matters.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, RenderLayers},
    },
    ecs::{
        change_detection::{Res, ResMut},
        entity::{Entity, EntityHashMap, EntityHashSet},
        entity_disabling::Disabled,
        lifecycle::RemovedComponents,
        message::MessageReader,
        name::NameOrEntity,
        query::{Added, Changed, Has, Or, QueryData, With},
        system::{Local, Query, SystemParam},
    },
    math::{Affine3A, DAffine3, bounding::Aabb3d},
    mesh::{Mesh, Mesh2d, Mesh3d},
    platform::collections::{HashMap, HashSet},
    transform::components::GlobalTransform,
};
use tracing::warn;

use super::{
    BoundedBy, MeshBvhs, NoSpatialIndex, PickShape, RayCastBackfaces, Refusal, SimplifiedMesh, SpatialIndex,
    spatial_index::{Contents, PlacedSurface, Shape},
};
use crate::geometry::{
    aabb::{Aabb3dExt, union},
    ray::triangle::Backfaces,
    volume::Volume,
};

/// Follows mesh assets that are loaded, modified and removed, and takes over the hierarchies that have been built.
pub(super) fn follow_mesh_assets(
    mut events: MessageReader<AssetEvent<Mesh>>,
    assets: Res<Assets<Mesh>>,
    mut meshes: ResMut<MeshBvhs>,
) {
    // An asset that has changed several times is looked at once, as it is now.
    let changed: HashSet<AssetId<Mesh>> = events
        .read()
        .filter_map(|event| match *event {
            AssetEvent::Added { id }
            | AssetEvent::Modified { id }
            | AssetEvent::Removed { id }
            | AssetEvent::Unused { id } => Some(id),
            AssetEvent::LoadedWithDependencies { .. } => None,
        })
        .collect();
    for id in changed {
        meshes.follow(id, &assets);
    }
    if meshes.building() > 0 {
        meshes.collect_built();
    }
}

/// Everything that the index reads of an entity.
#[derive(QueryData)]
pub(super) struct Indexed {
    name: NameOrEntity,
    transform: &'static GlobalTransform,
    aabb: Option<&'static Aabb>,
    mesh_2d: Option<&'static Mesh2d>,
    mesh_3d: Option<&'static Mesh3d>,
    simplified_mesh: Option<&'static SimplifiedMesh>,
    shape: Option<&'static PickShape>,
    bounded_by: Option<&'static BoundedBy>,
    visibility: Option<&'static InheritedVisibility>,
    layers: Option<&'static RenderLayers>,
    has_backfaces: Has<RayCastBackfaces>,
    is_left_out: Has<NoSpatialIndex>,
}

/// Any of what the index reads of an entity has changed.
type AnyChanged = Or<(
    Changed<GlobalTransform>,
    Changed<Aabb>,
    Changed<Mesh2d>,
    Changed<Mesh3d>,
    Changed<SimplifiedMesh>,
    Changed<PickShape>,
    Changed<BoundedBy>,
    Changed<InheritedVisibility>,
    Changed<RenderLayers>,
    Changed<RayCastBackfaces>,
    Added<NoSpatialIndex>,
)>;

/// An entity could be in the index.
type HasBounds = Or<(
    With<Aabb>,
    With<Mesh2d>,
    With<Mesh3d>,
    With<SimplifiedMesh>,
    With<PickShape>,
)>;

/// What the index reads of an entity was taken away, or the whole entity.
#[derive(SystemParam)]
pub(super) struct Removed<'w, 's> {
    transform: RemovedComponents<'w, 's, GlobalTransform>,
    aabb: RemovedComponents<'w, 's, Aabb>,
    mesh_2d: RemovedComponents<'w, 's, Mesh2d>,
    mesh_3d: RemovedComponents<'w, 's, Mesh3d>,
    simplified_mesh: RemovedComponents<'w, 's, SimplifiedMesh>,
    shape: RemovedComponents<'w, 's, PickShape>,
    bounded_by: RemovedComponents<'w, 's, BoundedBy>,
    visibility: RemovedComponents<'w, 's, InheritedVisibility>,
    layers: RemovedComponents<'w, 's, RenderLayers>,
    backfaces: RemovedComponents<'w, 's, RayCastBackfaces>,
    no_spatial_index: RemovedComponents<'w, 's, NoSpatialIndex>,
    disabled: RemovedComponents<'w, 's, Disabled>,
}

impl Removed<'_, '_> {
    fn read(&mut self) -> impl Iterator<Item = Entity> + '_ {
        (self.transform.read())
            .chain(self.aabb.read())
            .chain(self.mesh_2d.read())
            .chain(self.mesh_3d.read())
            .chain(self.simplified_mesh.read())
            .chain(self.shape.read())
            .chain(self.bounded_by.read())
            .chain(self.visibility.read())
            .chain(self.layers.read())
            .chain(self.backfaces.read())
            .chain(self.no_spatial_index.read())
            .chain(self.disabled.read())
    }
}

/// What [`follow_entities`] keeps from frame to frame.
#[derive(Default)]
pub(super) struct Memory {
    bounded_by_mesh: BoundedByMesh,
    /// Buffers, kept for their memory.
    dirty: Vec<Entity>,
    new: Vec<(Entity, Contents)>,
}

/// The entities whose box comes from a mesh asset rather than from an `Aabb`, or would if it were loaded.
#[derive(Default)]
struct BoundedByMesh {
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

    fn of(&self, mesh: AssetId<Mesh>) -> impl Iterator<Item = Entity> + '_ {
        self.entities.get(&mesh).into_iter().flatten().copied()
    }
}

/// Brings the index up to date with every entity that has changed in any way that matters.
pub(super) fn follow_entities(
    changed: Query<Entity, (HasBounds, AnyChanged)>,
    disabled: Query<Entity, (With<Disabled>, Added<Disabled>)>,
    mut removed: Removed,
    entities: Query<Indexed>,
    assets: Option<Res<Assets<Mesh>>>,
    mut meshes: ResMut<MeshBvhs>,
    mut index: ResMut<SpatialIndex>,
    mut memory: Local<Memory>,
) {
    let Memory {
        bounded_by_mesh,
        dirty,
        new,
    } = &mut *memory;
    dirty.extend(&changed);
    let changed_alone = dirty.len();
    dirty.extend(&disabled);
    dirty.extend(removed.read());
    if meshes.has_changed() {
        dirty.extend(meshes.drain_changed().flat_map(|mesh| bounded_by_mesh.of(mesh)));
    }
    if dirty.is_empty() {
        return;
    }
    if dirty.len() > changed_alone {
        // One entity may be in several lists.
        dirty.sort_unstable();
        dirty.dedup();
    }

    let mut reconciler = Reconciler {
        assets: assets.as_deref(),
        meshes: &mut meshes,
        index: &mut index,
        bounded_by_mesh,
        new,
    };
    for entity in dirty.drain(..) {
        reconciler.reconcile(entity, entities.get(entity).ok());
    }
    if !new.is_empty() {
        index.insert_many(new);
    }
}

/// Makes the index agree with one entity at a time.
struct Reconciler<'a> {
    assets: Option<&'a Assets<Mesh>>,
    meshes: &'a mut MeshBvhs,
    index: &'a mut SpatialIndex,
    bounded_by_mesh: &'a mut BoundedByMesh,
    /// Entities to be inserted together.
    new: &'a mut Vec<(Entity, Contents)>,
}

impl Reconciler<'_> {
    /// Makes the index agree with `entity`, which is gone, disabled or without a place in the world if there is no
    /// `item`.
    fn reconcile(&mut self, entity: Entity, item: Option<IndexedItem>) {
        self.bounded_by_mesh.remove(entity);
        let old_mesh = self.index.surface_of(entity).and_then(PlacedSurface::mesh);
        let item = item.filter(|item| !item.is_left_out);
        let shape = item.as_ref().and_then(pick_shape);
        let mesh = shape.as_ref().and_then(Shape::mesh);
        let acquired = mesh.filter(|_| mesh != old_mesh);
        if let Some(mesh) = acquired {
            self.meshes.acquire(mesh, entity, self.assets);
        }
        if let Some(Shape::Mesh(mesh, kind)) = shape {
            self.meshes.bound_by(mesh, kind);
        }

        let state = item.as_ref().map_or(Ok(None), |item| self.state(entity, item, shape));
        let refusal = state.as_ref().err().copied();
        if self.index.set_refused(entity, refusal)
            && let (Some(why), Some(item)) = (refusal, &item)
        {
            warn!("{} ({entity}) is left out of the spatial index: {why}", item.name);
        }

        let stays = match state.ok().flatten() {
            Some(contents) => {
                if self.index.contains(entity) {
                    self.index.update(entity, contents);
                } else {
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

    /// What the index should hold for an entity: `None` if the entity has no bounds, or none yet.
    fn state(&mut self, entity: Entity, item: &IndexedItem, shape: Option<Shape>) -> Result<Option<Contents>, Refusal> {
        if item.aabb.is_none() && shape.is_none() {
            return Ok(None);
        }
        let world_from_local = item.transform.affine();
        if !world_from_local.is_finite() {
            return Err(Refusal::Transform);
        }
        let Some(local) = self.local_bounds(entity, item, shape.as_ref())? else {
            return Ok(None);
        };
        let world = local.transformed_by_affine(&world_from_local);
        if !world.is_sound() {
            return Err(Refusal::WorldBounds);
        }
        let surface = shape.map(|shape| PlacedSurface {
            shape,
            world_from_local,
            local_from_world: inverse(&world_from_local),
            backfaces: if item.has_backfaces || item.mesh_2d.is_some() {
                Backfaces::Include
            } else {
                Backfaces::Cull
            },
        });
        Ok(Some(Contents {
            aabb: world,
            surface,
            layers: item.layers.cloned().unwrap_or_default(),
            visible: item.visibility.is_none_or(|visibility| visibility.get()),
        }))
    }

    /// The local box of an entity: its `Aabb`, with the box of a simplified mesh or a `PickShape`, which may stick out;
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
    if let Some(shape) = item.shape {
        return Some(Shape::Analytic(shape.clone()));
    }
    let simplified = item.simplified_mesh.map(|mesh| mesh.0.id());
    let mesh = simplified
        .or(item.mesh_3d.map(|mesh| mesh.0.id()))
        .or(item.mesh_2d.map(|mesh| mesh.0.id()))?;
    let kind = item.bounded_by.copied().unwrap_or_default().0;
    Some(Shape::Mesh(mesh, kind))
}

/// The inverse of `transform`, or `None` if it has none: if the transform is flat.
fn inverse(transform: &Affine3A) -> Option<DAffine3> {
    // In double precision the determinant of the smallest scale that `f32` can hold does not vanish.
    let inverse = transform.as_daffine3().inverse();
    inverse.is_finite().then_some(inverse)
}
