//! The nearest of many, within a budget of lines.

use super::GizmoCount;

/// Collects shapes, and keeps the nearest that the budget can hold.
#[derive(Debug)]
pub(super) struct Nearest<T> {
    /// Lines.
    budget: usize,
    /// Shapes that may fit into it.
    most: usize,
    kept: Vec<Offer<T>>,
    offered: usize,
}

#[derive(Debug)]
struct Offer<T> {
    distance: f32,
    /// Decides between those at one distance.
    number: usize,
    shape: T,
}

impl<T> Offer<T> {
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        let by_distance = self.distance.total_cmp(&other.distance);
        by_distance.then(self.number.cmp(&other.number))
    }
}

impl<T> Nearest<T> {
    /// For shapes that take `least` lines or more.
    pub fn new(budget: usize, least: usize) -> Self {
        Self {
            budget,
            most: budget / least.max(1),
            kept: Vec::new(),
            offered: 0,
        }
    }

    /// Takes a shape, by the distance or its square.
    pub fn offer(&mut self, distance: f32, shape: T) {
        let number = self.offered;
        self.offered += 1;
        if self.most == 0 {
            return;
        }
        self.kept.push(Offer {
            distance,
            number,
            shape,
        });
        // Twice as many, so that each is looked at but a few times.
        if self.kept.len() >= self.most.saturating_mul(2) {
            self.drop_farthest();
        }
    }

    fn drop_farthest(&mut self) {
        if self.kept.len() > self.most {
            self.kept.select_nth_unstable_by(self.most - 1, Offer::order);
            self.kept.truncate(self.most);
        }
    }

    /// Has the shapes drawn, nearest first. `draw` gets the lines that are left, and returns how many it took; `None` if it
    /// drew nothing.
    pub fn draw(mut self, mut draw: impl FnMut(T, usize) -> Option<usize>) -> GizmoCount {
        if self.most > 0 {
            self.drop_farthest();
        }
        self.kept.sort_unstable_by(Offer::order);
        let (mut left, mut drawn) = (self.budget, 0);
        for Offer { shape, .. } in self.kept {
            if let Some(lines) = draw(shape, left) {
                left = left.saturating_sub(lines);
                drawn += 1;
            }
        }
        GizmoCount {
            drawn,
            left_out: self.offered - drawn,
        }
    }
}
