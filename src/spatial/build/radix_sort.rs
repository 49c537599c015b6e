//! Sorting numbers digit by digit.

use std::{mem, ops::Range};

pub(super) const DIGIT_BITS: u32 = 11;
const DIGITS: usize = 1 << DIGIT_BITS;

/// Sorts by a range of bits, lowest digit first, and perhaps by some bits above it; equal ones stay in their order. `spare`
/// is overwritten. There must be one key at least.
///
/// Source: Knuth, *The Art of Computer Programming*, vol. 3, 1998, §5.2.5. O(n) for each digit that is not the same
/// everywhere.
pub(super) fn sort(keys: &mut Vec<u64>, spare: &mut Vec<u64>, bits: Range<u32>) {
    if spare.len() < keys.len() {
        spare.resize(keys.len(), 0);
    }
    spare.truncate(keys.len());
    for shift in bits.step_by(DIGIT_BITS as usize) {
        let digit = |key: u64| (key >> shift) as usize % DIGITS;
        let mut places = [0_u32; DIGITS];
        for &key in keys.iter() {
            places[digit(key)] += 1;
        }
        if places[digit(keys[0])] as usize == keys.len() {
            continue;
        }
        let mut before = 0;
        for place in &mut places {
            before += mem::replace(place, before);
        }
        for &key in keys.iter() {
            let place = &mut places[digit(key)];
            spare[*place as usize] = key;
            *place += 1;
        }
        mem::swap(keys, spare);
    }
}
