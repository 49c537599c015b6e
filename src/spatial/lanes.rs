//! Eight boxes at once against what is looked for, with the very answers of the tests of one.
//!
//! Plain loops throughout: a closure that is handed to `map` or `fold` is compiled for the processor that every build
//! runs on, and not for the one that the [`Task`](super::simd::Task) has found.

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};

use super::{
    region::{self, OutlineKind, Plane},
    simd::{LANES, Simd},
    sweep,
    wide::WideNode,
};
use crate::geometry::{
    ray::{Ray, aabb::SlabRay},
    tolerance,
};

/// The bounds of eight boxes along each axis.
pub(crate) type Bounds = [[f32; LANES]; 3];

/// Eight boxes; for points, the least and the greatest corners are the same. What is found in a lane that holds none
/// means nothing.
#[derive(Clone, Copy)]
pub(crate) struct Boxes<'a> {
    pub min: &'a Bounds,
    pub max: &'a Bounds,
}

impl<'a> From<&'a WideNode> for Boxes<'a> {
    #[inline(always)]
    fn from(node: &'a WideNode) -> Self {
        Self {
            min: &node.min,
            max: &node.max,
        }
    }
}

impl Boxes<'_> {
    /// The lanes that hold a box.
    #[inline(always)]
    pub(crate) fn present<S: Simd>(self, simd: S) -> u32 {
        simd.le(simd.load(&self.min[0]), simd.load(&self.max[0]))
    }
}

/// Something that comes closer to boxes the farther it goes: a ray, or a sphere that grows.
pub(crate) trait Approach {
    /// The lanes whose boxes are met at or before `limit`, and where each is met: not negative.
    fn meets<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s);
}

impl<A: Approach> Approach for &A {
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        A::meets(self, simd, boxes, limit)
    }
}

/// A ray that meets a box where it enters it, exactly as [`Ray::aabb_intersection_at`] tells; with boxes that are first
/// grown by a reach if `GROWN`.
pub(crate) struct Entering<const GROWN: bool> {
    ray: SlabRay,
    /// The axes along which the ray enters through the maximum, bit by bit: three flags would be taken apart anew at each
    /// node.
    backward: u32,
    reach: [f32; 3],
}

impl Entering<false> {
    pub(crate) fn new(ray: &Ray) -> Self {
        Self {
            ray: slab_ray(ray),
            backward: ray.backward(),
            reach: [0.0; 3],
        }
    }
}

impl Entering<true> {
    /// For boxes that are [grown](super::sweep::grown) by `reach`.
    pub(crate) fn grown(ray: &Ray, reach: Vec3A) -> Self {
        Self {
            ray: slab_ray(ray),
            backward: ray.backward(),
            reach: reach.to_array(),
        }
    }
}

fn slab_ray(ray: &Ray) -> SlabRay {
    let mut ray = ray.slab_ray();
    // Not -0.0: parameters are compared by their bits.
    ray.t_min += 0.0;
    ray
}

impl<const GROWN: bool> Approach for Entering<GROWN> {
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        let ray = &self.ray;
        let t_min = simd.splat(ray.t_min);
        let (mut enter, mut leave) = (t_min, simd.splat(limit));
        let contact = if GROWN {
            simd.mul(largest_coordinates(simd, boxes), simd.splat(sweep::CONTACT))
        } else {
            t_min
        };
        for axis in 0..3 {
            let is_forward = self.backward >> axis & 1 == 0;
            let (min, max) = (&boxes.min[axis], &boxes.max[axis]);
            let (near, far) = if is_forward { (min, max) } else { (max, min) };
            let (mut near, mut far) = (simd.load(near), simd.load(far));
            if GROWN {
                let outward = if is_forward { -1.0 } else { 1.0 };
                near = grown(simd, near, outward, self.reach[axis], contact);
                far = grown(simd, far, -outward, self.reach[axis], contact);
            }
            let (origin, recip) = (simd.splat(ray.origin[axis]), simd.splat(ray.direction_recip[axis]));
            // A NaN changes nothing: see `Ray::aabb_intersection_at`, which this equals.
            enter = simd.max(simd.mul(simd.sub(near, origin), recip), enter);
            leave = simd.min(simd.mul(simd.sub(far, origin), recip), leave);
        }
        enter = simd.max(simd.mul(enter, simd.splat(1.0 - tolerance::SLAB)), t_min);
        leave = simd.mul(leave, simd.splat(1.0 + tolerance::SLAB));
        let reached = simd.le(enter, leave) & simd.le(enter, simd.splat(limit.min(f32::MAX)));
        (reached, enter)
    }
}

/// Faces of boxes, moved along an axis by a reach, with its rounding, and by a contact: up, or down where `outward` is -1.
#[inline(always)]
fn grown<S: Simd>(simd: S, faces: S::F32s, outward: f32, reach: f32, contact: S::F32s) -> S::F32s {
    let moved = simd.add(faces, simd.splat(outward * reach));
    let magnitude = simd.max(moved, simd.sub(simd.splat(0.0), moved));
    let rounded = simd.add(moved, simd.mul(magnitude, simd.splat(outward * f32::EPSILON)));
    simd.add(rounded, simd.mul(contact, simd.splat(outward)))
}

#[inline(always)]
fn largest_coordinates<S: Simd>(simd: S, boxes: Boxes) -> S::F32s {
    let zero = simd.splat(0.0);
    let mut largest = zero;
    for axis in 0..3 {
        // Of the two, -min and max are no less than min and -max.
        let (min, max) = (simd.load(&boxes.min[axis]), simd.load(&boxes.max[axis]));
        largest = simd.max(largest, simd.max(simd.sub(zero, min), max));
    }
    largest
}

/// A sphere that grows around a point and meets a box at the square of its distance, as
/// [`distance_squared`](super::region::distance_squared) tells.
pub(crate) struct Growing {
    pub center: Vec3A,
}

impl Approach for Growing {
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        let distances = distances_squared(simd, boxes, self.center);
        (simd.le(distances, simd.splat(limit)), distances)
    }
}

#[inline(always)]
fn distances_squared<S: Simd>(simd: S, boxes: Boxes, point: Vec3A) -> S::F32s {
    let zero = simd.splat(0.0);
    let mut sum = zero;
    for axis in 0..3 {
        let at = simd.splat(point[axis]);
        let below = simd.sub(simd.load(&boxes.min[axis]), at);
        let above = simd.sub(at, simd.load(&boxes.max[axis]));
        let offset = simd.max(zero, simd.max(below, above));
        sum = simd.add(sum, simd.mul(offset, offset));
    }
    sum
}

/// A box in every lane.
pub(super) struct Splat<S: Simd> {
    min: [S::F32s; 3],
    max: [S::F32s; 3],
}

impl<S: Simd> Splat<S> {
    #[inline(always)]
    pub fn of(simd: S, aabb: &Aabb3d) -> Self {
        let (min, max) = (aabb.min, aabb.max);
        Self {
            min: [simd.splat(min.x), simd.splat(min.y), simd.splat(min.z)],
            max: [simd.splat(max.x), simd.splat(max.y), simd.splat(max.z)],
        }
    }

    #[inline(always)]
    pub fn of_lane(simd: S, boxes: Boxes, lane: usize) -> Self {
        let Boxes { min, max } = boxes;
        Self {
            min: [
                simd.splat(min[0][lane]),
                simd.splat(min[1][lane]),
                simd.splat(min[2][lane]),
            ],
            max: [
                simd.splat(max[0][lane]),
                simd.splat(max[1][lane]),
                simd.splat(max[2][lane]),
            ],
        }
    }

    /// The lanes of a node whose boxes touch this one.
    #[inline(always)]
    pub fn touching(&self, simd: S, boxes: Boxes) -> u32 {
        let mut lanes = u32::MAX;
        for axis in 0..3 {
            lanes &= simd.le(simd.load(&boxes.min[axis]), self.max[axis]);
            lanes &= simd.le(self.min[axis], simd.load(&boxes.max[axis]));
        }
        lanes
    }
}

/// A region, held against eight boxes at once: the same answers as its [`Outline`] gives one by one.
pub(super) trait LaneRegion {
    /// The lanes whose boxes may have something inside that touches the region.
    fn may_touch<S: Simd>(&self, simd: S, boxes: Boxes) -> u32;

    /// The lanes in whose boxes everything touches the region.
    fn contains<S: Simd>(&self, simd: S, boxes: Boxes) -> u32;
}

impl LaneRegion for Aabb3d {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let mut lanes = u32::MAX;
        for axis in 0..3 {
            lanes &= simd.le(simd.load(&boxes.min[axis]), simd.splat(self.max[axis]));
            lanes &= simd.le(simd.splat(self.min[axis]), simd.load(&boxes.max[axis]));
        }
        lanes
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let mut lanes = u32::MAX;
        for axis in 0..3 {
            lanes &= simd.le(simd.splat(self.min[axis]), simd.load(&boxes.min[axis]));
            lanes &= simd.le(simd.load(&boxes.max[axis]), simd.splat(self.max[axis]));
        }
        lanes
    }
}

impl LaneRegion for BoundingSphere {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let distances = distances_squared(simd, boxes, self.center);
        simd.le(distances, simd.splat(self.radius() * self.radius()))
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let mut sum = simd.splat(0.0);
        for axis in 0..3 {
            let center = simd.splat(self.center[axis]);
            let below = simd.sub(center, simd.load(&boxes.min[axis]));
            let above = simd.sub(simd.load(&boxes.max[axis]), center);
            let farthest = simd.max(below, above);
            sum = simd.add(sum, simd.mul(farthest, farthest));
        }
        let reach = self.radius() * self.radius() * (1.0 - tolerance::REGION_PLANE);
        simd.le(sum, simd.splat(reach))
    }
}

impl LaneRegion for [Plane] {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let mut excluded = 0;
        for plane in self {
            excluded |= simd.lt(signed_distances::<S, true>(simd, plane, boxes), simd.splat(0.0));
        }
        !excluded
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let mut lanes = u32::MAX;
        for plane in self {
            lanes &= simd.le(simd.splat(0.0), signed_distances::<S, false>(simd, plane, boxes));
        }
        lanes
    }
}

/// The signed distances of the corners that are farthest along the normal, or of those that are farthest against it.
#[inline(always)]
pub(super) fn signed_distances<S: Simd, const ALONG: bool>(simd: S, plane: &Plane, boxes: Boxes) -> S::F32s {
    let corner = |axis: usize| {
        if (plane.normal[axis] >= 0.0) == ALONG {
            &boxes.max[axis]
        } else {
            &boxes.min[axis]
        }
    };
    let (x, y, z) = (corner(0), corner(1), corner(2));
    let x = simd.mul(simd.splat(plane.normal.x), simd.load(x));
    let y = simd.mul(simd.splat(plane.normal.y), simd.load(y));
    let z = simd.mul(simd.splat(plane.normal.z), simd.load(z));
    simd.add(simd.add(simd.add(x, y), z), simd.splat(plane.d))
}

/// What the bounds and the planes of a polytope have in common.
pub(super) struct LanePolytope<'a> {
    pub bounds: &'a Aabb3d,
    pub planes: &'a [Plane],
}

impl LaneRegion for LanePolytope<'_> {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let contact = simd.mul(largest_coordinates(simd, boxes), simd.splat(region::CONTACT));
        let mut lanes = u32::MAX;
        for axis in 0..3 {
            let (min, max) = (simd.splat(self.bounds.min[axis]), simd.splat(self.bounds.max[axis]));
            lanes &= simd.le(simd.load(&boxes.min[axis]), simd.add(max, contact));
            lanes &= simd.le(simd.sub(min, contact), simd.load(&boxes.max[axis]));
        }
        for plane in self.planes {
            if lanes & 0xff == 0 {
                break;
            }
            let distances = signed_distances::<S, true>(simd, plane, boxes);
            let rounding = roundings(simd, plane, boxes);
            lanes &= !simd.lt(simd.add(distances, rounding), simd.splat(0.0));
        }
        lanes
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let mut lanes = LaneRegion::contains(self.bounds, simd, boxes);
        for plane in self.planes {
            if lanes & 0xff == 0 {
                break;
            }
            let distances = signed_distances::<S, false>(simd, plane, boxes);
            // Not if both are infinite.
            lanes &= simd.lt(roundings(simd, plane, boxes), distances);
        }
        lanes
    }
}

/// What is inside is what the kind of the outline is; unlike for the others, no empty lane is found.
impl LaneRegion for OutlineKind {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let lanes = match self {
            Self::Aabb(region) => region.may_touch(simd, boxes),
            Self::Sphere(region) => region.may_touch(simd, boxes),
            Self::HalfSpaces(planes) => planes.may_touch(simd, boxes),
            Self::Polytope { bounds, planes } => LanePolytope { bounds, planes }.may_touch(simd, boxes),
        };
        lanes & boxes.present(simd)
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, boxes: Boxes) -> u32 {
        let lanes = match self {
            Self::Aabb(region) => LaneRegion::contains(region, simd, boxes),
            Self::Sphere(region) => region.contains(simd, boxes),
            Self::HalfSpaces(planes) => <[Plane] as LaneRegion>::contains(planes, simd, boxes),
            Self::Polytope { bounds, planes } => LanePolytope { bounds, planes }.contains(simd, boxes),
        };
        lanes & boxes.present(simd)
    }
}

/// How far off the signed distances may be.
#[inline(always)]
pub(super) fn roundings<S: Simd>(simd: S, plane: &Plane, boxes: Boxes) -> S::F32s {
    let zero = simd.splat(0.0);
    let mut sum = simd.splat(plane.magnitude);
    for axis in 0..3 {
        let (min, max) = (simd.load(&boxes.min[axis]), simd.load(&boxes.max[axis]));
        let magnitude = simd.max(simd.max(min, simd.sub(zero, min)), simd.max(max, simd.sub(zero, max)));
        sum = simd.add(sum, simd.mul(simd.splat(plane.normal[axis].abs()), magnitude));
    }
    let rounding = simd.mul(sum, simd.splat(tolerance::REGION_PLANE));
    simd.add(
        rounding,
        simd.mul(largest_coordinates(simd, boxes), simd.splat(region::CONTACT)),
    )
}

/// The lanes of a mask, from the first to the last.
#[inline(always)]
pub(crate) fn lanes_of(mask: u32) -> impl Iterator<Item = usize> {
    let mut rest = mask;
    std::iter::from_fn(move || {
        let lane = (rest != 0).then(|| rest.trailing_zeros() as usize);
        rest &= rest.wrapping_sub(1);
        lane
    })
}
