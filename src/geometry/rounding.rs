//! From double precision to single, in a chosen direction.

use bevy::math::{DVec3, Vec3A};

/// The smallest `f32` that is not below `value`: infinite where that overflows.
#[inline]
pub(crate) fn up(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) < value {
        nearest.next_up()
    } else {
        nearest
    }
}

/// The largest `f32` that is not above `value`: infinite where that overflows.
#[inline]
pub(crate) fn down(value: f64) -> f32 {
    -up(-value)
}

/// [`up`] in every coordinate.
#[inline]
pub(crate) fn up3(value: DVec3) -> Vec3A {
    Vec3A::from_array(value.to_array().map(up))
}

/// [`down`] in every coordinate.
#[inline]
pub(crate) fn down3(value: DVec3) -> Vec3A {
    Vec3A::from_array(value.to_array().map(down))
}
