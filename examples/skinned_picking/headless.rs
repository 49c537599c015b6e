//! The meadow without a window: clicks on a fox, casts rays at all of them in each frame, and checks what they meet.

use std::{
    error::Error,
    path::PathBuf,
    time::{Duration, Instant},
};

use bevy::{color::palettes::tailwind::YELLOW_300, math::DVec3, prelude::*, time::TimeUpdateStrategy};
use bevy_sightline::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    marks::{self, Mark},
    meadow::{SKY, TO_SUN, Unfitted},
    options::Options,
    pointer,
    ray_cast_picture::{Daylight, Painter, Picture},
    reference::{self, Reference, Triangles},
    shared,
};

const RAYS_PER_FRAME: usize = 100;
/// By how much of the distance a hit may be off: single precision, seen from a few metres.
const TOLERANCE: f64 = 2e-5;
/// In rays: four make a pixel.
const SIZE: UVec2 = UVec2::new(1920, 1080);

const DAYLIGHT: Daylight = Daylight {
    sky: SKY,
    to_sun: TO_SUN,
    haze: 60.0,
};

/// What the rays have found so far.
#[derive(Resource)]
struct Findings {
    rng: ChaCha8Rng,
    rays: usize,
    hits: usize,
    disagreements: usize,
    /// Greatest distance of a mark from where the reference has it, in metres.
    worst_mark: f64,
    first_ns: Vec<u64>,
    later_ns: Vec<u64>,
}

/// Runs the scene until it is loaded, then for the frames asked for, and prints the report.
pub fn run(mut app: App) -> AppExit {
    match try_run(&mut app) {
        Ok(()) => AppExit::Success,
        Err(error) => {
            eprintln!("{error}");
            AppExit::error()
        }
    }
}

fn try_run(app: &mut App) -> Result<(), Box<dyn Error + Send + Sync>> {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
        .insert_resource(Findings {
            rng: ChaCha8Rng::seed_from_u64(1),
            rays: 0,
            hits: 0,
            disagreements: 0,
            worst_mark: 0.0,
            first_ns: Vec::new(),
            later_ns: Vec::new(),
        });
    shared::load(app)?;
    while app.world_mut().query::<&Unfitted>().iter(app.world()).len() > 0 {
        app.update();
    }
    app.update();

    // A click on each fox, wherever it is by then.
    let options = app.world().resource::<Options>().clone();
    for number in 0..options.foxes as usize {
        let places = app.world_mut().run_system_cached(on_screen)?;
        if let Some(&place) = places.get(number) {
            pointer::play(app, [(place, None)]);
            pointer::play(app, pointer::click(place));
        }
    }
    for _ in 0..options.frames {
        app.update();
        app.world_mut().run_system_cached(check)?;
    }

    let picture_ms = app
        .world_mut()
        .run_system_cached_with(draw, options.picture.clone())??;
    let world = app.world_mut();
    let marks = world.query::<&Mark>().iter(world).len();
    let triangles: usize = world.run_system_cached(triangles)?;
    let mut findings = world.resource_mut::<Findings>();
    let (first, later) = (median_us(&mut findings.first_ns), median_us(&mut findings.later_ns));
    let Findings {
        rays,
        hits,
        disagreements,
        worst_mark,
        ..
    } = *findings;
    println!("{:<44}{triangles:>12}", "triangles of all foxes");
    println!("{:<44}{rays:>12}", "rays");
    println!("{:<44}{hits:>12}", "hits");
    println!("{:<44}{disagreements:>12}", "disagreements with double precision");
    println!("{:<44}{first:>12.2}", "first ray of a frame, median us");
    println!("{:<44}{later:>12.2}", "further rays, median us");
    println!("{:<44}{marks:>12}", "pins");
    println!("{:<44}{:>12.4}", "farthest pin from its place, mm", worst_mark * 1e3);
    println!("{:<44}{picture_ms:>12.0}", "picture, ms");
    println!("picture: {}", options.picture.display());
    if disagreements * 1000 > rays {
        return Err("more disagreements than rounding at the outlines explains".into());
    }
    if worst_mark > 1e-4 {
        return Err("a pin has left its triangle".into());
    }
    Ok(())
}

/// The skins of all foxes, in a fixed order.
type Skins<'w, 's> = Query<'w, 's, Entity, With<Mesh3d>>;

fn skins(skins: &Skins, foxes: &marks::Foxes) -> Vec<Entity> {
    let mut skins: Vec<Entity> = skins.iter().filter(|&skin| foxes.name(skin).is_some()).collect();
    skins.sort_unstable();
    skins
}

/// Where in the window the middles of the foxes are, from (0, 0) to (1, 1).
fn on_screen(
    all: Skins,
    foxes: marks::Foxes,
    reference: Reference,
    camera: Single<(&Camera, &GlobalTransform)>,
) -> Vec<Vec2> {
    let (camera, transform) = *camera;
    let Some(viewport) = camera.logical_viewport_size() else {
        return Vec::new();
    };
    let middle = |skin: Entity| {
        let corners = reference.triangles(skin)?.into_iter().flatten();
        let (min, max) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), corner| {
            (min.min(corner), max.max(corner))
        });
        let place = camera
            .world_to_viewport(transform, ((min + max) * 0.5).as_vec3())
            .ok()?;
        Some(place / viewport)
    };
    skins(&all, &foxes).into_iter().filter_map(middle).collect()
}

fn triangles(all: Skins, foxes: marks::Foxes, reference: Reference) -> usize {
    let skins = skins(&all, &foxes).into_iter();
    skins
        .filter_map(|skin| reference.triangles(skin))
        .map(|triangles| triangles.len())
        .sum()
}

/// Casts rays from anywhere to near the foxes, and compares each hit with the reference; and the marks.
fn check(
    scene: SceneQuery,
    all: Skins,
    foxes: marks::Foxes,
    reference: Reference,
    marks: Query<&Mark>,
    mut findings: ResMut<Findings>,
) {
    let posed: Vec<(Entity, Triangles)> = skins(&all, &foxes)
        .into_iter()
        .filter_map(|skin| Some((skin, reference.triangles(skin)?)))
        .collect();
    let is_fox = |entity: Entity| posed.iter().any(|(skin, _)| *skin == entity);
    let settings = SceneQuerySettings::default().filter(&is_fox);
    for number in 0..RAYS_PER_FRAME {
        let rng = &mut findings.rng;
        let (_, triangles) = &posed[rng.random_range(0..posed.len())];
        let near = triangles[rng.random_range(0..triangles.len())][0].as_vec3();
        let mut random = |size: f32| Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)));
        let (origin, target) = (near + random(4.0), near + random(0.1));
        let Ok(direction) = Dir3::new(target - origin) else {
            continue;
        };
        let ray = Ray3d::new(origin, direction);
        let start = Instant::now();
        let ours = scene.cast_ray(ray, &settings).map(|hit| f64::from(hit.distance));
        let ns = start.elapsed().as_nanos() as u64;
        if number == 0 {
            findings.first_ns.push(ns);
        } else {
            findings.later_ns.push(ns);
        }

        let theirs = posed
            .iter()
            .filter_map(|(_, triangles)| reference::cast(ray, triangles));
        let same = match (ours, theirs.min_by(f64::total_cmp)) {
            (None, None) => true,
            (Some(ours), Some(theirs)) => (ours - theirs).abs() <= TOLERANCE * theirs.max(1.0),
            _ => false,
        };
        findings.rays += 1;
        findings.hits += usize::from(ours.is_some());
        findings.disagreements += usize::from(!same);
    }
    for mark in &marks {
        let corners = scene.triangle(mark.entity, mark.triangle);
        let truth = posed.iter().find(|(skin, _)| *skin == mark.entity);
        let (Some(corners), Some((_, triangles))) = (corners, truth) else {
            findings.worst_mark = f64::INFINITY;
            continue;
        };
        let [a, b, c] = triangles[mark.triangle as usize];
        let weights = mark.barycentrics.as_dvec3();
        let place = a * weights.x + b * weights.y + c * weights.z;
        let off = mark.place(corners).0.as_dvec3().distance(place);
        findings.worst_mark = findings.worst_mark.max(off);
    }
}

/// Draws what the camera sees into a PNG file, with the pins, and returns the milliseconds that the rays took.
fn draw(
    In(file): In<PathBuf>,
    painter: Painter,
    camera: Single<(&Camera, &GlobalTransform)>,
    marks: Query<&Mark>,
    scene: SceneQuery,
) -> Result<f64, Box<dyn Error + Send + Sync>> {
    let start = Instant::now();
    let mut picture = Picture::ray_cast(SIZE, *camera, |ray| painter.shade(ray, &DAYLIGHT));
    let ms = start.elapsed().as_secs_f64() * 1e3;
    for mark in &marks {
        let Some(corners) = scene.triangle(mark.entity, mark.triangle) else {
            continue;
        };
        let (place, normal) = mark.place(corners);
        picture.line([place, place + normal * 0.16], mark.color);
        for i in 0..3 {
            let edge = [corners[i], corners[(i + 1) % 3]];
            picture.line(edge.map(|corner| corner + normal * 0.004), YELLOW_300);
        }
    }
    picture.save(&file)?;
    Ok(ms)
}

fn median_us(ns: &mut [u64]) -> f64 {
    ns.sort_unstable();
    ns.get(ns.len() / 2).map_or(f64::NAN, |median| *median as f64 / 1000.0)
}
