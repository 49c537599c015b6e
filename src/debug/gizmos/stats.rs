//! What was drawn.

use std::time::Duration;

use bevy::{
    ecs::{reflect::ReflectResource, resource::Resource},
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// How much of one kind was drawn in the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct GizmoCount {
    /// Shapes that were drawn: the nearest.
    pub drawn: usize,
    /// Shapes in view that were not, because there were too many, because one is NaN or infinite, or because a bounding
    /// volume is not made yet.
    pub left_out: usize,
}

/// What was drawn in the last frame, kind by kind: see [`SightlineGizmos`](super::SightlineGizmos). What is switched off
/// is zero.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct SightlineGizmoStats {
    /// Nodes of the tree.
    pub nodes: GizmoCount,
    /// Cells of the grid.
    pub cells: GizmoCount,
    /// World boxes of entities.
    pub leaves: GizmoCount,
    /// Bounding volumes.
    pub volumes: GizmoCount,
    /// What cameras see.
    pub frusta: GizmoCount,
    /// Boxes of what occludes.
    pub occluders: GizmoCount,
    /// Rays of pointers.
    pub rays: GizmoCount,
    /// Groups with levels of detail.
    pub lods: GizmoCount,
    /// All that was drawn for single entities.
    pub entities: GizmoCount,
    /// The time that it took.
    pub draw: Duration,
}

impl SightlineGizmoStats {
    /// Everything together.
    pub fn total(&self) -> GizmoCount {
        let all = [
            self.nodes,
            self.cells,
            self.leaves,
            self.volumes,
            self.frusta,
            self.occluders,
            self.rays,
            self.lods,
            self.entities,
        ];
        all.into_iter().fold(GizmoCount::default(), |total, count| GizmoCount {
            drawn: total.drawn + count.drawn,
            left_out: total.left_out + count.left_out,
        })
    }
}
