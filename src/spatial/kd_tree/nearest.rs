//! The nearest found so far.

use crate::spatial::Neighbour;

/// The `k` nearest found so far, from near to far, and of those at one distance the smaller keys first.
pub(super) struct Nearest<'a, K> {
    found: &'a mut Vec<Neighbour<K>>,
    k: usize,
}

impl<'a, K: Copy + Ord> Nearest<'a, K> {
    /// None yet. `k` must not be zero.
    pub(super) fn new(found: &'a mut Vec<Neighbour<K>>, k: usize) -> Self {
        found.clear();
        Self { found, k }
    }

    /// Takes one in, unless `k` are before it. Once there are `k`, lowers the limit to the distance of the last.
    #[inline(always)]
    pub(super) fn offer(&mut self, key: K, distance_squared: f32, limit: &mut f32) {
        let new = Neighbour { key, distance_squared };
        let is_before = |other: &Neighbour<K>| {
            distance_squared < other.distance_squared || distance_squared == other.distance_squared && key < other.key
        };
        let found = &mut *self.found;
        if found.len() == self.k {
            if !found.last().is_some_and(is_before) {
                return;
            }
        } else {
            found.push(new);
        }
        let mut place = found.len() - 1;
        while place > 0 && is_before(&found[place - 1]) {
            found[place] = found[place - 1];
            place -= 1;
        }
        found[place] = new;
        if found.len() == self.k {
            *limit = found[self.k - 1].distance_squared;
        }
    }
}
