//! Where something is in the world, and the way back, found when somebody asks.

use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering::*};

use bevy::math::{Affine3A, DAffine3};

/// A transform from local space to the world, with its inverse once that was asked for: most of what moves has moved on
/// before a ray comes near.
///
/// Made of atomic numbers, so that many things may be put elsewhere at once, each by one thread, through a shared
/// reference to all of them. While that goes on nobody may ask: who holds the index alone sees to that.
#[derive(Debug)]
#[repr(C)]
pub(super) struct Placement {
    world_from_local: [AtomicU32; 12],
    /// What is known of the inverse.
    knowledge: AtomicU8,
    local_from_world: [AtomicU64; 12],
}

/// Nobody has asked for the inverse.
const UNKNOWN: u8 = 0;
/// It is there.
const KNOWN: u8 = 1;
/// There is none.
const NONE: u8 = 2;

impl Placement {
    pub fn new(world_from_local: Affine3A) -> Self {
        let placement = Self {
            world_from_local: Default::default(),
            knowledge: AtomicU8::new(UNKNOWN),
            local_from_world: Default::default(),
        };
        placement.put(&world_from_local);
        placement
    }

    /// Puts it somewhere else.
    #[inline]
    pub fn put(&self, world_from_local: &Affine3A) {
        for (cell, value) in self.world_from_local.iter().zip(world_from_local.to_cols_array()) {
            cell.store(value.to_bits(), Relaxed);
        }
        self.knowledge.store(UNKNOWN, Relaxed);
    }

    #[inline]
    pub fn world_from_local(&self) -> Affine3A {
        let columns = self.world_from_local.each_ref();
        Affine3A::from_cols_array(&columns.map(|cell| f32::from_bits(cell.load(Relaxed))))
    }

    /// The inverse, if there is one, which `find` says when it is first asked for.
    #[inline]
    pub fn local_from_world(&self, find: impl FnOnce(&Affine3A) -> Option<DAffine3>) -> Option<DAffine3> {
        match self.knowledge.load(Acquire) {
            KNOWN => {
                let columns = self.local_from_world.each_ref();
                Some(DAffine3::from_cols_array(
                    &columns.map(|cell| f64::from_bits(cell.load(Relaxed))),
                ))
            }
            NONE => None,
            _ => {
                // Whoever else asks meanwhile finds the same.
                let found = find(&self.world_from_local());
                if let Some(found) = found {
                    for (cell, value) in self.local_from_world.iter().zip(found.to_cols_array()) {
                        cell.store(value.to_bits(), Relaxed);
                    }
                }
                let knowledge = if found.is_some() { KNOWN } else { NONE };
                self.knowledge.store(knowledge, Release);
                found
            }
        }
    }
}

impl Clone for Placement {
    fn clone(&self) -> Self {
        Self::new(self.world_from_local())
    }
}
