//! Bounding volumes whose kind is chosen at run time.

use bevy::{
    math::{
        Affine3A, Vec3A,
        bounding::{Aabb3d, BoundingSphere},
    },
    reflect::{Reflect, std_traits::ReflectDefault},
};

use super::{Tightness, UnboundablePoints, Volume};
use crate::geometry::{convex_hull::ConvexHull, obb::Obb, ray::Ray};

/// A kind of bounding volume.
///
/// What each is worth, measured on one core of an AMD EPYC: the time of its ray test, the area of it on average over seven
/// models and six primitives as a multiple of that of the hull (how many more rays enter it in vain), and how many times
/// faster rays through the axis-aligned box of a mesh become when it is tested before the triangles.
///
/// | | a ray | area | ball | ring, tilted | box, tilted | rod, tilted |
/// |---|---|---|---|---|---|---|
/// | `Sphere` | 8 ns | 2.9 | 1.15 | 0.97 | 0.97 | 0.97 |
/// | `Aabb` | 4 ns | 1.9 | 1 | 1 | 1 | 1 |
/// | `Obb` | 10 ns | 1.5 | 0.96 | 0.97 | 1.54 | 4.6 |
/// | `Hull`, of 8 to 128 corners | 43 to 260 ns | 1 | 0.05 | 0.48 | 1.5 | 5.0 |
/// | `Hull` of 24 corners at most | | | 0.95 | 0.95 | 1.5 | 4.6 |
///
/// Most models are made along the axes of their space: there the box is as tight as any, costs least, and is the one that
/// a hierarchy of triangles has at its root anyway. So it is the default, and the oriented box is for what is long and
/// slanted. The example `bounding_volumes` measures this for other models.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum BoundingKind {
    /// The smallest [`BoundingSphere`].
    Sphere,
    /// The axis-aligned box, [`Aabb3d`].
    #[default]
    Aabb,
    /// The oriented box, [`Obb`].
    Obb,
    /// The [`ConvexHull`].
    Hull,
}

impl BoundingKind {
    /// The volume of this kind around all `points`, in their space.
    ///
    /// # Errors
    ///
    /// As [`Volume::enclosing`].
    pub fn enclosing(self, points: impl IntoIterator<Item = Vec3A>) -> Result<AnyVolume, UnboundablePoints> {
        Ok(match self {
            Self::Sphere => AnyVolume::Sphere(BoundingSphere::enclosing(points)?),
            Self::Aabb => AnyVolume::Aabb(Aabb3d::enclosing(points)?),
            Self::Obb => AnyVolume::Obb(Obb::enclosing(points)?),
            Self::Hull => AnyVolume::Hull(ConvexHull::enclosing(points)?),
        })
    }
}

/// A bounding volume of any kind; its methods are those of [`Volume`].
#[derive(Clone, Debug, PartialEq)]
pub enum AnyVolume {
    /// A sphere.
    Sphere(BoundingSphere),
    /// An axis-aligned box.
    Aabb(Aabb3d),
    /// An oriented box.
    Obb(Obb),
    /// A convex hull.
    Hull(ConvexHull),
}

impl AnyVolume {
    /// Which kind it is.
    pub fn kind(&self) -> BoundingKind {
        match self {
            Self::Sphere(_) => BoundingKind::Sphere,
            Self::Aabb(_) => BoundingKind::Aabb,
            Self::Obb(_) => BoundingKind::Obb,
            Self::Hull(_) => BoundingKind::Hull,
        }
    }

    /// As [`Volume::transformed_by_affine`]; of the same kind.
    #[must_use]
    pub fn transformed_by_affine(&self, transform: &Affine3A) -> Self {
        match self {
            Self::Sphere(sphere) => Self::Sphere(sphere.transformed_by_affine(transform)),
            Self::Aabb(aabb) => Self::Aabb(aabb.transformed_by_affine(transform)),
            Self::Obb(obb) => Self::Obb(obb.transformed_by_affine(transform)),
            Self::Hull(hull) => Self::Hull(hull.transformed_by_affine(transform)),
        }
    }

    /// As [`Volume::grown`]; of the same kind.
    #[must_use]
    pub fn grown(&self, amount: f32) -> Self {
        match self {
            Self::Sphere(sphere) => Self::Sphere(sphere.grown(amount)),
            Self::Aabb(aabb) => Self::Aabb(aabb.grown(amount)),
            Self::Obb(obb) => Self::Obb(obb.grown(amount)),
            Self::Hull(hull) => Self::Hull(hull.grown(amount)),
        }
    }

    /// As [`Volume::contains_point`].
    pub fn contains_point(&self, point: Vec3A) -> bool {
        match self {
            Self::Sphere(sphere) => sphere.contains_point(point),
            Self::Aabb(aabb) => aabb.contains_point(point),
            Self::Obb(obb) => obb.contains_point(point),
            Self::Hull(hull) => hull.contains_point(point),
        }
    }

    /// As [`Volume::ray_intersection_at`].
    #[inline]
    pub fn ray_intersection_at(&self, ray: &Ray) -> Option<f32> {
        match self {
            Self::Sphere(sphere) => sphere.ray_intersection_at(ray),
            Self::Aabb(aabb) => aabb.ray_intersection_at(ray),
            Self::Obb(obb) => obb.ray_intersection_at(ray),
            Self::Hull(hull) => hull.ray_intersection_at(ray),
        }
    }

    /// As [`Volume::aabb`].
    pub fn aabb(&self) -> Aabb3d {
        match self {
            Self::Sphere(sphere) => sphere.aabb(),
            Self::Aabb(aabb) => aabb.aabb(),
            Self::Obb(obb) => obb.aabb(),
            Self::Hull(hull) => hull.aabb(),
        }
    }

    /// As [`Volume::volume`].
    pub fn volume(&self) -> f32 {
        match self {
            Self::Sphere(sphere) => sphere.volume(),
            Self::Aabb(aabb) => aabb.volume(),
            Self::Obb(obb) => obb.volume(),
            Self::Hull(hull) => hull.volume(),
        }
    }

    /// As [`Volume::surface_area`].
    pub fn surface_area(&self) -> f32 {
        match self {
            Self::Sphere(sphere) => sphere.surface_area(),
            Self::Aabb(aabb) => aabb.surface_area(),
            Self::Obb(obb) => obb.surface_area(),
            Self::Hull(hull) => hull.surface_area(),
        }
    }

    /// As [`Tightness::of`].
    pub fn tightness(&self, hull: &ConvexHull) -> Tightness {
        match self {
            Self::Sphere(sphere) => Tightness::of(sphere, hull),
            Self::Aabb(aabb) => Tightness::of(aabb, hull),
            Self::Obb(obb) => Tightness::of(obb, hull),
            Self::Hull(own) => Tightness::of(own, hull),
        }
    }
}
