//! A dynamic tree of axis-aligned boxes.
//!
//! A bounding volume hierarchy (Ericson, *Real-Time Collision Detection*, 2005, §6) with nodes of eight children, as an
//! R-tree has them (Guttman 1984). It is built at once from many boxes, or grows and shrinks one by one; either way
//! surface areas decide what goes together.
//!
//! # Upkeep
//!
//! Queries are exact at any time. That they stay fast takes three things, each as cheap as what it mends:
//!
//! - A leaf that moves stays in its node, and the boxes above are fitted to it.
//! - A leaf that makes its node much larger than it was when it was formed is taken out and inserted anew.
//! - What all this adds up to is watched, and [`optimize`](AabbTree::optimize) builds the tree anew when its nodes have
//!   become noticeably larger than they were.

mod build;
mod front_to_back;
mod half_spaces;
mod insert;
mod masked;
mod quality;
mod rebuild;
mod refit;
mod traverse;
mod validate;

pub(crate) use front_to_back::{Judge, Waiting};
pub(crate) use half_spaces::{HalfSpaces, Open, Sides};
pub use masked::Masked;
pub use rebuild::{Rebuild, Rebuilt};
pub use validate::BrokenInvariant;

use bevy::math::bounding::Aabb3d;

use super::{
    LeafId, NoSuchLeaf, SpatialUpdates, UnsoundBox, UpdateError,
    build::{BuildItem, Builder, sah_cost},
    leaves::Leaves,
    query::Descend,
    wide::{EVERY_MASK, NodeIndex, WideNode},
};
use crate::geometry::aabb::Aabb3dExt;
use quality::Quality;

/// A dynamic tree of axis-aligned boxes, each with a key of type `K`. See the [module](self).
///
/// Holds up to 2²⁹ leaves.
#[derive(Clone, Debug)]
pub struct AabbTree<K> {
    nodes: Vec<WideNode>,
    /// What is known of each node besides.
    links: Vec<NodeLink>,
    free_nodes: Vec<NodeIndex>,
    root: Option<NodeIndex>,
    leaves: Leaves<K, Place>,
    /// The keys of all leaves as the last build has put them: what is below a node is one slice.
    ordered: Vec<K>,
    quality: Quality,
    scratch: Scratch,
}

/// A lane of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place(u32);

impl Place {
    /// The place of a root.
    const NONE: Self = Self(u32::MAX);

    #[inline]
    fn new(node: NodeIndex, lane: usize) -> Self {
        debug_assert!(node < u32::MAX >> 3 && lane < 8);
        Self(node << 3 | lane as u32)
    }

    #[inline]
    fn node(self) -> NodeIndex {
        self.0 >> 3
    }

    #[inline]
    fn lane(self) -> usize {
        (self.0 & 7) as usize
    }
}

/// What belongs to a node and queries seldom need.
#[derive(Clone, Copy, Debug)]
struct NodeLink {
    parent: Place,
    /// The slice of [`AabbTree::ordered`] with the keys below this node; empty if they are not known as a slice.
    first: u32,
    count: u32,
    /// The area of the box around the children when they were brought together.
    formed_area: f32,
}

impl Scratch {
    fn memory(&self) -> usize {
        self.dirty.capacity() * size_of::<u64>()
            + self.strays.capacity() * size_of::<u32>()
            + self.items.capacity() * size_of::<BuildItem>()
            + self.builder.memory()
    }
}

/// Buffers, kept for their memory.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// A bit for each node that is to be fitted to its children.
    dirty: Vec<u64>,
    /// Leaves that are to be inserted anew.
    strays: Vec<u32>,
    items: Vec<BuildItem>,
    builder: Builder,
}

impl<K: Copy> Default for AabbTree<K> {
    fn default() -> Self {
        Self::new()
    }
}

impl<K: Copy> AabbTree<K> {
    /// An empty tree.
    pub fn new() -> Self {
        Self {
            nodes: Vec::new(),
            links: Vec::new(),
            free_nodes: Vec::new(),
            root: None,
            leaves: Leaves::default(),
            ordered: Vec::new(),
            quality: Quality::default(),
            scratch: Scratch::default(),
        }
    }

    /// Adds a leaf with a mask: the bits that stand for what the leaf is in. Queries through
    /// [`masked`](Self::masked) pass over whole subtrees by them. Without a bit it is never found, though `visit_all` visits it;
    /// other ways to insert set all bits.
    ///
    /// # Errors
    ///
    /// If the box is not [sound](Aabb3dExt::is_sound); the tree stays as it was.
    pub fn insert_masked(&mut self, key: K, aabb: Aabb3d, mask: u32) -> Result<LeafId, UnsoundBox> {
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb));
        }
        let id = self.leaves.add(key, Place::NONE);
        self.link(id.index, &aabb, mask);
        Ok(id)
    }

    /// The mask of a leaf, or `None` if there is no such leaf.
    pub fn mask(&self, id: LeafId) -> Option<u32> {
        let place = self.leaves.place(id).ok()?;
        Some(self.nodes[place.node() as usize].masks[place.lane()])
    }

    /// Gives a leaf another mask.
    ///
    /// # Errors
    ///
    /// If there is no such leaf.
    pub fn set_mask(&mut self, id: LeafId, mask: u32) -> Result<(), NoSuchLeaf> {
        let place = self.leaves.place(id)?;
        self.nodes[place.node() as usize].masks[place.lane()] = mask;
        if mask == 0 {
            self.break_slices(place.node());
        }
        self.refit_above(place.node());
        Ok(())
    }

    /// The same leaves, of which queries see those that have a bit of `mask`.
    pub fn masked(&self, mask: u32) -> Masked<'_, K> {
        Masked { tree: self, mask }
    }

    /// The surface area cost: the expected number of boxes that a random ray through the bounds meets.
    ///
    /// The sum of the areas of all boxes over the area of the bounds (MacDonald and Booth 1990). Zero if the tree is
    /// empty; the number of boxes where the bounds have no area.
    pub fn sah_cost(&self) -> f32 {
        self.root.map_or(0.0, |root| sah_cost(&self.nodes, root) as f32)
    }

    /// The number of nodes on the longest way from the root to a leaf.
    pub fn depth(&self) -> usize {
        self.linked_nodes().map(|(_, depth)| depth + 1).max().unwrap_or(0)
    }

    /// Visits every node with its depth, zero for the root, and its box, depth first: what is below a node comes right
    /// after it.
    pub fn visit_nodes(&self, mut visit: impl FnMut(usize, &Aabb3d)) {
        self.linked_nodes()
            .for_each(|(node, depth)| visit(depth, &self.nodes[node as usize].bounds()));
    }

    /// The same, and goes below a node only where `visit` says so.
    pub fn descend_nodes(&self, mut visit: impl FnMut(usize, &Aabb3d) -> Descend) {
        let mut stack: Vec<(NodeIndex, usize)> = self.root.map(|root| (root, 0)).into_iter().collect();
        while let Some((node, depth)) = stack.pop() {
            let node = &self.nodes[node as usize];
            match visit(depth, &node.bounds()) {
                Descend::Into => {}
                Descend::Past => continue,
                Descend::Stop => return,
            }
            stack.extend(
                node.children
                    .iter()
                    .filter_map(|child| Some((child.node()?, depth + 1))),
            );
        }
    }

    /// All nodes that are in the tree with their depths, parents before children.
    fn linked_nodes(&self) -> impl Iterator<Item = (NodeIndex, usize)> + '_ {
        let mut stack: Vec<(NodeIndex, usize)> = self.root.map(|root| (root, 0)).into_iter().collect();
        std::iter::from_fn(move || {
            let (node, depth) = stack.pop()?;
            stack.extend(self.nodes[node as usize].lanes().filter_map(|(_, child)| match child {
                super::wide::Child::Node(node) => Some((node, depth + 1)),
                super::wide::Child::Leaf(_) => None,
            }));
            Some((node, depth))
        })
    }

    /// The box of a leaf that is in the tree.
    fn aabb_at(&self, place: Place) -> Aabb3d {
        self.nodes[place.node() as usize].aabb(place.lane())
    }
}

impl<K: Copy> SpatialUpdates<K> for AabbTree<K> {
    fn insert(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox> {
        self.insert_masked(key, aabb, EVERY_MASK)
    }

    /// Builds the whole tree anew where that is cheaper than to insert one by one.
    fn insert_many(&mut self, leaves: impl IntoIterator<Item = (K, Aabb3d)>) -> Vec<Result<LeafId, UnsoundBox>> {
        self.insert_many_masked(leaves.into_iter().map(|(key, aabb)| (key, aabb, EVERY_MASK)))
    }

    fn remove(&mut self, id: LeafId) -> Result<K, NoSuchLeaf> {
        let (key, place) = self.leaves.remove(id)?;
        self.remove_child(place);
        Ok(key)
    }

    fn update(&mut self, id: LeafId, aabb: Aabb3d) -> Result<(), UpdateError> {
        let place = self.leaves.place(id)?;
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb).into());
        }
        self.refit(place, &aabb);
        Ok(())
    }

    fn update_many(&mut self, updates: &[(LeafId, Aabb3d)]) -> Vec<(LeafId, UpdateError)> {
        self.refit_parts(std::iter::once(updates))
    }

    fn clear(&mut self) {
        self.leaves.clear();
        self.nodes.clear();
        self.links.clear();
        self.free_nodes.clear();
        self.ordered.clear();
        self.root = None;
        self.quality = Quality::default();
    }

    fn key(&self, id: LeafId) -> Option<K> {
        self.leaves.key(id)
    }

    fn aabb(&self, id: LeafId) -> Option<Aabb3d> {
        self.leaves.place(id).ok().map(|place| self.aabb_at(place))
    }
}
