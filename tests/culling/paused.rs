//! Systems that are paused by a run condition for some frames.

use bevy::{
    camera::visibility::{RenderLayers, VisibleMeshEntities},
    light::NotShadowCaster,
    prelude::*,
};
use bevy_sightline::prelude::*;

use super::*;

#[derive(Resource)]
struct IsOn(bool);

fn is_on(is_on: Res<IsOn>) -> bool {
    is_on.0
}

/// An app in which a set of systems is on or off.
fn pausable(set: impl SystemSet) -> App {
    let mut app = ours();
    app.insert_resource(IsOn(true))
        .configure_sets(PostUpdate, set.run_if(is_on));
    app
}

fn switch(app: &mut App, is_on: bool) {
    app.world_mut().resource_mut::<IsOn>().0 = is_on;
}

#[test]
fn what_is_shown_and_hidden_while_the_index_is_paused_is_so_at_once() {
    let mut app = pausable(SpatialIndexSystems::Sync);
    let camera = spawn_camera(&mut app);
    let [shown, hidden] = [(); 2].map(|()| spawn_cube(&mut app));
    insert(&mut app, shown, Visibility::Hidden);
    assert_eq!(look(&mut app, camera), [hidden]);
    switch(&mut app, false);
    app.update();
    insert(&mut app, shown, Visibility::Inherited);
    insert(&mut app, hidden, Visibility::Hidden);
    assert_eq!(look(&mut app, camera), [shown]);
    assert!(is_seen(&app, shown) && !is_seen(&app, hidden));
}

#[test]
fn layers_that_change_while_the_index_is_paused_count_at_once() {
    let mut app = pausable(SpatialIndexSystems::Sync);
    let camera = spawn_camera(&mut app);
    let cube = spawn_cube(&mut app);
    assert_eq!(look(&mut app, camera), [cube]);
    switch(&mut app, false);
    insert(&mut app, cube, RenderLayers::layer(3));
    assert_eq!(look(&mut app, camera), []);
    remove::<RenderLayers>(&mut app, cube);
    assert_eq!(look(&mut app, camera), [cube]);
}

#[test]
fn what_comes_and_goes_while_nothing_is_written_is_in_no_list_afterwards() {
    let mut app = pausable(ViewCullingSystems::Write);
    let camera = spawn_camera(&mut app);
    let cube = spawn_cube_at(&mut app, 999.0, 0.0, 0.0);
    assert_eq!(look(&mut app, camera), []);
    switch(&mut app, false);
    insert(&mut app, cube, Transform::default());
    app.update();
    insert(&mut app, cube, Transform::from_xyz(999.0, 0.0, 0.0));
    app.update();
    switch(&mut app, true);
    assert_eq!(look(&mut app, camera), []);
    assert!(!is_seen(&app, cube));
}

#[test]
fn what_is_despawned_while_nothing_is_written_is_in_no_list_afterwards() {
    let mut app = pausable(ViewCullingSystems::Write);
    let camera = spawn_camera(&mut app);
    let cube = spawn_cube(&mut app);
    assert_eq!(look(&mut app, camera), [cube]);
    switch(&mut app, false);
    app.world_mut().despawn(cube);
    app.update();
    app.update();
    switch(&mut app, true);
    assert_eq!(look(&mut app, camera), []);
}

#[test]
fn who_takes_the_index_of_another_while_nothing_is_written_is_seen_afterwards() {
    let mut app = pausable(ViewCullingSystems::Write);
    let camera = spawn_camera(&mut app);
    let before = spawn_cube(&mut app);
    assert_eq!(look(&mut app, camera), [before]);
    switch(&mut app, false);
    app.update();
    let (mesh, world) = (cube(&app), app.world_mut());
    let place = world.despawn_no_free(before).expect("it was there");
    let after = world.spawn_at(place, mesh).expect("nobody is there").id();
    app.update();
    switch(&mut app, true);
    app.update();
    assert_eq!(look(&mut app, camera), [after]);
    assert!(is_seen(&app, after));
    insert(&mut app, after, Transform::from_xyz(999.0, 0.0, 0.0));
    assert_eq!(look(&mut app, camera), []);
    assert!(!is_seen(&app, after));
}

#[test]
fn what_casts_shadows_is_listed_rightly_after_the_lights_were_paused() {
    let mut app = pausable(ViewCullingSystems::Lights);
    spawn_camera(&mut app);
    let light = spawn(
        &mut app,
        (
            SpotLight {
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_xyz(0.0, 0.0, 10.0),
        ),
    );
    let before = spawn_cube(&mut app);
    let casters = |app: &mut App| {
        app.update();
        let listed = app.world().get::<VisibleMeshEntities>(light).expect("a light");
        listed.entities.clone()
    };
    assert_eq!(casters(&mut app), [before]);
    switch(&mut app, false);
    let (mesh, world) = (cube(&app), app.world_mut());
    let place = world.despawn_no_free(before).expect("it was there");
    let after = world.spawn_at(place, mesh).expect("nobody is there").id();
    app.update();
    switch(&mut app, true);
    assert_eq!(casters(&mut app), [after]);
    insert(&mut app, after, NotShadowCaster);
    assert_eq!(casters(&mut app), []);
}
