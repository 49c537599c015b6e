//! Following what changes in what can be seen.

use bevy::{
    camera::{
        primitives::{Aabb, Sphere},
        visibility::{
            InheritedVisibility, NoCpuCulling, NoFrustumCulling, RenderLayers, ViewVisibility, VisibilityClass,
            VisibilityRange,
        },
    },
    ecs::{
        change_detection::{Ref, Res, ResMut, Tick},
        entity::Entity,
        entity_disabling::Disabled,
        lifecycle::RemovedComponents,
        query::{Added, Changed, Or, With, Without},
        system::{Local, ParamSet, Query, SystemParam},
    },
    light::{DirectionalLight, NotShadowCaster},
    mesh::{Mesh2d, Mesh3d},
    tasks::{ComputeTaskPool, TaskPool},
    transform::components::GlobalTransform,
};
use smallvec::SmallVec;

use super::{ViewCulling, ViewCullingStats, candidates::Seeables, marks::ViewVisibilities};
use crate::{
    index::{
        PickShape, SimplifiedMesh, SpatialIndex,
        ticks::{Since, added, changed},
    },
    lod::LodChoices,
    occlusion::NoOcclusionCulling,
    phase::phase,
};

/// Fewer entities than this are not worth a task.
const LEAST_SHARED: usize = 65_536;

/// What the index does not look at, of all that can be seen.
type Watched = (
    Entity,
    Ref<'static, InheritedVisibility>,
    Option<Ref<'static, VisibilityClass>>,
    Option<Ref<'static, Sphere>>,
    Option<Ref<'static, VisibilityRange>>,
    Option<Ref<'static, NoFrustumCulling>>,
    Option<Ref<'static, NoOcclusionCulling>>,
    Option<Ref<'static, NotShadowCaster>>,
    Option<Ref<'static, DirectionalLight>>,
    Option<Ref<'static, RenderLayers>>,
);

/// The same one by one: something has changed.
type WatchedChanged = Or<(
    Changed<VisibilityClass>,
    Added<Sphere>,
    Added<VisibilityRange>,
    Added<NoFrustumCulling>,
    Added<NoOcclusionCulling>,
    Added<NotShadowCaster>,
    Added<DirectionalLight>,
)>;

/// What the index may know nothing of.
type Unbounded = (
    With<InheritedVisibility>,
    Without<Aabb>,
    Without<Mesh2d>,
    Without<Mesh3d>,
    Without<SimplifiedMesh>,
    Without<PickShape>,
);

/// What has changed since the last frame, besides what the index has found.
#[derive(SystemParam)]
pub(super) struct Changes<'w, 's> {
    watched: Query<'w, 's, Watched>,
    watched_changed: Query<'w, 's, Entity, (With<InheritedVisibility>, WatchedChanged)>,
    /// What the index looks at, if it does.
    shown_changed: Query<'w, 's, Entity, Or<(Changed<InheritedVisibility>, Changed<RenderLayers>)>>,
    layers: RemovedComponents<'w, 's, RenderLayers>,
    unbounded: Query<
        'w,
        's,
        (
            Entity,
            Ref<'static, InheritedVisibility>,
            Option<Ref<'static, RenderLayers>>,
            Option<Ref<'static, GlobalTransform>>,
        ),
        Unbounded,
    >,
    unbounded_changed: Query<
        'w,
        's,
        Entity,
        (
            Unbounded,
            Or<(
                Changed<InheritedVisibility>,
                Changed<RenderLayers>,
                Added<GlobalTransform>,
            )>,
        ),
    >,
    view_visibility: RemovedComponents<'w, 's, ViewVisibility>,
    classes: RemovedComponents<'w, 's, VisibilityClass>,
    sphere: RemovedComponents<'w, 's, Sphere>,
    range: RemovedComponents<'w, 's, VisibilityRange>,
    never_culled: RemovedComponents<'w, 's, NoFrustumCulling>,
    never_hidden: RemovedComponents<'w, 's, NoOcclusionCulling>,
    casts_no_shadow: RemovedComponents<'w, 's, NotShadowCaster>,
    directional_light: RemovedComponents<'w, 's, DirectionalLight>,
    marks: Query<'w, 's, (Entity, Ref<'static, ViewVisibility>)>,
    marks_changed: Query<'w, 's, Entity, Changed<ViewVisibility>>,
    left_to_gpu: RemovedComponents<'w, 's, NoCpuCulling>,
    disabled: RemovedComponents<'w, 's, Disabled>,
    newly_left_to_gpu: Query<'w, 's, Entity, Added<NoCpuCulling>>,
}

impl Changes<'_, '_> {
    /// Finds what may be seen otherwise than before, also that of which the index tells if it is current.
    fn find_dirty(&self, index_is_current: bool, dirty: &mut Vec<Entity>) {
        match self.watched.contiguous_iter() {
            Ok(tables) => {
                for (
                    entities,
                    inherited,
                    classes,
                    sphere,
                    range,
                    never_culled,
                    never_hidden,
                    casts_no_shadow,
                    light,
                    layers,
                ) in tables
                {
                    let since = Since::last_read(&inherited);
                    let columns = [
                        changed(classes),
                        added(sphere),
                        added(range),
                        added(never_culled),
                        added(never_hidden),
                        added(casts_no_shadow),
                        added(light),
                        changed(Some(inherited).filter(|_| !index_is_current)),
                        changed(layers.filter(|_| !index_is_current)),
                    ];
                    collect(entities, since, columns, dirty);
                }
            }
            // Something decides which entities are disabled that is not stored in tables.
            Err(_) => {
                dirty.extend(&self.watched_changed);
                if !index_is_current {
                    dirty.extend(&self.shown_changed);
                }
            }
        }
        match self.unbounded.contiguous_iter() {
            Ok(tables) => {
                for (entities, inherited, layers, place) in tables {
                    let since = Since::last_read(&inherited);
                    let columns = [changed(Some(inherited)), changed(layers), added(place)];
                    collect(entities, since, columns, dirty);
                }
            }
            Err(_) => dirty.extend(&self.unbounded_changed),
        }
    }

    /// Finds those whose marks have changed.
    fn find_marked(&self, marked: &mut Vec<Entity>) {
        match self.marks.contiguous_iter() {
            Ok(tables) => {
                for (entities, visibility) in tables {
                    let since = Since::last_read(&visibility);
                    collect(entities, since, [changed(Some(visibility))], marked);
                }
            }
            Err(_) => marked.extend(&self.marks_changed),
        }
    }

    /// Finds all of it, some of it several times.
    fn find(&mut self, index_is_current: bool, found: &mut Found) {
        let Found {
            dirty,
            marked,
            unmarked,
        } = found;
        dirty.clear();
        marked.clear();
        unmarked.clear();
        let pool = ComputeTaskPool::get_or_init(TaskPool::default);
        let this = &*self;
        if this.marks.iter().len() < LEAST_SHARED || pool.thread_num() <= 1 {
            this.find_dirty(index_is_current, dirty);
            this.find_marked(marked);
        } else {
            pool.scope(|scope| {
                scope.spawn(async { this.find_dirty(index_is_current, dirty) });
                scope.spawn(async { this.find_marked(marked) });
            });
        }
        unmarked.extend(self.view_visibility.read().chain(&self.newly_left_to_gpu));
        dirty.extend(&*unmarked);
        dirty.extend(
            (self.classes.read())
                .chain(self.sphere.read())
                .chain(self.range.read())
                .chain(self.never_culled.read())
                .chain(self.never_hidden.read())
                .chain(self.casts_no_shadow.read())
                .chain(self.directional_light.read()),
        );
        let off_layers = self.layers.read().filter(|_| !index_is_current);
        dirty.extend(off_layers);
        // Their marks come back as they were left.
        let back = dirty.len();
        dirty.extend(self.left_to_gpu.read().chain(self.disabled.read()));
        marked.extend(&dirty[back..]);
    }
}

/// What has changed.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// What may be seen otherwise than before.
    dirty: Vec<Entity>,
    /// Those whose marks have changed.
    marked: Vec<Entity>,
    /// Those whose marks were taken away, if they had any.
    unmarked: Vec<Entity>,
}

/// Collects the entities of a table of which some column has a newer tick.
fn collect<const N: usize>(entities: &[Entity], since: Since, columns: [Option<&[Tick]>; N], dirty: &mut Vec<Entity>) {
    let columns: SmallVec<[&[Tick]; N]> = columns.into_iter().flatten().collect();
    if columns.is_empty() {
        return;
    }
    since.collect(entities, &columns, dirty);
}

/// Brings what is known of the candidates up to date, and begins a frame for all views.
pub(super) fn follow_candidates(
    mut world: ParamSet<(Changes, ViewVisibilities)>,
    seeables: Seeables,
    index: Res<SpatialIndex>,
    lods: Option<Res<LodChoices>>,
    mut culling: ResMut<ViewCulling>,
    mut stats: ResMut<ViewCullingStats>,
    mut found: Local<Found>,
) {
    let phase = phase!("sightline/culling/find");
    let culling = &mut *culling;
    let syncs = index.syncs();
    culling.index_is_current = culling.syncs != syncs;
    let has_missed_some = culling.syncs.wrapping_add(1) < syncs;
    culling.syncs = syncs;
    culling.candidates.begin_frame();

    world.p0().find(culling.index_is_current, &mut found);
    let Found {
        dirty,
        marked,
        unmarked,
    } = &mut *found;
    dirty.append(&mut culling.candidates.incomplete);
    if culling.index_is_current {
        dirty.extend_from_slice(index.reconciled());
    }
    let lods = lods.as_deref();
    dirty.extend_from_slice(lods.map_or(&[], LodChoices::reassigned));
    if !has_missed_some {
        for entity in dirty.drain(..) {
            culling
                .candidates
                .refresh(entity, seeables.get(entity).ok(), &index, lods);
        }
    }
    // Entities may come and go in ways of which nothing tells: by a component that disables them.
    if has_missed_some || culling.candidates.len() != seeables.iter().len() {
        culling.forget();
        for seen in &seeables {
            culling.candidates.refresh(seen.entity, Some(seen), &index, lods);
        }
    }

    let ViewCulling {
        candidates,
        views,
        marks,
        ..
    } = culling;
    for view in views.values_mut() {
        view.begin_frame(&candidates.gone);
    }
    let gone = candidates.gone.iter().map(|&(entity, _)| entity);
    let gone = gone.chain(unmarked.iter().copied());
    // What was disabled for a while may have a mark that has not changed.
    marked.extend(&candidates.new);
    marked.extend(&*unmarked);
    marks.begin_frame(gone, marked.drain(..), candidates, &mut world.p1());
    *stats = ViewCullingStats {
        find: phase.end(),
        ..ViewCullingStats::default()
    };
}
