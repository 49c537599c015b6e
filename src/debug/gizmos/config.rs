//! What is to be drawn.

use std::ops::RangeInclusive;

use bevy::{
    color::{
        Color,
        palettes::tailwind::{AMBER_400, CYAN_400, EMERALD_400, FUCHSIA_500, LIME_400, ORANGE_500, ROSE_500, SKY_500},
    },
    ecs::{component::Component, reflect::ReflectComponent},
    gizmos::config::GizmoConfigGroup,
    reflect::{Reflect, std_traits::ReflectDefault},
};

use crate::geometry::volume::BoundingKind;

/// What is drawn of the whole scene: see [`gizmos`](super). By default, nothing.
#[derive(Clone, Debug, PartialEq, Reflect, GizmoConfigGroup)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct SightlineGizmos {
    /// The nodes of the tree.
    pub nodes: bool,
    /// The cells of the grid that hold something.
    pub cells: bool,
    /// The world boxes of entities.
    pub leaves: bool,
    /// The bounding volumes of this kind around what rays hit. Of what is posed or no mesh, the world box.
    pub volumes: Option<BoundingKind>,
    /// What cameras see.
    pub frusta: bool,
    /// What things occlude by.
    pub occluders: bool,
    /// The rays of pointers, with what they hit. Of no effect without the feature `picking`.
    pub rays: bool,
    /// The spheres around groups with levels of detail.
    pub lods: bool,
    /// Which nodes of the tree, by depth, with zero for the root; and which cells of the grid, by level, with zero for the
    /// finest.
    pub depths: RangeInclusive<usize>,
    /// The colours of depths and levels, over and over. White if there are none.
    pub palette: Vec<Color>,
    /// The most lines of each kind in a frame; the nearest come first. A box is twelve lines.
    pub limit: usize,
}

impl SightlineGizmos {
    pub(super) fn is_any_on(&self) -> bool {
        let switches = [
            self.nodes,
            self.cells,
            self.leaves,
            self.volumes.is_some(),
            self.frusta,
            self.occluders,
            self.rays,
            self.lods,
        ];
        switches.contains(&true)
    }
}

impl Default for SightlineGizmos {
    fn default() -> Self {
        Self {
            nodes: false,
            cells: false,
            leaves: false,
            volumes: None,
            frusta: false,
            occluders: false,
            rays: false,
            lods: false,
            depths: 0..=usize::MAX,
            palette: default_palette(),
            limit: DEFAULT_LIMIT,
        }
    }
}

/// The most lines: five thousand boxes.
pub(super) const DEFAULT_LIMIT: usize = 60_000;

/// The colours of depths and levels that are used by default.
pub fn default_palette() -> Vec<Color> {
    let colors = [
        ROSE_500,
        ORANGE_500,
        AMBER_400,
        LIME_400,
        EMERALD_400,
        CYAN_400,
        SKY_500,
        FUCHSIA_500,
    ];
    colors.map(Color::from).to_vec()
}

/// The colour of a depth or level.
pub(super) fn color_of(palette: &[Color], depth: usize) -> Color {
    palette
        .get(depth % palette.len().max(1))
        .copied()
        .unwrap_or(Color::WHITE)
}

/// Draws what is known of one entity, whatever is switched on for all. By default, all but a bounding volume.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct ShowGizmos {
    /// Its world box.
    pub leaf: bool,
    /// The bounding volume of this kind around what rays hit of it.
    pub volume: Option<BoundingKind>,
    /// What it occludes by.
    pub occluder: bool,
    /// If it is the root of a group with levels of detail: its sphere, and from where on the main camera shows each of the
    /// levels, in the horizontal plane through the centre of the group.
    pub lod: bool,
    /// If it is a camera: what it sees.
    pub frustum: bool,
}

impl Default for ShowGizmos {
    fn default() -> Self {
        Self {
            leaf: true,
            volume: None,
            occluder: true,
            lod: true,
            frustum: true,
        }
    }
}

impl ShowGizmos {
    /// Draws nothing: to switch on one thing.
    pub const NOTHING: Self = Self {
        leaf: false,
        volume: None,
        occluder: false,
        lod: false,
        frustum: false,
    };
}
