//! Which meshes touch, and where.

use bevy::{
    math::{Affine3A, DVec3},
    mesh::VertexAttributeValues,
    prelude::*,
};
use bevy_sightline::{
    geometry::triangle_triangle::{self, TriangleContact},
    index::MeshBvhs,
    prelude::*,
};
use rand::Rng;

use crate::common::*;

fn touch(app: &mut App, a: Entity, b: Entity) -> bool {
    let [there, back] = query(app, |scene| [scene.meshes_touch(a, b), scene.meshes_touch(b, a)]);
    assert_eq!(there, back, "one way and not the other");
    there
}

fn contacts(app: &mut App, a: Entity, b: Entity) -> Vec<MeshContact> {
    query(app, |scene| {
        let mut contacts = Vec::new();
        scene.mesh_contacts(a, b, &mut contacts);
        contacts
    })
}

fn neighbours(app: &mut App, entity: Entity, settings: &SceneQuerySettings) -> Vec<Entity> {
    let mut state = bevy::ecs::system::SystemState::<SceneQuery>::new(app.world_mut());
    let mut entities = vec![Entity::PLACEHOLDER];
    let scene = state.get(app.world()).expect("the plugin is there");
    scene.touching_meshes(entity, settings, &mut entities);
    entities
}

#[test]
fn cubes_that_overlap_touch_and_cubes_apart_do_not() {
    let mut app = headless_app();
    let a = spawn_cube(&mut app, Vec3::ZERO);
    let near = spawn_cube(&mut app, Vec3::new(0.7, 0.6, 0.5));
    let far = spawn_cube(&mut app, Vec3::new(1.5, 0.0, 0.0));
    settle(&mut app);
    assert!(touch(&mut app, a, near));
    assert!(!touch(&mut app, a, far));
    assert!(contacts(&mut app, a, far).is_empty());
}

#[test]
fn cubes_that_share_a_face_an_edge_or_a_corner_touch() {
    let mut app = headless_app();
    let a = spawn_cube(&mut app, Vec3::ZERO);
    let others = [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::ONE].map(|place| spawn_cube(&mut app, place));
    settle(&mut app);
    for other in others {
        assert!(touch(&mut app, a, other));
    }
}

#[test]
fn a_mesh_inside_another_touches_it_not() {
    let mut app = headless_app();
    let outer = spawn_mesh(&mut app, Sphere::new(5.0), Transform::IDENTITY);
    let inner = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    assert!(!touch(&mut app, outer, inner));
}

#[test]
fn the_contacts_of_crossing_spheres_lie_on_their_common_circle() {
    let mut app = headless_app();
    let ball = || Sphere::new(1.0).mesh().ico(20).expect("not too many");
    let a = spawn_mesh(&mut app, ball(), Transform::from_xyz(-0.5, 100.0, 0.0));
    let b = spawn_mesh(&mut app, ball(), Transform::from_xyz(0.5, 100.0, 0.0));
    settle(&mut app);
    let contacts = contacts(&mut app, a, b);
    let mut length = 0.0;
    for contact in &contacts {
        for &point in contact.contact.points() {
            let from_axis = (point - DVec3::new(0.0, 100.0, 0.0)).length();
            assert!(
                point.x.abs() < 0.01 && (from_axis - 0.75f64.sqrt()).abs() < 0.01,
                "{point}"
            );
        }
        if let TriangleContact::Segment([from, to]) = contact.contact {
            length += from.distance(to);
        }
    }
    let circumference = std::f64::consts::TAU * 0.75f64.sqrt();
    assert!(
        (length / circumference - 1.0).abs() < 0.02,
        "{length} is not {circumference}"
    );
}

#[test]
fn the_curve_of_two_closed_meshes_is_closed() {
    let mut rng = rng(12);
    let mut app = headless_app();
    let a = spawn_mesh(
        &mut app,
        Torus::new(0.5, 1.2),
        Transform::from_rotation(random_rotation(&mut rng)),
    );
    let b = spawn_mesh(
        &mut app,
        Sphere::new(1.0),
        Transform::from_xyz(0.6, 0.2, 0.3).with_rotation(random_rotation(&mut rng)),
    );
    settle(&mut app);
    let mut ends: Vec<DVec3> = contacts(&mut app, a, b)
        .iter()
        .flat_map(|contact| match contact.contact {
            TriangleContact::Segment(ends) => ends.to_vec(),
            _ => Vec::new(),
        })
        .collect();
    assert!(ends.len() > 40);
    while let Some(end) = ends.pop() {
        let partner = ends.iter().position(|other| other.distance(end) < 1e-6);
        ends.swap_remove(partner.unwrap_or_else(|| panic!("the curve ends at {end}")));
    }
}

/// The triangles of a mesh with indices, placed in double precision.
fn placed_triangles(mesh: &Mesh, transform: &Affine3A) -> Vec<[DVec3; 3]> {
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("no positions");
    };
    let place = transform.as_daffine3();
    let corner = |index: usize| place.transform_point3(Vec3::from(positions[index]).as_dvec3());
    let indices: Vec<usize> = mesh.indices().expect("indices").iter().collect();
    indices
        .chunks_exact(3)
        .map(|triangle| [0, 1, 2].map(|i| corner(triangle[i])))
        .collect()
}

#[test]
fn the_descent_finds_every_pair_that_a_test_of_all_pairs_finds() {
    let mut rng = rng(3);
    for round in 0..24 {
        let mut app = headless_app();
        let torus: Mesh = Torus::new(0.4, 1.0)
            .mesh()
            .major_resolution(16)
            .minor_resolution(10)
            .build();
        let cone: Mesh = Cone::new(0.8, 2.0).mesh().resolution(20).build();
        // Rigid, stretched, mirrored, and flat in one, in the other and in both.
        let mut scale = |flat: bool| {
            let sign = if rng.random_bool(0.3) { -1.0 } else { 1.0 };
            Vec3::new(1.0, sign, if flat { 0.0 } else { rng.random_range(0.5..2.0) })
        };
        let scales = [
            scale(round % 8 == 5 || round % 8 == 7),
            scale(round % 8 == 6 || round % 8 == 7),
        ];
        let mut place = |scale| Transform {
            translation: random_point(&mut rng, 0.6),
            rotation: random_rotation(&mut rng),
            scale,
        };
        let (place_a, place_b) = (place(scales[0]), place(scales[1]));
        let a = spawn_mesh(&mut app, torus.clone(), place_a);
        let b = spawn_mesh(&mut app, cone.clone(), place_b);
        settle(&mut app);

        let [of_a, of_b] =
            [(&torus, place_a), (&cone, place_b)].map(|(mesh, place)| placed_triangles(mesh, &place.compute_affine()));
        let mut expected = Vec::new();
        for (i, a) in (0..).zip(&of_a) {
            let touched = (0..)
                .zip(&of_b)
                .filter(|(_, b)| triangle_triangle::intersect_by_intervals(*a, **b));
            expected.extend(touched.map(|(j, _)| [i, j]));
        }
        let found: Vec<[u32; 2]> = contacts(&mut app, a, b)
            .iter()
            .map(|contact| contact.triangles)
            .collect();
        assert_eq!(found, expected, "round {round}");
        assert_eq!(touch(&mut app, a, b), !expected.is_empty());
    }
}

#[test]
fn meshes_that_are_still_being_built_touch_as_when_they_are_ready() {
    let mut app = headless_app();
    let a = spawn_mesh(&mut app, Sphere::new(1.0), Transform::IDENTITY);
    let b = spawn_mesh(&mut app, Torus::new(0.5, 1.0), Transform::from_xyz(1.0, 0.1, 0.2));
    app.update();
    assert_eq!(
        app.world().resource::<MeshBvhs>().building(),
        2,
        "the test begins too late"
    );
    let early = contacts(&mut app, a, b);
    finish_meshes(&mut app);
    let late = contacts(&mut app, a, b);
    assert!(late.len() > 10);
    assert_eq!(early, late);
}

#[test]
fn the_neighbours_that_touch_are_found_and_no_others() {
    let mut app = headless_app();
    let middle = spawn_mesh(&mut app, Sphere::new(1.0), Transform::IDENTITY);
    let mut touching = [Vec3::X * 1.2, Vec3::NEG_Z * 1.3].map(|place| spawn_cube(&mut app, place));
    touching.sort_unstable();
    // In the box of the sphere, and not on its surface.
    spawn_cube(&mut app, Vec3::splat(1.2));
    spawn_cube(&mut app, Vec3::X * 50.0);
    settle(&mut app);
    assert_eq!(neighbours(&mut app, middle, &SceneQuerySettings::default()), touching);
    let excluded = [touching[0]];
    let settings = SceneQuerySettings::default().excluding(&excluded);
    assert_eq!(neighbours(&mut app, middle, &settings), [touching[1]]);
}

#[test]
fn what_has_no_mesh_touches_nothing() {
    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    let shape = app
        .world_mut()
        .spawn((PickShape::new(Sphere::new(0.6)), Transform::IDENTITY))
        .id();
    settle(&mut app);
    assert!(!touch(&mut app, cube, shape));
    assert!(neighbours(&mut app, shape, &SceneQuerySettings::default()).is_empty());
    assert!(neighbours(&mut app, cube, &SceneQuerySettings::default()).is_empty());
}

#[test]
fn what_was_despawned_touches_nothing() {
    let mut app = headless_app();
    let [a, b] = [Vec3::ZERO, Vec3::splat(0.5)].map(|place| spawn_cube(&mut app, place));
    settle(&mut app);
    assert!(touch(&mut app, a, b));
    app.world_mut().despawn(b);
    assert!(!touch(&mut app, a, b));
    assert!(neighbours(&mut app, a, &SceneQuerySettings::default()).is_empty());
}
