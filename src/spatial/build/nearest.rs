//! For every cluster, the nearest of those that are close along the curve.

use std::hint::select_unpredictable;

use super::tagged_box::BinaryNode;
use crate::spatial::simd::{LANES, Simd};

/// How far along the curve a cluster looks, on either side. Measured: with 1, what is clustered is torn apart; from 4 on,
/// what is uniform becomes worse again, for large clusters outgrow small ones.
pub(super) const RADIUS: usize = 3;
/// So many clusters are looked at in one go.
pub(super) const WINDOW: usize = 256;
/// Room before and behind a window.
pub(super) const MARGIN: usize = LANES;

/// The area around two clusters, the least bits of which are replaced by a tag that tells the two from all other
/// candidates of either: the distance along the curve, less one, and then which of the two sides the other is on.
///
/// As both see the same key, two clusters are nearest to each other if and only if their least keys are equal. The tag
/// decides between equal areas. Then pairs of neighbours that begin at even places come first, so that equal clusters
/// find each other two by two, and not each the one before.
pub(super) type Key = f32;

const TAG_BITS: u32 = 7;

/// The key that no two clusters have.
pub(super) const NO_KEY: Key = f32::NAN;

/// The key that, if all have it, pairs every two neighbours.
pub(super) const EVERY_TWO: Key = 0.0;

/// By which the pairs of clusters are told apart that begin at odd and at even multiples of their distance, more or less:
/// the lowest bit of the distance flips between the two.
#[inline(always)]
const fn side(place: usize, distance: usize) -> u32 {
    (place >> distance.trailing_zeros()) as u32 & 1
}

/// The tags of pairs, by the places of the first modulo eight, and by distance.
const TAGS: [[u32; LANES]; RADIUS] = {
    let mut tags = [[0; LANES]; RADIUS];
    let mut place = 0;
    while place < LANES {
        let mut distance = 1;
        while distance <= RADIUS {
            tags[distance - 1][place] = 2 * (distance as u32 - 1) + side(place, distance);
            distance += 1;
        }
        place += 1;
    }
    tags
};

/// The place of the cluster that is nearest to the one at `place`.
#[inline(always)]
pub(super) fn other(place: usize, key: Key) -> usize {
    let tag = key.to_bits() & TAG_BITS;
    let distance = (tag >> 1) as usize + 1;
    let follows = side(place, distance) == tag & 1;
    select_unpredictable(follows, place + distance, place.wrapping_sub(distance))
}

/// Finds the least keys of clusters, window by window.
pub(super) struct Search {
    /// The bounds of the clusters of a window and a few more.
    bounds: [[f32; WINDOW + MARGIN]; 6],
    /// The keys of the clusters of a window, and of a few before, each with the one that is so much farther.
    keys: [[Key; MARGIN + WINDOW]; RADIUS],
}

impl Search {
    pub(super) const fn new() -> Self {
        Self {
            bounds: [[0.0; WINDOW + MARGIN]; 6],
            keys: [[f32::INFINITY; MARGIN + WINDOW]; RADIUS],
        }
    }

    /// Finds the keys of the window that begins at `start`, and writes them over `least`, up to seven too many. To be
    /// called for one window after the other.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, simd: S, clusters: &[BinaryNode], start: usize, least: &mut [Key]) {
        let count = WINDOW.min(clusters.len() - start);
        for first in (0..count + MARGIN).step_by(LANES) {
            let [mut min, mut max] = [[&[0.0; 4]; LANES]; 2];
            for lane in 0..LANES {
                [min[lane], max[lane]] = clusters.get(start + first + lane).unwrap_or(&BinaryNode::FAR).corners();
            }
            let [x_min, y_min, z_min, _] = simd.transpose(min);
            let [x_max, y_max, z_max, _] = simd.transpose(max);
            for (column, values) in self.bounds.iter_mut().zip([x_min, y_min, z_min, x_max, y_max, z_max]) {
                *lanes_mut(column, first) = simd.store(values);
            }
        }

        let most = simd.splat(f32::MAX);
        for first in (0..count).step_by(LANES) {
            let bounds = |distance: usize| {
                let [x_min, y_min, z_min, x_max, y_max, z_max] = &self.bounds;
                let load = |column| simd.load(lanes(column, first + distance));
                [
                    load(x_min),
                    load(y_min),
                    load(z_min),
                    load(x_max),
                    load(y_max),
                    load(z_max),
                ]
            };
            let [x_min, y_min, z_min, x_max, y_max, z_max] = bounds(0);
            for distance in 1..=RADIUS {
                let other = bounds(distance);
                let x = simd.sub(simd.max(x_max, other[3]), simd.min(x_min, other[0]));
                let y = simd.sub(simd.max(y_max, other[4]), simd.min(y_min, other[1]));
                let z = simd.sub(simd.max(z_max, other[5]), simd.min(z_min, other[2]));
                let area = simd.add(simd.mul(x, y), simd.mul(z, simd.add(x, y)));
                // What is infinite, or NaN, has no room for a tag.
                let key = simd.tag(simd.min(area, most), TAG_BITS, &TAGS[distance - 1]);
                *lanes_mut(&mut self.keys[distance - 1], MARGIN + first) = simd.store(key);
            }
        }
        for first in (0..count).step_by(LANES) {
            let mut key = simd.splat(f32::INFINITY);
            for distance in 1..=RADIUS {
                let keys = &self.keys[distance - 1];
                key = simd.min(simd.load(lanes(keys, MARGIN + first)), key);
                key = simd.min(simd.load(lanes(keys, MARGIN + first - distance)), key);
            }
            *lanes_mut(least, start + first) = simd.store(key);
        }
        for keys in &mut self.keys {
            keys.copy_within(WINDOW.., 0);
        }
    }
}

#[inline(always)]
fn lanes(values: &[f32], first: usize) -> &[f32; LANES] {
    values[first..first + LANES].try_into().expect("eight values")
}

#[inline(always)]
fn lanes_mut(values: &mut [f32], first: usize) -> &mut [f32; LANES] {
    (&mut values[first..first + LANES]).try_into().expect("eight values")
}
