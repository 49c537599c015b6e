//! Building the whole tree at once.

use bevy::math::bounding::Aabb3d;

use super::{
    AabbTree, NodeLink, Place, Scratch,
    quality::{Quality, area},
};
use crate::{
    geometry::aabb::Aabb3dExt,
    spatial::{
        BuildStrategy, LeafId, UnsoundBox,
        build::{BuildItem, Builder, Leaves, Order},
        simd::with_huge_pages,
        wide::{NodeIndex, WideNode},
    },
};

/// One leaf that is inserted costs about as much as this many that are built.
const INSERTION_COST: usize = 12;

impl<K: Copy> AabbTree<K> {
    /// Adds many leaves with their masks, and returns for each its id, or why it was refused.
    ///
    /// Builds the whole tree anew where that is cheaper than to insert one by one.
    pub fn insert_many_masked(
        &mut self,
        leaves: impl IntoIterator<Item = (K, Aabb3d, u32)>,
    ) -> Vec<Result<LeafId, UnsoundBox>> {
        let mut items = std::mem::take(&mut self.scratch.items);
        items.clear();
        let ids: Vec<_> = leaves
            .into_iter()
            .map(|(key, aabb, mask)| {
                if !aabb.is_sound() {
                    return Err(UnsoundBox(aabb));
                }
                let id = self.leaves.add(key, Place::NONE);
                items.push(BuildItem::new(&aabb, mask, id.index));
                Ok(id)
            })
            .collect();
        if items.len() * INSERTION_COST >= self.leaves.len() {
            gather(&self.nodes, &mut items);
            self.build(BuildStrategy::default(), &mut items);
            // What comes in at once may stay as it is: only a tree that wears keeps the buffers to build it anew.
            self.scratch = Scratch::default();
            self.nodes.shrink_to_fit();
            self.links.shrink_to_fit();
        } else {
            for item in &items {
                self.link(item.index(), &item.aabb(), item.mask());
            }
            self.scratch.items = items;
        }
        ids
    }

    /// Builds the whole tree anew over the leaves that it has.
    pub fn rebuild(&mut self) {
        self.rebuild_with(BuildStrategy::default());
    }

    /// The same, in a way of the caller's choice.
    pub fn rebuild_with(&mut self, strategy: BuildStrategy) {
        let mut items = std::mem::take(&mut self.scratch.items);
        items.clear();
        gather(&self.nodes, &mut items);
        self.build(strategy, &mut items);
        self.scratch.items = items;
    }

    /// Replaces all nodes by a hierarchy over these leaves.
    fn build(&mut self, strategy: BuildStrategy, items: &mut Vec<BuildItem>) {
        build_nodes(
            &mut self.scratch.builder,
            strategy,
            items,
            &mut self.nodes,
            &mut self.links,
        );
        self.install(items);
    }

    /// Brings all else in step with nodes that were built over these leaves, which are in the order of the tree.
    pub(super) fn install(&mut self, items: &[BuildItem]) {
        self.free_nodes.clear();
        self.root = (!self.nodes.is_empty()).then_some(0);
        self.ordered.clear();
        self.ordered
            .extend(items.iter().map(|item| self.leaves.key_at(item.index())));
        let (mut node_area, mut has_unseen) = (0.0, false);
        for (index, node) in (0..).zip(&self.nodes) {
            for (lane, child) in node.children.iter().enumerate() {
                if let Some(leaf) = child.leaf() {
                    self.leaves.set_place_at(leaf, Place::new(index, lane));
                    has_unseen |= node.masks[lane] == 0;
                } else if let Some(child) = child.node() {
                    let area = area(&node.aabb(lane));
                    node_area += area;
                    self.links[child as usize].formed_area = area as f32;
                }
            }
        }
        if has_unseen {
            self.break_slices_of_unseen();
        }
        let root_area = self.nodes.first().map_or(0.0, |root| area(&root.bounds()));
        self.quality = Quality::of_new(node_area, root_area, self.nodes.len());
    }

    /// Slices are visited without a look at the leaves: none may have a leaf in it that is never found.
    fn break_slices_of_unseen(&mut self) {
        for index in 0..self.nodes.len() {
            let node = &self.nodes[index];
            if (node.children.iter().zip(node.masks)).any(|(child, mask)| child.leaf().is_some() && mask == 0) {
                self.break_slices(index as NodeIndex);
            }
        }
    }
}

/// Adds all leaves that nodes hold.
pub(super) fn gather(nodes: &[WideNode], items: &mut Vec<BuildItem>) {
    for node in nodes {
        for (lane, child) in node.children.iter().enumerate() {
            if let Some(leaf) = child.leaf() {
                items.push(BuildItem::new(&node.aabb(lane), node.masks[lane], leaf));
            }
        }
    }
}

/// Builds nodes over leaves, which it puts into the order of the tree.
pub(super) fn build_nodes(
    builder: &mut Builder,
    strategy: BuildStrategy,
    items: &mut Vec<BuildItem>,
    nodes: &mut Vec<WideNode>,
    links: &mut Vec<NodeLink>,
) {
    links.clear();
    // Nodes have some five children that are leaves.
    let likely = items.len() / 5;
    if nodes.capacity() < likely {
        *nodes = with_huge_pages(likely);
    }
    let built = builder.build(
        &Order::new(strategy, Leaves::SINGLE),
        items,
        nodes,
        |items, _, _, _| items[0].index(),
        |_, parent, below| {
            links.push(NodeLink {
                parent: parent.map_or(Place::NONE, |(node, lane)| Place::new(node, lane)),
                first: below.start as u32,
                count: below.len() as u32,
                formed_area: 0.0,
            });
        },
    );
    built.expect("nothing calls it off");
}
