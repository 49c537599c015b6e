//! Shapes that pass into one another.

use crate::shape::Shape;

/// A shape with others of as many triangles, that it may become in part or in whole.
pub struct Morph {
    pub base: Shape,
    pub targets: Vec<(&'static str, Shape)>,
    pub clip: WeightClip,
}

/// The share of each target at equal times, the last as the first.
pub struct WeightClip {
    pub name: &'static str,
    pub seconds: f32,
    pub weights: Vec<Vec<f32>>,
}
