//! Several placed meshes as one.

use bevy::{
    math::Affine3A,
    mesh::{PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};
use bevy_sightline::{
    lod::simplify::{SimplifyError, merge_meshes},
    mesh::{TriangleMesh, UnusableMesh},
};

/// Six times the volume that the triangles of a closed mesh enclose; negative if they are turned inside out.
fn volume(mesh: &Mesh) -> f32 {
    let mesh = TriangleMesh::from_mesh(mesh).expect("a usable mesh");
    mesh.corners_of_all().map(|[a, b, c]| a.dot(b.cross(c))).sum()
}

fn normals_face_outward(mesh: &Mesh) -> bool {
    let triangles = TriangleMesh::from_mesh(mesh).expect("a usable mesh");
    let Some(VertexAttributeValues::Float32x3(normals)) = mesh.attribute(Mesh::ATTRIBUTE_NORMAL) else {
        return false;
    };
    (triangles.corners_of_all().zip(triangles.vertices_of_all())).all(|([a, b, c], vertices)| {
        let face = (b - a).cross(c - a).normalize();
        vertices
            .iter()
            .all(|&vertex| face.dot(normals[vertex as usize].into()) > 0.999)
    })
}

#[test]
fn parts_lie_where_they_were_placed() {
    let cube = Mesh::from(Cuboid::default());
    let places = [
        Affine3A::from_translation(Vec3::X * 5.0),
        Affine3A::from_scale(Vec3::splat(2.0)),
    ];
    let merged = merge_meshes(places.map(|place| (&cube, place))).expect("usable meshes");
    let aabb = TriangleMesh::from_mesh(&merged).expect("a usable mesh").aabb();
    assert_eq!(
        (Vec3::from(aabb.min), Vec3::from(aabb.max)),
        (Vec3::splat(-1.0), Vec3::new(5.5, 1.0, 1.0))
    );
    assert!((volume(&merged) - 6.0 * 9.0).abs() < 1e-3);
}

#[test]
fn what_is_mirrored_keeps_its_outside_outside() {
    let cube = Mesh::from(Cuboid::default());
    let shear = Mat3::from_cols(Vec3::X, Vec3::new(0.5, 1.0, 0.0), Vec3::Z);
    for matrix in [
        Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0)),
        Mat3::from_diagonal(Vec3::new(-1.0, -2.0, -3.0)),
        Mat3::from_diagonal(Vec3::new(3.0, 1.0, 0.5)),
        shear,
        shear * Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0)),
    ] {
        let merged = merge_meshes([(&cube, Affine3A::from_mat3(matrix))]).expect("a usable mesh");
        assert!(volume(&merged) > 0.0, "{matrix}");
        assert!(normals_face_outward(&merged), "{matrix}");
    }
}

#[test]
fn tangents_are_mirrored_with_their_mesh() {
    let mut cube = Mesh::from(Cuboid::default());
    cube.generate_tangents().expect("there is what is needed");
    let merged = merge_meshes([(&cube, Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)))]).expect("a usable mesh");
    let tangents = |mesh: &Mesh| match mesh.attribute(Mesh::ATTRIBUTE_TANGENT) {
        Some(VertexAttributeValues::Float32x4(tangents)) => tangents.clone(),
        _ => panic!("it has tangents"),
    };
    let sides = |tangents: Vec<[f32; 4]>| tangents.iter().map(|tangent| tangent[3]).sum::<f32>();
    assert_eq!(sides(tangents(&merged)), -sides(tangents(&cube)));
}

#[test]
fn parts_get_what_others_have_and_lose_what_others_lack() {
    let plain = Mesh::from(Cuboid::default());
    let plain = plain
        .with_removed_attribute(Mesh::ATTRIBUTE_UV_0)
        .with_removed_attribute(Mesh::ATTRIBUTE_NORMAL);
    let mut rich = Mesh::from(Sphere::default());
    rich.generate_tangents().expect("there is what is needed");
    let count = rich.count_vertices();
    rich.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.0, 0.5, 0.0, 1.0]; count]);
    let merged = merge_meshes([(&plain, Affine3A::IDENTITY), (&rich, Affine3A::IDENTITY)]).expect("usable meshes");
    for attribute in [Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_COLOR] {
        assert!(merged.contains_attribute(attribute), "{}", attribute.name);
    }
    assert!(!merged.contains_attribute(Mesh::ATTRIBUTE_TANGENT));
    assert!(
        merged
            .attributes()
            .all(|(_, values)| values.len() == merged.count_vertices())
    );
}

#[test]
fn parts_without_a_surface_are_left_out_unless_there_is_nothing_else() {
    let cube = Mesh::from(Cuboid::default());
    let lines = Mesh::new(PrimitiveTopology::LineList, default());
    let merged = merge_meshes([(&lines, Affine3A::IDENTITY), (&cube, Affine3A::IDENTITY)]).expect("one is usable");
    assert_eq!(merged.count_vertices(), cube.count_vertices());
    let merged = merge_meshes([(&lines, Affine3A::IDENTITY)]);
    let why = UnusableMesh::Topology(PrimitiveTopology::LineList);
    assert_eq!(merged.err(), Some(SimplifyError::Unusable(why)));
    assert_eq!(
        merge_meshes([]).err(),
        Some(SimplifyError::Unusable(UnusableMesh::NoTriangles))
    );
}
