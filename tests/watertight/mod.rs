//! No ray slips through a closed mesh, and every hit is the one that a reference in double precision finds.
//!
//! Rays are aimed at the vertices and edges of closed meshes that are scaled by 1e-6 to 1e6, turned, mirrored and sheared,
//! from outside and from inside, some along faces and along axes. They are taken to the space of the mesh as the index
//! takes them there, and [`reference`] says what they may hit and what they must.
//!
//! The long run casts as many rays as are asked for, on all processors or as many as are asked for:
//!
//! ```sh
//! WATERTIGHT_RAYS=100000000 WATERTIGHT_THREADS=1 cargo test --release --test all watertight -- --nocapture
//! ```

mod models;
mod reference;

use std::{
    ops::AddAssign,
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering},
    },
    thread,
};

use bevy::math::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBvh, TriangleHit},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use self::{
    models::{Model, Placed, Shape},
    reference::{Scratch, Verdict},
};
use crate::common::{random_dir, random_rotation, rng};

/// Rays that are cast under one transform.
const CHUNK: u64 = 500;

/// What came of the rays.
#[derive(Clone, Debug, Default, PartialEq)]
struct Tally {
    rays: u64,
    /// Those that had to hit, or had to miss.
    decided: u64,
    /// Those that had to hit, and did not, or hit something behind.
    slips: u64,
    /// Hits on triangles that the ray does not come near.
    phantoms: u64,
    /// Hits whose parameter or barycentric coordinates are wrong.
    misplaced: u64,
    /// Rays for which there is any hit and no closest one, or the other way round.
    contradictions: u64,
    /// The first of those that are wrong.
    example: Option<String>,
}

impl Tally {
    fn wrong(&self) -> u64 {
        self.slips + self.phantoms + self.misplaced + self.contradictions
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.decided += other.decided;
        self.slips += other.slips;
        self.phantoms += other.phantoms;
        self.misplaced += other.misplaced;
        self.contradictions += other.contradictions;
        self.example = self.example.take().or(other.example);
    }
}

#[test]
fn no_ray_slips_through_a_closed_mesh() {
    let asked = |variable| std::env::var(variable).ok().map(|n| n.parse().expect("a number"));
    let rays: u64 = asked("WATERTIGHT_RAYS").unwrap_or(20_000);
    let threads = asked("WATERTIGHT_THREADS").map_or_else(
        || thread::available_parallelism().map_or(1, usize::from),
        |threads| threads as usize,
    );
    let models = models();
    let chunks = rays.div_ceil(CHUNK);
    let (next, total) = (AtomicU64::new(0), Mutex::new(Tally::default()));
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let mut scratch = Scratch::default();
                loop {
                    let chunk = next.fetch_add(1, Ordering::Relaxed);
                    if chunk >= chunks {
                        break;
                    }
                    let model = &models[chunk as usize % models.len()];
                    let tally = cast_chunk(model, chunk, &mut scratch);
                    let mut total = total.lock().expect("no thread panics");
                    *total += tally;
                    if (total.rays / CHUNK).is_multiple_of(2000) {
                        println!("{total:?}");
                    }
                }
            });
        }
    });
    let total = total.into_inner().expect("no thread panics");
    println!("{total:?}");
    assert_eq!(total.wrong(), 0, "{total:?}");
    assert!(total.decided * 10 > total.rays * 8, "the reference decides: {total:?}");
}

#[test]
fn the_reference_notices_a_hole() {
    let shape = Shape::all().swap_remove(0);
    let mut model = Model::new(&shape, unplaced(1.0));
    let positions: Vec<Vec3> = shape.positions.iter().map(|point| point.as_vec3()).collect();
    model.bvh = models::bvh(&positions, &shape.triangles[..shape.triangles.len() - 1]);
    let tally = cast_chunks(&model, 20);
    assert!(tally.slips > 0, "{tally:?}");
    assert_eq!(tally.phantoms + tally.misplaced + tally.contradictions, 0, "{tally:?}");
}

#[test]
fn the_reference_notices_vertices_that_are_moved() {
    let shape = Shape::all().swap_remove(0);
    let mut model = Model::new(&shape, unplaced(1.0));
    let positions: Vec<Vec3> = (shape.positions.iter())
        .map(|point| (point * (1.0 + 1e-5)).as_vec3())
        .collect();
    model.bvh = models::bvh(&positions, &shape.triangles);
    let tally = cast_chunks(&model, 4);
    assert!(tally.misplaced * 10 > tally.rays, "{tally:?}");
}

/// Every shape in three sizes, turned, mirrored every second time, and moved off the origin.
fn models() -> Vec<Model> {
    let mut rng = rng(1);
    let mut models = Vec::new();
    for shape in Shape::all() {
        for scale in [1.0, 1e-6, 1e6] {
            let plain = scale == 1.0;
            let placed = Placed {
                scale: DVec3::new(if models.len() % 2 == 0 { scale } else { -scale }, scale, scale),
                rotation: if plain {
                    DQuat::IDENTITY
                } else {
                    random_rotation(&mut rng).as_dquat()
                },
                offset: if plain {
                    DVec3::ZERO
                } else {
                    random_dir(&mut rng).as_dvec3() * 2.0 * scale
                },
            };
            models.push(Model::new(&shape, placed));
        }
    }
    models
}

fn unplaced(scale: f64) -> Placed {
    Placed {
        scale: DVec3::splat(scale),
        rotation: DQuat::IDENTITY,
        offset: DVec3::ZERO,
    }
}

fn cast_chunks(model: &Model, chunks: u64) -> Tally {
    let mut scratch = Scratch::default();
    let mut total = Tally::default();
    for chunk in 0..chunks {
        total += cast_chunk(model, chunk, &mut scratch);
    }
    total
}

/// Casts some rays under one transform, the same for the same number.
fn cast_chunk(model: &Model, chunk: u64, scratch: &mut Scratch) -> Tally {
    let rng = &mut rng(chunk);
    let world_from_local = transform(model, rng);
    let local_from_world = world_from_local.inverse();
    let mut tally = Tally::default();
    for number in 0..CHUNK {
        let (from, to, inside) = ends(model, rng);
        let origin = world_from_local.transform_point3(from).as_vec3();
        let towards = world_from_local.transform_point3(to) - origin.as_dvec3();
        let direction = (towards * 10f64.powf(rng.random_range(-2.0..2.0))).as_vec3();
        let ray = Ray::new(origin, direction, f32::INFINITY).expect("two points");
        let local = ray.transformed_by(&local_from_world).expect("a ray");
        let verdict = model.reference.verdict(
            local_from_world.transform_point3(origin.as_dvec3()),
            local_from_world.transform_vector3(direction.as_dvec3()),
            rng,
            scratch,
        );
        let before = tally.wrong();
        check(&model.bvh, &local, &verdict, inside, &mut tally);
        if tally.wrong() > before && tally.example.is_none() {
            let hit = model.bvh.closest_hit(&local, Backfaces::Include);
            tally.example = Some(format!(
                "{}, chunk {chunk}, ray {number}: {local:?} hits {hit:?}, may {:?}, must {:?}",
                model.name, verdict.may, verdict.must
            ));
        }
    }
    tally
}

/// To a size of 1e-6 to 1e6: turned, mirrored, sheared and moved, or some of that, or nothing.
fn transform(model: &Model, rng: &mut ChaCha8Rng) -> DAffine3 {
    if rng.random_bool(0.1) {
        return DAffine3::IDENTITY;
    }
    let scale = 10f64.powf(rng.random_range(-6.0..6.0)) / model.radius;
    let mut linear = DMat3::from_quat(random_rotation(rng).as_dquat()) * scale;
    if rng.random() {
        linear.x_axis = -linear.x_axis;
    }
    if rng.random() {
        let [xy, xz, yz] = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
        linear *= DMat3::from_cols(DVec3::X, DVec3::new(xy, 1.0, 0.0), DVec3::new(xz, yz, 1.0));
    }
    let offset = if rng.random() {
        random_dir(rng).as_dvec3() * scale * model.radius * 10.0
    } else {
        DVec3::ZERO
    };
    DAffine3::from_mat3_translation(linear, offset)
}

/// Where a ray starts, where it goes to, and whether it starts well inside.
fn ends(model: &Model, rng: &mut ChaCha8Rng) -> (DVec3, DVec3, bool) {
    let [a, b] = model.reference.edge(rng);
    let [p, q, r] = model.reference.triangle(rng);
    let on_edge = a.lerp(b, rng.random_range(0.0..=1.0));
    let to = match rng.random_range(0..10) {
        0..3 => a,
        3..7 => on_edge,
        7..9 => on_edge + random_dir(rng).as_dvec3() * model.radius * 10f64.powf(rng.random_range(-9.0..-2.0)),
        _ => p.lerp(q, rng.random()).lerp(r, rng.random()),
    };
    let far = model.radius * 10f64.powf(rng.random_range(0.2..1.0));
    match rng.random_range(0..20) {
        0..8 => (model.interior_point(rng), to, true),
        8..16 => (model.center + random_dir(rng).as_dvec3() * far, to, false),
        16 => (model.center + random_dir(rng).as_dvec3() * far * 100.0, to, false),
        // Along an axis.
        17..19 => {
            let axis = DVec3::AXES[rng.random_range(0..3)];
            (to + axis * if rng.random() { far } else { -far } * 2.0, to, false)
        }
        // In the plane of a triangle, or along a side of it.
        _ => {
            let along = (q - p).lerp(r - p, if rng.random() { 0.0 } else { rng.random_range(0.0..=1.0) });
            (p - along.normalize() * far * 2.0, p + along * 0.5, false)
        }
    }
}

/// Compares the answers of the hierarchy with what must be.
fn check(bvh: &MeshBvh, ray: &Ray, verdict: &Verdict, inside: bool, tally: &mut Tally) {
    tally.rays += 1;
    tally.decided += u64::from(!verdict.must.is_empty() || verdict.may.is_empty());
    for backfaces in [Backfaces::Include, Backfaces::Cull] {
        let hit = bvh.closest_hit(ray, backfaces);
        tally.contradictions += u64::from(hit.is_some() != bvh.any_hit(ray, backfaces));
        let must = (verdict.must.iter()).filter(|must| backfaces == Backfaces::Include || must.degree > 0);
        let latest = must.map(|must| must.t_max).fold(f64::INFINITY, f64::min);
        let Some(hit) = hit else {
            let leaves = inside && backfaces == Backfaces::Include;
            tally.slips += u64::from(latest < f64::INFINITY || leaves);
            continue;
        };
        tally.slips += u64::from(f64::from(hit.t) > latest);
        check_hit(&hit, verdict, backfaces, tally);
    }
}

fn check_hit(hit: &TriangleHit, verdict: &Verdict, backfaces: Backfaces, tally: &mut Tally) {
    let mut may = (verdict.may.iter()).filter(|may| backfaces == Backfaces::Include || may.front);
    let Some(may) = may.find(|may| may.triangle == hit.triangle) else {
        tally.phantoms += 1;
        return;
    };
    let t = f64::from(hit.t);
    let sum = hit.barycentrics.as_dvec3().element_sum();
    let sound = hit.barycentrics.min_element() >= 0.0
        && (sum - 1.0).abs() <= 2.0 * f64::from(f32::EPSILON)
        && may.parameters[0] <= t
        && t <= may.parameters[1]
        && may.offset_of(hit.barycentrics) <= may.offset;
    tally.misplaced += u64::from(!sound);
}
