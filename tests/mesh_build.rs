//! Building the hierarchy of a mesh: every way gives the same answers, progress is told, and builds can be called off.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use bevy::{
    asset::RenderAssetUsages,
    math::{Vec3, Vec3A},
    mesh::{Mesh, PrimitiveTopology},
    tasks::{AsyncComputeTaskPool, ComputeTaskPool, TaskPoolBuilder},
};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBuildSettings, MeshBvh, TriangleMesh},
    spatial::{BuildProgress, BuildStrategy},
};
use rand::Rng;

use crate::common::rng;

const STRATEGIES: [BuildStrategy; 5] = [
    BuildStrategy::MiddleSplit,
    BuildStrategy::MedianSplit,
    BuildStrategy::BinnedSah,
    BuildStrategy::Ploc,
    BuildStrategy::Reinsertion,
];

fn mesh(corners: impl IntoIterator<Item = [Vec3; 3]>) -> TriangleMesh {
    let positions: Vec<Vec3> = corners.into_iter().flatten().collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    TriangleMesh::from_mesh(&mesh).expect("a mesh with triangles")
}

/// Small triangles in a cube of side 100.
fn soup(count: usize) -> Vec<[Vec3; 3]> {
    let mut rng = rng(1);
    let mut point = |size: f32| Vec3::new(rng.random(), rng.random(), rng.random()) * size;
    (0..count)
        .map(|_| {
            let center = point(100.0);
            [center + point(5.0), center + point(5.0), center + point(5.0)]
        })
        .collect()
}

fn settings(strategy: BuildStrategy) -> MeshBuildSettings {
    MeshBuildSettings {
        strategy,
        ..MeshBuildSettings::default()
    }
}

fn build(mesh: &TriangleMesh, strategy: BuildStrategy) -> MeshBvh {
    MeshBvh::build_with(mesh, &settings(strategy), None).expect("nothing calls it off")
}

fn rays(count: usize) -> impl Iterator<Item = Ray> {
    let mut rng = rng(2);
    (0..count).filter_map(move |_| {
        let mut point = || Vec3A::new(rng.random(), rng.random(), rng.random()) * 120.0 - 10.0;
        let (origin, target) = (point(), point());
        Ray::new(origin, target - origin, f32::INFINITY)
    })
}

#[test]
fn every_strategy_gives_the_answers_of_the_mesh() {
    let all_one = vec![[Vec3::ZERO, Vec3::X * 90.0, Vec3::splat(80.0)]; 1000];
    let in_line = (0..1000)
        .map(|i| [0.0, 1.0, 3.0].map(|x| Vec3::X * (x + i as f32)))
        .collect();
    let mut with_a_huge_one = soup(500);
    with_a_huge_one.push([Vec3::splat(-1e6), Vec3::new(1e6, -1e6, 0.0), Vec3::new(0.0, 1e6, 1e6)]);
    let flat = soup(500)
        .into_iter()
        .map(|corners| corners.map(|corner| corner.with_y(40.0)))
        .collect();
    for corners in [soup(1), soup(9), soup(1000), all_one, in_line, with_a_huge_one, flat] {
        let mesh = mesh(corners);
        for strategy in STRATEGIES {
            let bvh = build(&mesh, strategy);
            for ray in rays(100) {
                let (hit, expected) = (
                    bvh.closest_hit(&ray, Backfaces::Include),
                    mesh.closest_hit(&ray, Backfaces::Include),
                );
                let seen = |hit: Option<bevy_sightline::mesh::TriangleHit>| hit.map(|hit| (hit.t, hit.triangle));
                assert_eq!(seen(hit), seen(expected), "{strategy:?}");
            }
        }
    }
}

#[test]
fn many_triangles_in_one_place_are_built_soon() {
    let mesh = mesh(vec![[Vec3::ZERO, Vec3::X, Vec3::Y]; 100_000]);
    for strategy in STRATEGIES {
        let bvh = build(&mesh, strategy);
        let ray = Ray::new(Vec3A::new(0.2, 0.2, 1.0), Vec3A::NEG_Z, f32::INFINITY).expect("a ray");
        assert!(bvh.any_hit(&ray, Backfaces::Include));
    }
}

#[test]
fn nodes_that_were_moved_cost_less() {
    let mesh = mesh(soup(5000));
    let cost = |strategy| build(&mesh, strategy).sah_cost();
    assert!(cost(BuildStrategy::Reinsertion) < cost(BuildStrategy::BinnedSah));
    assert!(cost(BuildStrategy::Reinsertion) < cost(BuildStrategy::Ploc));
}

#[test]
fn a_build_that_is_called_off_gives_nothing() {
    let mesh = mesh(soup(1000));
    for strategy in STRATEGIES {
        let progress = BuildProgress::default();
        progress.cancel();
        assert!(MeshBvh::build_with(&mesh, &settings(strategy), Some(&progress)).is_none());
        assert!(progress.is_cancelled() && progress.fraction() < 1.0);
    }
}

#[test]
fn progress_only_grows_and_ends_at_one() {
    let mesh = mesh(soup(40_000));
    for strategy in STRATEGIES {
        let progress = BuildProgress::default();
        assert_eq!(progress.fraction(), 0.0);
        let done = AtomicBool::new(false);
        let seen = std::thread::scope(|scope| {
            let watcher = scope.spawn(|| {
                let mut seen = vec![progress.fraction()];
                while !done.load(Ordering::Acquire) {
                    seen.push(progress.fraction());
                    std::thread::yield_now();
                }
                seen
            });
            let bvh = MeshBvh::build_with(&mesh, &settings(strategy), Some(&progress));
            done.store(true, Ordering::Release);
            assert!(bvh.is_some());
            watcher.join().expect("nothing panics")
        });
        assert!(seen.is_sorted(), "{strategy:?}");
        assert_eq!(progress.fraction(), 1.0, "{strategy:?}");
    }
}

#[test]
fn a_task_of_another_pool_builds_with_the_compute_pool() {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(1).build());
    let pool = AsyncComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(1).build());
    let mesh = Arc::new(mesh(soup(40_000)));
    let tasks: Vec<_> = STRATEGIES
        .map(|strategy| {
            let mesh = mesh.clone();
            pool.spawn(async move { build(&mesh, strategy) })
        })
        .into();
    for task in tasks {
        let bvh = bevy::tasks::block_on(task);
        for ray in rays(5) {
            let (hit, expected) = (
                bvh.closest_hit(&ray, Backfaces::Include),
                mesh.closest_hit(&ray, Backfaces::Include),
            );
            assert_eq!(hit.map(|hit| hit.triangle), expected.map(|hit| hit.triangle));
        }
    }
}
