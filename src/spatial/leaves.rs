//! Handles of what a structure stores, and the table behind them.

use super::{NoSuchLeaf, simd::prefetch};

/// A leaf of one structure: one box with its key. Stays valid until the leaf is removed, whatever happens to others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LeafId {
    pub(crate) index: u32,
    /// Counts the leaves that had this index before, so that a stale id is known as such.
    generation: u32,
}

/// The leaves of a structure: the key of each, and its place, which means something to the structure alone.
///
/// Indices are dense, and those of leaves that were removed are used again, the last removed first.
#[derive(Clone, Debug)]
pub(crate) struct Leaves<K, P> {
    keys: Vec<K>,
    /// Apart from the keys: queries need only those, and updates only these.
    places: Vec<P>,
    /// Odd while the leaf is there.
    generations: Vec<u32>,
    free: Vec<u32>,
}

impl<K, P> Default for Leaves<K, P> {
    fn default() -> Self {
        Self {
            keys: Vec::new(),
            places: Vec::new(),
            generations: Vec::new(),
            free: Vec::new(),
        }
    }
}

impl<K: Copy, P: Copy> Leaves<K, P> {
    /// The number of leaves.
    pub fn len(&self) -> usize {
        self.keys.len() - self.free.len()
    }

    /// All indices that are or were in use are below this.
    pub fn capacity(&self) -> usize {
        self.keys.len()
    }

    /// Adds a leaf.
    pub fn add(&mut self, key: K, place: P) -> LeafId {
        let index = match self.free.pop() {
            Some(index) => {
                self.keys[index as usize] = key;
                self.places[index as usize] = place;
                index
            }
            None => {
                self.keys.push(key);
                self.places.push(place);
                self.generations.push(0);
                (self.keys.len() - 1) as u32
            }
        };
        let generation = &mut self.generations[index as usize];
        *generation = generation.wrapping_add(1);
        LeafId {
            index,
            generation: *generation,
        }
    }

    /// Removes a leaf, and returns its key and its place.
    pub fn remove(&mut self, id: LeafId) -> Result<(K, P), NoSuchLeaf> {
        let place = self.place(id)?;
        self.retire(id.index);
        Ok((self.keys[id.index as usize], place))
    }

    /// Removes all leaves, and keeps the memory.
    pub fn clear(&mut self) {
        for index in (0..self.capacity() as u32).rev() {
            if self.is_live(index) {
                self.retire(index);
            }
        }
    }

    fn retire(&mut self, index: u32) {
        let generation = &mut self.generations[index as usize];
        *generation = generation.wrapping_add(1);
        self.free.push(index);
    }

    /// Whether there is a leaf with this index.
    pub fn is_live(&self, index: u32) -> bool {
        self.generations[index as usize] % 2 == 1
    }

    /// How often the leaf with this index has come and gone.
    pub fn generation_at(&self, index: u32) -> u32 {
        self.generations[index as usize]
    }

    /// The same of all indices.
    pub fn generations(&self) -> &[u32] {
        &self.generations
    }

    /// The indices of all leaves, in ascending order.
    pub fn live(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.capacity() as u32).filter(|&index| self.is_live(index))
    }

    /// The key of the leaf with this index.
    #[inline]
    pub fn key_at(&self, index: u32) -> K {
        self.keys[index as usize]
    }

    /// The place of the leaf with this index.
    #[inline]
    pub fn place_at(&self, index: u32) -> P {
        self.places[index as usize]
    }

    #[inline]
    pub fn set_place_at(&mut self, index: u32, place: P) {
        self.places[index as usize] = place;
    }

    /// The key of a leaf.
    pub fn key(&self, id: LeafId) -> Option<K> {
        self.place(id).ok().map(|_| self.key_at(id.index))
    }

    /// The place of a leaf.
    #[inline]
    pub fn place(&self, id: LeafId) -> Result<P, NoSuchLeaf> {
        match self.generations.get(id.index as usize) {
            Some(&generation) if generation == id.generation => Ok(self.place_at(id.index)),
            _ => Err(NoSuchLeaf),
        }
    }

    /// Asks for the place of a leaf to be brought close.
    #[inline]
    pub fn prefetch(&self, id: LeafId) {
        if let (Some(generation), Some(place)) = (
            self.generations.get(id.index as usize),
            self.places.get(id.index as usize),
        ) {
            prefetch(generation);
            prefetch(place);
        }
    }

    /// Whether the free list holds exactly the indices that are not in use.
    pub fn is_whole(&self) -> bool {
        let mut is_free = vec![false; self.capacity()];
        let each_once = self
            .free
            .iter()
            .all(|&index| !std::mem::replace(&mut is_free[index as usize], true));
        each_once && (0..self.capacity() as u32).all(|index| is_free[index as usize] != self.is_live(index))
    }

    /// The bytes of memory in use.
    pub fn memory(&self) -> usize {
        self.keys.capacity() * size_of::<K>()
            + self.places.capacity() * size_of::<P>()
            + (self.generations.capacity() + self.free.capacity()) * size_of::<u32>()
    }
}
