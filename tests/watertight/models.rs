//! Closed meshes, with what is inside of them.

use std::{collections::HashMap, f64::consts::TAU};

use bevy::{
    asset::RenderAssetUsages,
    math::{DQuat, DVec3, Vec3},
    mesh::{Indices, Mesh, PrimitiveTopology},
};
use bevy_sightline::mesh::{MeshBvh, TriangleMesh};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::reference::Reference;

/// A closed mesh somewhere in its space.
pub struct Model {
    pub name: String,
    pub bvh: MeshBvh,
    pub reference: Reference,
    /// Of a sphere around the mesh.
    pub center: DVec3,
    pub radius: f64,
    interior: fn(&mut ChaCha8Rng) -> DVec3,
    placed: Placed,
}

/// How a shape was scaled, turned and moved before its vertices were rounded.
#[derive(Clone, Copy)]
pub struct Placed {
    pub scale: DVec3,
    pub rotation: DQuat,
    pub offset: DVec3,
}

impl Placed {
    fn point(&self, point: DVec3) -> DVec3 {
        self.rotation * (point * self.scale) + self.offset
    }
}

impl Model {
    pub fn new(shape: &Shape, placed: Placed) -> Self {
        let positions: Vec<Vec3> = (shape.positions.iter())
            .map(|&point| placed.point(point).as_vec3())
            .collect();
        let farthest = shape.positions.iter().map(|point| point.length());
        Self {
            name: format!("{} at {:e}", shape.name, placed.scale.y),
            bvh: bvh(&positions, &shape.triangles),
            reference: Reference::new(&positions, &shape.triangles),
            center: placed.offset,
            radius: farthest.fold(0.0, f64::max) * placed.scale.y,
            interior: shape.interior,
            placed,
        }
    }

    /// A point well inside.
    pub fn interior_point(&self, rng: &mut ChaCha8Rng) -> DVec3 {
        self.placed.point((self.interior)(rng))
    }
}

pub fn bvh(positions: &[Vec3], triangles: &[[u32; 3]]) -> MeshBvh {
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions.to_vec())
        .with_inserted_indices(Indices::U32(triangles.as_flattened().to_vec()));
    MeshBvh::build(&TriangleMesh::from_mesh(&mesh).expect("triangles"))
}

/// A closed mesh around the origin, in double precision.
pub struct Shape {
    name: &'static str,
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    interior: fn(&mut ChaCha8Rng) -> DVec3,
}

impl Shape {
    pub fn all() -> Vec<Self> {
        vec![
            Self::icosphere("icosphere", 2, |point| point, |rng| in_box(rng, DVec3::splat(0.4))),
            Self::icosphere("displaced sphere", 3, dented, |rng| in_box(rng, DVec3::splat(0.25))),
            // Of an icosphere whose triangles are ten thousand times longer than wide.
            Self::icosphere(
                "needle",
                2,
                |point| point * DVec3::new(1e-4, 1e-4, 1.0),
                |rng| in_box(rng, DVec3::new(3e-5, 3e-5, 0.4)),
            ),
            Self::torus(),
            Self::cube("cube", &[-1.0, 1.0]),
            Self::cube("cube of slivers", &[-1.0, -0.9998, 0.1, 0.9998, 1.0]),
            Self::cube("cube of duplicated vertices", &[-1.0, 0.25, 1.0]).duplicated(),
        ]
    }

    fn icosphere(
        name: &'static str,
        subdivisions: u32,
        place: fn(DVec3) -> DVec3,
        interior: fn(&mut ChaCha8Rng) -> DVec3,
    ) -> Self {
        let golden = (1.0 + 5f64.sqrt()) / 2.0;
        let mut positions: Vec<DVec3> = (0..12)
            .map(|i| {
                let (one, long) = ([-1.0, 1.0][i & 1], [-golden, golden][i >> 1 & 1]);
                [
                    DVec3::new(0.0, one, long),
                    DVec3::new(one, long, 0.0),
                    DVec3::new(long, 0.0, one),
                ][i / 4]
                    .normalize()
            })
            .collect();
        // Three corners at the distance of a side, counter-clockwise.
        let near = |a: DVec3, b: DVec3| a.distance(b) < 1.06;
        let mut triangles = Vec::new();
        for a in 0..12u32 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    let [p, q, r] = [a, b, c].map(|i| positions[i as usize]);
                    if near(p, q) && near(q, r) && near(r, p) {
                        let outward = (q - p).cross(r - p).dot(p) > 0.0;
                        triangles.push(if outward { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }
        for _ in 0..subdivisions {
            let mut middles = HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            triangles = (triangles.iter())
                .flat_map(|&[a, b, c]| {
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
                })
                .collect();
        }
        Self {
            name,
            positions: positions.into_iter().map(place).collect(),
            triangles,
            interior,
        }
    }

    fn torus() -> Self {
        const AROUND: u32 = 24;
        const ACROSS: u32 = 10;
        let position = |i: u32| {
            let (major, minor) = (i / ACROSS, i % ACROSS);
            let [major, minor] = [
                f64::from(major) / f64::from(AROUND),
                f64::from(minor) / f64::from(ACROSS),
            ];
            let from_axis = 1.0 + 0.35 * (minor * TAU).cos();
            let (sin, cos) = (major * TAU).sin_cos();
            DVec3::new(from_axis * cos, from_axis * sin, 0.35 * (minor * TAU).sin())
        };
        let at = |major: u32, minor: u32| major % AROUND * ACROSS + minor % ACROSS;
        let squares = (0..AROUND * ACROSS).flat_map(|i| {
            let (i, j) = (i / ACROSS, i % ACROSS);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        Self {
            name: "torus",
            positions: (0..AROUND * ACROSS).map(position).collect(),
            triangles: squares.collect(),
            interior: |rng| {
                let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
                DVec3::new(cos, sin, 0.0) + in_box(rng, DVec3::splat(0.1))
            },
        }
    }

    /// A cube that is cut at the same coordinates along each axis.
    fn cube(name: &'static str, cuts: &[f64]) -> Self {
        let n = cuts.len() as u32 - 1;
        let mut numbers = HashMap::new();
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for (side, i, j) in (0..6).flat_map(|side| (0..n * n).map(move |k| (side, k / n, k % n))) {
            let mut corner = |i: u32, j: u32| {
                // Turned round on one side of each axis, so that all face outward.
                let mut at = [0; 3];
                let (axis, [i, j], fixed) = if side % 2 == 0 {
                    (side / 2, [i, j], n)
                } else {
                    (side / 2, [j, i], 0)
                };
                at[axis] = fixed;
                at[(axis + 1) % 3] = i;
                at[(axis + 2) % 3] = j;
                *numbers.entry(at).or_insert_with(|| {
                    positions.push(DVec3::from_array(at.map(|k| cuts[k as usize])));
                    positions.len() as u32 - 1
                })
            };
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        Self {
            name,
            positions,
            triangles,
            interior: |rng| in_box(rng, DVec3::splat(0.6)),
        }
    }

    /// With vertices of its own for each triangle.
    fn duplicated(mut self) -> Self {
        let corners = self.triangles.as_flattened().iter();
        self.positions = corners.map(|&vertex| self.positions[vertex as usize]).collect();
        self.triangles = (0..self.positions.len() as u32 / 3)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        self
    }
}

fn dented(point: DVec3) -> DVec3 {
    let dents = (7.0 * point.x).sin() * (5.0 * point.y).cos() + (9.0 * point.z + 1.0).sin() * (11.0 * point.x).cos();
    point * (1.0 + 0.2 * dents)
}

fn in_box(rng: &mut ChaCha8Rng, half_size: DVec3) -> DVec3 {
    half_size * DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..=1.0)))
}
