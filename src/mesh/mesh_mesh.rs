//! Mesh against mesh: the simultaneous descent of two hierarchies.
//!
//! Source: Ericson, *Real-Time Collision Detection*, 2005, §6.3; Gottschalk, Lin and Manocha, *OBBTree*, 1996, for the
//! descent in the space of one of the two.

use std::{
    borrow::Cow,
    ops::{ControlFlow, Range},
};

use bevy::math::{Affine3A, DAffine3, DVec3, Vec3A, bounding::Aabb3d};
use smallvec::{SmallVec, smallvec};

use super::{
    MeshBvh, TriangleMesh,
    bvh::{LEAF_SIZE, unpack_slots},
};
use crate::{
    geometry::{
        tolerance,
        triangle_triangle::{self, TriangleContact},
        volume::Volume,
    },
    spatial::wide::{Child, EVERY_MASK, WideNode},
};

/// The triangles of a mesh somewhere in the world.
#[derive(Clone, Copy, Debug)]
pub struct PlacedMesh<'a> {
    triangles: &'a TriangleMesh,
    /// Empty if there is no hierarchy.
    nodes: &'a [WideNode],
    world_from_local: Affine3A,
}

impl<'a> PlacedMesh<'a> {
    /// The mesh of a hierarchy, placed by `world_from_local`, which may shear, mirror and flatten it.
    pub fn new(bvh: &'a MeshBvh, world_from_local: Affine3A) -> Self {
        Self {
            triangles: bvh.mesh(),
            nodes: bvh.nodes(),
            world_from_local,
        }
    }

    /// The same without a hierarchy: every triangle is looked at.
    pub fn without_hierarchy(triangles: &'a TriangleMesh, world_from_local: Affine3A) -> Self {
        Self {
            triangles,
            nodes: &[],
            world_from_local,
        }
    }

    /// A box around the mesh in the world.
    fn world_box(&self) -> Aabb3d {
        self.triangles.aabb().transformed_by_affine(&self.world_from_local)
    }

    /// Whether any triangle of this mesh touches a triangle of the other.
    ///
    /// Surfaces are asked, not solids: a mesh wholly inside another does not touch it. Decided exactly for the triangles
    /// as [`visit_touching`](Self::visit_touching) places them.
    pub fn intersects(&self, other: &PlacedMesh) -> bool {
        let mut found = false;
        self.visit_touching(other, |_| {
            found = true;
            ControlFlow::Break(())
        });
        found
    }

    /// Visits every pair of a triangle of this mesh and a triangle of the other that touch, in no promised order.
    ///
    /// The triangles are compared in the local space of this mesh, those of the other taken there in double precision,
    /// or, if the transform of this mesh is flat, in the world. There the answer is
    /// [exact](triangle_triangle), and a vertex that several triangles share is one point for all of them.
    pub fn visit_touching(&self, other: &PlacedMesh, mut visit: impl FnMut(&TrianglePair) -> ControlFlow<()>) {
        if !touch(&self.world_box(), &other.world_box()) {
            return;
        }
        let descent = Descent::new(self, other);
        for a in descent.a.parts() {
            for b in descent.b.parts() {
                if descent.descend(a, b, &mut visit).is_break() {
                    return;
                }
            }
        }
    }
}

/// Two triangles that touch, one of each mesh.
#[derive(Clone, Copy, Debug)]
pub struct TrianglePair {
    /// Their numbers in their meshes, as in [`TriangleHit::triangle`](super::TriangleHit).
    pub triangles: [u32; 2],
    /// In the space of the descent.
    corners: [[DVec3; 3]; 2],
    world_from_descent: DAffine3,
}

impl TrianglePair {
    /// Where the two touch, in world space.
    pub fn contact(&self) -> TriangleContact {
        let [a, b] = self.corners;
        let contact = triangle_triangle::contact(a, b).expect("a pair of triangles that touch");
        contact.map(|point| self.world_from_descent.transform_point3(point))
    }
}

/// Both meshes in the space of the descent.
struct Descent<'a> {
    a: Side<'a>,
    b: Side<'a>,
    world_from_descent: DAffine3,
}

/// One of the two meshes.
struct Side<'a> {
    triangles: &'a TriangleMesh,
    nodes: &'a [WideNode],
    /// From the space of the mesh to that of the descent, unless the two are one.
    placement: Option<Placement>,
}

struct Placement {
    exact: DAffine3,
    of_boxes: Affine3A,
    /// How far `of_boxes` may take a point of the mesh from where `exact` takes it.
    rounding: Vec3A,
}

/// What a step of the descent compares: with its box, in the space of the descent.
#[derive(Clone, Copy)]
struct Part {
    aabb: Aabb3d,
    content: Content,
}

#[derive(Clone, Copy)]
enum Content {
    Node(u32),
    Triangles { first: u32, end: u32 },
}

impl Placement {
    fn new(exact: DAffine3, triangles: &TriangleMesh) -> Self {
        let of_boxes = exact.as_affine3a();
        let Aabb3d { min, max } = triangles.aabb();
        let reach = min.abs().max(max.abs());
        let matrix = of_boxes.matrix3;
        let magnitude = matrix.x_axis.abs() * reach.x
            + matrix.y_axis.abs() * reach.y
            + matrix.z_axis.abs() * reach.z
            + of_boxes.translation.abs();
        Self {
            exact,
            of_boxes,
            rounding: magnitude * tolerance::BOX_TRANSFORM + tolerance::UNDERFLOW,
        }
    }
}

impl<'a> Descent<'a> {
    fn new(a: &PlacedMesh<'a>, b: &PlacedMesh<'a>) -> Self {
        let [world_from_a, world_from_b] = [a, b].map(|mesh| mesh.world_from_local.as_daffine3());
        let a_from_world = world_from_a.inverse();
        let a_from_b = a_from_world * world_from_b;
        let side = |mesh: &PlacedMesh<'a>, placement| Side {
            triangles: mesh.triangles,
            nodes: mesh.nodes,
            placement,
        };
        // The boxes are placed in single precision, and must not overflow there.
        if a_from_b.as_affine3a().is_finite() {
            Self {
                a: side(a, None),
                b: side(b, Some(Placement::new(a_from_b, b.triangles))),
                world_from_descent: world_from_a,
            }
        } else {
            Self {
                a: side(a, Some(Placement::new(world_from_a, a.triangles))),
                b: side(b, Some(Placement::new(world_from_b, b.triangles))),
                world_from_descent: DAffine3::IDENTITY,
            }
        }
    }

    /// Visits the touching pairs of triangles below two parts.
    fn descend(&self, a: Part, b: Part, visit: &mut impl FnMut(&TrianglePair) -> ControlFlow<()>) -> ControlFlow<()> {
        if !touch(&a.aabb, &b.aabb) {
            return ControlFlow::Continue(());
        }
        let mut stack: SmallVec<[(Part, Part); 64]> = smallvec![(a, b)];
        while let Some((a, b)) = stack.pop() {
            match (a.content, b.content) {
                (Content::Node(node_a), Content::Node(node_b)) => {
                    let node_a = self.a.node(node_a);
                    for b in Part::of_lanes(&self.b.node(node_b)) {
                        stack.extend(Part::of_touching_lanes(&node_a, &b.aabb).map(|a| (a, b)));
                    }
                }
                (Content::Node(node), Content::Triangles { .. }) => {
                    stack.extend(Part::of_touching_lanes(&self.a.node(node), &b.aabb).map(|a| (a, b)));
                }
                (Content::Triangles { .. }, Content::Node(node)) => {
                    stack.extend(Part::of_touching_lanes(&self.b.node(node), &a.aabb).map(|b| (a, b)));
                }
                (
                    Content::Triangles { first, end },
                    Content::Triangles {
                        first: first_b,
                        end: end_b,
                    },
                ) => {
                    let of_b: SmallVec<[_; LEAF_SIZE]> = self.b.triangles_touching(first_b..end_b, &a.aabb).collect();
                    if of_b.is_empty() {
                        continue;
                    }
                    for (slot_a, box_a) in self.a.triangles_touching(first..end, &b.aabb) {
                        let touching_a = of_b.iter().filter(|(_, box_b)| touch(&box_a, box_b));
                        for &(slot_b, _) in touching_a {
                            let corners = [self.a.corners(slot_a), self.b.corners(slot_b)];
                            if triangle_triangle::intersect_by_intervals(corners[0], corners[1]) {
                                visit(&TrianglePair {
                                    triangles: [self.a.triangles.number(slot_a), self.b.triangles.number(slot_b)],
                                    corners,
                                    world_from_descent: self.world_from_descent,
                                })?;
                            }
                        }
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}

impl Side<'_> {
    /// Where the descent begins: the root, or without a hierarchy each triangle.
    fn parts(&self) -> impl Iterator<Item = Part> + '_ {
        let root = (!self.nodes.is_empty()).then(|| Part {
            aabb: self.place(&self.triangles.aabb()),
            content: Content::Node(0),
        });
        let flat = root.is_none().then(|| self.triangles.slots());
        let triangles = flat.into_iter().flatten().map(|slot| Part {
            aabb: self.place(&self.triangles.triangle_box(slot)),
            content: Content::Triangles {
                first: slot,
                end: slot + 1,
            },
        });
        root.into_iter().chain(triangles)
    }

    /// A node with its boxes in the space of the descent.
    fn node(&self, index: u32) -> Cow<'_, WideNode> {
        let node = &self.nodes[index as usize];
        if self.placement.is_none() {
            return Cow::Borrowed(node);
        }
        let mut placed = WideNode::EMPTY;
        for (aabb, child) in node.lanes() {
            placed.push(&self.place(&aabb), EVERY_MASK, child);
        }
        Cow::Owned(placed)
    }

    fn place(&self, aabb: &Aabb3d) -> Aabb3d {
        match &self.placement {
            None => *aabb,
            Some(placement) => aabb.transformed_by_affine(&placement.of_boxes),
        }
    }

    /// The slots and the boxes, in the space of the descent, of those triangles whose boxes touch `aabb`.
    fn triangles_touching<'b>(
        &'b self,
        slots: Range<u32>,
        aabb: &'b Aabb3d,
    ) -> impl Iterator<Item = (u32, Aabb3d)> + 'b {
        let boxes = slots.map(|slot| (slot, self.triangle_box(slot)));
        boxes.filter(|(_, triangle)| touch(triangle, aabb))
    }

    /// The box of a triangle in the space of the descent.
    #[inline]
    fn triangle_box(&self, slot: u32) -> Aabb3d {
        let corners = self.triangles.corners(slot);
        let around = |[a, b, c]: [Vec3A; 3], slack| Aabb3d {
            min: a.min(b).min(c) - slack,
            max: a.max(b).max(c) + slack,
        };
        match &self.placement {
            None => around(corners, Vec3A::ZERO),
            Some(Placement { of_boxes, rounding, .. }) => {
                around(corners.map(|corner| of_boxes.transform_point3a(corner)), *rounding)
            }
        }
    }

    /// The corners of a triangle in the space of the descent.
    #[inline]
    fn corners(&self, slot: u32) -> [DVec3; 3] {
        let corners = self.triangles.corners(slot).map(Vec3A::as_dvec3);
        match &self.placement {
            None => corners,
            Some(placement) => corners.map(|corner| placement.exact.transform_point3(corner)),
        }
    }
}

/// Whether nothing tells that two boxes are apart: a bound that overflowed may be NaN.
#[inline]
fn touch(a: &Aabb3d, b: &Aabb3d) -> bool {
    let apart = a.min.cmpgt(b.max) | b.min.cmpgt(a.max);
    !apart.any()
}

impl Part {
    fn of_lanes(node: &WideNode) -> impl Iterator<Item = Part> + '_ {
        node.lanes().map(|(aabb, child)| Part::new(aabb, child))
    }

    fn of_touching_lanes(node: &WideNode, aabb: &Aabb3d) -> impl Iterator<Item = Part> {
        node.touching(aabb)
            .map(|lane| Part::new(node.aabb(lane), node.child(lane)))
    }

    fn new(aabb: Aabb3d, child: Child) -> Self {
        let content = match child {
            Child::Node(node) => Content::Node(node),
            Child::Leaf(leaf) => {
                let slots = unpack_slots(leaf);
                Content::Triangles {
                    first: slots.start,
                    end: slots.end,
                }
            }
        };
        Self { aabb, content }
    }
}
