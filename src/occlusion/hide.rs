//! Drawing and testing, node by node from the nearest to the farthest.

use bevy::math::{
    DMat4, Mat4, Vec3A, Vec4,
    bounding::{Aabb3d, BoundingVolume, IntersectsVolume},
};

use super::{OccluderShape, Occluders, OcclusionBuffer, OcclusionStats, SoftwareOcclusion};
use crate::{
    geometry::tolerance,
    index::{Key, SpatialIndex},
    raster::{Faces, MaskedDepthBuffer, PixelRect},
    spatial::{
        aabb_tree::{HalfSpaces, Judge, Sides, Waiting},
        lanes::Boxes,
        simd::{LANES, Simd},
    },
};

/// From where it is asked what is hidden, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viewpoint {
    settings: SoftwareOcclusion,
    clip_from_world: Mat4,
    /// Whether the renderer shows the faces that others do not.
    inverts_culling: bool,
    /// Around the eye and its near plane.
    lens: Aabb3d,
}

/// Who is asked.
pub(crate) struct Surroundings<'a> {
    pub index: &'a SpatialIndex,
    pub occluders: &'a Occluders,
    pub half_spaces: &'a HalfSpaces,
    pub mask: u32,
}

/// Kept for its memory.
#[derive(Debug, Default)]
pub(super) struct Work {
    waiting: Vec<Waiting<PixelRect>>,
    /// What was seen when its turn came.
    seen: Vec<(Key, PixelRect)>,
}

impl Viewpoint {
    /// None if depth is not as Bevy has it, larger for what is nearer, if the near plane is so oblique that it is not before
    /// all of the screen, or if something is NaN or infinite.
    pub fn new(
        settings: SoftwareOcclusion,
        clip_from_view: Mat4,
        world_from_view: Mat4,
        inverts_culling: bool,
    ) -> Option<Self> {
        let clip = |distance: f32| clip_from_view * Vec4::new(0.0, 0.0, -distance, 1.0);
        let [near, far] = [clip(1.0), clip(2.0)];
        let is_reversed = near.w > 0.0 && far.w > 0.0 && near.z / near.w > far.z / far.w;
        let clip_from_world = clip_from_view * world_from_view.inverse();
        if !is_reversed || !clip_from_world.is_finite() {
            return None;
        }
        let view_from_clip = clip_from_view.inverse();
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let corners = corners.map(|(x, y)| view_from_clip * Vec4::new(x, y, 1.0, 1.0));
        if !corners.iter().all(|corner| corner.w > 0.0) {
            return None;
        }
        let corners = corners.map(|corner| world_from_view.transform_point3(corner.truncate() / corner.w));
        let eye = world_from_view.w_axis.truncate();
        let (mut min, mut max) = (eye, eye);
        for corner in corners {
            (min, max) = (min.min(corner), max.max(corner));
        }
        let lens = Aabb3d {
            min: min.into(),
            max: max.into(),
        };
        let rounding = tolerance::RASTER_BOX * (lens.min.abs().max(lens.max.abs()).max_element());
        lens.min.is_finite().then(|| Self {
            settings,
            clip_from_world,
            inverts_culling,
            lens: lens.grow(Vec3A::splat(rounding)),
        })
    }

    /// Whether the same is hidden, if nothing changes that hides or is hidden.
    pub fn is_same(&self, other: &Self) -> bool {
        self.settings == other.settings
            && self.clip_from_world == other.clip_from_world
            && self.inverts_culling == other.inverts_culling
    }
}

impl OcclusionBuffer {
    /// Finds what is within half-spaces and not hidden by what is nearer.
    pub(crate) fn find_seen(
        &mut self,
        viewpoint: &Viewpoint,
        around: &Surroundings,
        may_occlude: impl Fn(Key) -> bool,
        sides: &mut impl Sides<Key>,
    ) {
        let SoftwareOcclusion { mode, resolution, .. } = viewpoint.settings;
        self.depth.begin(resolution, mode);
        self.viewpoint = Some(*viewpoint);
        self.is_new = true;
        self.work.seen.clear();
        let screen = self.depth.size().element_product() as f32;
        let mut hide = Hide {
            depth: &mut self.depth,
            seen: &mut self.work.seen,
            stats: OcclusionStats::default(),
            viewpoint,
            clip_from_world: viewpoint.clip_from_world.as_dmat4(),
            screen,
            occluders: around.occluders,
            may_occlude,
            sides,
        };
        let tree = around.index.tree();
        tree.judge(around.half_spaces, around.mask, &mut hide, &mut self.work.waiting);
        self.stats = hide.stats;
    }

    /// What was seen when its turn came, and is hidden by what was drawn since.
    pub(crate) fn hidden_since(&mut self) -> impl Iterator<Item = Key> + '_ {
        let Self { depth, stats, work, .. } = self;
        stats.tested += work.seen.len();
        work.seen.iter().filter_map(|(key, place)| {
            let is_hidden = depth.hides(place);
            stats.hidden += usize::from(is_hidden);
            is_hidden.then_some(*key)
        })
    }

    /// Whether a box is behind what was drawn.
    pub(crate) fn hides(&self, aabb: &Aabb3d) -> bool {
        let is_hidden_from = |viewpoint: &Viewpoint| {
            let place = self.depth.rect_of(aabb, &viewpoint.clip_from_world);
            self.depth.hides_rect(&place)
        };
        self.viewpoint.as_ref().is_some_and(is_hidden_from)
    }

    /// Whether something has been drawn, in this frame or an earlier one.
    pub(crate) fn is_drawn(&self) -> bool {
        self.viewpoint.is_some()
    }

    /// Whether it was drawn since this was last asked.
    pub(crate) fn take_new(&mut self) -> bool {
        std::mem::take(&mut self.is_new)
    }
}

/// Judges by what has been drawn so far, and draws what occludes.
struct Hide<'a, F, V> {
    depth: &'a mut MaskedDepthBuffer,
    seen: &'a mut Vec<(Key, PixelRect)>,
    stats: OcclusionStats,
    viewpoint: &'a Viewpoint,
    /// In double precision.
    clip_from_world: DMat4,
    /// The pixels of the buffer.
    screen: f32,
    occluders: &'a Occluders,
    may_occlude: F,
    sides: &'a mut V,
}

impl<F: Fn(Key) -> bool, V: Sides<Key>> Judge<Key> for Hide<'_, F, V> {
    type Place = PixelRect;

    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, boxes: Boxes) -> [PixelRect; LANES] {
        self.depth.pixels_of_boxes(simd, boxes, &self.viewpoint.clip_from_world)
    }

    #[inline(always)]
    fn nearness(place: &PixelRect) -> f32 {
        place.nearest
    }

    #[inline(always)]
    fn is_open<S: Simd>(&mut self, simd: S, place: &PixelRect) -> bool {
        self.stats.tested += 1;
        // What is beside the screen is for the half-spaces to tell.
        place.is_empty() || self.depth.shows(simd, place)
    }

    #[inline(always)]
    fn visit<S: Simd>(&mut self, _: S, key: Key, aabb: &Aabb3d, place: &PixelRect, is_inside: bool) {
        if is_inside {
            self.sides.inside(&[key]);
        } else {
            self.sides.across(key, aabb);
        }
        self.seen.push((key, *place));
        self.draw(key, aabb, place);
    }

    fn pass_over(&mut self, count: usize) {
        self.stats.hidden += count;
    }
}

impl<F: Fn(Key) -> bool, V> Hide<'_, F, V> {
    /// Draws an entity if it occludes and is worth it.
    ///
    /// What lies within what is drawn hides as that does, but for two cases: from within, or where the near plane cuts
    /// its surface away, one sees through; and what is seen turned inside out shows its inside.
    #[inline]
    fn draw(&mut self, key: Key, aabb: &Aabb3d, place: &PixelRect) {
        let Viewpoint {
            settings: SoftwareOcclusion { budget, .. },
            inverts_culling,
            lens,
            ..
        } = self.viewpoint;
        if (place.area() as f32) < budget.least_area * self.screen {
            return;
        }
        let Some((shape, world_from_local)) = self.occluders.get(key.entity) else {
            return;
        };
        let clip_from_local = self.clip_from_world * Mat4::from(*world_from_local).as_dmat4();
        let is_mirrored = clip_from_local.determinant() < 0.0;
        if is_mirrored != *inverts_culling || lens.intersects(aabb) || !(self.may_occlude)(key) {
            return;
        }
        let triangles = match shape {
            OccluderShape::Boxes(boxes) => 12 * boxes.len(),
            OccluderShape::Mesh(mesh) => mesh.len(),
        };
        if self.stats.occluders >= budget.occluders || self.stats.triangles + triangles > budget.triangles {
            self.stats.over_budget += 1;
            return;
        }
        self.stats.occluders += 1;
        self.stats.triangles += triangles;
        match shape {
            OccluderShape::Boxes(boxes) => {
                for aabb in &**boxes {
                    self.depth.draw_box(aabb, &clip_from_local);
                }
            }
            OccluderShape::Mesh(mesh) => {
                let faces = if *inverts_culling { Faces::Back } else { Faces::Front };
                self.depth.draw_mesh(mesh, &clip_from_local, faces);
            }
        }
    }
}
