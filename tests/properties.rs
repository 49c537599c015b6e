//! What the property tests share: how many cases, and the strategies for shapes, ugly ones included.

use bevy::math::{Affine3A, EulerRot, Mat3A, Quat, Vec3, Vec3A};
use proptest::{
    prelude::*,
    test_runner::{FileFailurePersistence, RngSeed},
};

/// A thousand cases from a fixed seed; with `PROPERTY_CASES` in the environment, that many from a new seed every time.
pub fn cases() -> ProptestConfig {
    let asked = std::env::var("PROPERTY_CASES")
        .ok()
        .map(|cases| cases.parse().expect("a number of cases"));
    ProptestConfig {
        cases: asked.unwrap_or(1000),
        rng_seed: if asked.is_some() {
            RngSeed::Random
        } else {
            RngSeed::Fixed(0)
        },
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("proptest-regressions"))),
        max_global_rejects: 1 << 20,
        ..ProptestConfig::default()
    }
}

/// A finite coordinate of a size that games have, often a small whole number, so that coincidences happen.
pub fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => -100.0f32..100.0,
        2 => (-3i8..=3).prop_map(f32::from),
        1 => -1.0f32..1.0,
    ]
}

/// A point with such coordinates.
pub fn point() -> impl Strategy<Value = Vec3A> {
    [coordinate(), coordinate(), coordinate()].prop_map(Vec3A::from_array)
}

/// A unit vector, along an axis at times.
pub fn direction() -> impl Strategy<Value = Vec3A> {
    prop_oneof![
        4 => [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(Vec3A::from_array),
        1 => [-1i8..=1, -1i8..=1, -1i8..=1].prop_map(|v| Vec3A::from_array(v.map(f32::from))),
    ]
    .prop_filter_map("not zero", |v| (v.length() > 0.1).then(|| v.normalize()))
}

/// A rotation, by quarter turns at times.
pub fn rotation() -> impl Strategy<Value = Quat> {
    use std::f32::consts::{FRAC_PI_2, PI};
    let angle = prop_oneof![3 => -PI..PI, 1 => (-2i8..=2).prop_map(|turns| f32::from(turns) * FRAC_PI_2)];
    [angle.clone(), angle.clone(), angle].prop_map(|[a, b, c]| Quat::from_euler(EulerRot::XYZ, a, b, c))
}

/// From one to a few dozen points: scattered, on a lattice, in a plane, on a line, all at one place; at scales from
/// 1e-20 to 1e7, and at times far from the origin.
pub fn points() -> impl Strategy<Value = Vec<Vec3A>> {
    let scattered = prop::collection::vec(point(), 1..40);
    let squashed =
        (prop::collection::vec(point(), 1..40), rotation(), 0usize..4).prop_map(|(points, rotation, rank)| {
            let kept = Vec3A::new(
                (rank > 0) as u8 as f32,
                (rank > 1) as u8 as f32,
                (rank > 2) as u8 as f32,
            );
            points.into_iter().map(|point| rotation * (point * kept)).collect()
        });
    let lattice = prop::collection::vec([-2i8..=2, -2i8..=2, -2i8..=2], 1..60).prop_map(|points| {
        points
            .into_iter()
            .map(|p| Vec3A::from_array(p.map(f32::from)))
            .collect()
    });
    let scale = prop_oneof![3 => Just(1.0f32), 1 => Just(1e-20f32), 1 => Just(1e-6f32), 1 => Just(1e5f32)];
    let offset = prop_oneof![3 => Just(Vec3A::ZERO), 1 => point().prop_map(|p| p * 1e3)];
    (prop_oneof![scattered, squashed, lattice], scale, offset).prop_map(
        |(points, scale, offset): (Vec<Vec3A>, _, _)| points.into_iter().map(|point| point * scale + offset).collect(),
    )
}

/// An affine transform: rigid, scaled, mirrored, sheared, and at times flat.
pub fn affine() -> impl Strategy<Value = Affine3A> {
    let scale = prop_oneof![
        2 => Just(Vec3::ONE),
        3 => [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0].prop_map(Vec3::from_array),
        1 => [-1i8..=1, -1i8..=1, -1i8..=1].prop_map(|v| Vec3::from_array(v.map(f32::from))),
    ];
    let shear = prop_oneof![2 => Just(Vec3A::ZERO), 1 => [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(Vec3A::from_array)];
    (scale, rotation(), shear, point()).prop_map(|(scale, rotation, shear, translation)| {
        let mut transform = Affine3A::from_scale_rotation_translation(scale, rotation, translation.into());
        let sheared = Mat3A::from_cols(
            Vec3A::X,
            Vec3A::new(shear.x, 1.0, 0.0),
            Vec3A::new(shear.y, shear.z, 1.0),
        );
        transform.matrix3 *= sheared;
        transform
    })
}
