//! One mesh, simplified.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{
        Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues, VertexFormat, morph::MorphAttributes,
    },
    platform::collections::{HashMap, HashSet},
    prelude::*,
};
use bevy_sightline::{
    lod::simplify::{Simplifier, SimplifyError, SimplifyTarget},
    mesh::{TriangleMesh, UnusableMesh},
};

const WARMTH: MeshVertexAttribute = MeshVertexAttribute::new("Warmth", 998_877, VertexFormat::Float32);

fn simplify(mesh: &Mesh, target: SimplifyTarget) -> bevy_sightline::lod::simplify::Simplified {
    let simplifier = Simplifier::new(mesh).expect("a usable mesh");
    simplifier.simplify(target, false).expect("a target")
}

fn positions(mesh: &Mesh) -> Vec<[f32; 3]> {
    let positions = mesh
        .attribute(Mesh::ATTRIBUTE_POSITION)
        .and_then(VertexAttributeValues::as_float3);
    positions.expect("it has some").to_vec()
}

/// A sphere with every attribute that Bevy knows, and one that it does not.
fn rich_sphere() -> Mesh {
    let mut mesh = Sphere::new(1.0).mesh().uv(48, 32);
    // Where texture coordinates are torn, positions are the same to the last bit.
    let rounded = |at: &[f32; 3]| at.map(|coordinate| (coordinate * 1e4).round() / 1e4 + 0.0);
    let at: Vec<[f32; 3]> = positions(&mesh).iter().map(rounded).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, at);
    mesh.generate_tangents().expect("there is what is needed");
    let positions = positions(&mesh);
    let by_vertex = |of: fn([f32; 3]) -> [f32; 4]| positions.iter().copied().map(of).collect::<Vec<_>>();
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_COLOR,
        by_vertex(|[x, y, z]| [x.abs(), y.abs(), z.abs(), 1.0]),
    );
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_WEIGHT,
        by_vertex(|[_, y, _]| {
            let share = (y + 1.0) / 2.0;
            [share, 1.0 - share, 0.0, 0.0]
        }),
    );
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; positions.len()]),
    );
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_UV_1,
        positions.iter().map(|&[x, y, _]| [x, y]).collect::<Vec<_>>(),
    );
    mesh.insert_attribute(
        WARMTH,
        positions.iter().map(|&[_, y, _]| y * 10.0).collect::<Vec<f32>>(),
    );
    mesh
}

/// All bytes of each vertex.
fn vertices(mesh: &Mesh) -> Vec<Vec<u8>> {
    let of_vertex = |vertex: usize| {
        let of_attribute = |(attribute, values): (&MeshVertexAttribute, &VertexAttributeValues)| {
            let size = attribute.format.size() as usize;
            values.get_bytes()[vertex * size..][..size].to_vec()
        };
        mesh.attributes().flat_map(of_attribute).collect()
    };
    (0..mesh.count_vertices()).map(of_vertex).collect()
}

#[test]
fn every_vertex_that_is_left_is_one_of_the_original_with_all_that_it_has() {
    let mesh = rich_sphere();
    let simple = simplify(&mesh, SimplifyTarget::Ratio(0.2));
    assert!(simple.triangles <= 600);
    let ids = |mesh: &Mesh| {
        mesh.attributes()
            .map(|(attribute, _)| attribute.name)
            .collect::<Vec<_>>()
    };
    assert_eq!(ids(&simple.mesh), ids(&mesh));
    let originals: HashSet<Vec<u8>> = vertices(&mesh).into_iter().collect();
    assert!(vertices(&simple.mesh).iter().all(|vertex| originals.contains(vertex)));
}

#[test]
fn a_ratio_is_met() {
    let mesh = Sphere::new(1.0).mesh().ico(20).expect("not too fine");
    let all = TriangleMesh::from_mesh(&mesh).expect("a usable mesh").len();
    for ratio in [0.5, 0.2, 0.05] {
        let simple = simplify(&mesh, SimplifyTarget::Ratio(ratio));
        let part = simple.triangles as f32 / all as f32;
        assert!((ratio * 0.9..=ratio * 1.01).contains(&part), "{part} of {ratio}");
    }
}

#[test]
fn an_error_is_kept_with_few_triangles() {
    let mesh = Mesh::from(Torus::new(0.5, 1.0).mesh().major_resolution(96).minor_resolution(48));
    let simplifier = Simplifier::new(&mesh).expect("a usable mesh");
    let mut before = simplifier.triangles();
    for error in [0.001, 0.005, 0.02, 0.08] {
        let simple = simplifier
            .simplify(SimplifyTarget::Error(error), false)
            .expect("a target");
        assert!(simple.deviation.at_most <= error * simplifier.extent());
        assert!(simple.triangles < before * 4 / 5, "{} after {before}", simple.triangles);
        before = simple.triangles;
    }
}

#[test]
fn what_makes_no_difference_is_taken_away_without_error() {
    let mesh = Mesh::from(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(20));
    let simple = simplify(&mesh, SimplifyTarget::Error(0.0));
    assert!(simple.triangles <= 40, "{}", simple.triangles);
}

#[test]
fn locked_borders_stay() {
    let mesh = Mesh::from(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(20));
    let simplifier = Simplifier::new(&mesh).expect("a usable mesh");
    let border = |mesh: &Mesh| {
        let is_outside = |[x, _, z]: &[f32; 3]| x.abs().max(z.abs()) > 0.999;
        let mut border: Vec<[u32; 3]> = positions(mesh)
            .iter()
            .filter(|at| is_outside(at))
            .map(|at| at.map(f32::to_bits))
            .collect();
        border.sort_unstable();
        border
    };
    let simple = simplifier.simplify(SimplifyTarget::Ratio(0.0), true).expect("a target");
    assert_eq!(border(&simple.mesh), border(&mesh));
    assert!(simple.triangles < simplifier.triangles() / 4);
    let free = simplifier
        .simplify(SimplifyTarget::Ratio(0.1), false)
        .expect("a target");
    assert!(border(&free.mesh).len() < border(&mesh).len());
}

#[test]
fn a_closed_mesh_stays_closed_across_its_seams() {
    let simple = simplify(&rich_sphere(), SimplifyTarget::Ratio(0.2));
    let at = positions(&simple.mesh);
    let mut edges = HashMap::<[[u32; 3]; 2], i32>::default();
    let indices: Vec<usize> = simple.mesh.indices().expect("a list with indices").iter().collect();
    for triangle in indices.as_chunks::<3>().0 {
        for side in 0..3 {
            let [from, to] = [side, (side + 1) % 3].map(|corner| at[triangle[corner]].map(f32::to_bits));
            let (key, turn) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            *edges.entry(key).or_default() += turn;
        }
    }
    assert!(edges.values().all(|&balance| balance == 0));
}

#[test]
fn joints_and_weights_survive_and_still_add_up_to_one() {
    let simple = simplify(&rich_sphere(), SimplifyTarget::Ratio(0.1));
    let Some(VertexAttributeValues::Float32x4(weights)) = simple.mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT) else {
        panic!("it has weights");
    };
    let Some(VertexAttributeValues::Uint16x4(joints)) = simple.mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
        panic!("it has joints");
    };
    assert_eq!(
        (weights.len(), joints.len()),
        (simple.mesh.count_vertices(), simple.mesh.count_vertices())
    );
    assert!(
        weights
            .iter()
            .all(|weights| (weights.iter().sum::<f32>() - 1.0).abs() < 1e-6)
    );
}

/// A straight tube along y, of `rings` rings, the upper half of which hangs on a second joint.
fn arm(rings: usize) -> Mesh {
    let mut mesh = Mesh::from(Cylinder::new(0.1, 2.0).mesh().resolution(8).segments(rings as u32));
    let weights: Vec<_> = positions(&mesh)
        .iter()
        .map(|&[_, y, _]| {
            let share = (0.5 + y * 5.0).clamp(0.0, 1.0);
            [1.0 - share, share, 0.0, 0.0]
        })
        .collect();
    let joints = VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; weights.len()]);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
    mesh
}

#[test]
fn a_straight_arm_keeps_the_vertices_that_it_is_bent_at() {
    let mesh = arm(40);
    let simple = simplify(&mesh, SimplifyTarget::Ratio(0.2));
    let bends = |mesh: &Mesh| positions(mesh).iter().filter(|[_, y, _]| y.abs() < 0.25).count();
    assert!(
        bends(&simple.mesh) >= 12,
        "{} vertices at the elbow",
        bends(&simple.mesh)
    );
}

#[test]
fn a_mesh_with_morph_targets_keeps_its_vertices_and_what_they_move() {
    let mut mesh = Mesh::from(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(20));
    let at = positions(&mesh);
    // A bump in the middle that is flat at rest.
    let bump = |&[x, _, z]: &[f32; 3]| MorphAttributes {
        position: Vec3::Y * (1.0 - 4.0 * Vec2::new(x, z).length()).max(0.0),
        ..default()
    };
    mesh.set_morph_targets(at.iter().map(bump).collect());
    let simple = simplify(&mesh, SimplifyTarget::Ratio(0.3));
    assert_eq!(positions(&simple.mesh), at);
    assert_eq!(simple.mesh.morph_targets(), mesh.morph_targets());
    let used: HashSet<usize> = simple.mesh.indices().expect("a list with indices").iter().collect();
    let of_bump = used
        .iter()
        .filter(|&&vertex| Vec2::new(at[vertex][0], at[vertex][2]).length() < 0.26)
        .count();
    assert!(of_bump >= 9, "{of_bump} vertices of the bump");
}

#[test]
fn lists_strips_and_loose_triangles_are_all_simplified() {
    let list = Mesh::from(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(9));
    let loose = list.clone().with_duplicated_vertices();
    let mut narrow = list.clone();
    narrow.insert_indices(Indices::U16(
        list.indices().expect("it has some").iter().map(|i| i as u16).collect(),
    ));
    let strip = Mesh::new(PrimitiveTopology::TriangleStrip, RenderAssetUsages::default()).with_inserted_attribute(
        Mesh::ATTRIBUTE_POSITION,
        (0..40)
            .map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0])
            .collect::<Vec<_>>(),
    );
    for mesh in [list, loose, narrow, strip] {
        let simple = simplify(&mesh, SimplifyTarget::Error(1e-3));
        assert!(simple.triangles <= 6, "{}", simple.triangles);
        assert_eq!(simple.mesh.primitive_topology(), PrimitiveTopology::TriangleList);
        assert!(simple.mesh.count_vertices() <= 8, "unused vertices are dropped");
        assert!(matches!(simple.mesh.indices(), Some(Indices::U16(_))));
    }
}

#[test]
fn a_level_of_many_vertices_has_wide_indices() {
    let mesh = Mesh::from(Plane3d::default().mesh().size(1.0, 1.0).subdivisions(259));
    let at: Vec<[f32; 3]> = positions(&mesh)
        .iter()
        .map(|&[x, _, z]| [x, (x * 97.0).sin() * (z * 83.0).cos(), z])
        .collect();
    let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, at);
    let simple = simplify(&mesh, SimplifyTarget::Ratio(0.99));
    assert!(simple.mesh.count_vertices() > usize::from(u16::MAX));
    assert!(matches!(simple.mesh.indices(), Some(Indices::U32(_))));
}

#[test]
fn bad_triangles_are_left_out() {
    let mut mesh = Sphere::new(1.0).mesh().uv(24, 16);
    let mut at = positions(&mesh);
    let bad = at.len() as u32;
    at.extend([[f32::NAN, 0.0, 0.0], [f32::INFINITY, 1.0, 0.0], [9e30, 9e30, 9e30]]);
    let mut indices: Vec<u32> = mesh
        .indices()
        .expect("it has some")
        .iter()
        .map(|index| index as u32)
        .collect();
    indices.extend([0, 1, bad, bad + 1, 2, 3, 4, 5, 4_000_000_000]);
    let mesh = {
        mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, at)
            .with_inserted_indices(Indices::U32(indices))
    };
    let simple = simplify(&mesh, SimplifyTarget::Ratio(0.3));
    let clean = TriangleMesh::from_mesh(&simple.mesh).expect("a usable mesh");
    assert_eq!(clean.left_out(), 0);
    assert!(simple.deviation.at_most < 0.5);
}

#[test]
fn attributes_that_are_not_numbers_do_no_harm() {
    let mut mesh = rich_sphere();
    let count = mesh.count_vertices();
    mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[f32::NAN, f32::INFINITY, 1e38]; count]);
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_COLOR,
        vec![[f32::NEG_INFINITY, f32::NAN, 1e38, -1.0]; count],
    );
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[f32::NAN, 1e38, -1e38, 0.0]; count]);
    let simple = simplify(&mesh, SimplifyTarget::Ratio(0.3));
    assert!(simple.triangles < 1000);
}

#[test]
fn degenerate_meshes_stay_something() {
    let mesh_of = |at: Vec<[f32; 3]>| {
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, at)
    };
    let point = mesh_of(vec![[1.0, 2.0, 3.0]; 9]);
    let line = mesh_of((0..9).map(|i| [i as f32, 0.0, 0.0]).collect());
    let tiny = mesh_of(vec![[0.0; 3], [1e-40, 0.0, 0.0], [0.0, 1e-40, 0.0]]);
    for mesh in [point, line, tiny] {
        for target in [
            SimplifyTarget::Ratio(0.0),
            SimplifyTarget::Error(0.1),
            SimplifyTarget::Error(0.0),
        ] {
            assert!(simplify(&mesh, target).triangles > 0);
        }
    }
}

#[test]
fn what_cannot_be_simplified_says_why() {
    let empty = |topology| Mesh::new(topology, RenderAssetUsages::default());
    let why = |mesh: &Mesh| Simplifier::new(mesh).err();
    let lines = empty(PrimitiveTopology::LineList);
    assert_eq!(
        why(&lines),
        Some(UnusableMesh::Topology(PrimitiveTopology::LineList).into())
    );
    let bare = empty(PrimitiveTopology::TriangleList);
    assert_eq!(why(&bare), Some(UnusableMesh::NoPositions.into()));
    let at = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let uneven = bare.clone().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, at);
    let uneven = uneven.with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0, 0.0]]);
    assert!(matches!(
        why(&uneven),
        Some(SimplifyError::UnevenAttribute {
            values: 1,
            vertices: 3,
            ..
        })
    ));
    let vast = vec![[-3e38, 0.0, 0.0], [3e38, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(
        why(&bare.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vast)),
        Some(SimplifyError::TooLarge)
    );
    let cube = Simplifier::new(&Mesh::from(Cuboid::default())).expect("a usable mesh");
    for target in [SimplifyTarget::Ratio(f32::NAN), SimplifyTarget::Error(-1.0)] {
        assert!(matches!(cube.simplify(target, false), Err(SimplifyError::BadTarget(_))));
    }
}
