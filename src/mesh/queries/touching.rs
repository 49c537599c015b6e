//! The triangles that touch a region.

use std::{borrow::Cow, ops::ControlFlow};

use bevy::math::{
    Vec3,
    bounding::{Aabb3d, BoundingSphere},
    primitives::Triangle3d,
};

use crate::{
    geometry::{
        convex_hull::ConvexHull,
        intersection::{Frustum, Intersects},
        obb::Obb,
        tolerance,
    },
    mesh::{MeshBvh, TriangleMesh, bvh::unpack_slots},
    spatial::{
        region::{Outline, OutlineKind, Outlined},
        traverse::{Found, visit_leaves, visit_outline},
        wide::EVERY_MASK,
    },
};

/// A region that triangles are held against: [`Aabb3d`], [`BoundingSphere`], [`Obb`], [`ConvexHull`] and [`Frustum`],
/// which is prepared from a [`ViewFrustum`](bevy::math::primitives::ViewFrustum).
pub trait TriangleRegion: Outlined + Intersects<Triangle3d> {}

impl TriangleRegion for Aabb3d {}
impl TriangleRegion for BoundingSphere {}
impl TriangleRegion for Obb {}
impl TriangleRegion for ConvexHull {}
impl TriangleRegion for Frustum {}

impl MeshBvh {
    /// Visits the numbers of the triangles that touch the region, each once, in no promised order.
    ///
    /// The surface is asked, not a solid: a region wholly inside of a closed mesh touches nothing. As exactly as
    /// [`Intersects`] tells: never without a triangle that touches. What is wholly inside of the region is not tested
    /// triangle by triangle.
    pub fn visit_touching(&self, region: &impl TriangleRegion, mut visit: impl FnMut(u32) -> ControlFlow<()>) {
        let outline = region.outline();
        let test = Test::new(region, &outline);
        let mesh = self.mesh();
        let one_by_one = |leaf: u32, visit: &mut _| {
            unpack_slots(leaf).try_for_each(|slot| test.visit_if_touching(mesh, slot, visit))
        };
        let every_box = |_: &Aabb3d| true;
        visit_outline(
            self.nodes(),
            0,
            EVERY_MASK,
            &test.around,
            every_box,
            |found| match found {
                Found::Leaf(leaf) => one_by_one(leaf, &mut visit),
                Found::Whole(node) if test.is_inside(&self.nodes()[node as usize].bounds()) => {
                    visit_leaves(self.nodes(), node, EVERY_MASK, |leaf| {
                        unpack_slots(leaf).try_for_each(|slot| visit(mesh.number(slot)))
                    })
                }
                Found::Whole(node) => visit_leaves(self.nodes(), node, EVERY_MASK, |leaf| one_by_one(leaf, &mut visit)),
            },
        );
    }

    /// The numbers of the triangles that touch the region, written over `found`, in no promised order.
    pub fn find_touching(&self, region: &impl TriangleRegion, found: &mut Vec<u32>) {
        found.clear();
        self.visit_touching(region, |triangle| {
            found.push(triangle);
            ControlFlow::Continue(())
        });
    }

    /// Whether any triangle touches the region: stops at the first.
    pub fn touches(&self, region: &impl TriangleRegion) -> bool {
        let mut found = false;
        self.visit_touching(region, |_| {
            found = true;
            ControlFlow::Break(())
        });
        found
    }
}

impl TriangleMesh {
    /// As [`MeshBvh::visit_touching`].
    pub fn visit_touching(&self, region: &impl TriangleRegion, mut visit: impl FnMut(u32) -> ControlFlow<()>) {
        let outline = region.outline();
        let test = Test::new(region, &outline);
        let _ = self
            .slots()
            .try_for_each(|slot| test.visit_if_touching(self, slot, &mut visit));
    }
}

/// The test of one triangle.
struct Test<'a, R> {
    region: &'a R,
    outline: &'a Outline,
    /// What touches the region, by no matter how little, touches this.
    around: Cow<'a, Outline>,
}

impl<'a, R: TriangleRegion> Test<'a, R> {
    fn new(region: &'a R, outline: &'a Outline) -> Self {
        let around = match &outline.0 {
            OutlineKind::Sphere(sphere) => Cow::Owned(Outline(OutlineKind::Sphere(with_rounding(sphere)))),
            // These bound what touches, rounding included.
            _ => Cow::Borrowed(outline),
        };
        Self {
            region,
            outline,
            around,
        }
    }

    /// True only if everything in the box is inside of the region.
    fn is_inside(&self, aabb: &Aabb3d) -> bool {
        let is_certain = match &self.outline.0 {
            // Among squares that underflow or overflow all are alike.
            OutlineKind::Sphere(sphere) => sphere.radius().powi(2).is_normal(),
            _ => true,
        };
        is_certain && self.outline.contains(aabb)
    }

    fn visit_if_touching(
        &self,
        mesh: &TriangleMesh,
        slot: u32,
        visit: &mut impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let aabb = mesh.triangle_box(slot);
        let touches = self.around.may_touch(&aabb)
            && (self.is_inside(&aabb) || {
                let [a, b, c] = mesh.corners(slot).map(Vec3::from);
                self.region.intersects(&Triangle3d::new(a, b, c))
            });
        if touches {
            visit(mesh.number(slot))
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// A sphere that a box touches, as `f32` has it, if anything inside of the box touches the given one, be it by rounding.
fn with_rounding(sphere: &BoundingSphere) -> BoundingSphere {
    let largest = sphere.radius().max(sphere.center.abs().max_element());
    let rounding = largest * tolerance::REGION_PLANE + tolerance::SQUARE_UNDERFLOW;
    BoundingSphere::new(sphere.center, sphere.radius() + rounding)
}
