//! Mending the boxes above a change.

use super::AabbTree;
use crate::spatial::wide::NodeIndex;

impl<K: Copy> AabbTree<K> {
    /// Fits the box of `node` and those of all its ancestors to their children; stops where nothing changes any more.
    pub(super) fn refit_above(&mut self, node: NodeIndex) {
        let mut node = node;
        while let Some(parent) = self.parents[node as usize] {
            let fitted = self.nodes[node as usize].bounds();
            let lanes = &mut self.nodes[parent.node as usize];
            if lanes.aabb(parent.lane as usize) == fitted {
                return;
            }
            lanes.set_aabb(parent.lane as usize, &fitted);
            node = parent.node;
        }
    }
}
