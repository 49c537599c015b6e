//! A bar to be dragged: the bias of the player's camera.

use bevy::{
    picking::{
        PickingSystems,
        backend::{HitData, PointerHits},
        pointer::{PointerId, PointerLocation},
    },
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::views::Player;

/// The bias at the ends of the bar is this power of two.
const ENDS: f32 = 4.0;
/// What an arrow key does in a second, on the same scale.
const SPEED: f32 = 2.0;
/// In logical pixels.
const WIDTH: f32 = 320.0;
const HEIGHT: f32 = 16.0;
/// In front of all that is in the scene, for pointers.
const ORDER: f32 = 1000.0;

#[derive(Component)]
struct Track;

/// The part of the track up to the value.
#[derive(Component)]
struct Fill;

#[derive(Component)]
struct Caption;

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, spawn)
        .add_systems(PreUpdate, pick_track.in_set(PickingSystems::Backend))
        .add_systems(Update, (turn_by_keys, show).chain());
}

fn spawn(mut commands: Commands) {
    let panel = Node {
        position_type: PositionType::Absolute,
        left: px(12),
        bottom: px(12),
        padding: UiRect::axes(px(12), px(8)),
        row_gap: px(6),
        flex_direction: FlexDirection::Column,
        border_radius: BorderRadius::all(px(6)),
        ..default()
    };
    let track = Node {
        width: px(WIDTH),
        height: px(HEIGHT),
        border_radius: BorderRadius::all(px(HEIGHT / 2.0)),
        ..default()
    };
    let fill = Node {
        width: percent(50),
        height: percent(100),
        border_radius: BorderRadius::all(px(HEIGHT / 2.0)),
        border: UiRect::right(px(6)),
        ..default()
    };
    commands
        .spawn((
            panel,
            BackgroundColor(Color::srgba(0.05, 0.08, 0.12, 0.75)),
            Pickable::IGNORE,
        ))
        .with_children(|panel| {
            let text = (Text::new(""), TextFont::from_font_size(14.0), Pickable::IGNORE);
            panel.spawn((Caption, text));
            panel
                .spawn((Track, track, BackgroundColor(Color::srgb(0.22, 0.26, 0.32))))
                .with_child((
                    Fill,
                    fill,
                    BackgroundColor(Color::srgb(0.40, 0.62, 0.95)),
                    BorderColor::all(Color::WHITE),
                    Pickable::IGNORE,
                ))
                .observe(|press: On<Pointer<Press>>, slider: Slider| slider.drag_to(&press.pointer_location.position))
                .observe(|drag: On<Pointer<Drag>>, slider: Slider| slider.drag_to(&drag.pointer_location.position));
        });
}

/// The bar and what it sets.
#[derive(bevy::ecs::system::SystemParam)]
struct Slider<'w, 's> {
    track: Single<'w, 's, (&'static ComputedNode, &'static UiGlobalTransform), With<Track>>,
    player: Single<'w, 's, (&'static Camera, &'static mut LodBias), With<Player>>,
}

impl Slider<'_, '_> {
    /// Sets the value to where a pointer is in the window.
    fn drag_to(mut self, pointer: &Vec2) {
        let (node, transform) = *self.track;
        let (camera, bias) = &mut *self.player;
        let pixel = pointer * camera.target_scaling_factor().unwrap_or(1.0);
        if let Some(place) = node.normalize_point(*transform, pixel) {
            bias.0 = (2.0 * place.x.clamp(-0.5, 0.5) * ENDS).exp2();
        }
    }
}

/// Lets pointers find the bar. Bevy does that of all nodes with its feature `ui_picking`.
fn pick_track(
    pointers: Query<(&PointerId, &PointerLocation)>,
    track: Single<(Entity, &ComputedNode, &UiGlobalTransform), With<Track>>,
    player: Single<(Entity, &Camera), With<Player>>,
    mut hits: MessageWriter<PointerHits>,
) {
    let (track, node, transform) = *track;
    let (player, camera) = *player;
    let scale = camera.target_scaling_factor().unwrap_or(1.0);
    for (&pointer, location) in &pointers {
        let is_over = location
            .location()
            .is_some_and(|location| node.contains_point(*transform, location.position * scale));
        if is_over {
            let hit = HitData::new(player, 0.0, None, None);
            hits.write(PointerHits::new(pointer, vec![(track, hit)], ORDER));
        }
    }
}

fn turn_by_keys(keys: Res<ButtonInput<KeyCode>>, time: Res<Time>, mut bias: Single<&mut LodBias, With<Player>>) {
    let up = f32::from(keys.pressed(KeyCode::ArrowRight)) - f32::from(keys.pressed(KeyCode::ArrowLeft));
    if up != 0.0 {
        let power = bias.0.log2() + up * SPEED * time.delta_secs();
        bias.0 = power.clamp(-ENDS, ENDS).exp2();
    }
}

fn show(
    bias: Single<&LodBias, (With<Player>, Changed<LodBias>)>,
    mut fill: Single<&mut Node, With<Fill>>,
    mut caption: Single<&mut Text, With<Caption>>,
) {
    let part = 0.5 + 0.5 * bias.0.log2() / ENDS;
    // So that the end of it can be seen.
    fill.width = percent(100.0 * part.clamp(0.03, 1.0));
    caption.0 = format!("LodBias of this camera: {:.2}   (drag, or arrow keys)", bias.0);
}
