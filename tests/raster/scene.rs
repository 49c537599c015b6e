//! Random occluders, and what a ray in double precision says of what they hide.

use bevy::{
    math::{Affine3A, DMat4, DVec2, DVec3, DVec4, Mat4, UVec2, Vec3, Vec3A, bounding::Aabb3d},
    prelude::*,
};
use bevy_sightline::raster::{Faces, MaskedDepthBuffer, OccluderMesh};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::{random_dir, random_rotation};

/// The corners of the faces of a box, counter-clockwise as seen from outside.
const FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

pub struct Occluder {
    shape: Shape,
    world_from_local: Affine3A,
}

enum Shape {
    Box(Aabb3d),
    Mesh {
        mesh: OccluderMesh,
        triangles: Vec<[Vec3; 3]>,
    },
}

impl Occluder {
    fn triangles(&self) -> Vec<[Vec3; 3]> {
        match &self.shape {
            Shape::Mesh { triangles, .. } => triangles.clone(),
            Shape::Box(aabb) => {
                let ends = [aabb.min, aabb.max];
                let corner =
                    |number: usize| Vec3::new(ends[number & 1].x, ends[number >> 1 & 1].y, ends[number >> 2 & 1].z);
                let halves = |face: [usize; 4]| [[face[0], face[1], face[2]], [face[0], face[2], face[3]]];
                FACES
                    .into_iter()
                    .flat_map(halves)
                    .map(|half| half.map(corner))
                    .collect()
            }
        }
    }
}

/// What a camera looks at, and how.
pub struct Scene {
    pub clip_from_world: Mat4,
    pub occluders: Vec<Occluder>,
    /// Corners of the front faces in clip space, which hide what is behind them.
    front: Vec<[DVec4; 3]>,
}

impl Scene {
    pub fn random(rng: &mut ChaCha8Rng) -> Self {
        let clip_from_view = if rng.random_bool(0.25) {
            let half = Vec2::new(rng.random_range(2.0..20.0), rng.random_range(2.0..20.0));
            let far = rng.random_range(30.0..200.0);
            // Reversed, as Bevy has it.
            Mat4::orthographic_rh(-half.x, half.x, -half.y, half.y, far, 0.0)
        } else {
            let near = if rng.random_bool(0.3) {
                rng.random_range(0.5..3.0)
            } else {
                0.1
            };
            Mat4::perspective_infinite_reverse_rh(rng.random_range(0.4..1.8), rng.random_range(0.6..2.2), near)
        };
        // The farther from the origin, the less single precision can tell.
        let eye = random_dir(rng) * 10f32.powf(rng.random_range(0.0..4.0));
        let world_from_view = Mat4::from_rotation_translation(random_rotation(rng), eye);
        let clip_from_world = clip_from_view * world_from_view.inverse();

        let mut occluders = Vec::new();
        for _ in 0..rng.random_range(1..12) {
            let distance = 10f32.powf(rng.random_range(-0.3..1.5));
            let at = Vec3::new(rng.random_range(-0.8..0.8), rng.random_range(-0.8..0.8), -1.0) * distance;
            let size = distance * 10f32.powf(rng.random_range(-1.5..0.3));
            let at = world_from_view.transform_point3(at);
            add(rng, at, size, &mut occluders);
        }
        Self::new(clip_from_world, occluders)
    }

    fn new(clip_from_world: Mat4, occluders: Vec<Occluder>) -> Self {
        let mut front = Vec::new();
        for occluder in &occluders {
            let clip_from_local = clip_from_local(clip_from_world, occluder);
            let is_mirrored = occluder.world_from_local.matrix3.determinant() < 0.0;
            for corners in occluder.triangles() {
                let corners = corners.map(|corner| clip_from_local * corner.as_dvec3().extend(1.0));
                let [a, b, c] = corners.map(xyw);
                if (a.dot(b.cross(c)) > 0.0) != (is_mirrored && matches!(occluder.shape, Shape::Box(_))) {
                    front.push(corners);
                }
            }
        }
        Self {
            clip_from_world,
            occluders,
            front,
        }
    }

    pub fn draw(&self, buffer: &mut MaskedDepthBuffer) {
        for occluder in &self.occluders {
            let clip_from_local = clip_from_local(self.clip_from_world, occluder);
            match &occluder.shape {
                Shape::Box(aabb) => buffer.draw_box(aabb, &clip_from_local),
                Shape::Mesh { mesh, .. } => buffer.draw_mesh(mesh, &clip_from_local, Faces::Front),
            }
        }
    }

    /// A box somewhere behind, beside or before an occluder.
    pub fn random_box(&self, rng: &mut ChaCha8Rng) -> Aabb3d {
        let occluder = &self.occluders[rng.random_range(0..self.occluders.len())];
        let triangles = occluder.triangles();
        let corner = triangles[rng.random_range(0..triangles.len())][rng.random_range(0..3)];
        let near_by = occluder.world_from_local.transform_point3(corner);
        let world_from_clip = self.clip_from_world.as_dmat4().inverse();
        let clip = self.clip_from_world.as_dmat4() * near_by.as_dvec3().extend(1.0);
        let depth = clip.z / clip.w * rng.random_range(0.02..1.1);
        let beside = DVec2::new(rng.random_range(-0.3..0.3), rng.random_range(-0.3..0.3)) * rng.random_range(0.0..1.0);
        let screen = clip.truncate().truncate() / clip.w + beside;
        let at = world_from_clip * DVec4::new(screen.x, screen.y, depth, 1.0);
        let at = (at.truncate() / at.w).as_vec3();
        let distance = at.distance(near_by).max(1e-3);
        let size = distance * 10f32.powf(rng.random_range(-2.5..-0.3));
        let half = Vec3A::new(
            rng.random_range(0.05..1.0),
            rng.random_range(0.05..1.0),
            rng.random_range(0.05..1.0),
        ) * size;
        Aabb3d::new(at, half)
    }

    /// Whether some of a box that does not reach behind the eye is on the screen.
    pub fn is_on_screen(&self, aabb: &Aabb3d) -> bool {
        self.rect(aabb).is_some()
    }

    /// The part of the screen that a box is in, if it is in any.
    fn rect(&self, aabb: &Aabb3d) -> Option<(DVec2, DVec2)> {
        let ends = [aabb.min.as_dvec3(), aabb.max.as_dvec3()];
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for number in 0..8 {
            let end = |axis: usize| ends[number >> axis & 1][axis];
            let corner = self.clip_from_world.as_dmat4() * DVec4::new(end(0), end(1), end(2), 1.0);
            assert!(corner.w > 0.0, "what reaches behind the eye is not hidden");
            let place = corner.truncate().truncate() / corner.w;
            (min, max) = (min.min(place), max.max(place));
        }
        let (min, max) = (min.max(DVec2::NEG_ONE), max.min(DVec2::ONE));
        min.cmple(max).all().then_some((min, max))
    }

    /// A place on the screen, both within -1..1, at which some point of a box can be seen, if one is found among those
    /// that are looked through: some within the box, and some beside every edge of an occluder, to both sides.
    pub fn visible_place(&self, aabb: &Aabb3d, size: UVec2, rng: &mut ChaCha8Rng) -> Option<DVec2> {
        let (min, max) = self.rect(aabb)?;
        let ends = [aabb.min.as_dvec3(), aabb.max.as_dvec3()];
        let world_from_clip = self.clip_from_world.as_dmat4().inverse();
        let front: Vec<&[DVec4; 3]> = self
            .front
            .iter()
            .filter(|corners| may_meet(corners, min, max))
            .collect();
        let is_visible = |place: DVec2| {
            let within = place.cmpge(min).all() && place.cmple(max).all();
            within && self.sees(place, ends, &world_from_clip, &front)
        };
        for _ in 0..24 {
            let share = DVec2::new(rng.random(), rng.random());
            let place = min + (max - min) * share;
            if is_visible(place) {
                return Some(place);
            }
        }
        let pixel = 2.0 / size.as_dvec2();
        for corners in &front {
            for side in 0..3 {
                let (from, to) = (corners[side], corners[(side + 1) % 3]);
                if from.w <= 0.0 || to.w <= 0.0 {
                    continue;
                }
                let [from, to] = [from, to].map(|corner| corner.truncate().truncate() / corner.w);
                let Some((first, last)) = part_within(from, to, min, max) else {
                    continue;
                };
                let across = (to - from).perp().normalize_or_zero();
                for _ in 0..2 {
                    let place = from.lerp(to, rng.random_range(first..=last));
                    for distance in [-0.5, -0.05, -1e-4, 1e-4, 0.05, 0.5] {
                        let place = place + across * pixel * distance;
                        if is_visible(place) {
                            return Some(place);
                        }
                    }
                }
            }
        }
        None
    }

    /// Whether a box is seen at a place of the screen.
    fn sees(&self, place: DVec2, ends: [DVec3; 2], world_from_clip: &DMat4, front: &[&[DVec4; 3]]) -> bool {
        let point = |depth: f64| {
            let point = *world_from_clip * DVec4::new(place.x, place.y, depth, 1.0);
            point.truncate() / point.w
        };
        // From the near plane on, through a point that is deeper.
        let (origin, through) = (point(1.0), point(0.5));
        let direction = through - origin;
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let [a, b] = ends.map(|end| (end[axis] - origin[axis]) / direction[axis]);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        // So short a way through it is rounding.
        if leave <= enter * (1.0 + 1e-9) {
            return false;
        }
        let entry = self.clip_from_world.as_dmat4() * (origin + direction * enter).extend(1.0);
        let depth = entry.z / entry.w;
        if !(0.0..=1.0).contains(&depth) {
            return false;
        }
        !front.iter().any(|corners| {
            depth_at(corners, place).is_some_and(|hides| hides <= 1.0 + 1e-12 && hides >= depth * (1.0 - 1e-9))
        })
    }
}

fn xyw(clip: DVec4) -> DVec3 {
    DVec3::new(clip.x, clip.y, clip.w)
}

/// Whether a triangle may be somewhere in a rectangle of the screen.
fn may_meet(corners: &[DVec4; 3], min: DVec2, max: DVec2) -> bool {
    if corners.iter().any(|corner| corner.w <= 0.0) {
        return true;
    }
    let places = corners.map(|corner| corner.truncate().truncate() / corner.w);
    let least = places[0].min(places[1]).min(places[2]);
    let greatest = places[0].max(places[1]).max(places[2]);
    least.cmple(max + 1e-6).all() && greatest.cmpge(min - 1e-6).all()
}

/// The depth of a triangle at a place of the screen, if it is there and before the eye. Rounding errs to that it is.
fn depth_at(corners: &[DVec4; 3], place: DVec2) -> Option<f64> {
    let [a, b, c] = corners.map(xyw);
    let eye = place.extend(1.0);
    let weights = [eye.dot(b.cross(c)), eye.dot(c.cross(a)), eye.dot(a.cross(b))];
    let scale = a.dot(b.cross(c));
    let weights = weights.map(|weight| weight / scale);
    let slack = 1e-9 * weights.iter().map(|weight| weight.abs()).sum::<f64>();
    // The weights add up to 1 / w.
    if weights.iter().any(|&weight| weight < -slack) || weights.iter().sum::<f64>() <= 0.0 {
        return None;
    }
    Some(
        weights
            .iter()
            .zip(corners)
            .map(|(weight, corner)| weight * corner.z)
            .sum(),
    )
}

/// The part of a line within a rectangle, from 0 at its begin to 1 at its end.
fn part_within(from: DVec2, to: DVec2, min: DVec2, max: DVec2) -> Option<(f64, f64)> {
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for axis in 0..2 {
        let along = to[axis] - from[axis];
        if along.abs() < 1e-12 {
            if from[axis] < min[axis] || from[axis] > max[axis] {
                return None;
            }
            continue;
        }
        let [a, b] = [min, max].map(|end| (end[axis] - from[axis]) / along);
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    (first <= last).then_some((first, last))
}

fn clip_from_local(clip_from_world: Mat4, occluder: &Occluder) -> DMat4 {
    clip_from_world.as_dmat4() * Mat4::from(occluder.world_from_local).as_dmat4()
}

fn add(rng: &mut ChaCha8Rng, at: Vec3, size: f32, occluders: &mut Vec<Occluder>) {
    let rotation = random_rotation(rng);
    let mut extent = || size * 10f32.powf(rng.random_range(-1.5..0.3));
    let half = Vec3A::new(extent(), extent(), extent());
    match rng.random_range(0..5) {
        // A wall of boxes with gaps from nothing to some hundredths.
        0 => {
            let gap = half.x * 10f32.powf(rng.random_range(-6.0..-1.0));
            for number in 0..rng.random_range(2..5) {
                let along = Vec3::X * (number as f32 * (2.0 * half.x + gap));
                let world_from_local = Affine3A::from_rotation_translation(rotation, at + rotation * along);
                let shape = Shape::Box(Aabb3d::new(Vec3A::ZERO, half));
                occluders.push(Occluder {
                    shape,
                    world_from_local,
                });
            }
        }
        1 => {
            let mirror = if rng.random_bool(0.5) { -1.0 } else { 1.0 };
            let scale = Vec3::new(mirror, 1.0, 1.0);
            let world_from_local = Affine3A::from_scale_rotation_translation(scale, rotation, at);
            let shape = Shape::Box(Aabb3d::new(Vec3A::new(0.3, -0.2, 0.1) * size, half));
            occluders.push(Occluder {
                shape,
                world_from_local,
            });
        }
        kind => {
            let mesh = match kind {
                2 => Mesh::from(Torus::new(0.4 * size, size)),
                3 => Sphere::new(size).mesh().ico(rng.random_range(1..4)).unwrap(),
                _ => fence(rng, size),
            };
            let world_from_local = Affine3A::from_rotation_translation(rotation, at);
            occluders.push(Occluder {
                shape: of_mesh(&mesh),
                world_from_local,
            });
        }
    }
}

fn of_mesh(mesh: &Mesh) -> Shape {
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
    let positions: Vec<Vec3> = positions.iter().map(|&at| Vec3::from(at)).collect();
    let indices: Vec<u32> = mesh.indices().unwrap().iter().map(|index| index as u32).collect();
    let triangles: Vec<[u32; 3]> = indices
        .chunks(3)
        .map(|corners| [corners[0], corners[1], corners[2]])
        .collect();
    let mesh = OccluderMesh::new(&positions, &triangles);
    let triangles = triangles
        .into_iter()
        .map(|corners| corners.map(|corner| positions[corner as usize]));
    Shape::Mesh {
        mesh,
        triangles: triangles.collect(),
    }
}

/// Slats with gaps, open like paper and one with another at some corners, with slivers among them.
fn fence(rng: &mut ChaCha8Rng, size: f32) -> Mesh {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    let mut left = -size;
    while left < size {
        let width = size * 10f32.powf(rng.random_range(-3.0..-0.3));
        let first = positions.len() as u32;
        let bend = rng.random_range(-0.2..0.2) * size;
        for (x, y) in [(left, -size), (left + width, -size), (left + width, size), (left, size)] {
            positions.push([x, y, if y > 0.0 { bend } else { 0.0 }]);
        }
        indices.extend([first, first + 1, first + 2, first, first + 2, first + 3]);
        let gap = if rng.random_bool(0.5) {
            0.0
        } else {
            size * 10f32.powf(rng.random_range(-5.0..-0.5))
        };
        left += width + gap;
    }
    Mesh::new(
        bevy::mesh::PrimitiveTopology::TriangleList,
        bevy::asset::RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_indices(bevy::mesh::Indices::U32(indices))
}
