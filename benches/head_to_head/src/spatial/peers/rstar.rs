//! rstar, bulk-loaded.

use bevy::math::{Vec3A, bounding::Aabb3d};
use rstar::{AABB, PointDistance, RTree, RTreeObject, SelectionFunction};

use super::{Nearest, corners};
use crate::spatial::{
    probes::{Probe, Relation},
    queries::{Found, NearQueries, PairQueries, RegionQueries, Scratch, distance_squared},
};

pub(crate) const NAME: &str = "rstar 0.14";

pub(crate) struct Rstar {
    tree: RTree<Leaf>,
}

impl Rstar {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        let leaf = |(key, aabb)| {
            let [min, max] = corners(aabb);
            Leaf {
                envelope: AABB::from_bounds(min, max),
                key,
            }
        };
        Self {
            tree: RTree::bulk_load((0..).zip(boxes).map(leaf).collect()),
        }
    }
}

impl RegionQueries for Rstar {
    fn find<P: Probe>(&self, probe: &P) -> Found {
        let mut found = Found::default();
        if let Some(region) = probe.as_aabb() {
            let [min, max] = corners(region);
            self.tree
                .locate_in_envelope_intersecting(AABB::from_bounds(min, max))
                .for_each(|leaf| found.add(leaf.key));
        } else {
            self.tree
                .locate_with_selection_function(Select(probe))
                .for_each(|leaf| found.add(leaf.key));
        }
        found
    }
}

impl PairQueries for Rstar {
    fn pairs(&self) -> Found {
        let mut found = Found::default();
        for (a, b) in self.tree.intersection_candidates_with_other_tree(&self.tree) {
            if a.key < b.key {
                found.add_pair(a.key, b.key);
            }
        }
        found
    }
}

impl NearQueries for Rstar {
    fn nearest<const N: usize>(&self, point: Vec3A, _: &mut Scratch) -> [f32; N] {
        let mut nearest = Nearest::<N>::new();
        for (leaf, distance_squared) in self
            .tree
            .nearest_neighbor_iter_with_distance_2(point.to_array())
            .take(N)
        {
            nearest.add(leaf.key, distance_squared);
        }
        nearest.distances_squared
    }
}

/// A box with its key.
struct Leaf {
    envelope: AABB<[f32; 3]>,
    key: u32,
}

impl RTreeObject for Leaf {
    type Envelope = AABB<[f32; 3]>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

impl PointDistance for Leaf {
    fn distance_2(&self, point: &[f32; 3]) -> f32 {
        let (min, max) = bounds(&self.envelope);
        distance_squared(Vec3A::from_array(*point), min, max)
    }
}

/// Selects what touches a region.
struct Select<'a, P>(&'a P);

impl<P: Probe> SelectionFunction<Leaf> for Select<'_, P> {
    fn should_unpack_parent(&self, envelope: &AABB<[f32; 3]>) -> bool {
        let (min, max) = bounds(envelope);
        self.0.relation(min, max) != Relation::Apart
    }

    fn should_unpack_leaf(&self, leaf: &Leaf) -> bool {
        let (min, max) = bounds(&leaf.envelope);
        self.0.touches(min, max)
    }
}

#[inline]
fn bounds(envelope: &AABB<[f32; 3]>) -> (Vec3A, Vec3A) {
    (Vec3A::from_array(envelope.lower()), Vec3A::from_array(envelope.upper()))
}
