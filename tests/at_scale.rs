//! Many entities: on several threads, and without allocations once warm.
//!
//! In a binary of its own, for an allocator and the number of threads are up to the whole program.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use bevy::{
    camera::primitives::Aabb,
    ecs::{
        schedule::SingleThreadedExecutor,
        system::{RunSystemOnce, SystemState},
    },
    math::bounding::{Aabb3d, BoundingSphere, BoundingVolume},
    mesh::{
        MeshPlugin, VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use bevy_sightline::{
    index::{MeshBvhs, PosedMeshes, SyncStats},
    prelude::*,
};

/// Counts what each thread allocates while it is counting.
struct Counting;

thread_local! {
    static COUNT: Cell<Option<usize>> = const { Cell::new(None) };
}

fn count() {
    // Threads allocate while they end, too.
    _ = COUNT.try_with(|count| count.set(count.get().map(|count| count + 1)));
}

#[expect(unsafe_code, reason = "an allocator is unsafe to write")]
// SAFETY: everything is left to the allocator of the system.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often this thread allocates in `work`.
fn allocations(work: impl FnOnce()) -> usize {
    COUNT.set(Some(0));
    work();
    COUNT.take().expect("it was set")
}

/// How often the systems of the index have allocated in the last frame.
#[derive(Resource, Default)]
struct Allocated(usize);

/// One of so many entities moves.
#[derive(Component)]
struct Mover(f32);

/// An app with `n` boxes in a cube, which have a surface, of which one in `one_in` swings to and fro.
fn app_with_boxes(n: usize, one_in: usize) -> App {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SpatialIndexPlugin))
        .init_resource::<Allocated>()
        .add_systems(Update, swing);
    app.finish();
    let side = (n as f32).cbrt().ceil() as usize;
    for i in 0..n {
        let place = UVec3::new((i % side) as u32, (i / side % side) as u32, (i / side / side) as u32);
        let mut entity = app.world_mut().spawn((
            Transform::from_translation(place.as_vec3() * 3.0),
            Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE),
            PickShape::new(bevy::math::primitives::Sphere::new(1.0)),
        ));
        if i % one_in == 0 {
            entity.insert(Mover(i as f32));
        }
    }
    app
}

fn swing(mut frame: Local<u32>, mut movers: Query<(&Mover, &mut Transform)>) {
    *frame += 1;
    let step = if *frame % 8 < 4 { 0.4 } else { -0.4 };
    for (mover, mut transform) in &mut movers {
        transform.translation += Vec3::new(mover.0.sin(), mover.0.cos(), 0.5) * step;
    }
}

fn assert_agrees(app: &mut App) {
    let mut boxes = app.world_mut().query::<(Entity, &GlobalTransform)>();
    let index = app.world().resource::<SpatialIndex>();
    index.validate().expect("a whole index");
    for (entity, place) in boxes.iter(app.world()) {
        let aabb = index.aabb(entity).expect("it is in the index");
        let center = (aabb.min + aabb.max) / 2.0;
        assert!(center.abs_diff_eq(place.translation_vec3a(), 1e-3), "{entity}");
    }
}

#[test]
fn what_moves_is_followed_on_several_threads() {
    let mut app = app_with_boxes(50_000, 3);
    app.update();
    assert_agrees(&mut app);
    for _ in 0..5 {
        app.update();
        assert_agrees(&mut app);
    }
    let found = app
        .world_mut()
        .run_system_once(|scene: SceneQuery, movers: Query<&GlobalTransform, With<Mover>>| {
            let settings = SceneQuerySettings::default();
            let rays: Vec<Ray3d> = movers
                .iter()
                .map(|place| Ray3d::new(place.translation() + Vec3::X * 1.2, Dir3::NEG_X))
                .collect();
            let mut hits = Vec::new();
            scene.cast_rays(&rays, &settings, &mut hits);
            let one_by_one = rays.iter().map(|&ray| scene.cast_ray(ray, &settings));
            assert!(
                one_by_one.eq(hits.iter().copied()),
                "many rays hit what they hit one by one"
            );
            hits.iter().flatten().count()
        });
    assert!(found.expect("the system runs") > 10_000);
}

#[test]
fn nothing_is_allocated_per_frame_once_warm() {
    let mut app = app_with_boxes(10_000, 100);
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app.add_systems(
        PostUpdate,
        (
            (|| COUNT.set(Some(0)))
                .after(TransformSystems::Propagate)
                .before(SpatialIndexSystems::Sync),
            (|mut allocated: ResMut<Allocated>| allocated.0 = COUNT.take().expect("it was set"))
                .after(SpatialIndexSystems::Optimize),
        ),
    );
    app.update();
    assert!(
        app.world().resource::<Allocated>().0 > 0,
        "the first frame builds the index"
    );
    for _ in 0..32 {
        app.update();
    }
    for _ in 0..32 {
        app.update();
        assert_eq!(app.world().resource::<Allocated>().0, 0);
    }
    assert_agrees(&mut app);
}

#[test]
fn nothing_is_allocated_per_query_once_warm() {
    let mut app = app_with_boxes(10_000, 100);
    app.update();
    let mut state = SystemState::<SceneQuery>::new(app.world_mut());
    let scene = state.get(app.world()).expect("the plugin is there");
    let settings = SceneQuerySettings::default();
    let (mut entities, mut near, mut pairs, mut hits, mut many) = (vec![], vec![], vec![], vec![], vec![]);
    let middle = Vec3::splat(30.0);
    let ray = Ray3d::new(Vec3::new(-5.0, 30.2, 30.3), Dir3::X);
    let mut found = 0;
    let mut ask = || {
        let hit = scene.cast_ray(ray, &settings);
        scene.cast_ray_all(ray, &settings, &mut hits);
        scene.cast_rays(&[ray; 8], &settings, &mut many);
        let sees = scene.line_of_sight(ray.origin, middle, &settings) || !scene.any_hit(ray, &settings);
        let seen = hit.and_then(|hit| scene.visible_fraction_from(ray.origin, hit.entity, 16, &settings));
        scene.overlap(&Aabb3d::new(middle, Vec3::splat(9.0)), &settings, &mut entities);
        scene.overlap(&BoundingSphere::new(middle, 9.0), &settings, &mut entities);
        let nearest = scene.nearest(middle, &settings);
        scene.k_nearest(middle, 16, &settings, &mut near);
        scene.neighbours_within(middle, 9.0, &settings, &mut near);
        let ball = scene.sweep_sphere(ray, 0.5, &settings);
        let slab = scene.sweep_aabb(ray, Vec3::ONE, &settings);
        scene.pairs(&settings, &mut pairs);
        assert!(hit.is_some() && !sees && seen > Some(0.0) && nearest.is_some() && ball.is_some() && slab.is_some());
        found = hits.len().min(entities.len()).min(near.len()).min(many.len());
    };
    ask();
    assert_eq!(allocations(ask), 0);
    assert!(found > 5);
}

/// One of so many joints, which sway.
#[derive(Component)]
struct Joint(f32);

/// An app with `n` skinned spheres of so many joints, four apart along the x axis.
fn app_with_skins(n: usize, joints: u16) -> App {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        TransformPlugin,
        bevy::image::ImagePlugin::default(),
        MeshPlugin,
        SpatialIndexPlugin,
    ))
    .init_resource::<Allocated>()
    .add_systems(Update, sway);
    app.finish();
    let mesh = bevy::math::primitives::Sphere::new(1.0).mesh().uv(64, 40);
    let vertices = mesh.count_vertices();
    let joint = |vertex: usize| (vertex * usize::from(joints) / vertices) as u16;
    let indices = (0..vertices).map(|vertex| [joint(vertex), (joint(vertex) + 1) % joints, 0, 0]);
    let mesh = mesh
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            VertexAttributeValues::Uint16x4(indices.collect()),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[0.75, 0.25, 0.0, 0.0]; vertices]);
    let world = app.world_mut();
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let bind_poses = vec![Mat4::IDENTITY; joints.into()];
    let inverse_bindposes = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(bind_poses);
    for i in 0..n {
        let place = Transform::from_xyz(4.0 * i as f32, 0.0, 0.0);
        let joints = (0..joints).map(|joint| world.spawn((place, Joint(f32::from(joint)))).id());
        let skin = SkinnedMesh {
            joints: joints.collect(),
            inverse_bindposes: inverse_bindposes.clone(),
        };
        world.spawn((Mesh3d(mesh.clone()), skin, Transform::default()));
    }
    app.update();
    while app.world().resource::<MeshBvhs>().building() > 0 {
        app.update();
    }
    app
}

fn sway(mut frame: Local<u32>, mut joints: Query<(&Joint, &mut Transform)>) {
    *frame += 1;
    for (joint, mut transform) in &mut joints {
        transform.translation.y = 0.2 * (0.3 * *frame as f32 + joint.0).sin();
    }
}

#[test]
fn skinned_meshes_are_followed_and_hit_without_allocations_once_warm() {
    let mut app = app_with_skins(20, 6);
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app.add_systems(
        PostUpdate,
        (
            (|| COUNT.set(Some(0)))
                .after(TransformSystems::Propagate)
                .before(SpatialIndexSystems::Sync),
            (|scene: SceneQuery| {
                let ray = Ray3d::new(Vec3::new(8.0, 9.0, 0.1), Dir3::NEG_Y);
                assert!(scene.cast_ray(ray, &SceneQuerySettings::default()).is_some());
            })
            .after(SpatialIndexSystems::Optimize),
            (|mut allocated: ResMut<Allocated>| allocated.0 = COUNT.take().expect("it was set"))
                .after(SpatialIndexSystems::Optimize),
        )
            .chain(),
    );
    for _ in 0..32 {
        app.update();
    }
    let before = app.world().resource::<PosedMeshes>().stats().meshes;
    for _ in 0..32 {
        app.update();
        assert_eq!(app.world().resource::<SyncStats>().posed, 20);
        assert_eq!(app.world().resource::<Allocated>().0, 0);
    }
    let posed = app.world().resource::<PosedMeshes>().stats().meshes - before;
    assert_eq!(posed, 32, "one in each frame");
}

#[test]
fn poses_are_followed_on_several_threads() {
    let mut app = app_with_skins(1000, 4);
    let mut skins = app.world_mut().query_filtered::<Entity, With<SkinnedMesh>>();
    let skins: Vec<Entity> = skins.iter(app.world()).collect();
    let mut last_top = f32::NAN;
    for _ in 0..3 {
        app.update();
        assert_eq!(app.world().resource::<SyncStats>().posed, 1000);
        let index = app.world().resource::<SpatialIndex>();
        index.validate().expect("a whole index");
        // All sway alike, side by side.
        let first = index.aabb(skins[0]).expect("an indexed skin");
        assert_ne!(first.max.y, last_top);
        last_top = first.max.y;
        for (i, &skin) in skins.iter().enumerate() {
            let aabb = index.aabb(skin).expect("an indexed skin");
            assert_eq!((aabb.min.y, aabb.max.y), (first.min.y, first.max.y));
            assert!((aabb.center().x - 4.0 * i as f32).abs() < 0.1);
        }
    }
}

/// An app with so many groups of three levels on a plane, 3 m apart, and a camera above them.
fn app_with_groups(n: usize) -> (App, Entity) {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, ProxyLodPlugin))
        .init_resource::<Allocated>();
    app.finish();
    let side = (n as f32).sqrt().ceil() as usize;
    for i in 0..n {
        let place = Vec3::new((i % side) as f32, 0.0, (i / side) as f32) * 3.0;
        let root = app.world_mut().spawn(Transform::from_translation(place)).id();
        let around = Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE);
        let levels = [(); 3].map(|()| {
            app.world_mut()
                .spawn((Transform::default(), around, ChildOf(root)))
                .id()
        });
        let lod = ProxyLod::new(LodMetric::Height, levels[0])
            .then(0.2, levels[1])
            .then(0.05, levels[2]);
        app.world_mut().entity_mut(root).insert(lod);
    }
    let camera = app
        .world_mut()
        .spawn((Camera3d::default(), Transform::from_xyz(0.0, 4.0, 0.0)));
    let camera = camera.id();
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app.add_systems(
        PostUpdate,
        (
            (|| COUNT.set(Some(0)))
                .after(TransformSystems::Propagate)
                .before(LodSystems::Follow),
            (|mut allocated: ResMut<Allocated>| allocated.0 = COUNT.take().expect("it was set"))
                .after(LodSystems::Choose),
        ),
    );
    (app, camera)
}

#[test]
fn levels_are_chosen_without_allocations_once_warm() {
    let (mut app, camera) = app_with_groups(1000);
    let levels = |app: &mut App| -> usize {
        let mut roots = app.world_mut().query_filtered::<Entity, With<ProxyLod>>();
        let choices = app.world().resource::<LodChoices>();
        let level = |root| choices.level(root, camera).expect("a group and a camera");
        roots.iter(app.world()).map(level).sum()
    };
    let step = |app: &mut App, at: f32| {
        let mut place = app.world_mut().get_mut::<Transform>(camera).expect("a camera");
        place.translation.x = at;
        app.update();
    };
    // To and fro, twice.
    let way = || (0..80).chain((0..80).rev()).map(|at| at as f32);
    way().for_each(|at| step(&mut app, at));
    let first = levels(&mut app);
    let mut has_switched = false;
    for at in way() {
        step(&mut app, at);
        assert_eq!(app.world().resource::<Allocated>().0, 0, "at {at}");
        has_switched |= levels(&mut app) != first;
    }
    assert!(has_switched);
    for _ in 0..32 {
        app.update();
        assert_eq!(app.world().resource::<Allocated>().0, 0);
    }
}
