//! How a hierarchy follows vertices that move, and what it costs.

use super::*;

fn positions(mesh: &Mesh) -> Vec<Vec3> {
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("a mesh with positions");
    };
    positions.iter().copied().map(Vec3::from).collect()
}

fn with_positions(mesh: &Mesh, positions: Vec<Vec3>) -> Mesh {
    mesh.clone()
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
}

/// The vertices of the mesh, twisted about the y axis and blown up by `scale`.
fn twisted(mesh: &Mesh, scale: f32) -> Vec<Vec3> {
    let twist = |at: Vec3| Vec3::new(at.x + at.y * at.z, at.y * 0.5, at.z - at.x * at.x) * scale;
    positions(mesh).into_iter().map(twist).collect()
}

/// Compares two hierarchies on random rays.
fn assert_answer_alike(seed: u64, a: &MeshBvh, b: &MeshBvh) {
    let mut rng = rng(seed);
    let mut hits = 0;
    for _ in 0..2_000 {
        let ray = random_ray(&mut rng, a.mesh());
        for backfaces in [Backfaces::Cull, Backfaces::Include] {
            let hit = a.closest_hit(&ray, backfaces);
            assert_eq!(bits(hit), bits(b.closest_hit(&ray, backfaces)), "{ray:?}");
            assert_eq!(a.any_hit(&ray, backfaces), hit.is_some());
            assert_eq!(b.any_hit(&ray, backfaces), hit.is_some());
            hits += usize::from(hit.is_some());
        }
    }
    assert!(hits > 200, "only {hits} hits");
}

#[test]
fn a_refitted_hierarchy_answers_as_one_built_anew() {
    for (seed, mesh) in [
        (60, sphere()),
        (61, list(soup(&mut rng(62), 500))),
        (63, Torus::new(0.5, 2.0).mesh().build()),
    ] {
        let mut bvh = MeshBvh::build(&triangles(&mesh));
        for scale in [1.0, 1e-6, 1e6, 1.0] {
            let moved = twisted(&mesh, scale);
            bvh.refit(&moved);
            let anew = MeshBvh::build(&triangles(&with_positions(&mesh, moved)));
            assert_eq!(bvh.mesh().aabb(), anew.mesh().aabb());
            assert_answer_alike(seed, &bvh, &anew);
        }
    }
}

#[test]
fn a_refit_to_where_the_vertices_are_changes_nothing() {
    let mesh = sphere();
    let built = MeshBvh::build(&triangles(&mesh));
    let mut refitted = built.clone();
    refitted.refit(&positions(&mesh));
    assert_eq!(refitted.sah_cost(), built.sah_cost());
    assert_answer_alike(64, &refitted, &built);
}

#[test]
fn a_refit_leaves_clones_where_they_are() {
    let mesh = sphere();
    let (built, other) = (MeshBvh::build(&triangles(&mesh)), MeshBvh::build(&triangles(&mesh)));
    let mut moved = built.clone();
    moved.refit(&twisted(&mesh, 3.0));
    assert_ne!(moved.mesh().aabb(), built.mesh().aabb());
    assert_answer_alike(65, &built, &other);
}

#[test]
#[should_panic(expected = "positions must be finite")]
fn a_refit_to_a_vertex_that_is_not_finite_panics() {
    let mesh = sphere();
    let mut moved = positions(&mesh);
    moved[7].y = f32::NAN;
    MeshBvh::build(&triangles(&mesh)).refit(&moved);
}

#[test]
fn a_mesh_that_is_torn_apart_costs_more() {
    let mesh = sphere();
    let mut bvh = MeshBvh::build(&triangles(&mesh));
    let before = bvh.sah_cost();
    assert!(before > 1.0);
    let mut rng = rng(66);
    let scattered: Vec<Vec3> = positions(&mesh).iter().map(|_| random_point(&mut rng, 1.0)).collect();
    bvh.refit(&scattered);
    assert!(bvh.sah_cost() > before * 3.0);
}

#[test]
fn leaves_of_every_size_are_hit_as_by_the_scan() {
    for n in 1..40 {
        let soup = soup(&mut rng(100 + n), n as usize);
        let mesh = list(soup);
        let mut rng = rng(200 + n);
        assert_hierarchy_agrees(&mesh, |mesh| (0..100).map(|_| random_ray(&mut rng, mesh)).collect());
    }
}

#[test]
fn meshes_as_small_and_as_large_as_f32_allows_are_hit_as_by_the_scan() {
    for (seed, scale) in [(70, 1e-20_f32), (71, 1e20), (72, 1e-12), (73, 1e12)] {
        let mesh = sphere().scaled_by(Vec3::splat(scale));
        let mut rng = rng(seed);
        let rays = |_: &TriangleMesh| {
            let ray = |_| {
                let (from, to) = (random_point(&mut rng, 2.0), random_point(&mut rng, 1.0));
                // Of a length that does not vanish.
                Ray::new(from * scale, to - from, f32::INFINITY).expect("two different points")
            };
            (0..2_000).map(ray).collect()
        };
        let hits = assert_hierarchy_agrees(&mesh, rays);
        assert!(hits > 500, "only {hits} hits at {scale}");
    }
}

#[test]
fn a_hierarchy_takes_no_more_memory_than_its_parts() {
    let bare = sphere()
        .with_removed_attribute(Mesh::ATTRIBUTE_NORMAL)
        .with_removed_attribute(Mesh::ATTRIBUTE_UV_0);
    let bvh = MeshBvh::build(&triangles(&bare));
    let per_triangle = bvh.memory() as f32 / bvh.mesh().len() as f32;
    assert!((40.0..100.0).contains(&per_triangle), "{per_triangle} bytes a triangle");
}

fn compact(mesh: &Mesh) -> MeshBvh {
    let settings = MeshBuildSettings {
        compact: true,
        ..MeshBuildSettings::default()
    };
    MeshBvh::build_with(&triangles(mesh), &settings, None).expect("nothing calls it off")
}

#[test]
fn a_compact_hierarchy_answers_as_any_other() {
    for (seed, mesh) in [
        (70, sphere()),
        (71, list(soup(&mut rng(72), 500))),
        (73, strip(zigzag(50))),
    ] {
        let (mut small, mut large) = (compact(&mesh), MeshBvh::build(&triangles(&mesh)));
        assert_eq!(small.validate(), Ok(()));
        assert_answer_alike_where_hit(seed, &small, &large);
        let moved = twisted(&mesh, 3.0);
        small.refit(&moved);
        large.refit(&moved);
        assert_eq!((small.validate(), small.mesh().aabb()), (Ok(()), large.mesh().aabb()));
        assert_answer_alike_where_hit(seed, &small, &large);
    }
}

/// Towards triangles, that few rays at random hit.
fn assert_answer_alike_where_hit(seed: u64, a: &MeshBvh, b: &MeshBvh) {
    let mut rng = rng(seed);
    for corners in a.mesh().corners_of_all() {
        let target = corners.iter().sum::<Vec3>() / 3.0;
        let origin = target + random_point(&mut rng, 2.0);
        let Some(ray) = Ray::new(origin, target - origin, f32::INFINITY) else {
            continue;
        };
        let hit = a.closest_hit(&ray, Backfaces::Include);
        assert_eq!(bits(hit), bits(b.closest_hit(&ray, Backfaces::Include)), "{ray:?}");
        assert_eq!(a.any_hit(&ray, Backfaces::Include), hit.is_some());
    }
}

#[test]
fn a_compact_hierarchy_takes_less_than_half_the_memory() {
    // Without normals and texture coordinates, which both keep.
    let mut mesh = sphere();
    mesh.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
    mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0);
    let (small, large) = (compact(&mesh), MeshBvh::build(&triangles(&mesh)));
    assert!(
        2 * small.memory() < large.memory(),
        "{} of {}",
        small.memory(),
        large.memory()
    );
}
