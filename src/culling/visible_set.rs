//! What a camera sees, for the game.

use bevy::{
    ecs::{
        change_detection::{DetectChanges, Mut},
        component::Component,
        entity::Entity,
        event::EntityEvent,
        reflect::{ReflectComponent, ReflectEvent},
    },
    math::{Vec3A, bounding::Aabb3d},
    reflect::{Reflect, std_traits::ReflectDefault},
    transform::components::GlobalTransform,
};

use super::{
    candidates::Candidates,
    sorted::amend,
    view::{View, come, gone},
};
use crate::index::SpatialIndex;

/// All entities that a camera sees, whatever their visibility class, as of the last `PostUpdate`.
///
/// On every camera, as [`ViewCullingPlugin`](super::ViewCullingPlugin) requires it. It holds everything that is not
/// hidden, on a layer of the camera, in range, of the level of detail that it shows, not wholly out of its frustum, and, with
/// [`SoftwareOcclusion`](crate::occlusion::SoftwareOcclusion), not found to be behind occluders; also what is not drawn.
/// While the camera is not active, or [culling is left to Bevy](super::ViewCullingSettings::enabled), it stays as it was.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::prelude::*;
/// #[derive(Component)]
/// struct Enemy;
///
/// fn warn(views: Query<&VisibleSet>, enemies: Query<&Name, With<Enemy>>) {
///     for view in &views {
///         for name in enemies.iter_many(view.entered()) {
///             println!("{name} comes into view");
///         }
///     }
/// }
/// ```
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct VisibleSet {
    entities: Vec<Entity>,
    entered: Vec<Entity>,
    left: Vec<Entity>,
}

/// Asks for [`EnteredView`] and [`LeftView`] to be triggered for what a camera sees.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct ReportViewChanges;

/// A camera with [`ReportViewChanges`] has begun to see an entity.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Event, Debug, Clone, PartialEq)]
pub struct EnteredView {
    /// What is seen.
    pub entity: Entity,
    /// The camera.
    pub view: Entity,
}

/// A camera with [`ReportViewChanges`] has ceased to see an entity. Not triggered for what is despawned.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Event, Debug, Clone, PartialEq)]
pub struct LeftView {
    /// What was seen.
    pub entity: Entity,
    /// The camera.
    pub view: Entity,
}

/// An entity in view, with where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleEntity {
    /// The entity.
    pub entity: Entity,
    /// Its world box, as the index has it.
    pub aabb: Aabb3d,
    /// How far its nearest point is along the axis of the camera, in world units: negative behind the camera.
    pub depth: f32,
}

impl VisibleSet {
    /// All that is seen, in ascending order.
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }

    /// Whether an entity is seen.
    pub fn contains(&self, entity: Entity) -> bool {
        self.entities.binary_search(&entity).is_ok()
    }

    /// What is seen and was not in the frame before, in ascending order.
    pub fn entered(&self) -> &[Entity] {
        &self.entered
    }

    /// What was seen in the frame before and is not now, in ascending order. Some of it may not exist any more.
    pub fn left(&self) -> &[Entity] {
        &self.left
    }

    /// All that is seen and is in the index, with its world box, in ascending order.
    pub fn with_bounds<'a>(&'a self, index: &'a SpatialIndex) -> impl Iterator<Item = (Entity, Aabb3d)> + 'a {
        self.entities
            .iter()
            .filter_map(|&entity| Some((entity, index.aabb(entity)?)))
    }

    /// The same, nearest first as a camera at `eye` has it, written over `visible`: by the nearest point of the world
    /// box along the axis of the camera, and at one depth by entity.
    pub fn front_to_back(&self, index: &SpatialIndex, eye: &GlobalTransform, visible: &mut Vec<VisibleEntity>) {
        let forward = Vec3A::from(*eye.forward());
        let origin = forward.dot(eye.translation_vec3a());
        visible.clear();
        visible.extend(self.with_bounds(index).map(|(entity, aabb)| {
            let nearest = Vec3A::select(forward.cmpge(Vec3A::ZERO), aabb.min, aabb.max);
            let depth = forward.dot(nearest) - origin;
            VisibleEntity { entity, aabb, depth }
        }));
        visible.sort_unstable_by(|a, b| a.depth.total_cmp(&b.depth).then(a.entity.cmp(&b.entity)));
    }

    /// Brings the set of a camera up to date with its view, whose changes are in order.
    pub(super) fn write(mut set: Mut<Self>, view: &View, candidates: &Candidates, buffer: &mut Vec<Entity>) {
        if view.written.is_none() || set.is_added() {
            let set = &mut *set;
            let before = std::mem::take(&mut set.entities);
            set.entities
                .extend(view.seen.iter().map(|number| candidates.record(number).entity));
            set.entities.sort_unstable();
            let is_in = |list: &[Entity], entity: &Entity| list.binary_search(entity).is_ok();
            set.left.clear();
            set.left
                .extend(before.iter().filter(|entity| !is_in(&set.entities, entity)));
            set.entered.clear();
            set.entered
                .extend(set.entities.iter().filter(|entity| !is_in(&before, entity)));
            return;
        }
        if view.changes.is_empty() && set.entered.is_empty() && set.left.is_empty() {
            return;
        }
        let set = &mut *set;
        let (come, gone) = (come(&view.changes), gone(&view.changes));
        amend(&mut set.entities, gone.clone(), come.clone(), buffer);
        set.entered.clear();
        set.entered.extend(come);
        set.left.clear();
        set.left.extend(gone);
    }
}
