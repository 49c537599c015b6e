//! Bugs that were: what could be seen and was left out, and answers that were not so.

use bevy::{
    camera::{PerspectiveProjection, SubCameraView, visibility::VisibilityClass},
    ecs::system::RunSystemOnce,
    prelude::*,
};
use bevy_sightline::{
    culling::{VisibilityReason, VisibilityReasons},
    index::{HitSurface, PickShape, SimplifiedMesh},
    raster::{MaskedDepthBuffer, RasterMode, ScreenRect},
};

use super::*;
use crate::skinned_picking::rig::{Rig, spawn_rig, with_one_joint};

fn finish(app: &mut App) {
    settle(app);
    while app.world().resource::<Occluders>().making() > 0 {
        app.update();
    }
}

/// A skinned mesh whose own entity is behind the wall, and whose joint is somewhere.
fn spawn_skinned(app: &mut App, mesh: impl Into<Mesh>, joint: Vec3) -> Rig {
    let rig = spawn_rig(app, with_one_joint(mesh.into()), &[Transform::from_translation(joint)]);
    insert(app, rig.entity, Transform::from_xyz(0.0, 0.0, -20.0));
    rig
}

#[test]
fn a_skinned_mesh_that_is_hit_as_something_else_is_seen_where_it_is_drawn() {
    type Change = fn(&mut App, Entity);
    let simplified: Change = |app, entity| {
        let mesh = add_mesh(app, Cuboid::default());
        insert(app, entity, SimplifiedMesh(mesh));
    };
    let changes: [Change; 3] = [
        |app, entity| insert(app, entity, PickShape::new(Capsule3d::new(0.4, 1.2))),
        |app, entity| insert(app, entity, HitSurface::Volume(default())),
        simplified,
    ];
    for change in changes {
        let mut app = headless_app();
        let camera = spawn_camera(&mut app);
        spawn_wall(&mut app);
        let rig = spawn_skinned(&mut app, Cuboid::default(), Vec3::new(0.0, 7.2, -20.0));
        change(&mut app, rig.entity);
        finish(&mut app);
        assert!(sees(&mut app, camera, rig.entity));
    }
}

#[test]
fn a_skinned_mesh_with_a_smaller_one_to_be_hit_is_seen_in_its_own_size() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let rig = spawn_skinned(&mut app, Cuboid::new(1.0, 16.0, 1.0), Vec3::new(0.0, 0.0, -20.0));
    let small = add_mesh(&mut app, with_one_joint(Cuboid::from_length(0.5).into()));
    insert(&mut app, rig.entity, SimplifiedMesh(small));
    finish(&mut app);
    assert!(sees(&mut app, camera, rig.entity));
}

/// Has the renderer show what it does not otherwise.
fn invert(app: &mut App, camera: Entity) {
    app.world_mut()
        .get_mut::<Camera>(camera)
        .expect("a camera")
        .invert_culling = true;
}

fn spawn_room(app: &mut App) -> Entity {
    let room = spawn_mesh(app, Cuboid::new(8.0, 6.0, 8.0), Transform::from_xyz(0.0, 0.0, -10.0));
    insert(app, room, Occluder::Box);
    room
}

#[test]
fn a_camera_that_shows_the_inside_of_things_sees_what_is_in_them() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_room(&mut app);
    let inside = spawn_ahead(&mut app, 10.0);
    assert!(!sees(&mut app, camera, inside));
    invert(&mut app, camera);
    assert!(sees(&mut app, camera, inside), "in the frame of the change");
    insert(&mut app, camera, Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
    assert!(!sees(&mut app, camera, inside), "mirrored, it shows the outside again");
    app.world_mut()
        .get_mut::<Camera>(camera)
        .expect("a camera")
        .invert_culling = false;
    assert!(sees(&mut app, camera, inside));
}

#[test]
fn triangles_that_a_camera_does_not_show_hide_nothing_from_it() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let sheet = spawn_mesh(&mut app, Rectangle::new(8.0, 6.0), Transform::from_xyz(0.0, 0.0, -10.0));
    insert(&mut app, sheet, Occluder::Mesh);
    let behind = spawn_ahead(&mut app, 20.0);
    finish(&mut app);
    assert!(!sees(&mut app, camera, behind));
    invert(&mut app, camera);
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn what_an_oblique_near_plane_opens_is_seen_through() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    // Below the water all is cut away.
    let projection = PerspectiveProjection {
        near_clip_plane: Vec4::new(0.0, 1.0, 0.0, -1.0),
        ..default()
    };
    insert(
        &mut app,
        camera,
        (Projection::from(projection), Transform::from_xyz(0.0, -1.0, 0.0)),
    );
    let house = spawn_mesh(
        &mut app,
        Cuboid::new(40.0, 10.0, 20.0),
        Transform::from_xyz(0.0, 0.0, -30.0),
    );
    let core = Mesh::from(Cuboid::new(38.0, 4.0, 19.8)).translated_by(Vec3::new(0.0, 2.3, 0.0));
    let core = add_mesh(&mut app, core);
    insert(&mut app, house, Occluder::Proxy(core));
    let behind = spawn_mesh(&mut app, Cuboid::from_length(0.2), Transform::from_xyz(0.0, 1.4, -60.0));
    finish(&mut app);
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn a_part_of_a_view_is_judged_by_what_it_shows() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let projection = PerspectiveProjection {
        aspect_ratio: 4.0 / 3.0,
        ..default()
    };
    insert(&mut app, camera, Projection::from(projection));
    app.world_mut()
        .get_mut::<Camera>(camera)
        .expect("a camera")
        .sub_camera_view = Some(SubCameraView {
        full_size: UVec2::new(1600, 600),
        offset: Vec2::ZERO,
        size: UVec2::new(800, 600),
    });
    let wall = spawn_mesh(
        &mut app,
        Cuboid::new(4.0, 6.0, 1.0),
        Transform::from_xyz(-3.6, 0.0, -10.0),
    );
    insert(&mut app, wall, Occluder::Box);
    let beyond_its_edge = spawn_mesh(
        &mut app,
        Cuboid::new(4.0, 1.0, 1.0),
        Transform::from_xyz(-11.05, 0.0, -20.0),
    );
    assert!(sees(&mut app, camera, beyond_its_edge));
}

#[test]
fn a_buffer_that_is_taken_away_or_replaced_hides_nothing_wrongly() {
    let changes: [fn(&mut App, Entity); 3] = [
        |app, camera| remove::<OcclusionBuffer>(app, camera),
        |app, camera| insert(app, camera, OcclusionBuffer::default()),
        |app, camera| {
            app.world_mut()
                .entity_mut(camera)
                .remove_with_requires::<SoftwareOcclusion>();
            insert(app, camera, SoftwareOcclusion::default());
        },
    ];
    for change in changes {
        let mut app = headless_app();
        let camera = spawn_camera(&mut app);
        spawn_wall(&mut app);
        let behind = spawn_ahead(&mut app, 20.0);
        // The arms of the player reach through the near plane.
        let arms = spawn_skinned(&mut app, Cuboid::default(), Vec3::new(0.0, 0.0, -0.3));
        finish(&mut app);
        assert!(sees(&mut app, camera, arms.entity));
        change(&mut app, camera);
        for _ in 0..3 {
            assert!(sees(&mut app, camera, arms.entity));
            assert!(!listed(&app, camera).contains(&behind));
        }
    }
}

#[test]
fn a_point_between_four_pixels_is_hidden_by_nothing_in_an_empty_buffer() {
    let buffer = MaskedDepthBuffer::new(UVec2::new(1024, 512), RasterMode::Strict);
    let at = Vec2::new(512.0, 256.0);
    let point = ScreenRect {
        min: at,
        max: at,
        nearest: 0.5,
    };
    assert!(buffer.is_rect_visible(&point) && !buffer.hides_rect(&point));
}

#[derive(Resource)]
struct IsOn(bool);

#[test]
fn while_the_index_is_paused_what_leaves_the_view_is_not_seen() {
    for occlusion in [false, true] {
        let mut app = headless_app();
        app.insert_resource(IsOn(true));
        app.configure_sets(PostUpdate, SpatialIndexSystems::Sync.run_if(|is_on: Res<IsOn>| is_on.0));
        let camera = spawn(&mut app, Camera3d::default());
        if occlusion {
            insert(&mut app, camera, SoftwareOcclusion::default());
        }
        let cube = spawn_ahead(&mut app, 5.0);
        app.update();
        assert!(sees(&mut app, camera, cube));
        app.world_mut().resource_mut::<IsOn>().0 = false;
        insert(&mut app, cube, Transform::from_xyz(500.0, 0.0, -5.0));
        assert!(!sees(&mut app, camera, cube));
    }
}

fn reason(app: &mut App, entity: Entity, camera: Entity) -> Option<VisibilityReason> {
    let ask = move |reasons: VisibilityReasons| reasons.of(entity, camera);
    app.world_mut().run_system_once(ask).expect("a system that runs")
}

#[test]
fn what_nothing_hides_is_not_said_to_be_occluded() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let cube = spawn_ahead(&mut app, 5.0);
    insert(&mut app, cube, Visibility::Hidden);
    app.update();
    insert(&mut app, cube, InheritedVisibility::VISIBLE);
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::NotYet));
}

#[test]
fn what_bevy_itself_lists_is_said_to_be_visible() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = false;
    let cube = spawn_ahead(&mut app, 5.0);
    app.update();
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::Visible));
}

#[derive(Resource, Default)]
struct ChangedFrames(usize);

#[test]
fn a_buffer_is_marked_as_changed_only_when_it_is_drawn() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let wall = spawn_wall(&mut app);
    app.init_resource::<ChangedFrames>();
    app.add_systems(
        Last,
        |changed: Query<(), Changed<OcclusionBuffer>>, mut frames: ResMut<ChangedFrames>| {
            frames.0 += changed.iter().count();
        },
    );
    finish(&mut app);
    app.update();
    let before = app.world().resource::<ChangedFrames>().0;
    for _ in 0..5 {
        app.update();
    }
    assert_eq!(app.world().resource::<ChangedFrames>().0, before);
    insert(&mut app, wall, Transform::from_xyz(1.0, 0.0, -10.0));
    app.update();
    assert_eq!(app.world().resource::<ChangedFrames>().0, before + 1);
    remove::<SoftwareOcclusion>(&mut app, camera);
    app.update();
    let buffer = app.world().get::<OcclusionBuffer>(camera).expect("it stays");
    assert_eq!(buffer.depth().size(), UVec2::ZERO, "and is emptied");
}

#[test]
fn what_was_found_and_never_written_does_not_pile_up_or_last() {
    let mut app = headless_app();
    app.insert_resource(IsOn(true));
    app.configure_sets(PostUpdate, ViewCullingSystems::Write.run_if(|is_on: Res<IsOn>| is_on.0));
    let camera = spawn_camera(&mut app);
    let cube = spawn_ahead(&mut app, 5.0);
    app.update();
    app.world_mut().resource_mut::<IsOn>().0 = false;
    app.update();
    insert(&mut app, camera, Transform::from_rotation(Quat::from_rotation_y(2.0)));
    app.update();
    app.world_mut().resource_mut::<IsOn>().0 = true;
    app.update();
    assert!(!listed(&app, camera).contains(&cube));
    assert!(!app.world().get::<ViewVisibility>(cube).expect("a mesh").get());
}

#[test]
fn an_occluder_for_which_the_budget_does_not_suffice_is_counted() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let budget = OcclusionBudget {
        triangles: 11,
        ..default()
    };
    insert(&mut app, camera, SoftwareOcclusion { budget, ..default() });
    app.update();
    assert_eq!(
        app.world()
            .get::<OcclusionBuffer>(camera)
            .expect("a buffer")
            .stats()
            .over_budget,
        1
    );
}

#[test]
fn a_lamp_is_not_hidden_with_the_small_shape_by_which_it_is_picked() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let range = bevy::camera::primitives::Sphere {
        center: Vec3A::NEG_Z * 20.0,
        radius: 30.0,
    };
    let lamp = spawn(
        &mut app,
        (
            range,
            PickShape::new(Sphere::new(0.3)),
            Transform::from_xyz(0.0, 0.0, -20.0),
            Visibility::default(),
            VisibilityClass::default(),
        ),
    );
    finish(&mut app);
    app.update();
    let seen = app.world().get::<VisibleSet>(camera).expect("every camera has one");
    assert!(seen.contains(lamp));
}

#[test]
fn a_mesh_that_is_edited_while_the_index_is_paused_hides_afterwards_as_it_is_then() {
    let mut app = headless_app();
    app.insert_resource(IsOn(true))
        .configure_sets(PostUpdate, SpatialIndexSystems::Sync.run_if(|is_on: Res<IsOn>| is_on.0));
    let camera = spawn_camera(&mut app);
    let wall = spawn_mesh(
        &mut app,
        Cuboid::new(8.0, 6.0, 1.0),
        Transform::from_xyz(0.0, 0.0, -10.0),
    );
    insert(&mut app, wall, Occluder::Mesh);
    let behind = spawn_cube(&mut app, Vec3::new(3.0, 0.0, -20.0));
    finish(&mut app);
    assert!(!sees(&mut app, camera, behind));
    app.world_mut().resource_mut::<IsOn>().0 = false;
    let mesh = app.world().get::<Mesh3d>(wall).expect("a mesh").0.clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(&mesh, Cuboid::default().into()).expect("a live asset");
    app.update();
    app.world_mut().resource_mut::<IsOn>().0 = true;
    finish(&mut app);
    assert!(sees(&mut app, camera, behind));
}
