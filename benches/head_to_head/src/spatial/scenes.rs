//! The scenes, and where in them is asked.
//!
//! Lengths are metres. Every scene keeps its density as it grows, so that a query finds about as much at any size.

use std::f32::consts::{FRAC_PI_4, TAU};

use bevy::math::{
    Mat4, Quat, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::ViewFrustum,
};
use bevy_sightline::geometry::{obb::Obb, ray::Ray};
use rand::{Rng, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

/// Boxes, whose keys are their indices.
pub(crate) struct Scene {
    /// What cases are named by.
    pub name: &'static str,
    pub boxes: Vec<Aabb3d>,
    pub bounds: Aabb3d,
    /// The radius of a sphere around the middle of a box that touches about ten.
    pub reach: f32,
}

/// How to make each kind of scene of a number of boxes.
pub(crate) type MakeScene = fn(usize) -> Scene;

impl Scene {
    /// Like-sized boxes, one to a cubic metre; a ray goes about seven metres before it meets one.
    pub fn uniform(n: usize) -> Self {
        let mut rng = rng(n, 1);
        let side = (n as f32).cbrt();
        let boxes = (0..n).map(|_| around(vector(&mut rng) * side / 2.0, vector(&mut rng).abs() * 0.2 + 0.05));
        Self::new("uniform", boxes.collect(), 1.2)
    }

    /// Blocks with buildings, and streets with the many small things that lie and move near the ground.
    pub fn city(n: usize) -> Self {
        const BLOCK: f32 = 60.0;
        const STREET: f32 = 14.0;
        let mut rng = rng(n, 2);
        let blocks = (n as f32 / 100.0).sqrt().ceil();
        let mut boxes = Vec::with_capacity(n);
        let mut block = 0;
        while boxes.len() < n {
            let corner = Vec3A::new((block as f32 % blocks).floor(), 0.0, (block as f32 / blocks).floor()) * BLOCK;
            block += 1;
            // The ground, then three by three buildings.
            boxes.push(Aabb3d {
                min: corner,
                max: corner + Vec3A::new(BLOCK, 0.0, BLOCK),
            });
            for lot in 0..9 {
                let lot_size = (BLOCK - STREET) / 3.0;
                let lot = corner + (Vec3A::new((lot % 3) as f32, 0.0, (lot / 3) as f32) + 0.5) * lot_size;
                let half = Vec3A::new(lot_size * 0.45, 0.0, lot_size * 0.45) * rng.random_range(0.6..1.0);
                let tall = if rng.random_bool(0.1) { 80.0 } else { 20.0 };
                boxes.push(Aabb3d {
                    min: (lot - half).with_y(0.0),
                    max: (lot + half).with_y(rng.random_range(4.0..tall)),
                });
            }
            // Along two sides of the block: many things of some centimetres, people, cars, a few trees.
            for _ in 0..90 {
                let along = rng.random_range(0.0..BLOCK);
                let across = BLOCK - STREET + rng.random_range(0.0..STREET);
                let place = if rng.random() {
                    Vec3A::new(along, 0.0, across)
                } else {
                    Vec3A::new(across, 0.0, along)
                };
                let size = 0.1 * rng.random_range(0.0_f32..3.8).exp();
                let half = Vec3A::from_array(std::array::from_fn(|_| rng.random_range(0.3..1.0))) * size / 2.0;
                boxes.push(around(corner + place + Vec3A::Y * half.y, half));
            }
        }
        boxes.truncate(n);
        boxes.shuffle(&mut rng);
        Self::new("city", boxes, 7.0)
    }

    /// Heaps of some hundred like-sized boxes each, far apart.
    pub fn clustered(n: usize) -> Self {
        let mut rng = rng(n, 3);
        let side = 4.0 * (n as f32).cbrt();
        let centers: Vec<Vec3A> = (0..n.div_ceil(300)).map(|_| vector(&mut rng) * side / 2.0).collect();
        let boxes = (0..n).map(|_| {
            let center = centers[rng.random_range(0..centers.len())];
            let normal = vector(&mut rng) + vector(&mut rng) + vector(&mut rng);
            around(center + normal * 3.0, vector(&mut rng).abs() * 0.2 + 0.05)
        });
        Self::new("clustered", boxes.collect(), 1.4)
    }

    /// Sizes from millimetres to a good part of the scene, the smaller the more, and slabs and rods among them.
    pub fn mixed(n: usize) -> Self {
        let mut rng = rng(n, 4);
        let side = (n as f32).cbrt();
        let boxes = (0..n).map(|_| {
            let size = (0.01 * rng.random_range(1e-7_f32..1.0).powf(-0.6)).min(side / 4.0);
            let shape = vector(&mut rng).abs() + 0.02;
            around(vector(&mut rng) * side / 2.0, shape * size)
        });
        Self::new("mixed", boxes.collect(), 1.2)
    }

    /// People in the plane, as close as in a full square.
    pub fn flat_crowd(n: usize) -> Self {
        let mut rng = rng(n, 5);
        let side = (n as f32).sqrt();
        let boxes = (0..n).map(|_| {
            let place = vector(&mut rng) * side / 2.0;
            around(place.with_y(0.9), Vec3A::new(0.25, 0.9, 0.25))
        });
        Self::new("flat", boxes.collect(), 1.5)
    }

    /// A swarm in space.
    pub fn crowd_in_space(n: usize) -> Self {
        let mut rng = rng(n, 6);
        let side = (n as f32).cbrt();
        let boxes = (0..n).map(|_| around(vector(&mut rng) * side / 2.0, Vec3A::splat(0.2)));
        Self::new("volume", boxes.collect(), 1.2)
    }

    fn new(name: &'static str, boxes: Vec<Aabb3d>, reach: f32) -> Self {
        let union = |a: Aabb3d, b: &Aabb3d| Aabb3d {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        };
        let bounds = boxes.iter().fold(boxes[0], union);
        Self {
            name,
            boxes,
            bounds,
            reach,
        }
    }

    /// Rays from anywhere to anywhere.
    pub fn random_rays(&self, count: usize) -> Vec<Ray> {
        let mut rng = rng(count, 10);
        let ray = || Ray::new(self.place(&mut rng), direction(&mut rng), f32::INFINITY);
        std::iter::repeat_with(ray).flatten().take(count).collect()
    }

    /// The rays of tiles of 64 by 32 pixels, row by row, of pictures of 512 by 256 taken in the open.
    pub fn camera_rays(&self, count: usize) -> Vec<Ray> {
        const TILE: [usize; 2] = [64, 32];
        let mut rng = rng(count, 11);
        let mut rays = Vec::with_capacity(count);
        while rays.len() < count {
            let (eye, rotation) = self.view(&mut rng);
            let [left, top] = [rng.random_range(0..512 - TILE[0]), rng.random_range(0..256 - TILE[1])];
            let pixels = (0..TILE[1]).flat_map(|y| (0..TILE[0]).map(move |x| [left + x, top + y]));
            rays.extend(pixels.filter_map(|[x, y]| {
                let on_screen = Vec3::new(x as f32 / 256.0 - 1.0, 0.5 - y as f32 / 256.0, -1.0);
                Ray::new(eye, (rotation * on_screen).normalize(), f32::INFINITY)
            }));
        }
        rays.truncate(count);
        rays
    }

    /// Points near boxes.
    pub fn points(&self, count: usize) -> Vec<Vec3A> {
        let mut rng = rng(count, 12);
        let near = |_| self.middle(&mut rng) + vector(&mut rng) * self.reach / 2.0;
        (0..count).map(near).collect()
    }

    /// Boxes that touch a few of those of the scene, or `scale³` times as many.
    pub fn query_boxes(&self, count: usize, scale: f32) -> Vec<Aabb3d> {
        let half = Vec3A::splat(self.reach / 2.0 * scale);
        self.points(count)
            .into_iter()
            .map(|point| around(point, half))
            .collect()
    }

    /// Spheres that touch about ten boxes.
    pub fn query_spheres(&self, count: usize) -> Vec<BoundingSphere> {
        let sphere = |point| BoundingSphere::new(point, self.reach);
        self.points(count).into_iter().map(sphere).collect()
    }

    /// Oriented boxes that touch about ten boxes: flat ones, at any angle.
    pub fn query_obbs(&self, count: usize) -> Vec<Obb> {
        let mut rng = rng(count, 13);
        let half_size = Vec3A::new(1.6, 0.8, 0.4) * self.reach;
        let obb = |point| Obb::new(point, half_size, rotation(&mut rng));
        self.points(count).into_iter().filter_map(obb).collect()
    }

    /// What cameras in the open see, as far as half the scene reaches.
    pub fn frusta(&self, count: usize) -> Vec<ViewFrustum> {
        let mut rng = rng(count, 14);
        let far = (self.bounds.max - self.bounds.min).max_element() / 2.0;
        let frustum = |_| {
            let (eye, rotation) = self.view(&mut rng);
            let clip_from_view = Mat4::perspective_infinite_reverse_rh(FRAC_PI_4, 16.0 / 9.0, 0.1);
            let view_from_world = Mat4::from_rotation_translation(rotation, eye).inverse();
            let clip_from_world = clip_from_view * view_from_world;
            ViewFrustum::from_clip_from_world_custom_far(&clip_from_world, &eye, &(rotation * Vec3::Z), far)
        };
        (0..count).map(frustum).collect()
    }

    /// A camera that is in no box and looks somewhere, up or down a little.
    fn view(&self, rng: &mut ChaCha8Rng) -> (Vec3, Quat) {
        let inside = |point: Vec3A, aabb: &Aabb3d| point.cmpge(aabb.min).all() && point.cmple(aabb.max).all();
        loop {
            let mut eye = self.place(rng);
            eye.y = self.bounds.min.y + 0.12 * (self.bounds.max.y - self.bounds.min.y);
            if !self.boxes.iter().any(|aabb| inside(eye, aabb)) {
                let around_up = Quat::from_rotation_y(rng.random_range(0.0..TAU));
                return (
                    eye.into(),
                    around_up * Quat::from_rotation_x(rng.random_range(-0.3..0.2)),
                );
            }
        }
    }

    fn place(&self, rng: &mut ChaCha8Rng) -> Vec3A {
        let middle = (self.bounds.min + self.bounds.max) / 2.0;
        middle + vector(rng) * (self.bounds.max - middle)
    }

    fn middle(&self, rng: &mut ChaCha8Rng) -> Vec3A {
        let aabb = self.boxes[rng.random_range(0..self.boxes.len())];
        (aabb.min + aabb.max) / 2.0
    }
}

/// A box by its middle and half its size.
fn around(center: Vec3A, half_size: Vec3A) -> Aabb3d {
    Aabb3d {
        min: center - half_size,
        max: center + half_size,
    }
}

pub(super) fn rng(n: usize, stream: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(n as u64 ^ stream << 32)
}

/// Between -1 and 1 along each axis.
pub(super) fn vector(rng: &mut ChaCha8Rng) -> Vec3A {
    Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
}

pub(super) fn direction(rng: &mut ChaCha8Rng) -> Vec3A {
    rotation(rng) * Vec3A::X
}

fn rotation(rng: &mut ChaCha8Rng) -> Quat {
    let mut normal = || (0..6).map(|_| rng.random_range(-1.0_f32..1.0)).sum();
    Quat::from_xyzw(normal(), normal(), normal(), normal()).normalize()
}
