//! The keys that switch what there is, at any time.

use bevy::{picking::PickingSystems, prelude::*};
use bevy_sightline::prelude::*;

use crate::{drawing::Selecting, stopwatch::Stopwatch};

/// Whether anything looks for what is under the pointer.
#[derive(Resource)]
pub struct PickingIsOn(pub bool);

/// What is drawn of the inside.
#[derive(Resource, Clone, Copy, Default, PartialEq, Eq)]
pub enum Inside {
    #[default]
    Nothing,
    Nodes,
    Boxes,
    Occluders,
    Levels,
}

impl Inside {
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "off",
            Self::Nodes => "nodes",
            Self::Boxes => "boxes",
            Self::Occluders => "occluders",
            Self::Levels => "levels",
        }
    }

    fn next(self) -> Self {
        match self {
            Self::Nothing => Self::Nodes,
            Self::Nodes => Self::Boxes,
            Self::Boxes => Self::Occluders,
            Self::Occluders => Self::Levels,
            Self::Levels => Self::Nothing,
        }
    }
}

/// The keys that make sense with whatever finds and culls.
pub fn window_plugin(app: &mut App) {
    app.insert_resource(PickingIsOn(true))
        .configure_sets(
            PreUpdate,
            PickingSystems::Backend.run_if(|is_on: Res<PickingIsOn>| is_on.0),
        )
        .add_systems(Update, switch_picking);
}

/// Those of `bevy_sightline`.
pub fn sightline_plugin(app: &mut App) {
    app.init_resource::<Inside>()
        .add_systems(Startup, configure_gizmos)
        .add_systems(Update, (switch_views, switch_occlusion, choose_selection, show_inside));
}

fn switch_picking(keys: Res<ButtonInput<KeyCode>>, mut is_on: ResMut<PickingIsOn>) {
    if keys.just_pressed(KeyCode::KeyP) {
        is_on.0 ^= true;
    }
}

fn switch_views(
    keys: Res<ButtonInput<KeyCode>>,
    mut culling: ResMut<ViewCullingSettings>,
    mut levels: ResMut<LodSettings>,
    mut watch: ResMut<Stopwatch>,
) {
    let switched = [KeyCode::KeyC, KeyCode::KeyL, KeyCode::KeyO];
    if keys.any_just_pressed(switched) {
        watch.forget();
    }
    if keys.just_pressed(KeyCode::KeyC) {
        culling.enabled ^= true;
    }
    if keys.just_pressed(KeyCode::KeyL) {
        levels.enabled ^= true;
    }
}

/// Occlusion is a component of the camera: it comes and goes at any time.
fn switch_occlusion(
    keys: Res<ButtonInput<KeyCode>>,
    mut commands: Commands,
    camera: Single<(Entity, Has<SoftwareOcclusion>), With<Camera3d>>,
) {
    if !keys.just_pressed(KeyCode::KeyO) {
        return;
    }
    match *camera {
        (camera, true) => commands.entity(camera).remove::<(SoftwareOcclusion, OcclusionBuffer)>(),
        (camera, false) => commands.entity(camera).insert(SoftwareOcclusion::default()),
    };
}

fn choose_selection(keys: Res<ButtonInput<KeyCode>>, mut selecting: ResMut<Selecting>) {
    if keys.just_pressed(KeyCode::KeyT) {
        selecting.settings.mode = match selecting.settings.mode {
            SelectionMode::Touching => SelectionMode::Enclosed,
            SelectionMode::Enclosed => SelectionMode::Touching,
        };
    }
}

fn configure_gizmos(mut store: ResMut<GizmoConfigStore>) {
    let (config, gizmos) = store.config_mut::<SightlineGizmos>();
    config.line.width = 1.5;
    gizmos.limit = 12_000;
}

fn show_inside(keys: Res<ButtonInput<KeyCode>>, mut inside: ResMut<Inside>, mut store: ResMut<GizmoConfigStore>) {
    if !keys.just_pressed(KeyCode::KeyG) {
        return;
    }
    *inside = inside.next();
    let (_, gizmos) = store.config_mut::<SightlineGizmos>();
    gizmos.nodes = *inside == Inside::Nodes;
    gizmos.leaves = *inside == Inside::Boxes;
    gizmos.occluders = *inside == Inside::Occluders;
    gizmos.lods = *inside == Inside::Levels;
}
