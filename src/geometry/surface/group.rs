//! Groups of surfaces.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;

use super::{Surface, SurfaceHit};
use crate::geometry::{
    aabb,
    ray::{Ray, triangle::Backfaces},
    support::Support,
};

/// Several surfaces, in one space, that are hit as one. It keeps a box around them all, and tests that first.
///
/// A group may hold groups: a hierarchy of bounding volumes, by composition. Of several hits at the same parameter, the
/// one on the first member counts. An empty group is hit by nothing, and has no box.
#[derive(Default)]
pub struct SurfaceGroup {
    members: Vec<Box<dyn Surface>>,
    /// `None` if there is nothing to hit, or a member has no end.
    aabb: Option<Aabb3d>,
}

impl SurfaceGroup {
    /// An empty group.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a surface after the others. One that is shared goes in as an [`Arc`](std::sync::Arc).
    pub fn push(&mut self, surface: impl Surface + 'static) {
        if !surface.is_empty() {
            self.aabb = match (self.aabb, surface.aabb()) {
                (Some(around), Some(member)) => Some(aabb::union(&around, &member)),
                (None, member) if self.is_empty() => member,
                _ => None,
            };
        }
        self.members.push(Box::new(surface));
    }

    /// The surfaces, in the order in which they were added.
    pub fn members(&self) -> &[Box<dyn Surface>] {
        &self.members
    }

    fn may_hit(&self, ray: &Ray) -> bool {
        self.aabb.is_none_or(|aabb| ray.aabb_intersection_at(&aabb).is_some())
    }
}

impl Surface for SurfaceGroup {
    fn aabb(&self) -> Option<Aabb3d> {
        self.aabb
    }

    /// Whether there are no members, or none that is not empty itself.
    fn is_empty(&self) -> bool {
        self.members.iter().all(Surface::is_empty)
    }

    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        if !self.may_hit(ray) {
            return None;
        }
        let mut rest = *ray;
        let mut closest: Option<SurfaceHit> = None;
        for member in &self.members {
            let hit = member.closest_hit(&rest, backfaces);
            // A surface of the user's own may be wrong.
            let Some(hit) = hit.filter(|hit| rest.has_parameter(hit.t)) else {
                continue;
            };
            if closest.is_none_or(|closest| hit.t < closest.t) {
                closest = Some(hit);
                rest = rest.with_t_max(hit.t);
            }
        }
        closest
    }

    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        self.may_hit(ray) && self.members.iter().any(|member| member.any_hit(ray, backfaces))
    }

    fn visit_hulls(&self, visit: &mut dyn FnMut(&dyn Support) -> ControlFlow<()>) -> ControlFlow<()> {
        self.members.iter().try_for_each(|member| member.visit_hulls(visit))
    }
}

impl<S: Surface + 'static> Extend<S> for SurfaceGroup {
    fn extend<I: IntoIterator<Item = S>>(&mut self, surfaces: I) {
        surfaces.into_iter().for_each(|surface| self.push(surface));
    }
}

impl<S: Surface + 'static> FromIterator<S> for SurfaceGroup {
    fn from_iter<I: IntoIterator<Item = S>>(surfaces: I) -> Self {
        let mut group = Self::new();
        group.extend(surfaces);
        group
    }
}
