//! Boxes inside of solid meshes: each is held against every triangle, and its centre counted inside, in the plainest
//! way.

use bevy::{
    asset::RenderAssetUsages,
    math::{DVec3, bounding::Aabb3d},
    mesh::{Mesh, PrimitiveTopology},
    prelude::*,
};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{InnerBoxSettings, InnerBoxes, MeshBvh, NotSolid, TriangleMesh},
    spatial::BuildProgress,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

type Triangles = Vec<[Vec3; 3]>;

// --- Meshes ---

fn triangles_of(mesh: impl Into<Mesh>) -> Triangles {
    let mesh = TriangleMesh::from_mesh(&mesh.into()).expect("a usable mesh");
    mesh.corners_of_all().collect()
}

fn mesh_of(triangles: &[[Vec3; 3]]) -> TriangleMesh {
    let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    TriangleMesh::from_mesh(&mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)).expect("a usable mesh")
}

fn cuboid(min: Vec3, max: Vec3) -> Triangles {
    let cuboid = triangles_of(Cuboid::from_size(max - min));
    // From the corners, so that walls that share a coordinate share it to the last bit.
    moved(&cuboid, |corner| Vec3::select(corner.cmplt(Vec3::ZERO), min, max))
}

fn moved(triangles: &[[Vec3; 3]], place: impl Fn(Vec3) -> Vec3) -> Triangles {
    triangles.iter().map(|corners| corners.map(&place)).collect()
}

fn inverted(triangles: &[[Vec3; 3]]) -> Triangles {
    triangles.iter().map(|&[a, b, c]| [b, a, c]).collect()
}

/// Unit cubes side by side, without the faces between them.
fn cubes(places: &[IVec3]) -> Triangles {
    let mut triangles = Vec::new();
    for &place in places {
        for [a, b, c] in cuboid(place.as_vec3(), place.as_vec3() + 1.0) {
            let outward = (b - a).cross(c - a).normalize().round().as_ivec3();
            if !places.contains(&(place + outward)) {
                triangles.push([a, b, c]);
            }
        }
    }
    triangles
}

fn ball(subdivisions: u32) -> Triangles {
    triangles_of(Sphere::new(1.0).mesh().ico(subdivisions).expect("few faces"))
}

/// A ball with bumps and dents.
fn potato(rng: &mut ChaCha8Rng) -> Triangles {
    let waves: [Vec3; 4] = std::array::from_fn(|_| random_point(rng, 4.0));
    let radius = |corner: Vec3| 1.0 + 0.15 * waves.iter().map(|wave| wave.dot(corner).sin()).sum::<f32>();
    moved(&ball(6), |corner| corner * radius(corner))
}

// --- Oracles ---

fn find(triangles: &[[Vec3; 3]]) -> Result<Vec<Aabb3d>, NotSolid> {
    InnerBoxes::find(&mesh_of(triangles), &InnerBoxSettings::default()).map(|found| found.boxes)
}

fn why_not(triangles: &[[Vec3; 3]]) -> NotSolid {
    find(triangles).expect_err("no solid")
}

/// The boxes inside, each of which is.
fn inside(triangles: &[[Vec3; 3]]) -> Vec<Aabb3d> {
    let boxes = find(triangles).expect("a solid");
    assert!(!boxes.is_empty());
    assert_inside(triangles, &boxes);
    boxes
}

/// The boxes inside of a mesh of several solids, each of which is inside of one of them.
fn inside_of_parts(parts: &[Triangles]) -> Vec<Aabb3d> {
    let boxes = find(&parts.concat()).expect("a solid");
    for aabb in &boxes {
        let is_apart_from = |part: &Triangles| part.iter().all(|&corners| is_apart(aabb, corners));
        let is_in = |part: &&Triangles| is_apart_from(part) && winding(part, center(aabb)) > 0;
        let around = parts.iter().find(is_in).expect("a part around the box");
        assert_inside(around, &[*aabb]);
    }
    boxes
}

fn center(aabb: &Aabb3d) -> DVec3 {
    (aabb.min.as_dvec3() + aabb.max.as_dvec3()) / 2.0
}

/// How often the triangles go around a point.
fn winding(triangles: &[[Vec3; 3]], point: DVec3) -> i32 {
    let ways = [
        // Not through edges of what is in proportion.
        DVec3::new(0.313, 0.557, 0.891),
        DVec3::new(-0.719, 0.117, 0.231),
        DVec3::new(0.053, -0.919, -0.417),
    ];
    let along = |towards: DVec3| {
        triangles
            .iter()
            .map(|&corners| exit(corners, point, towards))
            .sum::<i32>()
    };
    let windings = ways.map(along);
    assert_eq!(windings, [windings[0]; 3], "a ray has met an edge, or the mesh is open");
    windings[0]
}

fn assert_inside(triangles: &[[Vec3; 3]], boxes: &[Aabb3d]) {
    for aabb in boxes {
        assert!(aabb.min.cmplt(aabb.max).all(), "{aabb:?} is empty");
        for &corners in triangles {
            assert!(is_apart(aabb, corners), "{aabb:?} meets {corners:?}");
        }
        assert!(winding(triangles, center(aabb)) > 0, "{aabb:?} is outside");
    }
}

/// Whether a plane separates a box from a triangle.
fn is_apart(aabb: &Aabb3d, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let edges = [b - a, c - b, a - c];
    let crossed = DVec3::AXES.map(|axis| edges.map(|edge| axis.cross(edge)));
    let axes = DVec3::AXES
        .into_iter()
        .chain([edges[0].cross(edges[1])])
        .chain(crossed.into_iter().flatten());
    axes.into_iter().any(|axis| {
        let (low, high) = (axis * aabb.min.as_dvec3(), axis * aabb.max.as_dvec3());
        let (box_min, box_max) = (low.min(high).element_sum(), low.max(high).element_sum());
        let of_corners = [a, b, c].map(|corner| axis.dot(corner));
        let min = of_corners.into_iter().fold(f64::INFINITY, f64::min);
        let max = of_corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
        box_max < min || max < box_min
    })
}

/// 1 if the ray goes out through the triangle, -1 if it comes in.
fn exit(corners: [Vec3; 3], origin: DVec3, towards: DVec3) -> i32 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - origin);
    let (u, v, w) = (
        towards.dot(b.cross(c)),
        towards.dot(c.cross(a)),
        towards.dot(a.cross(b)),
    );
    let same_side = (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
    let normal = (b - a).cross(c - a);
    let is_ahead = normal.dot(a) * normal.dot(towards) > 0.0;
    if same_side && is_ahead {
        normal.dot(towards).signum() as i32
    } else {
        0
    }
}

/// The volume of what is in any of the boxes.
fn union_volume(boxes: &[Aabb3d]) -> f64 {
    let cuts = [0, 1, 2].map(|axis| {
        let mut cuts: Vec<f64> = (boxes.iter())
            .flat_map(|aabb| [f64::from(aabb.min[axis]), f64::from(aabb.max[axis])])
            .collect();
        cuts.sort_by(f64::total_cmp);
        cuts
    });
    let mut volume = 0.0;
    for x in cuts[0].windows(2) {
        for y in cuts[1].windows(2) {
            for z in cuts[2].windows(2) {
                let min = DVec3::new(x[0], y[0], z[0]);
                let size = DVec3::new(x[1], y[1], z[1]) - min;
                let center = min + size / 2.0;
                let is_in =
                    |aabb: &Aabb3d| aabb.min.as_dvec3().cmple(center).all() && center.cmple(aabb.max.as_dvec3()).all();
                if boxes.iter().any(is_in) {
                    volume += size.element_product();
                }
            }
        }
    }
    volume
}

/// The volume that triangles enclose.
fn volume(triangles: &[[Vec3; 3]]) -> f64 {
    let of_cone = |corners: &[Vec3; 3]| {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        a.dot(b.cross(c)) / 6.0
    };
    triangles.iter().map(of_cone).sum()
}

/// How much of a solid is in boxes inside of it.
fn coverage(triangles: &[[Vec3; 3]]) -> f64 {
    union_volume(&inside(triangles)) / volume(triangles)
}

// --- How much is found ---

#[test]
fn a_cuboid_gets_one_box_that_nearly_fills_it() {
    for size in [Vec3::ONE, Vec3::new(0.2, 3.0, 1.0), Vec3::new(40.0, 0.01, 0.3)] {
        let cuboid = triangles_of(Cuboid::from_size(size));
        let boxes = inside(&cuboid);
        assert_eq!(boxes.len(), 1, "{boxes:?}");
        let gap = (Vec3::from(boxes[0].max) - size / 2.0)
            .abs()
            .max((Vec3::from(boxes[0].min) + size / 2.0).abs());
        assert!((gap / size).max_element() <= 1e-3, "{gap} of {size}");
        assert!(coverage(&cuboid) >= 0.99);
    }
}

#[test]
fn half_of_a_ball_is_found_in_eight_boxes() {
    let boxes = inside(&ball(12));
    assert!(boxes.len() <= 8);
    assert!(coverage(&ball(12)) >= 0.5, "{}", coverage(&ball(12)));
}

#[test]
fn nearly_all_of_a_thin_wall_is_found() {
    let wall = cuboid(Vec3::new(-5.0, 0.0, 0.0), Vec3::new(5.0, 3.0, 0.02));
    assert!(coverage(&wall) >= 0.9);
}

#[test]
fn the_arms_of_angular_shapes_are_found() {
    let l = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 2, 0]].map(IVec3::from);
    let u = [
        [0, 0, 0],
        [1, 0, 0],
        [2, 0, 0],
        [0, 1, 0],
        [0, 2, 0],
        [2, 1, 0],
        [2, 2, 0],
    ]
    .map(IVec3::from);
    for (shape, arms) in [(cubes(&l), 2), (cubes(&u), 3)] {
        assert!(inside(&shape).len() <= arms);
        assert!(coverage(&shape) >= 0.99, "{}", coverage(&shape));
    }
}

#[test]
fn the_walls_of_a_house_of_overlapping_parts_are_found() {
    let (min, max) = (Vec3::new(-5.0, 0.0, -4.0), Vec3::new(5.0, 3.0, 4.0));
    let walls = [0, 2].into_iter().flat_map(|axis| {
        let (mut near, mut far) = (max, min);
        (near[axis], far[axis]) = (min[axis] + 0.1, max[axis] - 0.1);
        [cuboid(min, near), cuboid(far, max)]
    });
    let floors = [0.0, 2.9].map(|y| cuboid(Vec3::new(-6.0, y, -5.0), Vec3::new(6.0, y + 0.1, 5.0)));
    let parts: Vec<Triangles> = walls.chain(floors).collect();
    let boxes = inside_of_parts(&parts);
    assert_eq!(boxes.len(), 6, "{boxes:?}");
    let whole = 2.0 * 0.1 * 12.0 * 10.0 + 2.8 * (10.0 * 8.0 - 9.8 * 7.8);
    assert!(
        union_volume(&boxes) >= 0.99 * whole,
        "{} of {whole}",
        union_volume(&boxes)
    );
}

#[test]
fn a_room_in_a_solid_stays_empty() {
    let room = inverted(&cuboid(Vec3::splat(-0.9), Vec3::splat(0.9)));
    let hollow: Triangles = cuboid(Vec3::NEG_ONE, Vec3::ONE).into_iter().chain(room).collect();
    assert!(inside(&hollow).len() >= 6);
    assert!(coverage(&hollow) >= 0.9, "{}", coverage(&hollow));
}

#[test]
fn solids_that_overlap_hide_each_as_a_whole() {
    let parts = [
        cuboid(Vec3::ZERO, Vec3::ONE),
        cuboid(Vec3::splat(0.5), Vec3::splat(1.5)),
    ];
    let boxes = inside_of_parts(&parts);
    assert_eq!(boxes.len(), 2, "{boxes:?}");
    assert!(union_volume(&boxes) >= 0.99 * 1.875);
}

#[test]
fn what_is_in_the_box_of_another_part_adds_nothing() {
    let core = cuboid(Vec3::NEG_ONE, Vec3::ONE);
    let within = (0..50).map(|i| cuboid(Vec3::splat(-0.01 * i as f32), Vec3::splat(0.5)));
    let parts: Vec<Triangles> = within.skip(1).chain([core]).collect();
    assert_eq!(inside_of_parts(&parts).len(), 1);
}

#[test]
fn the_primitives_of_bevy_are_solid() {
    let solids: [(&str, Mesh, f64); 9] = [
        ("ball", Sphere::new(1.0).mesh().uv(32, 18), 0.5),
        ("capsule", Capsule3d::new(0.5, 1.0).into(), 0.5),
        ("cylinder", Cylinder::new(0.5, 1.0).into(), 0.7),
        ("cone", Cone::new(0.5, 1.0).into(), 0.3),
        (
            "frustum",
            ConicalFrustum {
                radius_top: 0.3,
                radius_bottom: 0.6,
                height: 1.0,
            }
            .into(),
            0.5,
        ),
        ("torus", Torus::new(0.5, 1.0).into(), 0.3),
        ("tetrahedron", Tetrahedron::default().into(), 0.2),
        ("prism", Extrusion::new(RegularPolygon::new(1.0, 6), 2.0).into(), 0.6),
        (
            "turned",
            Mesh::from(Cuboid::default()).rotated_by(Quat::from_rotation_y(0.5)),
            0.6,
        ),
    ];
    for (name, mesh, least) in solids {
        let found = coverage(&triangles_of(mesh));
        assert!(found >= least, "{name}: {found}");
    }
}

// --- Nothing but what is inside ---

#[test]
fn boxes_are_inside_of_random_solids_of_any_size_anywhere() {
    let mut rng = rng(1);
    for round in 0..40 {
        let parts = match round % 4 {
            0 => vec![potato(&mut rng)],
            1 => {
                let all = (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9));
                let some: Vec<IVec3> = all.filter(|_| rng.random_bool(0.5)).collect();
                vec![cubes(&some)]
            }
            2 => (0..5)
                .map(|_| {
                    let (center, size) = (random_point(&mut rng, 1.0), random_point(&mut rng, 0.5).abs() + 0.1);
                    let rotation = random_rotation(&mut rng);
                    moved(&triangles_of(Cuboid::from_size(2.0 * size)), |corner| {
                        center + rotation * corner
                    })
                })
                .collect(),
            _ => vec![triangles_of(Torus::new(0.3, 1.0))],
        };
        let scale = 10f32.powf(rng.random_range(-3.0..3.0));
        let (rotation, offset) = (random_rotation(&mut rng), random_point(&mut rng, 3.0));
        let moved =
            |place: &dyn Fn(Vec3) -> Vec3| -> Vec<Triangles> { parts.iter().map(|part| moved(part, place)).collect() };
        assert!(!inside_of_parts(&moved(&|corner| scale * corner)).is_empty());
        inside_of_parts(&moved(&|corner| scale * (rotation * corner + offset)));
    }
}

#[test]
fn boxes_are_inside_of_what_passes_through_itself() {
    // The tube is wider than the hole.
    inside(&triangles_of(Torus {
        minor_radius: 1.0,
        major_radius: 0.6,
    }));
    let mut rng = rng(4);
    for _ in 0..10 {
        let waves: [[Vec3; 2]; 4] = std::array::from_fn(|_| [random_point(&mut rng, 5.0), random_point(&mut rng, 0.6)]);
        let offset = |corner: Vec3| {
            waves
                .iter()
                .map(|[wave, way]| way * wave.dot(corner).sin())
                .sum::<Vec3>()
        };
        let crumpled = moved(&ball(6), |corner| corner + offset(corner));
        match find(&crumpled) {
            Ok(boxes) => assert_inside(&crumpled, &boxes),
            Err(why) => assert!(matches!(why, NotSolid::NoRoom | NotSolid::InsideOut), "{why}"),
        }
    }
    let twisted = moved(&cuboid(Vec3::splat(-1.0), Vec3::ONE), |corner| {
        if corner == Vec3::ONE { Vec3::splat(-1.5) } else { corner }
    });
    if let Ok(boxes) = find(&twisted) {
        assert_inside(&twisted, &boxes);
    }
}

#[test]
fn boxes_are_inside_of_turned_thin_walls() {
    let mut rng = rng(2);
    for _ in 0..10 {
        let (rotation, thickness) = (random_rotation(&mut rng), rng.random_range(0.01..0.3));
        let wall = moved(&triangles_of(Cuboid::new(4.0, 3.0, thickness)), |corner| {
            rotation * corner
        });
        match find(&wall) {
            Ok(boxes) => assert_inside(&wall, &boxes),
            Err(why) => assert_eq!(why, NotSolid::NoRoom),
        }
    }
}

#[test]
fn two_solids_in_one_mesh_leave_what_is_between_them() {
    let pair = [-2.0, 2.0].map(|x| cuboid(Vec3::new(x - 1.0, -1.0, -1.0), Vec3::new(x + 1.0, 1.0, 1.0)));
    assert_eq!(inside_of_parts(&pair).len(), 2);
}

#[test]
fn faces_that_are_there_twice_enclose_the_same() {
    let cube = cuboid(Vec3::ZERO, Vec3::ONE);
    assert_eq!(inside(&[cube.clone(), cube.clone()].concat()), inside(&cube));
}

// --- What is not solid ---

#[test]
fn open_meshes_have_no_inside() {
    let cube = triangles_of(Cuboid::default());
    assert_eq!(why_not(&cube[..11]), NotSolid::Open { edges: 3 });
    assert_eq!(why_not(&cube[..1]), NotSolid::Open { edges: 3 });
    assert!(matches!(
        why_not(&triangles_of(Plane3d::default())),
        NotSolid::Open { .. }
    ));
    // A box with one face turned over.
    let mut turned = cube;
    turned[0].swap(0, 1);
    assert_eq!(why_not(&turned), NotSolid::Open { edges: 3 });
}

#[test]
fn a_triangle_that_is_nan_leaves_a_hole() {
    let mut cube = triangles_of(Cuboid::default());
    cube[3][1].y = f32::NAN;
    assert_eq!(why_not(&cube), NotSolid::Open { edges: 3 });
}

#[test]
fn meshes_that_face_inward_are_inside_out() {
    assert_eq!(
        why_not(&inverted(&triangles_of(Cuboid::default()))),
        NotSolid::InsideOut
    );
    assert_eq!(why_not(&inverted(&ball(4))), NotSolid::InsideOut);
}

#[test]
fn flat_meshes_have_no_room() {
    let quad = triangles_of(Rectangle::new(1.0, 1.0));
    assert_eq!(why_not(&[quad.clone(), inverted(&quad)].concat()), NotSolid::NoRoom);
    let sail = vec![[Vec3::ZERO, Vec3::new(1.0, 0.3, 0.2), Vec3::new(0.1, 1.0, 0.7)]];
    assert_eq!(why_not(&[sail.clone(), inverted(&sail)].concat()), NotSolid::NoRoom);
    assert_eq!(why_not(&[[Vec3::ONE; 3]]), NotSolid::NoRoom);
}

#[test]
fn numbers_at_the_end_of_the_range_do_no_harm() {
    for scale in [1e-40, 1e-20, 1e20, 3e38] {
        if let Ok(boxes) = find(&moved(&triangles_of(Cuboid::default()), |corner| corner * scale)) {
            assert!(boxes.iter().all(|aabb| aabb.min.is_finite() && aabb.max.is_finite()));
        }
    }
}

// --- What it is for ---

#[test]
fn what_a_box_hides_from_outside_a_front_face_hides() {
    let mut rng = rng(3);
    for round in 0..12 {
        let parts: Vec<Triangles> = match round % 3 {
            0 => vec![potato(&mut rng)],
            1 => vec![
                cuboid(Vec3::NEG_ONE, Vec3::ONE),
                inverted(&cuboid(Vec3::splat(-0.8), Vec3::splat(0.8))),
            ],
            _ => (0..6)
                .map(|_| {
                    let (center, size) = (random_point(&mut rng, 1.0), random_point(&mut rng, 0.6).abs() + 0.1);
                    cuboid(center - size, center + size)
                })
                .collect(),
        };
        let triangles = parts.concat();
        let boxes = find(&triangles).expect("a solid");
        let bvh = MeshBvh::build(&mesh_of(&triangles));
        let mut rays = 0;
        while rays < 300 {
            let eye = random_point(&mut rng, 2.0);
            if winding(&triangles, eye.as_dvec3()) != 0 {
                continue;
            }
            let aabb = boxes[rng.random_range(0..boxes.len())];
            let weights = Vec3A::from(random_point(&mut rng, 0.5)) + 0.5;
            let target = Vec3::from(aabb.min + (aabb.max - aabb.min) * weights);
            let ray = Ray::from_ray3d(ray_towards(eye, target), eye.distance(target)).expect("a finite ray");
            assert!(
                bvh.closest_hit(&ray, Backfaces::Cull).is_some(),
                "{aabb:?} is seen from {eye}"
            );
            rays += 1;
        }
    }
}

// --- Settings ---

#[test]
fn no_more_boxes_are_found_than_asked_for() {
    let mesh = mesh_of(&ball(6));
    for max_boxes in 1..4 {
        let settings = InnerBoxSettings {
            max_boxes,
            least_gain: 0.0,
            ..default()
        };
        assert_eq!(
            InnerBoxes::find(&mesh, &settings).expect("a solid").boxes.len(),
            max_boxes
        );
    }
}

#[test]
fn a_search_that_is_called_off_finds_nothing() {
    let progress = BuildProgress::default();
    progress.cancel();
    assert_eq!(
        InnerBoxes::find_with(&mesh_of(&ball(6)), &InnerBoxSettings::default(), Some(&progress)),
        None
    );
}
