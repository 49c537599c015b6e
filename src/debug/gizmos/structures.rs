//! Any structure, and any ray.

use std::ops::RangeInclusive;

use bevy::{
    color::{
        Color,
        palettes::tailwind::{AMBER_400, EMERALD_400, ROSE_500},
    },
    gizmos::{config::GizmoConfigGroup, gizmos::GizmoBuffer},
    math::{Affine3A, Ray3d, Vec3, bounding::Aabb3d, primitives::ViewFrustum},
};

use super::{
    GizmoCount,
    config::{DEFAULT_LIMIT, color_of, default_palette},
    nearest::Nearest,
    shapes::{BOX_LINES, Pen},
    views::{View, Views},
};
use crate::{
    geometry::volume::AnyVolume,
    index::RayHit,
    spatial::{AabbTree, Descend, KdTree, Octree, PointKdTree, UniformGrid},
};

/// How a structure is drawn, and how much of it.
#[derive(Clone, Debug)]
pub struct StructureStyle {
    /// Which cells or nodes. Of trees the depth, with zero for the root: of an octree how many times smaller a cell is than
    /// the whole, as a power of two. Of a grid the level, with zero for the finest.
    pub depths: RangeInclusive<usize>,
    /// The colours of the depths, over and over. White if there are none.
    pub palette: Vec<Color>,
    /// The most lines; a cell takes twelve.
    pub limit: usize,
    /// Only what may be in here, its far plane passed over.
    pub within: Option<ViewFrustum>,
    /// From where it is told what is nearest, and comes first where the limit is reached. Without it, what is nearer to the
    /// root comes first.
    pub nearest_to: Option<Vec3>,
}

impl Default for StructureStyle {
    fn default() -> Self {
        Self {
            depths: 0..=usize::MAX,
            palette: default_palette(),
            limit: DEFAULT_LIMIT,
            within: None,
            nearest_to: None,
        }
    }
}

/// Draws structures and rays; every `Gizmos` can.
pub trait DrawStructures {
    /// Draws the nodes of a tree: the boxes around what is below them.
    fn aabb_tree<K: Copy>(&mut self, tree: &AabbTree<K>, style: &StructureStyle) -> GizmoCount;

    /// Draws the cells of a grid that hold something.
    fn uniform_grid<K: Copy>(&mut self, grid: &UniformGrid<K>, style: &StructureStyle) -> GizmoCount;

    /// Draws the cells of a tree over boxes: the boxes around what is in them, down to the single ones.
    fn kd_tree<K: Copy>(&mut self, tree: &KdTree<K>, style: &StructureStyle) -> GizmoCount;

    /// Draws the cells of a tree over points: the boxes around what is in them.
    fn point_kd_tree<K: Copy>(&mut self, tree: &PointKdTree<K>, style: &StructureStyle) -> GizmoCount;

    /// Draws the cells of an octree.
    fn octree<K: Copy>(&mut self, octree: &Octree<K>, style: &StructureStyle) -> GizmoCount;

    /// Draws a bounding volume where `world_from_local` puts it: a box as it stands in its own space.
    fn bounding_volume(&mut self, volume: &AnyVolume, world_from_local: &Affine3A, color: Color);

    /// Draws a ray up to what it hits, with the normal there and the triangle; without a hit, for a thousand units.
    fn ray_hit(&mut self, ray: Ray3d, hit: Option<&RayHit>);
}

impl<Config, Clear> DrawStructures for GizmoBuffer<Config, Clear>
where
    Config: GizmoConfigGroup,
    Clear: 'static + Send + Sync,
{
    fn aabb_tree<K: Copy>(&mut self, tree: &AabbTree<K>, style: &StructureStyle) -> GizmoCount {
        Cells::of_style(style).draw(self, |cells| {
            tree.descend_nodes(|depth, aabb| cells.descend(depth, aabb));
        })
    }

    fn uniform_grid<K: Copy>(&mut self, grid: &UniformGrid<K>, style: &StructureStyle) -> GizmoCount {
        Cells::of_style(style).draw(self, |cells| cells.of_grid(grid))
    }

    fn kd_tree<K: Copy>(&mut self, tree: &KdTree<K>, style: &StructureStyle) -> GizmoCount {
        Cells::of_style(style).draw(self, |cells| {
            tree.descend_cells(|depth, aabb| cells.descend(depth, aabb));
        })
    }

    fn point_kd_tree<K: Copy>(&mut self, tree: &PointKdTree<K>, style: &StructureStyle) -> GizmoCount {
        Cells::of_style(style).draw(self, |cells| {
            tree.descend_cells(|depth, aabb| cells.descend(depth, aabb));
        })
    }

    fn octree<K: Copy>(&mut self, octree: &Octree<K>, style: &StructureStyle) -> GizmoCount {
        Cells::of_style(style).draw(self, |cells| {
            let mut root = None;
            octree.visit_nodes(|node| {
                // The cells below are within this one, and no box is asked for.
                let root = *root.get_or_insert(node.level);
                cells.descend((root - node.level).unsigned_abs() as usize, &node.cell)
            });
        })
    }

    fn bounding_volume(&mut self, volume: &AnyVolume, world_from_local: &Affine3A, color: Color) {
        Pen { gizmos: self }.volume(volume, world_from_local, color);
    }

    fn ray_hit(&mut self, ray: Ray3d, hit: Option<&RayHit>) {
        const WITHOUT_HIT: f32 = 1000.0;
        let hit = hit.filter(|hit| hit.position.is_finite() && hit.normal.is_finite());
        let end = hit.map_or_else(|| ray.get_point(WITHOUT_HIT), |hit| hit.position);
        if !ray.origin.is_finite() || !end.is_finite() {
            return;
        }
        self.line(ray.origin, end, if hit.is_some() { AMBER_400 } else { ROSE_500 });
        let Some(hit) = hit else {
            return;
        };
        // As large from where the ray starts, however far away.
        let size = 0.05 * ray.origin.distance(end);
        self.line(end, end + size * hit.normal, EMERALD_400);
        for axis in Vec3::AXES {
            let arm = 0.1 * size * axis;
            self.line(end - arm, end + arm, AMBER_400);
        }
        let vertices = hit.triangle.map(|triangle| triangle.vertices);
        if let Some([a, b, c]) = vertices.filter(|vertices| vertices.iter().all(|vertex| vertex.is_finite())) {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                self.line(from, to, EMERALD_400);
            }
        }
    }
}

/// Cells that are to be drawn.
pub(super) struct Cells<'a> {
    depths: &'a RangeInclusive<usize>,
    palette: &'a [Color],
    /// Everything, if there are none.
    views: Option<&'a Views>,
    own_views: Option<Views>,
    eye: Option<Vec3>,
    nearest: Nearest<(usize, Aabb3d)>,
}

impl<'a> Cells<'a> {
    /// Those that are in view.
    pub fn in_view(depths: &'a RangeInclusive<usize>, palette: &'a [Color], limit: usize, views: &'a Views) -> Self {
        Self {
            depths,
            palette,
            views: Some(views),
            own_views: None,
            eye: None,
            nearest: Nearest::new(limit, BOX_LINES),
        }
    }

    fn of_style(style: &'a StructureStyle) -> Self {
        let eye = style.nearest_to.filter(|eye| eye.is_finite());
        let views = style.within.as_ref().map(|frustum| Views {
            views: vec![View::new(eye.unwrap_or_default().into(), frustum)],
        });
        Self {
            depths: &style.depths,
            palette: &style.palette,
            views: None,
            own_views: views,
            eye,
            nearest: Nearest::new(style.limit, BOX_LINES),
        }
    }

    fn views(&self) -> Option<&Views> {
        self.views.or(self.own_views.as_ref())
    }

    fn may_see(&self, aabb: &Aabb3d) -> bool {
        self.views().is_none_or(|views| views.may_see(aabb))
    }

    fn add(&mut self, depth: usize, aabb: &Aabb3d) {
        if !self.depths.contains(&depth) {
            return;
        }
        let distance = match (self.views, self.eye) {
            (Some(views), _) => views.distance_squared(aabb),
            (None, Some(eye)) => aabb.closest_point(eye).distance_squared(eye.into()),
            (None, None) => depth as f32,
        };
        self.nearest.offer(distance, (depth, *aabb));
    }

    /// Takes a cell that contains those below it.
    pub fn descend(&mut self, depth: usize, aabb: &Aabb3d) -> Descend {
        if !self.may_see(aabb) {
            return Descend::Past;
        }
        self.add(depth, aabb);
        if depth < *self.depths.end() {
            Descend::Into
        } else {
            Descend::Past
        }
    }

    /// Takes the cells of a grid.
    pub fn of_grid<K: Copy>(&mut self, grid: &UniformGrid<K>) {
        grid.visit_cells(|cell, cube, _| {
            if self.may_see(cube) {
                self.add(cell.level() as usize, cube);
            }
        });
    }

    /// Draws what `gather` finds.
    pub fn draw<Config, Clear>(
        mut self,
        gizmos: &mut GizmoBuffer<Config, Clear>,
        gather: impl FnOnce(&mut Self),
    ) -> GizmoCount
    where
        Config: GizmoConfigGroup,
        Clear: 'static + Send + Sync,
    {
        gather(&mut self);
        let palette = self.palette;
        self.nearest.draw(|(depth, aabb), left| {
            let fits = left >= BOX_LINES;
            let mut pen = Pen { gizmos: &mut *gizmos };
            fits.then(|| pen.aabb(&aabb, color_of(palette, depth))).flatten()
        })
    }
}
