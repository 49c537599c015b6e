//! A script that plays the mouse and the keys of a window, and takes pictures of it: what made the pictures in `docs/`.
//!
//! Every example takes `--play SCRIPT`, for instance `--play "click 0.2,0.5; wait 30; shot out/city.png"`. It starts when
//! all models are loaded, and the example ends with it. Until then no time passes, and from then on a sixtieth of a second
//! in each frame: what moves is in the same place whenever a script is played.

use std::{path::PathBuf, str::FromStr, time::Duration};

use bevy::{
    input::{
        ButtonState,
        keyboard::{Key, KeyboardInput},
        mouse::MouseButtonInput,
    },
    prelude::*,
    reflect::enums::{DynamicEnum, DynamicVariant},
    render::view::screenshot::{Capturing, Screenshot, save_to_disk},
    time::TimeUpdateStrategy,
    window::{PrimaryWindow, WindowEvent},
};

/// The argument before a script.
pub const OPTION: &str = "--play";

/// What all examples say of it.
pub const HELP: &str = "
In a window, all examples:
  --play SCRIPT    play mouse and keys, and end; of these, parted by semicolons:
                     move X,Y  click X,Y  press  release  key NAME  hold NAME  let NAME  wait FRAMES  shot FILE
                   with X and Y from 0 to 1, and the names of keys as Bevy has them";

/// What happens in one frame.
#[derive(Clone, Debug, PartialEq)]
enum Act {
    /// From (0, 0) at the top left of the window to (1, 1).
    Move(Vec2),
    Button(ButtonState),
    Key(KeyCode, ButtonState),
    Rest,
    Shot(PathBuf),
}

struct Script(Vec<Act>);

/// Where the script is played, in `Last`: an example that has more to wait for than its models says so by a condition.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PlayScript;

/// How far a script is.
#[derive(Resource)]
struct Playing {
    acts: Vec<Act>,
    next: usize,
}

impl FromStr for Script {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        use ButtonState::{Pressed, Released};
        let mut acts = Vec::new();
        for order in text.split(';').map(str::trim).filter(|order| !order.is_empty()) {
            let (verb, what) = order.split_once(' ').unwrap_or((order, ""));
            let what = what.trim();
            match verb {
                "move" => acts.push(Act::Move(place(what)?)),
                "press" => acts.push(Act::Button(Pressed)),
                "release" => acts.push(Act::Button(Released)),
                "click" => acts.extend([
                    Act::Move(place(what)?),
                    Act::Rest,
                    Act::Button(Pressed),
                    Act::Button(Released),
                    Act::Rest,
                ]),
                "hold" => acts.push(Act::Key(key(what)?, Pressed)),
                "let" => acts.push(Act::Key(key(what)?, Released)),
                "key" => acts.extend([Act::Key(key(what)?, Pressed), Act::Key(key(what)?, Released)]),
                "wait" => {
                    let frames = what.parse().map_err(|_| format!("{what} is no number of frames"))?;
                    acts.extend(std::iter::repeat_n(Act::Rest, frames));
                }
                "shot" => acts.push(Act::Shot(what.into())),
                _ => return Err(format!("{order} is not in the language of scripts\n{HELP}")),
            }
        }
        Ok(Self(acts))
    }
}

fn place(text: &str) -> Result<Vec2, String> {
    let numbers = text.split_once(',');
    let place = numbers.and_then(|(x, y)| Some(Vec2::new(x.trim().parse().ok()?, y.trim().parse().ok()?)));
    place.ok_or_else(|| format!("{text} is no place: two numbers, parted by a comma"))
}

fn key(name: &str) -> Result<KeyCode, String> {
    KeyCode::from_reflect(&DynamicEnum::new(name, DynamicVariant::Unit))
        .ok_or_else(|| format!("no key is named {name}"))
}

/// Whether the command line says what to play.
pub fn is_given() -> bool {
    std::env::args().any(|argument| argument == OPTION)
}

/// Plays what the command line says, if it does.
///
/// # Panics
///
/// If that is not in the language of scripts.
pub fn plugin(app: &mut App) {
    let mut arguments = std::env::args().skip_while(|argument| argument != OPTION).skip(1);
    if let Some(text) = arguments.next() {
        let Script(acts) = text.parse().unwrap_or_else(|error| panic!("{error}"));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs(1) / 60))
            .insert_resource(Playing { acts, next: 0 })
            .add_systems(Startup, |mut time: ResMut<Time<Virtual>>| time.pause())
            .add_systems(Last, play.in_set(PlayScript));
    }
}

fn play(world: &mut World) {
    if world.query::<&Capturing>().iter(world).next().is_some() {
        return;
    }
    if world.resource::<Playing>().next == 0 {
        match super::is_loaded(world) {
            Ok(true) => world.resource_mut::<Time<Virtual>>().unpause(),
            Ok(false) => return,
            Err(error) => panic!("{error}"),
        }
    }
    let mut playing = world.resource_mut::<Playing>();
    let act = playing.acts.get(playing.next).cloned();
    playing.next += 1;
    match act {
        Some(act) => perform(world, act),
        None => {
            world.write_message(AppExit::Success);
        }
    }
}

/// Has the next frame find what the window system would have told.
fn perform(world: &mut World, act: Act) {
    let Ok((window, mut properties)) = world
        .query_filtered::<(Entity, &mut Window), With<PrimaryWindow>>()
        .single_mut(world)
    else {
        return;
    };
    match act {
        Act::Rest => {}
        Act::Move(place) => {
            let position = place * properties.size();
            // The window system must not move its own pointer, and tell of that when the script is elsewhere.
            let properties = properties.bypass_change_detection();
            properties.set_cursor_position(Some(position));
            tell(
                world,
                CursorMoved {
                    window,
                    position,
                    delta: None,
                },
            );
        }
        Act::Button(state) => tell(
            world,
            MouseButtonInput {
                button: MouseButton::Left,
                state,
                window,
            },
        ),
        Act::Key(key_code, state) => tell(
            world,
            KeyboardInput {
                key_code,
                logical_key: Key::Unidentified(bevy::input::keyboard::NativeKey::Unidentified),
                state,
                text: None,
                repeat: false,
                window,
            },
        ),
        Act::Shot(file) => {
            if let Some(folder) = file.parent() {
                std::fs::create_dir_all(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
            }
            world.spawn(Screenshot::primary_window()).observe(save_to_disk(file));
        }
    }
}

/// As the window system does: by itself, and among all that happens to windows.
fn tell<M: Message + Clone + Into<WindowEvent>>(world: &mut World, message: M) {
    world.write_message::<WindowEvent>(message.clone().into());
    world.write_message(message);
}
