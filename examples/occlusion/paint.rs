//! The view from above shows what the walker sees in its colours, what is hidden from it as ghosts, and the rest dark.

use bevy::{platform::collections::HashMap, prelude::*};

use crate::sight::{Look, Sight};

/// What is left of a colour outside of the view.
const DIMMED: f32 = 0.06;
/// The colour of ghosts.
const GHOST: LinearRgba = LinearRgba::new(0.04, 0.22, 1.0, 0.5);

/// The three looks of a thing.
#[derive(Component, Clone)]
struct Looks {
    seen: Handle<StandardMaterial>,
    hidden: Handle<StandardMaterial>,
    outside: Handle<StandardMaterial>,
}

pub fn plugin(app: &mut App) {
    app.add_systems(Update, dim)
        .add_systems(PostUpdate, paint.in_set(Look).after(crate::sight::look));
}

/// Darkens all that is new.
fn dim(
    mut commands: Commands,
    mut things: Query<(Entity, &mut MeshMaterial3d<StandardMaterial>), (Added<Mesh3d>, With<Name>)>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut known: Local<HashMap<AssetId<StandardMaterial>, Looks>>,
) {
    for (entity, mut material) in &mut things {
        let seen = material.0.clone();
        let looks = known.entry(seen.id()).or_insert_with(|| {
            let bright = materials.get(&seen).cloned().unwrap_or_default();
            let outside = materials.add(StandardMaterial {
                base_color: (bright.base_color.to_linear() * DIMMED).into(),
                reflectance: 0.0,
                ..bright.clone()
            });
            let hidden = materials.add(StandardMaterial {
                base_color: GHOST.into(),
                alpha_mode: AlphaMode::Blend,
                reflectance: 0.0,
                ..bright
            });
            Looks { seen, hidden, outside }
        });
        material.0 = looks.outside.clone();
        commands.entity(entity).insert(looks.clone());
    }
}

/// Repaints what has come and gone since the last frame.
fn paint(
    sight: Res<Sight>,
    mut before: Local<Sight>,
    mut things: Query<(&Looks, &mut MeshMaterial3d<StandardMaterial>)>,
) {
    let is_in = |list: &[Entity], entity: &Entity| list.binary_search(entity).is_ok();
    let lists = [
        (&before.seen, &sight.seen),
        (&sight.seen, &before.seen),
        (&before.hidden, &sight.hidden),
        (&sight.hidden, &before.hidden),
    ];
    for (list, other) in lists {
        for entity in list.iter().filter(|entity| !is_in(other, entity)) {
            if let Ok((looks, mut material)) = things.get_mut(*entity) {
                let look = if is_in(&sight.seen, entity) {
                    &looks.seen
                } else if is_in(&sight.hidden, entity) {
                    &looks.hidden
                } else {
                    &looks.outside
                };
                material.0 = look.clone();
            }
        }
    }
    before.seen.clone_from(&sight.seen);
    before.hidden.clone_from(&sight.hidden);
}
