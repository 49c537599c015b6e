//! What lets the examples run without a window: Bevy without a renderer.
//!
//! A game needs none of this.

use bevy::{
    app::{PluginGroupBuilder, ScheduleRunnerPlugin},
    asset::RecursiveDependencyLoadState,
    log::LogPlugin,
    prelude::*,
    render::{RenderPlugin, settings::WgpuSettings},
    window::{ExitCondition, WindowResolution},
    winit::WinitPlugin,
    world_serialization::WorldAssetRoot,
};
use bevy_sightline::index::MeshBvhs;

pub mod script;

/// Whether a window could be opened: elsewhere than on Linux and its kin there always is a display.
pub fn has_display() -> bool {
    let needs_server = cfg!(all(
        unix,
        not(any(target_os = "macos", target_os = "ios", target_os = "android"))
    ));
    let is_set = |name: &&str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !needs_server || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(is_set)
}

/// All of Bevy, with a window and what plays a script in it; headless, all but the renderer and the window system. The
/// window is then an entity like any other, for cameras and pointers to refer to, and nobody shows it.
pub fn plugins(title: &str, headless: bool) -> PluginGroupBuilder {
    let window = WindowPlugin {
        primary_window: Some(Window {
            title: title.into(),
            resolution: WindowResolution::new(1280, 720),
            ..default()
        }),
        ..default()
    };
    // Found wherever the example is started from.
    let assets = AssetPlugin {
        file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into(),
        ..default()
    };
    if !headless {
        return DefaultPlugins.set(window).set(assets).add(script::plugin);
    }
    if script::is_given() {
        eprintln!("{} is passed over: there is no window to play in", script::OPTION);
    }
    let no_renderer = WgpuSettings {
        backends: None,
        ..default()
    };
    DefaultPlugins
        .set(assets)
        .set(WindowPlugin {
            exit_condition: ExitCondition::DontExit,
            ..window
        })
        .set(RenderPlugin {
            render_creation: no_renderer.into(),
            ..default()
        })
        // Bevy warns that there is no renderer.
        .set(LogPlugin {
            filter: "warn,bevy_render=off,bevy_gizmos_render=off,bevy_gltf=error".into(),
            ..default()
        })
        .disable::<WinitPlugin>()
        .add(ScheduleRunnerPlugin::run_once())
}

/// Starts a headless app, and runs frames until all its models are loaded and can be picked at full speed.
pub fn load(app: &mut App) -> Result<(), String> {
    app.finish();
    app.cleanup();
    loop {
        app.update();
        if is_loaded(app.world_mut())? {
            // One more, in which cameras see what has arrived.
            app.update();
            return Ok(());
        }
    }
}

fn is_loaded(world: &mut World) -> Result<bool, String> {
    let mut scenes = world.query::<(&WorldAssetRoot, Has<Children>)>();
    let scenes_are_there = scenes.iter(world).all(|(_, is_spawned)| is_spawned);
    let mut handles: Vec<_> = scenes.iter(world).map(|(scene, _)| scene.id().untyped()).collect();
    let mut meshes = world.query::<&Mesh3d>();
    handles.extend(meshes.iter(world).map(|mesh| mesh.id().untyped()));

    let server = world.resource::<AssetServer>();
    for handle in handles {
        if let Some(RecursiveDependencyLoadState::Failed(error)) = server.get_recursive_dependency_load_state(handle) {
            return Err(format!("cannot load a model: {error}"));
        }
    }
    let assets = world.resource::<Assets<Mesh>>();
    let meshes_are_there = meshes.iter(world).all(|mesh| assets.contains(mesh));
    let built = world.get_resource::<MeshBvhs>().is_none_or(|bvhs| bvhs.building() == 0);
    Ok(scenes_are_there && meshes_are_there && built)
}
