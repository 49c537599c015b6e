//! The flight that is measured: through the same city with `bevy_sightline` and with Bevy's built-ins, in turn.

use std::{any::TypeId, fs, time::Duration};

use bevy::{
    camera::{
        primitives::Aabb,
        visibility::{NoAutoAabb, VisibleEntities},
    },
    ecs::entity::EntityHashMap,
    log::LogPlugin,
    picking::pointer::{PointerId, PointerInteraction},
    platform::collections::HashMap,
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_sightline::prelude::*;

use crate::{
    build,
    flight::route,
    levels::{Hits, OtherLevel},
    loading::load,
    options::Options,
    pointer,
    stopwatch::{Stage, Stopwatch},
};

/// Frames before the first that counts.
const WARMING_UP: u32 = 20;
const STEP: Duration = Duration::from_millis(16);

/// The number that something has in both cities.
type Number = usize;

/// A city with whatever finds, culls and hides.
struct City {
    name: &'static str,
    app: App,
    camera: Entity,
    /// Of everything that has a mesh: of a level, the number of what it is a level of.
    numbers: EntityHashMap<Number>,
    /// How many are in view, by frame.
    seen: Vec<usize>,
}

/// What was found in one frame.
struct Found {
    seen: Vec<Number>,
    /// What is under the pointer, and how far away.
    picked: Option<(Number, f32)>,
}

/// How the two have compared.
#[derive(Default)]
struct Comparison {
    picks: usize,
    /// Two surfaces at the same distance, of which each has picked another.
    ties: usize,
    disagreements: usize,
}

/// Flies, and prints how long each stage takes.
pub fn run(options: &Options) -> AppExit {
    match fly(options) {
        Ok(()) => AppExit::Success,
        Err(message) => {
            eprintln!("{message}");
            AppExit::error()
        }
    }
}

fn fly(options: &Options) -> Result<(), String> {
    let mut cities = if options.plain {
        vec![City::new(options, true, true)?]
    } else {
        vec![City::new(options, false, true)?, City::new(options, true, false)?]
    };
    let count = number(&mut cities)?;
    if let [ours, plain] = &mut cities[..] {
        share_boxes(ours, plain);
    }
    let route = route(options.blocks);
    let mut comparison = Comparison::default();
    let mut seen_by_bevy = vec![0; count];
    for frame in 0..WARMING_UP + options.frames {
        let counted = frame.checked_sub(WARMING_UP);
        if counted == Some(0) {
            for city in &mut cities {
                city.app.insert_resource(Stopwatch::of_last(options.frames as usize));
            }
        }
        let along = counted.unwrap_or_default() as f32 / options.frames as f32;
        let place = route.place(along);
        let pointer = Vec2::new(0.5 + 0.4 * (along * 61.0).sin(), 0.55 + 0.35 * (along * 37.0).cos());
        // Neither is always the one that comes after the other.
        for turn in 0..cities.len() as u32 {
            let city = (turn + frame) as usize % cities.len();
            cities[city].step(place, pointer);
        }
        let Some(counted) = counted else {
            continue;
        };
        let found: Vec<Found> = cities.iter_mut().map(City::look).collect::<Result<_, _>>()?;
        for (city, found) in cities.iter_mut().zip(&found) {
            city.seen.push(found.seen.len());
        }
        if let [ours, plain] = &found[..] {
            comparison.note(ours, plain, counted + 1, &mut seen_by_bevy)?;
        }
    }
    print_report(options, &mut cities, &comparison)?;
    let is_rounding = comparison.disagreements <= options.frames as usize / 100;
    is_rounding.then_some(()).ok_or("the two pick different things".into())
}

impl City {
    fn new(options: &Options, is_plain: bool, is_first: bool) -> Result<Self, String> {
        let mut app = App::new();
        let plugins = crate::shared::plugins("bevy_sightline: city", true);
        if is_first {
            app.add_plugins(plugins);
        } else {
            // There is one log.
            app.add_plugins(plugins.disable::<LogPlugin>());
        }
        let options = Options {
            plain: is_plain,
            ..options.clone()
        };
        build(&mut app, options);
        // Nothing moves while models are loaded.
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
        if !is_plain {
            // As Bevy has it: rays hit what is shown, and levels switch at their distances.
            app.insert_resource(Hits(LodHits::Shown));
            app.world_mut().resource_mut::<LodSettings>().hysteresis = 0.0;
        }
        load(&mut app)?;
        app.insert_resource(TimeUpdateStrategy::ManualDuration(STEP));
        let world = app.world_mut();
        let camera = world.query_filtered::<Entity, With<Camera3d>>().single(world);
        Ok(Self {
            name: if is_plain { "Bevy" } else { "bevy_sightline" },
            camera: camera.map_err(|error| error.to_string())?,
            app,
            numbers: default(),
            seen: Vec::new(),
        })
    }

    fn step(&mut self, place: Transform, pointer: Vec2) {
        if let Some(mut transform) = self.app.world_mut().get_mut::<Transform>(self.camera) {
            *transform = place;
        }
        pointer::act(self.app.world_mut(), (pointer, None));
        self.app.update();
    }

    fn look(&mut self) -> Result<Found, String> {
        let world = self.app.world_mut();
        let mut pointers = world.query::<(&PointerId, &PointerInteraction)>();
        let mouse = pointers.iter(world).find(|(id, _)| **id == PointerId::Mouse);
        let nearest = mouse.and_then(|(_, interaction)| interaction.get_nearest_hit());
        // The window is behind everything.
        let picked = nearest.and_then(|(entity, hit)| Some((*self.numbers.get(entity)?, hit.depth)));
        let visible = world
            .get::<VisibleEntities>(self.camera)
            .ok_or("the camera sees nothing")?;
        let seen = visible.get(TypeId::of::<Mesh3d>()).iter();
        let seen = seen.map(|entity| {
            self.numbers
                .get(entity)
                .copied()
                .ok_or(format!("{entity} has no number"))
        });
        Ok(Found {
            seen: seen.collect::<Result<_, _>>()?,
            picked,
        })
    }
}

/// Numbers what is in both cities by its name, and says how many there are. Both must have the same.
fn number(cities: &mut [City]) -> Result<usize, String> {
    let mut by_name: HashMap<String, Number> = HashMap::new();
    for (place, city) in cities.iter_mut().enumerate() {
        let world = city.app.world_mut();
        let mut named = world.query_filtered::<(Entity, &Name), With<Mesh3d>>();
        for (entity, name) in named.iter(world) {
            let next = by_name.len();
            let number = match by_name.get(name.as_str()) {
                Some(&number) => number,
                None if place == 0 => *by_name.entry(name.as_str().into()).or_insert(next),
                None => return Err(format!("{name} is in one of the cities only")),
            };
            city.numbers.insert(entity, number);
        }
        if city.numbers.len() != by_name.len() {
            return Err("the cities are not the same".into());
        }
        let mut levels = world.query_filtered::<(Entity, &ChildOf), With<OtherLevel>>();
        for (entity, of) in levels.iter(world) {
            let number = city.numbers[&of.parent()];
            city.numbers.insert(entity, number);
        }
    }
    Ok(by_name.len())
}

/// A mesh that is swapped is culled by one box for all of its levels: the levels of the other city are given the same.
fn share_boxes(ours: &mut City, plain: &mut City) {
    let world = ours.app.world_mut();
    let mut boxed = world.query::<(Entity, &Aabb)>();
    let boxes: HashMap<Number, Aabb> = boxed
        .iter(world)
        .filter_map(|(entity, aabb)| Some((*ours.numbers.get(&entity)?, *aabb)))
        .collect();
    for (&entity, number) in &plain.numbers {
        if let Some(&aabb) = boxes.get(number) {
            plain.app.world_mut().entity_mut(entity).insert((aabb, NoAutoAabb));
        }
    }
}

impl Comparison {
    /// Occlusion only ever takes away, and nothing else may differ. `marks` has the number of the last frame in which
    /// Bevy saw each thing.
    fn note(&mut self, ours: &Found, plain: &Found, frame: u32, marks: &mut [u32]) -> Result<(), String> {
        for &number in &plain.seen {
            marks[number] = frame;
        }
        if let Some(number) = ours.seen.iter().find(|&&number| marks[number] != frame) {
            return Err(format!("frame {frame}: Bevy does not see thing {number}"));
        }
        self.picks += usize::from(ours.picked.is_some());
        match (ours.picked, plain.picked) {
            (None, None) => {}
            (Some((one, _)), Some((other, _))) if one == other => {}
            (Some((_, one)), Some((_, other))) if (one - other).abs() <= 1e-4 * other => self.ties += 1,
            (one, other) => {
                println!("frame {frame}: bevy_sightline picks {one:?}, Bevy {other:?} (number of the thing, metres)");
                self.disagreements += 1;
            }
        }
        Ok(())
    }
}

fn print_report(options: &Options, cities: &mut [City], comparison: &Comparison) -> Result<(), String> {
    let mut json = serde_json::Map::new();
    println!(
        "{} frames, times of the CPU in milliseconds: without a window nothing is drawn\n",
        options.frames
    );
    print!("{:<20}", "");
    for city in &*cities {
        print!("{:>22}", city.name);
    }
    print!("\n{:<20}", "");
    for _ in &*cities {
        print!("{:>12}{:>10}", "median", "95%");
    }
    println!("{:>12}", if cities.len() == 2 { "Bevy / ours" } else { "" });
    for stage in Stage::ALL {
        print!("{:<20}", stage.name());
        let mut medians = Vec::new();
        for city in &*cities {
            let times = city.app.world().resource::<Stopwatch>().times(stage);
            let [median, slow] = [50, 95].map(|part| times.percentile(part));
            print!("{median:>12.3}{slow:>10.3}");
            medians.push(median);
            json.insert(format!("{}, {}, median ms", city.name, stage.name()), median.into());
            json.insert(format!("{}, {}, 95% ms", city.name, stage.name()), slow.into());
        }
        match medians[..] {
            [ours, bevy] if stage != Stage::Index => println!("{:>12.1}", bevy / ours),
            _ => println!(),
        }
    }
    println!();
    for city in cities {
        city.seen.sort_unstable();
        let (median, most) = (city.seen[city.seen.len() / 2], city.seen[city.seen.len() - 1]);
        let world = city.app.world_mut();
        let with_meshes = world.query::<&Mesh3d>().iter(world).len();
        println!(
            "{:<20}{with_meshes:>12} entities with meshes; in view, median {median}, at most {most}",
            city.name
        );
        json.insert(format!("{}, entities with meshes", city.name), with_meshes.into());
        json.insert(format!("{}, in view, median", city.name), median.into());
    }
    let Comparison {
        picks,
        ties,
        disagreements,
    } = *comparison;
    if !options.plain {
        println!("all that bevy_sightline sees, Bevy sees too");
        println!("{picks} picks: {ties} of two surfaces at one place, {disagreements} different");
        json.insert("picks".into(), picks.into());
        json.insert("different picks".into(), disagreements.into());
    }
    if cfg!(debug_assertions) {
        println!("the times mean little without --release");
    }
    if let Some(file) = &options.json {
        let json = serde_json::Value::from(json);
        fs::write(file, format!("{json:#}\n")).map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}
