//! Hits on the triangles of a mesh, whichever way the mesh stores them.

use bevy::{
    asset::RenderAssetUsages,
    math::{
        Dir3, Vec2, Vec3, Vec3A,
        primitives::{Cuboid, Sphere, Tetrahedron, Torus},
    },
    mesh::{
        Indices, Mesh, MeshBuilder, MeshVertexAttribute, Meshable, PrimitiveTopology, VertexAttributeValues,
        VertexFormat,
    },
    transform::components::Transform,
};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBuildSettings, MeshBvh, TriangleHit, TriangleMesh, UnusableMesh},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

mod hierarchy;

use crate::{
    common::{random_dir, random_point, random_rotation, rng},
    properties::cases,
};

fn mesh(topology: PrimitiveTopology, positions: Vec<Vec3>) -> Mesh {
    Mesh::new(topology, RenderAssetUsages::default()).with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
}

fn list(positions: Vec<Vec3>) -> Mesh {
    mesh(PrimitiveTopology::TriangleList, positions)
}

fn strip(positions: Vec<Vec3>) -> Mesh {
    mesh(PrimitiveTopology::TriangleStrip, positions)
}

fn triangles(mesh: &Mesh) -> TriangleMesh {
    TriangleMesh::from_mesh(mesh).expect("a usable mesh")
}

fn sphere() -> Mesh {
    Sphere::new(1.0).mesh().ico(8).expect("not too fine")
}

/// A band of `n` points that zigzags along x and waves in z, facing +z.
fn zigzag(n: u32) -> Vec<Vec3> {
    (0..n)
        .map(|i| Vec3::new(i as f32 / 2.0, 1.0 - (i % 2) as f32, (i as f32).sin() / 4.0))
        .collect()
}

/// The triangles of a strip of `n` vertices, all facing one way.
fn triangles_of_strip(n: u32) -> Vec<[u32; 3]> {
    (0..n - 2)
        .map(|i| {
            if i % 2 == 0 {
                [i, i + 1, i + 2]
            } else {
                [i + 1, i, i + 2]
            }
        })
        .collect()
}

/// A grid of squares of side 1 in the plane z = 0, facing +z, with a corner at the origin.
fn grid(squares: u32) -> Mesh {
    let side = squares + 1;
    let positions = (0..side * side)
        .map(|i| Vec3::new((i % side) as f32, (i / side) as f32, 0.0))
        .collect();
    let indices = (0..squares * squares).flat_map(|i| {
        let corner = i / squares * side + i % squares;
        [
            corner,
            corner + 1,
            corner + side + 1,
            corner,
            corner + side + 1,
            corner + side,
        ]
    });
    list(positions).with_inserted_indices(Indices::U32(indices.collect()))
}

/// Random triangles in the cube ±10.
fn soup(rng: &mut ChaCha8Rng, n: usize) -> Vec<Vec3> {
    let triangle = |_| {
        let center = random_point(rng, 10.0);
        std::array::from_fn::<_, 3, _>(|_| center + random_point(rng, 2.0))
    };
    (0..n).flat_map(triangle).collect()
}

/// A ray from somewhere around the mesh to a point in its box, half of the time with an end.
fn random_ray(rng: &mut ChaCha8Rng, mesh: &TriangleMesh) -> Ray {
    let (min, max) = (mesh.aabb().min, mesh.aabb().max);
    let target = min + (max - min) * Vec3A::from_array(std::array::from_fn(|_| rng.random_range(0.0..=1.0)));
    let origin = (min + max) / 2.0 + Vec3A::from(*random_dir(rng)) * (max - min).length() * rng.random_range(0.0..2.0);
    let t_max = if rng.random() {
        f32::INFINITY
    } else {
        rng.random_range(0.0..2.0)
    };
    Ray::new(origin, target - origin, t_max).expect("two different points")
}

/// Everything that a hit says of itself, bit for bit.
fn bits(hit: Option<TriangleHit>) -> Option<(u32, u32, [u32; 3])> {
    hit.map(|hit| {
        (
            hit.t.to_bits(),
            hit.triangle,
            hit.barycentrics.to_array().map(f32::to_bits),
        )
    })
}

/// Compares the hierarchy of a mesh with the scan of all triangles, ray by ray; returns how many rays hit.
fn assert_hierarchy_agrees(mesh: &Mesh, rays: impl FnOnce(&TriangleMesh) -> Vec<Ray>) -> usize {
    let scan = triangles(mesh);
    let bvh = MeshBvh::build(&scan);
    let mut hits = 0;
    for (ray, backfaces) in rays(&scan)
        .iter()
        .flat_map(|ray| [(ray, Backfaces::Cull), (ray, Backfaces::Include)])
    {
        let (by_scan, by_bvh) = (scan.closest_hit(ray, backfaces), bvh.closest_hit(ray, backfaces));
        assert_eq!(bits(by_bvh), bits(by_scan), "{ray:?} {backfaces:?}");
        assert_eq!(bvh.any_hit(ray, backfaces), by_scan.is_some(), "{ray:?} {backfaces:?}");
        if let (Some(by_scan), Some(by_bvh)) = (by_scan, by_bvh) {
            assert_eq!(scan.triangle(&by_scan), bvh.mesh().triangle(&by_bvh));
            assert_eq!(scan.normal(&by_scan), bvh.mesh().normal(&by_bvh));
            assert_eq!(scan.uv(&by_scan), bvh.mesh().uv(&by_bvh));
            hits += 1;
        }
    }
    hits
}

fn assert_agrees_on_random_rays(seed: u64, n: usize, mesh: &Mesh) {
    let mut rng = rng(seed);
    let hits = assert_hierarchy_agrees(mesh, |mesh| (0..n).map(|_| random_ray(&mut rng, mesh)).collect());
    assert!(hits > n / 50, "only {hits} of {n} rays hit");
}

/// Asserts that two meshes are hit alike by random rays, triangle numbers and all.
fn assert_hit_alike(a: &Mesh, b: &Mesh) {
    let (a, b) = (triangles(a), triangles(b));
    assert_eq!((a.len(), a.left_out(), a.aabb()), (b.len(), b.left_out(), b.aabb()));
    let mut rng = rng(20);
    let mut hits = 0;
    for _ in 0..2_000 {
        let ray = random_ray(&mut rng, &a);
        for backfaces in [Backfaces::Cull, Backfaces::Include] {
            let hit = a.closest_hit(&ray, backfaces);
            assert_eq!(bits(hit), bits(b.closest_hit(&ray, backfaces)));
            hits += usize::from(hit.is_some());
        }
    }
    assert!(hits > 200, "only {hits} hits");
}

/// The triangle that a ray along -z through the point hits from the front.
fn front_triangle_at(mesh: &TriangleMesh, x: f32, y: f32) -> Option<u32> {
    let ray = Ray::new(Vec3::new(x, y, 10.0), Vec3::NEG_Z, f32::INFINITY).expect("a sound ray");
    mesh.closest_hit(&ray, Backfaces::Cull).map(|hit| hit.triangle)
}

// --- How a mesh stores its triangles ---

#[test]
fn lists_are_hit_alike_with_16_bit_with_32_bit_and_without_indices() {
    let positions = zigzag(30);
    let indices = triangles_of_strip(30);
    let with_u32 = list(positions.clone()).with_inserted_indices(Indices::U32(indices.concat()));
    let narrow = indices.concat().into_iter().map(|i| i as u16).collect();
    let with_u16 = list(positions.clone()).with_inserted_indices(Indices::U16(narrow));
    let without = list(indices.concat().into_iter().map(|i| positions[i as usize]).collect());
    assert_hit_alike(&with_u32, &with_u16);
    assert_hit_alike(&with_u32, &without);
}

#[test]
fn strips_are_hit_as_the_list_of_their_triangles() {
    let positions = zigzag(30);
    let as_list = list(positions.clone()).with_inserted_indices(Indices::U32(triangles_of_strip(30).concat()));
    assert_hit_alike(&as_list, &strip(positions.clone()));
    assert_hit_alike(
        &as_list,
        &strip(positions.clone()).with_inserted_indices(Indices::U16((0..30).collect())),
    );
    assert_hit_alike(
        &as_list,
        &strip(positions).with_inserted_indices(Indices::U32((0..30).collect())),
    );
}

#[test]
fn all_triangles_of_a_strip_face_one_way() {
    let mesh = triangles(&strip(zigzag(10)));
    for i in 0..8 {
        let (x, y) = ((i + 1) as f32 / 2.0, if i % 2 == 0 { 0.6 } else { 0.4 });
        assert_eq!(front_triangle_at(&mesh, x, y), Some(i));
    }
}

#[test]
fn the_largest_index_ends_a_strip_and_begins_a_new_one() {
    // The first strip has an odd number of triangles: the second must begin with the right side up all the same.
    let narrow = Indices::U16(vec![0, 1, 2, 3, 4, u16::MAX, 6, 7, 8, 9]);
    let wide = Indices::U32(vec![0, 1, 2, 3, 4, u32::MAX, 6, 7, 8, 9]);
    for indices in [narrow, wide] {
        let mesh = triangles(&strip(zigzag(10)).with_inserted_indices(indices));
        assert_eq!(mesh.len(), 5);
        let hit = |i: u32| front_triangle_at(&mesh, (i + 1) as f32 / 2.0, if i.is_multiple_of(2) { 0.6 } else { 0.4 });
        assert_eq!([0, 1, 2].map(hit), [Some(0), Some(1), Some(2)]);
        assert_eq!([3, 4, 5].map(hit), [None; 3], "between the strips");
        assert_eq!(
            [6, 7].map(hit),
            [Some(6), Some(7)],
            "numbered by the position of the first index"
        );
    }
}

#[test]
fn the_end_of_a_strip_is_no_triangle_that_was_left_out() {
    let indices = Indices::U16(vec![0, 1, 2, 3, u16::MAX, 4, 5, 6, 7]);
    assert_eq!(
        triangles(&strip(zigzag(8)).with_inserted_indices(indices)).left_out(),
        0
    );
}

#[test]
fn an_incomplete_last_triangle_is_ignored() {
    let mut positions = zigzag(3);
    positions.extend([Vec3::ZERO, Vec3::X]);
    let unindexed = triangles(&list(positions.clone()));
    let indexed = triangles(&list(positions).with_inserted_indices(Indices::U16(vec![0, 1, 2, 2])));
    for mesh in [unindexed, indexed] {
        assert_eq!((mesh.len(), mesh.left_out()), (1, 0));
    }
}

#[test]
fn triangles_with_bad_vertices_are_left_out_and_the_others_keep_their_numbers() {
    let mut positions = zigzag(12);
    positions[1].z = f32::NAN;
    positions[10].x = f32::INFINITY;
    let indices = vec![0, 1, 2, 2, 3, 4, 99, 3, 4, 4, 5, 6, 9, 10, 11];
    let mesh = triangles(&list(positions).with_inserted_indices(Indices::U16(indices)));
    assert_eq!((mesh.len(), mesh.left_out()), (2, 3));
    assert!(mesh.aabb().min.is_finite() && mesh.aabb().max.is_finite());
    assert_eq!(front_triangle_at(&mesh, 0.5, 0.6), None);
    assert_eq!(front_triangle_at(&mesh, 1.5, 0.6), Some(1));
    assert_eq!(front_triangle_at(&mesh, 2.5, 0.6), Some(3));
}

#[test]
fn the_box_is_that_of_the_triangles_and_not_of_stray_vertices() {
    let mut positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    positions.push(Vec3::splat(100.0));
    let mesh = triangles(&list(positions).with_inserted_indices(Indices::U16(vec![0, 1, 2])));
    assert_eq!(
        (mesh.aabb().min, mesh.aabb().max),
        (Vec3A::ZERO, Vec3A::new(1.0, 1.0, 0.0))
    );
}

// --- Meshes without a surface ---

fn refusal(mesh: &Mesh) -> Option<UnusableMesh> {
    TriangleMesh::from_mesh(mesh).err()
}

#[test]
fn lines_and_points_have_no_surface() {
    for topology in [
        PrimitiveTopology::PointList,
        PrimitiveTopology::LineList,
        PrimitiveTopology::LineStrip,
    ] {
        assert_eq!(
            refusal(&mesh(topology, zigzag(6))),
            Some(UnusableMesh::Topology(topology))
        );
    }
}

#[test]
fn a_mesh_needs_positions_of_three_floats() {
    let bare = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    assert_eq!(refusal(&bare), Some(UnusableMesh::NoPositions));

    let flat = MeshVertexAttribute::new("Vertex_Position", 0, VertexFormat::Float32x2);
    assert_eq!(flat.id, Mesh::ATTRIBUTE_POSITION.id);
    let bare = bare.with_inserted_attribute(flat, vec![[0.0_f32; 2]; 3]);
    assert_eq!(
        refusal(&bare),
        Some(UnusableMesh::PositionFormat(VertexFormat::Float32x2))
    );
}

#[test]
fn a_mesh_needs_a_triangle_that_can_be_hit() {
    let nothing = Some(UnusableMesh::NoTriangles);
    assert_eq!(refusal(&list(Vec::new())), nothing);
    assert_eq!(refusal(&list(zigzag(2))), nothing);
    assert_eq!(refusal(&strip(zigzag(2))), nothing);
    assert_eq!(refusal(&list(vec![Vec3::NAN; 3])), nothing);
    assert_eq!(
        refusal(&list(zigzag(3)).with_inserted_indices(Indices::U16(vec![7, 8, 9]))),
        nothing
    );
}

#[test]
fn a_mesh_whose_data_are_on_the_gpu_says_so() {
    let mut mesh = sphere();
    mesh.take_gpu_data().expect("data to take");
    assert_eq!(refusal(&mesh), Some(UnusableMesh::NotInMainWorld));
}

// --- The hierarchy ---

#[test]
fn the_hierarchy_agrees_with_the_scan_on_random_triangles() {
    let soup = soup(&mut rng(30), 1_000);
    assert_agrees_on_random_rays(31, 4_000, &list(soup));
}

#[test]
fn the_hierarchy_agrees_with_the_scan_on_a_sphere() {
    assert_agrees_on_random_rays(32, 4_000, &sphere());
}

#[test]
fn the_hierarchy_agrees_with_the_scan_on_a_torus() {
    assert_agrees_on_random_rays(33, 4_000, &Torus::new(0.5, 2.0).mesh().build());
}

#[test]
fn the_hierarchy_agrees_with_the_scan_whatever_the_size() {
    assert_agrees_on_random_rays(34, 3_000, &sphere().scaled_by(Vec3::splat(1e6)));
    assert_agrees_on_random_rays(35, 3_000, &sphere().scaled_by(Vec3::splat(1e-6)));
    assert_agrees_on_random_rays(
        36,
        3_000,
        &list(soup(&mut rng(37), 300)).scaled_by(Vec3::new(100.0, 1.0, 0.01)),
    );
}

#[test]
fn the_hierarchy_agrees_with_the_scan_from_far_away() {
    let mut rng = rng(44);
    let hits = assert_hierarchy_agrees(&sphere(), |mesh| {
        let from_afar = |_| {
            let near = random_ray(&mut rng, mesh);
            let target = near.at(1.0);
            let origin = target - near.direction() * 10_f32.powi(rng.random_range(2..6));
            Ray::new(origin, target - origin, f32::INFINITY).expect("two different points")
        };
        (0..4_000).map(from_afar).collect()
    });
    assert!(hits > 1_000, "only {hits} hits");
}

#[test]
fn the_hierarchy_agrees_with_the_scan_on_one_triangle() {
    assert_agrees_on_random_rays(38, 1_000, &list(vec![Vec3::ZERO, Vec3::X, Vec3::Y]));
}

#[test]
fn the_hierarchy_agrees_with_the_scan_on_coincident_triangles() {
    let few = soup(&mut rng(39), 7);
    let mesh = list(few.iter().copied().cycle().take(few.len() * 20).collect());
    assert_agrees_on_random_rays(40, 1_000, &mesh);
}

#[test]
fn the_hierarchy_agrees_with_the_scan_among_degenerate_triangles() {
    let mut rng = rng(41);
    let mut positions = soup(&mut rng, 300);
    for triangle in positions.chunks_exact_mut(3).step_by(2) {
        // A point, a needle, or a line of three points.
        match rng.random_range(0..3) {
            0 => triangle.fill(Vec3::splat(rng.random_range(-5.0..5.0))),
            1 => triangle[1] = triangle[2],
            _ => triangle[1] = (triangle[0] + triangle[2]) / 2.0,
        }
    }
    assert_agrees_on_random_rays(42, 3_000, &list(positions));
}

#[test]
fn rays_at_shared_vertices_and_edges_hit_and_the_hierarchy_agrees_with_the_scan() {
    let mesh = grid(8);
    let rays = |_: &TriangleMesh| {
        // Every vertex and every middle of an edge or diagonal inside the grid, from several sides.
        let targets = (1..16).flat_map(|x| (1..16).map(move |y| Vec3::new(x as f32 / 2.0, y as f32 / 2.0, 0.0)));
        let origins = [
            Vec3::Z,
            Vec3::new(1.0, 0.0, 1.0),
            Vec3::new(-0.5, 2.0, 4.0),
            Vec3::new(0.3, 0.7, 1.1),
        ];
        let rays = targets.flat_map(|target| origins.map(|from| Ray::new(target + from, -from, f32::INFINITY)));
        rays.map(|ray| ray.expect("a sound ray")).collect()
    };
    let hits = assert_hierarchy_agrees(&mesh, rays);
    assert_eq!(hits, 2 * 15 * 15 * 4, "no ray slips through");
}

/// A closed mesh at any scale, stretched, turned and moved, and a point inside it.
fn closed_mesh(rng: &mut ChaCha8Rng) -> (TriangleMesh, Vec3A) {
    let mut mesh: Mesh = match rng.random_range(0..3) {
        0 => Cuboid::default().into(),
        1 => Tetrahedron::default().into(),
        _ => Sphere::default().mesh().ico(4).expect("few enough triangles"),
    };
    let scale = 10.0_f32.powi(rng.random_range(-6..7));
    let center = random_point(rng, 5.0) * scale;
    let place = Transform {
        translation: center,
        rotation: random_rotation(rng),
        scale: Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.3..3.0))) * scale,
    };
    mesh.transform_by(place);
    (triangles(&mesh), center.into())
}

#[test]
fn no_ray_at_an_edge_or_a_vertex_of_a_closed_mesh_slips_through() {
    let mut rng = rng(44);
    let rays = cases().cases * 100;
    let (mut cast, mut missed) = (0, 0);
    while cast < rays {
        let (mesh, inside) = closed_mesh(&mut rng);
        let bvh = MeshBvh::build(&mesh);
        let corners: Vec<[Vec3A; 3]> = mesh.corners_of_all().map(|corners| corners.map(Vec3A::from)).collect();
        for _ in 0..1000 {
            let [a, b, _] = corners[rng.random_range(0..corners.len())];
            let along = [0.0, 1.0, 0.5, rng.random_range(0.0..1.0)][rng.random_range(0..4)];
            let direction = a + (b - a) * along - inside;
            let ray = Ray::new(inside, direction * rng.random_range(0.1..10.0), f32::INFINITY).expect("not the center");
            let hit = bvh.closest_hit(&ray, Backfaces::Include);
            missed += u32::from(hit.is_none() || !bvh.any_hit(&ray, Backfaces::Include));
            cast += 1;
        }
    }
    assert_eq!(missed, 0, "of {cast}");
}

#[test]
fn of_triangles_at_one_distance_the_first_is_hit() {
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = triangles(&list([one; 9].concat()));
    let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z, f32::INFINITY).expect("a sound ray");
    assert_eq!(mesh.closest_hit(&ray, Backfaces::Cull).map(|hit| hit.triangle), Some(0));
    assert_eq!(
        MeshBvh::build(&mesh)
            .closest_hit(&ray, Backfaces::Cull)
            .map(|hit| hit.triangle),
        Some(0)
    );
}

#[test]
fn from_inside_a_closed_mesh_only_back_faces_are_seen() {
    let bvh = MeshBvh::build(&triangles(&sphere()));
    let mut rng = rng(43);
    for _ in 0..200 {
        let ray = Ray::new(random_point(&mut rng, 0.4), *random_dir(&mut rng), f32::INFINITY).expect("a sound ray");
        assert_eq!(bvh.closest_hit(&ray, Backfaces::Cull), None);
        assert!(!bvh.any_hit(&ray, Backfaces::Cull));
        assert!(bvh.closest_hit(&ray, Backfaces::Include).is_some());
        assert!(bvh.any_hit(&ray, Backfaces::Include));
    }
}

// --- What is known of a hit ---

/// The hits of rays that come at the unit sphere from all sides, each with the side.
fn hits_on_sphere(bvh: &MeshBvh) -> Vec<(Dir3, TriangleHit)> {
    let mut rng = rng(50);
    let hit = |_| {
        let out = random_dir(&mut rng);
        let ray = Ray::new(*out * 3.0, -*out, f32::INFINITY).expect("a sound ray");
        (
            out,
            bvh.closest_hit(&ray, Backfaces::Cull)
                .expect("the sphere is in the way"),
        )
    };
    (0..500).map(hit).collect()
}

#[test]
fn the_weights_of_a_hit_give_its_place() {
    let bvh = MeshBvh::build(&triangles(&sphere()));
    for (out, hit) in hits_on_sphere(&bvh) {
        let [a, b, c] = bvh.mesh().triangle(&hit);
        let place = a * hit.barycentrics.x + b * hit.barycentrics.y + c * hit.barycentrics.z;
        assert!((place - out * (3.0 - hit.t)).length() < 1e-5);
        assert!((hit.barycentrics.element_sum() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn normals_are_interpolated() {
    let bvh = MeshBvh::build(&triangles(&sphere()));
    for (out, hit) in hits_on_sphere(&bvh) {
        assert!(bvh.mesh().normal(&hit).normalize().dot(*out) > 0.99999);
    }
}

#[test]
fn without_normals_that_of_the_triangle_is_given() {
    let bare = triangles(&sphere().with_removed_attribute(Mesh::ATTRIBUTE_NORMAL));
    let bvh = MeshBvh::build(&bare);
    for (out, hit) in hits_on_sphere(&bvh) {
        let [a, b, c] = bvh.mesh().triangle(&hit);
        let expected = (b - a).cross(c - a).normalize();
        assert!(bvh.mesh().normal(&hit).normalize().dot(expected) > 0.99999);
        assert!(expected.dot(*out) > 0.9);
    }
}

#[test]
fn useless_normals_are_replaced_by_that_of_the_triangle() {
    for useless in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
        let mesh = list(vec![Vec3::ZERO, Vec3::X, Vec3::Y]);
        let mesh = triangles(&mesh.with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![useless; 3]));
        let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z, f32::INFINITY).expect("a sound ray");
        let hit = mesh
            .closest_hit(&ray, Backfaces::Cull)
            .expect("the triangle is in the way");
        assert_eq!(mesh.normal(&hit).normalize(), Vec3::Z);
    }
}

#[test]
fn texture_coordinates_are_interpolated() {
    let mesh = grid(4);
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("a grid has positions");
    };
    let uvs: Vec<[f32; 2]> = positions.iter().map(|p| [p[0] / 4.0, 1.0 - p[1] / 4.0]).collect();
    let mesh = triangles(&mesh.with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs));
    let mut rng = rng(51);
    for _ in 0..200 {
        let at = Vec2::new(rng.random_range(0.0..4.0), rng.random_range(0.0..4.0));
        let ray = Ray::new(at.extend(1.0), Vec3::NEG_Z, f32::INFINITY).expect("a sound ray");
        let hit = mesh.closest_hit(&ray, Backfaces::Cull).expect("the grid is in the way");
        let uv = mesh.uv(&hit).expect("the grid has texture coordinates");
        assert!(uv.distance(Vec2::new(at.x / 4.0, 1.0 - at.y / 4.0)) < 1e-6);
    }
}

#[test]
fn without_texture_coordinates_none_are_given() {
    let mesh = triangles(&sphere().with_removed_attribute(Mesh::ATTRIBUTE_UV_0));
    let ray = Ray::new(Vec3::Z * 3.0, Vec3::NEG_Z, f32::INFINITY).expect("a sound ray");
    let hit = mesh
        .closest_hit(&ray, Backfaces::Cull)
        .expect("the sphere is in the way");
    assert_eq!(mesh.uv(&hit), None);
}
