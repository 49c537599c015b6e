//! Hierarchies that are saved beside their meshes, and what becomes of files that are not what they should be.

use std::sync::LazyLock;

use bevy::{
    asset::RenderAssetUsages,
    math::{
        Vec3,
        primitives::{Sphere, Torus},
    },
    mesh::{Mesh, MeshBuilder, Meshable, PrimitiveTopology},
};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBvh, TriangleMesh, UnreadableBvh},
};
use proptest::prelude::*;

use crate::{
    common::{random_dir, random_point, rng},
    properties::cases,
};

fn triangles(mesh: &Mesh) -> TriangleMesh {
    TriangleMesh::from_mesh(mesh).expect("a usable mesh")
}

fn list(positions: Vec<Vec3>) -> TriangleMesh {
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    triangles(&mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions))
}

fn soup(seed: u64, n: usize) -> Vec<Vec3> {
    let mut rng = rng(seed);
    let triangle = |_| {
        let center = random_point(&mut rng, 10.0);
        std::array::from_fn::<_, 3, _>(|_| center + random_point(&mut rng, 2.0))
    };
    (0..n).flat_map(triangle).collect()
}

fn meshes() -> Vec<TriangleMesh> {
    vec![
        triangles(&Sphere::new(1.0).mesh().ico(8).expect("not too fine")),
        triangles(&Torus::new(0.5, 2.0).mesh().build()),
        list(soup(1, 500)),
        list(soup(2, 1)),
        list(soup(3, 7)),
        list(soup(4, 1).repeat(50)),
        list(vec![Vec3::ONE; 60]),
    ]
}

fn assert_hit_alike(a: &MeshBvh, b: &MeshBvh, n: usize) {
    let mut rng = rng(5);
    for _ in 0..n {
        let ray = Ray::new(random_point(&mut rng, 12.0), *random_dir(&mut rng), f32::INFINITY).expect("a direction");
        let [a, b] = [a, b].map(|bvh| bvh.closest_hit(&ray, Backfaces::Include));
        assert_eq!(
            a.map(|hit| (hit.t, hit.triangle, hit.barycentrics)),
            b.map(|hit| (hit.t, hit.triangle, hit.barycentrics))
        );
    }
}

#[test]
fn a_hierarchy_comes_back_as_it_was_saved() {
    for mesh in meshes() {
        let built = MeshBvh::build(&mesh);
        assert_eq!(built.validate(), Ok(()));
        let bytes = built.to_bytes();
        let loaded = MeshBvh::from_bytes(&bytes, &mesh).expect("its own bytes");
        assert_eq!(loaded.validate(), Ok(()));
        assert_eq!(loaded.to_bytes(), bytes);
        assert_hit_alike(&built, &loaded, 500);
    }
}

#[test]
fn a_hierarchy_that_was_refitted_is_saved_for_the_mesh_as_it_is_now() {
    let (before, after) = (soup(6, 300), soup(7, 300));
    let mut refitted = MeshBvh::build(&list(before.clone()));
    refitted.refit(&after);
    let bytes = refitted.to_bytes();
    assert_eq!(
        MeshBvh::from_bytes(&bytes, &list(before)).err(),
        Some(UnreadableBvh::OtherMesh)
    );
    let loaded = MeshBvh::from_bytes(&bytes, &list(after)).expect("the mesh as it is now");
    assert_hit_alike(&refitted, &loaded, 500);
}

#[test]
fn a_hierarchy_is_read_for_a_mesh_whose_triangles_lie_in_another_order_of_memory() {
    let mesh = list(soup(8, 200));
    let built = MeshBvh::build(&mesh);
    let loaded = MeshBvh::from_bytes(&built.to_bytes(), built.mesh()).expect("the same triangles");
    assert_hit_alike(&built, &loaded, 500);
}

#[test]
fn a_hierarchy_of_triangles_with_gaps_in_their_numbers_comes_back() {
    let mut positions = soup(9, 100);
    positions[3].x = f32::NAN;
    positions[200].y = f32::INFINITY;
    let mesh = list(positions);
    assert_eq!(mesh.len(), 98);
    let built = MeshBvh::build(&mesh);
    assert_hit_alike(
        &built,
        &MeshBvh::from_bytes(&built.to_bytes(), &mesh).expect("its own bytes"),
        500,
    );
}

#[test]
fn the_hierarchy_of_another_mesh_is_refused() {
    let positions = soup(10, 100);
    let bytes = MeshBvh::build(&list(positions.clone())).to_bytes();
    let refusal = |positions: Vec<Vec3>| MeshBvh::from_bytes(&bytes, &list(positions)).err();

    let mut moved = positions.clone();
    moved[77].z = moved[77].z.next_up();
    assert_eq!(refusal(moved), Some(UnreadableBvh::OtherMesh));
    let mut turned = positions.clone();
    turned.swap(0, 1);
    assert_eq!(refusal(turned), Some(UnreadableBvh::OtherMesh));
    let mut exchanged = positions.clone();
    exchanged.rotate_left(3);
    assert_eq!(refusal(exchanged), Some(UnreadableBvh::OtherMesh));
    assert_eq!(refusal(positions[3..].to_vec()), Some(UnreadableBvh::OtherMesh));
    assert_eq!(refusal(positions), None);
}

/// A mesh, and the bytes of its hierarchy.
static SAVED: LazyLock<(TriangleMesh, Vec<u8>)> = LazyLock::new(|| {
    let mesh = list(soup(11, 200));
    let bytes = MeshBvh::build(&mesh).to_bytes();
    (mesh, bytes)
});

/// The bytes, with the checksum that they should have.
fn with_right_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let checksum = crc32fast::hash(&bytes[..body]).to_le_bytes();
    bytes[body..].copy_from_slice(&checksum);
    bytes
}

/// Asserts that the bytes are refused, or are those of a hierarchy that gives the right answers.
fn assert_harmless(bytes: &[u8]) -> Option<UnreadableBvh> {
    let (mesh, _) = &*SAVED;
    match MeshBvh::from_bytes(bytes, mesh) {
        Err(why) => Some(why),
        Ok(loaded) => {
            assert_eq!(loaded.validate(), Ok(()));
            assert_hit_alike(&MeshBvh::build(mesh), &loaded, 20);
            None
        }
    }
}

#[test]
fn bytes_of_every_shorter_length_are_refused() {
    let (_, bytes) = &*SAVED;
    for len in 0..bytes.len() {
        let expected = match len {
            0..8 => UnreadableBvh::NotABvh,
            8..24 => UnreadableBvh::Length {
                found: len as u64,
                expected: 24,
            },
            _ => UnreadableBvh::Length {
                found: len as u64,
                expected: bytes.len() as u64,
            },
        };
        assert_eq!(assert_harmless(&bytes[..len]), Some(expected));
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert!(matches!(assert_harmless(&longer), Some(UnreadableBvh::Length { .. })));
}

#[test]
fn every_flipped_bit_is_noticed() {
    let (_, bytes) = &*SAVED;
    for bit in 0..bytes.len() * 8 {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(assert_harmless(&flipped).is_some(), "bit {bit}");
    }
}

#[test]
fn another_version_is_refused_by_its_number() {
    let mut bytes = SAVED.1.clone();
    bytes[8..12].copy_from_slice(&7_u32.to_le_bytes());
    assert_eq!(assert_harmless(&bytes), Some(UnreadableBvh::Version { found: 7 }));
    assert_eq!(
        assert_harmless(&with_right_checksum(bytes)),
        Some(UnreadableBvh::Version { found: 7 })
    );
}

#[test]
fn a_header_that_promises_more_than_there_is_is_refused_before_anything_is_allocated() {
    for at in [16, 20] {
        let mut bytes = SAVED.1.clone();
        bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(matches!(
            assert_harmless(&with_right_checksum(bytes)),
            Some(UnreadableBvh::Length { .. })
        ));
    }
}

/// The bytes with other numbers of nodes and of triangles, and with as much behind the header.
fn with_body(nodes: &[[u8; 8]], triangles: &[u32]) -> Vec<u8> {
    let mut bytes = SAVED.1[..16].to_vec();
    bytes.extend((triangles.len() as u32).to_le_bytes());
    bytes.extend((nodes.len() as u32).to_le_bytes());
    bytes.extend(nodes.as_flattened());
    bytes.extend(triangles.iter().flat_map(|triangle| triangle.to_le_bytes()));
    bytes.extend([0; 4]);
    with_right_checksum(bytes)
}

#[test]
fn trees_that_are_none_are_refused_though_their_checksums_are_right() {
    let all: Vec<u32> = (0..200).collect();
    let full = [[255; 8], [5; 8], [5; 8], [5; 8], [5; 8], [5; 8]];
    // 8 × 5 × 5 triangles: a root, five nodes of eight leaves.
    let sound = |root: [u8; 8]| [&[root][..], &full[1..]].concat();
    assert_eq!(
        assert_harmless(&with_body(&sound([255, 255, 255, 255, 255, 0, 0, 0]), &all)),
        None
    );

    let malformed = |nodes: &[[u8; 8]], triangles: &[u32]| {
        assert_eq!(
            assert_harmless(&with_body(nodes, triangles)),
            Some(UnreadableBvh::Malformed)
        );
    };
    malformed(&[], &all);
    malformed(&full, &all);
    malformed(&sound([255, 255, 255, 255, 0, 0, 0, 0]), &all);
    malformed(&sound([255, 255, 255, 255, 255, 1, 0, 0]), &all);
    malformed(&sound([255, 0, 255, 255, 255, 255, 0, 0]), &all);
    malformed(&sound([255, 255, 255, 255, 255, 100, 0, 0]), &all);
    malformed(&[[0; 8]; 6], &all);
    malformed(&vec![[255, 0, 0, 0, 0, 0, 0, 0]; 200], &all);
    malformed(&vec![[255, 255, 0, 0, 0, 0, 0, 0]; 200], &all);
    malformed(&vec![[0; 8]; 10_000], &all);

    let nodes = sound([255, 255, 255, 255, 255, 0, 0, 0]);
    let mut twice = all.clone();
    twice[17] = 18;
    malformed(&nodes, &twice);
    let mut unknown = all.clone();
    unknown[17] = u32::MAX;
    malformed(&nodes, &unknown);
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn damaged_bytes_do_no_harm(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        checksum_is_right in any::<bool>(),
    ) {
        let mut bytes = SAVED.1.clone();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        assert_harmless(&if checksum_is_right { with_right_checksum(bytes) } else { bytes });
    }

    #[test]
    fn random_trees_do_no_harm(
        nodes in prop::collection::vec(prop::sample::select(vec![0_u8, 1, 2, 5, 6, 7, 8, 255, 255]), 8..400),
        shuffle in any::<u64>(),
    ) {
        let mut triangles: Vec<u32> = (0..200).collect();
        triangles.rotate_left((shuffle % 200) as usize);
        assert_harmless(&with_body(nodes.as_chunks().0, &triangles));
    }

    #[test]
    fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..300), has_magic in any::<bool>()) {
        let bytes = if has_magic { [&SAVED.1[..24], &bytes].concat() } else { bytes };
        prop_assert!(assert_harmless(&bytes).is_some());
    }
}
