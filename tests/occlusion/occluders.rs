//! Occluders follow the world: every way to occlude has its way out, and the version tells of each.

use bevy::{
    asset::RenderAssetUsages,
    camera::{
        primitives::Aabb,
        visibility::{RenderLayers, VisibilityRange},
    },
    ecs::entity_disabling::Disabled,
    math::{Affine3A, bounding::Aabb3d},
    mesh::{MeshAccessError, PrimitiveTopology, morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
};
use bevy_sightline::{
    mesh::{InnerBoxSettings, NotSolid, UnusableMesh},
    occlusion::{Occluder, OccluderRefusal, OccluderSettings, OccluderShape, Occluders, OcclusionSystems},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

// --- The app ---

fn occluding_app() -> App {
    headless_app()
}

fn occluders(app: &App) -> &Occluders {
    app.world().resource()
}

/// Runs frames until all shapes are made.
fn finish(app: &mut App) {
    app.update();
    while occluders(app).making() > 0 {
        app.update();
    }
}

/// What an entity occludes by, once all shapes are made.
fn shape(app: &mut App, entity: Entity) -> Option<OccluderShape> {
    finish(app);
    occluders(app).get(entity).map(|(shape, _)| shape.clone())
}

fn occludes(app: &mut App, entity: Entity) -> bool {
    shape(app, entity).is_some()
}

fn boxes(app: &mut App, entity: Entity) -> Vec<Aabb3d> {
    match shape(app, entity) {
        Some(OccluderShape::Boxes(boxes)) => boxes.to_vec(),
        other => panic!("not boxes: {other:?}"),
    }
}

/// The corners of the box around the triangles that an entity occludes by.
fn triangle_bounds(app: &mut App, entity: Entity) -> (Vec3, Vec3) {
    match shape(app, entity) {
        Some(OccluderShape::Mesh(mesh)) => {
            let aabb = mesh.aabb().expect("triangles");
            (aabb.min.into(), aabb.max.into())
        }
        other => panic!("not triangles: {other:?}"),
    }
}

fn refusal(app: &mut App, entity: Entity) -> Option<OccluderRefusal> {
    finish(app);
    occluders(app)
        .refused()
        .find(|&(refused, _)| refused == entity)
        .map(|(_, why)| why)
}

fn spawn(app: &mut App, mesh: impl Into<Mesh>, occluder: Occluder) -> Entity {
    let mesh = add_mesh(app, mesh);
    app.world_mut().spawn((Mesh3d(mesh), occluder)).id()
}

/// A unit cube that occludes by the box inside of it.
fn spawn_occluder(app: &mut App) -> Entity {
    spawn(app, Cuboid::default(), Occluder::Auto)
}

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
}

fn remove<B: Bundle>(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).remove::<B>();
}

fn edit(app: &mut App, entity: Entity, edit: impl FnOnce(&mut Mesh)) {
    let mesh = app.world().get::<Mesh3d>(entity).expect("a mesh").0.clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    edit(&mut meshes.get_mut(&mesh).expect("a loaded mesh"));
}

fn open_mesh() -> Mesh {
    Plane3d::default().mesh().build()
}

/// Visible up to a distance, and half there near it, if there is a margin.
fn up_to(end: f32, margin: f32) -> VisibilityRange {
    VisibilityRange {
        start_margin: 0.0..0.0,
        end_margin: end - margin..end,
        use_aabb: false,
    }
}

// --- Kinds ---

#[test]
fn a_mesh_occludes_by_the_boxes_inside_of_it() {
    let mut app = occluding_app();
    let cube = spawn(&mut app, Cuboid::new(2.0, 4.0, 6.0), Occluder::Auto);
    let [aabb] = boxes(&mut app, cube)[..] else {
        panic!("not one box");
    };
    assert!(aabb.max.cmplt(Vec3A::new(1.0, 2.0, 3.0)).all() && aabb.max.cmpgt(Vec3A::new(0.99, 1.99, 2.99)).all());
}

#[test]
fn nothing_is_hidden_until_the_boxes_are_found() {
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    app.update();
    assert_eq!(occluders(&app).making(), 1);
    assert!(occluders(&app).get(cube).is_none());
    assert!(occludes(&mut app, cube));
}

#[test]
fn instances_of_a_mesh_share_one_shape() {
    let mut app = occluding_app();
    let mesh = add_mesh(&mut app, Cuboid::default());
    let [a, b] = [0, 1].map(|_| app.world_mut().spawn((Mesh3d(mesh.clone()), Occluder::Auto)).id());
    app.update();
    assert_eq!(occluders(&app).making(), 1);
    let (Some(OccluderShape::Boxes(a)), Some(OccluderShape::Boxes(b))) = (shape(&mut app, a), shape(&mut app, b))
    else {
        panic!("no boxes");
    };
    assert!(std::sync::Arc::ptr_eq(&a, &b));
}

#[test]
fn a_box_occludes_by_its_bounds_at_once() {
    let mut app = occluding_app();
    let aabb = Aabb::from_min_max(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0));
    let wall = app.world_mut().spawn((Transform::default(), aabb, Occluder::Box)).id();
    app.update();
    assert!(occluders(&app).get(wall).is_some());
    let expected = Aabb3d {
        min: Vec3A::ZERO,
        max: Vec3A::new(1.0, 2.0, 3.0),
    };
    assert_eq!(boxes(&mut app, wall), [expected]);
    insert(&mut app, wall, Aabb::from_min_max(Vec3::ZERO, Vec3::ONE));
    assert_eq!(
        boxes(&mut app, wall),
        [Aabb3d {
            max: Vec3A::ONE,
            ..expected
        }]
    );
}

#[test]
fn triangles_are_those_of_the_mesh_open_or_not() {
    let mut app = occluding_app();
    let plane = spawn(&mut app, open_mesh(), Occluder::Mesh);
    let corner = Vec3::new(0.5, 0.0, 0.5);
    assert_eq!(triangle_bounds(&mut app, plane), (-corner, corner));
}

#[test]
fn a_proxy_brings_the_triangles_of_another_mesh() {
    let mut app = occluding_app();
    let proxy = add_mesh(&mut app, Cuboid::from_length(0.5));
    let ball = spawn(&mut app, Sphere::new(1.0), Occluder::Proxy(proxy));
    assert_eq!(triangle_bounds(&mut app, ball), (Vec3::splat(-0.25), Vec3::splat(0.25)));
}

#[test]
fn the_kind_may_change() {
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    assert_eq!(boxes(&mut app, cube).len(), 1);
    insert(&mut app, cube, Occluder::Mesh);
    triangle_bounds(&mut app, cube);
    insert(&mut app, cube, Occluder::Box);
    assert_eq!(boxes(&mut app, cube)[0].max, Vec3A::splat(0.5));
    insert(&mut app, cube, Occluder::Auto);
    assert!(boxes(&mut app, cube)[0].max.cmplt(Vec3A::splat(0.5)).all());
}

#[test]
fn what_has_only_the_gpu_by_now_occludes_by_the_copy_of_the_index() {
    let mut app = occluding_app();
    let mut mesh = Mesh::from(Cuboid::default());
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let mesh = add_mesh(&mut app, mesh);
    let cube = app.world_mut().spawn(Mesh3d(mesh.clone())).id();
    settle(&mut app);
    // As the renderer does.
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let taken = meshes.get_mut_untracked(&mesh).expect("a loaded mesh").take_gpu_data();
    assert!(!matches!(taken, Err(MeshAccessError::ExtractedToRenderWorld)));
    insert(&mut app, cube, Occluder::Auto);
    assert!(occludes(&mut app, cube));
}

// --- In and out ---

/// Whatever stops an entity from occluding, and lets it again; each grows the version.
fn assert_undone(occluder: Occluder, change: impl Fn(&mut App, Entity), undo: impl Fn(&mut App, Entity)) {
    let mut app = occluding_app();
    let cube = spawn(&mut app, Cuboid::default(), occluder);
    assert!(occludes(&mut app, cube));
    for _ in 0..2 {
        let before = occluders(&app).version();
        change(&mut app, cube);
        app.update();
        assert!(occluders(&app).get(cube).is_none(), "at once");
        assert!(!occludes(&mut app, cube));
        let between = occluders(&app).version();
        assert!(between > before);
        undo(&mut app, cube);
        assert!(occludes(&mut app, cube));
        assert!(occluders(&app).version() > between);
    }
    app.world_mut().despawn(cube);
    app.update();
    assert!(occluders(&app).is_empty() && occluders(&app).refused().len() == 0);
}

#[test]
fn the_component_comes_and_goes() {
    assert_undone(Occluder::Auto, remove::<Occluder>, |app, cube| {
        insert(app, cube, Occluder::Auto);
    });
}

#[test]
fn the_mesh_comes_and_goes() {
    for occluder in [Occluder::Auto, Occluder::Mesh] {
        assert_undone(occluder, remove::<Mesh3d>, |app, cube| {
            let mesh = add_mesh(app, Cuboid::default());
            insert(app, cube, Mesh3d(mesh));
        });
    }
}

#[test]
fn the_bounds_of_a_box_come_and_go() {
    assert_undone(Occluder::Box, remove::<(Aabb, Mesh3d)>, |app, cube| {
        insert(app, cube, Aabb::from_min_max(Vec3::ZERO, Vec3::ONE));
    });
}

#[test]
fn the_place_comes_and_goes() {
    assert_undone(Occluder::Auto, remove::<GlobalTransform>, |app, cube| {
        insert(app, cube, GlobalTransform::IDENTITY);
    });
}

#[test]
fn a_place_that_is_nan_is_none() {
    assert_undone(
        Occluder::Auto,
        |app, cube| insert(app, cube, Transform::from_xyz(f32::NAN, 0.0, 0.0)),
        |app, cube| insert(app, cube, Transform::default()),
    );
}

#[test]
fn what_is_hidden_hides_nothing() {
    assert_undone(
        Occluder::Auto,
        |app, cube| insert(app, cube, Visibility::Hidden),
        |app, cube| insert(app, cube, Visibility::Inherited),
    );
}

#[test]
fn what_is_disabled_hides_nothing() {
    for occluder in [Occluder::Auto, Occluder::Box] {
        assert_undone(occluder, |app, cube| insert(app, cube, Disabled), remove::<Disabled>);
    }
}

#[test]
fn what_is_skinned_or_morphed_is_not_where_its_mesh_is() {
    for occluder in [Occluder::Auto, Occluder::Mesh] {
        assert_undone(
            occluder.clone(),
            |app, cube| insert(app, cube, SkinnedMesh::default()),
            remove::<SkinnedMesh>,
        );
        assert_undone(
            occluder,
            |app, cube| insert(app, cube, MeshMorphWeights::Value { weights: vec![] }),
            remove::<MeshMorphWeights>,
        );
    }
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    insert(&mut app, cube, SkinnedMesh::default());
    assert_eq!(refusal(&mut app, cube), Some(OccluderRefusal::Posed));
}

#[test]
fn what_fades_at_some_distance_is_not_always_whole() {
    assert_undone(
        Occluder::Auto,
        |app, cube| insert(app, cube, up_to(20.0, 5.0)),
        |app, cube| insert(app, cube, up_to(20.0, 0.0)),
    );
}

#[test]
fn the_asset_goes_and_comes_back() {
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    assert!(occludes(&mut app, cube));
    let id = app.world().get::<Mesh3d>(cube).expect("a mesh").id();
    let mesh = app
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .remove(id)
        .expect("a loaded mesh");
    app.update();
    assert!(!occludes(&mut app, cube));
    assert_eq!(refusal(&mut app, cube), None, "it may be on its way");
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(id, mesh)
        .expect("a handle that is in use");
    assert!(occludes(&mut app, cube));
}

/// Despawns an entity and spawns another with its index.
fn replace_by_namesake(app: &mut App, old: Entity, bundle: impl Bundle) -> Entity {
    let world = app.world_mut();
    let place = world.despawn_no_free(old).expect("it was there");
    world.spawn_at(place, bundle).expect("nobody is there").id()
}

#[test]
fn an_entity_in_the_place_of_another_is_not_the_other() {
    let mut app = occluding_app();
    let first = spawn_occluder(&mut app);
    assert!(occludes(&mut app, first));
    let mesh = Mesh3d(add_mesh(&mut app, Cuboid::default()));
    let second = replace_by_namesake(&mut app, first, (mesh, Occluder::Auto));
    assert!(occludes(&mut app, second) && !occludes(&mut app, first));
    assert_eq!(occluders(&app).iter().collect::<Vec<_>>(), [second]);
}

/// Whether occluders are followed.
#[derive(Resource)]
struct IsOn(bool);

/// Goes on after so many frames that Bevy has forgotten what was despawned at first.
fn pause(app: &mut App, meanwhile: impl FnOnce(&mut App)) {
    app.insert_resource(IsOn(false));
    meanwhile(app);
    (0..5).for_each(|_| app.update());
    app.insert_resource(IsOn(true));
    finish(app);
}

#[test]
fn what_has_happened_in_a_pause_is_found_out() {
    let mut app = occluding_app();
    app.insert_resource(IsOn(true));
    let is_on = |on: Res<IsOn>| on.0;
    app.configure_sets(PostUpdate, OcclusionSystems::FollowOccluders.run_if(is_on));
    let [a, b, c] = [0; 3].map(|_| spawn_occluder(&mut app));
    finish(&mut app);
    let mesh = Mesh3d(add_mesh(&mut app, Cuboid::default()));
    let mut new = Entity::PLACEHOLDER;
    pause(&mut app, |app| {
        new = replace_by_namesake(app, a, (mesh, Occluder::Auto));
        insert(app, b, Transform::from_xyz(1.0, 0.0, 0.0));
        app.world_mut().despawn(c);
    });
    let mut all: Vec<Entity> = occluders(&app).iter().collect();
    all.sort_unstable();
    let mut left = [new, b];
    left.sort_unstable();
    assert_eq!(all, left);
    let (_, place) = occluders(&app).get(b).expect("it is still there");
    assert_eq!(place.translation, Vec3A::X);
}

// --- Meshes that change ---

#[test]
fn boxes_are_found_anew_when_the_mesh_is_edited() {
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    finish(&mut app);
    edit(&mut app, cube, |mesh| *mesh = Cuboid::from_length(4.0).into());
    app.update();
    assert!(
        occluders(&app).get(cube).is_none(),
        "the old ones are not those of the mesh"
    );
    assert!(boxes(&mut app, cube)[0].max.x > 1.9);
}

#[test]
fn a_proxy_follows_its_mesh() {
    let mut app = occluding_app();
    let proxy = add_mesh(&mut app, Cuboid::from_length(0.5));
    let ball = spawn(&mut app, Sphere::new(1.0), Occluder::Proxy(proxy.clone()));
    finish(&mut app);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    *meshes.get_mut(&proxy).expect("a loaded mesh") = Cuboid::from_length(0.25).into();
    assert_eq!(triangle_bounds(&mut app, ball).1, Vec3::splat(0.125));
}

#[test]
fn another_mesh_is_another_shape() {
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    finish(&mut app);
    let mesh = add_mesh(&mut app, Cuboid::from_length(2.0));
    insert(&mut app, cube, Mesh3d(mesh));
    assert!(boxes(&mut app, cube)[0].max.x > 0.9);
}

#[test]
fn open_meshes_are_listed_until_they_are_closed() {
    let mut app = occluding_app();
    let thing = spawn(&mut app, open_mesh(), Occluder::Auto);
    let why = refusal(&mut app, thing);
    assert!(
        matches!(why, Some(OccluderRefusal::NotSolid(NotSolid::Open { .. }))),
        "{why:?}"
    );
    assert!(!occludes(&mut app, thing));
    edit(&mut app, thing, |mesh| *mesh = Cuboid::default().into());
    assert!(occludes(&mut app, thing));
    assert_eq!(refusal(&mut app, thing), None);
}

#[test]
fn meshes_without_triangles_are_listed() {
    let mut app = occluding_app();
    let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default());
    for occluder in [Occluder::Auto, Occluder::Mesh] {
        let thing = spawn(&mut app, lines.clone(), occluder);
        let why = UnusableMesh::Topology(PrimitiveTopology::LineList);
        assert_eq!(refusal(&mut app, thing), Some(OccluderRefusal::Unusable(why)));
    }
}

#[test]
fn other_settings_find_other_boxes() {
    let mut app = occluding_app();
    let ball = spawn(&mut app, Sphere::new(1.0), Occluder::Auto);
    assert!(boxes(&mut app, ball).len() > 1);
    let inner = InnerBoxSettings {
        max_boxes: 1,
        ..default()
    };
    app.world_mut().insert_resource(OccluderSettings { inner });
    assert_eq!(boxes(&mut app, ball).len(), 1);
    let version = occluders(&app).version();
    app.world_mut().insert_resource(OccluderSettings { inner });
    app.update();
    assert_eq!(occluders(&app).version(), version, "written to, and the same");
}

// --- The version ---

#[test]
fn the_version_stands_still_while_nothing_changes_that_occludes() {
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    finish(&mut app);
    let version = occluders(&app).version();
    let (visible, hidden) = (spawn_cube(&mut app, Vec3::ONE), spawn_occluder(&mut app));
    insert(&mut app, hidden, Visibility::Hidden);
    for i in 0..3 {
        finish(&mut app);
        insert(&mut app, visible, Transform::from_xyz(i as f32, 0.0, 0.0));
        insert(&mut app, hidden, Transform::from_xyz(i as f32, 0.0, 0.0));
        // Written to, and the same.
        insert(&mut app, cube, (Transform::default(), Occluder::Auto));
    }
    finish(&mut app);
    assert_eq!(occluders(&app).version(), version);
}

#[test]
fn the_version_grows_with_what_an_occluder_does() {
    let mut app = occluding_app();
    let cube = spawn_occluder(&mut app);
    let mut version = 0;
    let mut assert_grown = |app: &mut App, what: &str| {
        finish(app);
        let new = occluders(app).version();
        assert!(new > version, "{what}");
        version = new;
    };
    assert_grown(&mut app, "comes");
    insert(&mut app, cube, Transform::from_xyz(1.0, 2.0, 3.0));
    assert_grown(&mut app, "moves");
    let place = occluders(&app).get(cube).map(|(_, place)| *place);
    assert_eq!(place, Some(Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0))));
    insert(&mut app, cube, RenderLayers::layer(3));
    assert_grown(&mut app, "is on another layer");
    assert_eq!(occluders(&app).layers(cube), Some(&RenderLayers::layer(3)));
    remove::<RenderLayers>(&mut app, cube);
    assert_grown(&mut app, "is on the first layer");
    insert(&mut app, cube, Occluder::Mesh);
    assert_grown(&mut app, "occludes otherwise");
    edit(&mut app, cube, |mesh| *mesh = Sphere::new(1.0).into());
    assert_grown(&mut app, "has other vertices");
    app.world_mut().despawn(cube);
    assert_grown(&mut app, "goes");
}

// --- Any order of anything ---

/// What occludes, by what, and where, as the world has it.
type Snapshot = Vec<(Entity, &'static str, usize, Affine3A, RenderLayers)>;

/// What the components say.
fn expected(app: &mut App) -> Snapshot {
    let world = app.world_mut();
    let mut entities = world.query::<EntityRef>();
    let meshes = world.resource::<Assets<Mesh>>();
    let mut all = Snapshot::new();
    for entity in entities.iter(world) {
        let (Some(occluder), Some(place)) = (entity.get::<Occluder>(), entity.get::<GlobalTransform>()) else {
            continue;
        };
        let is_shown = entity.get::<InheritedVisibility>().is_none_or(|shown| shown.get());
        let is_whole = entity.get::<VisibilityRange>().is_none_or(VisibilityRange::is_abrupt);
        let is_posed = entity.contains::<SkinnedMesh>();
        let triangles = |mesh: &Handle<Mesh>| meshes.get(mesh).map(|mesh| mesh.indices().map_or(0, |i| i.len() / 3));
        let own = || {
            entity
                .get::<Mesh3d>()
                .filter(|_| !is_posed)
                .and_then(|mesh| triangles(&mesh.0))
        };
        let shape = match occluder {
            // A cube; the other mesh is open.
            Occluder::Auto => own().filter(|&count| count == 12).map(|_| ("boxes", 1)),
            Occluder::Box => entity.get::<Aabb>().map(|_| ("boxes", 1)),
            Occluder::Mesh => own().map(|count| ("triangles", count)),
            Occluder::Proxy(mesh) => triangles(mesh).map(|count| ("triangles", count)),
        };
        let Some((kind, count)) = shape.filter(|_| is_shown && is_whole && place.affine().is_finite()) else {
            continue;
        };
        let layers = entity.get::<RenderLayers>().cloned().unwrap_or_default();
        all.push((entity.id(), kind, count, place.affine(), layers));
    }
    all.sort_by_key(|entry| entry.0.index());
    all
}

/// What is found.
fn found(app: &App) -> Snapshot {
    let occluders = occluders(app);
    let entry = |entity: Entity| {
        let (shape, place) = occluders.get(entity).expect("one that is listed");
        let (kind, count) = match shape {
            OccluderShape::Boxes(boxes) => ("boxes", boxes.len()),
            OccluderShape::Mesh(mesh) => ("triangles", mesh.len()),
        };
        let layers = occluders.layers(entity).expect("one that is listed").clone();
        (entity, kind, count, *place, layers)
    };
    occluders.iter().map(entry).collect()
}

fn change_something(app: &mut App, all: &mut Vec<Entity>, meshes: &[Handle<Mesh>], rng: &mut ChaCha8Rng) {
    let mesh = meshes[rng.random_range(0..meshes.len())].clone();
    let occluder = match rng.random_range(0..4) {
        0 => Occluder::Auto,
        1 => Occluder::Box,
        2 => Occluder::Mesh,
        _ => Occluder::Proxy(mesh.clone()),
    };
    let place = Transform::from_translation(random_point(rng, 5.0));
    if all.len() < 5 || rng.random_bool(0.1) {
        all.push(app.world_mut().spawn((Mesh3d(mesh), occluder, place)).id());
        return;
    }
    let number = rng.random_range(0..all.len());
    let entity = all[number];
    match rng.random_range(0..16) {
        0 => {
            app.world_mut().despawn(all.swap_remove(number));
        }
        1 => insert(app, entity, occluder),
        2 => remove::<Occluder>(app, entity),
        3 => insert(app, entity, Mesh3d(mesh)),
        4 => remove::<Mesh3d>(app, entity),
        5 => remove::<Aabb>(app, entity),
        6 => insert(app, entity, Visibility::Hidden),
        7 => insert(app, entity, Visibility::Inherited),
        8 => insert(app, entity, RenderLayers::layer(rng.random_range(0..3))),
        9 => insert(app, entity, SkinnedMesh::default()),
        10 => remove::<SkinnedMesh>(app, entity),
        11 => insert(app, entity, up_to(10.0, rng.random_range(0..2) as f32)),
        12 => remove::<VisibilityRange>(app, entity),
        13 => {
            let mut assets = app.world_mut().resource_mut::<Assets<Mesh>>();
            let edited = if rng.random_bool(0.5) {
                Cuboid::default().into()
            } else {
                open_mesh()
            };
            let _ = assets.insert(mesh.id(), edited);
        }
        14 => insert(app, entity, Transform::from_scale(Vec3::splat(f32::NAN))),
        _ => insert(app, entity, place),
    }
}

#[test]
fn occluders_are_what_the_components_say_whatever_happens() {
    for seed in 0..8 {
        let (mut app, mut rng) = (occluding_app(), rng(seed));
        let meshes = [add_mesh(&mut app, Cuboid::default()), add_mesh(&mut app, open_mesh())];
        let mut all = Vec::new();
        let (mut last, mut version) = (Snapshot::new(), 0);
        for _ in 0..80 {
            for _ in 0..rng.random_range(0..4) {
                change_something(&mut app, &mut all, &meshes, &mut rng);
            }
            finish(&mut app);
            let now = found(&app);
            assert_eq!(now, expected(&mut app), "seed {seed}");
            assert_eq!(occluders(&app).len(), now.len());
            assert!(now == last || occluders(&app).version() > version, "seed {seed}");
            (last, version) = (now, occluders(&app).version());
        }
    }
}

#[test]
fn all_meshes_occlude_if_the_game_wants_it_so() {
    let mut app = occluding_app();
    app.register_required_components::<Mesh3d, Occluder>();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    assert!(occludes(&mut app, cube));
}
