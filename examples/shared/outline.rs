//! A box or a lasso that is drawn with the mouse, and how it looks.

use bevy::{
    color::palettes::tailwind::SKY_300,
    ecs::system::SystemParam,
    input::{ButtonState, mouse::MouseButtonInput},
    prelude::*,
    window::PrimaryWindow,
};
use bevy_sightline::prelude::*;

/// How far the mouse moves, in pixels, before a lasso gets another corner.
const STEP: f32 = 3.0;
/// Between the lines that fill the outline, in pixels.
const HATCHING: f32 = 4.0;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    Box,
    Lasso,
}

/// What is being drawn, or was last.
#[derive(Resource, Default)]
pub struct Marquee {
    /// Two opposite corners, or of a lasso all.
    places: Vec<Vec2>,
    is_lasso: bool,
    pub is_drawing: bool,
}

/// The mouse that draws.
#[derive(SystemParam)]
pub struct Mouse<'w, 's> {
    buttons: Res<'w, ButtonInput<MouseButton>>,
    window: Single<'w, 's, &'static Window, With<PrimaryWindow>>,
    moves: MessageReader<'w, 's, CursorMoved>,
}

impl Mouse<'_, '_> {
    /// Whether the left button was pressed in this frame.
    #[allow(dead_code, reason = "where every drag draws, nobody asks")]
    pub fn has_just_pressed(&self) -> bool {
        self.buttons.just_pressed(MouseButton::Left)
    }
}

impl Marquee {
    /// Draws on as long as the left button is held. Where it is pressed, begins what the mouse is to draw, if anything.
    pub fn follow(&mut self, mouse: &mut Mouse, outline: Option<Outline>) {
        // All of them, so that a lasso is as fine as the hand that draws it, whatever the frame rate.
        let mut places = mouse.moves.read().map(|moved| moved.position);
        if !mouse.buttons.pressed(MouseButton::Left) {
            self.is_drawing = false;
            return;
        }
        if !self.is_drawing {
            let Some(outline) = outline else {
                return;
            };
            let Some(place) = places.next().or(mouse.window.cursor_position()) else {
                return;
            };
            self.begin(place, outline);
        }
        for place in places {
            self.draw_to(place);
        }
    }

    fn begin(&mut self, place: Vec2, outline: Outline) {
        self.places.clear();
        self.places.push(place);
        (self.is_lasso, self.is_drawing) = (outline == Outline::Lasso, true);
    }

    fn draw_to(&mut self, place: Vec2) {
        if !self.is_lasso {
            self.places.truncate(1);
            self.places.push(place);
        } else if self.places.last().is_none_or(|last| last.distance(place) >= STEP) {
            self.places.push(place);
        }
    }

    /// The corners of the outline, in logical pixels.
    pub fn corners(&self) -> Vec<Vec2> {
        match self.places[..] {
            [a, b] if !self.is_lasso => vec![a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)],
            _ => self.places.clone(),
        }
    }

    /// What is within, if that is anything.
    pub fn region(&self) -> Option<ScreenRegion> {
        match self.places[..] {
            [a, b] if !self.is_lasso => Some(ScreenRegion::rect(a, b)),
            _ => ScreenRegion::polygon(&self.places).ok(),
        }
    }
}

/// Moves the mouse of an app without a window from place to place with the left button held, one in a frame.
pub fn draw_by_script(app: &mut App, held: Option<KeyCode>, places: &[Vec2]) {
    let world = app.world_mut();
    let mut windows = world.query_filtered::<Entity, With<PrimaryWindow>>();
    let window = windows.single(world).expect("the window plugin makes one window");
    let press = |app: &mut App, state: ButtonState| {
        app.world_mut().write_message(MouseButtonInput {
            button: MouseButton::Left,
            state,
            window,
        });
        let mut keys = app.world_mut().resource_mut::<ButtonInput<KeyCode>>();
        if let Some(key) = held {
            match state {
                ButtonState::Pressed => keys.press(key),
                ButtonState::Released => keys.release(key),
            }
        }
    };
    press(app, ButtonState::Pressed);
    for &position in places {
        app.world_mut().write_message(CursorMoved {
            window,
            position,
            delta: None,
        });
        app.update();
    }
    press(app, ButtonState::Released);
    app.update();
}

/// Lines that are in front of everything.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct OnTheScreen;

/// Draws the outline, in a window.
pub fn window_plugin(app: &mut App) {
    app.insert_gizmo_config(
        OnTheScreen,
        GizmoConfig {
            depth_bias: -1.0,
            ..default()
        },
    )
    .add_systems(PostUpdate, draw_outline.after(SpatialIndexSystems::Sync));
}

/// Draws the outline on the screen, and fills it by the even-odd rule.
fn draw_outline(marquee: Res<Marquee>, view: Single<(&Camera, &GlobalTransform)>, mut gizmos: Gizmos<OnTheScreen>) {
    if !marquee.is_drawing {
        return;
    }
    let (camera, eye) = *view;
    // Just behind the near plane.
    let lift = |place: Vec2| Some(camera.viewport_to_world(eye, place).ok()?.get_point(0.01));
    let mut line = |from: Vec2, to: Vec2, color: Srgba| {
        if let (Some(from), Some(to)) = (lift(from), lift(to)) {
            gizmos.line(from, to, color);
        }
    };
    let corners = marquee.corners();
    for [left, right] in hatching(&corners) {
        line(left, right, SKY_300.with_alpha(0.25));
    }
    for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        line(from, to, SKY_300);
    }
}

/// Level lines through a polygon, by the even-odd rule.
fn hatching(corners: &[Vec2]) -> Vec<[Vec2; 2]> {
    let heights = corners.iter().map(|corner| corner.y);
    let (top, bottom) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(top, bottom), y| {
        (top.min(y), bottom.max(y))
    });
    let mut lines = Vec::new();
    let rows = ((bottom - top) / HATCHING).max(0.0) as u32;
    for y in (0..rows).map(|row| top + (row as f32 + 0.5) * HATCHING) {
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let crossed = edges.filter(|(from, to)| (from.y > y) != (to.y > y));
        let mut crossings: Vec<f32> = crossed
            .map(|(from, to)| from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y))
            .collect();
        crossings.sort_unstable_by(f32::total_cmp);
        lines.extend(
            crossings
                .chunks_exact(2)
                .map(|pair| [Vec2::new(pair[0], y), Vec2::new(pair[1], y)]),
        );
    }
    lines
}
