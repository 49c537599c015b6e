//! Boxes in the order of a space-filling curve.

use std::ops::Range;

use super::{
    extents::Extents,
    morton::MortonGrid,
    progress::{Cancelled, Stage},
    radix_sort::{self, DIGIT_BITS},
    tagged_box::BuildItem,
};
use crate::spatial::simd::{self, LANES, Simd, Task};

/// More items than this in one cell of a grid get a grid of their own.
const CROWD: usize = 16;
/// The bits of a code: two digits, or three for more items than this.
const CODE_BITS: u32 = 2 * DIGIT_BITS;
const CODE_BITS_OF_MANY: u32 = 31;
const MANY: usize = 1 << 18;
/// How many items ahead the memory is asked for them.
const AHEAD: usize = 32;

/// Sorts items along a Z-order curve, and keeps its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct ZOrder {
    /// A code, and below it the place of the item.
    keys: Vec<u64>,
    spare: Vec<u64>,
    waiting: Vec<Range<usize>>,
}

impl ZOrder {
    pub(super) fn memory(&self) -> usize {
        (self.keys.capacity() + self.spare.capacity()) * size_of::<u64>()
            + self.waiting.capacity() * size_of::<Range<usize>>()
    }

    /// Writes the items in their order over `sorted`. Those in one cell are sorted on a finer grid in turn where they
    /// are many, so that one that is far from all others does no harm. What was in `items` is lost.
    pub(super) fn sort(
        &mut self,
        items: &mut [BuildItem],
        sorted: &mut Vec<BuildItem>,
        stage: &Stage,
    ) -> Result<(), Cancelled> {
        sorted.resize(items.len(), items[0]);
        let code_bits = if items.len() <= MANY {
            CODE_BITS
        } else {
            CODE_BITS_OF_MANY
        };
        self.waiting.clear();
        self.waiting.push(0..items.len());
        while let Some(range) = self.waiting.pop() {
            if range.len() > MANY {
                stage.advance(0)?;
            }
            let (items, sorted) = (&mut items[range.clone()], &mut sorted[range.clone()]);
            let Some(grid) = MortonGrid::new(&Extents::of(items).centers, code_bits) else {
                sorted.copy_from_slice(items);
                continue;
            };
            self.sort_on(&grid, code_bits, items, sorted, stage)?;

            let mut cell = 0;
            while cell < items.len() {
                let code = self.keys[cell] >> u32::BITS;
                let others = &self.keys[cell..];
                let crowd = others.get(CROWD).is_some_and(|key| key >> u32::BITS == code);
                let end = cell
                    + if crowd {
                        others.partition_point(|key| key >> u32::BITS <= code)
                    } else {
                        1
                    };
                // A grid that told nothing apart is not tried again.
                if crowd && end - cell < items.len() {
                    items[cell..end].copy_from_slice(&sorted[cell..end]);
                    self.waiting.push(range.start + cell..range.start + end);
                }
                cell = end;
            }
        }
        stage.advance(items.len())
    }

    /// Writes the items over `sorted` in the order of their codes.
    fn sort_on(
        &mut self,
        grid: &MortonGrid,
        code_bits: u32,
        items: &[BuildItem],
        sorted: &mut [BuildItem],
        stage: &Stage,
    ) -> Result<(), Cancelled> {
        self.keys.clear();
        simd::dispatch(Keys {
            grid,
            items,
            keys: &mut self.keys,
        });
        stage.advance(0)?;
        radix_sort::sort(&mut self.keys, &mut self.spare, u32::BITS..u32::BITS + code_bits);
        stage.advance(0)?;
        for (i, (&key, sorted)) in self.keys.iter().zip(sorted).enumerate() {
            if let Some(&ahead) = self.keys.get(i + AHEAD) {
                simd::prefetch(&items[place(ahead)]);
            }
            *sorted = items[place(key)];
        }
        Ok(())
    }
}

/// The place of an item in its key.
#[inline(always)]
fn place(key: u64) -> usize {
    key as u32 as usize
}

/// Makes the key of every item.
struct Keys<'a> {
    grid: &'a MortonGrid,
    items: &'a [BuildItem],
    keys: &'a mut Vec<u64>,
}

impl Task for Keys<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.keys.reserve(self.items.len());
        let mut place = 0;
        let (chunks, rest) = self.items.as_chunks::<LANES>();
        let mut add = |codes: &[u32]| {
            for &code in codes {
                self.keys.push(u64::from(code) << u32::BITS | place);
                place += 1;
            }
        };
        for chunk in chunks {
            add(&self.grid.codes(chunk));
        }
        if let Some(&last) = rest.last() {
            let mut chunk = [last; LANES];
            chunk[..rest.len()].copy_from_slice(rest);
            add(&self.grid.codes(&chunk)[..rest.len()]);
        }
    }
}
