//! Rays at a model.

use bevy::math::{Mat3, Vec3};
use bevy_sightline::geometry::ray::Ray;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{MeshRays, models::Model};
use crate::Effort;

/// How far before the surface rays start that start there, as a fraction of the size of the model.
const OFFSET: f32 = 1e-4;

/// A point before the surface, and the normal there.
pub(crate) struct SurfacePoint {
    position: Vec3,
    normal: Vec3,
}

/// From random points of a sphere around the model through random points of its box.
pub(crate) fn incoherent(model: &Model, n: usize) -> Vec<Ray> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let min = model.positions.iter().fold(Vec3::INFINITY, |min, &p| min.min(p));
    let ray = |_| {
        let origin = model.center + direction(&mut rng) * model.radius * 1.2;
        let inside = Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..=1.0)));
        let target = min + 2.0 * (model.center - min) * inside;
        Ray::new(origin, (target - origin).normalize(), f32::INFINITY).expect("a direction")
    };
    (0..n).map(ray).collect()
}

/// Where rays hit, on the side from which they come: as many as there are rays.
pub(crate) fn surface(model: &Model, rays: &[Ray], hits: &dyn MeshRays) -> Vec<SurfacePoint> {
    let point = |ray: &Ray| {
        let (t, triangle) = hits.closest(ray)?;
        let [a, b, c] = model.corners(triangle);
        let normal = (b - a).cross(c - a).try_normalize()?;
        let normal = normal * -normal.dot(ray.direction().into()).signum();
        Some(SurfacePoint {
            position: Vec3::from(ray.at(t)) + normal * model.radius * OFFSET,
            normal,
        })
    };
    rays.iter().filter_map(point).collect()
}

/// Away from the surface, cosine-weighted.
pub(crate) fn bounces(points: &[SurfacePoint]) -> Vec<Ray> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let ray = |point: &SurfacePoint| {
        let towards = (point.normal + 0.999 * direction(&mut rng)).normalize();
        Ray::new(point.position, towards, f32::INFINITY).expect("a direction")
    };
    points.iter().map(ray).collect()
}

/// From the surface to a light.
pub(crate) fn shadows(model: &Model, points: &[SurfacePoint]) -> Vec<Ray> {
    let light = model.center + Vec3::new(0.8, 0.4, 0.45) * 2.0 * model.radius;
    let ray = |point: &SurfacePoint| Ray::segment(point.position, light).expect("a light off the surface");
    points.iter().map(ray).collect()
}

/// The rays of a picture that the model fills, row by row.
pub(crate) fn camera(model: &Model, effort: Effort) -> Vec<Ray> {
    const WIDTH: usize = super::TURN;
    const HEIGHT: usize = 768;
    let back = Vec3::new(0.35, 0.8, 1.0).normalize();
    let eye = model.center + back * 1.25 * model.radius;
    let right = Vec3::Y.cross(back).normalize();
    let turn = Mat3::from_cols(right, back.cross(right), back);
    let step = match effort {
        Effort::Quick => 32,
        Effort::Full => 4,
    };
    let rows = (0..HEIGHT).step_by(step);
    let pixels = rows.flat_map(|row| (0..WIDTH).map(move |column| [column, row]));
    let ray = |[column, row]: [usize; 2]| {
        let x = column as f32 + 0.5 - WIDTH as f32 / 2.0;
        let y = HEIGHT as f32 / 2.0 - row as f32 - 0.5;
        let towards = turn * Vec3::new(x, y, -(HEIGHT as f32)).normalize();
        Ray::new(eye, towards, f32::INFINITY).expect("a direction")
    };
    pixels.map(ray).collect()
}

fn direction(rng: &mut ChaCha8Rng) -> Vec3 {
    loop {
        let point = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..=1.0)));
        if (1e-4..=1.0).contains(&point.length_squared()) {
            return point.normalize();
        }
    }
}
