//! Where items are, in one pass over them.

use bevy::math::bounding::Aabb3d;

use super::tagged_box::BuildItem;
use crate::geometry::aabb::{EMPTY, union};

/// Where items are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extents {
    pub bounds: Aabb3d,
    /// The bounds of the [doubled centers](BuildItem::doubled_center).
    pub centers: Aabb3d,
}

impl Extents {
    const EMPTY: Self = Self {
        bounds: EMPTY,
        centers: EMPTY,
    };

    #[inline(always)]
    fn with(&self, item: &BuildItem) -> Self {
        let center = item.doubled_center();
        let center = Aabb3d {
            min: center,
            max: center,
        };
        Self {
            bounds: union(&self.bounds, &item.aabb()),
            centers: union(&self.centers, &center),
        }
    }

    pub(super) fn of(items: &[BuildItem]) -> Self {
        items.iter().fold(Self::EMPTY, |extents, item| extents.with(item))
    }

    /// The axis along which the centers are farthest apart; `None` if they coincide.
    pub(super) fn longest_axis(&self) -> Option<usize> {
        let size = self.centers.max - self.centers.min;
        let axis = size.max_position();
        (size[axis] > 0.0).then_some(axis)
    }
}
