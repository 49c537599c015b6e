//! Marquee and lasso selection: everything in a rectangle or a polygon on the screen.
//!
//! [`SceneQuery::select_on_screen`] finds all entities whose mesh lies in a [`ScreenRegion`] as a camera sees it, or
//! touches it: box selection as in strategy games and editors, the lasso, and, with a rectangle without an area, a click
//! that goes through everything.
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! fn release(
//!     scene: SceneQuery,
//!     view: Single<(&Camera, &GlobalTransform)>,
//!     dragged: Local<[Vec2; 2]>,
//!     mut units: Local<Vec<Entity>>,
//! ) {
//!     let (camera, eye) = *view;
//!     let [from, to] = *dragged;
//!     let marquee = ScreenRegion::rect(from, to);
//!     let settings = SceneQuerySettings::default();
//!     scene.select_on_screen(camera, eye, &marquee, &SelectionSettings::default(), &settings, &mut units);
//!     println!("{} units", units.len());
//! }
//! ```
//!
//! # What is selected
//!
//! - **Regions** are in logical pixels, as cursors and [`Camera::viewport_to_world`] have them, with y down; the offset of
//!   a viewport counts in. What is outside of the viewport, before the near plane or beyond a far plane that the projection
//!   has is not on the screen, and never touches a region. A perspective projection has no far plane.
//! - **What is hidden behind other things** is selected too, and so are back faces.
//! - **Contact** counts: region and meshes are closed, and things that come within [`SCREEN_CONTACT`] of each other touch.
//! - **Meshes** are tested triangle by triangle, as far as their bounds leave it open, in double precision, skinned and
//!   morphed ones where they are drawn. A [`PickShape`](crate::index::PickShape), a volume in place of a mesh
//!   ([`HitSurface`](crate::index::HitSurface)) and a sprite are tested by the convex shapes that make them up
//!   ([`Surface::visit_hulls`]): solids exactly, a torus and a concave extrusion by their convex hulls, a sprite as
//!   its rectangle with its holes, surfaces of your own by their boxes unless they say better. Entities without any of
//!   these, and those whose mesh has no triangles or is not loaded, are their world boxes.
//!
//! # How it is found
//!
//! The screen is never divided. The tree and the hierarchies of the meshes are gone down box by box: one whose image on the
//! screen meets no edge of the region is wholly inside, and then so is everything in it, or wholly outside. Only what meets
//! an edge is looked at more closely, in the end triangle by triangle: clipped against the view and the box around the region
//! in homogeneous coordinates (Sutherland and Hodgman, *Reentrant Polygon Clipping*, 1974; Blinn and Newell, *Clipping Using
//! Homogeneous Coordinates*, 1978), and held against the edges near its image. So concave and self-intersecting regions are
//! as exact as rectangles, and the cost goes with what is on the outline.
//!
//! [`Camera::viewport_to_world`]: bevy::camera::Camera::viewport_to_world
//! [`SceneQuery::select_on_screen`]: crate::index::SceneQuery::select_on_screen
//! [`SCREEN_CONTACT`]: crate::geometry::tolerance::SCREEN_CONTACT
//! [`Surface::visit_hulls`]: crate::geometry::surface::Surface::visit_hulls

mod hull;
mod outline;
mod region;
mod select;
mod triangle;
mod view;

pub use region::{ScreenRegion, UnusableRegion};

use bevy::reflect::{Reflect, std_traits::ReflectDefault};

/// What [`SceneQuery::select_on_screen`](crate::index::SceneQuery::select_on_screen) selects. By default all that touches,
/// by its mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub struct SelectionSettings {
    /// How much of an entity must be in the region.
    pub mode: SelectionMode,
    /// What of an entity must be there.
    pub precision: SelectionPrecision,
}

/// How much of an entity must be in a region on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum SelectionMode {
    /// Any part.
    #[default]
    Touching,
    /// All of it, with nothing off the screen. It may reach the outline of the region, but must not be crossed by it.
    Enclosed,
}

/// What of an entity must be in a region on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum SelectionPrecision {
    /// Its mesh, or what stands in for that: see the [module](self).
    #[default]
    Mesh,
    /// Its world box, as in [`SceneQuery::overlap`](crate::index::SceneQuery::overlap).
    Bounds,
}

impl SelectionSettings {
    /// Sets [`mode`](Self::mode).
    #[must_use]
    pub fn with_mode(self, mode: SelectionMode) -> Self {
        Self { mode, ..self }
    }

    /// Sets [`precision`](Self::precision).
    #[must_use]
    pub fn with_precision(self, precision: SelectionPrecision) -> Self {
        Self { precision, ..self }
    }
}
