//! The bound on how far two surfaces lie apart.

use bevy::prelude::*;
use bevy_sightline::{
    lod::simplify::{Deviation, DeviationSettings},
    mesh::{MeshBvh, TriangleMesh},
};

use crate::common::{random_point, rng};

fn bvh(mesh: &Mesh) -> MeshBvh {
    MeshBvh::build(&TriangleMesh::from_mesh(mesh).expect("a usable mesh"))
}

fn between(a: &Mesh, b: &Mesh) -> Deviation {
    Deviation::between(&bvh(a), &bvh(b), &DeviationSettings::default())
}

/// A mesh of loose triangles.
fn soup(corners: Vec<Vec3>) -> Mesh {
    Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
}

/// The farthest of many points of one surface from the other, by a test of all triangles.
fn farthest_sample(from: &Mesh, to: &Mesh, steps: u32) -> f32 {
    let [from, to] = [from, to].map(|mesh| TriangleMesh::from_mesh(mesh).expect("a usable mesh"));
    let mut farthest = 0.0f32;
    for [a, b, c] in from.corners_of_all() {
        for i in 0..=steps {
            for j in 0..=steps - i {
                let [u, v] = [i, j].map(|step| step as f32 / steps as f32);
                let point = a + (b - a) * u + (c - a) * v;
                let nearest = to.closest_point(point, f32::INFINITY).expect("there is a surface");
                farthest = farthest.max(nearest.distance);
            }
        }
    }
    farthest
}

#[test]
fn a_surface_does_not_deviate_from_itself() {
    let sphere = Mesh::from(Sphere::new(1.0));
    let deviation = between(&sphere, &sphere);
    assert!(
        deviation.at_least <= deviation.at_most && deviation.at_most < 1e-6,
        "{deviation:?}"
    );
}

#[test]
fn a_surface_cut_up_otherwise_does_not_deviate() {
    let coarse = Mesh::from(Plane3d::default().mesh().size(3.0, 2.0));
    let fine = Mesh::from(Plane3d::default().mesh().size(3.0, 2.0).subdivisions(7));
    let settings = DeviationSettings {
        negligible: 1e-3,
        ..default()
    };
    let deviation = Deviation::between(&bvh(&coarse), &bvh(&fine), &settings);
    assert!(deviation.at_most <= 1e-3, "{deviation:?}");
}

#[test]
fn a_cube_that_is_moved_deviates_as_far_as_it_was_moved() {
    let cube = Mesh::from(Cuboid::default());
    let moved = cube.clone().translated_by(Vec3::X * 0.25);
    let deviation = between(&cube, &moved);
    assert!((0.2499..=0.25 * 1.051).contains(&deviation.at_most), "{deviation:?}");
}

#[test]
fn a_hole_counts_though_everything_else_lies_on_the_original() {
    let whole = Mesh::from(Plane3d::default().mesh().size(4.0, 4.0));
    let corner = soup(vec![
        Vec3::new(-2.0, 0.0, -2.0),
        Vec3::new(-2.0, 0.0, 2.0),
        Vec3::new(2.0, 0.0, -2.0),
    ]);
    let deviation = between(&corner, &whole);
    let true_distance = 8.0f32.sqrt();
    assert!(
        (true_distance * 0.999..=true_distance * 1.051).contains(&deviation.at_most),
        "{deviation:?}"
    );
}

#[test]
fn no_point_is_farther_than_the_bound_and_the_bound_is_tight() {
    let rng = &mut rng(7);
    for round in 0..40 {
        let mut corners = |count: usize| -> Vec<Vec3> { (0..3 * count).map(|_| random_point(rng, 1.0)).collect() };
        let (a, b) = (soup(corners(1 + round % 7)), soup(corners(1 + round % 5)));
        let sampled = farthest_sample(&a, &b, 40).max(farthest_sample(&b, &a, 40));
        let deviation = between(&a, &b);
        assert!(sampled <= deviation.at_most, "{sampled} > {deviation:?}");
        assert!(deviation.at_most <= deviation.at_least * 1.051, "{deviation:?}");
        // No sample is farther than a step from its neighbours.
        assert!(deviation.at_least <= sampled + 3.5 / 40.0, "{sampled} < {deviation:?}");
    }
}

#[test]
fn noise_on_a_fine_mesh_is_bounded() {
    let rng = &mut rng(8);
    let sphere = Sphere::new(1.0).mesh().ico(6).expect("not too fine");
    let mut noisy = sphere.clone();
    let positions = noisy.attribute_mut(Mesh::ATTRIBUTE_POSITION).expect("it has some");
    if let bevy::mesh::VertexAttributeValues::Float32x3(positions) = positions {
        for position in positions {
            *position = (Vec3::from(*position) + random_point(rng, 0.02)).into();
        }
    }
    let sampled = farthest_sample(&sphere, &noisy, 4).max(farthest_sample(&noisy, &sphere, 4));
    let deviation = between(&sphere, &noisy);
    assert!(sampled <= deviation.at_most, "{sampled} > {deviation:?}");
    assert!(deviation.at_most <= deviation.at_least * 1.051, "{deviation:?}");
}

#[test]
fn a_bound_without_a_budget_still_holds() {
    let rng = &mut rng(9);
    let mut corners = || -> Vec<Vec3> { (0..30).map(|_| random_point(rng, 1.0)).collect() };
    let (a, b) = (soup(corners()), soup(corners()));
    let settings = DeviationSettings {
        pieces_per_triangle: 0,
        ..default()
    };
    let loose = Deviation::between(&bvh(&a), &bvh(&b), &settings);
    assert!(loose.at_most >= between(&a, &b).at_least);
}

#[test]
fn triangles_without_area_are_measured_as_what_they_are() {
    let point = soup(vec![Vec3::ZERO; 3]);
    let line = soup(vec![Vec3::X, Vec3::X * 2.0, Vec3::X * 3.0]);
    let deviation = between(&point, &line);
    assert!((3.0..=3.0 * 1.051).contains(&deviation.at_most), "{deviation:?}");
}
