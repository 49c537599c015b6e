//! Plugins that are added twice, in any order, or without those of Bevy that they go with.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy::{
    app::{PluginGroupBuilder, Plugins},
    camera::CameraPlugin,
    diagnostic::{Diagnostic, DiagnosticPath, DiagnosticsStore},
    ecs::system::RunSystemOnce,
    gizmos::GizmoPlugin,
    image::ImagePlugin,
    input::InputPlugin,
    light::LightPlugin,
    mesh::MeshPlugin,
    picking::DefaultPickingPlugins,
    prelude::*,
    window::WindowPlugin,
};
use bevy_sightline::prelude::*;

use crate::common::*;

/// What adding plugins says when it panics.
fn complaint<M>(app: &mut App, plugins: impl Plugins<M>) -> Option<String> {
    let panic = catch_unwind(AssertUnwindSafe(|| _ = app.add_plugins(plugins))).err()?;
    let message = panic.downcast_ref::<String>().cloned();
    Some(message.unwrap_or_else(|| "not a message".into()))
}

/// Bevy's own plugins.
struct Bevys;

impl PluginGroup for Bevys {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add_group(MinimalPlugins)
            .add(AssetPlugin::default())
            .add(TransformPlugin)
            .add(ImagePlugin::default())
            .add(MeshPlugin)
            .add(WindowPlugin::default())
            .add(CameraPlugin)
            .add(LightPlugin)
            .add(GizmoPlugin)
            .add(InputPlugin)
            .add_group(DefaultPickingPlugins)
    }
}

fn started(mut app: App) -> App {
    app.finish();
    app.cleanup();
    app
}

/// What is hit, seen, hidden and drawn of a wall, a cube behind it and a group.
fn outcome(app: &mut App) -> (Option<f32>, Vec<bool>, usize, Option<usize>, usize) {
    let camera = app
        .world_mut()
        .spawn((Camera3d::default(), SoftwareOcclusion::default()))
        .id();
    let wall = spawn_mesh(app, Cuboid::new(8.0, 6.0, 1.0), Transform::from_xyz(0.0, 0.0, -10.0));
    app.world_mut().entity_mut(wall).insert(Occluder::Box);
    let hidden = spawn_cube(app, Vec3::NEG_Z * 20.0);
    let near = spawn_cube(app, Vec3::NEG_Z * 5.0);
    let levels = ProxyLod::new(LodMetric::Distance, near).then_nothing(2.0);
    let group = app.world_mut().spawn((Transform::default(), levels)).id();
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    store.config_mut::<SightlineGizmos>().1.leaves = true;
    settle(app);
    app.update();
    let hit = hit_at(app, Vec3::NEG_Z * 100.0).map(|hit| hit.distance);
    let set = app.world().get::<VisibleSet>(camera).expect("every camera has one");
    let seen = [wall, hidden, near].map(|entity| set.contains(entity)).to_vec();
    (
        hit,
        seen,
        app.world().resource::<ViewCullingStats>().views,
        app.world().resource::<LodChoices>().level(group, camera),
        app.world().resource::<SightlineGizmoStats>().leaves.drawn,
    )
}

#[test]
fn plugins_work_before_and_after_those_of_bevy() {
    let mut before = App::new();
    before.add_plugins((SightlinePlugins, Bevys));
    let mut after = App::new();
    after.add_plugins((Bevys, SightlinePlugins));
    let (mut before, mut after) = (started(before), started(after));
    let expected = outcome(&mut after);
    assert_eq!(
        expected.1,
        [true, false, false],
        "the wall hides one cube, and the other is far from its group"
    );
    assert_eq!(expected.2, 1);
    assert_eq!(outcome(&mut before), expected);
}

#[test]
fn plugins_work_in_the_middle_of_those_of_bevy() {
    let mut app = App::new();
    app.add_plugins(MinimalPlugins)
        .add_plugins(SpatialIndexPlugin)
        .add_plugins((
            AssetPlugin::default(),
            OcclusionPlugin,
            ViewCullingPlugin,
            TransformPlugin,
        ))
        .add_plugins((ImagePlugin::default(), ProxyLodPlugin, MeshPlugin, SpatialPickingPlugin))
        .add_plugins((
            WindowPlugin::default(),
            CameraPlugin,
            SightlineGizmosPlugin,
            GizmoPlugin,
        ))
        .add_plugins((LightPlugin, InputPlugin, DefaultPickingPlugins));
    let mut usual = App::new();
    usual.add_plugins((Bevys, SightlinePlugins));
    assert_eq!(outcome(&mut started(app)), outcome(&mut started(usual)));
}

#[test]
fn the_index_may_be_added_again_by_whoever_needs_it() {
    let mut app = App::new();
    app.add_plugins(MinimalPlugins);
    assert_eq!(complaint(&mut app, SpatialIndexPlugin), None);
    assert_eq!(complaint(&mut app, SpatialIndexPlugin), None);
    assert_eq!(complaint(&mut app, SightlinePlugins), None);
    assert_eq!(complaint(&mut app, SpatialIndexPlugin), None);
}

#[test]
fn any_other_plugin_that_is_added_twice_is_named_by_a_panic() {
    fn check<P: Plugin + Default>() {
        let mut app = App::new();
        app.add_plugins(MinimalPlugins);
        assert_eq!(complaint(&mut app, P::default()), None);
        let complaint = complaint(&mut app, P::default()).expect("a panic");
        let name = std::any::type_name::<P>();
        assert!(
            complaint.contains(name) && complaint.contains("already added"),
            "{complaint}"
        );
    }
    check::<OcclusionPlugin>();
    check::<SightlineGizmosPlugin>();
    check::<SpatialPickingPlugin>();
    check::<ViewCullingPlugin>();
    #[cfg(feature = "simplify")]
    check::<AutoProxyPlugin>();
    #[cfg(feature = "sprite")]
    check::<SpriteIndexPlugin>();
}

#[test]
fn the_group_twice_or_with_a_plugin_of_its_own_is_named_by_a_panic() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SightlinePlugins));
    let twice = complaint(&mut app, SightlinePlugins).expect("a panic");
    assert!(
        twice.contains("SightlinePlugins") && twice.contains("already added"),
        "{twice}"
    );
    let one_more = complaint(&mut app, SpatialPickingPlugin).expect("a panic");
    assert!(
        one_more.contains("SpatialPickingPlugin") && one_more.contains("already added"),
        "{one_more}"
    );
}

#[test]
fn levels_may_be_added_again_by_whatever_makes_them() {
    let mut app = App::new();
    app.add_plugins(MinimalPlugins);
    assert_eq!(complaint(&mut app, LevelVariantsPlugin::<Name>::default()), None);
    assert!(app.is_plugin_added::<ProxyLodPlugin>());
    assert_eq!(complaint(&mut app, SightlinePlugins), None);
    assert_eq!(complaint(&mut app, ProxyLodPlugin), None);
}

#[test]
fn without_the_culling_of_views_there_are_no_reasons_and_no_panic() {
    let mut app = App::new();
    app.add_plugins((Bevys, SpatialPickingPlugin));
    let mut app = started(app);
    let camera = app.world_mut().spawn(Camera3d::default()).id();
    let cube = spawn_cube(&mut app, Vec3::NEG_Z * 5.0);
    app.update();
    let ask = move |reasons: VisibilityReasons| reasons.of(cube, camera);
    assert_eq!(app.world_mut().run_system_once(ask).ok(), Some(None));
}

#[test]
fn diagnostics_may_be_added_again_by_whoever_shows_them() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SightlinePlugins));
    assert_eq!(complaint(&mut app, SightlineDiagnosticsPlugin), None);
    assert_eq!(complaint(&mut app, SightlineDiagnosticsPlugin), None);
    app.update();
    let store = app.world().resource::<DiagnosticsStore>();
    let sync = store.get(&DiagnosticPath::const_new("sightline/index/sync"));
    assert_eq!(sync.map(Diagnostic::history_len), Some(1), "measured once a frame");
}

#[test]
fn a_server_may_leave_out_any_of_bevys_plugins() {
    let steps: [fn(&mut App); 6] = [
        |app| _ = app.add_plugins(TransformPlugin),
        |app| _ = app.add_plugins(AssetPlugin::default()),
        |app| _ = app.add_plugins((ImagePlugin::default(), MeshPlugin)),
        |app| _ = app.add_plugins((WindowPlugin::default(), CameraPlugin)),
        |app| _ = app.add_plugins((LightPlugin, GizmoPlugin)),
        |app| _ = app.add_plugins((InputPlugin, DefaultPickingPlugins)),
    ];
    for added in 0..=steps.len() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, SightlinePlugins, SightlineDiagnosticsPlugin));
        steps[..added].iter().for_each(|add| add(&mut app));
        let mut app = started(app);
        let ball = PickShape::new(Sphere::new(1.0));
        let place = GlobalTransform::from_xyz(0.0, 0.0, -5.0);
        let entity = app
            .world_mut()
            .spawn((ball, Transform::from_xyz(0.0, 0.0, -5.0), place))
            .id();
        app.world_mut()
            .spawn((Camera::default(), Projection::default(), GlobalTransform::default()));
        for _ in 0..3 {
            app.update();
        }
        assert_eq!(
            hit_at(&mut app, Vec3::ZERO).map(|hit| hit.entity),
            Some(entity),
            "with {added}"
        );
    }
}
