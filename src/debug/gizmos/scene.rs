//! The entities in view.

use bevy::{ecs::entity::Entity, math::bounding::Aabb3d};

use super::views::Views;
use crate::{
    index::{Key, SpatialIndex},
    spatial::{aabb_tree::Sides, wide::EVERY_MASK},
};

/// An entity in view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub entity: Entity,
    pub aabb: Aabb3d,
    /// The square of its distance from who is nearest.
    pub distance_squared: f32,
}

/// Finds all entities whose boxes may be in view, each once.
pub(super) fn find_in_view(index: &SpatialIndex, views: &Views, seen: &mut Vec<Seen>) {
    seen.clear();
    for (number, view) in views.views.iter().enumerate() {
        let mut gather = Gather {
            index,
            views,
            number,
            seen,
        };
        let tree = index.tree();
        for open in tree.open(&view.half_spaces, EVERY_MASK, 1, &mut gather) {
            tree.walk(&view.half_spaces, EVERY_MASK, open, &mut gather);
        }
    }
}

struct Gather<'a> {
    index: &'a SpatialIndex,
    views: &'a Views,
    /// Of the view that looks.
    number: usize,
    seen: &'a mut Vec<Seen>,
}

impl Gather<'_> {
    fn add(&mut self, entity: Entity, aabb: &Aabb3d) {
        let is_new = !self.views.views[..self.number].iter().any(|view| view.may_see(aabb));
        if is_new {
            self.seen.push(Seen {
                entity,
                aabb: *aabb,
                distance_squared: self.views.distance_squared(aabb),
            });
        }
    }
}

impl Sides<Key> for Gather<'_> {
    fn inside(&mut self, keys: &[Key]) {
        for key in keys {
            if let Some(aabb) = self.index.aabb(key.entity) {
                self.add(key.entity, &aabb);
            }
        }
    }

    fn across(&mut self, key: Key, aabb: &Aabb3d) {
        if self.views.views[self.number].may_see(aabb) {
            self.add(key.entity, aabb);
        }
    }
}
