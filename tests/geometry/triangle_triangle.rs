use bevy::math::{DVec3, Vec3, primitives::Triangle3d};
use bevy_sightline::geometry::{
    intersection::Intersects,
    triangle_triangle::{TriangleContact, contact, intersect_by_edges, intersect_by_intervals},
};
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};
use proptest::prelude::*;

use super::triangle_triangle_oracle::{common_points_of, common_points_on_lattice, to_rational};

type Triangle = [DVec3; 3];

fn triangle(vertices: [[f64; 3]; 3]) -> Triangle {
    vertices.map(DVec3::from_array)
}

/// The answer of both tests and of the contact, which must be one.
fn intersect(a: Triangle, b: Triangle) -> bool {
    let answer = intersect_by_intervals(a, b);
    assert_eq!(intersect_by_edges(a, b), answer, "by edges, {a:?} {b:?}");
    assert_eq!(contact(a, b).is_some(), answer, "contact, {a:?} {b:?}");
    answer
}

/// The right triangle in the plane z = 0 with legs of 4.
const FLOOR: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

fn meets_floor(vertices: [[f64; 3]; 3]) -> Option<TriangleContact> {
    let (a, b) = (triangle(FLOOR), triangle(vertices));
    intersect(a, b);
    contact(a, b)
}

fn point(x: f64, y: f64, z: f64) -> Option<TriangleContact> {
    Some(TriangleContact::Point(DVec3::new(x, y, z)))
}

/// The contact with its points in order of their coordinates.
fn sorted(contact: Option<TriangleContact>) -> Vec<[f64; 3]> {
    let mut points: Vec<_> = contact
        .iter()
        .flat_map(TriangleContact::points)
        .map(DVec3::to_array)
        .collect();
    points.sort_by(|p, q| p.partial_cmp(q).expect("numbers"));
    points
}

#[test]
fn a_triangle_through_another_shares_a_segment() {
    let wall = meets_floor([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 9.0, 0.0]]);
    assert!(matches!(wall, Some(TriangleContact::Segment(_))));
    assert_eq!(sorted(wall), [[1.0, 1.0, 0.0], [1.0, 3.0, 0.0]]);
}

#[test]
fn a_triangle_over_another_is_apart() {
    assert_eq!(
        meets_floor([[0.0, 0.0, 1e-300], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]]),
        None
    );
}

#[test]
fn triangles_that_straddle_each_others_planes_may_be_apart() {
    assert_eq!(meets_floor([[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [3.0, 9.0, 0.0]]), None);
}

#[test]
fn a_vertex_on_a_face_is_a_point() {
    assert_eq!(
        meets_floor([[1.0, 1.0, 0.0], [1.0, 1.0, 3.0], [2.0, 1.0, 3.0]]),
        point(1.0, 1.0, 0.0)
    );
}

#[test]
fn a_vertex_on_an_edge_is_a_point() {
    assert_eq!(
        meets_floor([[2.0, 2.0, 0.0], [2.0, 2.0, 3.0], [3.0, 2.0, 3.0]]),
        point(2.0, 2.0, 0.0)
    );
}

#[test]
fn a_vertex_on_a_vertex_is_a_point() {
    assert_eq!(
        meets_floor([[4.0, 0.0, 0.0], [5.0, 0.0, 1.0], [5.0, 1.0, 1.0]]),
        point(4.0, 0.0, 0.0)
    );
    assert_eq!(
        meets_floor([[4.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0]]),
        point(4.0, 0.0, 0.0)
    );
}

#[test]
fn edges_that_cross_in_a_point_are_a_point() {
    assert_eq!(
        meets_floor([[2.0, 0.0, 1.0], [2.0, 0.0, -1.0], [2.0, -5.0, 0.0]]),
        point(2.0, 0.0, 0.0)
    );
}

#[test]
fn edges_that_overlap_share_a_segment() {
    let standing = meets_floor([[1.0, 0.0, 0.0], [6.0, 0.0, 0.0], [2.0, 0.0, 3.0]]);
    assert_eq!(sorted(standing), [[1.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    let beside = meets_floor([[1.0, 0.0, 0.0], [6.0, 0.0, 0.0], [2.0, -3.0, 0.0]]);
    assert_eq!(sorted(beside), [[1.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
}

#[test]
fn collinear_edges_that_do_not_overlap_are_apart() {
    assert_eq!(meets_floor([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 0.0, 3.0]]), None);
    assert_eq!(meets_floor([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, -3.0, 0.0]]), None);
}

#[test]
fn identical_triangles_share_themselves() {
    let mut corners = FLOOR;
    corners.sort_by(|p, q| p.partial_cmp(q).expect("numbers"));
    assert_eq!(sorted(meets_floor(FLOOR)), corners);
}

#[test]
fn coplanar_triangles_share_a_polygon_with_up_to_six_corners() {
    let (a, b) = (
        triangle([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [3.0, 6.0, 0.0]]),
        triangle([[0.0, 4.0, 0.0], [6.0, 4.0, 0.0], [3.0, -2.0, 0.0]]),
    );
    assert!(intersect(a, b));
    let Some(TriangleContact::Polygon(corners)) = contact(a, b) else {
        panic!("no polygon");
    };
    assert_eq!(corners.len(), 6);
    let turns = |i: usize| {
        let [p, q, r] = [0, 1, 2].map(|k| corners[(i + k) % 6]);
        (q - p).cross(r - q).z
    };
    assert!(
        (0..6).all(|i| turns(i) * turns(0) > 0.0),
        "not convex in order: {corners:?}"
    );
}

#[test]
fn a_triangle_within_another_is_the_polygon() {
    let inner = [[1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [2.0, 1.0, 0.0]];
    assert_eq!(sorted(meets_floor(inner)), inner);
}

#[test]
fn a_segment_pierces_a_triangle_in_a_point() {
    let (below, above) = ([1.0, 1.0, -1.0], [1.0, 1.0, 1.0]);
    assert_eq!(meets_floor([below, above, above]), point(1.0, 1.0, 0.0));
    assert_eq!(meets_floor([below, [1.0, 1.0, 0.5], above]), point(1.0, 1.0, 0.0));
}

#[test]
fn a_segment_in_the_plane_of_a_triangle_is_clipped() {
    let (left, right) = ([-1.0, 1.0, 0.0], [9.0, 1.0, 0.0]);
    assert_eq!(
        sorted(meets_floor([left, left, right])),
        [[0.0, 1.0, 0.0], [3.0, 1.0, 0.0]]
    );
}

#[test]
fn segments_meet_where_they_cross_and_not_where_they_are_skew() {
    let along_x = triangle([[0.0; 3], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    let crossing = triangle([[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    let skew = triangle([[1.0, -1.0, 1e-30], [1.0, 1.0, 1e-30], [1.0, 1.0, 1e-30]]);
    assert!(intersect(along_x, crossing));
    assert_eq!(contact(along_x, crossing), point(1.0, 0.0, 0.0));
    assert!(!intersect(along_x, skew));
}

#[test]
fn points_meet_what_they_are_in() {
    let at = |x: f64, y: f64, z: f64| meets_floor([[x, y, z]; 3]);
    assert_eq!(at(1.0, 1.0, 0.0), point(1.0, 1.0, 0.0));
    assert_eq!(at(4.0, 0.0, 0.0), point(4.0, 0.0, 0.0));
    assert_eq!(at(1.0, 1.0, 1e-300), None);
    assert_eq!(at(3.0, 3.0, 0.0), None);
    let [p, q] = [[DVec3::ONE; 3], [DVec3::NEG_ONE; 3]];
    assert!(intersect(p, p) && !intersect(p, q));
}

#[test]
fn a_vertex_one_ulp_off_a_slanted_face_is_told_from_one_on_it() {
    let face = triangle([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let on = [0.25, 0.25, 0.5];
    let touching = |z| triangle([[on[0], on[1], z], [2.0, 2.0, 2.0], [2.0, 3.0, 2.0]]);
    assert!(intersect(face, touching(on[2])));
    assert!(intersect(face, touching(on[2].next_down())));
    assert!(!intersect(face, touching(on[2].next_up())));
}

#[test]
fn coordinates_that_are_not_finite_meet_nothing() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..9 {
            let mut a = [0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 4.0, 0.0];
            a[i] = bad;
            let a = [0, 3, 6].map(|i| DVec3::new(a[i], a[i + 1], a[i + 2]));
            for b in [
                triangle(FLOOR),
                triangle([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 9.0, 0.0]]),
                [DVec3::ZERO; 3],
                a,
            ] {
                assert!(!intersect(a, b) && !intersect(b, a), "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn bevy_triangles_intersect_through_the_trait() {
    let floor = Triangle3d::new(Vec3::ZERO, Vec3::X, Vec3::Y);
    let up = Vec3::new(0.0, 0.0, f32::from_bits(1));
    let above = Triangle3d::new(up, Vec3::X + up, Vec3::Y + up);
    assert!(floor.intersects(&floor));
    assert!(!floor.intersects(&above));
}

/// All triangles on the corners of a cube, degenerate ones included, against all.
#[test]
fn every_pair_on_the_corners_of_a_cube_is_decided_as_in_exact_arithmetic() {
    let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
    let mut triangles = Vec::new();
    for i in 0..8 {
        for j in 0..=i {
            triangles.extend((0..=j).map(|k| [corner(i), corner(j), corner(k)]));
        }
    }
    for (i, &a) in triangles.iter().enumerate() {
        for &b in &triangles[..=i] {
            assert_matches_lattice(a, b);
        }
    }
}

fn assert_matches_lattice(a: Triangle, b: Triangle) {
    let exact = common_points_on_lattice(a, b);
    let found = contact(a, b);
    assert_eq!(intersect(a, b), !exact.is_empty(), "{a:?} {b:?}");
    assert_eq!(
        found.iter().flat_map(TriangleContact::points).count(),
        exact.len(),
        "{a:?} {b:?} {found:?}"
    );
    let exact: Vec<_> = exact
        .iter()
        .map(|p| p.each_ref().map(|x| x.to_f64().expect("a number")))
        .collect();
    for point in found.iter().flat_map(TriangleContact::points) {
        let near = |p: &[f64; 3]| point.abs_diff_eq(DVec3::from_array(*p), 1e-11);
        assert!(exact.iter().any(near), "{a:?} {b:?} {found:?} {exact:?}");
    }
}

fn assert_matches_oracle(a: Triangle, b: Triangle) {
    let (exact, exponent) = common_points_of(a, b);
    assert_eq!(intersect(a, b), !exact.is_empty(), "{a:?} {b:?}");
    let Some(found) = contact(a, b) else { return };
    assert_eq!(found.points().len(), exact.len(), "{a:?} {b:?} {found:?}");

    let size = |vectors: &[DVec3]| vectors.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    let longest = [a, b].map(|[p, q, r]| size(&[p - q, q - r, r - p]));
    let largest = [a, b].map(|vertices| size(&vertices));
    let slack = to_rational(longest[0].max(longest[1]) * 2f64.powi(-40), exponent)
        + to_rational(largest[0].max(largest[1]) * 2f64.powi(-50), exponent);
    let near =
        |point: &DVec3, p: &[BigRational; 3]| (0..3).all(|i| (to_rational(point[i], exponent) - &p[i]).abs() <= slack);
    assert!(
        exact.iter().all(|p| found.points().iter().any(|point| near(point, p))),
        "{a:?} {b:?} {found:?}"
    );
    assert!(
        found.points().iter().all(|point| exact.iter().any(|p| near(point, p))),
        "{a:?} {b:?} {found:?}"
    );
    // Around a polygon in the order of the oracle, one way or the other.
    if exact.len() > 3 {
        let n = exact.len();
        let around =
            |first: usize, step: usize| (0..n).all(|i| near(&found.points()[(first + step * i) % n], &exact[i]));
        assert!(
            (0..n).any(|first| around(first, 1) || around(first, n - 1)),
            "{a:?} {b:?} {found:?}"
        );
    }
}

fn lattice_point() -> impl Strategy<Value = Vec3> {
    [-2i8..=2, -2i8..=2, -2i8..=2].prop_map(|p| Vec3::from_array(p.map(f32::from)))
}

fn scattered_point() -> impl Strategy<Value = Vec3> {
    [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(Vec3::from_array)
}

fn lattice_pair() -> impl Strategy<Value = [[Vec3; 3]; 2]> {
    prop::array::uniform2(prop::array::uniform3(lattice_point()))
}

fn scattered_pair() -> impl Strategy<Value = [[Vec3; 3]; 2]> {
    prop::array::uniform2(prop::array::uniform3(scattered_point()))
}

/// The coordinates moved by up to two units in the last place.
fn nudged(point: Vec3, ulps: [i8; 3]) -> Vec3 {
    let mut point = point;
    for (i, ulps) in ulps.into_iter().enumerate() {
        for _ in 0..ulps.unsigned_abs() {
            point[i] = if ulps < 0 {
                point[i].next_down()
            } else {
                point[i].next_up()
            };
        }
    }
    point
}

/// The second triangle all but in the plane of the first, or on its edges, or a sliver.
fn near_coplanar_pair() -> impl Strategy<Value = [[Vec3; 3]; 2]> {
    let weight = prop_oneof![
        2 => -0.5f32..1.5,
        1 => prop::sample::select(vec![0.0f32, 0.25, 0.5, 1.0, -1.0]),
    ];
    let vertices = prop::array::uniform3(prop_oneof![scattered_point(), lattice_point()]);
    let weights = prop::array::uniform3([weight.clone(), weight]);
    let nudge = prop_oneof![Just(0i8), -2i8..=2];
    let nudges = prop::array::uniform6([nudge.clone(), nudge.clone(), nudge]);
    (vertices, weights, nudges).prop_map(|([p, q, r], weights, nudges)| {
        let b = weights.map(|[s, t]| p + (q - p) * s + (r - p) * t);
        let nudge = |points: [Vec3; 3], first: usize| [0, 1, 2].map(|i| nudged(points[i], nudges[first + i]));
        [nudge([p, q, r], 0), nudge(b, 3)]
    })
}

/// The second triangle with vertices of the first, and each perhaps with a vertex twice or on an edge of its own.
fn joined_pair() -> impl Strategy<Value = [[Vec3; 3]; 2]> {
    let other = prop_oneof![lattice_pair(), scattered_pair(), near_coplanar_pair()];
    let from = prop::array::uniform3(prop::option::of(0usize..3));
    let collapse = || prop::option::weighted(0.3, prop::sample::select(vec![0.0f32, 0.5, 1.0, 2.0, 0.3]));
    (other, from, collapse(), collapse()).prop_map(|([mut a, mut b], from, collapse_a, collapse_b)| {
        for (vertex, from) in b.iter_mut().zip(from) {
            *vertex = from.map_or(*vertex, |from| a[from]);
        }
        for (triangle, collapse) in [(&mut a, collapse_a), (&mut b, collapse_b)] {
            if let Some(t) = collapse {
                triangle[2] = triangle[0] + (triangle[1] - triangle[0]) * t;
            }
        }
        [a, b]
    })
}

/// All of these, at scales from denormal to 1e7, mixed at times, and at times far from the origin.
fn pair() -> impl Strategy<Value = [Triangle; 2]> {
    let pairs = prop_oneof![lattice_pair(), scattered_pair(), near_coplanar_pair(), joined_pair()];
    let powers = prop_oneof![Just(0), Just(-66), Just(23), Just(-130), Just(-147), Just(100)];
    let scales = prop_oneof![
        4 => Just([1.0, 1.0]),
        3 => powers.clone().prop_map(|k| [2f32.powi(k); 2]),
        1 => [powers.clone(), powers].prop_map(|k| k.map(|k| 2f32.powi(k))),
        1 => Just([1e-20, 1e-20]),
        1 => Just([1e7, 1e7]),
    ];
    let offset = prop_oneof![3 => Just(Vec3::ZERO), 1 => lattice_point().prop_map(|p| p * 1e6)];
    (pairs, scales, offset).prop_map(|(pair, scales, offset)| {
        [0, 1].map(|i| pair[i].map(|point| (point * scales[i] + offset * scales[i]).as_dvec3()))
    })
}

/// Coordinates with all the bits of an `f64`, at scales where determinants overflow and underflow.
fn wide_pair() -> impl Strategy<Value = [Triangle; 2]> {
    let tweak = prop::array::uniform18(-2i64..=2);
    let power = prop_oneof![
        Just(0),
        Just(-400),
        Just(-800),
        Just(-1000),
        Just(400),
        Just(800),
        Just(1000)
    ];
    (pair(), tweak, power).prop_filter_map("spans too many powers of two", |(pair, tweak, power)| {
        let mut tweaks = tweak.into_iter();
        let pair = pair.map(|triangle| {
            triangle.map(|point| {
                let tweaked = point.to_array().map(|x| {
                    let ulps = tweaks.next().unwrap_or(0);
                    if x == 0.0 {
                        x
                    } else {
                        f64::from_bits((x.to_bits() as i64 + ulps) as u64)
                    }
                });
                DVec3::from_array(tweaked)
            })
        });
        let sizes = || {
            pair.iter()
                .flatten()
                .flat_map(DVec3::to_array)
                .map(f64::abs)
                .filter(|&x| x != 0.0)
        };
        let (min, max) = (
            sizes().fold(f64::MAX, f64::min).log2(),
            sizes().fold(f64::MIN_POSITIVE, f64::max).log2(),
        );
        let fits = min + f64::from(power) > -960.0 && max + f64::from(power) < 1010.0;
        fits.then(|| pair.map(|triangle| triangle.map(|point| point * 2f64.powi(power))))
    })
}

proptest! {
    #![proptest_config(crate::properties::cases())]

    #[test]
    fn lattice_pairs_meet_as_in_exact_arithmetic([a, b] in lattice_pair()) {
        assert_matches_lattice(a.map(Vec3::as_dvec3), b.map(Vec3::as_dvec3));
    }

    #[test]
    fn pairs_meet_as_in_exact_arithmetic([a, b] in pair()) {
        assert_matches_oracle(a, b);
    }

    #[test]
    fn near_coplanar_pairs_meet_as_in_exact_arithmetic([a, b] in near_coplanar_pair()) {
        assert_matches_oracle(a.map(Vec3::as_dvec3), b.map(Vec3::as_dvec3));
    }

    #[test]
    fn pairs_of_doubles_at_extreme_scales_meet_as_in_exact_arithmetic([a, b] in wide_pair()) {
        assert_matches_oracle(a, b);
    }

    #[test]
    fn the_two_tests_agree([a, b] in pair()) {
        prop_assert_eq!(intersect_by_edges(a, b), intersect_by_intervals(a, b));
    }

    #[test]
    fn the_order_of_triangles_and_vertices_does_not_matter([a, b] in pair(), turn in 0usize..3, reversed in any::<bool>()) {
        let mut turned = a;
        turned.rotate_left(turn);
        if reversed {
            turned.reverse();
        }
        let [found, other] = [contact(a, b), contact(b, turned)];
        prop_assert_eq!(intersect(a, b), intersect(b, turned));
        prop_assert_eq!(found.is_some(), other.is_some());
        if let (Some(found), Some(other)) = (found, other) {
            prop_assert_eq!(found.points().len(), other.points().len());
            let size = a.iter().chain(&b).map(|p| p.abs().max_element()).fold(0.0, f64::max);
            // Twice the promised bound; an edge is no longer than two coordinates.
            let slack = size * 2f64.powi(-37);
            for p in found.points() {
                prop_assert!(other.points().iter().any(|q| (*p - *q).abs().max_element() <= slack), "{:?} {:?}", found, other);
            }
        }
    }
}

#[test]
fn doubles_that_are_all_tiny_are_told_apart() {
    let (u, base) = (2f64.powi(-1009), -(2f64.powi(-957)));
    let at = |[x, y, z]: [f64; 3]| DVec3::new(base + x * u, base + y * u, base + z * u);
    // The second is beyond a corner of the first, by one unit in the last place.
    let a = [
        [0.0; 3],
        [0.0, 10200547328.0, 5368709118.0],
        [5368709120.0, 10200547328.0, 5368709118.0],
    ]
    .map(at);
    let b = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -2.0]].map(at);
    assert!(!intersect(a, b));
}

#[test]
fn segments_on_one_line_that_are_apart_do_not_meet() {
    let on_line = |[p, q]: [f64; 2]| [p, q, q].map(|t| DVec3::new(t, 2.0 * t, 3.0 * t));
    assert!(intersect(on_line([0.0, 1.0]), on_line([1.0, 3.0])));
    assert!(!intersect(on_line([0.0, 1.0]), on_line([2.0, 3.0])));
    assert!(!intersect(on_line([2.0, 3.0]), on_line([0.0, 1.0])));
}

#[test]
fn a_vertex_in_the_plane_of_the_other_is_given_as_it_is() {
    // In double precision, p + (q - p) is not q.
    let (p, q) = (
        DVec3::new(0.5, 0.5, 0.524560164915884),
        DVec3::new(0.5, 0.5, -7.966303146382229),
    );
    assert_ne!(p + (q - p), q);
    let floor = [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]].map(|[x, y]| DVec3::new(x, y, q.z));
    let below = q - DVec3::Y - DVec3::Z;
    for through in [[q, p, below], [p, below, q], [below, q, p], [below, p, q]] {
        for [a, b] in [[floor, through], [through, floor]] {
            let found = contact(a, b).expect("a contact");
            assert!(found.points().contains(&q), "{found:?}");
        }
    }
}

#[test]
fn a_vertex_in_one_plane_that_is_just_beside_an_edge_is_outside() {
    // In double precision, the determinant of this point and the edge is zero.
    let beside = DVec3::new(0.4999999999999978, 0.4999999999999979, 0.0);
    let a = triangle([[-12.0, -12.0, 0.0], [24.0, 24.0, 0.0], [24.0, -12.0, 0.0]]);
    let b = [beside, DVec3::new(-4.0, 8.0, 0.0), DVec3::new(0.0, 8.0, 0.0)];
    assert!(!intersect(a, b));
}
