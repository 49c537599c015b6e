//! How good the tree is by now, compared to how good it was.

use bevy::math::bounding::Aabb3d;

use super::{AabbTree, Place};

/// A tree is built anew when the area of its nodes has grown by this factor.
const DEGRADED: f64 = 1.05;

/// A node looks for leaves that stray when it has grown by this much of the area of a node of average size.
const MOST_GROWTH: f64 = 0.5;

/// How large the nodes are, to know when they have become too large.
///
/// The area of all nodes is what queries pay: the surface area heuristic without its leaves, which are what they are. It
/// is watched both as it is and as a multiple of the area of the root, so that neither a scene that contracts nor one that
/// spreads passes for a good tree.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quality {
    /// The areas of all nodes but the root, together.
    pub area: f64,
    /// The least that this has been since the last build.
    least_area: f64,
    /// The least that it has been as a multiple of the area of the root.
    least_ratio: f64,
    /// How much a node may grow before its leaves are looked at, however large it is.
    most_growth: f32,
}

impl Quality {
    /// That of a new tree.
    pub fn of_new(area: f64, root_area: f64, nodes: usize) -> Self {
        Self {
            area,
            least_area: area,
            least_ratio: area / root_area,
            most_growth: (area * MOST_GROWTH / nodes as f64) as f32,
        }
    }

    /// A node holds on to its leaves until it is larger than this: until it is twice as large as when it was formed, or
    /// has grown by as much as a node of average size.
    #[inline]
    pub fn limit(&self, formed_area: f32) -> f32 {
        formed_area + formed_area.min(self.most_growth)
    }

    /// Whether the nodes have become noticeably larger than they were at their best.
    fn is_degraded(&mut self, root_area: f64) -> bool {
        let ratio = self.area / root_area;
        // In this order a NaN, of a root without area, is passed over.
        self.least_area = self.area.min(self.least_area);
        self.least_ratio = ratio.min(self.least_ratio);
        self.area > DEGRADED * self.least_area || ratio > DEGRADED * self.least_ratio
    }
}

impl<K: Copy> AabbTree<K> {
    /// Keeps queries fast: builds the tree anew if that has become worth it, and returns whether it has.
    ///
    /// To be called once in a while, as once per frame; next to free when there is nothing to do. Never needed for
    /// answers to be right.
    pub fn optimize(&mut self) -> bool {
        let is_degraded = self.is_degraded();
        if is_degraded {
            self.rebuild();
        }
        is_degraded
    }

    /// Whether the tree has become noticeably worse than it was at its best since the last build, by some 5% of what
    /// queries visit.
    pub fn is_degraded(&mut self) -> bool {
        let Some(root) = self.root else { return false };
        let root_area = area(&self.nodes[root as usize].bounds());
        self.quality.is_degraded(root_area)
    }

    /// Takes the tree as it is for the best that it can be.
    pub(super) fn measure(&mut self) {
        let Some(root) = self.root else { return };
        let root_area = area(&self.nodes[root as usize].bounds());
        let nodes = self.nodes.len() - self.free_nodes.len();
        self.quality = Quality::of_new(self.quality.area, root_area, nodes);
    }

    /// Gives a child another box.
    #[inline]
    pub(super) fn fit(&mut self, place: Place, aabb: &Aabb3d) {
        let lanes = &mut self.nodes[place.node() as usize];
        self.quality.area += area(aabb) - area(&lanes.aabb(place.lane()));
        lanes.set_aabb(place.lane(), aabb);
    }
}

/// Half of the surface of a box.
#[inline]
pub(super) fn area(aabb: &Aabb3d) -> f64 {
    let [x, y, z] = (aabb.max - aabb.min).to_array().map(f64::from);
    x * y + y * z + z * x
}
