//! parry3d: its `TriMesh`.

use bevy::math::{Vec3, Vec3A};
use bevy_sightline::geometry::ray::Ray;
use parry3d::{
    math::Vector,
    partitioning::TraversalAction,
    query::{self, RayCast},
    shape::{CompositeShapeRef, TriMesh},
};

use crate::{
    mesh::{Hit, MeshRays, models::Model, refit::Refit},
    spatial::peers::Slabs,
};

pub(crate) struct Parry {
    mesh: TriMesh,
}

impl Parry {
    pub fn build(model: &Model) -> Self {
        let vertices = model.positions.iter().copied().map(vector).collect();
        Self {
            mesh: TriMesh::new(vertices, model.triangles.clone()).expect("triangles"),
        }
    }
}

impl MeshRays for Parry {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let hit = CompositeShapeRef(&self.mesh).cast_local_ray(&converted(ray), ray.t_max().min(f32::MAX), true)?;
        Some((hit.1, hit.0))
    }

    fn any(&self, ray: &Ray) -> bool {
        let slabs = Slabs::new(ray);
        let parry_ray = converted(ray);
        let mut found = false;
        self.mesh.bvh().traverse(|node| {
            let (min, max) = (node.mins().to_array(), node.maxs().to_array());
            if slabs.enter(Vec3A::from_array(min), Vec3A::from_array(max)) >= ray.t_max() {
                return TraversalAction::Prune;
            }
            let Some(triangle) = node.leaf_data() else {
                return TraversalAction::Continue;
            };
            found = self
                .mesh
                .triangle(triangle)
                .intersects_local_ray(&parry_ray, ray.t_max());
            if found {
                TraversalAction::EarlyExit
            } else {
                TraversalAction::Continue
            }
        });
        found
    }
}

impl Refit for Parry {
    fn refit(&mut self, positions: &[Vec3]) {
        self.mesh.update_vertices(|vertices| {
            for (vertex, &position) in vertices.iter_mut().zip(positions) {
                *vertex = vector(position);
            }
        });
    }
}

fn vector(position: Vec3) -> Vector {
    position.to_array().into()
}

fn converted(ray: &Ray) -> query::Ray {
    query::Ray::new(ray.origin().to_array().into(), ray.direction().to_array().into())
}
