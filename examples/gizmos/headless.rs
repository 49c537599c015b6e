//! Each kind for itself, without a window.

use bevy::{camera_controller::free_camera::FreeCamera, prelude::*};
use bevy_sightline::{index::MeshBvhs, prelude::*};

use crate::{
    kinds::{KINDS, Structure, StructureCount, switch_structure},
    options::Options,
    picture, pointer, shared,
};

/// Draws each kind for itself, and prints how much there was of it.
pub fn run(mut app: App) -> AppExit {
    match draw_each(&mut app) {
        Ok(()) => AppExit::Success,
        Err(message) => {
            eprintln!("{message}");
            AppExit::error()
        }
    }
}

fn draw_each(app: &mut App) -> Result<(), String> {
    shared::load(app)?;
    settle(app);
    println!("{:<12}{:>8}{:>10}", "", "drawn", "left out");
    for kind in &KINDS {
        configure(app, kind.switch);
        settle(app);
        let count = (kind.count)(app.world().resource());
        finish(app, kind.name, count)?;
        configure(app, |gizmos| {
            let limit = gizmos.limit;
            *gizmos = SightlineGizmos { limit, ..default() };
        });
    }
    loop {
        app.world_mut()
            .run_system_cached(switch_structure)
            .map_err(|error| error.to_string())?;
        let name = app.world().resource::<Structure>().name();
        if matches!(app.world().resource::<Structure>(), Structure::None) {
            break;
        }
        settle(app);
        let count = app.world().resource::<StructureCount>().0;
        finish(app, name, count)?;
    }
    let thing = under_pointer(app)?;
    let everything = ShowGizmos {
        volume: Some(BoundingKind::Hull),
        ..default()
    };
    app.world_mut().entity_mut(thing).insert(everything);
    settle(app);
    let count = app.world().resource::<SightlineGizmoStats>().entities;
    finish(app, "one thing", count)
}

/// Runs frames until all is made that is drawn, with the pointer in the middle.
fn settle(app: &mut App) {
    loop {
        pointer::play(app, [(POINTER, None); 2]);
        let making = app.world().resource::<Occluders>().making() + app.world().resource::<MeshBvhs>().building();
        if making == 0 {
            // One more, in which what was made last is drawn.
            pointer::play(app, [(POINTER, None); 2]);
            return;
        }
    }
}

/// Where the pointer is: in the middle.
const POINTER: Vec2 = Vec2::new(0.5, 0.5);

fn configure(app: &mut App, change: impl FnOnce(&mut SightlineGizmos)) {
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    change(store.config_mut::<SightlineGizmos>().1);
}

fn under_pointer(app: &mut App) -> Result<Entity, String> {
    let find = |camera: Single<(&Camera, &GlobalTransform), With<FreeCamera>>, scene: SceneQuery| {
        let (camera, place) = *camera;
        let pixel = camera.logical_viewport_size()? * POINTER;
        let ray = camera.viewport_to_world(place, pixel).ok()?;
        let hit = scene.cast_ray(ray, &SceneQuerySettings::default())?;
        Some(hit.entity)
    };
    let found = app.world_mut().run_system_cached(find);
    found
        .map_err(|error| error.to_string())?
        .ok_or("nothing is under the pointer".into())
}

/// Prints what was drawn and makes a picture of it.
fn finish(app: &mut App, name: &str, count: GizmoCount) -> Result<(), String> {
    let GizmoCount { drawn, left_out } = count;
    println!("{name:<12}{drawn:>8}{left_out:>10}");
    if drawn == 0 {
        return Err(format!("{name}: nothing was drawn"));
    }
    let options = app.world().resource::<Options>();
    if let Some(folder) = &options.pictures {
        let file = folder.join(format!("{}.png", name.replace(' ', "_")));
        match app.world_mut().run_system_cached_with(picture::draw, file.clone()) {
            Ok(Ok(())) => println!("{:<12}{}", "", file.display()),
            Ok(Err(error)) => return Err(format!("no picture: {error}")),
            Err(error) => return Err(format!("no picture: {error}")),
        }
    }
    Ok(())
}
