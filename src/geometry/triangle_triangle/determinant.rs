//! A determinant that is rounded once.
//!
//! It is added up as an expansion: a sum of floating-point numbers that do not overlap, in order of magnitude, and is
//! exact (Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997, §2).

use smallvec::SmallVec;

/// An exact difference of two numbers, as the rounded difference and what the rounding took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry([f64; 2]);

impl Entry {
    pub(super) fn difference(x: f64, y: f64) -> Self {
        let (difference, error) = two_sum(x, -y);
        Self([difference, error])
    }
}

/// The determinant of the matrix with these rows, right to a few units in the last place. There must be no overflow
/// nor underflow.
pub(super) fn determinant([a, b, c]: [[Entry; 3]; 3]) -> f64 {
    const PERMUTATIONS: [([usize; 3], f64); 6] = [
        ([0, 1, 2], 1.0),
        ([1, 2, 0], 1.0),
        ([2, 0, 1], 1.0),
        ([0, 2, 1], -1.0),
        ([1, 0, 2], -1.0),
        ([2, 1, 0], -1.0),
    ];
    let mut sum = Expansion::default();
    for ([i, j, k], sign) in PERMUTATIONS {
        for x in a[i].0 {
            for y in b[j].0 {
                for z in c[k].0 {
                    sum.add_product(sign * x, y, z);
                }
            }
        }
    }
    sum.value()
}

/// Numbers that do not overlap, from the smallest to the largest, without zeros.
#[derive(Default)]
struct Expansion(SmallVec<[f64; 32]>);

impl Expansion {
    fn add_product(&mut self, x: f64, y: f64, z: f64) {
        if x == 0.0 || y == 0.0 || z == 0.0 {
            return;
        }
        let (product, error) = two_product(x, y);
        for factor in [error, product] {
            let (product, error) = two_product(factor, z);
            self.add(error);
            self.add(product);
        }
    }

    /// Shewchuk's Grow-Expansion, with zeros left out.
    fn add(&mut self, mut carried: f64) {
        let mut kept = 0;
        for i in 0..self.0.len() {
            let (sum, error) = two_sum(carried, self.0[i]);
            if error != 0.0 {
                self.0[kept] = error;
                kept += 1;
            }
            carried = sum;
        }
        self.0.truncate(kept);
        if carried != 0.0 {
            self.0.push(carried);
        }
    }

    fn value(&self) -> f64 {
        self.0.iter().sum()
    }
}

/// The rounded sum and its error (Knuth).
fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let y_virtual = sum - x;
    (sum, (x - (sum - y_virtual)) + (y - y_virtual))
}

/// The rounded product and its error.
fn two_product(x: f64, y: f64) -> (f64, f64) {
    let product = x * y;
    (product, x.mul_add(y, -product))
}
