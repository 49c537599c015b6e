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
    math::bounding::{Aabb3d, BoundingSphere},
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use bevy_sightline::prelude::*;

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
        scene.overlap(&Aabb3d::new(middle, Vec3::splat(9.0)), &settings, &mut entities);
        scene.overlap(&BoundingSphere::new(middle, 9.0), &settings, &mut entities);
        let nearest = scene.nearest(middle, &settings);
        scene.k_nearest(middle, 16, &settings, &mut near);
        scene.neighbours_within(middle, 9.0, &settings, &mut near);
        let ball = scene.sweep_sphere(ray, 0.5, &settings);
        let slab = scene.sweep_aabb(ray, Vec3::ONE, &settings);
        scene.pairs(&settings, &mut pairs);
        assert!(hit.is_some() && !sees && nearest.is_some() && ball.is_some() && slab.is_some());
        found = hits.len().min(entities.len()).min(near.len()).min(many.len());
    };
    ask();
    assert_eq!(allocations(ask), 0);
    assert!(found > 5);
}
