//! What a ray may meet and what it must meet, in double precision.
//!
//! All is seen along the ray: the axes are permuted and sheared so that it runs along z through the origin, as Woop,
//! Benthin and Wald do it (*Watertight Ray/Triangle Intersection*, 2013), and every edge has a side of the ray, the sign
//! of its edge function.
//!
//! # What rounding may do
//!
//! With u = 2⁻²⁴, o the start of the ray in the space of the mesh and R the largest coordinate of a vertex seen from
//! there, a test in `f32` knows a vertex to within η in x and y:
//!
//! - the start is rounded when it is taken to the mesh, u·|o|, and a vertex when the start is subtracted, u·R;
//! - the shear is a quotient of two rounded coordinates, 3u, and is multiplied with a depth that is rounded as above and
//!   again by the product: 5u·R + u·|o|; the difference rounds once more, 2u·R.
//!
//! So η = u·(8R + 2|o|), of which a quarter more is allowed here: [`ETA`]. The sign of an edge function of the rounded
//! vertices is exact, so that the test in `f32` decides for a mesh whose vertices are moved by up to η, all triangles
//! alike: a closed mesh is still closed. An edge whose function stays away from zero wherever its ends are moved so is
//! *certain*.
//!
//! # What must be
//!
//! - A triangle with certain edges of both signs is not met, wherever its vertices are moved so: it is *out*, and must not
//!   be reported. So is one that is to one side of the ray with all its vertices.
//! - The other triangles are gathered in clusters, across edges that are not certain. The boundary of a cluster keeps
//!   away from the ray: it consists of certain edges, and of edges of triangles that are out. So the degree of the
//!   cluster, which is how many of its triangles the ray meets from the front less how many from behind, is the same for
//!   the true mesh and the moved one. If it is not zero, one of the triangles **must** be hit: any of them, at an edge or
//!   a vertex. If it is zero, the ray passes close to a silhouette, and may hit or not. The degree is counted for a ray
//!   that is moved aside by a random eighth of η, where no edge function is zero.
//! - The parameter is that of a point of the triangle within ρ of the ray: see [`Reference::parameters`].

use std::collections::HashMap;

use bevy::math::{DVec3, Vec3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// The unit roundoff of `f32`.
const U: f64 = 1.0 / (1u64 << 24) as f64;

/// η is `U * (ETA[0] * R + ETA[1] * |o|)`.
const ETA: [f64; 2] = [10.0, 2.5];

/// The coordinates of the corners of a triangle.
type Corners = [[f64; 3]; 3];

/// A closed mesh.
pub struct Reference {
    /// All x, then all y, then all z.
    vertices: [Vec<f64>; 3],
    /// From the smaller number to the larger.
    edges: Vec<[u32; 2]>,
    triangles: Vec<Triangle>,
    /// The two triangles of each edge.
    beside: Vec<[u32; 2]>,
}

struct Triangle {
    vertices: [u32; 3],
    /// Opposite of each vertex, and the sign of its function as seen by the triangle.
    edges: [(u32, f64); 3],
}

/// What a ray may meet, and must.
pub struct Verdict {
    /// All triangles that are not out, but those behind the start.
    pub may: Vec<May>,
    /// The clusters that must be hit.
    pub must: Vec<Must>,
}

/// A triangle that may be hit.
#[derive(Debug)]
pub struct May {
    pub triangle: u32,
    /// Whether it may be seen from the front.
    pub front: bool,
    /// Within which the parameter is.
    pub parameters: [f64; 2],
    /// Within which the point that the barycentric coordinates tell is to the ray, seen along it; infinite where the ray
    /// sees the triangle edge-on.
    pub offset: f64,
    corners: Corners,
}

impl May {
    /// How far the point with these barycentric coordinates is from the ray, seen along it.
    pub fn offset_of(&self, barycentrics: Vec3) -> f64 {
        let weights = barycentrics.as_dvec3().to_array();
        let coordinate = |axis: usize| -> f64 {
            let sum: f64 = (0..3).map(|i| weights[i] * self.corners[i][axis]).sum();
            sum.abs()
        };
        coordinate(0).max(coordinate(1))
    }
}

/// A cluster that must be hit.
#[derive(Debug)]
pub struct Must {
    /// Front faces less back faces.
    pub degree: i32,
    /// No later than which it is hit.
    pub t_max: f64,
}

/// What is kept from ray to ray.
#[derive(Default)]
pub struct Scratch {
    seen: [Vec<f64>; 3],
    /// To which sides of the ray a vertex is more than η away.
    sides: Vec<u8>,
    /// The signs of the functions of the edges of all triangles that were not left out at once; zero if not certain.
    signs: Vec<f64>,
    clusters: Vec<u32>,
}

impl Reference {
    /// # Panics
    ///
    /// If the mesh is not closed, where vertices at one place are one vertex.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let mut numbers = HashMap::new();
        let mut vertices: [Vec<f64>; 3] = Default::default();
        let welded: Vec<u32> = (positions.iter())
            .map(|position| {
                *numbers
                    .entry(position.to_array().map(|x| (x + 0.0).to_bits()))
                    .or_insert_with(|| {
                        (0..3).for_each(|axis| vertices[axis].push(position[axis].into()));
                        vertices[0].len() as u32 - 1
                    })
            })
            .collect();
        let (mut edges, mut beside) = (Vec::new(), Vec::new());
        let mut numbers = HashMap::new();
        let triangles: Vec<Triangle> = (0..)
            .zip(triangles)
            .map(|(number, triangle)| {
                let vertices = triangle.map(|vertex| welded[vertex as usize]);
                let edges = [1, 2, 0].map(|i| {
                    let (from, to) = (vertices[i], vertices[(i + 1) % 3]);
                    let ends = [from.min(to), from.max(to)];
                    let edge = *numbers.entry(ends).or_insert_with(|| {
                        edges.push(ends);
                        beside.push([u32::MAX; 2]);
                        edges.len() - 1
                    });
                    let side = usize::from(from > to);
                    assert_eq!(beside[edge][side], u32::MAX, "one triangle to each side of an edge");
                    beside[edge][side] = number;
                    (edge as u32, if from < to { -1.0 } else { 1.0 })
                });
                Triangle { vertices, edges }
            })
            .collect();
        assert!(
            beside.as_flattened().iter().all(|&triangle| triangle != u32::MAX),
            "a closed mesh"
        );
        Self {
            vertices,
            edges,
            triangles,
            beside,
        }
    }

    pub fn edge(&self, rng: &mut ChaCha8Rng) -> [DVec3; 2] {
        self.edges[rng.random_range(0..self.edges.len())].map(|vertex| self.vertex(vertex))
    }

    pub fn triangle(&self, rng: &mut ChaCha8Rng) -> [DVec3; 3] {
        let triangle = &self.triangles[rng.random_range(0..self.triangles.len())];
        triangle.vertices.map(|vertex| self.vertex(vertex))
    }

    fn vertex(&self, vertex: u32) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| self.vertices[axis][vertex as usize]))
    }

    /// What the ray may meet, and must, after its start.
    pub fn verdict(&self, origin: DVec3, direction: DVec3, rng: &mut ChaCha8Rng, scratch: &mut Scratch) -> Verdict {
        let kz = direction.abs().max_position();
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        if direction[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        let z_to_t = 1.0 / direction[kz];
        let reach = self.look(origin, direction, [kx, ky, kz], scratch);
        let eta = U * (ETA[0] * reach + ETA[1] * origin.abs().max_element());
        self.find_sides(eta, scratch);
        let mut may = Vec::new();
        for number in 0..self.triangles.len() {
            if self.is_aside(number, scratch) {
                continue;
            }
            self.find_signs(number, eta, scratch);
            if !self.is_out(number, &scratch.signs) {
                may.push(self.parameters(number, z_to_t, eta, reach, scratch));
            }
        }
        let must = self.clusters(&may, eta, rng, scratch);
        let ahead = may.into_iter().filter(|may| may.parameters[1] >= 0.0);
        Verdict {
            may: ahead.collect(),
            must,
        }
    }

    /// Shears all vertices, and tells the largest coordinate as seen from the origin.
    fn look(&self, origin: DVec3, direction: DVec3, [kx, ky, kz]: [usize; 3], scratch: &mut Scratch) -> f64 {
        let (sx, sy) = (direction[kx] / direction[kz], direction[ky] / direction[kz]);
        let [xs, ys, zs] = &mut scratch.seen;
        let count = self.vertices[0].len();
        for seen in [&mut *xs, ys, zs] {
            seen.resize(count, 0.0);
        }
        let mut reach = 0.0f64;
        let (from_x, from_y, from_z) = (&self.vertices[kx], &self.vertices[ky], &self.vertices[kz]);
        for i in 0..count {
            let (x, y, z) = (from_x[i] - origin[kx], from_y[i] - origin[ky], from_z[i] - origin[kz]);
            reach = reach.max(x.abs()).max(y.abs()).max(z.abs());
            (xs[i], ys[i], zs[i]) = (x - sx * z, y - sy * z, z);
        }
        reach
    }

    fn find_sides(&self, eta: f64, scratch: &mut Scratch) {
        let Scratch {
            seen: [xs, ys, _],
            sides,
            ..
        } = scratch;
        sides.clear();
        let side = |(&x, &y): (&f64, &f64)| {
            u8::from(x > eta) | u8::from(x < -eta) << 1 | u8::from(y > eta) << 2 | u8::from(y < -eta) << 3
        };
        sides.extend(xs.iter().zip(&*ys).map(side));
    }

    /// Whether all of the triangle is to one side of the ray, which is out as well.
    fn is_aside(&self, number: usize, scratch: &Scratch) -> bool {
        let [a, b, c] = self.triangles[number]
            .vertices
            .map(|vertex| scratch.sides[vertex as usize]);
        a & b & c != 0
    }

    fn find_signs(&self, number: usize, eta: f64, scratch: &mut Scratch) {
        scratch.signs.resize(self.edges.len(), 0.0);
        let [xs, ys, _] = &scratch.seen;
        for (edge, _) in self.triangles[number].edges {
            let [p, q] = self.edges[edge as usize].map(|vertex| vertex as usize);
            let function = xs[p] * ys[q] - ys[p] * xs[q];
            let rounding = eta * (xs[p].abs() + ys[p].abs() + xs[q].abs() + ys[q].abs()) + 2.0 * eta * eta;
            let certain = function.abs() > rounding;
            scratch.signs[edge as usize] = if certain { function.signum() } else { 0.0 };
        }
    }

    fn is_out(&self, number: usize, signs: &[f64]) -> bool {
        let [a, b, c] = self.triangles[number]
            .edges
            .map(|(edge, sign)| sign * signs[edge as usize]);
        a.min(b).min(c) < 0.0 && a.max(b).max(c) > 0.0
    }

    fn seen(&self, number: usize, scratch: &Scratch) -> Corners {
        let [xs, ys, zs] = &scratch.seen;
        self.triangles[number].vertices.map(|vertex| {
            let vertex = vertex as usize;
            [xs[vertex], ys[vertex], zs[vertex]]
        })
    }

    /// The parameters at which the triangle may be reported.
    ///
    /// The test weights the depths of the corners by their edge functions. These are rounded by up to 4u·M² each, where M
    /// is the largest coordinate of a corner in x and y. Weights wᵢ with Σwᵢvᵢ = 0 that are off by eᵢ give a point that is
    /// off by Σeᵢvᵢ / Σwᵢ, no more than 12u·M³ / |det|; and the vertices are off by η. So the depth is that of a point of
    /// the triangle within ρ = η + 12u·M³ / |det| of the ray: the depth at the ray, give or take ρ times the slope, and
    /// within the extent of the triangle. Depths are rounded by η at most, and by 16u·R when they are weighted, added up
    /// and made a parameter.
    fn parameters(&self, number: usize, z_to_t: f64, eta: f64, reach: f64, scratch: &Scratch) -> May {
        let corners @ [a, b, c] = self.seen(number, scratch);
        let [bx, by, bz]: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let [cx, cy, cz]: [f64; 3] = std::array::from_fn(|i| c[i] - a[i]);
        let det = bx * cy - cx * by;
        let size = corners
            .iter()
            .flat_map(|v| [v[0].abs(), v[1].abs()])
            .fold(0.0, f64::max)
            + eta;
        let det_error = 12.0 * (eta * size + U * size * size);
        let mut depths = [a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2])];
        let mut offset = f64::INFINITY;
        if det.abs() > 2.0 * det_error {
            offset = eta + 12.0 * U * size.powi(3) / (det.abs() - det_error);
            let slope = [(bz * cy - cz * by) / det, (bx * cz - cx * bz) / det];
            let depth = a[2] - slope[0] * a[0] - slope[1] * a[1];
            let about = offset * (slope[0].abs() + slope[1].abs());
            let within = [depths[0].max(depth - about), depths[1].min(depth + about)];
            if within[0] <= within[1] {
                depths = within;
            }
        }
        let rounding = eta + 16.0 * U * reach;
        let [near, far] = [(depths[0] - rounding) * z_to_t, (depths[1] + rounding) * z_to_t];
        let back = self.triangles[number]
            .edges
            .iter()
            .any(|&(edge, sign)| sign * scratch.signs[edge as usize] < 0.0);
        May {
            triangle: number as u32,
            front: !back,
            parameters: [near.min(far), near.max(far)],
            // The weights are rounded to f32 when they are told.
            offset: offset + 4.0 * U * size,
            corners,
        }
    }

    /// The clusters of degree other than zero that lie after the start.
    fn clusters(&self, may: &[May], eta: f64, rng: &mut ChaCha8Rng, scratch: &mut Scratch) -> Vec<Must> {
        let mut clusters = std::mem::take(&mut scratch.clusters);
        clusters.clear();
        clusters.extend(0..may.len() as u32);
        let place = |triangle: u32| may.binary_search_by_key(&triangle, |may| may.triangle).ok();
        // Few triangles: the smaller number goes on across the edges until nothing changes.
        loop {
            let mut changed = false;
            for (at, triangle) in may.iter().enumerate() {
                for (edge, _) in self.triangles[triangle.triangle as usize].edges {
                    if scratch.signs[edge as usize] != 0.0 {
                        continue;
                    }
                    for other in self.beside[edge as usize].into_iter().filter_map(place) {
                        let least = clusters[at].min(clusters[other]);
                        changed |= clusters[at] != clusters[other];
                        clusters[at] = least;
                        clusters[other] = least;
                    }
                }
            }
            if !changed {
                break;
            }
        }
        let mut must = Vec::new();
        for cluster in 0..may.len() as u32 {
            let members = || {
                (may.iter().zip(&clusters))
                    .filter(|&(_, &of)| of == cluster)
                    .map(|(may, _)| may)
            };
            if members().next().is_none() || members().any(|may| may.parameters[0] <= 0.0) {
                continue;
            }
            let degree = self.degree(members, eta, rng, scratch);
            if degree != 0 {
                let t_max = members().map(|may| may.parameters[1]).fold(0.0, f64::max);
                must.push(Must { degree, t_max });
            }
        }
        scratch.clusters = clusters;
        must
    }

    /// How many of the triangles a ray close by meets from the front, less how many from behind.
    fn degree<'a, I: Iterator<Item = &'a May>>(
        &self,
        members: impl Fn() -> I,
        eta: f64,
        rng: &mut ChaCha8Rng,
        scratch: &Scratch,
    ) -> i32 {
        'aside: loop {
            let aside = [
                rng.random_range(-0.125..0.125) * eta,
                rng.random_range(-0.125..0.125) * eta,
            ];
            let mut degree = 0;
            for may in members() {
                let mut sides = [0.0; 3];
                for (side, (edge, sign)) in sides.iter_mut().zip(self.triangles[may.triangle as usize].edges) {
                    let [p, q] = self.edges[edge as usize].map(|vertex| {
                        let vertex = vertex as usize;
                        [scratch.seen[0][vertex] - aside[0], scratch.seen[1][vertex] - aside[1]]
                    });
                    let along = [q[0] - p[0], q[1] - p[1]];
                    let function = p[0] * along[1] - p[1] * along[0];
                    let magnitude = (p[0] * along[1]).abs() + (p[1] * along[0]).abs();
                    // An edge that is seen as a point bounds triangles that are seen as lines, which nothing meets.
                    if magnitude > 0.0 && function.abs() <= 4.0 * f64::EPSILON * magnitude {
                        continue 'aside;
                    }
                    *side = sign * function;
                }
                degree += i32::from(sides.iter().all(|&side| side > 0.0));
                degree -= i32::from(sides.iter().all(|&side| side < 0.0));
            }
            return degree;
        }
    }
}
