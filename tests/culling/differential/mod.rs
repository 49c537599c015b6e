//! Two apps in which the same things happen, frame by frame: one with Bevy's own systems, one with ours.
//!
//! After every frame they must agree on all that a user can see of culling: every list of every camera and light, in its
//! order; every `ViewVisibility`; and which of them changed, as a system in `Update` and one in `Last` see it.
//!
//! A thousand frames from fixed seeds; with `PROPERTY_CASES` in the environment, that many from a new seed every time. A
//! failure names the seed: set `PROPERTY_SEED` to see it again.

pub mod apps;
mod bounds;
pub mod cast;
mod faults;
mod lights;
mod snapshot;
pub mod things;
mod third_party;
mod views;

use std::fmt::Write;

use bevy::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::rng;
use apps::{bevys, handed_back, ours, set_enabled};
use cast::{Cast, Change, Role, Script, Skin, Way, When, draw};
use snapshot::{Tally, difference, take};

/// What happens in a run.
#[derive(Clone, Copy)]
struct Plan {
    /// Things at the start, and about as many later.
    things: usize,
    cameras: usize,
    lights: usize,
    /// How much happens in a frame, and how often nothing does.
    most_changes: usize,
    stillness: f64,
    /// Whether ours is switched off and on again.
    is_switched: bool,
}

const VIEWS: Plan = Plan {
    things: 200,
    cameras: 3,
    lights: 0,
    most_changes: 12,
    stillness: 0.2,
    is_switched: false,
};

const LIGHTS: Plan = Plan {
    things: 100,
    cameras: 2,
    lights: 5,
    most_changes: 8,
    stillness: 0.2,
    is_switched: false,
};

/// Puts something wrong in the second app, from some frame on, until it finds what to put wrong and returns true.
#[derive(Clone, Copy)]
struct Fault {
    frame: usize,
    act: fn(&mut World) -> bool,
}

/// Two apps and who takes part in them.
struct Run {
    plan: Plan,
    seed: u64,
    rng: ChaCha8Rng,
    apps: [App; 2],
    cast: Cast,
    /// What has happened so far, and in which frame.
    log: Vec<(usize, String)>,
}

impl Run {
    fn new(plan: Plan, seed: u64, apps: [App; 2]) -> Self {
        Self {
            plan,
            seed,
            rng: rng(seed),
            apps,
            cast: Cast::default(),
            log: Vec::new(),
        }
    }

    /// Runs so many frames, and tells of the first difference; if there is none, how much there was to differ.
    fn frames(mut self, frames: usize, mut fault: Option<Fault>) -> Result<Tally, String> {
        let mut tally = Tally::default();
        for frame in 0..frames {
            let changes = if frame == 0 {
                self.set_the_scene();
                Vec::new()
            } else {
                self.draw_changes()
            };
            if self.plan.is_switched && self.rng.random_bool(0.1) {
                let enabled = self.rng.random();
                self.log.push((frame, format!("enabled: {enabled}")));
                set_enabled(&mut self.apps[1], enabled);
            }
            self.play(frame, changes);
            let [bevys, ours] = &mut self.apps;
            fault = fault.filter(|fault| frame < fault.frame || !(fault.act)(ours.world_mut()));
            let (theirs, our) = (take(bevys), take(ours));
            if let Some(difference) = difference(&theirs, &our) {
                let Self { seed, log, .. } = &self;
                let mut message = format!("seed {seed}, frame {frame}: {}", difference.message);
                let names: Vec<String> = difference.concerns.iter().map(Entity::to_string).collect();
                for (frame, what) in log.iter().filter(|(_, what)| concerns(what, &names)) {
                    write!(message, "\n  before frame {frame}: {what}").expect("strings can be written to");
                }
                return Err(message);
            }
            tally.count(&theirs);
            let [world, other] = [bevys.world(), ours.world()];
            self.cast.retain(|entity| {
                let exists = world.get_entity(entity).is_ok();
                assert_eq!(exists, other.get_entity(entity).is_ok(), "{entity} is in one app alone");
                exists
            });
        }
        Ok(tally)
    }

    fn set_the_scene(&mut self) {
        for _ in 0..2 {
            let carrier = views::spawn_carrier(&mut self.rng);
            self.play_one(0, &carrier);
        }
        for _ in 0..Skin::JOINTS {
            let joint = things::spawn_joint(&mut self.rng);
            self.play_one(0, &joint);
        }
        self.play_many(2, things::spawn_rig);
        self.play_many(self.plan.things, things::spawn);
        self.play_many(self.plan.cameras, views::spawn);
        self.play_many(self.plan.lights, lights::spawn);
    }

    fn play_many(&mut self, count: usize, way: fn(&mut ChaCha8Rng, &Cast) -> Option<Change>) {
        for _ in 0..count {
            if let Some(change) = way(&mut self.rng, &self.cast) {
                self.play_one(0, &change);
            }
        }
    }

    fn draw_changes(&mut self) -> Vec<Change> {
        let Self { plan, rng, cast, .. } = self;
        if rng.random_bool(plan.stillness) {
            return Vec::new();
        }
        let count = rng.random_range(1..=plan.most_changes);
        let draw_one = |_| {
            let ways: &[Way] = match rng.random_range(0..20) {
                0..=10 => things::WAYS,
                11..=12 => bounds::WAYS,
                13 => third_party::WAYS,
                14..=16 if plan.lights > 0 => lights::WAYS,
                _ => views::WAYS,
            };
            draw(ways, rng, cast)
        };
        let mut changes: Vec<Change> = (0..count).filter_map(draw_one).collect();
        // More go than come: children with their parents.
        if cast.count(Role::Thing) < plan.things {
            changes.extend((0..4).filter_map(|_| things::spawn(rng, cast)));
        }
        if cast.count(Role::Camera) < plan.cameras {
            changes.extend(views::spawn(rng, cast));
        }
        if cast.count(Role::Light) < plan.lights {
            changes.extend(lights::spawn(rng, cast));
        }
        changes
    }

    /// Makes the changes in both apps, at some point of the frame, and runs it.
    fn play(&mut self, frame: usize, changes: Vec<Change>) {
        for change in changes {
            // Who is born within a frame is not known before it is over.
            let when = match self.rng.random_range(0..4) {
                0 if change.role().is_none() => When::Update,
                1 if change.role().is_none() => When::Last,
                _ => When::Between,
            };
            if when == When::Between {
                self.play_one(frame, &change);
                continue;
            }
            self.log.push((frame, format!("{} in {when:?}", change.what)));
            for app in &mut self.apps {
                let script = &mut app.world_mut().resource_mut::<Script>().0;
                script.entry(when).or_default().push(change.clone());
            }
        }
        for app in &mut self.apps {
            app.update();
        }
    }

    fn play_one(&mut self, frame: usize, change: &Change) {
        let [born, other] = self.apps.each_mut().map(|app| change.act(app.world_mut()));
        assert_eq!(born, other, "the apps count entities alike");
        let name = born.map_or_else(String::new, |entity| format!("{entity} "));
        self.log.push((frame, format!("{name}{}", change.what)));
        if let (Some(role), Some(entity)) = (change.role(), born) {
            self.cast.enter(role, entity);
        }
    }
}

/// Whether any of these entities is named.
fn concerns(what: &str, names: &[String]) -> bool {
    let mut words = what.split(|character: char| !character.is_alphanumeric());
    words.any(|word| names.iter().any(|name| name == word))
}

/// Runs as many frames as asked for, or `share` of a thousand, each some hundred in apps of their own.
fn assert_agree(plan: Plan, share: f64, apps: impl Fn() -> [App; 2]) {
    const FRAMES_PER_RUN: usize = 100;
    let number = |name| std::env::var(name).ok().map(|n| n.parse::<u64>().expect("a number"));
    let (asked, seed) = (number("PROPERTY_CASES"), number("PROPERTY_SEED"));
    let frames = (asked.unwrap_or(1000) as f64 * share).ceil() as usize;
    let fresh = || asked.map(|_| rand::random());
    let first = seed.or_else(fresh).unwrap_or(0);
    for run in 0..frames.div_ceil(FRAMES_PER_RUN) as u64 {
        let run = Run::new(plan, first.wrapping_add(run), apps());
        if let Err(difference) = run.frames(FRAMES_PER_RUN.min(frames), None) {
            panic!("{difference}");
        }
    }
}

#[test]
fn cameras_see_what_bevy_says_frame_by_frame() {
    assert_agree(VIEWS, 0.4, || [bevys(), ours()]);
}

#[test]
fn lights_see_what_bevy_says_frame_by_frame() {
    assert_agree(LIGHTS, 0.3, || [bevys(), ours()]);
}

#[test]
fn culling_may_be_switched_off_and_on_at_any_time() {
    let plan = Plan {
        is_switched: true,
        ..LIGHTS
    };
    assert_agree(plan, 0.2, || [bevys(), ours()]);
}

#[test]
fn culling_that_is_handed_back_to_bevy_is_bevys() {
    assert_agree(LIGHTS, 0.1, || [bevys(), handed_back()]);
}
