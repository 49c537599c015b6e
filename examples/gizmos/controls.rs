//! The keys, the mouse and the legend.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    kinds::{KINDS, Structure, StructureCount, switch_structure},
    panel::panel,
};

/// How many lines there may be.
const LIMITS: [usize; 4] = [1_200, 12_000, 60_000, 600_000];

const HELP: &str = "\
, .: level by level    L: limit    click: one thing
W A S D E Q, right mouse button: fly";

#[derive(Component)]
struct Legend;

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, set_up)
        .add_systems(
            Update,
            (
                press,
                switch_structure.run_if(|keys: Res<ButtonInput<KeyCode>>| keys.just_pressed(KeyCode::Digit9)),
                tell,
            ),
        )
        .add_observer(show_clicked);
}

fn set_up(mut commands: Commands, mut store: ResMut<GizmoConfigStore>) {
    commands.spawn(panel(Legend, "loading"));
    let (_, gizmos) = store.config_mut::<SightlineGizmos>();
    (gizmos.nodes, gizmos.frusta) = (true, true);
}

fn press(keys: Res<ButtonInput<KeyCode>>, mut store: ResMut<GizmoConfigStore>) {
    // Nothing is written to where nothing is pressed.
    if keys.get_just_pressed().len() == 0 {
        return;
    }
    let (_, gizmos) = store.config_mut::<SightlineGizmos>();
    for kind in KINDS.iter().filter(|kind| keys.just_pressed(kind.key)) {
        (kind.switch)(gizmos);
    }
    let (first, last) = (*gizmos.depths.start(), *gizmos.depths.end());
    let is_one = first == last;
    if keys.just_pressed(KeyCode::Period) {
        let next = if is_one { first + 1 } else { 0 };
        gizmos.depths = next..=next;
    }
    if keys.just_pressed(KeyCode::Comma) {
        gizmos.depths = match first.checked_sub(1).filter(|_| is_one) {
            Some(previous) => previous..=previous,
            None => 0..=usize::MAX,
        };
    }
    if keys.just_pressed(KeyCode::KeyL) {
        let greater = LIMITS.into_iter().find(|&limit| limit > gizmos.limit);
        gizmos.limit = greater.unwrap_or(LIMITS[0]);
    }
}

/// Shows what is known of a thing that is clicked, or no more.
fn show_clicked(click: On<Pointer<Click>>, mut commands: Commands, shown: Query<Has<ShowGizmos>>) {
    if click.button != PointerButton::Primary {
        return;
    }
    match shown.get(click.entity) {
        Ok(true) => {
            commands.entity(click.entity).remove::<ShowGizmos>();
        }
        Ok(false) => {
            let everything = ShowGizmos {
                volume: Some(BoundingKind::Hull),
                ..default()
            };
            commands.entity(click.entity).insert(everything);
        }
        Err(_) => {}
    }
}

fn tell(
    stats: Res<SightlineGizmoStats>,
    structure: Res<Structure>,
    structure_count: Res<StructureCount>,
    store: Res<GizmoConfigStore>,
    mut text: Single<&mut Text, With<Legend>>,
) {
    let (_, gizmos) = store.config::<SightlineGizmos>();
    let kinds = KINDS.iter().map(|kind| (kind.name, (kind.count)(&stats)));
    let all = kinds.chain([(structure.name(), structure_count.0)]);
    let mut legend = String::new();
    for (number, (name, count)) in (1..).zip(all) {
        let count = match count {
            GizmoCount { drawn: 0, left_out: 0 } => String::new(),
            GizmoCount { drawn, left_out } => format!(": {drawn} drawn, {left_out} left out"),
        };
        legend.push_str(&format!("{number}  {name}{count}\n"));
    }
    let depths = match (gizmos.depths.start(), gizmos.depths.end()) {
        (first, last) if first == last => format!("level {first}"),
        _ => "all levels".into(),
    };
    text.0 = format!(
        "{legend}\n{depths}, up to {} lines of each, {} of single things\n\n{HELP}",
        gizmos.limit, stats.entities.drawn
    );
}
