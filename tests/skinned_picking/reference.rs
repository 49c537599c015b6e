//! Skinning and morphing in double precision, written down from the vertex shader, and rays against the result.

use bevy::{
    math::{DMat4, DVec3},
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};

/// The triangles of an entity where they are drawn.
pub struct Reference {
    pub triangles: Vec<[DVec3; 3]>,
    /// How far a vertex may be off that was computed in `f32`: the joint matrix rounds four times, the sum of four of them
    /// four times, and applying it four times; a morph target twice.
    pub slack: f64,
}

impl Reference {
    pub fn of(app: &App, entity: Entity) -> Self {
        let world = app.world();
        let entity = world.entity(entity);
        let meshes = world.resource::<Assets<Mesh>>();
        let mesh = meshes.get(&entity.get::<Mesh3d>().expect("a mesh").0).expect("loaded");
        let place = |entity: Entity| {
            let place = world.get::<GlobalTransform>(entity).expect("a joint");
            Mat4::from(place.affine()).as_dmat4()
        };
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).expect("positions");
        let positions = positions.as_float3().expect("three floats");
        let skin = match (
            entity.get::<SkinnedMesh>(),
            mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX),
            mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT),
        ) {
            (
                Some(skin),
                Some(VertexAttributeValues::Uint16x4(joints)),
                Some(VertexAttributeValues::Float32x4(weights)),
            ) => {
                let bind_poses = world.resource::<Assets<SkinnedMeshInverseBindposes>>();
                let bind_poses = bind_poses.get(&skin.inverse_bindposes).expect("loaded");
                let named = skin.joints.iter().zip(bind_poses.iter());
                let matrices: Vec<[DMat4; 2]> = named
                    .map(|(&joint, bind_pose)| {
                        let (place, bind_pose) = (place(joint), bind_pose.as_dmat4());
                        [place * bind_pose, absolute(place) * absolute(bind_pose)]
                    })
                    .collect();
                Some((matrices, joints, weights))
            }
            _ => None,
        };
        let morph = match entity.get::<MeshMorphWeights>() {
            Some(MeshMorphWeights::Value { weights }) => weights.clone(),
            Some(&MeshMorphWeights::Reference(holder)) => {
                world.get::<MorphWeights>(holder).expect("weights").weights().to_vec()
            }
            None => Vec::new(),
        };
        let targets: &[_] = mesh.morph_targets().map_or(&[], Vec::as_slice);

        let mut magnitude = 0.0f64;
        let drawn: Vec<DVec3> = (0..positions.len())
            .map(|vertex| {
                let mut position = Vec3::from(positions[vertex]).as_dvec3();
                let mut reach = position.abs();
                for (weight, target) in morph.iter().zip(targets.chunks(positions.len())) {
                    let displacement = target[vertex].position.as_dvec3() * f64::from(*weight);
                    position += displacement;
                    reach += displacement.abs();
                }
                let (matrix, size) = match &skin {
                    Some((matrices, joints, weights)) => {
                        let (mut sum, mut size) = (DMat4::ZERO, DMat4::ZERO);
                        for (joint, weight) in joints[vertex].into_iter().zip(weights[vertex]) {
                            let [matrix, absolute] = matrices[usize::from(joint)];
                            sum += matrix * f64::from(weight);
                            size += absolute * f64::from(weight.abs());
                        }
                        (sum, size)
                    }
                    None => (place(entity.id()), absolute(place(entity.id()))),
                };
                magnitude = magnitude.max((size * reach.extend(1.0)).truncate().max_element());
                (matrix * position.extend(1.0)).truncate()
            })
            .collect();
        let indices: Vec<usize> = match mesh.indices() {
            Some(indices) => indices.iter().collect(),
            None => (0..positions.len()).collect(),
        };
        let roundings = 12.0 + 2.0 * morph.len() as f64;
        Self {
            triangles: indices
                .as_chunks::<3>()
                .0
                .iter()
                .map(|triangle| triangle.map(|vertex| drawn[vertex]))
                .collect(),
            // In every coordinate, so that the distance is up to √3 times as large.
            slack: roundings * f64::from(f32::EPSILON) / 2.0 * magnitude * 3.0f64.sqrt(),
        }
    }

    /// Checks what a ray has hit, whichever way the triangles face: the number of a triangle, and its distance.
    ///
    /// The ray must be on that triangle there, up to rounding, and no triangle may be nearer that it passes through by more
    /// than rounding; so may none at all if it has hit nothing.
    pub fn check(&self, ray: Ray3d, hit: Option<(usize, f64)>) {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let rounding = |distance: f64| {
            let of_ray = 8.0 * f64::from(f32::EPSILON) * (distance.abs() + origin.length());
            16.0 * self.slack + of_ray
        };
        if let Some((triangle, distance)) = hit {
            let off = distance_to_triangle(self.triangles[triangle], origin + direction * distance);
            let allowed = rounding(distance);
            assert!(
                off <= allowed,
                "{ray:?} is {off:e} off triangle {triangle}, {allowed:e} allowed"
            );
        }
        for (number, &[a, b, c]) in self.triangles.iter().enumerate() {
            let normal = (b - a).cross(c - a);
            let speed = direction.dot(normal);
            let distance = (a - origin).dot(normal) / speed;
            if !(distance > 0.0 && distance.is_finite()) {
                continue;
            }
            // What moves across the plane by one part in rounding moves along the ray by so much more.
            let error = rounding(distance) * normal.length() / speed.abs();
            if hit.is_some_and(|(_, nearest)| nearest <= distance + error) || distance <= error {
                continue;
            }
            let point = origin + direction * distance;
            let inside = |from: DVec3, to: DVec3| normal.dot((to - from).cross(point - from)) / (to - from).length();
            let inside = inside(a, b).min(inside(b, c)).min(inside(c, a)) / normal.length();
            assert!(
                inside <= error,
                "{ray:?} hits triangle {number} at {distance}, not {hit:?}"
            );
        }
    }
}

/// How far a point is from a triangle.
fn distance_to_triangle([a, b, c]: [DVec3; 3], point: DVec3) -> f64 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let edges = [(a, b), (b, c), (c, a)];
    if edges
        .iter()
        .all(|&(from, to)| normal.dot((to - from).cross(point - from)) >= 0.0)
    {
        return normal.dot(point - a).abs();
    }
    let to_edge = edges.map(|(from, to)| {
        let along = (point - from).dot(to - from) / (to - from).length_squared();
        point.distance(from.lerp(to, along.clamp(0.0, 1.0)))
    });
    to_edge.into_iter().fold(f64::INFINITY, f64::min)
}

fn absolute(matrix: DMat4) -> DMat4 {
    DMat4::from_cols_array(&matrix.to_cols_array().map(f64::abs))
}

/// The box around everything drawn.
pub fn bounds(triangles: &[[DVec3; 3]]) -> (DVec3, DVec3) {
    let corners = triangles.iter().flatten();
    corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), corner| {
        (min.min(*corner), max.max(*corner))
    })
}
