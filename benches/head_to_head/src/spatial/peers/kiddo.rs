//! kiddo: points only.

use std::num::NonZero;

use bevy::math::{Vec3A, bounding::Aabb3d};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::spatial::queries::{NearQueries, Scratch};

pub(crate) const NAME: &str = "kiddo 6.3";

pub(crate) struct Kiddo {
    tree: ImmutableKdTree<f32, 3>,
}

impl Kiddo {
    /// The tree of the minima of the boxes, which are points.
    pub fn build(points: &[Aabb3d]) -> Self {
        let points: Vec<[f32; 3]> = points.iter().map(|point| point.min.to_array()).collect();
        Self {
            tree: ImmutableKdTree::new_from_slice(&points).expect("finite points"),
        }
    }
}

impl NearQueries for Kiddo {
    fn nearest<const N: usize>(&self, point: Vec3A, _: &mut Scratch) -> [f32; N] {
        let point = point.to_array();
        let query = self.tree.query(&point);
        if N == 1 {
            let nearest = query.nearest_one::<SquaredEuclidean<f32>>().execute();
            return [nearest.distance; N];
        }
        let number = NonZero::new(N).expect("at least one");
        let nearest = query.nearest_n::<SquaredEuclidean<f32>>(number).execute();
        std::array::from_fn(|i| nearest[i].distance)
    }
}
