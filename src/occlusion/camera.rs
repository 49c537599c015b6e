//! Cameras that do not see what is hidden.

use std::ops::AddAssign;

use bevy::{
    ecs::{component::Component, reflect::ReflectComponent},
    math::UVec2,
    reflect::{Reflect, std_traits::ReflectDefault},
};

use super::hide::{Viewpoint, Work};
use crate::raster::{MaskedDepthBuffer, RasterMode};

/// Has a camera leave out what is behind [occluders](super::Occluder).
///
/// Takes effect in the frame in which it comes, goes, or changes. Needs [`OcclusionPlugin`](super::OcclusionPlugin) and
/// [`ViewCullingPlugin`](crate::culling::ViewCullingPlugin), and does nothing without them, nor while
/// [view culling](crate::culling::ViewCullingSettings) is left to Bevy, nor for a camera with `NoCpuCulling`. It shortens
/// the lists of this camera, and never those of lights.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(OcclusionBuffer)]
pub struct SoftwareOcclusion {
    /// How surely what is left out is hidden.
    pub mode: RasterMode,
    /// The pixels of the buffer, across and down, which need not be as many as those of the view, nor in the same ratio.
    /// Brought within 8 to 8192. More of them hide more. In [`RasterMode::Fast`] fewer than the default hide too much.
    pub resolution: UVec2,
    /// How much is drawn to it.
    pub budget: OcclusionBudget,
}

impl Default for SoftwareOcclusion {
    fn default() -> Self {
        Self {
            mode: RasterMode::default(),
            resolution: UVec2::new(1024, 512),
            budget: OcclusionBudget::default(),
        }
    }
}

/// How much is drawn to hide things, in each frame and for each camera: the nearest first.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct OcclusionBudget {
    /// The most entities.
    pub occluders: usize,
    /// The most triangles. A box is twelve. A mesh of more is never drawn.
    pub triangles: usize,
    /// The least share of the view, from 0 to 1, that the box of an entity must take up for it to be drawn.
    pub least_area: f32,
}

impl Default for OcclusionBudget {
    fn default() -> Self {
        Self {
            occluders: 512,
            triangles: 16_384,
            least_area: 0.000_5,
        }
    }
}

/// Is seen, if it is within the view, behind whatever hides other things: for what a shader moves out of its box, for outlines
/// and marks that are drawn through everything.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq, Hash)]
pub struct NoOcclusionCulling;

/// What hides things from a camera, as of the last frame in which something changed. On every camera with
/// [`SoftwareOcclusion`], and empty without that.
///
/// Not reflected, for it is drawn anew where a scene is loaded; its figures are: [`OcclusionStats`].
#[derive(Component, Debug, Default)]
pub struct OcclusionBuffer {
    pub(super) depth: MaskedDepthBuffer,
    pub(super) stats: OcclusionStats,
    pub(super) work: Work,
    /// From where it was drawn.
    pub(super) viewpoint: Option<Viewpoint>,
    /// Whether that was since somebody asked.
    pub(super) is_new: bool,
}

impl OcclusionBuffer {
    /// The depths of what hides things.
    pub fn depth(&self) -> &MaskedDepthBuffer {
        &self.depth
    }

    /// What was done.
    pub fn stats(&self) -> &OcclusionStats {
        &self.stats
    }
}

/// What finding out what is hidden took, the last time that it had to be found out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OcclusionStats {
    /// The entities that were drawn.
    pub occluders: usize,
    /// The triangles that they have. A box is twelve.
    pub triangles: usize,
    /// The entities that were not drawn, as the [budget](OcclusionBudget) was used up, or had too little left for them.
    pub over_budget: usize,
    /// The boxes, of entities and of nodes of the tree, that were tested.
    pub tested: usize,
    /// The entities that were passed over: hidden themselves, or in a node of the tree that is. Of such a node some may be
    /// beside the view.
    pub hidden: usize,
}

impl AddAssign for OcclusionStats {
    fn add_assign(&mut self, other: Self) {
        self.occluders += other.occluders;
        self.triangles += other.triangles;
        self.over_budget += other.over_budget;
        self.tested += other.tested;
        self.hidden += other.hidden;
    }
}
