//! Following what changes in what occludes.
//!
//! Whatever happens to an entity, it ends in [`Follower::reconcile`], which looks at the entity as it is now: every way
//! in has its way out. What has but moved is given its new place.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, RenderLayers, VisibilityRange},
    },
    ecs::{
        change_detection::{DetectChangesMut, Ref, Res, ResMut, Tick},
        entity::Entity,
        entity_disabling::Disabled,
        lifecycle::RemovedComponents,
        message::{MessageCursor, Messages},
        name::NameOrEntity,
        query::{Added, Changed, Has, Or, QueryData, With},
        system::{Local, Query, SystemParam},
    },
    math::bounding::Aabb3d,
    mesh::{Mesh, Mesh3d, morph::MeshMorphWeights, skinning::SkinnedMesh},
    transform::components::GlobalTransform,
};
use smallvec::SmallVec;
use tracing::warn;

use super::{
    Occluder, OccluderRefusal, OccluderSettings, OccluderShape, OccluderStats, Occluders,
    occluders::{Active, Record},
    shapes::{Form, ShapeKey, Shapes, Sources},
};
use crate::{
    geometry::aabb::Aabb3dExt,
    index::{
        MeshBvhs, SpatialIndex,
        ticks::{Since, added, changed, misses, ones},
    },
    phase::phase,
};

/// What decides whether and how an entity occludes, with the times of the changes.
type Watched = (
    Entity,
    Ref<'static, Occluder>,
    Option<Ref<'static, GlobalTransform>>,
    Option<Ref<'static, InheritedVisibility>>,
    Option<Ref<'static, RenderLayers>>,
    Option<Ref<'static, Mesh3d>>,
    Option<Ref<'static, Aabb>>,
    Option<Ref<'static, VisibilityRange>>,
    Option<Ref<'static, SkinnedMesh>>,
    Option<Ref<'static, MeshMorphWeights>>,
);

/// Any of that has changed.
type AnyChanged = Or<(
    Changed<Occluder>,
    Changed<GlobalTransform>,
    Changed<InheritedVisibility>,
    Changed<RenderLayers>,
    Changed<Mesh3d>,
    Changed<Aabb>,
    Changed<VisibilityRange>,
    Added<SkinnedMesh>,
    Added<MeshMorphWeights>,
)>;

/// What has changed since the last frame.
#[derive(SystemParam)]
pub(super) struct Changes<'w, 's> {
    watched: Query<'w, 's, Watched>,
    changed: Query<'w, 's, Entity, (With<Occluder>, AnyChanged)>,
    occluder: RemovedComponents<'w, 's, Occluder>,
    transform: RemovedComponents<'w, 's, GlobalTransform>,
    visibility: RemovedComponents<'w, 's, InheritedVisibility>,
    layers: RemovedComponents<'w, 's, RenderLayers>,
    mesh: RemovedComponents<'w, 's, Mesh3d>,
    aabb: RemovedComponents<'w, 's, Aabb>,
    range: RemovedComponents<'w, 's, VisibilityRange>,
    skin: RemovedComponents<'w, 's, SkinnedMesh>,
    morph_weights: RemovedComponents<'w, 's, MeshMorphWeights>,
    disabled: RemovedComponents<'w, 's, Disabled>,
    newly_disabled: Query<'w, 's, Entity, (With<Occluder>, With<Disabled>, Added<Disabled>)>,
}

impl Changes<'_, '_> {
    /// Finds what is to be looked at, some of it several times, and moves what has but moved.
    fn find(&mut self, items: &Query<Item>, occluders: &mut Occluders, dirty: &mut Vec<Entity>) {
        match self.watched.contiguous_iter() {
            Ok(tables) => {
                for (entities, occluder, transform, shown, layers, mesh, aabb, range, skin, morph) in tables {
                    let since = Since::last_read(&occluder);
                    let places: &[GlobalTransform] = transform.as_deref().unwrap_or_default();
                    let columns = [
                        changed(Some(occluder)),
                        changed(shown),
                        changed(layers),
                        changed(mesh),
                        changed(aabb),
                        changed(range),
                        added(skin),
                        added(morph),
                        // The last, if there is any.
                        changed(transform.clone()),
                    ];
                    let columns: SmallVec<[&[Tick]; 9]> = columns.into_iter().flatten().collect();
                    let others = columns.len() - usize::from(!places.is_empty());
                    for block in since.blocks_with_newer(&columns, 0..entities.len()) {
                        let newer = |ticks: &&[Tick]| since.newer(&ticks[block.clone()]);
                        let otherwise = columns[..others].iter().map(newer).fold(0, |all, newer| all | newer);
                        let moved = columns[others..].iter().map(newer).fold(0, |all, newer| all | newer);
                        for row in ones(otherwise | moved) {
                            let entity = entities[block.start + row as usize];
                            let has_but_moved = otherwise >> row & 1 == 0;
                            let place = || places[block.start + row as usize].affine();
                            if !(has_but_moved && occluders.set_place(entity, place())) {
                                dirty.push(entity);
                            }
                        }
                    }
                }
            }
            // Something decides which entities are disabled that is not stored in tables.
            Err(_) => dirty.extend(&self.changed),
        }
        let removed = (self.occluder.read())
            .chain(self.transform.read())
            .chain(self.visibility.read())
            .chain(self.layers.read())
            .chain(self.mesh.read())
            .chain(self.aabb.read())
            .chain(self.range.read())
            .chain(self.skin.read())
            .chain(self.morph_weights.read());
        dirty.extend(removed.filter(|&entity| occluders.record(entity).is_some()));
        dirty.extend(self.disabled.read().filter(|&entity| items.contains(entity)));
        dirty.extend(&self.newly_disabled);
    }
}

impl Changes<'_, '_> {
    /// Whether Bevy has forgotten what was removed before it could be read, after a pause of some frames. To be asked before
    /// [`find`](Self::find), which reads it.
    fn has_missed_some(&self) -> bool {
        misses(&self.occluder)
            || misses(&self.transform)
            || misses(&self.visibility)
            || misses(&self.layers)
            || misses(&self.mesh)
            || misses(&self.aabb)
            || misses(&self.range)
            || misses(&self.skin)
            || misses(&self.morph_weights)
            || misses(&self.disabled)
    }
}

/// What is read of an entity that may occlude.
#[derive(QueryData)]
pub(super) struct Item {
    name: NameOrEntity,
    occluder: &'static Occluder,
    transform: Option<&'static GlobalTransform>,
    visibility: Option<&'static InheritedVisibility>,
    layers: Option<&'static RenderLayers>,
    mesh: Option<&'static Mesh3d>,
    aabb: Option<&'static Aabb>,
    range: Option<&'static VisibilityRange>,
    has_skin: Has<SkinnedMesh>,
    has_morph_weights: Has<MeshMorphWeights>,
}

/// Brings the [`Occluders`] up to date with whatever has changed.
pub(super) fn follow_occluders(
    mut changes: Changes,
    items: Query<Item>,
    events: Option<Res<Messages<AssetEvent<Mesh>>>>,
    mut events_read: Local<MessageCursor<AssetEvent<Mesh>>>,
    assets: Option<Res<Assets<Mesh>>>,
    index: Res<SpatialIndex>,
    bvhs: Res<MeshBvhs>,
    settings: Res<OccluderSettings>,
    mut occluders: ResMut<Occluders>,
    mut stats: ResMut<OccluderStats>,
    mut dirty: Local<Vec<Entity>>,
    mut syncs: Local<u64>,
) {
    let phase = phase!("sightline/occlusion/follow");
    let is_current = std::mem::replace(&mut *syncs, index.syncs()) != index.syncs();
    let quietly = occluders.bypass_change_detection();
    let version = quietly.version();
    let mut has_missed_some = changes.has_missed_some();
    changes.find(&items, quietly, &mut dirty);
    if let Some(events) = &events {
        if events_read.missed_messages(events) > 0 {
            quietly.shapes.forget_all(&mut dirty);
            has_missed_some = true;
        }
        for event in events_read.read(events) {
            if let Some(mesh) = changed_mesh(event) {
                quietly.shapes.follow_mesh(mesh, &mut dirty);
            }
        }
    }
    quietly.shapes.set_inner(settings.inner, &mut dirty);
    quietly.shapes.collect_made(&mut dirty);
    dirty.sort_unstable();
    dirty.dedup();
    let mut reconciled = dirty.len();

    let mut follower = Follower {
        occluders: quietly,
        sources: Sources {
            bvhs: &bvhs,
            is_current,
            assets: assets.as_deref(),
        },
    };
    for entity in dirty.drain(..) {
        follower.reconcile(entity, items.get(entity).ok());
    }
    // Entities may come and go in ways of which nothing tells: by a component that disables them.
    if has_missed_some || follower.occluders.known() != items.iter().len() {
        dirty.extend(follower.occluders.all_known());
        reconciled += dirty.len() + items.iter().len();
        for entity in dirty.drain(..) {
            follower.reconcile(entity, items.get(entity).ok());
        }
        for item in &items {
            follower.reconcile(item.name.entity, Some(item));
        }
    }
    let is_changed = quietly.version() != version;
    *stats = OccluderStats {
        occluders: quietly.len(),
        refused: quietly.refused().len(),
        making: quietly.making(),
        reconciled,
        follow: phase.end(),
    };
    if is_changed {
        occluders.set_changed();
    }
}

fn changed_mesh(event: &AssetEvent<Mesh>) -> Option<AssetId<Mesh>> {
    match *event {
        AssetEvent::Added { id }
        | AssetEvent::Modified { id }
        | AssetEvent::Removed { id }
        | AssetEvent::Unused { id } => Some(id),
        AssetEvent::LoadedWithDependencies { .. } => None,
    }
}

/// Makes what is known agree with one entity at a time.
struct Follower<'a> {
    occluders: &'a mut Occluders,
    sources: Sources<'a>,
}

impl Follower<'_> {
    /// Makes what is known agree with `entity`, which is gone, disabled, or has no `Occluder` if there is no `item`.
    fn reconcile(&mut self, entity: Entity, item: Option<ItemItem>) {
        // Of an earlier generation, whose end was missed.
        if let Some(namesake) = self.occluders.namesake(entity).filter(|_| item.is_some()) {
            self.reconcile(namesake, None);
        }
        let old = self.occluders.record(entity).cloned();
        let key = item.as_ref().and_then(ItemItem::shape_key);
        if let Some(old_key) = old.as_ref().and_then(|old| old.key)
            && Some(old_key) != key
        {
            self.occluders.shapes.release(old_key, entity);
        }
        let Some(item) = item else {
            if old.is_some() {
                self.occluders.set_record(entity, None);
                self.occluders.set_refused(entity, None);
            }
            return;
        };
        let old_shape = old.and_then(|old| old.active).map(|active| active.shape);
        let shape = match key {
            Some(key) => self.shape_of_mesh(key, &item),
            None => item.own_shape(old_shape),
        };
        let active = shape.and_then(|shape| item.active(shape));
        let refusal = active.as_ref().err().copied();
        let is_of_mesh = matches!(
            refusal,
            Some(OccluderRefusal::NotSolid(_) | OccluderRefusal::Unusable(_))
        );
        if self.occluders.set_refused(entity, refusal)
            && let Some(why) = refusal.filter(|_| !is_of_mesh)
        {
            warn!("{} ({entity}) does not occlude: {why}", item.name);
        }
        let active = active.ok().flatten();
        self.occluders.set_record(entity, Some(Record { entity, key, active }));
    }

    /// The shape of a mesh, if it is done. That there is none is said once for each mesh.
    fn shape_of_mesh(&mut self, key: ShapeKey, item: &ItemItem) -> Result<Option<OccluderShape>, OccluderRefusal> {
        let shapes: &mut Shapes = &mut self.occluders.shapes;
        let entity = item.name.entity;
        let shape = shapes.acquire(key, entity, &self.sources).transpose();
        if let Err(why) = &shape
            && shapes.begin_warning(key)
        {
            let mesh = key.0;
            warn!("the mesh {mesh} of {} ({entity}) does not occlude: {why}", item.name);
        }
        shape
    }
}

impl ItemItem<'_, '_> {
    /// The shape of a mesh by which it occludes.
    fn shape_key(&self) -> Option<ShapeKey> {
        let own_mesh = || self.mesh.filter(|_| !self.is_posed()).map(|mesh| mesh.0.id());
        match self.occluder {
            Occluder::Auto => Some((own_mesh()?, Form::Boxes)),
            Occluder::Mesh => Some((own_mesh()?, Form::Triangles)),
            Occluder::Proxy(mesh) => Some((mesh.id(), Form::Triangles)),
            Occluder::Box => None,
        }
    }

    fn is_posed(&self) -> bool {
        self.has_skin || self.has_morph_weights
    }

    /// The shape by which it occludes without one of a mesh; the old one if it is the same.
    fn own_shape(&self, old: Option<OccluderShape>) -> Result<Option<OccluderShape>, OccluderRefusal> {
        if *self.occluder != Occluder::Box {
            let is_refused = self.mesh.is_some() && self.is_posed();
            return if is_refused {
                Err(OccluderRefusal::Posed)
            } else {
                Ok(None)
            };
        }
        let Some(aabb) = self.aabb else {
            return Ok(None);
        };
        let aabb = Aabb3d {
            min: aabb.min(),
            max: aabb.max(),
        };
        if !aabb.is_sound() {
            return Err(OccluderRefusal::Bounds);
        }
        Ok(Some(match old {
            Some(OccluderShape::Boxes(boxes)) if *boxes == [aabb] => OccluderShape::Boxes(boxes),
            _ => OccluderShape::Boxes([aabb].into()),
        }))
    }

    /// How it occludes by a shape, if it does now.
    fn active(&self, shape: Option<OccluderShape>) -> Result<Option<Active>, OccluderRefusal> {
        let Some(transform) = self.transform else {
            return Ok(None);
        };
        let world_from_local = transform.affine();
        if !world_from_local.is_finite() {
            return Err(OccluderRefusal::Transform);
        }
        let is_shown = self.visibility.is_none_or(|visibility| visibility.get());
        let is_whole = self.range.is_none_or(VisibilityRange::is_abrupt);
        Ok(shape.filter(|_| is_shown && is_whole).map(|shape| Active {
            shape,
            world_from_local,
            layers: self.layers.cloned().unwrap_or_default(),
        }))
    }
}
