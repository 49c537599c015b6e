//! A closed way through a city, for cameras that fly by themselves.

use bevy::{
    math::cubic_splines::{CubicCardinalSpline, CubicCurve, CyclicCubicGenerator},
    prelude::*,
};

/// A closed way.
#[derive(Resource)]
pub struct Route(CubicCurve<Vec3>);

impl Route {
    /// A smooth way through points, of which there must be more than two.
    pub fn through(points: impl IntoIterator<Item = Vec3>) -> Self {
        let curve = CubicCardinalSpline::new_catmull_rom(points).to_curve_cyclic();
        Self(curve.expect("more than two points"))
    }

    /// The eye after a part of the way, which runs from 0 to 1 and on.
    pub fn place(&self, part: f32) -> Transform {
        let at = |part: f32| self.0.position(part.rem_euclid(1.0) * self.0.segments().len() as f32);
        let eye = at(part);
        let ahead = (at(part + 0.03) - eye).with_y(0.0).normalize_or(Vec3::NEG_Z);
        // The higher, the more it looks down.
        Transform::from_translation(eye).looking_to(ahead - Vec3::Y * (0.006 * eye.y).min(0.5), Vec3::Y)
    }
}
