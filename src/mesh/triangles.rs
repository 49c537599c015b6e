//! The triangles of a mesh, whichever way the mesh stores them.

mod edit;

use std::{
    ops::{Add, Mul},
    sync::OnceLock,
};

use bevy::{
    math::{Vec2, Vec3, Vec3A, bounding::Aabb3d},
    mesh::{Indices, Mesh, MeshAccessError, PrimitiveTopology, VertexAttributeValues, VertexFormat},
};

use crate::geometry::{
    convex_hull::ConvexHull,
    ray::{
        Ray,
        triangle::{Backfaces, TriangleIntersection, TriangleRay},
    },
    tolerance,
    volume::{AnyVolume, BoundingKind, UnboundablePoints, Volume},
};

pub(crate) use edit::MeshEdit;

/// The most corners that the hull of a mesh has as a [`bounding_volume`](TriangleMesh::bounding_volume).
pub const HULL_CORNERS: usize = 24;

/// A hit on one triangle of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// The parameter of the ray.
    pub t: f32,
    /// The number of the triangle in the mesh: in a list `index / 3` of its first index, in a strip that of its first
    /// index.
    pub triangle: u32,
    /// The weights of the three vertices.
    pub barycentrics: Vec3,
    /// Where a [`TriangleMesh`] keeps the triangle, which need not be in the order of the mesh.
    pub(super) slot: u32,
}

/// Why a mesh has no triangles to hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum UnusableMesh {
    /// Lines and points have no surface.
    #[error("its topology is {0:?}, which has no surface to hit")]
    Topology(PrimitiveTopology),
    /// The vertex data live on the GPU alone.
    #[error("its data were moved to the render world; create it with `RenderAssetUsages::MAIN_WORLD`")]
    NotInMainWorld,
    /// There is no position attribute.
    #[error("it has no vertex positions")]
    NoPositions,
    /// The positions are not three floats.
    #[error("its vertex positions are {0:?}, not Float32x3")]
    PositionFormat(VertexFormat),
    /// Every triangle, if there is any, has indices out of range or positions that are NaN or infinite.
    #[error("it has no triangle with finite positions and indices in range")]
    NoTriangles,
}

/// The triangles of a mesh with what a hit reports of them: a copy of the data of the mesh.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    vertices: Vec<Vertex>,
    has_uvs: bool,
    triangles: Vec<Triangle>,
    /// The box around all triangles.
    aabb: Aabb3d,
    /// How many triangles were left out.
    left_out: usize,
    /// The slot of each triangle by its number, [`NO_SLOT`] of those that were left out; once it is asked for.
    slots: OnceLock<Vec<u32>>,
}

/// No triangle is in this slot.
const NO_SLOT: u32 = u32::MAX;

/// All of a triangle in one place: a test of it then loads one stretch of memory.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [Vec3; 3],
    /// The numbers of its vertices in the mesh.
    vertices: [u32; 3],
    /// Its number in the mesh.
    number: u32,
}

/// What a hit reports of a vertex.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    /// Zero if the mesh has no normals.
    normal: [f32; 3],
    uv: [f32; 2],
}

impl TriangleMesh {
    /// Copies the triangles of `mesh`: lists and strips, with 16-bit, 32-bit and no indices.
    ///
    /// Leaves out triangles with indices out of range and with positions that are NaN or infinite, and an incomplete
    /// triangle at the end of a list. In a strip, the largest index restarts.
    ///
    /// # Errors
    ///
    /// If nothing is left that could be hit.
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, UnusableMesh> {
        let topology = mesh.primitive_topology();
        if !matches!(
            topology,
            PrimitiveTopology::TriangleList | PrimitiveTopology::TriangleStrip
        ) {
            return Err(UnusableMesh::Topology(topology));
        }
        let values = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
            Ok(values) => values,
            Err(MeshAccessError::ExtractedToRenderWorld) => {
                return Err(UnusableMesh::NotInMainWorld);
            }
            Err(MeshAccessError::NotFound) => return Err(UnusableMesh::NoPositions),
        };
        let positions = values.as_float3().ok_or(UnusableMesh::PositionFormat(values.into()))?;

        let numbered: Vec<Numbered> = match (mesh.try_indices_option().ok().flatten(), topology) {
            (None, PrimitiveTopology::TriangleStrip) => strip(0..positions.len() as u32, None),
            (None, _) => list(0..positions.len() as u32),
            (Some(Indices::U16(indices)), PrimitiveTopology::TriangleStrip) => {
                strip(indices.iter().map(|&i| i.into()), Some(u16::MAX.into()))
            }
            (Some(Indices::U32(indices)), PrimitiveTopology::TriangleStrip) => {
                strip(indices.iter().copied(), Some(u32::MAX))
            }
            (Some(Indices::U16(indices)), _) => list(indices.iter().map(|&i| i.into())),
            (Some(Indices::U32(indices)), _) => list(indices.iter().copied()),
        };

        let all = numbered.len();
        let corner = |vertex: u32| {
            let position = positions.get(vertex as usize).copied().map(Vec3::from);
            position.filter(|position| position.is_finite())
        };
        let triangles: Vec<Triangle> = numbered
            .into_iter()
            .filter_map(|(number, vertices)| {
                let [a, b, c] = vertices.map(corner);
                Some(Triangle {
                    corners: [a?, b?, c?],
                    vertices,
                    number,
                })
            })
            .collect();
        let corners = triangles.iter().flat_map(|triangle| triangle.corners);
        let aabb = Aabb3d::enclosing(corners.map(Vec3A::from)).map_err(|_| UnusableMesh::NoTriangles)?;
        let normals = match mesh.try_attribute(Mesh::ATTRIBUTE_NORMAL) {
            Ok(VertexAttributeValues::Float32x3(normals)) if normals.len() == positions.len() => Some(normals),
            _ => None,
        };
        let uvs = match mesh.try_attribute(Mesh::ATTRIBUTE_UV_0) {
            Ok(VertexAttributeValues::Float32x2(uvs)) if uvs.len() == positions.len() => Some(uvs),
            _ => None,
        };
        Ok(Self {
            vertices: (0..positions.len())
                .map(|vertex| Vertex {
                    normal: normals.map_or([0.0; 3], |normals| normals[vertex]),
                    uv: uvs.map_or([0.0; 2], |uvs| uvs[vertex]),
                })
                .collect(),
            has_uvs: uvs.is_some(),
            aabb,
            left_out: all - triangles.len(),
            triangles,
            slots: OnceLock::new(),
        })
    }

    /// The number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are no triangles. Never true of a mesh from [`TriangleMesh::from_mesh`].
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// How many triangles of the mesh were left out because they cannot be hit.
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// The box around all triangles.
    pub fn aabb(&self) -> Aabb3d {
        self.aabb
    }

    /// The corners of all triangles that can be hit, in no promised order.
    pub fn corners_of_all(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> + '_ {
        self.triangles.iter().map(|triangle| triangle.corners)
    }

    /// A volume around all triangles.
    ///
    /// # Errors
    ///
    /// If the volume would overflow.
    pub fn enclosing_volume<V: Volume>(&self) -> Result<V, UnboundablePoints> {
        V::enclosing(self.corners_of_all().flatten().map(Vec3A::from))
    }

    /// A volume of some kind around everything that a ray can hit; `None` if it would overflow.
    ///
    /// A hull has up to [`HULL_CORNERS`] corners, and so may be larger than the convex hull: a test of a ray takes time
    /// for each of its faces, which soon is more than the triangles take.
    pub fn bounding_volume(&self, kind: BoundingKind) -> Option<AnyVolume> {
        let corners = self.corners_of_all().flatten().map(Vec3A::from);
        let tight = match kind {
            BoundingKind::Hull => ConvexHull::with_vertex_budget(corners, HULL_CORNERS).map(AnyVolume::Hull),
            _ => kind.enclosing(corners),
        };
        let size = self.aabb.max - self.aabb.min;
        Some(tight.ok()?.grown(size.max_element() * tolerance::TRIANGLE_BOX))
    }

    /// The nearest hit, found by a test of every triangle. Of triangles at one parameter the one with the smallest
    /// number wins.
    pub fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<TriangleHit> {
        self.closest_hit_of(ray, backfaces, |corner| corner)
    }

    /// The same with every corner moved by `place` first: for transforms without an inverse, under which the ray
    /// cannot be taken to the mesh.
    pub fn closest_hit_of(
        &self,
        ray: &Ray,
        backfaces: Backfaces,
        place: impl Fn(Vec3A) -> Vec3A,
    ) -> Option<TriangleHit> {
        let triangle_ray = TriangleRay::new(ray);
        let mut closest: Option<TriangleHit> = None;
        for slot in 0..self.len() as u32 {
            let t_max = closest.map_or(ray.t_max(), |hit| hit.t);
            let corners = self.corners(slot).map(&place);
            if let Some(hit) = triangle_ray.triangle_intersection(corners, t_max, backfaces) {
                closest = nearer(closest, self.hit(slot, hit));
            }
        }
        closest
    }

    /// The corners of the triangle that was hit.
    pub fn triangle(&self, hit: &TriangleHit) -> [Vec3; 3] {
        self.triangles[hit.slot as usize].corners
    }

    /// The normal at the hit: interpolated from the vertices, of any length; without vertex normals, that of the
    /// triangle.
    pub fn normal(&self, hit: &TriangleHit) -> Vec3 {
        let normal = interpolate(
            hit.barycentrics,
            self.vertices(hit).map(|vertex| Vec3::from(vertex.normal)),
        );
        if normal.is_finite() && normal != Vec3::ZERO {
            return normal;
        }
        self.geometric_normal(hit)
    }

    /// The normal of the triangle that was hit, of any length.
    pub fn geometric_normal(&self, hit: &TriangleHit) -> Vec3 {
        let [a, b, c] = self.triangle(hit);
        // Scaled first, so that the product of tiny sides does not underflow.
        let (ab, ac) = (b - a, c - a);
        let longest = ab.abs().max(ac.abs()).max_element();
        (ab / longest).cross(ac / longest)
    }

    /// The texture coordinates at the hit, if the mesh has any.
    pub fn uv(&self, hit: &TriangleHit) -> Option<Vec2> {
        let uvs = || self.vertices(hit).map(|vertex| Vec2::from(vertex.uv));
        self.has_uvs.then(|| interpolate(hit.barycentrics, uvs()))
    }

    /// The number of vertices of the mesh, used or not.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// The numbers of the vertices of the triangle that was hit, in the mesh.
    pub fn vertex_numbers(&self, hit: &TriangleHit) -> [u32; 3] {
        self.triangles[hit.slot as usize].vertices
    }

    /// The numbers of the vertices of the triangle with this number, in the mesh. `None` if there is no such triangle, or
    /// it was left out. The first time in O(n).
    pub fn vertices_of(&self, number: u32) -> Option<[u32; 3]> {
        Some(self.triangles[self.slot_of(number)?].vertices)
    }

    /// The corners of the triangle with this number: see [`vertices_of`](Self::vertices_of).
    pub fn corners_of(&self, number: u32) -> Option<[Vec3; 3]> {
        Some(self.triangles[self.slot_of(number)?].corners)
    }

    fn slot_of(&self, number: u32) -> Option<usize> {
        let slots = self.slots.get_or_init(|| {
            let end = self.triangles.iter().map(|triangle| triangle.number + 1).max();
            let mut slots = vec![NO_SLOT; end.unwrap_or(0) as usize];
            for (triangle, slot) in self.triangles.iter().zip(0..) {
                slots[triangle.number as usize] = slot;
            }
            slots
        });
        let slot = *slots.get(number as usize)?;
        (slot != NO_SLOT).then_some(slot as usize)
    }

    /// The numbers of the vertices of all triangles that can be hit, in the order of
    /// [`corners_of_all`](Self::corners_of_all).
    pub fn vertices_of_all(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().map(|triangle| triangle.vertices)
    }

    /// The vertices of the triangle that was hit.
    fn vertices(&self, hit: &TriangleHit) -> [&Vertex; 3] {
        self.vertex_numbers(hit).map(|vertex| &self.vertices[vertex as usize])
    }

    #[inline]
    pub(super) fn corners(&self, slot: u32) -> [Vec3A; 3] {
        self.triangles[slot as usize].corners.map(Vec3A::from)
    }

    /// The number of a triangle in the mesh.
    pub(super) fn number(&self, slot: u32) -> u32 {
        self.triangles[slot as usize].number
    }

    /// The box of a triangle, with the slack that its ray test needs: see [`tolerance::TRIANGLE_BOX`].
    pub(super) fn triangle_box(&self, slot: u32) -> Aabb3d {
        let [a, b, c] = self.corners(slot);
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        let slack = Vec3A::splat((max - min).max_element() * tolerance::TRIANGLE_BOX);
        Aabb3d {
            min: min - slack,
            max: max + slack,
        }
    }

    #[inline]
    pub(super) fn hit(&self, slot: u32, hit: TriangleIntersection) -> TriangleHit {
        TriangleHit {
            t: hit.t,
            triangle: self.triangles[slot as usize].number,
            barycentrics: hit.barycentrics,
            slot,
        }
    }

    /// This mesh with its triangles in another order of slots: the new slot `i` holds the old slot `order[i]`.
    pub(super) fn reordered(&self, order: impl Iterator<Item = u32>) -> Self {
        Self {
            triangles: order.map(|slot| self.triangles[slot as usize]).collect(),
            vertices: self.vertices.clone(),
            slots: OnceLock::new(),
            ..*self
        }
    }

    /// Moves vertex `i` to `positions[i]`, and with it the corners of the triangles.
    ///
    /// # Panics
    ///
    /// As [`MeshBvh::refit`](super::MeshBvh::refit).
    pub fn move_vertices(&mut self, positions: &[Vec3]) {
        for triangle in &mut self.triangles {
            triangle.corners = triangle.vertices.map(|vertex| positions[vertex as usize]);
        }
        let corners = self.triangles.iter().flat_map(|triangle| triangle.corners);
        self.aabb = Aabb3d::enclosing(corners.map(Vec3A::from)).expect("finite positions");
    }
}

/// The nearer of two hits; of two at the same parameter, the triangle with the smaller number.
#[inline]
pub(super) fn nearer(best: Option<TriangleHit>, hit: TriangleHit) -> Option<TriangleHit> {
    match best {
        Some(best) if (best.t, best.triangle) <= (hit.t, hit.triangle) => Some(best),
        _ => Some(hit),
    }
}

/// A number of a triangle in the mesh, and its vertices.
type Numbered = (u32, [u32; 3]);

fn list(mut indices: impl Iterator<Item = u32>) -> Vec<Numbered> {
    (0..)
        .map_while(|number| Some((number, [indices.next()?, indices.next()?, indices.next()?])))
        .collect()
}

/// The triangles of a strip: every second one is turned round, so that all face one way.
fn strip(indices: impl Iterator<Item = u32>, restart: Option<u32>) -> Vec<Numbered> {
    let indices: Vec<u32> = indices.collect();
    let mut since_restart = 0;
    let triangle = |(number, window): (u32, &[u32])| {
        if window.iter().any(|index| Some(*index) == restart) {
            since_restart = 0;
            return None;
        }
        since_restart += 1;
        let (a, b, c) = (window[0], window[1], window[2]);
        Some((number, if since_restart % 2 == 1 { [a, b, c] } else { [b, a, c] }))
    };
    (0..).zip(indices.windows(3)).filter_map(triangle).collect()
}

/// The sum of three values, each weighted by a barycentric coordinate.
pub(super) fn interpolate<T: Mul<f32, Output = T> + Add<Output = T>>(weights: Vec3, [a, b, c]: [T; 3]) -> T {
    a * weights.x + b * weights.y + c * weights.z
}
