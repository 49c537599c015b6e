//! Boxes inside of a solid mesh: what they hide, the mesh hides.
//!
//! 1. The mesh must enclose something: it has no open edge, and faces outward. If it consists of several parts
//!    that do, each is looked at by itself, for what is inside of it is hidden, whatever of the others is there.
//! 2. The box of each is cut into cells. Cells that no triangle touches lie inside or outside as a whole.
//! 3. Of all boxes of inner cells, the one with the largest surface that is not covered yet is taken, and its
//!    faces are pushed on to the triangles that they meet. Again, until it is no longer worth it.
//!
//! Whatever such a box hides from an eye outside of the mesh is behind a front face: on its way from the eye to the
//! box, a ray enters the solid. From an eye inside it is not, for there faces are seen from behind, and most are not
//! drawn then.
//!
//! Related: Darnell, *Automated Occluders for GPU Culling*, 2011, which keeps boxes of voxels too.

mod clip;
mod grid;
mod largest;
mod push;
mod search;
mod solid;

use bevy::{
    math::bounding::Aabb3d,
    reflect::{Reflect, std_traits::ReflectDefault},
};

use super::TriangleMesh;
use crate::spatial::{BuildProgress, build::Cancelled};
use search::Search;
use solid::{Solid, Solids};

/// Of how many parts of a mesh boxes are looked for, for each box that is asked for: of the largest.
const PARTS_PER_BOX: usize = 2;

/// How the boxes inside of a mesh are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct InnerBoxSettings {
    /// How many cells the longest side of the mesh is cut into, from 4 to 128; the other sides in proportion, and not
    /// into fewer than 8. 32 by default. The time grows with the fourth power.
    ///
    /// Cells are cut at large flat parts that are parallel to the axes too: walls may be much thinner than a cell.
    pub cells: u32,
    /// The most boxes that are looked for. 8 by default.
    pub max_boxes: usize,
    /// What another box has to add, as a fraction of what there is: of surface that is not covered. 0.03 by default.
    pub least_gain: f32,
}

impl Default for InnerBoxSettings {
    fn default() -> Self {
        Self {
            cells: 32,
            max_boxes: 8,
            least_gain: 0.03,
        }
    }
}

/// Why there are no boxes inside of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum NotSolid {
    /// The surface has a border, or neighbours that face opposite ways.
    #[error("it is open: {edges} of its edges are without an opposite")]
    Open {
        /// How many edges have more triangles on one side than on the other.
        edges: usize,
    },
    /// Its triangles face inward.
    #[error("it is inside out")]
    InsideOut,
    /// It encloses nothing, or only what is thinner than a cell.
    #[error("there is no room in it for a box")]
    NoRoom,
}

/// Axis-aligned boxes inside of a solid mesh, in its local space; the most useful first. They may overlap.
///
/// Triangles wind around every point of them, counter-clockwise from outside. No triangle touches a box but those of
/// parts that overlap the one in which it lies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InnerBoxes {
    /// The boxes, each of positive size.
    pub boxes: Vec<Aabb3d>,
}

impl InnerBoxes {
    /// Finds boxes inside of `mesh`.
    ///
    /// Triangles that face each other at no distance enclose nothing, parts that overlap count once, and so does what
    /// is enclosed several times. Gaps of up to [`tolerance::SEAM`](crate::geometry::tolerance::SEAM) are closed.
    ///
    /// # Errors
    ///
    /// If there is none, and why.
    pub fn find(mesh: &TriangleMesh, settings: &InnerBoxSettings) -> Result<Self, NotSolid> {
        Self::find_with(mesh, settings, None).expect("nothing calls it off")
    }

    /// The same; `None` if `progress` was told to [cancel](BuildProgress::cancel).
    ///
    /// # Errors
    ///
    /// If there is none, and why.
    pub fn find_with(
        mesh: &TriangleMesh,
        settings: &InnerBoxSettings,
        progress: Option<&BuildProgress>,
    ) -> Option<Result<Self, NotSolid>> {
        match search(mesh, settings, progress) {
            Ok(boxes) => Some(Ok(Self { boxes })),
            Err(Stopped::NotSolid(why)) => Some(Err(why)),
            Err(Stopped::Cancelled) => None,
        }
    }
}

/// The search has ended without boxes.
enum Stopped {
    NotSolid(NotSolid),
    Cancelled,
}

impl From<NotSolid> for Stopped {
    fn from(why: NotSolid) -> Self {
        Self::NotSolid(why)
    }
}

impl From<Cancelled> for Stopped {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

fn search(
    mesh: &TriangleMesh,
    settings: &InnerBoxSettings,
    progress: Option<&BuildProgress>,
) -> Result<Vec<Aabb3d>, Stopped> {
    let Solids { whole, mut parts } = Solids::new(mesh)?;
    let mut of_parts = None;
    // What is inside of a part is inside of the mesh, unless another part is a hole.
    if parts.len() > 1 && !parts.iter().any(Solid::is_inverted) {
        parts.sort_by(|a, b| b.surface().total_cmp(&a.surface()));
        parts.truncate(settings.max_boxes.saturating_mul(PARTS_PER_BOX));
        of_parts = Some(Search::new(&parts, &whole, settings, progress)?);
    }
    let mut search = match of_parts.filter(|search| !search.enclosed.any_inverted) {
        Some(search) => search,
        None => Search::new(std::slice::from_ref(&whole), &whole, settings, progress)?,
    };
    if !search.enclosed.any && search.enclosed.any_inverted {
        return Err(NotSolid::InsideOut.into());
    }
    let boxes = search.take_boxes(settings, progress)?;
    if boxes.is_empty() {
        return Err(NotSolid::NoRoom.into());
    }
    Ok(boxes)
}
