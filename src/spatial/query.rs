//! The traits that the structures answer: [`SpatialQueries`], and [`SpatialUpdates`] of those that change.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{LeafId, NoSuchLeaf, Region, Sweep, Trace, UnsoundBox, UpdateError};
use crate::geometry::ray::Ray;

/// What a visitor wants of the rest of an ordered query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Visit {
    /// Go on to the end.
    Continue,
    /// Go on, but no farther than this: a parameter of a ray, a distance squared. Beyond the present end it changes
    /// nothing.
    Shorten(f32),
    /// Visit nothing more.
    Stop,
}

/// What a visitor of nodes wants of the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Descend {
    /// Go on with the nodes within this one.
    Into,
    /// Go on with what is beside this one.
    Past,
    /// Visit nothing more.
    Stop,
}

/// A box found near a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour<K> {
    /// The key of the box.
    pub key: K,
    /// The distance of the point from the box, squared; zero inside.
    pub distance_squared: f32,
}

/// Queries over a set of boxes, each with a key.
///
/// All queries see the boxes exactly as they were last given, whatever slack a structure keeps inside. The visiting
/// methods are what a structure implements; the others are made of them. All boxes are closed: what touches counts.
pub trait SpatialQueries<K: Copy> {
    /// The number of boxes.
    fn len(&self) -> usize;

    /// Whether there are no boxes.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A box around all boxes, as tight as the structure knows it; `None` if there are none.
    fn bounds(&self) -> Option<Aabb3d>;

    /// The bytes of memory that the structure has allocated, its tables included.
    fn memory(&self) -> usize;

    /// Visits every key with its box, in no promised order.
    fn visit_all(&self, visit: impl FnMut(K, &Aabb3d));

    /// Visits every key whose box the ray enters, with the parameter at which it does, as
    /// [`Ray::aabb_intersection_at`] tells.
    ///
    /// Boxes come roughly from near to far, in no promised order. A box that the ray enters exactly where it was
    /// shortened to is still visited, so that ties do not depend on the structure.
    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit);

    /// Visits what [`visit_ray`](Self::visit_ray) visits, in that order, and tells the way: which nodes or cells were entered,
    /// and which boxes tested there. Slow, and for those who want to look into a structure.
    ///
    /// ```
    /// use bevy::math::{Vec3, bounding::Aabb3d};
    /// use bevy_sightline::{geometry::ray::Ray, spatial::{AabbTree, SpatialQueries, SpatialUpdates}};
    ///
    /// let mut tree = AabbTree::new();
    /// tree.insert_many((0..1000).map(|key| (key, Aabb3d::new(Vec3::X * key as f32 * 3.0, Vec3::ONE))));
    ///
    /// let ray = Ray::new(Vec3::new(30.0, 50.0, 0.0), Vec3::NEG_Y, f32::INFINITY).expect("a direction");
    /// let (first, trace) = tree.trace_closest_box(&ray);
    /// assert_eq!(first.map(|(key, _)| key), Some(10));
    /// println!("{} nodes, and {} boxes in them", trace.nodes().count(), trace.boxes_tested());
    /// ```
    fn trace_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) -> Trace<K>;

    /// Visits every key whose box the moving shape touches, with the parameter at which it first does.
    ///
    /// In the order of [`visit_ray`](Self::visit_ray), and with its way to shorten.
    fn visit_sweep<S: Sweep>(&self, sweep: &S, visit: impl FnMut(K, f32) -> Visit);

    /// Visits every key whose box touches the region, in no promised order.
    fn visit_region<R: Region>(&self, region: &R, visit: impl FnMut(K) -> ControlFlow<()>);

    /// Visits every key whose box is no farther from `point` than `max_distance`, with that distance squared.
    ///
    /// Roughly from near to far, in no promised order; shortened to the square of a distance. Boxes exactly at the limit
    /// are visited: those with `distance² <= max_distance²`, both rounded. Nothing is within a negative distance, nor of a
    /// point that is not finite.
    fn visit_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(K, f32) -> Visit);

    /// Visits every pair of keys whose boxes touch, each pair once, in no promised order.
    fn visit_pairs(&self, visit: impl FnMut(K, K) -> ControlFlow<()>);

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
                Visit::Shorten(t)
            }
            _ => Visit::Continue,
        });
        closest
    }

    /// The first box along the ray, and the parameter at which the ray enters it. Of two at the same parameter the
    /// smaller key wins.
    fn closest_box(&self, ray: &Ray) -> Option<(K, f32)>
    where
        K: Ord,
    {
        let mut closest = None;
        self.visit_ray(ray, |key, t| keep_first(&mut closest, key, t));
        closest
    }

    /// The [`closest_box`](Self::closest_box), and the way to it: see [`trace_ray`](Self::trace_ray).
    fn trace_closest_box(&self, ray: &Ray) -> (Option<(K, f32)>, Trace<K>)
    where
        K: Ord,
    {
        let mut closest = None;
        let trace = self.trace_ray(ray, |key, t| keep_first(&mut closest, key, t));
        (closest, trace)
    }

    /// The first box that the moving shape touches, and the parameter at which it does. Of two at the same parameter
    /// the smaller key wins.
    fn first_touched<S: Sweep>(&self, sweep: &S) -> Option<(K, f32)>
    where
        K: Ord,
    {
        let mut first = None;
        self.visit_sweep(sweep, |key, t| keep_first(&mut first, key, t));
        first
    }

    /// Whether `test` is true for any key whose box the ray enters; stops at the first.
    fn any_hit(&self, ray: &Ray, mut test: impl FnMut(K, &Ray) -> bool) -> bool {
        let mut found = false;
        self.visit_ray(ray, |key, _| {
            found = test(key, ray);
            if found { Visit::Stop } else { Visit::Continue }
        });
        found
    }

    /// The keys of all boxes that touch the region, written over `found`, in no promised order.
    fn find_in_region<R: Region>(&self, region: &R, found: &mut Vec<K>) {
        found.clear();
        self.visit_region(region, |key| {
            found.push(key);
            ControlFlow::Continue(())
        });
    }

    /// The `k` boxes that are nearest to `point`, none farther than `max_distance`, written over `nearest`: from near to
    /// far, and of those at one distance the smaller keys first.
    fn k_nearest(&self, point: Vec3A, k: usize, max_distance: f32, nearest: &mut Vec<Neighbour<K>>)
    where
        K: Ord,
    {
        nearest.clear();
        if k == 0 {
            return;
        }
        self.visit_near(point, max_distance, |key, distance_squared| {
            let new = Neighbour { key, distance_squared };
            let order = |a: &Neighbour<K>| (a.distance_squared, a.key) < (distance_squared, key);
            if nearest.len() == k {
                if !nearest
                    .last()
                    .is_some_and(|last| (distance_squared, key) < (last.distance_squared, last.key))
                {
                    return Visit::Continue;
                }
                nearest.pop();
            }
            // Found from near to far for the most part: the place is close to the end.
            let place = nearest.iter().rposition(order).map_or(0, |before| before + 1);
            nearest.insert(place, new);
            if nearest.len() == k {
                Visit::Shorten(nearest[k - 1].distance_squared)
            } else {
                Visit::Continue
            }
        });
    }

    /// Visits every pair of a key of this structure and one of `other` whose boxes touch, in no promised order.
    fn visit_pairs_with<L: Copy>(&self, other: &impl SpatialQueries<L>, mut visit: impl FnMut(K, L) -> ControlFlow<()>)
    where
        Self: Sized,
    {
        let mut flow = ControlFlow::Continue(());
        other.visit_all(|theirs, aabb| {
            if flow.is_continue() {
                self.visit_region(aabb, |ours| {
                    flow = visit(ours, theirs);
                    flow
                });
            }
        });
    }
}

/// Keeps the first along a ray, by parameter and then by key.
fn keep_first<K: Ord + Copy>(first: &mut Option<(K, f32)>, key: K, t: f32) -> Visit {
    if first.is_none_or(|(k, c)| (t, key) < (c, k)) {
        *first = Some((key, t));
        Visit::Shorten(t)
    } else {
        Visit::Continue
    }
}

/// A structure that changes: leaves come, move and go.
pub trait SpatialUpdates<K: Copy>: SpatialQueries<K> {
    /// Adds a leaf.
    ///
    /// # Errors
    ///
    /// If the box is not [sound](crate::geometry::aabb::Aabb3dExt::is_sound); nothing changes.
    fn insert(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox>;

    /// Adds many leaves, and returns for each its id, or why it was refused. Cheaper than one by one.
    fn insert_many(&mut self, leaves: impl IntoIterator<Item = (K, Aabb3d)>) -> Vec<Result<LeafId, UnsoundBox>> {
        leaves.into_iter().map(|(key, aabb)| self.insert(key, aabb)).collect()
    }

    /// Removes a leaf and returns its key.
    ///
    /// # Errors
    ///
    /// If there is no such leaf.
    fn remove(&mut self, id: LeafId) -> Result<K, NoSuchLeaf>;

    /// Gives a leaf a new box.
    ///
    /// # Errors
    ///
    /// If there is no such leaf, or if the box is not sound: then the old one stays.
    fn update(&mut self, id: LeafId, aabb: Aabb3d) -> Result<(), UpdateError>;

    /// Gives many leaves new boxes, and returns those that were not moved, and why. Cheaper than one by one; of several
    /// boxes for one leaf the last counts.
    fn update_many(&mut self, updates: &[(LeafId, Aabb3d)]) -> Vec<(LeafId, UpdateError)> {
        let mut refused = Vec::new();
        for &(id, aabb) in updates {
            if let Err(why) = self.update(id, aabb) {
                refused.push((id, why));
            }
        }
        refused
    }

    /// Removes all leaves, and keeps the memory.
    fn clear(&mut self);

    /// The key of a leaf, or `None` if there is no such leaf.
    fn key(&self, id: LeafId) -> Option<K>;

    /// The box of a leaf as it was last given, or `None` if there is no such leaf.
    fn aabb(&self, id: LeafId) -> Option<Aabb3d>;
}
