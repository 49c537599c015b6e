//! What a hierarchy costs to query.

use bevy::math::bounding::Aabb3d;

use crate::spatial::wide::{NodeIndex, WideNode};

/// The area of all boxes, those of nodes and those of leaves, over that of the bounds of `root`: the number of boxes that
/// a random line meets which meets the bounds (Goldsmith and Salmon, *Automatic Creation of Object Hierarchies for Ray
/// Tracing*, 1987). Nodes that are empty count nothing; where the bounds have no area, every box counts one.
pub(crate) fn sah_cost(nodes: &[WideNode], root: NodeIndex) -> f64 {
    let Some(root) = nodes.get(root as usize) else {
        return 0.0;
    };
    let whole = area(&root.bounds());
    let boxes = || nodes.iter().flat_map(WideNode::lanes);
    if whole > 0.0 {
        boxes().map(|(aabb, _)| area(&aabb)).sum::<f64>() / whole
    } else {
        boxes().count() as f64
    }
}

/// In `f64`, where no area of `f32` boxes overflows or vanishes.
fn area(aabb: &Aabb3d) -> f64 {
    let size = aabb.max.as_dvec3() - aabb.min.as_dvec3();
    size.x * size.y + size.y * size.z + size.z * size.x
}
