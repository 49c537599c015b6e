//! What lies within half-spaces, sorted by how surely: what views are culled by.
//!
//! A box that is inside of a plane is so with all that it contains, so that each plane is tested only as far down as it
//! cuts (Assarsson and Möller, *Optimized View Frustum Culling Algorithms for Bounding Boxes*, 2000, §3.3: masking).
//! Below a node that no plane cuts, everything is found as a slice.

use std::ops::ControlFlow;

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::HalfSpace,
};
use smallvec::SmallVec;

use super::{AabbTree, NodeLink};
use crate::{
    geometry::tolerance,
    spatial::{
        lanes::{Boxes, LaneRegion, roundings, signed_distances},
        region::{Plane, Planes},
        simd::{LANES, Simd, Task, dispatch, prefetch},
        traverse,
        wide::{Child, NodeIndex},
    },
};

/// What several half-spaces have in common, seven at most.
#[derive(Clone, Debug)]
pub(crate) struct HalfSpaces {
    planes: Planes,
    ball: Option<Ball>,
}

/// A ball that decides too: it is held against the shape in a box, which is symmetric about its own centre, by the
/// nearest point of the shape along the line between the centres.
#[derive(Clone, Debug)]
struct Ball {
    /// What is in here passes.
    surely_in: BoundingSphere,
    /// How far the ball reaches, and rounding.
    reach: f32,
}

/// What is done with what is found. Rounding is on the safe side of both: what is across may be inside or outside.
pub(crate) trait Sides<K> {
    /// Boxes that are inside of all half-spaces, and in the ball, by more than rounding.
    fn inside(&mut self, keys: &[K]);

    /// A box that is not, nor outside of one of them.
    fn across(&mut self, key: K, aabb: &Aabb3d);
}

/// By each half-space, and the ball, the lanes of the boxes that it cuts.
pub(super) type Cuts = [u32; u8::BITS as usize];

/// A node that is still to be looked into, with what cuts its box, bit by bit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Open {
    node: NodeIndex,
    cut_by: u8,
}

impl HalfSpaces {
    /// The most planes, and the bit of the ball.
    const BALL: usize = 7;

    /// A half-space that is NaN, or infinitely wide, excludes nothing. Whether one with an infinite normal does is not
    /// sure of any box.
    ///
    /// # Panics
    ///
    /// If there are more than seven.
    pub fn new<'a>(half_spaces: impl IntoIterator<Item = &'a HalfSpace>) -> Self {
        let excludes_some = |half_space: &&HalfSpace| {
            let (normal, d) = (half_space.normal(), half_space.d());
            !(normal.is_nan() || d.is_nan() || normal.is_finite() && d == f32::INFINITY)
        };
        let half_spaces = half_spaces.into_iter().filter(excludes_some);
        let planes = half_spaces.map(|half_space| Plane {
            normal: half_space.normal(),
            d: half_space.d(),
            magnitude: half_space.d().abs(),
        });
        let planes: Planes = planes.collect();
        assert!(planes.len() <= Self::BALL, "more half-spaces than there are bits for");
        Self { planes, ball: None }
    }

    /// The same within a ball, as Bevy has it: it is held against the shape in a box, which is symmetric about its own
    /// centre, by the nearest point of the shape along the line between the centres.
    pub fn within(mut self, center: Vec3A, radius: f32) -> Self {
        let rounding = 2.0 * tolerance::REGION_PLANE * (center.abs().max_element() + radius.abs());
        self.ball = Some(Ball {
            // A ball with a radius that is NaN contains nothing surely.
            surely_in: BoundingSphere::new(center, (radius - rounding).max(0.0)),
            reach: radius + rounding,
        });
        self
    }

    /// Whether the centre of a box is inside of all half-spaces by more than rounding, where no ball decides too: then
    /// so is some point of everything that has the same centre.
    pub fn surely_have_center(&self, aabb: &Aabb3d) -> bool {
        let center = (aabb.min + aabb.max) * 0.5;
        let magnitude = aabb.min.abs().max(aabb.max.abs());
        self.ball.is_none()
            && self.planes.iter().all(|plane| {
                let rounding = 2.0 * tolerance::REGION_PLANE * (plane.normal.abs().dot(magnitude) + plane.magnitude);
                plane.normal.dot(center) + plane.d > rounding
            })
    }

    /// Of some lanes of boxes below one that is cut by these, those that are not outside, and the lanes that each cuts.
    #[inline(always)]
    pub(super) fn sort_out<S: Simd>(&self, simd: S, boxes: Boxes, mut lanes: u32, cut_by: u8) -> (u32, Cuts) {
        let mut cut = [0; u8::BITS as usize];
        for (index, plane) in self.planes.iter().enumerate() {
            if cut_by >> index & 1 == 0 {
                continue;
            }
            let rounding = roundings(simd, plane, boxes);
            let farthest = signed_distances::<S, true>(simd, plane, boxes);
            lanes &= !simd.lt(simd.add(farthest, rounding), simd.splat(0.0));
            if lanes == 0 {
                break;
            }
            let nearest = signed_distances::<S, false>(simd, plane, boxes);
            // Also if both are infinite, or either is NaN.
            cut[index] = !simd.lt(rounding, nearest);
        }
        if let Some(ball) = &self.ball
            && cut_by >> Self::BALL & 1 != 0
        {
            lanes &= !ball.is_far_from(simd, boxes);
            cut[Self::BALL] = !ball.surely_in.contains(simd, boxes);
        }
        (lanes, cut)
    }

    /// What cuts the box in a lane, bit by bit.
    #[inline(always)]
    pub(super) fn cut_by(cuts: &Cuts, lane: usize) -> u8 {
        let mut cut_by = 0;
        for (index, cut) in cuts.iter().enumerate() {
            cut_by |= ((cut >> lane & 1) as u8) << index;
        }
        cut_by
    }

    /// The bits of all that cuts.
    pub(super) fn all(&self) -> u8 {
        !(!0u8 << self.planes.len()) | u8::from(self.ball.is_some()) << Self::BALL
    }
}

impl Ball {
    /// The lanes whose boxes have nothing in them that could pass.
    ///
    /// A shape that is symmetric about its centre `c` lies in a box with centre `w` and half extents `h`. With a point
    /// `c + δ` it has `c - δ`, so that `|c - w| + |δ| <= h` along every axis, and the lengths of the two add up to no
    /// more than the half extents do: no point of the shape is nearer, along any line, than `w` but for their sum.
    #[inline(always)]
    fn is_far_from<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let half = simd.splat(0.5);
        let (mut distance_squared, mut reach) = (simd.splat(0.0), simd.splat(self.reach));
        for axis in 0..3 {
            let (min, max) = (simd.load(&boxes.min[axis]), simd.load(&boxes.max[axis]));
            let from_center = simd.sub(
                simd.mul(simd.add(min, max), half),
                simd.splat(self.surely_in.center[axis]),
            );
            distance_squared = simd.add(distance_squared, simd.mul(from_center, from_center));
            reach = simd.add(reach, simd.mul(simd.sub(max, min), half));
        }
        let distance_squared = simd.mul(distance_squared, simd.splat(1.0 - tolerance::REGION_PLANE));
        let is_near = simd.le(distance_squared, simd.mul(reach, reach));
        // A ball that reaches nowhere, or whose reach is NaN, is for the other test to tell.
        if self.reach >= 0.0 { !is_near } else { 0 }
    }
}

impl<K: Copy> AabbTree<K> {
    /// Begins a walk through what has a bit of `mask` and may be inside of half-spaces: goes down until as many nodes
    /// as `parts` are open, each of which can be [walked](Self::walk) by itself, and visits what it finds on the way.
    /// What is found has a bit of the mask, or shares a subtree with what has.
    pub(crate) fn open(
        &self,
        half_spaces: &HalfSpaces,
        mask: u32,
        parts: usize,
        visit: &mut impl Sides<K>,
    ) -> Vec<Open> {
        let mut open: Vec<Open> = Vec::new();
        open.extend(self.root.map(|node| Open {
            node,
            cut_by: half_spaces.all(),
        }));
        while !open.is_empty() && open.len() < parts {
            let mut level = std::mem::take(&mut open);
            for node in level.drain(..) {
                let mut below: SmallVec<[Open; LANES]> = SmallVec::new();
                dispatch(Walk {
                    tree: self,
                    half_spaces,
                    mask,
                    from: node,
                    visit,
                    leave_open: Some(&mut below),
                });
                open.extend(below);
            }
        }
        open
    }

    /// Visits all below an open node.
    pub(crate) fn walk(&self, half_spaces: &HalfSpaces, mask: u32, from: Open, visit: &mut impl Sides<K>) {
        dispatch(Walk {
            tree: self,
            half_spaces,
            mask,
            from,
            visit,
            leave_open: None,
        });
    }

    fn visit_inside(&self, node: NodeIndex, mask: u32, visit: &mut impl Sides<K>) {
        let NodeLink { first, count, .. } = self.links[node as usize];
        if count == 0 {
            let every_leaf = traverse::visit_leaves(&self.nodes, node, mask, |leaf| {
                visit.inside(&[self.leaves.key_at(leaf)]);
                ControlFlow::Continue(())
            });
            debug_assert!(every_leaf.is_continue());
        } else {
            visit.inside(&self.ordered[first as usize..][..count as usize]);
        }
    }
}

struct Walk<'a, K, V> {
    tree: &'a AabbTree<K>,
    half_spaces: &'a HalfSpaces,
    mask: u32,
    from: Open,
    visit: &'a mut V,
    /// Where the nodes below go that are not to be looked into.
    leave_open: Option<&'a mut SmallVec<[Open; LANES]>>,
}

impl<K: Copy, V: Sides<K>> Task for Walk<'_, K, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut stack: SmallVec<[Open; 64]> = SmallVec::new();
        stack.push(self.from);
        while let Some(open) = stack.pop() {
            let node = &self.tree.nodes[open.node as usize];
            let boxes: Boxes = node.into();
            let lanes = simd.with_any_bit(&node.masks, self.mask);
            let (mut lanes, cut) = self.half_spaces.sort_out(simd, boxes, lanes, open.cut_by);
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize % LANES;
                lanes &= lanes - 1;
                let cut_by = HalfSpaces::cut_by(&cut, lane);
                match node.child(lane) {
                    Child::Node(child) if cut_by == 0 => self.tree.visit_inside(child, self.mask, self.visit),
                    Child::Node(child) => {
                        let below = Open { node: child, cut_by };
                        if let Some(leave_open) = &mut self.leave_open {
                            leave_open.push(below);
                        } else {
                            prefetch(&self.tree.nodes[child as usize]);
                            stack.push(below);
                        }
                    }
                    Child::Leaf(leaf) => {
                        let key = self.tree.leaves.key_at(leaf);
                        if cut_by == 0 {
                            self.visit.inside(&[key]);
                        } else {
                            self.visit.across(key, &node.aabb(lane));
                        }
                    }
                }
            }
        }
    }
}
