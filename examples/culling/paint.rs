//! Bright is what the flying camera has kept, dark is what was culled.

use std::any::TypeId;

use bevy::{
    camera::visibility::VisibleEntities, camera_controller::free_camera::FreeCamera, platform::collections::HashMap,
    prelude::*,
};

/// What is left of a colour.
const DIMMED: f32 = 0.05;

/// The two looks of a thing.
#[derive(Component)]
struct Looks {
    kept: Handle<StandardMaterial>,
    culled: Handle<StandardMaterial>,
}

pub fn plugin(app: &mut App) {
    app.add_systems(Update, (dim, paint).chain());
}

/// Darkens all that is new.
fn dim(
    mut commands: Commands,
    mut things: Query<(Entity, &mut MeshMaterial3d<StandardMaterial>), (Added<Mesh3d>, With<Name>)>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut dimmed: Local<HashMap<AssetId<StandardMaterial>, Handle<StandardMaterial>>>,
) {
    for (entity, mut look) in &mut things {
        let kept = look.0.clone();
        let culled = dimmed.entry(kept.id()).or_insert_with(|| {
            let bright = materials.get(&kept).cloned().unwrap_or_default();
            materials.add(StandardMaterial {
                base_color: (bright.base_color.to_linear() * DIMMED).into(),
                reflectance: 0.0,
                ..bright
            })
        });
        look.0 = culled.clone();
        let culled = culled.clone();
        commands.entity(entity).insert(Looks { kept, culled });
    }
}

/// Repaints what entered the view in the last frame and what left it, by comparison with the sorted list before that.
///
/// Not through `VisibleSet`, which rests while Bevy culls.
fn paint(
    flying: Single<&VisibleEntities, With<FreeCamera>>,
    mut before: Local<Vec<Entity>>,
    mut things: Query<(&Looks, &mut MeshMaterial3d<StandardMaterial>)>,
) {
    let now = flying.get(TypeId::of::<Mesh3d>());
    let is_in = |list: &[Entity], entity: &Entity| list.binary_search(entity).is_ok();
    for left in before.iter().filter(|entity| !is_in(now, entity)) {
        if let Ok((looks, mut look)) = things.get_mut(*left) {
            look.0 = looks.culled.clone();
        }
    }
    for entered in now.iter().filter(|entity| !is_in(&before, entity)) {
        if let Ok((looks, mut look)) = things.get_mut(*entered) {
            look.0 = looks.kept.clone();
        }
    }
    now.clone_into(&mut before);
}
