//! Sets of entities, by their indices in the world.

use crate::index::ticks::ones;

/// A set of small numbers, one bit for each. What is done with all of it costs as much as it holds, whatever the
/// largest.
#[derive(Clone, Debug, Default)]
pub(super) struct Bits {
    words: Vec<u64>,
    /// One bit for each word that may have a bit.
    used: Vec<u64>,
}

impl Bits {
    /// Adds a number; returns whether it is new.
    #[inline]
    pub fn insert(&mut self, number: u32) -> bool {
        let word = number as usize / 64;
        if word >= self.words.len() {
            self.grow(word);
        }
        let bit = 1 << (number % 64);
        let is_new = self.words[word] & bit == 0;
        self.words[word] |= bit;
        self.used[word / 64] |= 1 << (word % 64);
        is_new
    }

    #[cold]
    fn grow(&mut self, word: usize) {
        let words = (word + 1).next_power_of_two().max(64);
        self.words.resize(words, 0);
        self.used.resize(words / 64, 0);
    }

    /// Takes a number out; returns whether it was there.
    #[inline]
    pub fn remove(&mut self, number: u32) -> bool {
        let Some(word) = self.words.get_mut(number as usize / 64) else {
            return false;
        };
        let bit = 1 << (number % 64);
        let was_there = *word & bit != 0;
        *word &= !bit;
        was_there
    }

    #[inline]
    pub fn set(&mut self, number: u32, is_in: bool) {
        if is_in {
            self.insert(number);
        } else {
            self.remove(number);
        }
    }

    #[inline]
    pub fn contains(&self, number: u32) -> bool {
        self.word(number as usize / 64) >> (number % 64) & 1 != 0
    }

    /// The bits of the numbers from `64 * word` on.
    #[inline]
    pub fn word(&self, word: usize) -> u64 {
        self.words.get(word).copied().unwrap_or(0)
    }

    /// Which of the words from `64 * block` on may have bits.
    #[inline]
    pub fn used(&self, block: usize) -> u64 {
        self.used.get(block).copied().unwrap_or(0)
    }

    /// How many blocks there are of words that may have bits.
    pub fn blocks(&self) -> usize {
        self.used.len()
    }

    /// Gives a word its bits.
    pub fn set_word(&mut self, word: usize, bits: u64) {
        if word >= self.words.len() {
            if bits == 0 {
                return;
            }
            self.grow(word);
        }
        self.words[word] = bits;
        if bits == 0 {
            self.used[word / 64] &= !(1 << (word % 64));
        } else {
            self.used[word / 64] |= 1 << (word % 64);
        }
    }

    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    pub fn clear(&mut self) {
        for (block, used) in self.used.iter_mut().enumerate() {
            for word in ones(std::mem::take(used)) {
                self.words[block * 64 + word as usize] = 0;
            }
        }
    }

    /// All numbers, in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.blocks()).flat_map(move |block| {
            ones(self.used[block]).flat_map(move |word| {
                let word = block as u32 * 64 + word;
                ones(self.words[word as usize]).map(move |bit| word * 64 + bit)
            })
        })
    }
}
