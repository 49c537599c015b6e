//! Which nodes of a binary hierarchy become wide nodes.

use bevy::math::bounding::BoundingVolume;

use super::{Leaves, tagged_box::BinaryNode};
use crate::spatial::simd::{self, LANES, Simd, Task};

/// What a node costs for the memory that it takes, where to be met as often as a typical node costs one. Measured: so
/// nodes have 6.3 children on average in place of 6.1, and rays visit as many.
const MEMORY_COST: f32 = 0.25;

/// The same where all items are told apart: without bags, which fill nodes, there would be less than five children on
/// average.
const MEMORY_COST_WITHOUT_BAGS: f32 = 1.0;

/// What it costs to give all that is below a node to one lane of a wide node, to two, and so on to eight.
type Costs = [f32; LANES];

/// The best shares of lanes for a binary hierarchy.
///
/// A lane holds a leaf, or a wide node, which costs its area and what its own eight lanes cost; a node that is given more
/// lanes may share them out among its children. What costs least is found from the leaves up. Source: Ylitie, Karras and
/// Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, 2017, §3.1.
///
/// A bag is not taken apart by halves: it gets one lane, or one for each of its items where leaves are single items.
/// Halves would be nodes of two or three children at the bottom of the hierarchy, where most of the nodes are.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// By the pairs that children are.
    costs: Vec<Costs>,
    leaves: Leaves,
    bag_size: u32,
    memory_cost: f32,
}

/// How a node uses its lanes.
pub(super) enum Shares {
    /// It is one child, as it is.
    Whole,
    /// Each item of the bag is a child.
    Items,
    /// Its children get so many lanes each.
    Children([usize; 2]),
}

impl Plan {
    pub(super) fn memory(&self) -> usize {
        self.costs.capacity() * size_of::<Costs>()
    }

    /// Plans for a hierarchy whose nodes come `children_first`, or after their parents; without the root.
    pub(super) fn make(
        &mut self,
        root: &BinaryNode,
        tree: &[BinaryNode],
        children_first: bool,
        leaves: Leaves,
        bag_size: u32,
    ) {
        self.leaves = leaves;
        self.bag_size = bag_size;
        // Where nothing has an area, the number of nodes alone decides.
        let memory_cost = if bag_size > 1 {
            MEMORY_COST
        } else {
            MEMORY_COST_WITHOUT_BAGS
        };
        self.memory_cost = (memory_cost * typical_area(tree)).max(f32::MIN_POSITIVE);
        self.costs.clear();
        self.costs.resize(tree.len() / 2, [0.0; LANES]);
        simd::dispatch(Planning {
            plan: self,
            root,
            tree,
            children_first,
        });
    }

    #[inline(always)]
    pub(super) fn is_bag(&self, node: &BinaryNode) -> bool {
        node.count() <= self.bag_size
    }

    /// The costs of a node that is no bag.
    #[inline(always)]
    pub(super) fn costs_of_inner(&self, node: &BinaryNode) -> &Costs {
        &self.costs[node.first() as usize / 2]
    }

    #[inline(always)]
    fn costs(&self, node: &BinaryNode) -> Costs {
        let count = node.count();
        if !self.is_bag(node) {
            *self.costs_of_inner(node)
        } else if self.leaves.most > 1 {
            [self.leaf(node); LANES]
        } else {
            let whole = if count > 1 { area(node) + self.memory_cost } else { 0.0 };
            let mut costs = [0.0; LANES];
            for (lanes, cost) in (1..).zip(&mut costs) {
                *cost = if lanes < count { whole } else { 0.0 };
            }
            costs
        }
    }

    /// The cost of a leaf.
    #[inline(always)]
    fn leaf(&self, node: &BinaryNode) -> f32 {
        let packets = node.count().div_ceil(self.leaves.packet) as f32;
        packets * self.leaves.packet_cost * (area(node) + self.memory_cost)
    }

    /// The cost of a node from those of its children.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, node: &BinaryNode, tree: &[BinaryNode]) {
        if self.is_bag(node) {
            return;
        }
        let first = node.first() as usize;
        let (a, b) = (self.costs(&tree[first]), self.costs(&tree[first + 1]));
        let mut shifted = [f32::INFINITY; 2 * LANES];
        shifted[LANES..].copy_from_slice(&b);
        let mut shared = simd.splat(f32::INFINITY);
        for lanes in 1..LANES {
            let rest = shifted[LANES - lanes..][..LANES].try_into().expect("eight lanes");
            shared = simd.min(simd.add(simd.splat(a[lanes - 1]), simd.load(rest)), shared);
        }
        let whole = if node.count() <= self.leaves.most {
            self.leaf(node)
        } else {
            area(node) + self.memory_cost + simd.store(shared)[LANES - 1]
        };
        self.costs[first / 2] = simd.store(simd.min(simd.splat(whole), shared));
    }

    /// How a node uses so many lanes of a wide node: of its own if it `is_wide`.
    #[inline(always)]
    pub(super) fn shares(&self, node: &BinaryNode, tree: &[BinaryNode], lanes: usize, is_wide: bool) -> Shares {
        let count = node.count();
        if self.is_bag(node) {
            let all_items = self.leaves.most == 1 && (is_wide || lanes >= count as usize);
            return if all_items { Shares::Items } else { Shares::Whole };
        }
        let first = node.first() as usize;
        let costs = self.costs_of_inner(node);
        if !is_wide && (lanes == 1 || costs[lanes - 1] >= costs[0]) {
            return Shares::Whole;
        }
        let (a, b) = (self.costs(&tree[first]), self.costs(&tree[first + 1]));
        let (mut least, mut best) = (f32::INFINITY, 1);
        for lanes_of_a in 1..lanes {
            let cost = a[lanes_of_a - 1] + b[lanes - lanes_of_a - 1];
            if cost < least {
                (least, best) = (cost, lanes_of_a);
            }
        }
        Shares::Children([best, lanes - best])
    }
}

/// The area of a node, or so much that the sum over all nodes is still finite.
#[inline(always)]
pub(super) fn area(node: &BinaryNode) -> f32 {
    const MOST: f32 = f32::MAX / (1_u64 << 33) as f32;
    // Also for a NaN, of what is infinite one way and flat another.
    node.aabb().visible_area().min(MOST)
}

/// About the geometric mean of the areas of nodes: a few that are huge do not count for more. The bits of numbers that
/// are not negative grow like their logarithms.
fn typical_area(tree: &[BinaryNode]) -> f32 {
    let sum: u64 = tree.iter().map(|node| u64::from(area(node).to_bits())).sum();
    f32::from_bits((sum / tree.len().max(1) as u64) as u32)
}

struct Planning<'a> {
    plan: &'a mut Plan,
    root: &'a BinaryNode,
    tree: &'a [BinaryNode],
    children_first: bool,
}

impl Task for Planning<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self {
            plan,
            root,
            tree,
            children_first,
        } = self;
        let count = tree.len();
        for place in 0..count {
            let node = if children_first { place } else { count - 1 - place };
            plan.add(simd, &tree[node], tree);
        }
        plan.add(simd, root, tree);
    }
}
