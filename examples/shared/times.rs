//! How long frames take, or parts of them.

use std::collections::VecDeque;

/// The frames of which the median is told.
const FRAMES: usize = 120;

/// Times of the last frames in milliseconds.
pub struct Times {
    frames: VecDeque<f32>,
    /// As many are remembered.
    most: usize,
}

impl Default for Times {
    fn default() -> Self {
        Self {
            frames: VecDeque::new(),
            most: FRAMES,
        }
    }
}

impl Times {
    /// Remembers another number of frames.
    #[allow(dead_code, reason = "most examples tell of the last frames")]
    pub fn of_last(frames: usize) -> Self {
        Self {
            most: frames,
            ..Self::default()
        }
    }

    pub fn add(&mut self, ms: f32) {
        if self.frames.len() == self.most {
            self.frames.pop_front();
        }
        self.frames.push_back(ms);
    }

    /// The number of frames that are remembered.
    #[allow(dead_code, reason = "not every example counts frames")]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// NaN while there is none.
    pub fn median(&self) -> f32 {
        self.percentile(50)
    }

    /// So many in a hundred frames take no longer; NaN while there is none.
    pub fn percentile(&self, of_hundred: usize) -> f32 {
        let mut sorted: Vec<f32> = self.frames.iter().copied().collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let place = (sorted.len() * of_hundred / 100).min(sorted.len().saturating_sub(1));
        sorted.get(place).copied().unwrap_or(f32::NAN)
    }

    /// The median with so many decimals, or what to say while there is none.
    pub fn tell(&self, decimals: usize, unknown: &str) -> String {
        match self.median() {
            median if median.is_nan() => unknown.into(),
            median => format!("{median:.decimals$} ms"),
        }
    }
}
