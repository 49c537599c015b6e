//! Every query, asked of a structure and of the oracle.

use std::{fmt::Debug, ops::ControlFlow};

use bevy::math::{
    Mat4, Quat, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{HalfSpace, ViewFrustum},
};
use bevy_sightline::{
    geometry::{
        convex_hull::ConvexHull,
        intersection::Frustum,
        obb::Obb,
        ray::Ray,
        sweep::{AabbSweep, SphereSweep},
        volume::Volume,
    },
    spatial::{BruteForce, Region, SpatialQueries, SpatialUpdates, Sweep, Visit},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::scenes::Scene;
use crate::common::{random_dir, random_point, random_rotation};

type Oracle = BruteForce<u32>;

/// Asks both every query, with random arguments that suit the scene and some that suit nothing.
///
/// # Panics
///
/// If an answer differs.
pub fn compare_all(
    ours: &impl SpatialQueries<u32>,
    oracle: &Oracle,
    scene: Scene,
    rng: &mut ChaCha8Rng,
    context: &str,
) {
    compare_contents(ours, oracle, context);
    for _ in 0..6 {
        let ray = ray(oracle, scene, rng);
        if in_reach_of_floats(oracle, &ray) {
            compare_ray(ours, oracle, &ray, rng, &format!("{context}: {ray:?}"));
        }
        if !in_reach_of_doubles(scene) {
            continue;
        }
        let radius = length(oracle, scene, rng);
        if let Some(sweep) = SphereSweep::new(ray, radius) {
            compare_sweep(ours, oracle, &sweep, rng, &format!("{context}: {sweep:?}"));
        }
        let half_size = Vec3A::from_array([(); 3].map(|()| length(oracle, scene, rng)));
        if let Some(sweep) = AabbSweep::new(ray, half_size) {
            compare_sweep(ours, oracle, &sweep, rng, &format!("{context}: {sweep:?}"));
        }
    }
    for _ in 0..4 {
        compare_regions(ours, oracle, scene, rng, context);
        let (point, max_distance) = (point(oracle, scene, rng), max_distance(oracle, scene, rng));
        let context = format!("{context}: {point:?} within {max_distance:?}");
        compare_near(ours, oracle, point, max_distance, rng, &context);
    }
    compare_pairs(ours, oracle, scene, rng, context);
}

/// Numbers by their bits: NaN equals itself, and 0 is not -0.
type Found = Vec<(u32, u32)>;

fn sorted<T: Ord>(mut found: Vec<T>) -> Vec<T> {
    found.sort_unstable();
    found
}

fn bits(aabb: &Aabb3d) -> [u32; 6] {
    let ([a, b, c], [d, e, f]) = (aabb.min.to_array(), aabb.max.to_array());
    [a, b, c, d, e, f].map(f32::to_bits)
}

fn same<T: PartialEq + Debug>(ours: T, theirs: T, query: &str, context: &str) {
    assert_eq!(ours, theirs, "{query} of {context}");
}

fn contents(structure: &impl SpatialQueries<u32>) -> Vec<(u32, [u32; 6])> {
    let mut all = Vec::new();
    structure.visit_all(|key, aabb| all.push((key, bits(aabb))));
    sorted(all)
}

fn compare_contents(ours: &impl SpatialQueries<u32>, oracle: &Oracle, context: &str) {
    same(ours.len(), oracle.len(), "len", context);
    same(ours.is_empty(), oracle.is_empty(), "is_empty", context);
    same(contents(ours), contents(oracle), "visit_all", context);
    match (ours.bounds(), oracle.bounds()) {
        (Some(ours), Some(theirs)) => {
            let contains = ours.min.cmple(theirs.min).all() && ours.max.cmpge(theirs.max).all();
            assert!(contains, "{context}: {ours:?} is to contain {theirs:?}");
        }
        (ours, theirs) => same(ours, theirs, "bounds", context),
    }
}

fn compare_ray(ours: &impl SpatialQueries<u32>, oracle: &Oracle, ray: &Ray, rng: &mut ChaCha8Rng, context: &str) {
    let all = compare_ordered(
        |visit| ours.visit_ray(ray, visit),
        |visit| oracle.visit_ray(ray, visit),
        rng,
        context,
    );
    let closest = |closest: Option<(u32, f32)>| closest.map(|(key, t)| (key, t.to_bits()));
    same(
        closest(ours.closest_box(ray)),
        closest(oracle.closest_box(ray)),
        "closest_box",
        context,
    );

    // What is in a box is hit behind its surface, or not at all.
    let entered = |key: u32| {
        f32::from_bits(
            all.iter()
                .find(|found| found.0 == key)
                .expect("a box that is entered")
                .1,
        )
    };
    let hit = |key: u32| {
        let t = entered(key) * (1.0 + (key % 5) as f32 * 0.1) + (key % 2) as f32 * 0.01;
        (!key.is_multiple_of(3) && t <= ray.t_max()).then_some(t)
    };
    let test = |key: u32, rest: &Ray| hit(key).filter(|&t| t <= rest.t_max()).map(|t| (t, key ^ 1));
    let closest = |closest: Option<(u32, f32, u32)>| closest.map(|(key, t, hit)| (key, t.to_bits(), hit));
    same(
        closest(ours.closest_hit(ray, test)),
        closest(oracle.closest_hit(ray, test)),
        "closest_hit",
        context,
    );
    let is_hit = |key: u32, _: &Ray| hit(key).is_some();
    same(
        ours.any_hit(ray, is_hit),
        oracle.any_hit(ray, is_hit),
        "any_hit",
        context,
    );
}

fn compare_sweep(
    ours: &impl SpatialQueries<u32>,
    oracle: &Oracle,
    sweep: &impl Sweep,
    rng: &mut ChaCha8Rng,
    context: &str,
) {
    compare_ordered(
        |visit| ours.visit_sweep(sweep, visit),
        |visit| oracle.visit_sweep(sweep, visit),
        rng,
        context,
    );
    let first = |first: Option<(u32, f32)>| first.map(|(key, t)| (key, t.to_bits()));
    same(
        first(ours.first_touched(sweep)),
        first(oracle.first_touched(sweep)),
        "first_touched",
        context,
    );
}

fn compare_near(
    ours: &impl SpatialQueries<u32>,
    oracle: &Oracle,
    point: Vec3A,
    max_distance: f32,
    rng: &mut ChaCha8Rng,
    context: &str,
) {
    compare_ordered(
        |visit| ours.visit_near(point, max_distance, visit),
        |visit| oracle.visit_near(point, max_distance, visit),
        rng,
        context,
    );
    let k = [0, 1, 2, 8, 1000][rng.random_range(0..5)];
    // What is in the buffer before must not matter.
    let (mut nearest, mut theirs) = (Vec::new(), Vec::new());
    oracle.k_nearest(Vec3A::ZERO, 3, f32::INFINITY, &mut nearest);
    ours.k_nearest(point, k, max_distance, &mut nearest);
    oracle.k_nearest(point, k, max_distance, &mut theirs);
    let found = |nearest: Vec<_>| -> Found {
        let found = nearest.into_iter();
        found
            .map(|n: bevy_sightline::spatial::Neighbour<u32>| (n.key, n.distance_squared.to_bits()))
            .collect()
    };
    same(found(nearest), found(theirs), "k_nearest", context);
}

/// A query whose visits may shorten it: all that it finds, with what is found if it is shortened, or stopped.
fn compare_ordered(
    ours: impl Fn(&mut dyn FnMut(u32, f32) -> Visit),
    oracle: impl Fn(&mut dyn FnMut(u32, f32) -> Visit),
    rng: &mut ChaCha8Rng,
    context: &str,
) -> Found {
    let all = |query: &dyn Fn(&mut dyn FnMut(u32, f32) -> Visit)| {
        let mut found = Found::new();
        query(&mut |key, at| {
            found.push((key, at.to_bits()));
            Visit::Continue
        });
        sorted(found)
    };
    let theirs = all(&oracle);
    same(all(&ours), theirs.clone(), "all", context);

    let stop_after = rng.random_range(1..6);
    let mut visited = Found::new();
    ours(&mut |key, at| {
        visited.push((key, at.to_bits()));
        if visited.len() == stop_after {
            Visit::Stop
        } else {
            Visit::Continue
        }
    });
    same(
        visited.len(),
        stop_after.min(theirs.len()),
        "the number of visits before a stop",
        context,
    );
    let each_is_one = visited.iter().all(|found| theirs.binary_search(found).is_ok());
    assert!(
        each_is_one,
        "{context}: {visited:?} before a stop, but there are {theirs:?}"
    );

    // Shortened to what one of them has, at the first visit: those up to there are visited, no later ones are, and a
    // limit that is farther changes nothing.
    if !theirs.is_empty() {
        let limit = f32::from_bits(theirs[rng.random_range(0..theirs.len())].1);
        let mut first = None;
        let mut visited = Found::new();
        ours(&mut |key, at| {
            if first.is_none() {
                first = Some((key, at.to_bits()));
                return Visit::Shorten(limit);
            }
            visited.push((key, at.to_bits()));
            Visit::Shorten(f32::INFINITY)
        });
        let up_to_there = theirs.iter().copied().filter(|&found| f32::from_bits(found.1) <= limit);
        let expected = up_to_there.filter(|&found| Some(found) != first).collect();
        same(sorted(visited), expected, "those up to a limit", context);
    }
    theirs
}

fn compare_regions(
    ours: &impl SpatialQueries<u32>,
    oracle: &Oracle,
    scene: Scene,
    rng: &mut ChaCha8Rng,
    context: &str,
) {
    let center = point(oracle, scene, rng);
    let half_size = Vec3A::from_array([(); 3].map(|()| length(oracle, scene, rng)));
    let mut region = Aabb3d {
        min: center - half_size,
        max: center + half_size,
    };
    if rng.random_bool(0.05) {
        std::mem::swap(&mut region.min, &mut region.max);
    }
    compare_region(ours, oracle, &region, rng, &format!("{context}: {region:?}"));
    if let Some((_, aabb)) = any_box(oracle, rng) {
        compare_region(ours, oracle, &aabb, rng, &format!("{context}: {aabb:?}"));
    }
    let sphere = BoundingSphere::new(center, length(oracle, scene, rng));
    compare_region(ours, oracle, &sphere, rng, &format!("{context}: {sphere:?}"));

    let frustum = frustum(center, half_size.max_element(), rng);
    compare_region(ours, oracle, &frustum, rng, &format!("{context}: {frustum:?}"));
    if !in_reach_of_doubles(scene) {
        return;
    }
    let frustum = Frustum::from(&frustum);
    compare_region(ours, oracle, &frustum, rng, &format!("{context}: {frustum:?}"));
    let rotation = if rng.random_bool(0.2) {
        Quat::IDENTITY
    } else {
        random_rotation(rng)
    };
    if let Some(obb) = Obb::new(center, half_size, rotation) {
        compare_region(ours, oracle, &obb, rng, &format!("{context}: {obb:?}"));
    }
    let corners = [(); 8].map(|()| center + half_size * Vec3A::from(random_point(rng, 1.0)));
    let rank = rng.random_range(1..=8);
    if let Ok(hull) = ConvexHull::enclosing(corners.into_iter().take(rank)) {
        compare_region(ours, oracle, &hull, rng, &format!("{context}: {hull:?}"));
    }
}

/// Sweeps and polytopes are held against boxes in double precision, conservatively: where coordinates differ by more
/// than it resolves, what they touch is a matter of rounding, and the boxes around are passed by or not as it happens.
fn in_reach_of_doubles(scene: Scene) -> bool {
    scene != Scene::Extreme
}

/// The slab test promises nothing about boxes that are farther from the start of the ray than `f32` reaches.
fn in_reach_of_floats(oracle: &Oracle, ray: &Ray) -> bool {
    oracle.bounds().is_none_or(|bounds| {
        let reach = (bounds.min - ray.origin()).abs().max((bounds.max - ray.origin()).abs());
        reach.is_finite()
    })
}

/// A frustum that looks about from near a point: of a perspective with and without end, of an orthographic projection,
/// and of half-spaces that are anything.
fn frustum(center: Vec3A, size: f32, rng: &mut ChaCha8Rng) -> ViewFrustum {
    let (eye, size) = (Vec3::from(center), size.clamp(1e-6, 1e12));
    let (fov, aspect) = (rng.random_range(0.2..2.5), rng.random_range(0.5..2.0));
    let projection = match rng.random_range(0..4) {
        0 => Mat4::perspective_infinite_reverse_rh(fov, aspect, size * 0.01),
        1 => Mat4::orthographic_rh(-size, size, -size, size, 2.0 * size, 0.0),
        _ => Mat4::perspective_rh(fov, aspect, size * 2.0, size * 0.01),
    };
    let view = Mat4::look_to_rh(eye, *random_dir(rng), *random_dir(rng));
    let mut frustum = ViewFrustum::from_clip_from_world(&(projection * view));
    if rng.random_bool(0.1) {
        let any = [(); 4].map(|()| rng.random_range(-1.0f32..1.0) * size);
        frustum.half_spaces[rng.random_range(0..6)] = HalfSpace::new(any.into());
    }
    frustum
}

fn compare_region(
    ours: &impl SpatialQueries<u32>,
    oracle: &Oracle,
    region: &impl Region,
    rng: &mut ChaCha8Rng,
    context: &str,
) {
    let (mut found, mut theirs) = (vec![7; 3], Vec::new());
    ours.find_in_region(region, &mut found);
    oracle.find_in_region(region, &mut theirs);
    let theirs = sorted(theirs);
    same(sorted(found), theirs.clone(), "visit_region", context);

    let stop_after = rng.random_range(1..6);
    let mut visited = Vec::new();
    ours.visit_region(region, |key| {
        visited.push(key);
        if visited.len() == stop_after {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    same(
        visited.len(),
        stop_after.min(theirs.len()),
        "the number of visits before a stop",
        context,
    );
    let each_is_one = visited.iter().all(|found| theirs.binary_search(found).is_ok());
    assert!(
        each_is_one,
        "{context}: {visited:?} before a stop, but there are {theirs:?}"
    );
}

fn compare_pairs(ours: &impl SpatialQueries<u32>, oracle: &Oracle, scene: Scene, rng: &mut ChaCha8Rng, context: &str) {
    let pairs = |structure: &dyn Fn(&mut dyn FnMut(u32, u32) -> ControlFlow<()>)| {
        let mut pairs = Vec::new();
        structure(&mut |a, b| {
            pairs.push((a.min(b), a.max(b)));
            ControlFlow::Continue(())
        });
        sorted(pairs)
    };
    let theirs = pairs(&|visit| oracle.visit_pairs(visit));
    let found = pairs(&|visit| ours.visit_pairs(visit));
    let context = &format!("{context}, {} pairs of {}", theirs.len(), oracle.len());
    assert!(found == theirs, "visit_pairs of {context}: {} are found", found.len());

    let stop_after = rng.random_range(1..6);
    let mut visited = 0;
    ours.visit_pairs(|_, _| {
        visited += 1;
        if visited == stop_after {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    same(
        visited,
        stop_after.min(theirs.len()),
        "the number of pairs before a stop",
        context,
    );

    let mut others = Oracle::new();
    others.insert_many((0..20).map(|key| (key, scene.aabb(rng))));
    let pairs_with = |structure: &dyn Fn(&mut dyn FnMut(u32, u32) -> ControlFlow<()>)| {
        let mut pairs = Vec::new();
        structure(&mut |a, b| {
            pairs.push((a, b));
            ControlFlow::Continue(())
        });
        sorted(pairs)
    };
    let theirs = pairs_with(&|visit| oracle.visit_pairs_with(&others, visit));
    let found = pairs_with(&|visit| ours.visit_pairs_with(&others, visit));
    assert!(
        found == theirs,
        "visit_pairs_with of {context}: {} and {}",
        found.len(),
        theirs.len()
    );
}

fn any_box(oracle: &Oracle, rng: &mut ChaCha8Rng) -> Option<(u32, Aabb3d)> {
    let mut rest = (!oracle.is_empty()).then(|| rng.random_range(0..oracle.len()))?;
    let mut chosen = None;
    oracle.visit_all(|key, aabb| {
        if rest == 0 && chosen.is_none() {
            chosen = Some((key, *aabb));
        }
        rest = rest.saturating_sub(1);
    });
    chosen
}

/// A point in the scene, often one that matters: a corner of a box, on its face, or in it; at times NaN.
fn point(oracle: &Oracle, scene: Scene, rng: &mut ChaCha8Rng) -> Vec3A {
    let aabb = any_box(oracle, rng).map_or_else(|| scene.aabb(rng), |(_, aabb)| aabb);
    let middle = aabb.min * 0.5 + aabb.max * 0.5;
    let side = aabb.max * 0.5 - aabb.min * 0.5;
    match rng.random_range(0..20) {
        0..4 => aabb.min,
        4..7 => Vec3A::new(aabb.min.x, aabb.max.y, middle.z),
        7..10 => middle,
        10..15 => middle + side * Vec3A::from(random_point(rng, 4.0)),
        15 => Vec3A::from(random_point(rng, 1.0)).with_y(f32::NAN),
        16 => Vec3A::ZERO,
        _ => {
            let other = scene.aabb(rng);
            other.min * 0.5 + other.max * 0.5
        }
    }
}

/// A length that suits the scene: of the size of a box, or of a distance between two; zero at times.
fn length(oracle: &Oracle, scene: Scene, rng: &mut ChaCha8Rng) -> f32 {
    let aabb = any_box(oracle, rng).map_or_else(|| scene.aabb(rng), |(_, aabb)| aabb);
    let other = scene.aabb(rng);
    let length = match rng.random_range(0..8) {
        0 => 0.0,
        1..4 => (aabb.max * 0.5 - aabb.min * 0.5).max_element() * rng.random_range(0.0..4.0),
        _ => (aabb.max * 0.5 - other.min * 0.5).abs().max_element() * rng.random_range(0.0..2.0),
    };
    length.min(f32::MAX)
}

fn max_distance(oracle: &Oracle, scene: Scene, rng: &mut ChaCha8Rng) -> f32 {
    match rng.random_range(0..12) {
        0 => f32::NAN,
        1..4 => f32::INFINITY,
        _ => length(oracle, scene, rng),
    }
}

/// A ray through the scene, along an axis or towards a box at times, without end or ending where it enters a box.
fn ray(oracle: &Oracle, scene: Scene, rng: &mut ChaCha8Rng) -> Ray {
    loop {
        let origin = point(oracle, scene, rng);
        let direction = match rng.random_range(0..4) {
            0 => Vec3A::AXES[rng.random_range(0..3)] * [-1.0, 1.0, 1e-3][rng.random_range(0..3)],
            1 => Vec3A::from(*random_dir(rng)),
            2 => point(oracle, scene, rng) - origin,
            _ => {
                let mut direction = Vec3A::from(random_point(rng, 1.0));
                direction[rng.random_range(0..3)] = 0.0;
                direction
            }
        };
        let Some(ray) = Ray::new(origin, direction, f32::INFINITY) else {
            continue;
        };
        let entered = any_box(oracle, rng).and_then(|(_, aabb)| ray.aabb_intersection_at(&aabb));
        return match rng.random_range(0..8) {
            0 => ray.with_t_max(length(oracle, scene, rng)),
            1 => ray.with_t_max(1.0),
            2 | 3 => entered.map_or(ray, |t| ray.with_t_max(t)),
            4 => entered.map_or(ray, |t| ray.with_interval(t, t * 2.0)),
            _ => ray,
        };
    }
}
