//! The regions of space that a structure can be asked for, and how a box that stands for many is held against them.

use bevy::math::{
    DVec3, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{HalfSpace, ViewFrustum},
};
use smallvec::SmallVec;

use crate::geometry::{
    aabb::EVERYTHING,
    convex_hull::ConvexHull,
    intersection::{Contains, Frustum, Intersects, polyhedron::Polyhedron},
    obb::Obb,
    rounding,
    support::Support,
    tolerance,
    volume::Volume,
};

/// A region of space: structures find the boxes that touch it.
///
/// | region | a box is found if |
/// |---|---|
/// | [`Aabb3d`] | the two have a point in common |
/// | [`BoundingSphere`] | its squared distance from the centre is at most the square of the radius, both rounded |
/// | [`Obb`], [`ConvexHull`], [`Frustum`] | the two have a point in common, as exactly as [`Intersects`] tells |
/// | [`ViewFrustum`] | it is not wholly behind one of the half-spaces, as culling has it: boxes beside an edge slip in |
///
/// The last is many times cheaper than the one before: a few products decide, for eight boxes at once.
pub trait Region: Outlined {
    /// Whether a box is found.
    fn touches(&self, aabb: &Aabb3d) -> bool;
}

/// What a region is held against whole groups of boxes by.
pub trait Outlined {
    /// The outline of the region. Opaque outside of this crate.
    fn outline(&self) -> Outline;
}

/// A simple shape around a region.
#[derive(Clone, Debug)]
pub struct Outline(pub(crate) OutlineKind);

/// See [`Outline`].
#[derive(Clone, Debug)]
pub(crate) enum OutlineKind {
    /// The region itself.
    Aabb(Aabb3d),
    /// The region itself.
    Sphere(BoundingSphere),
    /// The region itself: all points that no plane excludes.
    HalfSpaces(Planes),
    /// What a box and planes have in common contains the region, up to rounding; the region contains all that is inside
    /// by more than rounding.
    Polytope { bounds: Aabb3d, planes: Planes },
}

pub(crate) type Planes = SmallVec<[Plane; 6]>;

/// The points with `normal · point + d >= 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    pub normal: Vec3A,
    pub d: f32,
    /// The largest magnitude that rounded on the way to `d`.
    pub magnitude: f32,
}

impl Plane {
    /// Whether the two have a point in common. A plane that is NaN excludes nothing.
    ///
    /// In this order of operations, which rounds monotonically: a box around one that is admitted is admitted too.
    fn admits(&self, aabb: &Aabb3d) -> bool {
        let excluded = self.signed_distance(self.vertex(aabb.min, aabb.max)) < 0.0;
        !excluded
    }

    /// Whether every point of the box is inside; then it is for every box in it.
    fn contains(&self, aabb: &Aabb3d) -> bool {
        self.signed_distance(self.vertex(aabb.max, aabb.min)) >= 0.0
    }

    /// The corner that is farthest along the normal, of a box by its least and greatest corner.
    fn vertex(&self, min: Vec3A, max: Vec3A) -> Vec3A {
        Vec3A::select(self.normal.cmpge(Vec3A::ZERO), max, min)
    }

    fn signed_distance(&self, point: Vec3A) -> f32 {
        let [x, y, z] = (self.normal * point).to_array();
        x + y + z + self.d
    }

    /// How far off the distance of any point of the box may be, with what counts as contact.
    fn rounding(&self, aabb: &Aabb3d) -> f32 {
        let [x, y, z] = (self.normal.abs() * aabb.min.abs().max(aabb.max.abs())).to_array();
        tolerance::REGION_PLANE * (x + y + z + self.magnitude) + contact_slack(aabb)
    }
}

/// How close a box may come to count as touching, as a fraction of its largest coordinate.
pub(crate) const CONTACT: f32 = 4.0 * tolerance::DOUBLE as f32;

/// From how far away a box may count as touching another shape, whatever the axis.
pub(crate) fn contact_slack(aabb: &Aabb3d) -> f32 {
    aabb.min.abs().max(aabb.max.abs()).max_element() * CONTACT
}

/// A box that is larger by as much on all sides.
pub(crate) fn with_slack(aabb: &Aabb3d, slack: f32) -> Aabb3d {
    Aabb3d {
        min: aabb.min - slack,
        max: aabb.max + slack,
    }
}

impl Outline {
    /// False only if no box in `aabb` touches the region.
    pub(crate) fn may_touch(&self, aabb: &Aabb3d) -> bool {
        match &self.0 {
            OutlineKind::Aabb(region) => region.touches(aabb),
            OutlineKind::Sphere(region) => region.touches(aabb),
            OutlineKind::HalfSpaces(planes) => planes.iter().all(|plane| plane.admits(aabb)),
            OutlineKind::Polytope { bounds, planes } => {
                with_slack(bounds, contact_slack(aabb)).touches(aabb)
                    && planes.iter().all(|plane| {
                        let farthest = plane.signed_distance(plane.vertex(aabb.min, aabb.max));
                        let excluded = farthest < -plane.rounding(aabb);
                        !excluded
                    })
            }
        }
    }

    /// True only if every box in `aabb` touches the region.
    pub(crate) fn contains(&self, aabb: &Aabb3d) -> bool {
        match &self.0 {
            OutlineKind::Aabb(region) => region.contains(aabb),
            OutlineKind::Sphere(region) => {
                let farthest = (region.center - aabb.min).max(aabb.max - region.center);
                // Covers the rounding of the differences, the squares and their sums.
                farthest.length_squared() <= region.radius() * region.radius() * (1.0 - tolerance::REGION_PLANE)
            }
            OutlineKind::HalfSpaces(planes) => planes.iter().all(|plane| plane.contains(aabb)),
            OutlineKind::Polytope { bounds, planes } => {
                bounds.contains(aabb)
                    && planes.iter().all(|plane| {
                        let nearest = plane.signed_distance(plane.vertex(aabb.max, aabb.min));
                        // Not if both are infinite.
                        nearest > plane.rounding(aabb)
                    })
            }
        }
    }

    /// Whether [`may_touch`](Self::may_touch) is the exact answer.
    pub(crate) fn is_exact(&self) -> bool {
        !matches!(self.0, OutlineKind::Polytope { .. })
    }
}

impl Region for Aabb3d {
    #[inline]
    fn touches(&self, aabb: &Aabb3d) -> bool {
        self.min.cmple(aabb.max).all() && self.max.cmpge(aabb.min).all()
    }
}

impl Outlined for Aabb3d {
    fn outline(&self) -> Outline {
        Outline(OutlineKind::Aabb(*self))
    }
}

impl Region for BoundingSphere {
    #[inline]
    fn touches(&self, aabb: &Aabb3d) -> bool {
        distance_squared(self.center, aabb) <= self.radius() * self.radius()
    }
}

impl Outlined for BoundingSphere {
    fn outline(&self) -> Outline {
        Outline(OutlineKind::Sphere(*self))
    }
}

impl Region for ViewFrustum {
    fn touches(&self, aabb: &Aabb3d) -> bool {
        (self.half_spaces.iter().filter_map(plane)).all(|plane| plane.admits(aabb))
    }
}

impl Outlined for ViewFrustum {
    fn outline(&self) -> Outline {
        Outline(OutlineKind::HalfSpaces(
            self.half_spaces.iter().filter_map(plane).collect(),
        ))
    }
}

/// The squared distance of a point from a box, zero inside.
///
/// In this order of operations, which rounds monotonically: a box around another is never farther.
#[inline]
pub(crate) fn distance_squared(point: Vec3A, aabb: &Aabb3d) -> f32 {
    // A NaN stays one, and nothing is as near as that.
    let offset = Vec3A::ZERO.max((aabb.min - point).max(point - aabb.max));
    let [x, y, z] = (offset * offset).to_array();
    x + y + z
}

/// The square of the distance from a point within which a search looks: below zero, for nothing, where the distance is
/// negative or the point is not finite.
pub(crate) fn limit_squared(point: Vec3A, max_distance: f32) -> f32 {
    if max_distance >= 0.0 && point.is_finite() {
        max_distance * max_distance
    } else {
        -1.0
    }
}

/// The plane of a half-space, unless that is the whole space, as of a far plane at infinity.
fn plane(half_space: &HalfSpace) -> Option<Plane> {
    let (normal, d) = (half_space.normal(), half_space.d());
    let bounds = if normal == Vec3A::ZERO {
        d < 0.0
    } else {
        normal.is_finite() && d < f32::INFINITY
    };
    bounds.then_some(Plane {
        normal,
        d,
        magnitude: d.abs(),
    })
}

impl Region for Frustum {
    fn touches(&self, aabb: &Aabb3d) -> bool {
        self.intersects(aabb)
    }
}

impl Outlined for Frustum {
    fn outline(&self) -> Outline {
        let planes = self.planes().map(|plane| Plane {
            normal: -plane.normal.as_vec3a(),
            d: rounding::up(plane.offset),
            magnitude: plane.offset.abs() as f32,
        });
        let corners = self.corners().map(|corners| {
            Aabb3d::enclosing(corners.map(DVec3::as_vec3a)).map_or(EVERYTHING, |corners| {
                let largest = corners.min.abs().max(corners.max.abs()).max_element();
                corners.grown(largest * tolerance::REGION_PLANE)
            })
        });
        Outline(OutlineKind::Polytope {
            bounds: corners.unwrap_or(EVERYTHING),
            planes: planes.collect(),
        })
    }
}

impl Region for Obb {
    fn touches(&self, aabb: &Aabb3d) -> bool {
        self.intersects(aabb)
    }
}

impl Outlined for Obb {
    fn outline(&self) -> Outline {
        let axes = self.axes();
        let normals = [axes.x_axis, axes.y_axis, axes.z_axis].into_iter();
        let planes = normals.flat_map(|axis| [axis, -axis]).map(|outward| {
            let direction = Vec3::from(outward).as_dvec3();
            (-outward, rounding::up(direction.dot(self.support_point(direction))))
        });
        polytope(self.aabb(), planes)
    }
}

impl Region for ConvexHull {
    fn touches(&self, aabb: &Aabb3d) -> bool {
        self.intersects(aabb)
    }
}

impl Outlined for ConvexHull {
    fn outline(&self) -> Outline {
        let planes = self.planes().iter().map(|plane| (-plane.normal, plane.offset));
        polytope(self.aabb(), planes)
    }
}

/// A region within planes and a box, which is grown by the distance at which shapes apart may count as touching.
///
/// Its faces may be off the planes by the rounding of its largest coordinate: axes are not quite at right angles.
fn polytope(bounds: Aabb3d, planes: impl Iterator<Item = (Vec3A, f32)>) -> Outline {
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let plane = |(normal, d): (Vec3A, f32)| Plane {
        normal,
        d,
        magnitude: d.abs() + largest,
    };
    Outline(OutlineKind::Polytope {
        bounds: bounds.grown(largest * tolerance::REGION_PLANE),
        planes: planes.map(plane).collect(),
    })
}
