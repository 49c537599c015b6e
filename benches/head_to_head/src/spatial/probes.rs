//! The regions that are asked for, as our structures take them and as a user would ask peers for them.

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::ViewFrustum,
};
use bevy_sightline::{geometry::obb::Obb, spatial::Region};

use super::queries::distance_squared;

/// A region as peers without regions are asked for it, by what a user of theirs would write.
pub(crate) trait Probe {
    type Region: Region;

    /// Whether a box that is not [`Apart`](Relation::Apart) touches the region for sure.
    const EXACT: bool;

    fn region(&self) -> &Self::Region;

    /// How the box from `min` to `max` lies to the region.
    fn relation(&self, min: Vec3A, max: Vec3A) -> Relation;

    /// The region, if it is a box: that all peers know.
    fn as_aabb(&self) -> Option<&Aabb3d> {
        None
    }

    /// Whether a leaf touches the region.
    #[inline]
    fn touches(&self, min: Vec3A, max: Vec3A) -> bool {
        self.relation(min, max) != Relation::Apart && (Self::EXACT || self.region().touches(&Aabb3d { min, max }))
    }
}

/// How a box lies to a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// They have no point in common.
    Apart,
    /// They may have.
    Across,
    /// All that is in the box touches the region. Small regions, which contain nothing large, do not look.
    Inside,
}

impl Relation {
    #[inline]
    fn touching(touches: bool) -> Self {
        if touches { Self::Across } else { Self::Apart }
    }
}

impl Probe for Aabb3d {
    type Region = Self;

    const EXACT: bool = true;

    fn region(&self) -> &Self {
        self
    }

    #[inline]
    fn relation(&self, min: Vec3A, max: Vec3A) -> Relation {
        Relation::touching((self.min.cmple(max) & self.max.cmpge(min)).all())
    }

    fn as_aabb(&self) -> Option<&Aabb3d> {
        Some(self)
    }
}

impl Probe for BoundingSphere {
    type Region = Self;

    const EXACT: bool = true;

    fn region(&self) -> &Self {
        self
    }

    #[inline]
    fn relation(&self, min: Vec3A, max: Vec3A) -> Relation {
        let center = self.center;
        Relation::touching(distance_squared(center, min, max) <= self.radius() * self.radius())
    }
}

/// A box that contains many.
pub(crate) struct LargeBox(pub Aabb3d);

impl Probe for LargeBox {
    type Region = Aabb3d;

    const EXACT: bool = true;

    fn region(&self) -> &Aabb3d {
        &self.0
    }

    #[inline]
    fn relation(&self, min: Vec3A, max: Vec3A) -> Relation {
        if (self.0.min.cmple(min) & self.0.max.cmpge(max)).all() {
            Relation::Inside
        } else {
            self.0.relation(min, max)
        }
    }
}

/// What a camera sees.
pub(crate) struct FrustumProbe {
    frustum: ViewFrustum,
    planes: [(Vec3A, f32); 6],
}

impl FrustumProbe {
    pub fn new(frustum: ViewFrustum) -> Self {
        Self {
            frustum,
            planes: frustum
                .half_spaces
                .map(|half_space| (half_space.normal(), half_space.d())),
        }
    }
}

impl Probe for FrustumProbe {
    type Region = ViewFrustum;

    const EXACT: bool = true;

    fn region(&self) -> &ViewFrustum {
        &self.frustum
    }

    #[inline]
    fn relation(&self, min: Vec3A, max: Vec3A) -> Relation {
        against_planes(&self.planes, min, max)
    }
}

/// An oriented box.
pub(crate) struct ObbProbe {
    obb: Obb,
    bounds: Aabb3d,
    planes: [(Vec3A, f32); 6],
}

impl ObbProbe {
    pub fn new(obb: Obb) -> Self {
        let corners = obb.corners();
        let bounds = Aabb3d {
            min: corners.into_iter().fold(corners[0], Vec3A::min),
            max: corners.into_iter().fold(corners[0], Vec3A::max),
        };
        let (axes, center, half) = (obb.axes(), obb.center(), obb.half_size());
        let planes = std::array::from_fn(|i| {
            let axis = axes.col(i / 2) * if i % 2 == 0 { 1.0 } else { -1.0 };
            // A little outward: the exact test decides.
            (
                axis,
                (half[i / 2] - axis.dot(center)) + 1e-5 * (half[i / 2] + center.length()),
            )
        });
        Self { obb, bounds, planes }
    }
}

impl Probe for ObbProbe {
    type Region = Obb;

    const EXACT: bool = false;

    fn region(&self) -> &Obb {
        &self.obb
    }

    #[inline]
    fn relation(&self, min: Vec3A, max: Vec3A) -> Relation {
        if self.bounds.relation(min, max) == Relation::Apart {
            return Relation::Apart;
        }
        Relation::touching(against_planes(&self.planes, min, max) != Relation::Apart)
    }
}

/// How a box lies to the points with `normal · point + d >= 0` for all planes.
#[inline]
fn against_planes(planes: &[(Vec3A, f32); 6], min: Vec3A, max: Vec3A) -> Relation {
    let mut inside = true;
    for &(normal, d) in planes {
        let positive = normal.cmpge(Vec3A::ZERO);
        let signed_distance = |corner: Vec3A| {
            let [x, y, z] = (normal * corner).to_array();
            x + y + z + d
        };
        if signed_distance(Vec3A::select(positive, max, min)) < 0.0 {
            return Relation::Apart;
        }
        inside &= signed_distance(Vec3A::select(positive, min, max)) >= 0.0;
    }
    if inside { Relation::Inside } else { Relation::Across }
}
