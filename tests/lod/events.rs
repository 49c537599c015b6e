//! Telling of switches.

use super::*;

/// What was told.
#[derive(Resource, Default)]
struct Told(Vec<LodSwapped>);

fn listen(app: &mut App) {
    app.init_resource::<Told>();
    app.add_observer(|swapped: On<LodSwapped>, mut told: ResMut<Told>| told.0.push(*swapped));
}

/// What was told in a frame.
fn told(app: &mut App) -> Vec<LodSwapped> {
    app.world_mut().resource_mut::<Told>().0.clear();
    app.update();
    app.world().resource::<Told>().0.clone()
}

fn swapped(entity: Entity, view: Entity, from: usize, to: usize) -> LodSwapped {
    LodSwapped { entity, view, from, to }
}

#[test]
fn each_switch_is_told_once_and_the_first_choice_is_none() {
    let mut app = app();
    listen(&mut app);
    let (camera, statue) = (spawn_camera(&mut app, 50.0), spawn_statue_by_distance(&mut app));
    assert_eq!(told(&mut app), []);
    insert(&mut app, camera, at_distance(15.0));
    assert_eq!(told(&mut app), [swapped(statue.root, camera, 2, 1)]);
    assert_eq!(told(&mut app), []);
    insert(&mut app, camera, at_distance(1.0));
    assert_eq!(told(&mut app), [swapped(statue.root, camera, 1, 0)]);
    insert(&mut app, camera, at_distance(100.0));
    assert_eq!(told(&mut app), [swapped(statue.root, camera, 0, 2)]);
}

#[test]
fn each_view_tells_of_its_own() {
    let mut app = app();
    listen(&mut app);
    let statue = spawn_statue_by_distance(&mut app);
    let (still, moving) = (spawn_camera(&mut app, 5.0), spawn_camera(&mut app, 5.0));
    assert_eq!(told(&mut app), []);
    insert(&mut app, moving, at_distance(15.0));
    assert_eq!(told(&mut app), [swapped(statue.root, moving, 0, 1)]);
    insert(&mut app, statue.root, Transform::from_xyz(0.0, 0.0, -100.0));
    let mut all = told(&mut app);
    all.sort_by_key(|swapped| swapped.view);
    let mut expected = [swapped(statue.root, still, 0, 2), swapped(statue.root, moving, 1, 2)];
    expected.sort_by_key(|swapped| swapped.view);
    assert_eq!(all, expected);
}

#[test]
fn an_observer_of_the_group_hears_of_it() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    app.init_resource::<Told>();
    app.world_mut()
        .entity_mut(statue.root)
        .observe(|swapped: On<LodSwapped>, mut told: ResMut<Told>| told.0.push(*swapped));
    app.update();
    insert(&mut app, camera, at_distance(15.0));
    assert_eq!(told(&mut app), [swapped(statue.root, camera, 0, 1)]);
}

#[test]
fn what_an_observer_reads_is_as_it_was_told() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    app.add_observer(|swapped: On<LodSwapped>, choices: Res<LodChoices>| {
        assert_eq!(choices.level(swapped.entity, swapped.view), Some(swapped.to));
    });
    for distance in [5.0, 15.0, 50.0] {
        look_from(&mut app, camera, distance, &statue);
    }
}

#[test]
fn an_observer_may_end_the_group() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    app.add_observer(|swapped: On<LodSwapped>, mut commands: Commands| {
        commands.entity(swapped.entity).despawn();
    });
    app.update();
    insert(&mut app, camera, at_distance(15.0));
    app.update();
    app.update();
    assert_eq!(listed(&app, camera), []);
    assert_eq!(choices(&app).level(statue.root, camera), None);
    assert!(choices(&app).is_empty());
}

#[test]
fn a_camera_that_comes_back_begins_anew() {
    let mut app = app();
    listen(&mut app);
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    told(&mut app);
    app.world_mut().get_mut::<Camera>(camera).unwrap().is_active = false;
    insert(&mut app, camera, at_distance(50.0));
    assert_eq!(told(&mut app), []);
    assert_eq!(choices(&app).level(statue.root, camera), None);
    app.world_mut().get_mut::<Camera>(camera).unwrap().is_active = true;
    assert_eq!(told(&mut app), []);
    assert_eq!(shown(&app, camera, &statue), 2);
}

#[test]
fn of_swapped_meshes_the_main_camera_tells() {
    let mut app = app();
    listen(&mut app);
    let main = spawn_camera(&mut app, 5.0);
    let meshes: Vec<_> = (0..2).map(|_| add_mesh(&mut app, Cuboid::default())).collect();
    let lod = ProxyLod::new(LodMetric::Distance, meshes[0].clone()).then(10.0, meshes[1].clone());
    let root = spawn(&mut app, (Mesh3d(meshes[0].clone()), lod));
    let other = spawn_camera(&mut app, 5.0);
    app.world_mut().get_mut::<Camera>(other).unwrap().order = 1;
    assert_eq!(told(&mut app), []);
    insert(&mut app, other, at_distance(50.0));
    assert_eq!(told(&mut app), []);
    insert(&mut app, main, at_distance(50.0));
    assert_eq!(told(&mut app), [swapped(root, main, 0, 1)]);
}
