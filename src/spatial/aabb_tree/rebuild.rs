//! Building the tree anew beside its use: on another thread, while the tree changes.

use super::{
    AabbTree, NodeLink, Place,
    build::{build_nodes, gather},
};
use crate::spatial::{
    BuildStrategy, LeafId, SpatialUpdates,
    build::{BuildItem, Builder},
    wide::{Child, LANES, PackedChild, WideNode},
};

/// The leaves of a tree as they were at one time, to be built into a new one: see [`AabbTree::begin_rebuild`].
#[derive(Debug)]
pub struct Rebuild {
    items: Vec<BuildItem>,
    /// By which leaves that are not the same any more are known.
    generations: Vec<u32>,
}

/// A tree that was built beside the one in use: see [`AabbTree::adopt`].
#[derive(Debug)]
pub struct Rebuilt {
    nodes: Vec<WideNode>,
    links: Vec<NodeLink>,
    /// In the order of the tree.
    items: Vec<BuildItem>,
    generations: Vec<u32>,
}

impl Rebuild {
    /// Builds the new tree. This is what takes the time, and may be done on any thread.
    pub fn run(mut self) -> Rebuilt {
        let (mut nodes, mut links) = (Vec::new(), Vec::new());
        let strategy = BuildStrategy::default();
        build_nodes(
            &mut Builder::default(),
            strategy,
            &mut self.items,
            &mut nodes,
            &mut links,
        );
        Rebuilt {
            nodes,
            links,
            items: self.items,
            generations: self.generations,
        }
    }
}

impl<K: Copy> AabbTree<K> {
    /// Copies what is needed to build this tree anew elsewhere, while it is in use and changes.
    pub fn begin_rebuild(&self) -> Rebuild {
        let mut items = Vec::with_capacity(self.leaves.len());
        gather(&self.nodes, &mut items);
        Rebuild {
            items,
            generations: self.leaves.generations().to_vec(),
        }
    }

    /// Takes over a tree that was [begun](Self::begin_rebuild) from this one, whatever has changed in the meantime: boxes
    /// are as they are now, leaves that were removed are not there, and those that were added are.
    ///
    /// Takes a fraction of the time of a [`rebuild`](Self::rebuild). What was begun from another tree is of no use, and
    /// does no harm.
    pub fn adopt(&mut self, rebuilt: Rebuilt) {
        let Rebuilt {
            mut nodes,
            links,
            items,
            generations,
        } = rebuilt;
        if generations.len() > self.leaves.capacity() {
            return;
        }

        // What the new tree does not know, as it is now.
        let added: Vec<BuildItem> = (self.leaves.live())
            .filter(|&index| generations.get(index as usize) != Some(&self.leaves.generation_at(index)))
            .map(|index| {
                let place = self.leaves.place_at(index);
                let lanes = &self.nodes[place.node() as usize];
                BuildItem::new(&lanes.aabb(place.lane()), lanes.masks[place.lane()], index)
            })
            .collect();

        // What it knows, as it is now. What is gone gets a new name, under which it can be removed like any leaf.
        let mut gone: Vec<LeafId> = Vec::new();
        let mut lost: Vec<(usize, usize, u32)> = Vec::new();
        for (at, node) in nodes.iter_mut().enumerate() {
            for lane in 0..LANES {
                let Some(index) = node.children[lane].leaf() else {
                    continue;
                };
                if generations[index as usize] == self.leaves.generation_at(index) {
                    let place = self.leaves.place_at(index);
                    let lanes = &self.nodes[place.node() as usize];
                    node.set(
                        lane,
                        &lanes.aabb(place.lane()),
                        lanes.masks[place.lane()],
                        Child::Leaf(index),
                    );
                } else {
                    lost.push((at, lane, index));
                }
            }
        }
        for (at, lane, index) in lost {
            let id = self.leaves.add(self.leaves.key_at(index), Place::NONE);
            nodes[at].children[lane] = PackedChild::pack(Child::Leaf(id.index));
            gone.push(id);
        }

        for node in (1..nodes.len()).rev() {
            let (mask, parent) = (nodes[node].mask(), links[node].parent);
            nodes[parent.node() as usize].masks[parent.lane()] = mask;
        }
        (self.nodes, self.links) = (nodes, links);
        self.install(&items);
        self.refit_all();
        self.measure();
        for id in gone {
            self.remove(id).expect("a leaf that was just added");
        }
        for item in added {
            self.link(item.index(), &item.aabb(), item.mask());
        }
    }
}
