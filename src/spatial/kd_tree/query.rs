//! What trees are searched for in order: what is near a point, along a ray, or in the way of a moving shape.

use bevy::math::bounding::Aabb3d;

use crate::spatial::{
    Sweep,
    lanes::{Approach, Boxes, Entering, Growing},
    simd::Simd,
    sweep::slack_reach,
};

/// A search with an order: boxes are met at a distance or a parameter, and none before a box around it.
pub(crate) trait Query {
    /// Whether few of the lanes of a node are met, as by a ray; a search for the nearest meets all at first.
    const MEETS_FEW: bool;

    /// The lanes that are met no farther than `limit`, and where they are.
    fn meet<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s);

    /// Where one box is met that [`meet`](Self::meet) finds, exactly.
    #[inline(always)]
    fn refine(&self, _aabb: impl FnOnce() -> Aabb3d, at: f32) -> Option<f32> {
        Some(at)
    }
}

/// Boxes near a point, at squared distances.
impl Query for Growing {
    const MEETS_FEW: bool = false;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        let (lanes, ats) = self.meets(simd, boxes, limit);
        (lanes & boxes.present(simd), ats)
    }
}

/// Boxes that a ray enters.
impl Query for Entering<false> {
    const MEETS_FEW: bool = true;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        let (lanes, ats) = self.meets(simd, boxes, limit);
        (lanes & boxes.present(simd), ats)
    }
}

/// Boxes that a moving shape touches.
pub(super) struct InTheWay<'a, W> {
    sweep: &'a W,
    approach: Entering<true>,
}

impl<'a, W: Sweep> InTheWay<'a, W> {
    pub(super) fn of(sweep: &'a W) -> Self {
        Self {
            sweep,
            approach: Entering::grown(sweep.ray(), slack_reach(sweep)),
        }
    }
}

impl<W: Sweep> Query for InTheWay<'_, W> {
    const MEETS_FEW: bool = true;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        let (lanes, ats) = self.approach.meets(simd, boxes, limit);
        (lanes & boxes.present(simd), ats)
    }

    #[inline(always)]
    fn refine(&self, aabb: impl FnOnce() -> Aabb3d, _at: f32) -> Option<f32> {
        // A contact beyond the range of parameters is none.
        self.sweep.intersection_at(&aabb()).filter(|t| t.is_finite())
    }
}
