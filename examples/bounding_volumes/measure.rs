//! The volumes of a subject, and their figures.

use std::{
    f32::consts::TAU,
    fmt,
    hint::black_box,
    time::{Duration, Instant},
};

use bevy::{
    math::{Vec3A, bounding::BoundingSphere},
    prelude::*,
};
use bevy_sightline::geometry::{
    convex_hull::ConvexHull,
    obb::Obb,
    ray::Ray,
    volume::{AnyVolume, BoundingKind, Tightness, UnboundablePoints, Volume},
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// All kinds, from the loosest to the tightest, and what they are called.
pub const KINDS: [(BoundingKind, &str); 4] = [
    (BoundingKind::Sphere, "sphere"),
    (BoundingKind::Aabb, "axis-aligned box"),
    (BoundingKind::Obb, "oriented box"),
    (BoundingKind::Hull, "convex hull"),
];

/// The volumes of the present subject.
#[derive(Resource)]
pub struct Measured {
    name: String,
    points: usize,
    /// The smallest sphere around all points, in the space of the mesh.
    pub sphere: BoundingSphere,
    hull: ConvexHull,
    rows: Vec<Row>,
}

struct Row {
    name: &'static str,
    volume: AnyVolume,
    tightness: Tightness,
    build: Duration,
    ns_per_ray: f64,
    /// Of rays through the bounding sphere, how many enter the volume.
    entered: f64,
}

impl Measured {
    /// Builds and measures all volumes of some points.
    pub fn new(name: &str, points: &[Vec3A]) -> Result<Self, UnboundablePoints> {
        let hull = ConvexHull::enclosing(points.iter().copied())?;
        let sphere = BoundingSphere::enclosing(points.iter().copied())?;
        let rays = random_rays(sphere.center.into(), sphere.radius());
        let rows = KINDS.into_iter().map(|(kind, name)| {
            let start = Instant::now();
            let volume = kind.enclosing(points.iter().copied())?;
            let build = start.elapsed();
            let (ns_per_ray, entered) = time_rays(&volume, &rays);
            Ok(Row {
                name,
                tightness: volume.tightness(&hull),
                build,
                ns_per_ray,
                entered,
                volume,
            })
        });
        Ok(Self {
            name: name.into(),
            points: points.len(),
            sphere,
            rows: rows.collect::<Result<_, _>>()?,
            hull,
        })
    }

    /// The edges of a volume in world space. The axis-aligned box is made anew around the subject as it stands, and the
    /// others turn with it.
    pub fn wireframe(&self, kind: BoundingKind, transform: &GlobalTransform) -> Vec<[Vec3; 2]> {
        let affine = transform.affine();
        match self
            .rows
            .iter()
            .find(|row| row.volume.kind() == kind)
            .map(|row| &row.volume)
        {
            Some(AnyVolume::Sphere(sphere)) => {
                let sphere = sphere.transformed_by_affine(&affine);
                great_circles(sphere.center.into(), sphere.radius())
            }
            Some(AnyVolume::Aabb(_)) => {
                let aabb = self.hull.transformed_by_affine(&affine).aabb();
                Obb::from(aabb).edges().map(|edge| edge.map(Vec3::from)).to_vec()
            }
            Some(AnyVolume::Obb(obb)) => {
                let edges = obb.transformed_by_affine(&affine).edges();
                edges.map(|edge| edge.map(Vec3::from)).to_vec()
            }
            Some(AnyVolume::Hull(hull)) => {
                let place = |vertex: u32| Vec3::from(affine.transform_point3a(hull.vertices()[vertex as usize]));
                hull.edges().iter().map(|edge| edge.map(place)).collect()
            }
            None => Vec::new(),
        }
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}, {} points, a hull of {} corners",
            self.name,
            self.points,
            self.hull.vertices().len()
        )?;
        writeln!(
            f,
            "{:<18}{:>8}{:>8}{:>10}{:>10}{:>11}",
            "", "volume", "area", "rays in", "ns a ray", "build, us"
        )?;
        for (at, row) in self.rows.iter().enumerate() {
            let (Tightness { volume, projected_area }, build) = (row.tightness, row.build.as_secs_f64() * 1e6);
            let line_end = if at + 1 < self.rows.len() { "\n" } else { "" };
            write!(
                f,
                "{:<18}{volume:>8.2}{projected_area:>8.2}{:>9.0}%{:>10.1}{build:>11.0}{line_end}",
                row.name,
                100.0 * row.entered,
                row.ns_per_ray,
            )?;
        }
        Ok(())
    }
}

/// Rays through a sphere, from outside, the same ones every time.
fn random_rays(center: Vec3, radius: f32) -> Vec<Ray> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut in_ball = || loop {
        let point = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if point.length_squared() < 1.0 {
            break point;
        }
    };
    let ray = || {
        let (through, from) = (in_ball(), in_ball().normalize_or(Vec3::X) * 3.0);
        Ray::new(center + from * radius, through - from, f32::INFINITY)
    };
    std::iter::repeat_with(ray).flatten().take(4096).collect()
}

/// Nanoseconds for each ray, the median of some rounds, and the share of rays that enter.
fn time_rays(volume: &AnyVolume, rays: &[Ray]) -> (f64, f64) {
    let mut entered = 0;
    let mut times: Vec<Duration> = (0..15)
        .map(|_| {
            let start = Instant::now();
            let enters = |ray: &&Ray| black_box(volume).ray_intersection_at(ray).is_some();
            entered = rays.iter().filter(enters).count();
            start.elapsed()
        })
        .collect();
    times.sort_unstable();
    let count = rays.len() as f64;
    (times[times.len() / 2].as_nanos() as f64 / count, entered as f64 / count)
}

fn great_circles(center: Vec3, radius: f32) -> Vec<[Vec3; 2]> {
    const STEPS: u16 = 64;
    let at = |axis: Vec3, step: u16| {
        let (sin, cos) = (f32::from(step) / f32::from(STEPS) * TAU).sin_cos();
        center + (axis.any_orthonormal_vector() * cos + axis.cross(axis.any_orthonormal_vector()) * sin) * radius
    };
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let circles = axes
        .into_iter()
        .flat_map(|axis| (0..STEPS).map(move |step| [at(axis, step), at(axis, step + 1)]));
    circles.collect()
}
