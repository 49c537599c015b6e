//! The life of the hierarchies of meshes: edits, memory, what is dropped and what comes back.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};
use bevy_sightline::{
    geometry::{
        ray::{Ray, triangle::Backfaces},
        tolerance,
    },
    index::{MeshBvhs, MeshSettings, MeshStatus},
    mesh::TriangleMesh,
    prelude::*,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

/// For how many frames what is not used is kept.
const GRACE: usize = 60;

/// An app with one entity at the origin.
struct World {
    app: App,
    mesh: Handle<Mesh>,
    entity: Entity,
}

impl World {
    /// All built.
    fn new(mesh: Mesh) -> Self {
        let mut world = Self::unbuilt(mesh);
        finish_meshes(&mut world.app);
        world
    }

    /// In the frame in which the mesh begins to be built.
    fn unbuilt(mesh: Mesh) -> Self {
        let mut app = headless_app();
        let mesh = add_mesh(&mut app, mesh);
        let entity = app.world_mut().spawn(Mesh3d(mesh.clone())).id();
        app.update();
        Self { app, mesh, entity }
    }

    fn bvhs(&self) -> &MeshBvhs {
        self.app.world().resource()
    }

    fn status(&self) -> Option<MeshStatus> {
        self.bvhs().status(&self.mesh)
    }

    /// Edits the asset, and runs the frame that takes notice.
    fn edit(&mut self, edit: impl FnOnce(&mut Mesh)) {
        let mut meshes = self.app.world_mut().resource_mut::<Assets<Mesh>>();
        edit(&mut meshes.get_mut(&self.mesh).expect("a loaded mesh"));
        self.app.update();
    }

    fn frames(&mut self, count: usize) {
        (0..count).for_each(|_| self.app.update());
    }

    fn set(&mut self, settings: MeshSettings) {
        self.app.world_mut().resource_mut::<SpatialIndexSettings>().meshes = settings;
    }

    /// Rays hit what the asset is now, triangle for triangle.
    fn assert_exact(&mut self, seed: u64) {
        let asset = self.app.world().resource::<Assets<Mesh>>().get(&self.mesh).cloned();
        let oracle = asset.and_then(|mesh| TriangleMesh::from_mesh(&mesh).ok());
        let mut rng = rng(seed);
        let mut hits = 0;
        for _ in 0..40 {
            let ray = ray_towards(*random_dir(&mut rng) * 6.0, random_point(&mut rng, 0.7));
            let expected = oracle.as_ref().and_then(|oracle| {
                let ray = Ray::from_ray3d(ray, f32::INFINITY).expect("a finite ray");
                oracle.closest_hit(&ray, Backfaces::Cull)
            });
            let hit = cast(&mut self.app, ray);
            let triangle = |hit: RayHit| hit.triangle.expect("a mesh is hit").index;
            assert_eq!(hit.map(triangle), expected.map(|hit| hit.triangle), "{ray:?}");
            let distance = |t: f32| t * (1.0 + 8.0 * tolerance::SLAB);
            if let (Some(hit), Some(expected)) = (hit, expected) {
                assert!(hit.distance <= distance(expected.t) && expected.t <= distance(hit.distance));
                hits += 1;
            }
        }
        assert!(
            oracle.is_none_or(|oracle| oracle.left_out() > 0) || hits > 5,
            "{hits} hits"
        );
    }
}

fn ball() -> Mesh {
    Sphere::new(1.0).mesh().ico(8).expect("few faces")
}

/// The positions of a mesh, each replaced.
fn move_vertices(mesh: &mut Mesh, mut place: impl FnMut(Vec3) -> Vec3) {
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) else {
        panic!("a mesh with positions");
    };
    for position in positions {
        *position = place(Vec3::from(*position)).into();
    }
}

/// Moves every vertex somewhere else, so that no box of the hierarchy is any good.
fn scatter(mesh: &mut Mesh, rng: &mut ChaCha8Rng) {
    move_vertices(mesh, |_| random_point(rng, 1.0));
}

// --- Edits ---

#[test]
fn a_mesh_whose_vertices_move_keeps_its_hierarchy_and_is_hit_where_it_is_at_once() {
    let mut world = World::new(ball());
    for i in 0..5 {
        world.edit(|mesh| move_vertices(mesh, |v| v * Vec3::new(1.0, 1.05, 0.95) + Vec3::splat(0.01)));
        assert_eq!(
            (world.status(), world.bvhs().progress(&world.mesh)),
            (Some(MeshStatus::Ready), None)
        );
        world.assert_exact(i);
    }
}

#[test]
fn a_mesh_with_other_triangles_is_built_anew_and_hit_as_it_is_meanwhile() {
    let mut world = World::new(ball());
    world.edit(|mesh| *mesh = Torus::new(0.3, 1.0).into());
    assert_eq!(world.status(), Some(MeshStatus::Building));
    world.assert_exact(10);
    finish_meshes(&mut world.app);
    assert_eq!(world.status(), Some(MeshStatus::Ready));
    world.assert_exact(11);
}

#[test]
fn triangles_of_the_same_number_between_other_vertices_are_built_anew() {
    let mut world = World::new(ball());
    world.edit(|mesh| {
        let indices: Vec<u32> = mesh.indices().expect("a list").iter().map(|i| i as u32).collect();
        let turned = indices
            .chunks(3)
            .flat_map(|triangle| [triangle[1], triangle[0], triangle[2]]);
        mesh.insert_indices(Indices::U32(turned.collect()));
    });
    assert_eq!(world.status(), Some(MeshStatus::Building));
    world.assert_exact(12);
}

#[test]
fn new_normals_are_reported_and_cost_no_hierarchy() {
    let mut world = World::new(Cuboid::default().into());
    world.edit(|mesh| {
        let normals = vec![Vec3::X; mesh.count_vertices()];
        mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
        mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0);
    });
    assert_eq!((world.status(), world.bvhs().building()), (Some(MeshStatus::Ready), 0));
    let hit = hit_at(&mut world.app, Vec3::ZERO).expect("a hit");
    assert_eq!((hit.normal, hit.uv), (Vec3::X, None));
}

#[test]
fn a_hierarchy_that_has_worn_is_built_anew_beside_its_use() {
    let mut world = World::new(ball());
    let mut rng = rng(20);
    world.edit(|mesh| scatter(mesh, &mut rng));
    assert_eq!(world.status(), Some(MeshStatus::Ready), "the old one serves");
    assert!(
        world.bvhs().progress(&world.mesh).is_some(),
        "the new one is on its way"
    );
    world.assert_exact(21);
    finish_meshes(&mut world.app);
    assert_eq!(world.bvhs().progress(&world.mesh), None);
    world.assert_exact(22);
}

#[test]
fn vertices_that_move_while_a_hierarchy_is_built_anew_are_hit_where_they_are() {
    let mut world = World::new(ball());
    let mut rng = rng(23);
    world.edit(|mesh| scatter(mesh, &mut rng));
    world.edit(|mesh| move_vertices(mesh, |v| v * 0.8));
    world.assert_exact(24);
    finish_meshes(&mut world.app);
    world.assert_exact(25);
}

#[test]
fn how_far_a_hierarchy_may_wear_is_a_setting() {
    let mut world = World::new(ball());
    world.set(MeshSettings {
        rebuild_factor: f32::INFINITY,
        ..default()
    });
    let mut rng = rng(26);
    world.edit(|mesh| scatter(mesh, &mut rng));
    assert_eq!(world.bvhs().progress(&world.mesh), None);
    world.assert_exact(27);
}

#[test]
fn a_mesh_that_is_edited_every_frame_gets_its_hierarchy_by_one_task_at_a_time() {
    let mut world = World::unbuilt(ball());
    let mut frames = 0;
    while world.status() != Some(MeshStatus::Ready) {
        world.edit(|mesh| move_vertices(mesh, |v| v + Vec3::X * 1e-4));
        assert!(world.bvhs().building() <= 1);
        world.assert_exact(frames);
        frames += 1;
    }
    // And keeps it up, however badly the vertices are thrown about.
    let mut rng = rng(30);
    for frame in 0..10 {
        world.edit(|mesh| scatter(mesh, &mut rng));
        assert_eq!(world.status(), Some(MeshStatus::Ready));
        world.assert_exact(frame);
    }
}

#[test]
fn a_vertex_that_becomes_nan_takes_its_triangles_out_until_it_is_good_again() {
    let mut world = World::new(ball());
    let good = world
        .app
        .world()
        .resource::<Assets<Mesh>>()
        .get(&world.mesh)
        .expect("a mesh")
        .clone();
    world.edit(|mesh| {
        let mut first = true;
        move_vertices(mesh, |v| if std::mem::take(&mut first) { Vec3::NAN } else { v });
    });
    assert!(world.bvhs().triangles(&world.mesh).expect("a mesh").left_out() > 0);
    world.assert_exact(40);
    finish_meshes(&mut world.app);
    world.assert_exact(41);
    world.edit(|mesh| *mesh = good);
    assert_eq!(world.bvhs().triangles(&world.mesh).map(TriangleMesh::left_out), Some(0));
    finish_meshes(&mut world.app);
    world.assert_exact(42);
}

#[test]
fn a_strip_with_gaps_in_its_numbers_follows_its_vertices() {
    let positions: Vec<Vec3> = (0..12)
        .map(|i| Vec3::new(i as f32 / 12.0 - 0.5, (i % 2) as f32, 0.0))
        .collect();
    let restart = u32::MAX;
    let indices = vec![0, 1, 2, 3, restart, 4, 5, 6, 7, 99, 8, 9, 10, 11];
    let strip = Mesh::new(PrimitiveTopology::TriangleStrip, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices));
    let mut world = World::new(strip);
    world.edit(|mesh| move_vertices(mesh, |v| v + Vec3::Z * 0.25));
    assert_eq!(world.status(), Some(MeshStatus::Ready));
    world.assert_exact(43);
}

#[test]
fn whatever_becomes_of_a_mesh_rays_hit_it_as_it_is() {
    for seed in 0..3 {
        let mut rng = rng(50 + seed);
        let mut world = World::unbuilt(ball());
        world.set(MeshSettings {
            memory_budget: Some(rng.random_range(0..2) * 1_000_000),
            ..default()
        });
        for step in 0..25 {
            let is_there = world.app.world().resource::<Assets<Mesh>>().contains(&world.mesh);
            match rng.random_range(0..9) {
                0 | 1 if is_there => world.edit(|mesh| scatter(mesh, &mut rng)),
                2 | 3 if is_there => world.edit(|mesh| move_vertices(mesh, |v| v * 0.99)),
                4 if is_there => world.edit(|mesh| {
                    mesh.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
                }),
                5 => {
                    let mesh = if rng.random() { ball() } else { Cuboid::default().into() };
                    let mut meshes = world.app.world_mut().resource_mut::<Assets<Mesh>>();
                    meshes.insert(&world.mesh, mesh).expect("a live id");
                    world.frames(1);
                }
                6 => {
                    world.app.world_mut().resource_mut::<Assets<Mesh>>().remove(&world.mesh);
                    world.frames(1);
                }
                7 => world.frames(GRACE + 1),
                _ => finish_meshes(&mut world.app),
            }
            world.assert_exact(step);
        }
    }
}

// --- Progress, and what is called off ---

#[test]
fn progress_is_told_while_a_hierarchy_is_built() {
    let mut world = World::unbuilt(ball());
    let progress = world.bvhs().progress(&world.mesh);
    assert!(
        progress.is_some_and(|progress| (0.0..=1.0).contains(&progress)),
        "{progress:?}"
    );
    finish_meshes(&mut world.app);
    assert_eq!(world.bvhs().progress(&world.mesh), None);
    assert_eq!(
        world.bvhs().progress(AssetId::<Mesh>::invalid()),
        None,
        "nobody uses it"
    );
}

#[test]
fn what_is_being_built_is_called_off_with_its_asset_and_begun_again_with_it() {
    let mut world = World::unbuilt(ball());
    world.app.world_mut().resource_mut::<Assets<Mesh>>().remove(&world.mesh);
    world.frames(1);
    let told = (
        world.status(),
        world.bvhs().building(),
        world.bvhs().progress(&world.mesh),
    );
    assert_eq!(told, (Some(MeshStatus::Missing), 0, None));
    world.assert_exact(60);
    let mut meshes = world.app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(&world.mesh, Cuboid::default().into()).expect("a live id");
    settle(&mut world.app);
    assert_eq!(world.status(), Some(MeshStatus::Ready));
    world.assert_exact(61);
}

// --- Instances and memory ---

#[test]
fn a_thousand_instances_share_one_hierarchy() {
    let mut world = World::new(ball());
    let alone = world.bvhs().memory();
    for i in 0..1000 {
        let place = Transform::from_xyz(10.0 + 3.0 * i as f32, 0.0, 0.0);
        world.app.world_mut().spawn((Mesh3d(world.mesh.clone()), place));
    }
    world.frames(1);
    assert_eq!((world.bvhs().building(), world.bvhs().memory()), (0, alone));
    assert!(hit_at(&mut world.app, Vec3::X * 3007.0).is_some());
}

#[test]
fn memory_is_counted_by_asset_and_in_all() {
    let mut world = World::new(ball());
    let other = add_mesh(&mut world.app, Torus::default());
    world.app.world_mut().spawn(Mesh3d(other.clone()));
    settle(&mut world.app);
    let bvhs = world.bvhs();
    let each = [&world.mesh, &other].map(|mesh| bvhs.memory_of(mesh).expect("a mesh in use"));
    assert!(each.iter().all(|&bytes| bytes > 10_000), "{each:?}");
    assert_eq!(bvhs.memory(), each[0] + each[1]);
    assert_eq!(bvhs.memory_of(AssetId::<Mesh>::invalid()), None, "nobody uses it");
}

#[test]
fn short_of_memory_a_hierarchy_goes_that_no_ray_comes_near_and_returns_with_a_ray() {
    let mut world = World::new(ball());
    let whole = world.bvhs().memory();
    world.set(MeshSettings {
        memory_budget: Some(0),
        ..default()
    });
    world.frames(GRACE + 1);
    assert_eq!(world.status(), Some(MeshStatus::Dormant));
    assert!(world.bvhs().memory() < whole, "its triangles stay");
    world.frames(3);
    assert_eq!(
        (world.status(), world.bvhs().building()),
        (Some(MeshStatus::Dormant), 0),
        "nobody has asked"
    );

    world.assert_exact(70);
    world.frames(1);
    assert_eq!(world.status(), Some(MeshStatus::Building));
    world.assert_exact(71);
    finish_meshes(&mut world.app);
    assert_eq!(
        (world.status(), world.bvhs().memory()),
        (Some(MeshStatus::Ready), whole),
        "rays come near"
    );
    world.assert_exact(72);
}

#[test]
fn what_rays_come_near_stays_however_short_memory_is() {
    let mut world = World::new(ball());
    world.set(MeshSettings {
        memory_budget: Some(0),
        ..default()
    });
    for _ in 0..3 {
        world.frames(GRACE - 1);
        assert!(hit_at(&mut world.app, Vec3::ZERO).is_some());
        assert_eq!(world.status(), Some(MeshStatus::Ready));
    }
}

#[test]
fn the_hierarchy_goes_first_that_no_ray_came_near_for_longest() {
    let mut world = World::new(ball());
    let late = add_mesh(&mut world.app, ball());
    let place = Transform::from_xyz(10.0, 0.0, 0.0);
    world.app.world_mut().spawn((Mesh3d(late.clone()), place));
    settle(&mut world.app);
    world.frames(GRACE);
    assert!(hit_at(&mut world.app, Vec3::X * 10.0).is_some());
    world.frames(GRACE + 1);
    world.set(MeshSettings {
        memory_budget: Some(world.bvhs().memory() - 1),
        ..default()
    });
    world.frames(1);
    let late = world.bvhs().status(&late);
    assert_eq!(
        (world.status(), late),
        (Some(MeshStatus::Dormant), Some(MeshStatus::Ready))
    );
}

#[test]
fn a_hierarchy_that_returns_is_as_compact_as_is_wanted_by_then() {
    let mut world = World::new(ball());
    let whole = world.bvhs().memory();
    world.set(MeshSettings {
        memory_budget: Some(0),
        compact: true,
        ..default()
    });
    world.frames(GRACE + 1);
    assert_eq!(world.status(), Some(MeshStatus::Dormant));
    world.assert_exact(74);
    world.frames(1);
    finish_meshes(&mut world.app);
    assert_eq!(world.status(), Some(MeshStatus::Ready));
    let compact = world.bvhs().memory();
    assert!(compact < whole * 6 / 10, "{compact} of {whole}");
    world.assert_exact(75);
}

#[test]
fn a_mesh_that_comes_later_is_held_to_the_budget_too() {
    let mut world = World::new(ball());
    world.set(MeshSettings {
        memory_budget: Some(world.bvhs().memory()),
        ..default()
    });
    world.frames(GRACE);
    let late = add_mesh(&mut world.app, ball());
    world.app.world_mut().spawn(Mesh3d(late.clone()));
    world.frames(2);
    assert_eq!(
        world.status(),
        Some(MeshStatus::Dormant),
        "the triangles of the other are too much"
    );
    finish_meshes(&mut world.app);
    assert_eq!(world.bvhs().status(&late), Some(MeshStatus::Ready));
    world.frames(GRACE + 1);
    assert_eq!(world.bvhs().status(&late), Some(MeshStatus::Dormant));
}

#[derive(Resource, Default)]
struct Told(usize);

#[test]
fn nobody_is_told_of_a_change_where_there_is_none() {
    let mut world = World::new(ball());
    let count = |mut told: ResMut<Told>| told.0 += 1;
    world
        .app
        .init_resource::<Told>()
        .add_systems(Last, count.run_if(resource_changed::<MeshBvhs>));
    world.frames(1);
    let before = world.app.world().resource::<Told>().0;
    world.frames(3);
    assert_eq!(world.app.world().resource::<Told>().0, before);
    world.edit(|mesh| move_vertices(mesh, |v| v * 2.0));
    assert_eq!(world.app.world().resource::<Told>().0, before + 1);
}

#[test]
fn within_the_budget_nothing_goes() {
    let mut world = World::new(ball());
    world.set(MeshSettings {
        memory_budget: Some(world.bvhs().memory()),
        ..default()
    });
    world.frames(2 * GRACE);
    assert_eq!(world.status(), Some(MeshStatus::Ready));
}

#[test]
fn a_mesh_without_hierarchy_is_edited_without_building_one() {
    let mut world = World::new(ball());
    world.set(MeshSettings {
        memory_budget: Some(0),
        ..default()
    });
    world.frames(GRACE + 1);
    world.edit(|mesh| move_vertices(mesh, |v| v * 0.9));
    assert_eq!(world.status(), Some(MeshStatus::Dormant));
    world.edit(|mesh| *mesh = Torus::new(0.3, 1.0).into());
    assert_eq!(world.status(), Some(MeshStatus::Dormant));
    world.assert_exact(80);
}

#[test]
fn a_mesh_that_nobody_uses_is_dropped_after_a_while_and_comes_back_with_a_user() {
    let mut world = World::new(ball());
    world.app.world_mut().despawn(world.entity);
    world.frames(GRACE);
    assert_eq!(world.status(), Some(MeshStatus::Ready), "it may come back");
    world.frames(1);
    assert_eq!((world.status(), world.bvhs().memory()), (None, 0));

    world.app.world_mut().spawn(Mesh3d(world.mesh.clone()));
    settle(&mut world.app);
    assert_eq!(world.status(), Some(MeshStatus::Ready));
    world.assert_exact(90);
}

#[test]
fn a_mesh_that_finds_a_user_in_time_is_kept() {
    let mut world = World::new(ball());
    for _ in 0..3 {
        world.app.world_mut().despawn(world.entity);
        world.frames(GRACE / 2 + 1);
        world.entity = world.app.world_mut().spawn(Mesh3d(world.mesh.clone())).id();
        world.frames(GRACE / 2 + 1);
        assert_eq!((world.status(), world.bvhs().building()), (Some(MeshStatus::Ready), 0));
    }
    world.frames(2 * GRACE);
    assert_eq!(world.status(), Some(MeshStatus::Ready));
}

#[test]
fn a_mesh_that_is_dropped_while_it_is_built_is_built_no_more() {
    let mut world = World::unbuilt(ball());
    world.app.world_mut().despawn(world.entity);
    world.frames(GRACE + 2);
    assert_eq!((world.status(), world.bvhs().building()), (None, 0));
}

#[test]
fn while_the_index_is_paused_meshes_are_hit_as_they_were() {
    #[derive(Resource)]
    struct IsOn(bool);

    let mut app = headless_app();
    app.insert_resource(IsOn(true))
        .configure_sets(PostUpdate, SpatialIndexSystems::Sync.run_if(|is_on: Res<IsOn>| is_on.0));
    let mesh = add_mesh(&mut app, Cuboid::default());
    app.world_mut().spawn((Mesh3d(mesh.clone()), Transform::default()));
    settle(&mut app);
    let near_face = |app: &mut App| cast(app, Ray3d::new(Vec3::Z * 100.0, Dir3::NEG_Z)).map(|hit| hit.position.z);
    assert_eq!(near_face(&mut app), Some(0.5));
    app.world_mut().resource_mut::<IsOn>().0 = false;
    let flat = Cuboid::new(1.0, 1.0, 0.25).into();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(&mesh, flat).expect("an asset that is there");
    app.update();
    app.update();
    assert_eq!(near_face(&mut app), Some(0.5));
    app.world_mut().resource_mut::<IsOn>().0 = true;
    app.update();
    assert_eq!(near_face(&mut app), Some(0.125));
}
