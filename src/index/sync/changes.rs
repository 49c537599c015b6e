//! What has changed since the last frame, found and dealt with in parallel as far as that goes.

use std::ops::Range;

use bevy::{
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, RenderLayers},
    },
    ecs::{
        change_detection::{ContiguousRef, Ref, Tick},
        entity::Entity,
        entity_disabling::Disabled,
        lifecycle::RemovedComponents,
        query::{Added, Changed, Or, With},
        system::{Query, SystemParam},
    },
    mesh::{Mesh2d, Mesh3d, morph::MeshMorphWeights, skinning::SkinnedMesh},
    tasks::{ComputeTaskPool, TaskPool},
    transform::components::GlobalTransform,
};
use smallvec::SmallVec;

use crate::index::{
    BoundedBy, DetailLevel, HitSurface, NoSpatialIndex, PickShape, RayCastBackfaces, SimplifiedMesh, SpatialIndex,
    pick_shape::DerivedShape,
    spatial_index::Moves,
    ticks::{Since, added, changed, misses, ones},
};

/// Fewer entities than this are not worth a task.
const LEAST_ROWS: usize = 16_384;

/// Tasks per thread, so that none waits long for another.
const TASKS_PER_THREAD: usize = 4;

/// An entity could be in the index.
type HasBounds = Or<(
    With<Aabb>,
    With<Mesh2d>,
    With<Mesh3d>,
    With<SimplifiedMesh>,
    With<PickShape>,
    With<DerivedShape>,
)>;

/// What the index reads of entities, with the times of the changes.
type Watched = (
    Entity,
    Ref<'static, GlobalTransform>,
    Option<Ref<'static, Aabb>>,
    Option<Ref<'static, Mesh2d>>,
    Option<Ref<'static, Mesh3d>>,
    Option<Ref<'static, SimplifiedMesh>>,
    Option<Ref<'static, PickShape>>,
    Option<Ref<'static, DerivedShape>>,
    Option<Ref<'static, BoundedBy>>,
    Option<Ref<'static, HitSurface>>,
    Option<Ref<'static, InheritedVisibility>>,
    Option<Ref<'static, RenderLayers>>,
    Option<Ref<'static, RayCastBackfaces>>,
    Option<Ref<'static, NoSpatialIndex>>,
    Option<Ref<'static, DetailLevel>>,
);

/// Any of that has changed.
type AnyChanged = Or<(
    Changed<GlobalTransform>,
    Changed<Aabb>,
    Changed<Mesh2d>,
    Changed<Mesh3d>,
    Changed<SimplifiedMesh>,
    Changed<PickShape>,
    Changed<DerivedShape>,
    Changed<BoundedBy>,
    Changed<HitSurface>,
    Changed<InheritedVisibility>,
    Changed<RenderLayers>,
    Changed<RayCastBackfaces>,
    Changed<NoSpatialIndex>,
    Changed<DetailLevel>,
)>;

/// The entities that have changed.
#[derive(SystemParam)]
pub(in crate::index) struct Changes<'w, 's> {
    watched: Query<'w, 's, Watched, HasBounds>,
    changed: Query<'w, 's, Entity, (HasBounds, AnyChanged)>,
}

/// What was found in a part of the world.
#[derive(Debug, Default)]
pub(in crate::index) struct Found {
    /// What has moved and has not changed otherwise.
    pub moves: Moves,
    /// Everything else that has changed.
    pub dirty: Vec<Entity>,
    /// How many poses have changed.
    pub posed: usize,
}

impl Changes<'_, '_> {
    /// Finds everything that has changed. `parts` are buffers, of which as many are filled as there are tasks.
    pub fn find(&self, index: &SpatialIndex, parts: &mut Vec<Found>) {
        if parts.is_empty() {
            parts.push(Found::default());
        }
        let Ok(tables) = self.watched.contiguous_iter() else {
            // A program has made entities be disabled by a component that is not stored in tables.
            parts[0].dirty.extend(&self.changed);
            return;
        };
        let rows = self.watched.iter().len();
        let pool = ComputeTaskPool::get_or_init(TaskPool::default);
        let threads = pool.thread_num();
        if rows <= LEAST_ROWS || threads <= 1 {
            for table in tables {
                let table = Table::new(table);
                table.find(0..table.entities.len(), index, &mut parts[0]);
            }
            return;
        }

        let step = LEAST_ROWS.max(rows.div_ceil(threads * TASKS_PER_THREAD));
        let tables = tables.map(Table::new);
        let tasks: SmallVec<[(Table, Range<usize>); 32]> = tables
            .flat_map(|table| {
                let len = table.entities.len();
                (0..len)
                    .step_by(step)
                    .map(move |start| (table.clone(), start..len.min(start + step)))
            })
            .collect();
        if parts.len() < tasks.len() {
            parts.resize_with(tasks.len(), Found::default);
        }
        pool.scope(|scope| {
            for ((table, rows), found) in tasks.into_iter().zip(parts) {
                scope.spawn(async move { table.find(rows, index, found) });
            }
        });
    }
}

/// A table of the world.
#[derive(Clone)]
struct Table<'w> {
    entities: &'w [Entity],
    transforms: ContiguousRef<'w, GlobalTransform>,
    /// When each component was changed, of those that the entities have: first the place, last what is neither that nor
    /// the `Aabb`.
    ticks: SmallVec<[&'w [Tick]; 13]>,
    /// When each `Aabb` was added, if the entities have any.
    bounded: Option<&'w [Tick]>,
}

impl<'w> Table<'w> {
    fn new(
        (
            entities,
            transforms,
            aabb,
            mesh_2d,
            mesh_3d,
            simplified,
            shape,
            derived,
            bounded_by,
            hit_surface,
            visible,
            layers,
            backfaces,
            not_in,
            level,
        ): (
            &'w [Entity],
            ContiguousRef<'w, GlobalTransform>,
            Option<ContiguousRef<'w, Aabb>>,
            Option<ContiguousRef<'w, Mesh2d>>,
            Option<ContiguousRef<'w, Mesh3d>>,
            Option<ContiguousRef<'w, SimplifiedMesh>>,
            Option<ContiguousRef<'w, PickShape>>,
            Option<ContiguousRef<'w, DerivedShape>>,
            Option<ContiguousRef<'w, BoundedBy>>,
            Option<ContiguousRef<'w, HitSurface>>,
            Option<ContiguousRef<'w, InheritedVisibility>>,
            Option<ContiguousRef<'w, RenderLayers>>,
            Option<ContiguousRef<'w, RayCastBackfaces>>,
            Option<ContiguousRef<'w, NoSpatialIndex>>,
            Option<ContiguousRef<'w, DetailLevel>>,
        ),
    ) -> Self {
        let bounded = added(aabb.clone());
        let ticks = [
            Some(transforms.changed_ticks_slice()),
            changed(aabb),
            changed(mesh_2d),
            changed(mesh_3d),
            changed(simplified),
            changed(shape),
            changed(derived),
            changed(bounded_by),
            changed(hit_surface),
            changed(visible),
            changed(layers),
            changed(backfaces),
            changed(not_in),
            changed(level),
        ];
        Self {
            entities,
            transforms,
            bounded,
            ticks: ticks.into_iter().flatten().collect(),
        }
    }

    /// Finds what has changed in some rows.
    fn find(&self, rows: Range<usize>, index: &SpatialIndex, found: &mut Found) {
        let since = Since::last_read(&self.transforms);
        for block in since.blocks_with_newer(&self.ticks, rows) {
            let mut newer = self.ticks.iter().map(|ticks| since.newer(&ticks[block.clone()]));
            let moved = newer.next().unwrap_or(0);
            let resized = if self.bounded.is_some() {
                newer.next().unwrap_or(0)
            } else {
                0
            };
            let dirty = newer.fold(0, |dirty, newer| dirty | newer);
            let entities = &self.entities[block.clone()];
            found.dirty.extend(ones(dirty).map(|row| entities[row as usize]));
            for row in ones((moved | resized) & !dirty) {
                let entity = entities[row as usize];
                // Bevy gives a new box to what is skinned in each frame: ours is that of the pose.
                let is_bounded = || {
                    self.bounded
                        .is_some_and(|ticks| since.is_newer(ticks[block.start + row as usize]))
                };
                let is_resized = resized >> row & 1 == 1 && (!index.is_posed(entity) || is_bounded());
                if is_resized
                    || !index.note_move(
                        entity,
                        self.transforms[block.start + row as usize].affine(),
                        &mut found.moves,
                    )
                {
                    found.dirty.push(entity);
                }
            }
        }
    }
}

/// Defines [`Removed`] from the components whose removal counts.
macro_rules! define_removed {
    ($($name:ident: $component:ty,)*) => {
        /// What the index reads of an entity was taken away, or the whole entity.
        #[derive(SystemParam)]
        pub(in crate::index) struct Removed<'w, 's> {
            $($name: RemovedComponents<'w, 's, $component>,)*
            newly_disabled: Query<'w, 's, Entity, (With<Disabled>, Added<Disabled>)>,
        }

        impl Removed<'_, '_> {
            /// Whether Bevy has forgotten some of them before they could be read, after a pause of some frames.
            pub fn has_missed_some(&self) -> bool {
                false $(|| misses(&self.$name))*
            }

            /// Those entities, some of them several times.
            pub fn read(&mut self) -> impl Iterator<Item = Entity> + '_ {
                std::iter::empty() $(.chain(self.$name.read()))* .chain(&self.newly_disabled)
            }
        }
    };
}

define_removed! {
    transform: GlobalTransform,
    aabb: Aabb,
    mesh_2d: Mesh2d,
    mesh_3d: Mesh3d,
    simplified_mesh: SimplifiedMesh,
    shape: PickShape,
    derived: DerivedShape,
    bounded_by: BoundedBy,
    hit_surface: HitSurface,
    visibility: InheritedVisibility,
    layers: RenderLayers,
    backfaces: RayCastBackfaces,
    skin: SkinnedMesh,
    morph_weights: MeshMorphWeights,
    no_spatial_index: NoSpatialIndex,
    level: DetailLevel,
    disabled: Disabled,
}
