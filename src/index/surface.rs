//! What rays hit on an entity, placed in the world.

use bevy::{
    asset::AssetId,
    math::{Affine3A, DAffine3, Vec3},
    mesh::Mesh,
};

use super::{PickShape, placement::Placement, pose::PoseId};
use crate::geometry::{
    ray::{Ray, triangle::Backfaces},
    volume::BoundingKind,
};

/// What rays hit on an entity, placed in the world.
#[derive(Clone, Debug)]
pub(super) struct PlacedSurface {
    pub shape: Shape,
    pub backfaces: Backfaces,
    /// If it is a mesh that is posed.
    pub pose: Option<PoseId>,
    placement: Placement,
}

/// What rays hit on an entity, in its local space.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A mesh, whose triangles are tested when the ray enters its volume of this kind.
    Mesh(AssetId<Mesh>, BoundingKind),
    /// The volume of this kind around a mesh; as long as there is none, the mesh.
    Volume(AssetId<Mesh>, BoundingKind),
    Analytic(PickShape),
}

impl PlacedSurface {
    pub fn new(shape: Shape, backfaces: Backfaces, world_from_local: Affine3A) -> Self {
        Self {
            shape,
            backfaces,
            pose: None,
            placement: Placement::new(world_from_local),
        }
    }

    /// Puts the surface somewhere else, while nobody asks for it.
    #[inline]
    pub fn place(&self, world_from_local: &Affine3A) {
        self.placement.put(world_from_local);
    }

    pub fn world_from_local(&self) -> Affine3A {
        self.placement.world_from_local()
    }

    /// In double precision, for [`Ray::transformed_by`]. `None` where the transform flattens the surface.
    #[inline]
    pub fn local_from_world(&self) -> Option<DAffine3> {
        let find = |world_from_local: &Affine3A| {
            inverse(world_from_local).or_else(|| self.inverse_in_plane(*world_from_local))
        };
        self.placement.local_from_world(find)
    }

    /// Of a flat surface across z, the inverse of a transform that does what this does in the plane, and keeps the rest:
    /// it does not matter that a scale for two dimensions has zero for the third.
    fn inverse_in_plane(&self, mut in_plane: Affine3A) -> Option<DAffine3> {
        let (normal, _) = self.plane()?;
        let [x, y] = [in_plane.matrix3.x_axis, in_plane.matrix3.y_axis];
        in_plane.matrix3.z_axis = x.cross(y).normalize();
        (normal == Vec3::Z).then(|| inverse(&in_plane)).flatten()
    }

    /// The plane of the surface in its own space, if it is flat.
    fn plane(&self) -> Option<(Vec3, f32)> {
        match &self.shape {
            Shape::Mesh(..) | Shape::Volume(..) => None,
            Shape::Analytic(shape) => shape.surface().plane(),
        }
    }

    /// The ray in the space of the surface, with the same parameters, if there is such a ray.
    #[inline]
    pub fn ray_to_local(&self, ray: &Ray) -> Option<Ray> {
        ray.transformed_by(&self.local_from_world()?)
    }

    /// A unit normal in world space, for one in the space of the surface: normals transform by the inverse transpose
    /// (PBRT, 4th edition, §3.10.3). Zero if there is no inverse.
    pub fn normal_to_world(&self, normal: Vec3) -> Vec3 {
        self.local_from_world().map_or(Vec3::ZERO, |local_from_world| {
            let world = local_from_world.matrix3.transpose() * normal.as_dvec3();
            world.normalize_or_zero().as_vec3()
        })
    }

    /// The parameter at which a ray in the world meets the plane of the surface, if that is flat.
    ///
    /// Parallel planes keep their order, and one plane is met at one parameter, whatever else the transforms do.
    pub fn plane_parameter(&self, ray: &Ray) -> Option<f64> {
        let (normal, offset) = self.plane()?;
        let local_from_world = self.local_from_world()?;
        let point = self
            .world_from_local()
            .as_daffine3()
            .transform_point3((normal * offset).as_dvec3());
        // Of unit length, so that a scale leaves no trace.
        let normal = (local_from_world.matrix3.transpose() * normal.as_dvec3()).normalize();
        let t = normal.dot(point - Vec3::from(ray.origin()).as_dvec3())
            / normal.dot(Vec3::from(ray.direction()).as_dvec3());
        t.is_finite().then_some(t)
    }

    /// The mesh, if it is one or a volume of one.
    pub fn mesh(&self) -> Option<AssetId<Mesh>> {
        self.shape.mesh()
    }
}

impl Shape {
    /// The mesh, if it is one or a volume of one.
    pub fn mesh(&self) -> Option<AssetId<Mesh>> {
        match *self {
            Self::Mesh(mesh, _) | Self::Volume(mesh, _) => Some(mesh),
            Self::Analytic(_) => None,
        }
    }
}

/// The inverse of `transform`, or `None` if it has none: if the transform is flat.
fn inverse(transform: &Affine3A) -> Option<DAffine3> {
    // In double precision the determinant of the smallest scale that `f32` can hold does not vanish.
    let inverse = transform.as_daffine3().inverse();
    inverse.is_finite().then_some(inverse)
}
