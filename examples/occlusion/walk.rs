//! The walker's camera, and its round through the streets.

use bevy::{camera_controller::free_camera::FreeCamera, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    options::Options,
    plan::{PITCH, Plan},
};

/// In metres above the street.
const EYE: f32 = 1.7;
/// How far before a crossing a turn begins, in metres.
const TURN: f32 = 9.0;

/// The corners of the round, in parts of the side of the city: each is in one street with the next.
const CORNERS: [Vec2; 8] = [
    Vec2::new(0.75, 0.81),
    Vec2::new(0.75, 0.44),
    Vec2::new(0.56, 0.44),
    Vec2::new(0.56, 0.25),
    Vec2::new(0.25, 0.25),
    Vec2::new(0.25, 0.62),
    Vec2::new(0.44, 0.62),
    Vec2::new(0.44, 0.81),
];

/// Sees what is not hidden.
#[derive(Component)]
pub struct Walker;

/// A closed way along the middles of streets.
#[derive(Resource)]
pub struct Round {
    corners: Vec<Vec2>,
    length: f32,
}

impl Round {
    fn new(blocks: u32) -> Self {
        let half = Plan { blocks }.half_size();
        let mut corners: Vec<Vec2> = CORNERS
            .iter()
            .map(|corner| (corner * blocks as f32).round() * PITCH - half)
            .collect();
        corners.dedup();
        let mut round = Self { corners, length: 0.0 };
        round.length = round.sides().map(|[from, to]| from.distance(to)).sum();
        round
    }

    fn sides(&self) -> impl Iterator<Item = [Vec2; 2]> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(&from, &to)| [from, to])
    }

    /// In metres.
    pub fn length(&self) -> f32 {
        self.length
    }

    /// Where one is on the sides after so many metres.
    fn point(&self, along: f32) -> Vec2 {
        let mut left = along.rem_euclid(self.length);
        for [from, to] in self.sides() {
            let side = from.distance(to);
            if left <= side {
                return from + (to - from).normalize_or_zero() * left;
            }
            left -= side;
        }
        self.corners[0]
    }

    /// The eye of the walker after so many metres: in the middle of the street, and on a curve around its corners.
    pub fn place(&self, along: f32) -> Transform {
        let [behind, ahead] = [self.point(along - TURN), self.point(along + TURN)];
        let (middle, forward) = (behind.midpoint(ahead), ahead - behind);
        let eye = Vec3::new(middle.x, EYE, middle.y);
        Transform::from_translation(eye).looking_to(Vec3::new(forward.x, 0.04 * forward.length(), forward.y), Vec3::Y)
    }
}

pub fn plugin(app: &mut App) {
    app.add_systems(PostStartup, set_out);
}

/// Makes the camera of the city the walker's.
pub fn set_out(mut commands: Commands, options: Res<Options>, camera: Single<Entity, With<Camera3d>>) {
    let round = Round::new(options.blocks);
    commands.entity(*camera).insert((
        Walker,
        SoftwareOcclusion::default(),
        round.place(0.0),
        FreeCamera {
            walk_speed: 7.0,
            run_speed: 30.0,
            // M is for the mode.
            keyboard_key_toggle_cursor_grab: KeyCode::F12,
            ..default()
        },
    ));
    commands.insert_resource(round);
}
