//! A dynamic tree of axis-aligned boxes.
//!
//! A binary bounding volume hierarchy (Ericson, *Real-Time Collision Detection*, 2005, §6.6.2): leaves hold the boxes
//! that were stored, each inner node the box around its two children. It is built at once from many boxes
//! ([`build`]), or grows and shrinks one by one ([`insert`]); either way the surface area heuristic decides.
//!
//! # Margins
//!
//! A leaf that moves gets a *node* box grown by a margin, so that the next small moves stay inside of it and cost
//! nothing but a copy. Queries test the exact box, which the leaf keeps beside its node: the margin never shows.

mod build;
mod insert;
mod node;
mod refit;
mod traverse;
mod validate;

pub use validate::BrokenInvariant;

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use self::node::{Leaf, Node, NodeIndex};
use super::{NoSuchLeaf, UnsoundBox};
use crate::geometry::aabb::Aabb3dExt;

/// A leaf of one [`AabbTree`]. Stays valid until the leaf is removed, whatever happens to other leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LeafId {
    index: u32,
    /// Counts the leaves that had this index before, so that a stale id is known as such.
    generation: u32,
}

/// A dynamic tree of axis-aligned boxes, each with a key of type `K`. See the [module](self).
#[derive(Clone, Debug)]
pub struct AabbTree<K> {
    nodes: Vec<Node>,
    free_nodes: Vec<NodeIndex>,
    leaves: Vec<Leaf<K>>,
    free_leaves: Vec<u32>,
    root: Option<NodeIndex>,
    margin: f32,
}

impl<K: Copy> Default for AabbTree<K> {
    fn default() -> Self {
        Self::new(Self::DEFAULT_MARGIN)
    }
}

impl<K: Copy> AabbTree<K> {
    /// The margin of [`AabbTree::default`].
    pub const DEFAULT_MARGIN: f32 = 0.1;

    /// An empty tree, whose moving leaves get a margin of `margin` times the longest side of their box.
    ///
    /// # Panics
    ///
    /// If `margin` is negative, NaN or infinite.
    pub fn new(margin: f32) -> Self {
        assert!(
            margin >= 0.0 && margin.is_finite(),
            "the margin must be finite and not negative, not {margin}"
        );
        Self {
            nodes: Vec::new(),
            free_nodes: Vec::new(),
            leaves: Vec::new(),
            free_leaves: Vec::new(),
            root: None,
            margin,
        }
    }

    /// Adds a leaf.
    ///
    /// # Errors
    ///
    /// If the box is not [sound](Aabb3dExt::is_sound); the tree stays as it was.
    pub fn insert(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox> {
        let id = self.add_leaf(key, aabb)?;
        self.link(id.index, aabb);
        Ok(id)
    }

    /// Removes a leaf and returns its key.
    ///
    /// # Errors
    ///
    /// If there is no such leaf.
    pub fn remove(&mut self, id: LeafId) -> Result<K, NoSuchLeaf> {
        let index = self.live(id)?;
        self.unlink(index);
        let leaf = &mut self.leaves[index as usize];
        leaf.node = None;
        leaf.generation = leaf.generation.wrapping_add(1);
        self.free_leaves.push(index);
        Ok(leaf.key)
    }

    /// Moves a leaf to a new box.
    ///
    /// # Errors
    ///
    /// If there is no such leaf, or if the box is not [sound](Aabb3dExt::is_sound): then the old one stays.
    pub fn update(&mut self, id: LeafId, aabb: Aabb3d) -> Result<(), UpdateError> {
        let index = self.live(id)?;
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb).into());
        }
        let leaf = &mut self.leaves[index as usize];
        leaf.aabb = aabb;
        let node = leaf.node.expect("a live leaf has a node");
        if !self.nodes[node as usize].aabb.contains(&aabb) || self.is_too_loose(node, &aabb) {
            self.unlink(index);
            let margin = Vec3A::splat((aabb.max - aabb.min).max_element() * self.margin);
            let loose = Aabb3d {
                min: aabb.min - margin,
                max: aabb.max + margin,
            };
            self.link(index, if loose.is_sound() { loose } else { aabb });
        }
        Ok(())
    }

    /// Removes all leaves, and keeps the memory.
    pub fn clear(&mut self) {
        for leaf in 0..self.leaves.len() as u32 {
            if let Some(id) = self.id(leaf) {
                self.free_leaves.push(id.index);
                let leaf = &mut self.leaves[leaf as usize];
                leaf.node = None;
                leaf.generation = leaf.generation.wrapping_add(1);
            }
        }
        self.nodes.clear();
        self.free_nodes.clear();
        self.root = None;
    }

    /// The key of a leaf, or `None` if there is no such leaf.
    pub fn key(&self, id: LeafId) -> Option<K> {
        self.live(id).ok().map(|index| self.leaves[index as usize].key)
    }

    /// The box of a leaf as it was last given, or `None` if there is no such leaf.
    pub fn aabb(&self, id: LeafId) -> Option<Aabb3d> {
        self.live(id).ok().map(|index| self.leaves[index as usize].aabb)
    }

    /// The surface area cost: the expected number of nodes that a random ray through the bounds visits.
    ///
    /// The sum of the areas of all nodes over the area of the root (MacDonald and Booth 1990). Zero if the tree is
    /// empty or all its boxes are flat in two directions.
    pub fn sah_cost(&self) -> f32 {
        let Some(root) = self.root else { return 0.0 };
        let area = |node: &Node| f64::from(node.aabb.visible_area());
        let total: f64 = self.linked_nodes().map(|node| area(&self.nodes[node as usize])).sum();
        let whole = area(&self.nodes[root as usize]);
        if whole > 0.0 { (total / whole) as f32 } else { 0.0 }
    }

    /// Whether a node box is so much larger than what it holds that it should be fitted again: a thing that shrank.
    fn is_too_loose(&self, node: NodeIndex, aabb: &Aabb3d) -> bool {
        let node_size = {
            let node = &self.nodes[node as usize].aabb;
            (node.max - node.min).max_element()
        };
        let allowed = 1.0 + 4.0 * self.margin;
        node_size > allowed * (aabb.max - aabb.min).max_element()
    }

    /// Stores a leaf without linking it into the tree.
    fn add_leaf(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox> {
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb));
        }
        let index = self.free_leaves.pop().unwrap_or(self.leaves.len() as u32);
        if index as usize == self.leaves.len() {
            self.leaves.push(Leaf {
                key,
                aabb,
                node: None,
                generation: 0,
            });
        }
        let leaf = &mut self.leaves[index as usize];
        (leaf.key, leaf.aabb) = (key, aabb);
        Ok(LeafId {
            index,
            generation: leaf.generation,
        })
    }

    /// The index of a leaf that is in the tree.
    fn live(&self, id: LeafId) -> Result<u32, NoSuchLeaf> {
        match self.leaves.get(id.index as usize) {
            Some(leaf) if leaf.generation == id.generation && leaf.node.is_some() => Ok(id.index),
            _ => Err(NoSuchLeaf),
        }
    }

    /// The id of the leaf at an index, if it is in the tree.
    fn id(&self, index: u32) -> Option<LeafId> {
        let leaf = &self.leaves[index as usize];
        leaf.node.map(|_| LeafId {
            index,
            generation: leaf.generation,
        })
    }
}

/// Why a leaf was not moved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum UpdateError {
    /// The new box is not sound.
    #[error(transparent)]
    UnsoundBox(#[from] UnsoundBox),
    /// There is no such leaf.
    #[error(transparent)]
    NoSuchLeaf(#[from] NoSuchLeaf),
}
