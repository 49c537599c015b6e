//! The regions of the screen that can be asked for.

use bevy::math::Vec2;

use super::outline::Outline;

/// A region of the screen: a rectangle or a polygon, in logical pixels, as cursors and
/// [`Camera::viewport_to_world`](bevy::camera::Camera::viewport_to_world) have them.
///
/// The outline belongs to the region. A rectangle or polygon without an area is its outline: a click, or a cut along a line.
#[derive(Clone, Debug)]
pub struct ScreenRegion {
    /// `None` if there is nothing in it.
    outline: Option<Outline>,
}

/// Why a polygon is no region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnusableRegion {
    /// There are no corners.
    #[error("a polygon without corners")]
    Empty,
    /// A corner is NaN or infinite.
    #[error("corner {0} of the polygon is NaN or infinite")]
    NotFinite(usize),
}

impl ScreenRegion {
    /// The rectangle between two opposite corners, whichever. With a corner that is NaN or infinite there is nothing in it.
    pub fn rect(a: Vec2, b: Vec2) -> Self {
        let is_finite = a.is_finite() && b.is_finite();
        let (min, max) = (a.min(b).as_dvec2(), a.max(b).as_dvec2());
        Self {
            outline: is_finite.then(|| Outline::rect(min, max)),
        }
    }

    /// A single point: what a click through everything there selects.
    pub fn point(point: Vec2) -> Self {
        Self::rect(point, point)
    }

    /// The polygon with these corners, in either direction; the last is joined to the first. It may be concave, and may
    /// cross itself: a point is inside if a line from there to afar crosses the outline an odd number of times (the
    /// even-odd rule), so that what is enclosed twice is outside.
    ///
    /// ```
    /// # use bevy::math::Vec2;
    /// # use bevy_sightline::selection::ScreenRegion;
    /// let arrow = [(0.0, 0.0), (40.0, 20.0), (0.0, 40.0), (10.0, 20.0)].map(Vec2::from);
    /// let lasso = ScreenRegion::polygon(&arrow).expect("finite corners");
    /// assert!(lasso.contains(Vec2::new(20.0, 20.0)) && !lasso.contains(Vec2::new(5.0, 20.0)));
    /// ```
    ///
    /// # Errors
    ///
    /// If there are no corners, or one is NaN or infinite.
    pub fn polygon(corners: &[Vec2]) -> Result<Self, UnusableRegion> {
        if corners.is_empty() {
            return Err(UnusableRegion::Empty);
        }
        if let Some(corner) = corners.iter().position(|corner| !corner.is_finite()) {
            return Err(UnusableRegion::NotFinite(corner));
        }
        let outline = Some(Outline::polygon(corners.iter().map(|corner| corner.as_dvec2())));
        Ok(Self { outline })
    }

    /// Whether a point of the screen is in the region, or on its outline.
    pub fn contains(&self, point: Vec2) -> bool {
        let point = point.as_dvec2();
        let outline = self.outline().filter(|_| point.is_finite());
        outline.is_some_and(|outline| outline.contains(point))
    }

    pub(super) fn outline(&self) -> Option<&Outline> {
        self.outline.as_ref()
    }
}
