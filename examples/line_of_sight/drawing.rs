//! What only a window can show: fans of light on the ground, lines of sight, colours and words.

use bevy::{
    asset::RenderAssetUsages,
    color::palettes::tailwind::{AMBER_400, GREEN_400, RED_400, RED_500, SLATE_300},
    gizmos::config::{DefaultGizmoConfigGroup, GizmoConfigStore},
    light::NotShadowCaster,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    guards::{self, Effort, FAN, Guard, RANGE, Sight, State},
    panel::panel,
    thief::{Person, Thief},
};

const HELP: &str = "Arrow keys or W A S D: lead the thief    R: let it go its own way    Space: hold still";

/// The fan of a guard on the ground.
#[derive(Component)]
struct Fan(Entity);

/// The share of the thief that is seen, over its head.
#[derive(Component)]
struct Share;

/// Who sees how much.
#[derive(Component)]
struct Figures;

/// What it takes, and what to do.
#[derive(Component)]
struct Cost;

/// The looks of guards and of their fans, state by state.
#[derive(Resource)]
struct Looks {
    guards: [Handle<StandardMaterial>; 3],
    fans: [Handle<StandardMaterial>; 3],
}

const STATES: [State; 3] = [State::Calm, State::Blocked, State::Sees];

/// The colour of what a guard is doing.
pub fn color(state: State) -> Srgba {
    match state {
        State::Calm => GREEN_400,
        State::Blocked => AMBER_400,
        State::Sees => RED_500,
    }
}

pub fn plugin(app: &mut App) {
    app.add_systems(PostStartup, set_up)
        .add_systems(Update, (hold_still, label, tell))
        .add_systems(PostUpdate, (spread_fans, draw_lines, tint).after(guards::look));
}

fn set_up(
    mut commands: Commands,
    guards: Query<Entity, With<Guard>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    let (config, _) = gizmos.config_mut::<DefaultGizmoConfigGroup>();
    config.line.width = 3.0;
    let looks = Looks {
        guards: STATES.map(|state| {
            let color = Color::from(color(state));
            materials.add(match state {
                State::Calm => StandardMaterial::default(),
                _ => StandardMaterial {
                    base_color: color,
                    emissive: LinearRgba::from(color) * 0.3,
                    ..default()
                },
            })
        }),
        fans: STATES.map(|state| {
            materials.add(StandardMaterial {
                base_color: color(state).into(),
                unlit: true,
                alpha_mode: AlphaMode::Blend,
                cull_mode: None,
                ..default()
            })
        }),
    };
    for guard in &guards {
        // From the middle to two ends each.
        let triangles = (1..FAN as u32).flat_map(|n| [0, n, n + 1]);
        let fan = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![Vec3::ZERO; FAN + 1])
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![Vec3::Y; FAN + 1])
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![Vec4::ONE; FAN + 1])
            .with_inserted_indices(Indices::U32(triangles.collect()));
        commands.spawn((
            Fan(guard),
            Mesh3d(meshes.add(fan)),
            MeshMaterial3d(looks.fans[0].clone()),
            NoSpatialIndex,
            NotShadowCaster,
            bevy::camera::visibility::NoFrustumCulling,
        ));
    }
    commands.insert_resource(looks);
    commands.spawn(panel(Figures, ""));
    commands.spawn((
        Node {
            position_type: PositionType::Absolute,
            bottom: px(12),
            width: percent(100),
            justify_content: JustifyContent::Center,
            ..default()
        },
        children![(
            Cost,
            Text::default(),
            TextFont::from_font_size(15.0),
            TextLayout::justify(Justify::Center)
        )],
    ));
    commands.spawn((
        Share,
        Text::default(),
        TextFont::from_font_size(22.0),
        TextShadow {
            offset: Vec2::splat(1.5),
            color: Color::BLACK,
        },
        Node {
            position_type: PositionType::Absolute,
            ..default()
        },
    ));
    commands
        .spawn((
            Node {
                position_type: PositionType::Absolute,
                right: px(12),
                top: px(12),
                padding: UiRect::axes(px(12), px(8)),
                row_gap: px(4),
                flex_direction: FlexDirection::Column,
                border_radius: BorderRadius::all(px(6)),
                ..default()
            },
            BackgroundColor(Color::srgba(0.05, 0.08, 0.12, 0.75)),
        ))
        .with_children(|legend| {
            for (state, meaning) in [
                (State::Calm, "looks, and the thief is elsewhere"),
                (State::Blocked, "something is in the way: the cross"),
                (State::Sees, "sees the thief: a line to each point seen"),
            ] {
                legend.spawn((
                    Node {
                        column_gap: px(8),
                        align_items: AlignItems::Center,
                        ..default()
                    },
                    children![
                        (
                            Node {
                                width: px(14),
                                height: px(14),
                                border_radius: BorderRadius::all(px(7)),
                                ..default()
                            },
                            BackgroundColor(color(state).into()),
                        ),
                        (Text::new(meaning), TextFont::from_font_size(15.0)),
                    ],
                ));
            }
        });
}

fn hold_still(keys: Res<ButtonInput<KeyCode>>, mut time: ResMut<Time<Virtual>>) {
    if keys.just_pressed(KeyCode::Space) {
        time.toggle();
    }
}

/// Lays each fan on the ground, brightest at the guard.
fn spread_fans(fans: Query<(&Fan, &Mesh3d)>, sights: Query<&Sight>, mut meshes: ResMut<Assets<Mesh>>) {
    for (fan, mesh) in &fans {
        let (Ok(sight), Some(mut mesh)) = (sights.get(fan.0), meshes.get_mut(mesh)) else {
            continue;
        };
        let flat = |place: Vec3| place.with_y(0.03);
        let middle = flat(sight.eye);
        let brightness = |place: Vec3| 0.62 - 0.50 * (place.distance(middle) / RANGE).min(1.0);
        let places: Vec<Vec3> = std::iter::once(middle)
            .chain(sight.fan.iter().copied().map(flat))
            .collect();
        let colors: Vec<Vec4> = places
            .iter()
            .map(|&place| Vec3::ONE.extend(brightness(place)))
            .collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, places);
        mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    }
}

/// The lines of sight, of every guard that has the thief before it.
pub fn lines(sight: &Sight) -> Vec<[Vec3; 2]> {
    match (sight.state, sight.blocked_at) {
        (State::Sees, _) => sight.points.iter().map(|&point| [sight.eye, point]).collect(),
        (State::Blocked, Some(end)) => {
            let mut lines = vec![[sight.eye, end]];
            // Across the line, towards where it comes from, so that it is not inside of what it ends at.
            let back = (sight.eye - end).normalize_or_zero();
            let side = back.cross(Vec3::Y).normalize_or(Vec3::X);
            for arm in [side + Vec3::Y, side - Vec3::Y] {
                let arm = arm * 0.25;
                lines.push([end - arm + 0.1 * back, end + arm + 0.1 * back]);
            }
            lines
        }
        _ => Vec::new(),
    }
}

fn draw_lines(sights: Query<&Sight>, mut gizmos: Gizmos) {
    for sight in &sights {
        let color = if sight.state == State::Sees { RED_400 } else { SLATE_300 };
        for [from, to] in lines(sight) {
            gizmos.line(from, to, color);
        }
    }
}

/// Colours the guards and their fans.
fn tint(
    looks: Res<Looks>,
    mut guards: Query<(&Sight, &mut MeshMaterial3d<StandardMaterial>)>,
    mut fans: Query<(&Fan, &mut MeshMaterial3d<StandardMaterial>), Without<Sight>>,
) {
    for (sight, mut look) in &mut guards {
        look.0 = looks.guards[sight.state as usize].clone();
    }
    for (fan, mut look) in &mut fans {
        if let Ok((sight, _)) = guards.get(fan.0) {
            look.0 = looks.fans[sight.state as usize].clone();
        }
    }
}

/// Keeps the share over the head of the thief.
fn label(
    camera: Single<(&Camera, &GlobalTransform)>,
    thief: Single<&GlobalTransform, With<Thief>>,
    sights: Query<&Sight>,
    text: Single<(&mut Text, &mut TextColor, &mut Node), With<Share>>,
) {
    let (camera, eye) = *camera;
    let (mut text, mut ink, mut node) = text.into_inner();
    let share = sights.iter().map(|sight| sight.share).fold(0.0, f32::max);
    let state = sights.iter().map(|sight| sight.state).max_by_key(|&state| state as u8);
    text.0 = if share > 0.0 {
        format!("{:.0}% seen", 100.0 * share)
    } else {
        "unseen".into()
    };
    ink.0 = match state {
        Some(State::Sees) => RED_400.into(),
        _ => Color::WHITE,
    };
    let head = thief.translation() + Vec3::Y * 1.9 * Person::SCALE;
    if let Ok(place) = camera.world_to_viewport(eye, head) {
        node.left = px(place.x - 42.0);
        node.top = px(place.y - 34.0);
    }
}

fn tell(
    scene: SceneQuery,
    camera: Single<Entity, With<Camera>>,
    thief: Single<Entity, With<Thief>>,
    sights: Query<(&Guard, &Sight)>,
    effort: Res<Effort>,
    figures: Single<Entity, With<Figures>>,
    cost: Single<Entity, With<Cost>>,
    mut texts: Query<&mut Text>,
) {
    let rows = sights.iter().map(|(guard, sight)| {
        let news = match sight.state {
            State::Calm => "looks elsewhere".into(),
            State::Blocked if sight.share > 0.0 => format!("glimpses {:.0}%", 100.0 * sight.share),
            State::Blocked => "has something in the way".into(),
            State::Sees => {
                let (share, points) = (100.0 * sight.share, sight.points.len());
                format!("sees {share:.0}%, {points} of {} points", Person::POINTS.len())
            }
        };
        format!("guard {} {news}\n", guard.number)
    });
    let seen = scene.visible_fraction(*camera, *thief, 256, &SceneQuerySettings::default());
    let rows: String = rows.collect();
    if let Ok(mut text) = texts.get_mut(*figures) {
        text.0 = format!("{rows}you see {:.0}% of the thief", 100.0 * seen.unwrap_or(0.0));
    }
    if let Ok(mut text) = texts.get_mut(*cost) {
        let ms = effort.took.as_secs_f64() * 1e3;
        text.0 = format!(
            "{} rays and {} lines of sight in {ms:.1} ms\n{HELP}",
            effort.rays, effort.lines
        );
    }
}
