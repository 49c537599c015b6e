//! How far two surfaces lie apart: a bound on their Hausdorff distance.
//!
//! By branch and bound over the triangles of either surface, after Guthe, Borodin and Klein, *Fast and accurate
//! Hausdorff distance calculation between meshes*, Journal of WSCG 13, 2005. A piece of a triangle is known to lie
//! within a distance of the other surface by the least of:
//!
//! - **a ball**: the distance of its centroid, and the radius about it (§3);
//! - **one triangle**: distance to a triangle is convex, so that nothing of the piece is farther from it than a corner
//!   (§3);
//! - **two triangles**: the piece is cut in two where they are equally far from its sides, about; each part is bounded
//!   by its own triangle, wherever the cut is.
//!
//! What may be farther than what is known to be far is cut up, the worst first.

use std::{cmp::Ordering, collections::BinaryHeap};

use bevy::math::{DVec3, Vec3, Vec3A, primitives::Triangle3d};

use crate::{
    geometry::{closest_point::ClosestPoint, rounding, tolerance},
    mesh::MeshBvh,
    spatial::BuildProgress,
};

/// How closely [deviations](Deviation) are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviationSettings {
    /// How much larger than the distance its bound may be, as a fraction.
    pub slack: f32,
    /// The distance that need not be told from zero, in units of the surfaces.
    pub negligible: f32,
    /// Into how many pieces triangles may be cut, for each triangle of both surfaces. When they are used up, the bound
    /// is what it has come to: it holds, but may be looser than [`slack`](Self::slack).
    pub pieces_per_triangle: usize,
}

impl Default for DeviationSettings {
    fn default() -> Self {
        Self {
            slack: 0.05,
            negligible: 0.0,
            pieces_per_triangle: 64,
        }
    }
}

/// How far two surfaces lie apart: the most that any point of either is from the other.
///
/// This is their two-sided Hausdorff distance, in units of the surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// It is no less than this, up to rounding: so far is a point that was looked at.
    pub at_least: f32,
    /// It is no more than this.
    pub at_most: f32,
}

impl Deviation {
    /// Measures how far two surfaces lie apart.
    pub fn between(a: &MeshBvh, b: &MeshBvh, settings: &DeviationSettings) -> Self {
        Self::measure(a, b, settings, None).expect("nothing calls it off")
    }

    /// The same; `None` if `progress` was told to cancel.
    pub(super) fn measure(
        a: &MeshBvh,
        b: &MeshBvh,
        settings: &DeviationSettings,
        progress: Option<&BuildProgress>,
    ) -> Option<Self> {
        let budget = (a.mesh().len() + b.mesh().len()).saturating_mul(settings.pieces_per_triangle);
        let mut search = Search {
            slack: 1.0 + f64::from(settings.slack.max(0.0)),
            negligible: f64::from(settings.negligible.max(0.0)),
            at_least: 0.0,
            at_most: 0.0,
            progress,
        };
        let pieces = search.one_sided(a, b, budget / 2)?;
        search.one_sided(b, a, budget - pieces.min(budget))?;
        Some(Self {
            // What was looked at was rounded, and may be beyond the bound by that.
            at_least: search.at_least.min(search.at_most) as f32,
            at_most: rounding::up(search.at_most * (1.0 + tolerance::DOUBLE)),
        })
    }
}

struct Search<'a> {
    slack: f64,
    negligible: f64,
    at_least: f64,
    at_most: f64,
    progress: Option<&'a BuildProgress>,
}

/// A piece of a triangle.
struct Piece {
    corners: [DVec3; 3],
    /// No point of it is farther from the other surface.
    bound: f64,
    /// Triangles of the other surface close to it: to its middle, and to one of its corners.
    near: [Triangle3d; 2],
    /// Where it changes from one to the other, if it does.
    cut: Option<Cut>,
    depth: u32,
}

/// By their bounds.
impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl Search<'_> {
    /// How far points of one surface are from another; returns how many pieces were looked at, or `None` if it was
    /// called off.
    fn one_sided(&mut self, from: &MeshBvh, to: &MeshBvh, budget: usize) -> Option<usize> {
        let mut pieces = 0;
        let mut open = BinaryHeap::new();
        for corners in from.mesh().corners_of_all() {
            let corners = corners.map(Vec3::as_dvec3);
            self.look_at(corners, f64::INFINITY, None, 0, to, &mut open);
            pieces += 1;
            if pieces % 1024 == 0 && self.is_cancelled() {
                return None;
            }
        }
        while let Some(worst) = open.pop() {
            if worst.bound <= self.enough() || pieces >= budget {
                self.at_most = self.at_most.max(worst.bound);
                break;
            }
            for corners in worst.parts() {
                self.look_at(
                    corners,
                    worst.bound,
                    Some(&worst.near[0]),
                    worst.depth + 1,
                    to,
                    &mut open,
                );
                pieces += 1;
            }
            if pieces % 1024 < 3 && self.is_cancelled() {
                return None;
            }
        }
        Some(pieces)
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_some_and(BuildProgress::is_cancelled)
    }

    /// What is within this need not be looked at more closely.
    fn enough(&self) -> f64 {
        (self.at_least * self.slack).max(self.negligible)
    }

    /// Bounds a piece, no higher than what it is a part of, and notes it if that is not enough. `hint` is a triangle
    /// that may be close.
    fn look_at(
        &mut self,
        corners: [DVec3; 3],
        bound: f64,
        hint: Option<&Triangle3d>,
        depth: u32,
        to: &MeshBvh,
        open: &mut BinaryHeap<Piece>,
    ) {
        // Rounded, so that the point that is asked for is the point that is measured from.
        let middle = ((corners[0] + corners[1] + corners[2]) / 3.0).as_vec3a();
        let (distance, near) = nearest(to, middle, hint);
        self.at_least = self.at_least.max(distance);
        let radius = farthest(&corners, |corner| corner.distance(middle.as_dvec3()));
        let by_one = farthest(&corners, |corner| distance_to(&near, corner));
        let mut piece = Piece {
            corners,
            bound: bound.min(distance + radius).min(by_one),
            near: [near, near],
            cut: None,
            depth,
        };
        if piece.bound > self.enough() {
            let [a, b, c] = corners.map(|corner| distance_to(&near, corner));
            let worst = if a >= b && a >= c {
                corners[0]
            } else if b >= c {
                corners[1]
            } else {
                corners[2]
            };
            let (distance, other) = nearest(to, worst.as_vec3a(), Some(&near));
            self.at_least = self.at_least.max(distance);
            piece.near[1] = other;
            piece.cut = piece.find_cut();
            piece.bound = piece.bound.min(piece.bound_by_two());
        }
        if piece.bound > self.enough() {
            open.push(piece);
        } else {
            self.at_most = self.at_most.max(piece.bound);
        }
    }
}

/// Where a piece may be cut: the corner that is cut off, and the points on its two sides.
#[derive(Clone, Copy)]
struct Cut {
    corner: usize,
    sides: [DVec3; 2],
    /// Whether the corner is nearer to the first triangle.
    is_first: bool,
}

impl Piece {
    /// What is farthest if each part is measured from the triangle that is nearer to it.
    fn bound_by_two(&self) -> f64 {
        let Some(Cut {
            corner,
            sides,
            is_first,
        }) = self.cut
        else {
            return f64::INFINITY;
        };
        let [first, second] = &self.near;
        let (of_corner, of_rest) = if is_first { (first, second) } else { (second, first) };
        let [a, b, c] = self.corners_from(corner);
        let at = |triangle: &Triangle3d, points: &[DVec3]| farthest(points, |point| distance_to(triangle, point));
        at(of_corner, &[a, sides[0], sides[1]]).max(at(of_rest, &[b, c, sides[0], sides[1]]))
    }

    /// The corners, beginning with one of them.
    fn corners_from(&self, first: usize) -> [DVec3; 3] {
        std::array::from_fn(|next| self.corners[(first + next) % 3])
    }

    /// Cuts off the corner that is nearer to another triangle than the rest, if there is one.
    fn find_cut(&self) -> Option<Cut> {
        let [first, second] = &self.near;
        let nearer_to_first = |point: DVec3| distance_to(first, point) <= distance_to(second, point);
        let sides = self.corners.map(nearer_to_first);
        let corner = match sides {
            [a, b, c] if a == b && b == c => return None,
            [a, b, c] if b == c && a != b => 0,
            [a, b, c] if a == c && b != a => 1,
            _ => 2,
        };
        let [a, b, c] = self.corners_from(corner);
        let is_first = sides[corner];
        let between = |mut near: DVec3, mut far: DVec3| {
            for _ in 0..BISECTIONS {
                let middle = (near + far) / 2.0;
                if nearer_to_first(middle) == is_first {
                    near = middle;
                } else {
                    far = middle;
                }
            }
            (near + far) / 2.0
        };
        Some(Cut {
            corner,
            sides: [between(a, b), between(a, c)],
            is_first,
        })
    }

    /// Cuts it up: where it changes from one triangle to another, or else, and every second time, in halves.
    fn parts(&self) -> Parts {
        if self.depth.is_multiple_of(2)
            && let Some(Cut {
                corner,
                sides: [ab, ac],
                ..
            }) = self.cut
        {
            let [a, b, c] = self.corners_from(corner);
            return [Some([a, ab, ac]), Some([ab, b, c]), Some([ab, c, ac])]
                .into_iter()
                .flatten();
        }
        let [a, b, c] = self.corners;
        let sides = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
        let longest = (0..3).max_by(|&i, &j| sides[i].total_cmp(&sides[j])).unwrap_or(0);
        let [a, b, c] = self.corners_from(longest);
        let middle = (a + b) / 2.0;
        [Some([a, middle, c]), Some([middle, b, c]), None].into_iter().flatten()
    }
}

/// The parts of a piece.
type Parts = std::iter::Flatten<std::array::IntoIter<Option<[DVec3; 3]>, 3>>;

/// How often a side is halved to find where it changes from one triangle to another.
const BISECTIONS: u32 = 10;

/// The distance of a point, and the triangle that is so near.
fn nearest(to: &MeshBvh, point: Vec3A, hint: Option<&Triangle3d>) -> (f64, Triangle3d) {
    let hint = hint.map(|triangle| (distance_to(triangle, point.as_dvec3()), *triangle));
    let reach = hint.map_or(f32::INFINITY, |(distance, _)| rounding::up(distance));
    let found = to.closest_point(point, reach).map(|found| {
        let [a, b, c] = to.mesh().triangle(&found.hit);
        let triangle = Triangle3d::new(a, b, c);
        (distance_to(&triangle, point.as_dvec3()), triangle)
    });
    // There is nothing nearer than the hint, or the point has overflowed.
    found.or(hint).unwrap_or((f64::INFINITY, Triangle3d::default()))
}

fn distance_to(triangle: &Triangle3d, point: DVec3) -> f64 {
    triangle.closest_point_f64(point).distance(point)
}

fn farthest(points: &[DVec3], distance: impl Fn(DVec3) -> f64) -> f64 {
    points.iter().map(|&point| distance(point)).fold(0.0, f64::max)
}
