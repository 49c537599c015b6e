//! Convex hulls of points.

mod budget;
mod distance;
mod facets;
mod flat;
mod planes;
mod polytope;
mod predicates;
mod quickhull;
mod simplex;

use bevy::math::{Affine3A, DVec3, Vec3A, bounding::Aabb3d};

pub(crate) use planes::{LANES, PlaneLanes};
pub use polytope::HullRank;

use self::{
    planes::{Bounded, Planes},
    polytope::{Faces, Polytope},
    quickhull::convex_hull,
};
use super::{
    ray::Ray,
    rounding, tolerance,
    volume::{UnboundablePoints, Volume, finite},
};

/// The convex hull of some points: a polyhedron, or, if the points span no volume, a flat polygon, a segment or a point.
///
/// Built from points, it is exact: its corners are the extreme points, its faces as large as they are planar, both
/// decided in exact arithmetic, whatever the scale and however thin the hull. Two points that differ only in the sign of
/// a zero are one. A hull of n points takes O(n log n) time in practice.
///
/// What [`transformed_by_affine`](Volume::transformed_by_affine), [`merged`](Volume::merged) and
/// [`with_vertex_budget`](ConvexHull::with_vertex_budget) round is kept as a [margin](ConvexHull::margin): the hull is
/// all that lies within it of what the corners span.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexHull {
    rank: HullRank,
    vertices: Vec<Vec3A>,
    edges: Vec<[u32; 2]>,
    faces: Faces,
    planes: Vec<HullPlane>,
    plane_of_face: Vec<u32>,
    lanes: Vec<PlaneLanes>,
    margin: f64,
}

/// A plane that bounds a hull: the points with `normal · point <= offset` are on its inner side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullPlane {
    /// The unit normal, pointing out of the hull.
    pub normal: Vec3A,
    /// The largest distance along the normal that belongs to the hull, rounded outward: in `f64`, the inequality holds
    /// for every point of the hull. In `f32`, allow for the rounding of the product.
    pub offset: f32,
}

/// A face of a hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullFace<'a> {
    /// The plane that bounds the hull there. Faces that differ from one plane by less than the rounding share it.
    pub plane: HullPlane,
    /// Its corners, counter-clockwise seen from outside, by the indices of the [vertices](ConvexHull::vertices).
    pub vertices: &'a [u32],
}

impl ConvexHull {
    /// What the corners span.
    pub fn rank(&self) -> HullRank {
        self.rank
    }

    /// The corners.
    pub fn vertices(&self) -> &[Vec3A] {
        &self.vertices
    }

    /// The planes whose inner sides the hull is in: their intersection is the hull, up to rounding, outward. Those of
    /// the faces come first; then bevels, where faces meet so sharply that their planes, rounded, would meet far outside.
    /// A flat hull has planes on both sides, and bevels through its edges; a segment and a point are boxed in likewise.
    pub fn planes(&self) -> &[HullPlane] {
        &self.planes
    }

    /// The edges, each once, by the indices of its vertices.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// The faces. A flat polygon has two, one on each side; a segment and a point have none.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = HullFace<'_>> {
        (0..self.faces.len()).map(|face| HullFace {
            plane: self.planes[self.plane_of_face[face] as usize],
            vertices: self.faces.corners(face),
        })
    }

    /// How far the hull reaches beyond what its corners span, in the units of its space: zero as long as it is built
    /// from points, and afterwards the rounding that has added up, some units in the last place of the coordinates, and
    /// what it was [grown](Volume::grown) by.
    pub fn margin(&self) -> f32 {
        rounding::up(self.margin)
    }

    pub(crate) fn lanes(&self) -> &[PlaneLanes] {
        &self.lanes
    }

    /// The hull of all that lies within `margin` of what `points` span, of which there must be at least one; of
    /// everything if they lie too far out.
    fn spanned(points: &[Vec3A], margin: f64) -> Self {
        if !points.iter().copied().all(is_in_range) {
            return Self::of_everything();
        }
        let exact: Vec<DVec3> = points.iter().copied().map(Vec3A::as_dvec3).collect();
        let Polytope { rank, corners, faces } = convex_hull(&exact);
        let exact: Vec<DVec3> = corners.iter().map(|&corner| exact[corner as usize]).collect();
        let bounded = Bounded::new(&exact, margin);
        let Planes { planes, of_face } = match rank {
            HullRank::Point => bounded.around_point(),
            HullRank::Segment => bounded.around_segment(),
            HullRank::Polygon | HullRank::Solid => bounded.around_faces(&faces),
        };
        let edges = match rank {
            HullRank::Segment => vec![[0, 1]],
            _ => (0..faces.len())
                .flat_map(|face| faces.edges(face).filter(move |&(_, across)| face < across))
                .map(|(edge, _)| edge)
                .collect(),
        };
        Self {
            rank,
            // A negative zero plus zero is zero.
            vertices: corners
                .iter()
                .map(|&corner| points[corner as usize] + Vec3A::ZERO)
                .collect(),
            edges,
            faces,
            lanes: PlaneLanes::pack(&planes),
            planes,
            plane_of_face: of_face,
            margin,
        }
    }

    /// A hull that contains all finite points: what overflows ends up here.
    fn of_everything() -> Self {
        Self::spanned(&[-Vec3A::ONE, Vec3A::ONE], f64::INFINITY)
    }

    /// How far a point may be from what the corners span and still be [contained](Volume::contains_point): the margin,
    /// and the rounding of the distance.
    fn reach(&self) -> f64 {
        self.margin + 0.25 * tolerance::DOUBLE * self.magnitude().element_sum()
    }

    /// The largest coordinate of a corner on each axis.
    pub(crate) fn magnitude(&self) -> DVec3 {
        let largest = (self.vertices.iter()).fold(Vec3A::ZERO, |largest, vertex| largest.max(vertex.abs()));
        largest.as_dvec3()
    }

    /// The triangles of the faces.
    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let corner = |index: u32| self.vertices[index as usize].as_dvec3();
        (0..self.faces.len()).flat_map(move |face| {
            let corners = self.faces.corners(face);
            (corners[1..].windows(2)).map(move |pair| [corners[0], pair[0], pair[1]].map(corner))
        })
    }
}

/// Whether the ray test cannot overflow on a hull with this corner.
fn is_in_range(point: Vec3A) -> bool {
    point.abs().cmple(Vec3A::splat(f32::MAX / 8.0)).all()
}

impl Volume for ConvexHull {
    /// The hull of the points, exactly.
    ///
    /// # Errors
    ///
    /// As [`Volume::enclosing`] says. The hull overflows if a coordinate is larger than an eighth of [`f32::MAX`].
    fn enclosing(points: impl IntoIterator<Item = Vec3A>) -> Result<Self, UnboundablePoints> {
        let points = finite(points)?;
        if !points.iter().copied().all(is_in_range) {
            return Err(UnboundablePoints::Overflow);
        }
        Ok(Self::spanned(&points, 0.0))
    }

    /// The hull of the corners of both, exactly, with the larger margin of the two.
    fn merged(&self, other: &Self) -> Self {
        let vertices: Vec<Vec3A> = self.vertices.iter().chain(&other.vertices).copied().collect();
        Self::spanned(&vertices, self.reach().max(other.reach()))
    }

    /// The hull of the images of the corners, exactly, so that mirrored, sheared and flattened hulls have the faces, the
    /// winding and the rank that they should. Its margin allows for the rounding of the images.
    ///
    /// What overflows contains all finite points, and has an infinite margin.
    fn transformed_by_affine(&self, transform: &Affine3A) -> Self {
        let matrix = transform.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec3A::as_dvec3);
        // The largest stretch squared is at most the largest row sum of the products of the columns.
        let row = |a: DVec3| a.dot(x).abs() + a.dot(y).abs() + a.dot(z).abs();
        let stretch = row(x).max(row(y)).max(row(z)).sqrt();

        let reach = self.reach();
        let largest = self.magnitude() + reach;
        let added_up =
            x.abs() * largest.x + y.abs() * largest.y + z.abs() * largest.z + transform.translation.as_dvec3().abs();
        let rounding = tolerance::TRANSFORMED_POINT * added_up.length() + f64::from(tolerance::UNDERFLOW);
        let margin = stretch * reach + 2.0 * rounding;

        let vertices: Vec<Vec3A> = self
            .vertices
            .iter()
            .map(|&vertex| transform.transform_point3a(vertex))
            .collect();
        if margin.is_nan() {
            return Self::of_everything();
        }
        Self::spanned(&vertices, margin)
    }

    /// The same corners with a larger margin.
    fn grown(&self, amount: f32) -> Self {
        Self::spanned(&self.vertices, self.reach() + f64::from(amount))
    }

    /// Whether the point lies within the [margin](ConvexHull::margin) of what the corners span, up to the rounding of
    /// `f64`, and exactly inside where the hull is a solid without a margin. Tighter than the planes, at the same cost
    /// for points outside of these.
    fn contains_point(&self, point: Vec3A) -> bool {
        let point = point.as_dvec3();
        let inside = |plane: &HullPlane| plane.normal.as_dvec3().dot(point) <= f64::from(plane.offset);
        point.is_finite() && self.planes.iter().all(inside) && self.distance_from_corners(point) <= self.reach()
    }

    /// See [`Ray::convex_hull_intersection_at`].
    fn ray_intersection_at(&self, ray: &Ray) -> Option<f32> {
        ray.convex_hull_intersection_at(self)
    }

    /// The box around the corners and the margin: infinite if that is.
    fn aabb(&self) -> Aabb3d {
        let (min, max) = (self.vertices.iter()).fold((Vec3A::MAX, Vec3A::MIN), |(min, max), &vertex| {
            (min.min(vertex), max.max(vertex))
        });
        let outward = |bound: f32| rounding::up(f64::from(bound) + self.margin);
        Aabb3d {
            min: -Vec3A::from_array((-min).to_array().map(outward)),
            max: Vec3A::from_array(max.to_array().map(outward)),
        }
    }

    /// The volume of what the corners span, without the margin unless that is infinite.
    fn volume(&self) -> f32 {
        if self.margin == f64::INFINITY {
            return f32::INFINITY;
        }
        if self.rank < HullRank::Solid {
            return 0.0;
        }
        let apex = self.vertices[0].as_dvec3();
        let six_fold: f64 = self
            .triangles()
            .map(|[a, b, c]| (a - apex).dot((b - apex).cross(c - apex)))
            .sum();
        (six_fold / 6.0) as f32
    }

    /// The surface area of what the corners span, without the margin unless that is infinite.
    fn surface_area(&self) -> f32 {
        if self.margin == f64::INFINITY {
            return f32::INFINITY;
        }
        let two_fold: f64 = self.triangles().map(|[a, b, c]| (b - a).cross(c - a).length()).sum();
        (two_fold / 2.0) as f32
    }
}
