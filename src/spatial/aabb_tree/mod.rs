//! A dynamic tree of axis-aligned boxes.
//!
//! A bounding volume hierarchy (Ericson, *Real-Time Collision Detection*, 2005, §6) with nodes of eight children, as an
//! R-tree has them (Guttman 1984). It is built at once from many boxes ([`AabbTree::insert_many`]), or grows and shrinks
//! one by one ([`AabbTree::insert`]); either way surface areas decide what goes together.
//!
//! # Margins
//!
//! A leaf that moves stays in its node, and the boxes above are fitted to it, until it has left the box that it was
//! inserted with by a margin: then it is inserted anew, where it belongs by now. Queries always see the exact boxes.

mod build;
mod insert;
mod refit;
mod traverse;
mod validate;

pub use validate::BrokenInvariant;

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use super::{
    NoSuchLeaf, UnsoundBox,
    wide::{NodeIndex, WideNode},
};
use crate::geometry::aabb::Aabb3dExt;

/// A leaf of one [`AabbTree`]. Stays valid until the leaf is removed, whatever happens to other leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LeafId {
    index: u32,
    /// Counts the leaves that had this index before, so that a stale id is known as such.
    generation: u32,
}

/// A dynamic tree of axis-aligned boxes, each with a key of type `K`. See the [module](self).
///
/// Holds up to 2³¹ leaves.
#[derive(Clone, Debug)]
pub struct AabbTree<K> {
    nodes: Vec<WideNode>,
    /// Where each node is held; `None` for the root.
    parents: Vec<Option<Place>>,
    free_nodes: Vec<NodeIndex>,
    leaves: Vec<Leaf>,
    /// The key of each leaf: apart from the rest, for queries need nothing else.
    keys: Vec<K>,
    free_leaves: Vec<u32>,
    root: Option<NodeIndex>,
    margin: f32,
}

/// A lane of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    node: NodeIndex,
    lane: u32,
}

#[derive(Clone, Copy, Debug)]
struct Leaf {
    /// `None` while the leaf is not in the tree.
    place: Option<Place>,
    generation: u32,
    /// The leaf is inserted anew when it leaves this box.
    allowance: Aabb3d,
}

impl<K: Copy> Default for AabbTree<K> {
    fn default() -> Self {
        Self::new(Self::DEFAULT_MARGIN)
    }
}

impl<K: Copy> AabbTree<K> {
    /// The margin of [`AabbTree::default`].
    pub const DEFAULT_MARGIN: f32 = 0.5;

    /// An empty tree. A leaf may move by `margin` times the longest side of its box before it is inserted anew.
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
            parents: Vec::new(),
            free_nodes: Vec::new(),
            leaves: Vec::new(),
            keys: Vec::new(),
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
        let id = self.add_leaf(key, &aabb)?;
        self.link(id.index, &aabb);
        Ok(id)
    }

    /// Removes a leaf and returns its key.
    ///
    /// # Errors
    ///
    /// If there is no such leaf.
    pub fn remove(&mut self, id: LeafId) -> Result<K, NoSuchLeaf> {
        self.place(id)?;
        self.unlink(id.index);
        self.retire(id.index);
        Ok(self.keys[id.index as usize])
    }

    /// Moves a leaf to a new box.
    ///
    /// # Errors
    ///
    /// If there is no such leaf, or if the box is not [sound](Aabb3dExt::is_sound): then the old one stays.
    pub fn update(&mut self, id: LeafId, aabb: Aabb3d) -> Result<(), UpdateError> {
        let place = self.place(id)?;
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb).into());
        }
        if self.leaves[id.index as usize].allowance.contains(&aabb) {
            self.nodes[place.node as usize].set_aabb(place.lane as usize, &aabb);
            self.refit_above(place.node);
        } else {
            self.unlink(id.index);
            self.leaves[id.index as usize].allowance = self.allowance(&aabb);
            self.link(id.index, &aabb);
        }
        Ok(())
    }

    /// Removes all leaves, and keeps the memory.
    pub fn clear(&mut self) {
        for index in 0..self.leaves.len() as u32 {
            if self.leaves[index as usize].place.take().is_some() {
                self.retire(index);
            }
        }
        self.nodes.clear();
        self.parents.clear();
        self.free_nodes.clear();
        self.root = None;
    }

    /// The key of a leaf, or `None` if there is no such leaf.
    pub fn key(&self, id: LeafId) -> Option<K> {
        self.place(id).ok().map(|_| self.keys[id.index as usize])
    }

    /// The box of a leaf as it was last given, or `None` if there is no such leaf.
    pub fn aabb(&self, id: LeafId) -> Option<Aabb3d> {
        let place = self.place(id).ok()?;
        Some(self.nodes[place.node as usize].aabb(place.lane as usize))
    }

    /// The surface area cost: the expected number of boxes that a random ray through the bounds meets.
    ///
    /// The sum of the areas of all boxes over the area of the bounds (MacDonald and Booth 1990). Zero if the tree is
    /// empty or all its boxes are flat in two directions.
    pub fn sah_cost(&self) -> f32 {
        let Some(root) = self.root else { return 0.0 };
        let area = |aabb: &Aabb3d| f64::from(aabb.visible_area());
        let total: f64 = self
            .linked_nodes()
            .flat_map(|node| self.nodes[node as usize].lanes())
            .map(|(aabb, _)| area(&aabb))
            .sum();
        let whole = area(&self.nodes[root as usize].bounds());
        if whole > 0.0 { (total / whole) as f32 } else { 0.0 }
    }

    /// Stores a leaf without linking it into the tree.
    fn add_leaf(&mut self, key: K, aabb: &Aabb3d) -> Result<LeafId, UnsoundBox> {
        if !aabb.is_sound() {
            return Err(UnsoundBox(*aabb));
        }
        let allowance = self.allowance(aabb);
        let index = match self.free_leaves.pop() {
            Some(index) => {
                self.keys[index as usize] = key;
                self.leaves[index as usize].allowance = allowance;
                index
            }
            None => {
                self.keys.push(key);
                self.leaves.push(Leaf {
                    place: None,
                    generation: 0,
                    allowance,
                });
                (self.leaves.len() - 1) as u32
            }
        };
        Ok(LeafId {
            index,
            generation: self.leaves[index as usize].generation,
        })
    }

    /// Frees the index of a leaf that has been unlinked.
    fn retire(&mut self, index: u32) {
        let leaf = &mut self.leaves[index as usize];
        leaf.generation = leaf.generation.wrapping_add(1);
        self.free_leaves.push(index);
    }

    /// Where a leaf may go before it is inserted anew.
    fn allowance(&self, aabb: &Aabb3d) -> Aabb3d {
        let margin = Vec3A::splat((aabb.max - aabb.min).max_element() * self.margin);
        Aabb3d {
            min: aabb.min - margin,
            max: aabb.max + margin,
        }
    }

    /// Where a leaf is.
    fn place(&self, id: LeafId) -> Result<Place, NoSuchLeaf> {
        let leaf = self.leaves.get(id.index as usize).ok_or(NoSuchLeaf)?;
        let place = leaf.place.filter(|_| leaf.generation == id.generation);
        place.ok_or(NoSuchLeaf)
    }

    /// The indices of all leaves that are in the tree.
    fn linked_leaves(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.leaves.len() as u32).filter(|&index| self.leaves[index as usize].place.is_some())
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
