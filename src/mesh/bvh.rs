//! A bounding volume hierarchy over the triangles of one mesh.

use std::ops::Range;

use bevy::math::{Vec3, bounding::Aabb3d};

use super::triangles::{MeshEdit, TriangleHit, TriangleMesh, nearer};
use crate::{
    geometry::{
        aabb::{EMPTY, union},
        ray::{
            Ray,
            triangle::{Backfaces, TriangleRay},
        },
        surface::{Surface, SurfaceHit},
    },
    spatial::{
        Visit,
        lanes::Entering,
        traverse::visit_in_order,
        wide::{Child, EVERY_MASK, WideNode},
    },
};

/// The most triangles that a leaf holds.
pub(super) const LEAF_SIZE: usize = 6;

/// A static hierarchy over the triangles of one mesh, for all its instances.
///
/// Gives the same answers as the [`TriangleMesh`] that it was built from, and in O(log n) instead of O(n): hit for hit,
/// as long as the rounding of `f32` at the distance of the ray's origin is finer than the triangles.
///
/// Holds up to 2²⁸ triangles.
#[derive(Clone, Debug)]
pub struct MeshBvh {
    /// The root first.
    pub(super) nodes: Vec<WideNode>,
    /// Its slots are in the order of the leaves.
    pub(super) mesh: TriangleMesh,
}

impl MeshBvh {
    /// Moves the vertices of the mesh, vertex `i` to `positions[i]`, and fits every box to what is below it, in O(n). The
    /// answers are those of a hierarchy built anew; the farther the vertices have moved, the longer they take.
    ///
    /// # Panics
    ///
    /// If there are fewer positions than [vertices](TriangleMesh::vertex_count), or if one that is used is NaN or
    /// infinite.
    pub fn refit(&mut self, positions: &[Vec3]) {
        self.mesh.move_vertices(positions);
        self.fit_boxes();
    }

    /// The hierarchy with these nodes, whatever boxes they have, over the slots of `mesh`.
    pub(super) fn from_parts(nodes: Vec<WideNode>, mesh: TriangleMesh) -> Self {
        let mut bvh = Self { nodes, mesh };
        bvh.fit_boxes();
        bvh
    }

    /// Fits every box to what is below it.
    fn fit_boxes(&mut self) {
        // Children come after their parents.
        for index in (0..self.nodes.len()).rev() {
            for lane in 0..self.nodes[index].len() {
                let bounds = match self.nodes[index].child(lane) {
                    Child::Node(child) => self.nodes[child as usize].bounds(),
                    Child::Leaf(leaf) => {
                        unpack_slots(leaf).fold(EMPTY, |bounds, slot| union(&bounds, &self.mesh.triangle_box(slot)))
                    }
                };
                self.nodes[index].set_aabb(lane, &bounds);
            }
        }
    }

    /// Takes over the vertices of an edited mesh, which has the same triangles in any order of slots.
    pub(crate) fn take_vertices_of(&mut self, edited: &TriangleMesh, edit: MeshEdit) {
        debug_assert!(edit < MeshEdit::Topology);
        self.mesh.take_attributes_of(edited);
        if edit == MeshEdit::Positions {
            self.refit(&edited.positions());
        }
    }

    /// The triangles; hits of this hierarchy are looked up there.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    pub(super) fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    /// The nearest hit. Of triangles at one parameter the one with the smallest number wins.
    pub fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<TriangleHit> {
        let triangle_ray = TriangleRay::new(ray);
        let mut closest: Option<TriangleHit> = None;
        self.visit_ray(ray, |leaf| {
            for slot in unpack_slots(leaf) {
                let t_max = closest.map_or(ray.t_max(), |hit| hit.t);
                let corners = self.mesh.corners(slot);
                if let Some(hit) = triangle_ray.triangle_intersection(corners, t_max, backfaces) {
                    closest = nearer(closest, self.mesh.hit(slot, hit));
                }
            }
            closest.map_or(Visit::Continue, |hit| Visit::Shorten(hit.t))
        });
        closest
    }

    /// Whether there is any hit: stops at the first.
    pub fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        let triangle_ray = TriangleRay::new(ray);
        let mut found = false;
        self.visit_ray(ray, |leaf| {
            found = unpack_slots(leaf).any(|slot| {
                let corners = self.mesh.corners(slot);
                let hit = triangle_ray.triangle_intersection(corners, ray.t_max(), backfaces);
                hit.is_some()
            });
            if found { Visit::Stop } else { Visit::Continue }
        });
        found
    }

    /// Visits the leaves that the ray enters, near ones first.
    fn visit_ray(&self, ray: &Ray, mut visit: impl FnMut(u32) -> Visit) {
        let approach = Entering::new(ray);
        visit_in_order(&self.nodes, 0, EVERY_MASK, ray.t_max(), approach, |leaf, _| visit(leaf));
    }
}

/// The slots of a leaf in 31 bits.
pub(super) fn pack_slots(first: u32, count: u32) -> u32 {
    debug_assert!(count as usize <= LEAF_SIZE && first < 1 << 28);
    first << 3 | count
}

pub(super) fn unpack_slots(leaf: u32) -> Range<u32> {
    let first = leaf >> 3;
    first..first + (leaf & 7)
}

/// With the normal and the texture coordinates of the mesh; where it has none, those of the triangle, and zero.
impl Surface for MeshBvh {
    fn aabb(&self) -> Option<Aabb3d> {
        Some(self.mesh.aabb())
    }

    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        let hit = MeshBvh::closest_hit(self, ray, backfaces)?;
        let normal = self.mesh.normal(&hit).normalize_or_zero();
        Some(SurfaceHit::new(hit.t, normal, self.mesh.uv(&hit).unwrap_or_default()))
    }

    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        MeshBvh::any_hit(self, ray, backfaces)
    }
}
