//! The one trait that every structure answers.

use std::ops::ControlFlow;

use bevy::math::bounding::{Aabb3d, BoundingSphere};

use crate::geometry::ray::Ray;

/// What a visitor wants of the rest of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayVisit {
    /// Go on to the end of the ray.
    Continue,
    /// Go on, but no farther than this parameter. A parameter beyond the present end changes nothing.
    Shorten(f32),
    /// Visit nothing more.
    Stop,
}

/// Queries over a set of boxes, each with a key.
///
/// All queries see the boxes exactly as they were last given, whatever slack a structure keeps inside. The visiting
/// methods are what a structure implements; the others are made of them.
pub trait SpatialQueries<K: Copy> {
    /// The number of boxes.
    fn len(&self) -> usize;

    /// Whether there are no boxes.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A box around all boxes, as tight as the structure knows it; `None` if there are none.
    fn bounds(&self) -> Option<Aabb3d>;

    /// Visits every key whose box the ray enters, with the parameter at which it does.
    ///
    /// Boxes come roughly from near to far, in no promised order. A box that the ray enters exactly where it was
    /// shortened to is still visited, so that ties do not depend on the structure.
    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> RayVisit);

    /// Visits every key whose box touches `aabb`, in no promised order.
    fn visit_aabb(&self, aabb: &Aabb3d, visit: impl FnMut(K) -> ControlFlow<()>);

    /// Visits every key whose box touches `sphere`, in no promised order.
    fn visit_sphere(&self, sphere: &BoundingSphere, visit: impl FnMut(K) -> ControlFlow<()>);

    /// The nearest hit along the ray: its key, its parameter, and what `test` found.
    ///
    /// `test` gets a key whose box the ray enters and the ray as far as it still matters, and returns the parameter of
    /// the nearest hit in what the key stands for, with anything that the caller wants to know of it. Of two hits at
    /// the same parameter the smaller key wins.
    fn closest_hit<H>(&self, ray: &Ray, mut test: impl FnMut(K, &Ray) -> Option<(f32, H)>) -> Option<(K, f32, H)>
    where
        K: Ord,
    {
        let mut rest = *ray;
        let mut closest: Option<(K, f32, H)> = None;
        self.visit_ray(ray, |key, _| match test(key, &rest) {
            Some((t, hit)) if closest.as_ref().is_none_or(|(k, c, _)| (t, key) < (*c, *k)) => {
                closest = Some((key, t, hit));
                rest = rest.with_t_max(t);
                RayVisit::Shorten(t)
            }
            _ => RayVisit::Continue,
        });
        closest
    }

    /// Whether `test` is true for any key whose box the ray enters; stops at the first.
    fn any_hit(&self, ray: &Ray, mut test: impl FnMut(K, &Ray) -> bool) -> bool {
        let mut found = false;
        self.visit_ray(ray, |key, _| {
            found = test(key, ray);
            if found { RayVisit::Stop } else { RayVisit::Continue }
        });
        found
    }
}
