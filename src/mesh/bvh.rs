//! A bounding volume hierarchy over the triangles of one mesh.

use std::ops::Range;

use bevy::math::{Vec3A, bounding::Aabb3d};
use smallvec::SmallVec;

use super::triangles::{TriangleHit, TriangleMesh, nearer};
use crate::{
    geometry::{
        aabb::Aabb3dExt,
        ray::{
            Ray,
            triangle::{Backfaces, TriangleRay},
        },
        tolerance,
    },
    spatial::{
        RayVisit,
        binned_sah::{self, BuildItem},
    },
};

/// The most triangles that a leaf holds.
const LEAF_SIZE: usize = 4;

/// A static hierarchy over the triangles of one mesh, for all its instances.
///
/// Gives the same answers as the [`TriangleMesh`] that it was built from, hit for hit, and in O(log n) instead of O(n).
#[derive(Clone, Debug)]
pub struct MeshBvh {
    /// Parents before children; the first child of an inner node follows it at once.
    nodes: Vec<Node>,
    /// Its slots are in the order of the leaves.
    mesh: TriangleMesh,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    aabb: Aabb3d,
    kind: NodeKind,
}

#[derive(Clone, Copy, Debug)]
enum NodeKind {
    Inner { second: u32 },
    Leaf { first_slot: u32, count: u32 },
}

impl MeshBvh {
    /// Builds the hierarchy top down by the binned surface area heuristic, in O(n log n).
    pub fn build(mesh: &TriangleMesh) -> Self {
        let mut items: Vec<BuildItem> = (0..mesh.len() as u32)
            .map(|index| BuildItem {
                aabb: triangle_box(mesh.corners(index)),
                index,
            })
            .collect();

        let mut nodes: Vec<Node> = Vec::with_capacity(2 * items.len().div_ceil(LEAF_SIZE));
        let mut ranges: Vec<(Range<usize>, Option<u32>)> = vec![(0..items.len(), None)];
        while let Some((range, second_child_of)) = ranges.pop() {
            let items = &mut items[range.clone()];
            let node = nodes.len() as u32;
            let aabb = binned_sah::bounds(items);
            let kind = if items.len() <= LEAF_SIZE {
                NodeKind::Leaf {
                    first_slot: range.start as u32,
                    count: range.len() as u32,
                }
            } else {
                let middle = range.start + binned_sah::partition(items);
                ranges.push((middle..range.end, Some(node)));
                ranges.push((range.start..middle, None));
                NodeKind::Inner { second: 0 }
            };
            nodes.push(Node { aabb, kind });
            if let Some(parent) = second_child_of {
                nodes[parent as usize].kind = NodeKind::Inner { second: node };
            }
        }
        Self {
            nodes,
            mesh: mesh.reordered(items.iter().map(|item| item.index)),
        }
    }

    /// The triangles; hits of this hierarchy are looked up there.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The nearest hit. Of triangles at one parameter the one with the smallest number wins.
    pub fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<TriangleHit> {
        let triangle_ray = TriangleRay::new(ray);
        let mut closest: Option<TriangleHit> = None;
        self.visit_leaves(ray, |slots| {
            for slot in slots {
                let t_max = closest.map_or(ray.t_max(), |hit| hit.t);
                let corners = self.mesh.corners(slot);
                if let Some(hit) = triangle_ray.triangle_intersection(corners, t_max, backfaces) {
                    closest = nearer(closest, self.mesh.hit(slot, hit));
                }
            }
            closest.map_or(RayVisit::Continue, |hit| RayVisit::Shorten(hit.t))
        });
        closest
    }

    /// Whether there is any hit: stops at the first.
    pub fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        let triangle_ray = TriangleRay::new(ray);
        let mut found = false;
        self.visit_leaves(ray, |mut slots| {
            found = slots.any(|slot| {
                let corners = self.mesh.corners(slot);
                let hit = triangle_ray.triangle_intersection(corners, ray.t_max(), backfaces);
                hit.is_some()
            });
            if found { RayVisit::Stop } else { RayVisit::Continue }
        });
        found
    }

    /// Visits the slots of every leaf along the ray, near ones first.
    fn visit_leaves(&self, ray: &Ray, mut visit: impl FnMut(Range<u32>) -> RayVisit) {
        let mut rest = *ray;
        let mut stack: SmallVec<[(u32, f32); 64]> = SmallVec::new();
        stack.extend(self.entered(&rest, 0).map(|enter| (0, enter)));
        while let Some((node, enter)) = stack.pop() {
            if enter > rest.t_max() {
                continue;
            }
            match self.nodes[node as usize].kind {
                NodeKind::Inner { second } => {
                    let first = node + 1;
                    match (self.entered(&rest, first), self.entered(&rest, second)) {
                        (Some(a), Some(b)) if a <= b => stack.extend([(second, b), (first, a)]),
                        (Some(a), Some(b)) => stack.extend([(first, a), (second, b)]),
                        (Some(a), None) => stack.push((first, a)),
                        (None, Some(b)) => stack.push((second, b)),
                        (None, None) => {}
                    }
                }
                NodeKind::Leaf { first_slot, count } => match visit(first_slot..first_slot + count) {
                    RayVisit::Continue => {}
                    RayVisit::Shorten(t) => rest = rest.with_t_max(t.min(rest.t_max())),
                    RayVisit::Stop => return,
                },
            }
        }
    }

    fn entered(&self, ray: &Ray, node: u32) -> Option<f32> {
        ray.aabb_intersection_at(&self.nodes[node as usize].aabb)
    }
}

/// The box of a triangle, with the slack that its ray test needs: see [`tolerance::TRIANGLE_BOX`].
fn triangle_box(corners: [Vec3A; 3]) -> Aabb3d {
    let tight = Aabb3d::enclosing(corners).expect("three corners that are not NaN");
    let slack = Vec3A::splat((tight.max - tight.min).max_element() * tolerance::TRIANGLE_BOX);
    Aabb3d {
        min: tight.min - slack,
        max: tight.max + slack,
    }
}
