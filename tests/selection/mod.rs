//! What is in a rectangle or a polygon on the screen is selected, and nothing else.

mod oracle;

use std::f32::consts::TAU;

use bevy::{
    asset::RenderAssetUsages,
    camera::{
        CameraProjection, ComputedCameraValues, RenderTargetInfo, SubCameraView, Viewport, visibility::RenderLayers,
    },
    math::{Affine3A, DVec3, bounding::Aabb3d},
    mesh::PrimitiveTopology,
    prelude::*,
};
use bevy_sightline::{
    geometry::{obb::Obb, volume::BoundingKind},
    mesh::TriangleMesh,
    prelude::*,
    selection::UnusableRegion,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::{
    common::*,
    skinned_picking::rig::{move_joint, soup, spawn_rig, with_one_joint},
};
use oracle::Eye;

const TOUCHING: SelectionSettings = SelectionSettings {
    mode: SelectionMode::Touching,
    precision: SelectionPrecision::Mesh,
};
const ENCLOSED: SelectionSettings = SelectionSettings {
    mode: SelectionMode::Enclosed,
    ..TOUCHING
};

/// A camera with a screen of 800 by 600 pixels.
fn camera(clip_from_view: Mat4) -> Camera {
    camera_of_screen(clip_from_view, UVec2::new(800, 600), 1.0)
}

fn camera_of_screen(clip_from_view: Mat4, physical_size: UVec2, scale_factor: f32) -> Camera {
    Camera {
        computed: ComputedCameraValues {
            clip_from_view,
            target_info: Some(RenderTargetInfo {
                physical_size,
                scale_factor,
            }),
            ..default()
        },
        ..default()
    }
}

fn perspective() -> Mat4 {
    let projection = PerspectiveProjection {
        aspect_ratio: 4.0 / 3.0,
        ..default()
    };
    projection.get_clip_from_view()
}

/// A hundred pixels to the unit.
fn orthographic() -> Mat4 {
    let projection = OrthographicProjection {
        area: Rect::new(-4.0, -3.0, 4.0, 3.0),
        ..OrthographicProjection::default_3d()
    };
    projection.get_clip_from_view()
}

/// At z = 10, looking at the origin.
fn in_front() -> GlobalTransform {
    GlobalTransform::from_xyz(0.0, 0.0, 10.0)
}

type View<'a> = (&'a Camera, &'a GlobalTransform);

fn select(app: &mut App, view: View, region: &ScreenRegion, selection: SelectionSettings) -> Vec<Entity> {
    select_with(app, view, region, selection, &SceneQuerySettings::default())
}

fn select_with(
    app: &mut App,
    (camera, transform): View,
    region: &ScreenRegion,
    selection: SelectionSettings,
    settings: &SceneQuerySettings,
) -> Vec<Entity> {
    // What is there is written over.
    let mut selected = vec![Entity::PLACEHOLDER; 3];
    query(app, |scene| {
        scene.select_on_screen(camera, transform, region, &selection, settings, &mut selected);
    });
    assert!(selected.is_sorted());
    selected
}

fn sorted(entities: impl IntoIterator<Item = Entity>) -> Vec<Entity> {
    let mut entities: Vec<Entity> = entities.into_iter().collect();
    entities.sort_unstable();
    entities
}

/// A region with the corners that the oracle knows it by.
struct Marked {
    region: ScreenRegion,
    corners: Vec<Vec2>,
}

impl Marked {
    fn rect(a: Vec2, b: Vec2) -> Self {
        Self {
            region: ScreenRegion::rect(a, b),
            corners: vec![a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)],
        }
    }

    fn polygon(corners: Vec<Vec2>) -> Self {
        Self {
            region: ScreenRegion::polygon(&corners).expect("finite corners"),
            corners,
        }
    }
}

fn random_place(rng: &mut ChaCha8Rng) -> Vec2 {
    Vec2::new(rng.random_range(-50.0..850.0), rng.random_range(-50.0..650.0))
}

/// Rectangles, lassos drawn by an unsteady hand, stars, polygons that cross themselves, and clicks.
fn random_region(rng: &mut ChaCha8Rng) -> Marked {
    let (center, radius) = (random_place(rng), rng.random_range(10.0..400.0));
    let around = |angle: f32, radius: f32| center + Vec2::from_angle(angle) * radius;
    match rng.random_range(0..5) {
        0 => Marked::rect(random_place(rng), random_place(rng)),
        1 => {
            let corners = (0..80).map(|step| around(step as f32 / 80.0 * TAU, radius * rng.random_range(0.7..1.0)));
            Marked::polygon(corners.collect())
        }
        2 => {
            let corners = (0..10).map(|step| around(step as f32 / 10.0 * TAU, radius * [1.0, 0.3][step % 2]));
            Marked::polygon(corners.collect())
        }
        3 => Marked::polygon((0..7).map(|_| random_place(rng)).collect()),
        _ => Marked::rect(center, center),
    }
}

struct Scene {
    app: App,
    /// The entities with their triangles in the world.
    triangles: Vec<(Entity, Vec<[DVec3; 3]>)>,
}

/// A crowd around the origin, some of it mirrored, scaled unevenly, or flattened.
fn random_scene(rng: &mut ChaCha8Rng) -> Scene {
    let mut app = headless_app();
    let meshes: Vec<Mesh> = vec![
        Cuboid::default().into(),
        Sphere::new(0.7).mesh().ico(2).expect("few enough triangles"),
        Torus::default().into(),
        Plane3d::default().mesh().size(3.0, 0.5).build(),
        soup(rng, 12),
    ];
    let corners: Vec<Vec<[Vec3; 3]>> = meshes.iter().map(corners_of).collect();
    let meshes: Vec<Handle<Mesh>> = meshes.into_iter().map(|mesh| add_mesh(&mut app, mesh)).collect();
    let mut triangles = Vec::new();
    for _ in 0..120 {
        let kind = rng.random_range(0..meshes.len());
        let mut transform = Transform {
            translation: random_point(rng, 9.0),
            rotation: random_rotation(rng),
            scale: Vec3::from_array([0; 3].map(|_| rng.random_range(0.3..1.5))),
        };
        match rng.random_range(0..6) {
            0 => transform.scale *= -1.0,
            1 => transform.scale.y = 0.0,
            2 => transform.scale *= 3.0,
            _ => {}
        }
        let entity = app.world_mut().spawn((Mesh3d(meshes[kind].clone()), transform)).id();
        triangles.push((entity, placed(&corners[kind], &transform.compute_affine())));
    }
    settle(&mut app);
    Scene { app, triangles }
}

fn corners_of(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let triangles = TriangleMesh::from_mesh(mesh).expect("triangles");
    triangles.corners_of_all().collect()
}

fn placed(corners: &[[Vec3; 3]], transform: &Affine3A) -> Vec<[DVec3; 3]> {
    let transform = transform.as_daffine3();
    let place = |corner: Vec3| transform.transform_point3(corner.as_dvec3());
    corners.iter().map(|corners| corners.map(place)).collect()
}

/// Checks both modes of many regions against the oracle, and returns how many entities were selected.
fn assert_selects_as_the_oracle(scene: &mut Scene, view: View, rng: &mut ChaCha8Rng, regions: usize) -> usize {
    let eye = Eye::new(view.0, view.1);
    let mut found = 0;
    for _ in 0..regions {
        let marked = random_region(rng);
        for selection in [TOUCHING, ENCLOSED] {
            let expected = (scene.triangles.iter())
                .filter(|(_, triangles)| match selection.mode {
                    SelectionMode::Touching => eye.touches(triangles, &marked.corners),
                    SelectionMode::Enclosed => eye.encloses(triangles, &marked.corners),
                })
                .map(|(entity, _)| *entity);
            let expected = sorted(expected);
            let selected = select(&mut scene.app, view, &marked.region, selection);
            assert_eq!(selected, expected, "{selection:?} {:?}", marked.corners);
            found += selected.len();
        }
    }
    found
}

#[test]
fn meshes_are_selected_as_every_triangle_says_in_perspective() {
    let mut found = 0;
    for seed in 0..5 {
        let rng = &mut rng(seed);
        let mut scene = random_scene(rng);
        // Among the crowd, so that some of it is behind the camera and some goes through the near plane.
        for distance in [0.0, 6.0, 20.0] {
            let eye = random_dir(rng) * distance;
            let eye = GlobalTransform::from(Transform::from_translation(eye).looking_at(Vec3::splat(0.1), Vec3::Y));
            found += assert_selects_as_the_oracle(&mut scene, (&camera(perspective()), &eye), rng, 12);
        }
    }
    assert!(found > 1000, "{found}");
}

#[test]
fn meshes_are_selected_as_every_triangle_says_in_an_orthographic_view() {
    let mut found = 0;
    for seed in 10..14 {
        let rng = &mut rng(seed);
        let mut scene = random_scene(rng);
        for distance in [0.0, 20.0] {
            let eye = random_dir(rng) * distance;
            let eye = GlobalTransform::from(Transform::from_translation(eye).looking_at(Vec3::splat(0.1), Vec3::Y));
            found += assert_selects_as_the_oracle(&mut scene, (&camera(orthographic()), &eye), rng, 12);
        }
    }
    assert!(found > 500, "{found}");
}

#[test]
fn the_offset_of_a_viewport_and_the_scale_of_the_screen_count_in() {
    let rng = &mut rng(20);
    let mut scene = random_scene(rng);
    let mut camera = camera_of_screen(perspective(), UVec2::new(1600, 1200), 1.5);
    camera.viewport = Some(Viewport {
        physical_position: UVec2::new(300, 450),
        physical_size: UVec2::new(900, 600),
        ..default()
    });
    let eye = GlobalTransform::from(Transform::from_xyz(3.0, 5.0, 18.0).looking_at(Vec3::ZERO, Vec3::Y));
    let found = assert_selects_as_the_oracle(&mut scene, (&camera, &eye), rng, 40);
    assert!(found > 100, "{found}");

    // Left of and above the viewport.
    let aside = ScreenRegion::rect(Vec2::ZERO, Vec2::new(199.0, 299.0));
    assert_eq!(select(&mut scene.app, (&camera, &eye), &aside, TOUCHING), []);
}

#[test]
fn a_sub_view_selects_what_it_shows() {
    let rng = &mut rng(21);
    let mut scene = random_scene(rng);
    let sub_view = SubCameraView {
        full_size: UVec2::new(1600, 1200),
        offset: Vec2::new(500.0, 300.0),
        size: UVec2::new(800, 600),
    };
    let projection = PerspectiveProjection::default().get_clip_from_view_for_sub(&sub_view);
    let eye = GlobalTransform::from_xyz(0.0, 0.0, 20.0);
    let found = assert_selects_as_the_oracle(&mut scene, (&camera(projection), &eye), rng, 20);
    assert!(found > 100, "{found}");
}

#[test]
fn a_mirrored_and_scaled_camera_selects_what_it_shows() {
    let rng = &mut rng(22);
    let mut scene = random_scene(rng);
    let eye = Transform::from_xyz(0.0, 4.0, 15.0)
        .looking_at(Vec3::ZERO, Vec3::Y)
        .with_scale(Vec3::new(-0.5, 2.0, 1.0));
    let found = assert_selects_as_the_oracle(&mut scene, (&camera(perspective()), &eye.into()), rng, 20);
    assert!(found > 50, "{found}");
}

#[test]
fn it_makes_no_difference_whether_hierarchies_are_built() {
    let rng = &mut rng(23);
    let mut app = headless_app();
    for _ in 0..40 {
        let mesh = soup(rng, 60);
        spawn_mesh(&mut app, mesh, Transform::from_translation(random_point(rng, 4.0)));
    }
    let (camera, eye) = (camera(perspective()), in_front());
    let regions: Vec<Marked> = (0..20).map(|_| random_region(rng)).collect();
    let all = |app: &mut App| -> Vec<Vec<Entity>> {
        let mut select = |region: &Marked, selection| select(app, (&camera, &eye), &region.region, selection);
        regions
            .iter()
            .flat_map(|region| [TOUCHING, ENCLOSED].map(|selection| select(region, selection)))
            .collect()
    };
    app.update();
    let without = all(&mut app);
    finish_meshes(&mut app);
    assert_eq!(all(&mut app), without);
}

#[test]
fn bounds_are_the_world_boxes() {
    let rng = &mut rng(24);
    let Scene { mut app, triangles } = random_scene(rng);
    let boxes = triangles.iter().map(|(entity, _)| {
        let aabb = index(&app).aabb(*entity).expect("it is in the index");
        (*entity, triangles_of_box(&aabb))
    });
    let boxes: Vec<_> = boxes.collect();
    for (camera, eye) in [
        (camera(perspective()), GlobalTransform::from_xyz(0.0, 0.0, 14.0)),
        (camera(orthographic()), GlobalTransform::from_xyz(0.0, 1.0, 14.0)),
    ] {
        let oracle = Eye::new(&camera, &eye);
        for _ in 0..25 {
            let marked = random_region(rng);
            for mode in [SelectionMode::Touching, SelectionMode::Enclosed] {
                let by_bounds = TOUCHING.with_mode(mode).with_precision(SelectionPrecision::Bounds);
                let is_expected = |triangles: &[[DVec3; 3]]| match mode {
                    SelectionMode::Touching => oracle.touches(triangles, &marked.corners),
                    SelectionMode::Enclosed => oracle.encloses(triangles, &marked.corners),
                };
                let expected = boxes.iter().filter(|(_, triangles)| is_expected(triangles));
                let expected = sorted(expected.map(|(entity, _)| *entity));
                let selected = select(&mut app, (&camera, &eye), &marked.region, by_bounds);
                assert_eq!(selected, expected, "{mode:?} {:?}", marked.corners);
            }
        }
    }
}

fn triangles_of_box(aabb: &Aabb3d) -> Vec<[DVec3; 3]> {
    let corners = Obb::from(*aabb).corners().map(|corner| Vec3::from(corner).as_dvec3());
    // Every triangle of corners is on the box or inside.
    let mut triangles = Vec::new();
    for a in 0..8 {
        for b in 0..a {
            triangles.extend((0..b).map(|c| [corners[a], corners[b], corners[c]]));
        }
    }
    triangles
}

#[test]
fn a_click_selects_all_that_a_ray_through_it_hits() {
    let rng = &mut rng(25);
    let mut scene = random_scene(rng);
    let (camera, eye) = (camera(perspective()), GlobalTransform::from_xyz(0.0, 0.0, 12.0));
    let settings = SceneQuerySettings::default().with_backfaces(Backfaces::Include);
    let mut found = 0;
    for _ in 0..300 {
        let place = Vec2::new(rng.random_range(0.0..800.0), rng.random_range(0.0..600.0));
        let selected = select(&mut scene.app, (&camera, &eye), &ScreenRegion::point(place), TOUCHING);
        let ray = camera.viewport_to_world(&eye, place).expect("a ray");
        let mut hits = Vec::new();
        query(&mut scene.app, |scene| scene.cast_ray_all(ray, &settings, &mut hits));
        let hit = sorted(hits.iter().map(|hit| hit.entity));
        assert_eq!(selected, hit, "at {place}");
        found += hit.len();
    }
    assert!(found > 100, "{found}");
}

#[test]
fn nothing_behind_the_camera_is_selected() {
    let mut app = headless_app();
    let ahead = spawn_cube(&mut app, Vec3::ZERO);
    spawn_cube(&mut app, Vec3::Z * 20.0);
    spawn_cube(&mut app, Vec3::Z * 10.6);
    app.world_mut()
        .spawn((PickShape::new(Sphere::new(0.5)), Transform::from_xyz(0.0, 0.0, 10.6)));
    settle(&mut app);
    let everything = ScreenRegion::rect(Vec2::splat(-1e4), Vec2::splat(1e4));
    let (lasso, eye) = (
        Marked::polygon(vec![Vec2::splat(-1e4), Vec2::new(1e4, 0.0), Vec2::new(0.0, 1e4)]),
        in_front(),
    );
    for clip_from_view in [perspective(), orthographic()] {
        let camera = camera(clip_from_view);
        for region in [&everything, &lasso.region] {
            assert_eq!(select(&mut app, (&camera, &eye), region, TOUCHING), [ahead]);
            assert_eq!(select(&mut app, (&camera, &eye), region, ENCLOSED), [ahead]);
        }
    }
}

#[test]
fn a_perspective_view_has_no_end_and_an_orthographic_one_has() {
    let mut app = headless_app();
    let far = spawn_mesh(
        &mut app,
        Cuboid::default(),
        Transform::from_xyz(0.0, 0.0, -1e6).with_scale(Vec3::splat(1e6)),
    );
    settle(&mut app);
    let (eye, middle) = (in_front(), ScreenRegion::point(Vec2::new(400.0, 300.0)));
    assert_eq!(
        select(&mut app, (&camera(perspective()), &eye), &middle, TOUCHING),
        [far]
    );
    assert_eq!(select(&mut app, (&camera(orthographic()), &eye), &middle, TOUCHING), []);
}

#[test]
fn what_is_beside_the_screen_is_not_selected() {
    let mut app = headless_app();
    let (on_the_edge, beside) = (Vec3::new(4.0, 0.0, 0.0), Vec3::new(5.0, 0.0, 0.0));
    let on_the_edge = spawn_cube(&mut app, on_the_edge);
    spawn_cube(&mut app, beside);
    settle(&mut app);
    let (camera, eye) = (camera(orthographic()), in_front());
    let dragged_out = ScreenRegion::rect(Vec2::new(700.0, 100.0), Vec2::new(1500.0, 500.0));
    assert_eq!(select(&mut app, (&camera, &eye), &dragged_out, TOUCHING), [on_the_edge]);
    assert_eq!(select(&mut app, (&camera, &eye), &dragged_out, ENCLOSED), []);
}

#[test]
fn contact_counts_and_what_fits_is_enclosed() {
    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    // Without rounding: a cube from 448 to 576 and from 192 to 320 on the screen.
    let projection = OrthographicProjection {
        area: Rect::new(-4.0, -2.0, 4.0, 2.0),
        ..OrthographicProjection::default_3d()
    };
    let camera = camera_of_screen(projection.get_clip_from_view(), UVec2::new(1024, 512), 1.0);
    let eye = in_front();
    let mut select = |region, selection| select(&mut app, (&camera, &eye), &region, selection);
    let rect = |a: [f32; 2], b: [f32; 2]| ScreenRegion::rect(a.into(), b.into());
    assert_eq!(select(rect([576.0, 0.0], [600.0, 192.0]), TOUCHING), [cube]);
    assert_eq!(select(rect([576.001, 0.0], [600.0, 192.0]), TOUCHING), []);
    assert_eq!(select(rect([576.0, 320.0], [448.0, 192.0]), ENCLOSED), [cube]);
    assert_eq!(select(rect([575.999, 320.0], [448.0, 192.0]), ENCLOSED), []);
    let lasso = |last: f32| {
        let corners = [[448.0, 192.0], [576.0, 192.0], [last, 320.0], [448.0, 320.0]];
        ScreenRegion::polygon(&corners.map(Vec2::from)).expect("finite corners")
    };
    assert_eq!(select(lasso(576.0), ENCLOSED), [cube]);
    assert_eq!(select(lasso(575.999), ENCLOSED), []);
}

#[test]
fn a_line_selects_what_it_cuts() {
    let mut app = headless_app();
    let cut = spawn_cube(&mut app, Vec3::ZERO);
    spawn_cube(&mut app, Vec3::Y * 1.5);
    settle(&mut app);
    let (camera, eye) = (camera(orthographic()), in_front());
    let line = ScreenRegion::polygon(&[Vec2::new(100.0, 260.0), Vec2::new(700.0, 340.0)]).expect("finite corners");
    assert_eq!(select(&mut app, (&camera, &eye), &line, TOUCHING), [cut]);
    assert_eq!(select(&mut app, (&camera, &eye), &line, ENCLOSED), []);
}

#[test]
fn what_a_lasso_goes_around_twice_is_outside() {
    let mut app = headless_app();
    let cube = Transform::from_scale(Vec3::splat(0.1));
    spawn_mesh(&mut app, Cuboid::default(), cube);
    let in_a_point = spawn_mesh(&mut app, Cuboid::default(), cube.with_translation(Vec3::Y * 1.6));
    settle(&mut app);
    let (camera, eye) = (camera(orthographic()), in_front());
    // A pentagram, in one stroke.
    let tip = |number: usize| Vec2::new(400.0, 300.0) + Vec2::from_angle(TAU * (0.4 * number as f32 - 0.25)) * 200.0;
    let star = ScreenRegion::polygon(&[0, 1, 2, 3, 4].map(tip)).expect("finite corners");
    assert_eq!(select(&mut app, (&camera, &eye), &star, TOUCHING), [in_a_point]);
    assert_eq!(select(&mut app, (&camera, &eye), &star, ENCLOSED), [in_a_point]);
    assert!(!star.contains(Vec2::new(400.0, 300.0)) && star.contains(Vec2::new(400.0, 120.0)));
}

#[test]
fn settings_say_which_entities_are_considered() {
    let mut app = headless_app();
    let shown = spawn_cube(&mut app, Vec3::X);
    let hidden = spawn_cube(&mut app, Vec3::NEG_X);
    let layered = spawn_cube(&mut app, Vec3::Y);
    app.world_mut().entity_mut(hidden).insert(Visibility::Hidden);
    app.world_mut().entity_mut(layered).insert(RenderLayers::layer(3));
    settle(&mut app);
    let (camera, eye) = (camera(perspective()), in_front());
    let everything = ScreenRegion::rect(Vec2::ZERO, Vec2::new(800.0, 600.0));
    let mut select =
        |settings: SceneQuerySettings| select_with(&mut app, (&camera, &eye), &everything, TOUCHING, &settings);
    let all = SceneQuerySettings::default();
    assert_eq!(select(all), sorted([shown, layered]));
    assert_eq!(
        select(all.with_visibility(QueryVisibility::Any)),
        sorted([shown, hidden, layered])
    );
    assert_eq!(select(all.with_layers(&RenderLayers::layer(3))), [layered]);
    assert_eq!(select(all.excluding(&[shown])), [layered]);
    assert_eq!(select(all.filter(&|entity| entity == shown)), [shown]);
}

#[test]
fn what_is_despawned_is_not_selected() {
    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    app.world_mut().despawn(cube);
    let (camera, eye) = (camera(perspective()), in_front());
    let everything = ScreenRegion::rect(Vec2::ZERO, Vec2::new(800.0, 600.0));
    assert_eq!(select(&mut app, (&camera, &eye), &everything, TOUCHING), []);
}

#[test]
fn a_skinned_mesh_is_selected_where_it_is_drawn() {
    let mut app = headless_app();
    let rig = spawn_rig(
        &mut app,
        with_one_joint(Cuboid::default().into()),
        &[Transform::from_xyz(2.0, 0.0, 0.0)],
    );
    settle(&mut app);
    let (camera, eye) = (camera(orthographic()), in_front());
    let at = |app: &mut App, x: f32, selection| {
        let corner = Vec2::new(400.0 + 100.0 * x, 300.0);
        let region = ScreenRegion::rect(corner - 60.0, corner + 60.0);
        select(app, (&camera, &eye), &region, selection) == [rig.entity]
    };
    assert!(at(&mut app, 2.0, TOUCHING) && at(&mut app, 2.0, ENCLOSED) && !at(&mut app, 0.0, TOUCHING));
    move_joint(
        &mut app,
        rig.joints[0],
        Transform::from_xyz(-2.0, 0.0, 0.0).with_scale(Vec3::splat(0.5)),
    );
    app.update();
    assert!(at(&mut app, -2.0, TOUCHING) && at(&mut app, -2.0, ENCLOSED) && !at(&mut app, 2.0, TOUCHING));
    assert!(!at(&mut app, -1.1, TOUCHING) && at(&mut app, -1.4, TOUCHING) && !at(&mut app, -1.4, ENCLOSED));
}

/// Solids of half a unit around the origin, and how far up and right from there the corner of a quadrant must be to miss
/// them, in an orthographic view from the front.
fn solids() -> Vec<(&'static str, PickShape, f32)> {
    let mut group = SurfaceGroup::new();
    group.push(Sphere::new(0.5));
    group.push(Sphere::new(0.1));
    vec![
        ("sphere", PickShape::new(Sphere::new(0.5)), 0.5),
        (
            "negative sphere",
            PickShape::new(Sphere { radius: -0.5 }),
            0.5_f32.sqrt(),
        ),
        ("cuboid", PickShape::new(Cuboid::default()), 0.5_f32.sqrt()),
        ("cylinder", PickShape::new(Cylinder::new(0.5, 1.0)), 0.5_f32.sqrt()),
        ("cone", PickShape::new(Cone::new(0.5, 1.0)), 2.0_f32.sqrt() / 6.0),
        ("capsule", PickShape::new(Capsule3d::new(0.5, 0.0)), 0.5),
        ("torus", PickShape::new(Torus::new(0.3, 0.5)), 0.1 * 2.0_f32.sqrt()),
        ("extrusion", PickShape::new(Extrusion::new(Circle::new(0.5), 1.0)), 0.5),
        ("group", PickShape::new(group), 0.5),
    ]
}

#[test]
fn analytic_solids_are_selected_by_their_shape_and_not_by_their_box() {
    for (name, shape, reach) in solids() {
        let mut app = headless_app();
        let entity = app.world_mut().spawn(shape).id();
        settle(&mut app);
        let (camera, eye) = (camera(orthographic()), in_front());
        let middle = Vec2::new(400.0, 300.0);
        let mut touches = |distance: f32| {
            // From that far along the diagonal, up and right: a corner, and a corner of a lasso.
            let corner = middle + Vec2::new(1.0, -1.0) * 0.5_f32.sqrt() * distance * 100.0;
            let rect = ScreenRegion::rect(corner, corner + Vec2::new(300.0, -300.0));
            let lasso = [corner, corner + Vec2::new(300.0, -1.0), corner + Vec2::new(1.0, -300.0)];
            let lasso = ScreenRegion::polygon(&lasso).expect("finite corners");
            let found = [rect, lasso].map(|region| select(&mut app, (&camera, &eye), &region, TOUCHING) == [entity]);
            assert_eq!(found[0], found[1], "{name}: a rectangle and a lasso");
            found[0]
        };
        assert!(touches(reach - 0.001), "{name} is missed");
        assert!(!touches(reach + 0.001), "{name} is too large");
        let mut encloses = |half: f32| {
            let rect = ScreenRegion::rect(middle - half, middle + half);
            let lasso = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|at| middle + Vec2::from(at) * half);
            let lasso = ScreenRegion::polygon(&lasso).expect("finite corners");
            [rect, lasso].map(|region| select(&mut app, (&camera, &eye), &region, ENCLOSED) == [entity])
        };
        assert_eq!(encloses(50.1), [true; 2], "{name} is enclosed");
        assert_eq!(encloses(49.9), [false; 2], "{name} is not enclosed");
    }
}

#[test]
fn analytic_solids_in_perspective_are_selected_where_rays_hit_them() {
    let rng = &mut rng(30);
    let mut app = headless_app();
    for _ in 0..60 {
        let (_, shape, _) = solids().swap_remove(rng.random_range(0..6));
        let transform = Transform {
            translation: random_point(rng, 6.0),
            rotation: random_rotation(rng),
            scale: Vec3::from_array([0; 3].map(|_| rng.random_range(0.3..2.0))),
        };
        app.world_mut().spawn((shape, transform));
    }
    settle(&mut app);
    let (camera, eye) = (camera(perspective()), in_front());
    let settings = SceneQuerySettings::default().with_backfaces(Backfaces::Include);
    let mut clicked = 0;
    for _ in 0..100 {
        let place = Vec2::new(rng.random_range(0.0..800.0), rng.random_range(0.0..600.0));
        let ray = camera.viewport_to_world(&eye, place).expect("a ray");
        let mut hits = Vec::new();
        query(&mut app, |scene| scene.cast_ray_all(ray, &settings, &mut hits));
        let hit = sorted(hits.iter().map(|hit| hit.entity));
        let selected = select(&mut app, (&camera, &eye), &ScreenRegion::point(place), TOUCHING);
        // The box stands in for a sphere of negative radius.
        assert!(hit.iter().all(|entity| selected.contains(entity)), "at {place}");
        let lasso = ScreenRegion::polygon(&[place, place + 30.0, place - Vec2::X * 30.0]).expect("finite corners");
        let touched = select(&mut app, (&camera, &eye), &lasso, TOUCHING);
        assert!(selected.iter().all(|entity| touched.contains(entity)), "around {place}");
        clicked += hit.len();
    }
    assert!(clicked > 30, "{clicked}");
}

#[test]
fn a_volume_is_selected_in_place_of_the_mesh() {
    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    let (camera, eye) = (camera(orthographic()), in_front());
    // Above the cube, in the sphere around it.
    let above = ScreenRegion::point(Vec2::new(400.0, 300.0 - 70.0));
    assert_eq!(select(&mut app, (&camera, &eye), &above, TOUCHING), []);
    app.world_mut()
        .entity_mut(cube)
        .insert(HitSurface::Volume(BoundingKind::Sphere));
    settle(&mut app);
    assert_eq!(select(&mut app, (&camera, &eye), &above, TOUCHING), [cube]);
    let corner = ScreenRegion::point(Vec2::new(400.0 + 70.0, 300.0 - 70.0));
    assert_eq!(select(&mut app, (&camera, &eye), &corner, TOUCHING), []);
}

#[test]
fn what_has_no_surface_is_selected_by_its_bounds() {
    let mut app = headless_app();
    let line = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]);
    let line = spawn_mesh(&mut app, line, Transform::default());
    let bounds = bevy::camera::primitives::Aabb::from_min_max(Vec3::splat(-1.0), Vec3::splat(1.0));
    let bare = app.world_mut().spawn((bounds, Transform::default())).id();
    settle(&mut app);
    let (camera, eye) = (camera(orthographic()), in_front());
    let corner = ScreenRegion::point(Vec2::new(310.0, 210.0));
    assert_eq!(
        select(&mut app, (&camera, &eye), &corner, TOUCHING),
        sorted([line, bare])
    );
    let around = ScreenRegion::rect(Vec2::new(299.0, 199.0), Vec2::new(501.0, 401.0));
    assert_eq!(
        select(&mut app, (&camera, &eye), &around, ENCLOSED),
        sorted([line, bare])
    );
}

#[test]
fn bad_regions_are_refused_or_select_nothing() {
    let nan = Vec2::new(f32::NAN, 0.0);
    assert_eq!(ScreenRegion::polygon(&[]).err(), Some(UnusableRegion::Empty));
    let infinite = ScreenRegion::polygon(&[Vec2::ZERO, Vec2::splat(f32::INFINITY)]);
    assert_eq!(infinite.err(), Some(UnusableRegion::NotFinite(1)));
    assert_eq!(ScreenRegion::polygon(&[nan]).err(), Some(UnusableRegion::NotFinite(0)));
    assert!(!ScreenRegion::rect(Vec2::ZERO, Vec2::ONE).contains(nan));

    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    let (camera, eye) = (camera(perspective()), in_front());
    for corner in [nan, Vec2::INFINITY, Vec2::NEG_INFINITY] {
        let region = ScreenRegion::rect(Vec2::ZERO, corner);
        assert_eq!(select(&mut app, (&camera, &eye), &region, TOUCHING), []);
    }
    let huge = ScreenRegion::rect(Vec2::splat(f32::MIN), Vec2::splat(f32::MAX));
    assert_eq!(select(&mut app, (&camera, &eye), &huge, ENCLOSED), [cube]);
    let corners = [
        Vec2::splat(f32::MIN),
        Vec2::new(f32::MAX, f32::MIN),
        Vec2::new(0.0, f32::MAX),
    ];
    let huge = ScreenRegion::polygon(&corners).expect("finite corners");
    assert_eq!(select(&mut app, (&camera, &eye), &huge, TOUCHING), [cube]);
    let many = ScreenRegion::polygon(&[Vec2::new(400.0, 300.0); 1000]).expect("finite corners");
    assert_eq!(select(&mut app, (&camera, &eye), &many, TOUCHING), [cube]);
}

#[test]
fn a_camera_that_sees_nothing_selects_nothing() {
    let mut app = headless_app();
    spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    let everything = ScreenRegion::rect(Vec2::splat(-1e5), Vec2::splat(1e5));
    let without_near = Mat4::perspective_infinite_reverse_rh(1.0, 1.0, 0.0);
    let mut sightless = vec![
        (Camera::default(), in_front()),
        (camera_of_screen(perspective(), UVec2::ZERO, 1.0), in_front()),
        (camera_of_screen(perspective(), UVec2::ONE, 0.0), in_front()),
        (camera_of_screen(perspective(), UVec2::ONE, f32::NAN), in_front()),
    ];
    for matrix in [
        Mat4::ZERO,
        Mat4::NAN,
        Mat4::from_diagonal(Vec4::new(1.0, 1.0, 0.0, 1.0)),
        without_near,
    ] {
        sightless.push((camera(matrix), in_front()));
    }
    for eye in [
        Transform::from_scale(Vec3::new(1.0, 0.0, 1.0)),
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_xyz(f32::INFINITY, 0.0, 0.0),
    ] {
        sightless.push((camera(perspective()), eye.into()));
    }
    for (number, (camera, eye)) in sightless.iter().enumerate() {
        for selection in [TOUCHING, ENCLOSED] {
            assert_eq!(
                select(&mut app, (camera, eye), &everything, selection),
                [],
                "camera {number}"
            );
        }
    }
}
