//! Oriented boxes under affine transforms.

use bevy::math::{Affine3A, DMat3, DVec3};

use super::{Obb, exact_axes, fit::Measure, rounded_axes, skew};
use crate::geometry::{tolerance, volume::ExactAffine};

/// A box around the image of `obb`, which is a parallelepiped.
///
/// Of the six boxes that share a face's plane with it and in that an edge's direction, the smallest: if the image is a
/// box, they are all that box.
pub fn transformed(obb: &Obb, transform: &Affine3A) -> Obb {
    let transform = ExactAffine::new(transform);
    let generators = obb.generators();
    let reach = obb.center.as_dvec3().abs() + generators.abs() * DVec3::ONE;
    let image = transform.matrix * generators;
    let center = transform.transform_point(obb.center.as_dvec3());
    let rounded = center.as_vec3a();
    // What the image of a point and the centre are off by, at the most, in the coordinates of the space.
    let off = transform.rounding(reach) + (rounded.as_dvec3() - center).abs();
    if !(image.is_finite() && off.is_finite()) {
        return Obb::EVERYTHING;
    }

    let measure = Measure::above(image.abs().to_cols_array().into_iter().fold(0.0, f64::max));
    let half_size = |axes: &DMat3| (axes.transpose() * image).abs() * DVec3::ONE;
    let edges = [image.x_axis, image.y_axis, image.z_axis];
    let axes = [[0, 1], [1, 0], [0, 2], [2, 0], [1, 2], [2, 1]]
        .map(|[first, second]| frame(edges[first], edges[second], [first, second]))
        .into_iter()
        .min_by(|a, b| measure.of(half_size(a)).total_cmp(&measure.of(half_size(b))))
        .unwrap_or(DMat3::IDENTITY);

    let axes = rounded_axes(axes);
    let exact = exact_axes(&axes);
    let half_size = (half_size(&exact) + exact.transpose().abs() * off) * (1.0 + tolerance::DOUBLE);
    Obb::sound(rounded, half_size + skew(&exact, half_size), axes)
}

/// The right-handed frame whose axis number `first` runs along `a` and whose axis number `second` along what of `b` is
/// at a right angle to that; any that fits where these are zero.
fn frame(a: DVec3, b: DVec3, [first, second]: [usize; 2]) -> DMat3 {
    let a = unit(a)
        .or_else(|| unit(b).map(DVec3::any_orthonormal_vector))
        .unwrap_or(DVec3::AXES[first]);
    let b = unit(b - a * a.dot(b))
        .filter(|b| b.dot(a).abs() < 0.5)
        .unwrap_or_else(|| a.any_orthonormal_vector());
    // Once more: of two nearly parallel vectors the difference is not quite at a right angle.
    let b = (b - a * a.dot(b)).normalize();
    let third = 3 - first - second;
    let c = if second == (first + 1) % 3 {
        a.cross(b)
    } else {
        b.cross(a)
    };
    let mut frame = DMat3::ZERO;
    *frame.col_mut(first) = a;
    *frame.col_mut(second) = b;
    *frame.col_mut(third) = c;
    frame
}

/// The vector at unit length, however short or long, or `None` of zero.
fn unit(vector: DVec3) -> Option<DVec3> {
    (vector / vector.abs().max_element()).try_normalize()
}
