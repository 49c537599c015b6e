//! Levels that are made for entities.

use bevy::{asset::AssetPath, mesh::PrimitiveTopology, prelude::*};
use bevy_sightline::prelude::*;

use crate::common::{add_mesh, headless_app};

/// What was told of entities.
#[derive(Resource, Default)]
pub struct Told {
    pub ready: Vec<ProxyReady>,
    pub failed: Vec<ProxyFailed>,
}

/// An app that notes what is told.
pub fn app() -> App {
    let mut app = headless_app();
    app.init_resource::<Told>();
    app.add_observer(|ready: On<ProxyReady>, mut told: ResMut<Told>| told.ready.push(*ready));
    app.add_observer(|failed: On<ProxyFailed>, mut told: ResMut<Told>| told.failed.push(*failed));
    app
}

/// Runs frames until all proxies are made.
pub fn finish_proxies(app: &mut App) {
    app.update();
    while !progress(app).is_done() {
        app.update();
    }
    app.update();
}

pub fn progress(app: &App) -> ProxyProgress {
    *app.world().resource()
}

fn told(app: &App) -> &Told {
    app.world().resource()
}

fn fine_sphere() -> Mesh {
    Sphere::new(1.0).mesh().ico(7).expect("not too fine")
}

fn spawn(app: &mut App, mesh: &Handle<Mesh>, proxy: AutoProxy) -> Entity {
    app.world_mut()
        .spawn((Mesh3d(mesh.clone()), Transform::default(), proxy))
        .id()
}

fn lod(app: &App, entity: Entity) -> Option<&ProxyLod> {
    app.world().get::<ProxyLod>(entity)
}

/// The meshes of a group.
fn levels(app: &App, entity: Entity) -> Vec<AssetId<Mesh>> {
    let lod = lod(app, entity).expect("it has levels");
    let of_level = |level: &LodLevel| match &level.content {
        LodContent::Mesh(mesh) => mesh.id(),
        other => panic!("{other:?} is no mesh"),
    };
    lod.levels.iter().map(of_level).collect()
}

#[test]
fn a_group_is_filled_with_levels_and_their_errors() {
    let mut app = app();
    let mesh = add_mesh(&mut app, fine_sphere());
    let entity = spawn(&mut app, &mesh, AutoProxy::default().with_pixels(1.5));
    finish_proxies(&mut app);
    let lod = lod(&app, entity).expect("it has levels");
    assert_eq!(lod.metric, LodMetric::PixelError(1.5));
    assert_eq!(
        lod.levels[0],
        LodLevel {
            content: mesh.clone().into(),
            threshold: 0.0
        }
    );
    assert!(lod.levels.len() >= 4);
    assert!(
        lod.levels
            .is_sorted_by(|finer, coarser| finer.threshold < coarser.threshold)
    );
    let assets = app.world().resource::<Assets<Mesh>>();
    let sizes: Vec<usize> = levels(&app, entity)
        .into_iter()
        .map(|level| assets.get(level).expect("it is there").indices().expect("a list").len())
        .collect();
    assert!(sizes.is_sorted_by(|finer, coarser| finer > coarser), "{sizes:?}");
    assert_eq!(
        told(&app).ready,
        [ProxyReady {
            entity,
            levels: lod.levels.len()
        }]
    );
}

#[test]
fn a_group_that_is_there_keeps_what_is_not_measured() {
    let mut app = app();
    let mesh = add_mesh(&mut app, fine_sphere());
    let group = ProxyLod::new(LodMetric::Height, mesh.clone())
        .with_bias(2.0)
        .hit_as(LodHits::Shown);
    let entity = spawn(&mut app, &mesh, AutoProxy::default());
    app.world_mut().entity_mut(entity).insert(group);
    finish_proxies(&mut app);
    let lod = lod(&app, entity).expect("it has levels");
    assert_eq!(
        (lod.bias, lod.hits, lod.metric),
        (2.0, LodHits::Shown, LodMetric::ONE_PIXEL)
    );
}

#[test]
fn levels_are_made_once_for_all_that_use_them() {
    let mut app = app();
    let mesh = add_mesh(&mut app, fine_sphere());
    let first = spawn(&mut app, &mesh, AutoProxy::default());
    let second = spawn(&mut app, &mesh, AutoProxy::default().with_pixels(4.0));
    finish_proxies(&mut app);
    let late = spawn(&mut app, &mesh, AutoProxy::default());
    let other = spawn(&mut app, &mesh, AutoProxy::new([SimplifyTarget::Ratio(0.3)]));
    finish_proxies(&mut app);
    assert_eq!(levels(&app, first), levels(&app, second));
    assert_eq!(levels(&app, first), levels(&app, late));
    assert_ne!(levels(&app, first), levels(&app, other));
    assert_eq!(progress(&app).total, 2);
}

#[test]
fn progress_counts_what_is_done_of_what_there_is() {
    let mut app = app();
    assert_eq!(progress(&app).total, 0);
    for _ in 0..5 {
        let mesh = add_mesh(&mut app, fine_sphere());
        spawn(&mut app, &mesh, AutoProxy::default());
    }
    let lines = add_mesh(&mut app, Mesh::new(PrimitiveTopology::LineList, default()));
    spawn(&mut app, &lines, AutoProxy::default());
    app.update();
    let mut before = progress(&app);
    assert_eq!(before.total, 6);
    while !progress(&app).is_done() {
        app.update();
        let now = progress(&app);
        assert!(now.done >= before.done && now.fraction >= before.fraction && now.total == 6);
        before = now;
    }
    assert_eq!(
        (before.done, before.failed, before.waiting, before.fraction),
        (6, 1, 0, 1.0)
    );
}

#[test]
fn what_cannot_be_simplified_stays_as_it_is() {
    let mut app = app();
    let lines = add_mesh(&mut app, Mesh::new(PrimitiveTopology::LineList, default()));
    let entity = spawn(&mut app, &lines, AutoProxy::default());
    finish_proxies(&mut app);
    assert!(lod(&app, entity).is_none());
    let failed: Vec<Entity> = told(&app).failed.iter().map(|failed| failed.entity).collect();
    assert_eq!(failed, [entity]);
}

#[test]
fn a_mesh_that_cannot_get_simpler_gets_no_group() {
    let mut app = app();
    let triangle = add_mesh(&mut app, Triangle3d::default());
    let entity = spawn(&mut app, &triangle, AutoProxy::default());
    finish_proxies(&mut app);
    assert!(lod(&app, entity).is_none());
    assert_eq!(told(&app).ready, [ProxyReady { entity, levels: 1 }]);
}

#[test]
fn levels_wait_for_the_mesh_to_be_loaded() {
    let mut app = app();
    let mesh = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let entity = spawn(&mut app, &mesh, AutoProxy::default());
    for _ in 0..5 {
        app.update();
    }
    assert_eq!((progress(&app).total, progress(&app).waiting), (1, 1));
    let inserted = app
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(&mesh, fine_sphere());
    inserted.expect("the handle is good");
    finish_proxies(&mut app);
    assert!(lod(&app, entity).is_some());
}

#[test]
fn a_mesh_that_fails_to_load_fails() {
    let mut app = app();
    let path = AssetPath::parse("there/is/no/such/file.glb#Mesh0/Primitive0");
    let mesh = app.world().resource::<AssetServer>().load::<Mesh>(path);
    let entity = spawn(&mut app, &mesh, AutoProxy::default());
    finish_proxies(&mut app);
    assert_eq!(
        told(&app).failed,
        [ProxyFailed {
            entity,
            error: SimplifyError::NotLoaded
        }]
    );
}

#[test]
fn what_is_despawned_or_let_go_is_not_waited_for() {
    let mut app = app();
    let [first, second] = [(); 2].map(|()| add_mesh(&mut app, fine_sphere()));
    let despawned = spawn(&mut app, &first, AutoProxy::default());
    let let_go = spawn(&mut app, &second, AutoProxy::default());
    app.update();
    assert_eq!(progress(&app).total, 2);
    app.world_mut().despawn(despawned);
    app.world_mut().entity_mut(let_go).remove::<AutoProxy>();
    app.update();
    assert_eq!(progress(&app).total, 0);
    for _ in 0..20 {
        app.update();
    }
    assert!(lod(&app, let_go).is_none());
}

#[test]
fn what_has_its_levels_keeps_them_without_the_component() {
    let mut app = app();
    let mesh = add_mesh(&mut app, fine_sphere());
    let entity = spawn(&mut app, &mesh, AutoProxy::default());
    finish_proxies(&mut app);
    app.world_mut().entity_mut(entity).remove::<AutoProxy>();
    app.update();
    assert!(lod(&app, entity).is_some());
    assert_eq!(progress(&app).total, 0);
}

#[test]
fn a_modified_mesh_gets_new_levels() {
    let mut app = app();
    let mesh = add_mesh(&mut app, fine_sphere());
    let entity = spawn(&mut app, &mesh, AutoProxy::default());
    finish_proxies(&mut app);
    let before = lod(&app, entity).expect("it has levels").levels[1].threshold;
    let mut assets = app.world_mut().resource_mut::<Assets<Mesh>>();
    assets.get_mut(&mesh).expect("it is there").scale_by(Vec3::splat(10.0));
    // The event is written at the end of the frame, and read in the next one.
    app.update();
    app.update();
    finish_proxies(&mut app);
    let after = lod(&app, entity).expect("it has levels").levels[1].threshold;
    assert!((after / before - 10.0).abs() < 1.0, "{before} {after}");
}

#[test]
fn an_entity_with_another_mesh_gets_levels_of_that() {
    let mut app = app();
    let [first, second] = [(); 2].map(|()| add_mesh(&mut app, fine_sphere()));
    let entity = spawn(&mut app, &first, AutoProxy::default());
    finish_proxies(&mut app);
    app.world_mut().entity_mut(entity).insert(Mesh3d(second.clone()));
    finish_proxies(&mut app);
    assert_eq!(levels(&app, entity)[0], second.id());
    assert_eq!(
        app.world().get::<Mesh3d>(entity).map(|mesh| mesh.id()),
        Some(second.id())
    );
    assert_eq!(progress(&app).total, 1);
}

#[test]
fn a_swapped_level_is_not_taken_for_another_mesh() {
    let mut app = app();
    let mesh = add_mesh(&mut app, fine_sphere());
    let entity = spawn(&mut app, &mesh, AutoProxy::default());
    finish_proxies(&mut app);
    let before = levels(&app, entity);
    let far = Transform::from_xyz(0.0, 0.0, 2000.0);
    let camera = app.world_mut().spawn((Camera3d::default(), far)).id();
    app.update();
    app.update();
    assert!(app.world().get::<Camera>(camera).is_some());
    let coarse = lod(&app, entity).expect("it has levels").levels[2].content.clone();
    let LodContent::Mesh(coarse) = coarse else {
        panic!("it is a mesh")
    };
    app.world_mut().entity_mut(entity).insert(Mesh3d(coarse));
    app.update();
    assert_eq!(levels(&app, entity), before);
    assert_eq!((progress(&app).total, progress(&app).done), (1, 1));
}

#[test]
fn an_entity_that_shows_a_coarse_level_and_gets_another_mesh_keeps_that() {
    let mut app = app();
    let [first, second] = [(); 2].map(|()| add_mesh(&mut app, fine_sphere()));
    let entity = spawn(&mut app, &first, AutoProxy::default());
    finish_proxies(&mut app);
    let coarse = levels(&app, entity)[2];
    // Taken back together with the group, as by a camera that was far away.
    app.world_mut().entity_mut(entity).insert(Mesh3d(second.clone()));
    app.update();
    assert_ne!(coarse, second.id());
    app.world_mut().entity_mut(entity).insert(Mesh3d(first.clone()));
    finish_proxies(&mut app);
    assert_eq!(
        app.world().get::<Mesh3d>(entity).map(|mesh| mesh.id()),
        Some(second.id())
    );
    assert_eq!(levels(&app, entity)[0], second.id());
}

#[test]
fn other_settings_make_other_levels() {
    let mut app = app();
    let mesh = add_mesh(&mut app, fine_sphere());
    let entity = spawn(&mut app, &mesh, AutoProxy::default());
    finish_proxies(&mut app);
    let before = levels(&app, entity);
    app.world_mut().get_mut::<AutoProxy>(entity).expect("it has it").pixels = 3.0;
    finish_proxies(&mut app);
    assert_eq!(
        lod(&app, entity).map(|lod| lod.metric),
        Some(LodMetric::PixelError(3.0))
    );
    assert_eq!(levels(&app, entity), before);
    app.world_mut()
        .entity_mut(entity)
        .insert(AutoProxy::new([SimplifyTarget::Ratio(0.2)]));
    finish_proxies(&mut app);
    assert_eq!(levels(&app, entity).len(), 2);
}

#[test]
fn without_meshes_nothing_is_made() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        bevy_sightline::lod::simplify::AutoProxyPlugin::default(),
    ));
    app.world_mut().spawn(AutoProxy::default());
    app.update();
    app.update();
    assert_eq!(progress(&app).total, 0);
}
