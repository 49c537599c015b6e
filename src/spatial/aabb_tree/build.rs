//! Building the whole tree at once.

use bevy::math::bounding::Aabb3d;

use super::{
    AabbTree, NodeLink, Place,
    quality::{Quality, area},
};
use crate::{
    geometry::aabb::Aabb3dExt,
    spatial::{
        BuildStrategy, LeafId, UnsoundBox,
        build::BuildItem,
        wide::{Child, LANES},
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
            self.gather(&mut items);
            self.build(BuildStrategy::default(), &mut items);
        } else {
            for item in &items {
                self.link(item.index(), &item.aabb(), item.mask());
            }
        }
        self.scratch.items = items;
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
        self.gather(&mut items);
        self.build(strategy, &mut items);
        self.scratch.items = items;
    }

    /// Adds all leaves that are in the tree.
    fn gather(&self, items: &mut Vec<BuildItem>) {
        for node in &self.nodes {
            for lane in 0..LANES {
                if let Some(leaf) = node.children[lane].leaf() {
                    items.push(BuildItem::new(&node.aabb(lane), node.masks[lane], leaf));
                }
            }
        }
    }

    /// Replaces all nodes by a hierarchy over these leaves.
    fn build(&mut self, strategy: BuildStrategy, items: &mut Vec<BuildItem>) {
        let Self {
            nodes,
            links,
            leaves,
            ordered,
            ..
        } = self;
        links.clear();
        ordered.clear();
        self.scratch.builder.build(
            strategy,
            1,
            items,
            nodes,
            |items, _, node, lane| {
                let leaf = items[0].index();
                ordered.push(leaves.key_at(leaf));
                leaves.set_place_at(leaf, Place::new(node, lane));
                leaf
            },
            |_, parent, below| {
                links.push(NodeLink {
                    parent: parent.map_or(Place::NONE, |(node, lane)| Place::new(node, lane)),
                    first: below.start as u32,
                    count: below.len() as u32,
                    formed_area: 0.0,
                });
            },
        );
        self.free_nodes.clear();
        self.root = (!self.nodes.is_empty()).then_some(0);

        let mut node_area = 0.0;
        for node in &self.nodes {
            for lane in 0..LANES {
                if let Child::Node(child) = node.child(lane) {
                    let area = area(&node.aabb(lane));
                    node_area += area;
                    self.links[child as usize].formed_area = area as f32;
                }
            }
        }
        let root_area = self.nodes.first().map_or(0.0, |root| area(&root.bounds()));
        self.quality = Quality::of_new(node_area, root_area);
    }
}
