//! How large a view shows things, and which level of a group is enough for it.
//!
//! All metrics come down to one form: the level `i` takes over from where the distance is at least `r(i) · F`, with a
//! reach `r(i)` of the group alone and a factor `F` of the view alone. With the diameter `D`, the error `e` in world
//! units, the threshold `t`, the projected height of a unit at distance one, as a fraction of the viewport, `h`, and the
//! height of the viewport in pixels `H`:
//!
//! | metric | enough where | r | F |
//! |---|---|---|---|
//! | height | D · h / d ≤ t | D / t | h |
//! | pixel error | e · h · H / d ≤ t | e / t | h · H |
//! | distance | d ≥ t | t | 1 |
//!
//! An orthographic view shows things as large from everywhere: there `d` is 1, except for the plain distance.

use bevy::math::{Mat4, Vec3, Vec3A};

use super::LodMetric;

/// The most levels that a group may have.
pub(crate) const MAX_LEVELS: usize = 8;

/// How large a view shows things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lens {
    /// `F` for each [`MetricKind`].
    factors: [f32; 3],
    is_orthographic: bool,
}

/// What decides between levels, without its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum MetricKind {
    Height,
    PixelError,
    Distance,
}

/// All that is needed of a group to choose its level: one line of the cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Reaches {
    /// The box to whose nearest point distances are measured, in world space: of no size if it is a centre.
    pub min: Vec3,
    pub max: Vec3,
    /// `r` for each level, ascending: infinite for those that there are not, and less than any distance for the first.
    begins: [f32; MAX_LEVELS + 1],
    kind: MetricKind,
    /// The number of levels; zero if there is no such group.
    pub levels: u8,
    /// One bit for each level that could be shown.
    pub available: u8,
}

/// A level, and how far the view may move without needing another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice {
    pub level: u8,
    pub slack: f32,
}

impl Lens {
    /// Through which everything is as large as can be.
    pub const FINEST: Self = Self {
        factors: [f32::MAX; 3],
        is_orthographic: false,
    };

    /// Of a view with this projection, onto a viewport that is so high in physical pixels. `None` if it shows nothing that
    /// has a size.
    pub fn new(clip_from_view: &Mat4, viewport_height: f32, bias: f32) -> Option<Self> {
        let is_orthographic = clip_from_view.z_axis.w == 0.0;
        let w = if is_orthographic {
            clip_from_view.w_axis.w
        } else {
            clip_from_view.z_axis.w
        };
        // The viewport is two units high.
        let height = (clip_from_view.y_axis.y / w).abs() / 2.0;
        let factors = [height * bias, height * viewport_height * bias, bias];
        factors
            .iter()
            .all(|factor| factor.is_finite() && *factor > 0.0)
            .then_some(Self {
                factors,
                is_orthographic,
            })
    }
}

impl Reaches {
    /// Of no group.
    pub const NONE: Self = Self {
        min: Vec3::ZERO,
        max: Vec3::ZERO,
        begins: {
            let mut begins = [f32::INFINITY; MAX_LEVELS + 1];
            begins[0] = f32::NEG_INFINITY;
            begins
        },
        kind: MetricKind::Distance,
        levels: 0,
        available: 0,
    };

    /// Of a group of this diameter in world units, and with `scale` world units to each of its own. `thresholds` are those
    /// of all levels but the first. Without `place`, nothing is known of the group yet, and its first level is shown.
    pub fn new(
        metric: LodMetric,
        bias: f32,
        diameter: f32,
        scale: f32,
        place: Option<(Vec3A, Vec3A)>,
        thresholds: impl Iterator<Item = f32>,
    ) -> Self {
        let mut reaches = Self {
            kind: match metric {
                LodMetric::Height => MetricKind::Height,
                LodMetric::PixelError(_) => MetricKind::PixelError,
                LodMetric::Distance => MetricKind::Distance,
            },
            levels: 1,
            ..Self::NONE
        };
        for (begin, threshold) in reaches.begins[1..MAX_LEVELS].iter_mut().zip(thresholds) {
            let raw = match metric {
                LodMetric::Height => diameter / threshold,
                LodMetric::PixelError(pixels) => threshold * scale / pixels,
                LodMetric::Distance => threshold,
            };
            // What is no number is out of reach.
            *begin = if raw * bias >= 0.0 { raw * bias } else { f32::INFINITY };
            reaches.levels += 1;
        }
        match place {
            Some((min, max)) if min.is_finite() && max.is_finite() => {
                (reaches.min, reaches.max) = (min.into(), max.into());
            }
            _ => reaches.begins = Self::NONE.begins,
        }
        // A level that is enough where a coarser one is enough as well is never shown.
        let levels = usize::from(reaches.levels);
        for level in (1..levels - 1).rev() {
            reaches.begins[level] = reaches.begins[level].min(reaches.begins[level + 1]);
        }
        reaches
    }

    /// The coarsest level that is enough for a view from `eye`, if the last choice was `level`: a coarser one only from
    /// `stay` times its distance on.
    #[inline]
    pub fn choose(&self, lens: &Lens, eye: Vec3, level: u8, stay: f32) -> Choice {
        let factor = lens.factors[self.kind as usize];
        let is_fixed = lens.is_orthographic && self.kind != MetricKind::Distance;
        let distance = if is_fixed { 1.0 } else { self.distance(eye) };
        let begin = |level: u8| self.begins[usize::from(level) % self.begins.len()] * factor;
        let mut choice = level;
        if distance < begin(choice) {
            while choice > 0 && distance < begin(choice) {
                choice -= 1;
            }
        } else if distance >= begin(choice + 1) * stay {
            let last = self.levels.saturating_sub(1);
            while choice < last && distance >= begin(choice + 1) * stay {
                choice += 1;
            }
        }
        if is_fixed {
            return Choice {
                level: choice,
                slack: f32::INFINITY,
            };
        }
        let slack = (distance - begin(choice)).min(begin(choice + 1) * stay - distance);
        // The distance is rounded by a few units in the last place.
        Choice {
            level: choice,
            slack: slack - 8.0 * f32::EPSILON * distance,
        }
    }

    /// The levels that are enough somewhere between the distance of `eye`, divided by `margin`, and multiplied by it, one
    /// bit for each. Of a group of which nothing is known, the coarsest.
    pub fn near(&self, lens: &Lens, eye: Vec3, margin: f32) -> u8 {
        let last = self.levels.saturating_sub(1);
        if self.levels > 1
            && self.begins[1..=usize::from(last)]
                .iter()
                .all(|begin| begin.is_infinite())
        {
            return 1 << last;
        }
        let factor = lens.factors[self.kind as usize];
        let is_fixed = lens.is_orthographic && self.kind != MetricKind::Distance;
        let distance = if is_fixed { 1.0 } else { self.distance(eye) };
        (0..=last).fold(0, |near, level| {
            let [begin, end] = [level, level + 1].map(|level| self.begins[usize::from(level)] * factor);
            near | u8::from(begin <= distance * margin && distance <= end * margin) << level
        })
    }

    /// The distances from which on the levels are enough; `None` if that is the same at any distance.
    pub fn distances(&self, lens: &Lens) -> Option<impl Iterator<Item = f32> + use<'_>> {
        let factor = lens.factors[self.kind as usize];
        let is_fixed = lens.is_orthographic && self.kind != MetricKind::Distance;
        let begins = self.begins.iter().take(self.levels.into());
        (!is_fixed).then(|| begins.map(move |begin| (begin * factor).max(0.0)))
    }

    /// Never infinite: what is out of reach stays so.
    fn distance(&self, eye: Vec3) -> f32 {
        let to_nearest = (self.min - eye).max(eye - self.max).max(Vec3::ZERO);
        to_nearest.length().min(f32::MAX)
    }
}
