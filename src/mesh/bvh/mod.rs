//! A bounding volume hierarchy over the triangles of one mesh.

mod pack;
mod packets;
mod rays;
mod refit;

use std::ops::{ControlFlow, Range};

use bevy::math::{bounding::Aabb3d, primitives::Triangle3d};

use super::triangles::TriangleMesh;
use crate::{
    geometry::{
        ray::{Ray, triangle::Backfaces},
        support::Support,
        surface::{Surface, SurfaceHit},
    },
    spatial::{build::sah_cost, simd::LANES, wide::WideNode},
};

/// The most triangles that a leaf holds: one packet.
pub(super) const LEAF_SIZE: usize = LANES;

/// A static hierarchy over the triangles of one mesh, for all its instances.
///
/// Gives the same answers as the [`TriangleMesh`] that it was built from, and in O(log n) instead of O(n): hit for hit,
/// as long as the rounding of `f32` at the distance of the ray's origin is finer than the triangles.
///
/// Holds up to 2²⁸ triangles. A clone shares what does not change when [vertices move](Self::refit), and has its own boxes
/// and corners.
#[derive(Clone, Debug)]
pub struct MeshBvh {
    /// The root first.
    nodes: Vec<WideNode>,
    /// A group of its triangles for each leaf, in the order of the nodes and lanes.
    mesh: TriangleMesh,
}

impl MeshBvh {
    /// The triangles; hits of this hierarchy are looked up there.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// What the hierarchy costs to query: the number of boxes that a random line meets which meets the bounds (Goldsmith
    /// and Salmon, *Automatic Creation of Object Hierarchies for Ray Tracing*, 1987). A [refit](Self::refit) that makes it
    /// much larger is a reason to build anew.
    pub fn sah_cost(&self) -> f64 {
        sah_cost(&self.nodes, 0)
    }

    /// The bytes of memory that the hierarchy takes, with its [triangles](TriangleMesh::memory).
    pub fn memory(&self) -> usize {
        self.nodes.capacity() * size_of::<WideNode>() + size_of::<Vec<WideNode>>() + self.mesh.memory()
    }

    /// The triangles, without the hierarchy.
    pub(crate) fn into_mesh(self) -> TriangleMesh {
        let slots: Vec<u32> = self.mesh.slots().collect();
        self.mesh
            .indexed(slots.chunks(LANES).map(|chunk| chunk.iter().copied()))
    }

    pub(super) fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }
}

/// A leaf in 31 bits: the group, and how many of its lanes come after the first. While it is being built, its first place
/// in the order of the leaves in place of the group.
pub(super) fn pack_leaf(first: u32, count: u32) -> u32 {
    debug_assert!((1..=LEAF_SIZE as u32).contains(&count) && first < 1 << 28);
    first << 3 | (count - 1)
}

/// The places of a leaf that is being built, in the order of the leaves.
fn unpack_range(leaf: u32) -> Range<usize> {
    let first = group_of(leaf);
    first..first + (leaf & 7) as usize + 1
}

/// The slots of a leaf.
pub(super) fn unpack_slots(leaf: u32) -> Range<u32> {
    let first = group_of(leaf) as u32 * LANES as u32;
    first..first + (leaf & 7) + 1
}

/// The group of a leaf.
#[inline(always)]
fn group_of(leaf: u32) -> usize {
    (leaf >> 3) as usize
}

/// The lanes of its group that a leaf has.
#[inline(always)]
fn lanes_of(leaf: u32) -> u32 {
    (2 << (leaf & 7)) - 1
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

    /// Visits every triangle, in O(n).
    fn visit_hulls(&self, visit: &mut dyn FnMut(&dyn Support) -> ControlFlow<()>) -> ControlFlow<()> {
        (self.mesh.corners_of_all()).try_for_each(|[a, b, c]| visit(&Triangle3d::new(a, b, c)))
    }
}
