use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::{
    convex_hull::ConvexHull,
    volume::{AnyVolume, BoundingKind, Tightness, UnboundablePoints, Volume},
};
use proptest::prelude::*;

use super::volume::ugly_points;
use crate::properties::cases;

fn tightness(kind_of: &impl Volume, points: &[Vec3A]) -> Tightness {
    Tightness::of(kind_of, &ConvexHull::enclosing(points.iter().copied()).expect("finite"))
}

/// The corners of an octahedron: the volume of its hull is 4/3, the area 4√3; the box around it has 8 and 24.
const OCTAHEDRON: [Vec3A; 6] = [Vec3A::X, Vec3A::NEG_X, Vec3A::Y, Vec3A::NEG_Y, Vec3A::Z, Vec3A::NEG_Z];

#[test]
fn the_box_around_an_octahedron_is_six_times_as_large() {
    let aabb = Aabb3d::enclosing(OCTAHEDRON).expect("finite");
    let tightness = tightness(&aabb, &OCTAHEDRON);
    assert!((tightness.volume - 6.0).abs() < 1e-4);
    assert!((tightness.projected_area - 12f32.sqrt()).abs() < 1e-4);
}

#[test]
fn of_a_slanted_flat_hull_only_the_projected_area_compares() {
    let points = [Vec3A::ZERO, Vec3A::X, Vec3A::new(0.0, 1.0, 1.0)];
    let aabb = Aabb3d::enclosing(points).expect("finite");
    let tightness = tightness(&aabb, &points);
    assert_eq!(tightness.volume, f32::INFINITY);
    assert!((tightness.projected_area - 6.0 / 2f32.sqrt()).abs() < 1e-4);
}

#[test]
fn a_flat_volume_around_a_flat_hull_is_as_large_as_it_can_be() {
    let points = [Vec3A::ZERO, Vec3A::X, Vec3A::Y];
    let aabb = Aabb3d::enclosing(points).expect("finite");
    let flat = tightness(&aabb, &points);
    assert_eq!(flat.volume, 1.0);
    assert!((flat.projected_area - 2.0).abs() < 1e-4);
    let point = tightness(&Aabb3d::enclosing([Vec3A::ONE]).expect("finite"), &[Vec3A::ONE]);
    assert_eq!(
        point,
        Tightness {
            volume: 1.0,
            projected_area: 1.0
        }
    );
}

#[test]
fn the_default_kind_is_the_axis_aligned_box() {
    assert_eq!(BoundingKind::default(), BoundingKind::Aabb);
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_kind_makes_volumes_of_that_kind_that_answer_as_it_does(points in ugly_points()) {
        for kind in [BoundingKind::Sphere, BoundingKind::Aabb, BoundingKind::Obb] {
            let Ok(any) = kind.enclosing(points.iter().copied()) else { continue };
            prop_assert_eq!(any.kind(), kind);
            prop_assert!(points.iter().all(|&point| any.contains_point(point)));
            let (volume, area, aabb) = match &any {
                AnyVolume::Sphere(sphere) => (sphere.volume(), sphere.surface_area(), sphere.aabb()),
                AnyVolume::Aabb(aabb) => (aabb.volume(), aabb.surface_area(), aabb.aabb()),
                AnyVolume::Obb(obb) => (obb.volume(), obb.surface_area(), obb.aabb()),
                AnyVolume::Hull(hull) => (hull.volume(), hull.surface_area(), hull.aabb()),
            };
            prop_assert_eq!((any.volume(), any.surface_area(), any.aabb()), (volume, area, aabb));
        }
    }

    #[test]
    fn every_kind_refuses_what_is_not_finite(mut points in ugly_points(), at in any::<prop::sample::Index>()) {
        let index = at.index(points.len());
        points[index].y = f32::NAN;
        for kind in [BoundingKind::Sphere, BoundingKind::Aabb, BoundingKind::Obb] {
            let refused = kind.enclosing(points.iter().copied());
            prop_assert_eq!(refused, Err(UnboundablePoints::NotFinite { index }));
        }
    }
}
