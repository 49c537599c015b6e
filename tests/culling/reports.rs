//! Observers of what enters and leaves a view.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use super::*;

/// What has been reported: whether it has entered, what, and to which camera.
#[derive(Resource, Default)]
struct Reports(Vec<(bool, Entity, Entity)>);

/// An app that keeps what is reported, and a camera that asks for it.
fn reporting() -> (App, Entity) {
    let mut app = ours();
    app.init_resource::<Reports>()
        .add_observer(|entered: On<EnteredView>, mut reports: ResMut<Reports>| {
            reports.0.push((true, entered.entity, entered.view));
        })
        .add_observer(|left: On<LeftView>, mut reports: ResMut<Reports>| {
            reports.0.push((false, left.entity, left.view));
        });
    let camera = spawn_camera(&mut app);
    insert(&mut app, camera, ReportViewChanges);
    (app, camera)
}

/// What a frame reports of an entity.
fn reports_of(app: &mut App, entity: Entity) -> Vec<(bool, Entity)> {
    app.world_mut().resource_mut::<Reports>().0.clear();
    app.update();
    let reports = app.world().resource::<Reports>().0.iter();
    let of_it = reports.filter(|(_, reported, _)| *reported == entity);
    of_it.map(|(entered, _, view)| (*entered, *view)).collect()
}

#[test]
fn what_enters_and_leaves_a_view_is_reported_once() {
    let (mut app, camera) = reporting();
    let cube = spawn_cube(&mut app);
    assert_eq!(reports_of(&mut app, cube), [(true, camera)]);
    assert_eq!(reports_of(&mut app, cube), []);
    insert(&mut app, cube, Transform::from_xyz(99.0, 0.0, 0.0));
    assert_eq!(reports_of(&mut app, cube), [(false, camera)]);
    assert_eq!(reports_of(&mut app, cube), []);
}

#[test]
fn each_view_reports_for_itself() {
    let (mut app, first) = reporting();
    let second = spawn_camera(&mut app);
    insert(&mut app, second, ReportViewChanges);
    let cube = spawn_cube(&mut app);
    let reports = reports_of(&mut app, cube);
    assert_eq!(reports.len(), 2);
    assert!([first, second].iter().all(|&view| reports.contains(&(true, view))));
    insert(&mut app, second, Transform::from_xyz(0.0, 0.0, -10.0));
    assert_eq!(reports_of(&mut app, cube), [(false, second)]);
}

#[test]
fn a_camera_that_has_not_asked_reports_nothing() {
    let (mut app, camera) = reporting();
    remove::<ReportViewChanges>(&mut app, camera);
    let cube = spawn_cube(&mut app);
    assert_eq!(reports_of(&mut app, cube), []);
}

#[test]
fn what_is_despawned_in_view_is_not_reported() {
    let (mut app, _) = reporting();
    let cube = spawn_cube(&mut app);
    app.update();
    app.world_mut().despawn(cube);
    assert_eq!(reports_of(&mut app, cube), []);
}

#[test]
fn an_observer_of_one_entity_hears_of_that_alone() {
    let (mut app, _) = reporting();
    let (heard_of, other) = (spawn_cube(&mut app), spawn_cube(&mut app));
    #[derive(Resource, Default)]
    struct Heard(Vec<Entity>);
    app.init_resource::<Heard>();
    app.world_mut()
        .entity_mut(heard_of)
        .observe(|entered: On<EnteredView>, mut heard: ResMut<Heard>| heard.0.push(entered.entity));
    app.update();
    assert_eq!(app.world().resource::<Heard>().0, [heard_of]);
    assert!(is_seen(&app, other));
}

#[test]
fn an_observer_may_despawn_what_it_hears_of() {
    let (mut app, camera) = reporting();
    app.add_observer(
        |entered: On<EnteredView>, cubes: Query<&Mesh3d>, mut commands: Commands| {
            if cubes.contains(entered.entity) {
                commands.entity(entered.entity).despawn();
            }
        },
    );
    let cube = spawn_cube(&mut app);
    assert_eq!(reports_of(&mut app, cube), [(true, camera)]);
    assert!(app.world().get_entity(cube).is_err());
    assert_eq!(look(&mut app, camera), []);
}

#[test]
fn a_camera_that_comes_back_reports_what_has_changed_meanwhile_and_nothing_else() {
    let (mut app, camera) = reporting();
    let [stays, goes] = [(); 2].map(|()| spawn_cube(&mut app));
    app.update();
    for is_active in [false, true] {
        app.world_mut().get_mut::<Camera>(camera).expect("a camera").is_active = is_active;
        insert(&mut app, goes, Visibility::Hidden);
        app.world_mut().resource_mut::<Reports>().0.clear();
        app.update();
    }
    let reports = &app.world().resource::<Reports>().0;
    assert_eq!(*reports, [(false, goes, camera)]);
    assert!(!reports.iter().any(|(_, entity, _)| *entity == stays));
}
