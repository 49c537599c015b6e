//! The planes of a hull: those of its faces, and bevels where these meet so sharply that their rounding would let the
//! planes reach far beyond.

use bevy::math::DVec3;

use super::{
    HullPlane,
    polytope::{Faces, unit_normal},
    simplex::{bounds, farthest},
};
use crate::geometry::{rounding, support::unit, tolerance};

/// The planes around a hull.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Planes {
    /// Those of the faces first, then the bevels.
    pub planes: Vec<HullPlane>,
    /// The plane of each face. Faces that differ from one plane by no more than the rounding share it.
    pub of_face: Vec<u32>,
}

/// Edges whose faces turn by more than 120° are bevelled: the planes of the faces alone would meet at more than twice
/// their rounding from the edge.
const BEVELLED_EDGE: f64 = -0.5;

/// Corners are bevelled unless some direction is within 75° of the normals of all planes there: the planes alone would
/// meet at more than four times their rounding from the corner.
const BEVELLED_CORNER: f64 = 0.25;

/// What planes are laid around.
pub(super) struct Bounded<'a> {
    /// The corners of a convex hull.
    corners: &'a [DVec3],
    /// How far the hull reaches beyond what its corners span.
    margin: f64,
    extent: DVec3,
    /// The largest distance of a corner from the origin, up to a factor of √3.
    magnitude: f64,
}

impl<'a> Bounded<'a> {
    pub fn new(corners: &'a [DVec3], margin: f64) -> Self {
        let (min, max) = bounds(corners);
        Self {
            corners,
            margin,
            extent: max - min,
            magnitude: min.abs().max(max.abs()).element_sum(),
        }
    }

    /// The plane with the unit `normal` through `corner`, which is a farthest one along it.
    ///
    /// The normal turns when it is rounded to `f32`, so that other corners may come out farther; the extent of the hull
    /// says how much.
    fn plane(&self, normal: DVec3, corner: DVec3) -> HullPlane {
        let rounded = normal.as_vec3a();
        let turn = (rounded.as_dvec3() - normal).abs().dot(self.extent);
        let exact = rounded.as_dvec3().dot(corner) + turn + self.margin * (1.0 + f64::from(f32::EPSILON));
        HullPlane {
            normal: rounded,
            offset: rounding::up(exact + tolerance::DOUBLE * self.magnitude),
        }
    }

    /// The plane with the unit `normal` through whichever corner is farthest along it.
    fn supporting_plane(&self, normal: DVec3) -> HullPlane {
        let corner = farthest(self.corners, |corner| corner.dot(normal));
        self.plane(normal, self.corners[corner])
    }

    /// The plane with the unit `normal` of a face, as it was computed from these corners.
    ///
    /// Where a coordinate is so much larger than another that their difference is rounded, the normal of a needle may be
    /// anything, and whichever corner is farthest along it must be looked for.
    fn face_plane(&self, normal: DVec3, corners: &[u32]) -> HullPlane {
        let corner = |index: &u32| self.corners[*index as usize];
        let is_exact = |(a, b): (&u32, &u32)| {
            let (a, b) = (corner(a), corner(b));
            let difference = b - a;
            a + difference == b && b - difference == a
        };
        let next = corners.iter().cycle().skip(1);
        let fan = corners[1..].iter().map(|corner| (&corners[0], corner));
        if corners.iter().zip(next).chain(fan).all(is_exact) {
            self.plane(normal, corner(&corners[0]))
        } else {
            self.supporting_plane(normal)
        }
    }

    /// The box around a point.
    pub fn around_point(&self) -> Planes {
        Planes::without_faces(
            DVec3::AXES
                .iter()
                .flat_map(|&axis| [axis, -axis])
                .map(|n| self.supporting_plane(n)),
        )
    }

    /// The box around a segment: its two ends, and four sides.
    pub fn around_segment(&self) -> Planes {
        let along = unit(self.corners[1] - self.corners[0]);
        let (u, v) = along.any_orthonormal_pair();
        Planes::without_faces([along, -along, u, -u, v, -v].map(|normal| self.supporting_plane(normal)))
    }

    /// The planes around a polygon or a solid.
    pub fn around_faces(&self, faces: &Faces) -> Planes {
        let normals: Vec<DVec3> = (0..faces.len())
            .map(|face| unit_normal(self.corners, faces.corners(face)))
            .collect();
        let (mut planes, of_face) = self.shared_planes(faces, &normals);
        let bevels = self.edge_bevels(faces, &normals);
        planes.extend(bevels.iter().map(|bevel| self.supporting_plane(bevel.normal)));
        planes.extend(
            self.corner_bevels(faces, &normals, &bevels)
                .into_iter()
                .map(|n| self.supporting_plane(n)),
        );
        Planes { planes, of_face }
    }

    /// One plane for all faces around a large one that it fits up to rounding.
    fn shared_planes(&self, faces: &Faces, normals: &[DVec3]) -> (Vec<HullPlane>, Vec<u32>) {
        const NONE: u32 = u32::MAX;
        let thickness = self.margin + tolerance::HULL_FACE * self.magnitude;
        let size = |face: usize| {
            let mut corners = faces.corners(face).iter().map(|&corner| self.corners[corner as usize]);
            let start = corners.next().unwrap_or_default();
            corners.map(|corner| corner.distance_squared(start)).fold(0.0, f64::max)
        };
        let sizes: Vec<f64> = (0..faces.len()).map(size).collect();
        let mut largest_first: Vec<usize> = (0..faces.len()).collect();
        largest_first.sort_unstable_by(|&a, &b| sizes[b].total_cmp(&sizes[a]).then(a.cmp(&b)));

        let mut planes = Vec::new();
        let mut of_face = vec![NONE; faces.len()];
        let mut stack = Vec::new();
        for seed in largest_first {
            if of_face[seed] != NONE {
                continue;
            }
            let number = planes.len() as u32;
            let (normal, start) = (normals[seed], self.corners[faces.corners(seed)[0] as usize]);
            planes.push(self.face_plane(normal, faces.corners(seed)));
            of_face[seed] = number;
            stack.push(seed);
            while let Some(face) = stack.pop() {
                for (_, across) in faces.edges(face) {
                    let depth = |&corner: &u32| normal.dot(start - self.corners[corner as usize]);
                    if of_face[across] == NONE
                        && normals[across].dot(normal) > SHARED_PLANE
                        && faces.corners(across).iter().all(|corner| depth(corner) <= thickness)
                    {
                        of_face[across] = number;
                        stack.push(across);
                    }
                }
            }
        }
        (planes, of_face)
    }

    /// The bevels of the sharp edges: their normals halve the angle between those of the faces.
    fn edge_bevels(&self, faces: &Faces, normals: &[DVec3]) -> Vec<EdgeBevel> {
        let mut bevels = Vec::new();
        for face in 0..faces.len() {
            for (edge, across) in faces.edges(face) {
                let [a, b] = edge.map(|corner| self.corners[corner as usize]);
                if face < across && normals[face].dot(normals[across]) < BEVELLED_EDGE {
                    // Well defined even where the two normals are opposite and have no sum.
                    let normal = unit(unit(b - a).cross(normals[face] - normals[across]));
                    bevels.push(EdgeBevel { edge, normal });
                }
            }
        }
        bevels
    }

    /// The normals of the bevels of the sharp corners: against the sum of the edges there.
    fn corner_bevels(&self, faces: &Faces, normals: &[DVec3], edges: &[EdgeBevel]) -> Vec<DVec3> {
        let mut corners = vec![Corner::default(); self.corners.len()];
        for (face, &normal) in normals.iter().enumerate() {
            for ([a, b], across) in faces.edges(face) {
                let corner = &mut corners[a as usize];
                corner.axis += unit(self.corners[a as usize] - self.corners[b as usize]);
                corner.mean += (normal + normals[across]) * normal.distance(normals[across]);
            }
        }
        for corner in &mut corners {
            (corner.axis, corner.mean) = (unit(corner.axis), unit(corner.mean));
        }
        let on_bevels = || {
            edges
                .iter()
                .flat_map(|bevel| bevel.edge.map(|corner| (corner as usize, bevel.normal)))
        };
        for (corner, normal) in on_bevels() {
            corners[corner].add_hub(normal);
        }
        let on_faces = (normals.iter().enumerate())
            .flat_map(|(face, &normal)| faces.corners(face).iter().map(move |&corner| (corner as usize, normal)));
        for (corner, normal) in on_faces.chain(on_bevels()) {
            corners[corner].see(normal);
        }
        (corners.iter().filter(|corner| corner.is_sharp()))
            .map(|corner| corner.axis)
            .collect()
    }
}

impl Planes {
    fn without_faces(planes: impl IntoIterator<Item = HullPlane>) -> Self {
        Self {
            planes: planes.into_iter().collect(),
            of_face: Vec::new(),
        }
    }
}

struct EdgeBevel {
    edge: [u32; 2],
    normal: DVec3,
}

/// How the normals of the planes at a corner spread.
#[derive(Clone, Default)]
struct Corner {
    /// Against the sum of the edges: at most 90° from every normal.
    axis: DVec3,
    /// The mean of the normals on the way from face to face around the corner.
    mean: DVec3,
    /// The bevels of edges here: two at most, as three turns of 120° would close.
    hubs: [DVec3; 2],
    /// The widest angle between a normal and each of these four, as what the cosine is less than one.
    widest: [f64; 4],
}

impl Corner {
    fn directions(&self) -> [DVec3; 4] {
        [self.axis, self.mean, self.hubs[0], self.hubs[1]]
    }

    fn add_hub(&mut self, normal: DVec3) {
        if let Some(hub) = self.hubs.iter_mut().find(|hub| **hub == DVec3::ZERO) {
            *hub = normal;
        }
    }

    fn see(&mut self, normal: DVec3) {
        let directions = self.directions();
        for (widest, direction) in self.widest.iter_mut().zip(directions) {
            *widest = widest.max(1.0 - normal.dot(direction));
        }
    }

    /// Whether neither the axis nor the mean is near all normals, nor a bevel of an edge at most 105° from all of them,
    /// which does as well because it is itself among the planes.
    fn is_sharp(&self) -> bool {
        let [axis, mean, ..] = self.widest;
        let is_held = |(&hub, &widest): (&DVec3, &f64)| hub != DVec3::ZERO && 1.0 - widest > -BEVELLED_CORNER;
        1.0 - axis.min(mean) < BEVELLED_CORNER
            && !self.hubs.iter().zip(&self.widest[2..]).any(is_held)
            && self.axis != DVec3::ZERO
    }
}

/// Faces that share a plane differ by less than 45°, so that what their planes cut off is not a whole side.
const SHARED_PLANE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The planes once more, as the ray test reads them: eight at a time, coordinate by coordinate, so that one instruction
/// works on several planes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaneLanes {
    pub x: [f32; LANES],
    pub y: [f32; LANES],
    pub z: [f32; LANES],
    /// Widened by the rounding of the ray test, as far as that depends on the plane.
    pub offset: [f32; LANES],
}

/// How many planes are tested at once.
pub(crate) const LANES: usize = 8;

impl PlaneLanes {
    /// The last lanes, where there are no planes left, contain everything.
    pub fn pack(planes: &[HullPlane]) -> Vec<Self> {
        let pack = |planes: &[HullPlane]| {
            let lane = |of: fn(&HullPlane) -> f32, none: f32| std::array::from_fn(|i| planes.get(i).map_or(none, of));
            Self {
                x: lane(|plane| plane.normal.x, 0.0),
                y: lane(|plane| plane.normal.y, 0.0),
                z: lane(|plane| plane.normal.z, 0.0),
                offset: lane(
                    |plane| plane.offset + plane.offset.abs() * tolerance::HULL_RAY,
                    f32::INFINITY,
                ),
            }
        };
        planes.chunks(LANES).map(pack).collect()
    }
}
