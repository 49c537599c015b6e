//! Which nodes of the tree a frustum makes one look at.

use bevy::math::{
    bounding::{Aabb3d, BoundingVolume},
    primitives::ViewFrustum,
};
use bevy_sightline::prelude::*;

/// Where a box is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Inside,
    /// Inside and outside.
    Across,
    Outside,
}

impl Side {
    /// The sides that a box is on of the five planes that Bevy culls by: it leaves out the far one.
    pub fn of(aabb: &Aabb3d, frustum: &ViewFrustum) -> Self {
        let (center, half_size) = (aabb.center(), aabb.half_size());
        let mut side = Self::Inside;
        for plane in &frustum.half_spaces[..ViewFrustum::FAR_PLANE_IDX] {
            let ahead = plane.normal().dot(center) + plane.d();
            let reach = plane.normal().abs().dot(half_size);
            if ahead < -reach {
                return Self::Outside;
            }
            if ahead < reach {
                side = Self::Across;
            }
        }
        side
    }
}

/// Visits the nodes from the root down, and nothing in those that are wholly inside or outside.
pub fn visit(index: &SpatialIndex, frustum: &ViewFrustum, mut visit: impl FnMut(Side, &Aabb3d)) {
    let mut decided_at = usize::MAX;
    index.visit_nodes(|depth, aabb| {
        if depth > decided_at {
            return;
        }
        let side = Side::of(aabb, frustum);
        decided_at = if side == Side::Across { usize::MAX } else { depth };
        visit(side, aabb);
    });
}
