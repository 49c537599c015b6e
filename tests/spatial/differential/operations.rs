//! A structure and the oracle, changed in the same way.

use bevy::math::bounding::Aabb3d;
use bevy_sightline::spatial::{BruteForce, LeafId, NoSuchLeaf, SpatialUpdates, UpdateError};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::{
    Validate, queries,
    scenes::{Scene, unsound},
};

/// No more leaves than this, mostly.
const LEAVES: usize = 200;

pub struct Pair<T> {
    ours: T,
    oracle: BruteForce<u32>,
    /// The leaves that are there, by both their ids.
    leaves: Vec<(LeafId, LeafId)>,
    /// An id that is not valid any more.
    stale: Option<LeafId>,
    next_key: u32,
    scene: Scene,
    context: String,
}

impl<T: SpatialUpdates<u32> + Validate> Pair<T> {
    pub fn new(ours: T, scene: Scene, context: String) -> Self {
        Self {
            ours,
            oracle: BruteForce::new(),
            leaves: Vec::new(),
            stale: None,
            next_key: 0,
            scene,
            context,
        }
    }

    /// Changes both in one random way, and returns how many boxes have come, moved or gone.
    pub fn change(&mut self, rng: &mut ChaCha8Rng) -> usize {
        // Waves: the number of leaves goes up and down.
        let wanted = LEAVES / 2 + (self.next_key as usize / 3) % LEAVES;
        let inserts = if self.leaves.len() < wanted { 34 } else { 14 };
        let dice = rng.random_range(0..100);
        if self.leaves.is_empty() || dice < inserts {
            self.insert(rng)
        } else if dice < 48 {
            self.remove(rng)
        } else if dice < 86 {
            self.update(rng)
        } else {
            match dice {
                86..90 => self.update_many(rng),
                90..92 => self.insert_many(rng),
                92..95 => self.ask_for_stale(rng),
                95..98 => self.refuse_unsound(rng),
                _ if rng.random_bool(0.02) => self.clear(),
                _ => self.teleport_there_and_back(rng),
            }
        }
    }

    pub fn validate(&self) {
        assert_eq!(self.ours.broken_invariant(), None, "{}", self.context);
    }

    /// Compares everything.
    pub fn compare(&self, rng: &mut ChaCha8Rng) {
        let context = &self.context;
        self.validate();
        for &(ours, theirs) in &self.leaves {
            assert_eq!(self.ours.key(ours), self.oracle.key(theirs), "{context}");
            assert_eq!(self.ours.aabb(ours), self.oracle.aabb(theirs), "{context}");
        }
        queries::compare_all(&self.ours, &self.oracle, self.scene, rng, context);
    }

    /// Removes all leaves one by one.
    pub fn empty(&mut self, rng: &mut ChaCha8Rng) {
        while !self.leaves.is_empty() {
            self.remove(rng);
        }
        self.compare(rng);
    }

    fn insert(&mut self, rng: &mut ChaCha8Rng) -> usize {
        let aabb = self.scene.aabb(rng);
        let ours = self.ours.insert(self.next_key, aabb).expect("a sound box");
        let theirs = self.oracle.insert(self.next_key, aabb).expect("a sound box");
        self.leaves.push((ours, theirs));
        self.next_key += 1;
        1
    }

    fn remove(&mut self, rng: &mut ChaCha8Rng) -> usize {
        let (ours, theirs) = self.leaves.swap_remove(rng.random_range(0..self.leaves.len()));
        assert_eq!(self.ours.remove(ours), self.oracle.remove(theirs), "{}", self.context);
        self.stale = Some(ours);
        1
    }

    /// A new box for a leaf: mostly near the old one.
    fn new_box(&self, leaf: LeafId, rng: &mut ChaCha8Rng) -> Aabb3d {
        let old = self.oracle.aabb(leaf).expect("a leaf");
        if rng.random_bool(0.85) {
            self.scene.nudged(&old, rng)
        } else {
            self.scene.aabb(rng)
        }
    }

    fn update(&mut self, rng: &mut ChaCha8Rng) -> usize {
        let (ours, theirs) = self.leaves[rng.random_range(0..self.leaves.len())];
        let aabb = self.new_box(theirs, rng);
        self.ours.update(ours, aabb).expect("a leaf, and a sound box");
        self.oracle.update(theirs, aabb).expect("a leaf, and a sound box");
        assert_eq!(self.ours.aabb(ours), Some(aabb), "{}", self.context);
        1
    }

    /// Several at once: some twice, some with boxes that are refused, some of leaves that are not there.
    fn update_many(&mut self, rng: &mut ChaCha8Rng) -> usize {
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        let mut refused = Vec::new();
        for _ in 0..rng.random_range(0..12) {
            let (our_id, their_id) = self.leaves[rng.random_range(0..self.leaves.len())];
            match rng.random_range(0..20) {
                0 => {
                    let aabb = unsound(rng);
                    ours.push((our_id, aabb));
                    theirs.push((their_id, aabb));
                    refused.push(our_id);
                }
                1 if self.stale.is_some() => {
                    let stale = self.stale.expect("one");
                    ours.push((stale, self.scene.aabb(rng)));
                    refused.push(stale);
                }
                _ => {
                    let aabb = self.new_box(their_id, rng);
                    ours.push((our_id, aabb));
                    theirs.push((their_id, aabb));
                }
            }
        }
        let (ours, _) = (self.ours.update_many(&ours), self.oracle.update_many(&theirs));
        let mut ours: Vec<LeafId> = ours.into_iter().map(|(id, _)| id).collect();
        ours.sort();
        refused.sort();
        assert_eq!(ours, refused, "{}", self.context);
        theirs.len().max(1)
    }

    fn insert_many(&mut self, rng: &mut ChaCha8Rng) -> usize {
        let count = match rng.random_range(0..20) {
            0 => LEAVES,
            _ => rng.random_range(0..10),
        };
        let boxes: Vec<(u32, Aabb3d)> = (self.next_key..)
            .take(count)
            .map(|key| {
                let is_sound = rng.random_bool(0.95);
                (key, if is_sound { self.scene.aabb(rng) } else { unsound(rng) })
            })
            .collect();
        self.next_key += count as u32;
        let ours = self.ours.insert_many(boxes.iter().copied());
        let theirs = self.oracle.insert_many(boxes);
        assert_eq!(ours.len(), theirs.len(), "{}", self.context);
        for ids in ours.into_iter().zip(theirs) {
            match ids {
                (Ok(ours), Ok(theirs)) => self.leaves.push((ours, theirs)),
                (Err(_), Err(_)) => {}
                (ours, theirs) => panic!("{}: {ours:?}, and the oracle {theirs:?}", self.context),
            }
        }
        count.max(1)
    }

    fn ask_for_stale(&mut self, rng: &mut ChaCha8Rng) -> usize {
        if let Some(stale) = self.stale {
            let aabb = self.scene.aabb(rng);
            let context = &self.context;
            assert_eq!(self.ours.remove(stale), Err(NoSuchLeaf), "{context}");
            assert_eq!(
                self.ours.update(stale, aabb),
                Err(UpdateError::NoSuchLeaf(NoSuchLeaf)),
                "{context}"
            );
            assert_eq!(self.ours.key(stale), None, "{context}");
            assert_eq!(self.ours.aabb(stale), None, "{context}");
        }
        1
    }

    fn refuse_unsound(&mut self, rng: &mut ChaCha8Rng) -> usize {
        let aabb = unsound(rng);
        let context = &self.context;
        assert!(self.ours.insert(0, aabb).is_err(), "{context}");
        let (ours, theirs) = self.leaves[rng.random_range(0..self.leaves.len())];
        let refusal = self.ours.update(ours, aabb);
        assert!(matches!(refusal, Err(UpdateError::UnsoundBox(_))), "{context}");
        assert_eq!(self.ours.aabb(ours), self.oracle.aabb(theirs), "{context}");
        1
    }

    fn clear(&mut self) -> usize {
        let count = self.leaves.len();
        self.stale = self.leaves.first().map(|&(ours, _)| ours);
        self.leaves.clear();
        self.ours.clear();
        self.oracle.clear();
        count.max(1)
    }

    /// Far away, and back to the bit.
    fn teleport_there_and_back(&mut self, rng: &mut ChaCha8Rng) -> usize {
        let (ours, theirs) = self.leaves[rng.random_range(0..self.leaves.len())];
        let old = self.oracle.aabb(theirs).expect("a leaf");
        let away = Scene::ALL[rng.random_range(0..Scene::ALL.len())].aabb(rng);
        self.ours.update(ours, away).expect("a leaf, and a sound box");
        self.ours.update(ours, old).expect("a leaf, and a sound box");
        assert_eq!(self.ours.aabb(ours), Some(old), "{}", self.context);
        2
    }
}
