//! Many boxes at once.

use std::ops::Range;

use bevy::math::bounding::Aabb3d;
use smallvec::{SmallVec, smallvec};

use super::{
    super::{
        LeafId, UnsoundBox,
        wide::{Child, LANES, NodeIndex},
    },
    Octree,
    cell::{Branch, Cell, Kind, POINT, Place, Spot},
};
use crate::geometry::aabb::{Aabb3dExt, EMPTY};

/// A leaf that is to be built into nodes.
struct Item {
    aabb: Aabb3d,
    spot: Spot,
    leaf: u32,
    /// The [index](Branch::index) of the branch of the node that is being built.
    branch: u8,
}

impl<K: Copy> Octree<K> {
    /// Inserts many leaves: one by one if they are few compared to those that are there, or all are built anew.
    pub(super) fn insert_or_build(
        &mut self,
        leaves: impl IntoIterator<Item = (K, Aabb3d)>,
    ) -> Vec<Result<LeafId, UnsoundBox>> {
        let mut added = Vec::new();
        let results = leaves
            .into_iter()
            .map(|(key, aabb)| {
                if !aabb.is_sound() {
                    return Err(UnsoundBox(aabb));
                }
                let id = self.leaves.add(key, Place::NOWHERE);
                added.push((id.index, aabb));
                Ok(id)
            })
            .collect();
        let before = self.leaves.len() - added.len();
        if added.len() > before {
            self.build(&added);
        } else {
            for (leaf, aabb) in added {
                self.insert_leaf(leaf, &aabb);
            }
        }
        results
    }

    /// Builds all nodes anew, from the leaves that are in them and those that are added.
    fn build(&mut self, added: &[(u32, Aabb3d)]) {
        let item = |leaf, aabb| Item {
            aabb,
            spot: Spot::of(&aabb),
            leaf,
            branch: 0,
        };
        let mut items: Vec<Item> = Vec::with_capacity(self.leaves.len());
        for node in &self.nodes {
            items.extend(node.lanes().filter_map(|(aabb, child)| match child {
                Child::Leaf(leaf) => Some(item(leaf, aabb)),
                Child::Node(_) => None,
            }));
        }
        items.extend(added.iter().map(|&(leaf, aabb)| item(leaf, aabb)));

        self.nodes.clear();
        self.cells.clear();
        self.free.clear();
        let cell = Cell::containing(items.iter().map(|item| (item.spot, POINT)));
        let root = self.new_node(cell);
        self.root = Some(root);
        let mut waiting = vec![(root, 0..items.len())];
        while let Some((node, range)) = waiting.pop() {
            self.fill(node, &mut items, range, &mut waiting);
        }
        for node in (1..self.nodes.len() as NodeIndex).rev() {
            let bounds = self.nodes[node as usize].bounds();
            let place = self.cells[node as usize].parent;
            self.nodes[place.node() as usize].set_aabb(place.lane(), &bounds);
        }
    }

    /// Fills an empty node with some items, in children where they are too many.
    fn fill(
        &mut self,
        node: NodeIndex,
        items: &mut [Item],
        range: Range<usize>,
        waiting: &mut Vec<(NodeIndex, Range<usize>)>,
    ) {
        let mut cell = self.cells[node as usize].clone();
        cell.count = range.len() as u32;
        let mut parts = groups(&cell, &mut items[range.clone()]);
        while let [(branch, _)] = parts[..]
            && range.len() > 1
        {
            let spots = items[range.clone()].iter().map(|item| (item.spot, POINT));
            let Cell { parent, count, .. } = cell;
            cell = Cell {
                parent,
                count,
                ..cell.child(branch, spots)
            };
            parts = groups(&cell, &mut items[range.clone()]);
        }
        self.cells[node as usize] = cell.clone();
        let mut begin = range.start;
        for (branch, len) in parts {
            let members = begin..begin + len;
            begin += len;
            if len == 1 {
                let item = &items[members.start];
                self.push_lane(node, &item.aabb, Child::Leaf(item.leaf));
                continue;
            }
            let spots = items[members.clone()].iter().map(|item| (item.spot, POINT));
            let child = self.new_node(cell.child(branch, spots));
            self.push_lane(node, &EMPTY, Child::Node(child));
            waiting.push((child, members));
        }
    }
}

/// Sorts items into those that share a lane of a node, in order: how many they are, and the branch if more than one.
fn groups(cell: &Cell, items: &mut [Item]) -> Groups {
    if items.len() <= LANES {
        return smallvec![(Branch::Large, 1); items.len()];
    }
    if cell.kind == Kind::Crowd && cell.level == POINT {
        let share = |lane: usize| items.len() * (lane + 1) / LANES - items.len() * lane / LANES;
        return (0..LANES).map(|lane| (Branch::Large, share(lane))).collect();
    }

    let mut lens = [0; Branch::COUNT];
    for item in &mut *items {
        let branch = cell.branch(&item.spot);
        item.branch = branch.index() as u8;
        lens[branch.index()] += 1;
    }
    let mut is_gathered = [false; Branch::COUNT];
    let mut lanes = items.len();
    while lanes > LANES {
        let largest = (0..Branch::COUNT)
            .filter(|&branch| !is_gathered[branch] && lens[branch] > 1)
            .max_by_key(|&branch| lens[branch]);
        let Some(largest) = largest else {
            break;
        };
        is_gathered[largest] = true;
        lanes -= lens[largest] - 1;
    }
    if lanes > LANES {
        // Something in every octant, and something large.
        let (small, large) = (Branch::Small.index(), Branch::Large.index());
        for item in items.iter_mut().filter(|item| item.branch != large as u8) {
            item.branch = small as u8;
        }
        lens[small] = items.len() - lens[large];
        lens[..small].fill(0);
        is_gathered[..small].fill(false);
        is_gathered[small] = true;
    }

    items.sort_unstable_by_key(|item| item.branch);
    let mut groups = Groups::new();
    for (branch, len) in Branch::ALL.into_iter().zip(lens) {
        if is_gathered[branch.index()] {
            groups.push((branch, len));
        } else {
            groups.extend((0..len).map(|_| (branch, 1)));
        }
    }
    groups
}

type Groups = SmallVec<[(Branch, usize); LANES]>;
