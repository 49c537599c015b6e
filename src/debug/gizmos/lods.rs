//! Groups with levels of detail.

use bevy::{
    color::Color,
    ecs::entity::Entity,
    gizmos::{config::GizmoConfigGroup, gizmos::GizmoBuffer},
    math::{
        Vec3A,
        bounding::{Aabb3d, BoundingSphere},
    },
    transform::components::GlobalTransform,
};

use super::{
    config::color_of,
    shapes::{Pen, ROUNDED_LINES, SPHERE_LINES},
};
use crate::{geometry::volume::Volume, lod::LodChoices};

/// A group as the main camera sees it.
pub(super) struct GroupInView {
    pub root: Entity,
    pub level: usize,
    /// Around its bounds, which turn with the root.
    pub sphere: BoundingSphere,
    pub world_box: Aabb3d,
}

impl GroupInView {
    /// `None` if nothing is known of its bounds, or these are NaN or infinite.
    pub fn find(choices: &LodChoices, root: Entity, place: &GlobalTransform) -> Option<Self> {
        let bounds = choices.bounds(root)?;
        let world_from_root = place.affine();
        let center = world_from_root.transform_point3a(bounds.center);
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let corners = corners.map(|(y, z)| world_from_root.matrix3 * (bounds.half_extents * Vec3A::new(1.0, y, z)));
        let radius = corners.into_iter().map(Vec3A::length).fold(0.0, f32::max);
        if !center.is_finite() || !radius.is_finite() {
            return None;
        }
        let local = Aabb3d {
            min: bounds.min(),
            max: bounds.max(),
        };
        let main = choices.main_camera();
        Some(Self {
            root,
            level: main.and_then(|main| choices.level(root, main)).unwrap_or_default(),
            sphere: BoundingSphere::new(center, radius),
            world_box: local.transformed_by_affine(&world_from_root),
        })
    }

    /// Whether the main camera shows it at all, and not something coarser in the place of a group that it is in.
    pub fn is_shown(&self, choices: &LodChoices) -> bool {
        choices.main_camera().is_none_or(|main| choices.shows(main, self.root))
    }

    pub fn draw_sphere<Config, Clear>(
        &self,
        gizmos: &mut GizmoBuffer<Config, Clear>,
        palette: &[Color],
        left: usize,
    ) -> Option<usize>
    where
        Config: GizmoConfigGroup,
        Clear: 'static + Send + Sync,
    {
        let fits = left >= SPHERE_LINES;
        let mut pen = Pen { gizmos };
        fits.then(|| pen.sphere(&self.sphere, color_of(palette, self.level)))
            .flatten()
    }

    /// Draws from where on the main camera shows each level, in the colour of that.
    pub fn draw_distances<Config, Clear>(
        &self,
        gizmos: &mut GizmoBuffer<Config, Clear>,
        choices: &LodChoices,
        palette: &[Color],
    ) -> usize
    where
        Config: GizmoConfigGroup,
        Clear: 'static + Send + Sync,
    {
        let main = choices.main_camera();
        let distances = main.and_then(|main| choices.distances(self.root, main));
        let coarser = distances.into_iter().flatten().enumerate().skip(1);
        let mut pen = Pen { gizmos };
        let drawn =
            coarser.filter_map(|(level, distance)| pen.around_box(&self.world_box, distance, color_of(palette, level)));
        drawn.sum()
    }

    /// How many lines that takes at most.
    pub fn most_lines(&self, choices: &LodChoices) -> usize {
        let main = choices.main_camera();
        let distances = main.and_then(|main| choices.distances(self.root, main));
        SPHERE_LINES + ROUNDED_LINES * distances.into_iter().flatten().count()
    }
}
