//! The triangles of a mesh, whichever way the mesh stores them.

mod edit;
mod moving;
mod storage;

pub(crate) use edit::MeshEdit;
pub(super) use moving::MovingTriangles;
use storage::Group;
pub(super) use storage::{Indexed, Storage};

use std::{
    ops::{Add, Mul},
    sync::{Arc, OnceLock},
};

use bevy::{
    math::{Vec2, Vec3, Vec3A, bounding::Aabb3d},
    mesh::{Indices, Mesh, MeshAccessError, PrimitiveTopology, VertexAttributeValues, VertexFormat},
};

use super::packet::{TrianglePacket, triangle_box};
use crate::{
    geometry::{
        aabb::EMPTY,
        convex_hull::ConvexHull,
        ray::{
            Ray,
            triangle::{Backfaces, TriangleIntersection, TriangleRay},
        },
        tolerance,
        volume::{AnyVolume, BoundingKind, UnboundablePoints, Volume},
    },
    spatial::simd::LANES,
};

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
///
/// Clones share what does not change when [vertices move](super::MeshBvh::refit): the numbers of the vertices, the normals
/// and the texture coordinates.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    storage: Storage,
    /// The number of triangles.
    len: usize,
    /// The box around all triangles.
    aabb: Aabb3d,
    fixed: Arc<Fixed>,
    /// The slot of each triangle by its number, [`NO_SLOT`] of those that were left out; once it is asked for.
    slots_by_number: Arc<OnceLock<Vec<u32>>>,
}

/// No triangle is in this slot.
const NO_SLOT: u32 = u32::MAX;

/// What stays as it is when vertices move, and whatever the order of the slots.
#[derive(Debug)]
struct Fixed {
    /// The numbers of the vertices of each triangle, by its number; anything where a triangle was left out.
    vertices: Vec<[u32; 3]>,
    vertex_count: usize,
    /// By vertex; none if the mesh has none.
    normals: Vec<[f32; 3]>,
    /// By vertex; none if the mesh has none.
    uvs: Vec<[f32; 2]>,
    /// How many triangles were left out.
    left_out: usize,
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

        let Listed { vertices, count } = match (mesh.try_indices_option().ok().flatten(), topology) {
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

        let positions: Vec<Vec3> = positions.iter().copied().map(Vec3::from).collect();
        let mut numbers = Vec::with_capacity(vertices.len());
        let mut aabb = EMPTY;
        for (number, of_triangle) in (0..).zip(&vertices) {
            let corners =
                of_triangle.map(|vertex| positions.get(vertex as usize).copied().map_or(Vec3A::NAN, Vec3A::from));
            if corners.iter().all(|corner| corner.is_finite()) {
                numbers.push(number);
                for corner in corners {
                    (aabb.min, aabb.max) = (aabb.min.min(corner), aabb.max.max(corner));
                }
            }
        }
        if numbers.is_empty() {
            return Err(UnusableMesh::NoTriangles);
        }
        let normals = match mesh.try_attribute(Mesh::ATTRIBUTE_NORMAL) {
            Ok(VertexAttributeValues::Float32x3(normals)) if normals.len() == positions.len() => normals.clone(),
            _ => Vec::new(),
        };
        let uvs = match mesh.try_attribute(Mesh::ATTRIBUTE_UV_0) {
            Ok(VertexAttributeValues::Float32x2(uvs)) if uvs.len() == positions.len() => uvs.clone(),
            _ => Vec::new(),
        };
        Ok(Self {
            len: numbers.len(),
            aabb,
            fixed: Arc::new(Fixed {
                vertices,
                vertex_count: positions.len(),
                normals,
                uvs,
                left_out: count - numbers.len(),
            }),
            storage: Storage::indexed(&numbers, Arc::new(positions)),
            slots_by_number: Arc::default(),
        })
    }

    /// The number of triangles.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no triangles. Never true of a mesh from [`TriangleMesh::from_mesh`].
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// How many triangles of the mesh were left out because they cannot be hit.
    pub fn left_out(&self) -> usize {
        self.fixed.left_out
    }

    /// The box around all triangles.
    pub fn aabb(&self) -> Aabb3d {
        self.aabb
    }

    /// The corners of all triangles that can be hit, in no promised order.
    pub fn corners_of_all(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.slots().map(|slot| self.corners(slot).map(Vec3::from))
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
        for slot in self.slots() {
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
        self.corners(hit.slot).map(Vec3::from)
    }

    /// The normal at the hit: interpolated from the vertices, of any length; without vertex normals, that of the
    /// [triangle](Self::geometric_normal).
    pub fn normal(&self, hit: &TriangleHit) -> Vec3 {
        let normals = &self.fixed.normals;
        if normals.is_empty() {
            return self.geometric_normal(hit);
        }
        let of_vertices = self
            .vertex_numbers(hit)
            .map(|vertex| Vec3::from(normals[vertex as usize]));
        let normal = interpolate(hit.barycentrics, of_vertices);
        if normal.is_finite() && normal != Vec3::ZERO {
            normal
        } else {
            self.geometric_normal(hit)
        }
    }

    /// The normal of the triangle that was hit, of any length: its corners run counter-clockwise around it.
    pub fn geometric_normal(&self, hit: &TriangleHit) -> Vec3 {
        let [a, b, c] = self.triangle(hit);
        // Scaled first, so that the product of tiny sides does not underflow.
        let (ab, ac) = (b - a, c - a);
        let longest = ab.abs().max(ac.abs()).max_element();
        (ab / longest).cross(ac / longest)
    }

    /// The texture coordinates at the hit, if the mesh has any.
    pub fn uv(&self, hit: &TriangleHit) -> Option<Vec2> {
        let uvs = &self.fixed.uvs;
        let of_vertices = || self.vertex_numbers(hit).map(|vertex| Vec2::from(uvs[vertex as usize]));
        (!uvs.is_empty()).then(|| interpolate(hit.barycentrics, of_vertices()))
    }

    /// The number of vertices of the mesh, used or not.
    pub fn vertex_count(&self) -> usize {
        self.fixed.vertex_count
    }

    /// The numbers of the vertices of the triangle that was hit, in the mesh.
    pub fn vertex_numbers(&self, hit: &TriangleHit) -> [u32; 3] {
        self.fixed.vertices[hit.triangle as usize]
    }

    /// The numbers of the vertices of the triangle with this number, in the mesh. `None` if there is no such triangle, or
    /// it was left out. The first time in O(n).
    pub fn vertices_of(&self, number: u32) -> Option<[u32; 3]> {
        self.slot_of(number).map(|_| self.fixed.vertices[number as usize])
    }

    /// The corners of the triangle with this number: see [`vertices_of`](Self::vertices_of).
    pub fn corners_of(&self, number: u32) -> Option<[Vec3; 3]> {
        Some(self.corners(self.slot_of(number)?).map(Vec3::from))
    }

    /// The numbers of the vertices of all triangles that can be hit, in the order of
    /// [`corners_of_all`](Self::corners_of_all).
    pub fn vertices_of_all(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.slots().map(|slot| self.fixed.vertices[self.number(slot) as usize])
    }

    /// Where the triangle with this number is kept. The first time in O(n).
    pub(super) fn slot_of(&self, number: u32) -> Option<u32> {
        let slots = self.slots_by_number.get_or_init(|| {
            let mut slots = vec![NO_SLOT; self.fixed.vertices.len()];
            for slot in self.slots() {
                slots[self.number(slot) as usize] = slot;
            }
            slots
        });
        slots.get(number as usize).copied().filter(|&slot| slot != NO_SLOT)
    }

    /// The bytes of memory that the triangles take, with what clones share.
    pub fn memory(&self) -> usize {
        let fixed = &self.fixed;
        size_of::<Self>()
            + size_of::<Fixed>()
            + self.storage.memory()
            + self
                .slots_by_number
                .get()
                .map_or(0, |slots| slots.capacity() * size_of::<u32>())
            + fixed.vertices.capacity() * size_of::<[u32; 3]>()
            + fixed.normals.capacity() * size_of::<[f32; 3]>()
            + fixed.uvs.capacity() * size_of::<[f32; 2]>()
    }

    /// Where triangles are kept: group by group, of which some are not full.
    pub(super) fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.storage.group_count()).flat_map(|group| {
            let first = (group * LANES) as u32;
            first..first + self.storage.len_of(group) as u32
        })
    }

    #[inline]
    pub(super) fn corners(&self, slot: u32) -> [Vec3A; 3] {
        self.storage.corners(slot, &self.fixed.vertices)
    }

    /// The number of a triangle in the mesh.
    #[inline]
    pub(super) fn number(&self, slot: u32) -> u32 {
        self.storage.number(slot)
    }

    /// The box of a triangle, with the slack that its ray test needs.
    pub(super) fn triangle_box(&self, slot: u32) -> Aabb3d {
        triangle_box(self.corners(slot))
    }

    #[inline]
    pub(super) fn hit(&self, slot: u32, hit: TriangleIntersection) -> TriangleHit {
        TriangleHit {
            t: hit.t,
            triangle: self.number(slot),
            barycentrics: hit.barycentrics,
            slot,
        }
    }

    #[inline]
    pub(super) fn storage(&self) -> &Storage {
        &self.storage
    }

    /// The vertices of all triangles, by number.
    #[inline]
    pub(super) fn vertices(&self) -> &[[u32; 3]] {
        &self.fixed.vertices
    }

    /// A packet of the triangles in some slots, one to eight.
    #[inline]
    pub(super) fn gather(&self, slots: impl Iterator<Item = u32>) -> TrianglePacket {
        TrianglePacket::new(slots.map(|slot| (self.corners(slot), self.number(slot))))
    }

    /// The same triangles in packets.
    pub(super) fn packed(&self, packets: Vec<TrianglePacket>) -> Self {
        self.with_storage(Storage::Packed(packets))
    }

    /// The same triangles in groups, by their slots here.
    pub(super) fn indexed<G: Iterator<Item = u32>>(&self, groups: impl Iterator<Item = G>) -> Self {
        let groups = groups.map(|slots| Group::new(slots.map(|slot| self.number(slot))));
        self.with_storage(Storage::Indexed(Indexed {
            groups: groups.collect(),
            positions: match &self.storage {
                Storage::Packed(_) => Arc::new(self.positions().into_owned()),
                Storage::Indexed(indexed) => Arc::clone(&indexed.positions),
            },
        }))
    }

    fn with_storage(&self, storage: Storage) -> Self {
        Self {
            storage,
            len: self.len,
            aabb: self.aabb,
            fixed: Arc::clone(&self.fixed),
            slots_by_number: Arc::default(),
        }
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

/// The triangles of a mesh as it lists them.
struct Listed {
    /// By number; [`GAP`] where a strip begins anew.
    vertices: Vec<[u32; 3]>,
    /// The number of triangles.
    count: usize,
}

/// No vertices: beyond the end of any mesh.
const GAP: [u32; 3] = [u32::MAX; 3];

fn list(mut indices: impl Iterator<Item = u32>) -> Listed {
    let mut vertices = Vec::with_capacity(indices.size_hint().0 / 3);
    while let (Some(a), Some(b), Some(c)) = (indices.next(), indices.next(), indices.next()) {
        vertices.push([a, b, c]);
    }
    let count = vertices.len();
    Listed { vertices, count }
}

/// The triangles of a strip: every second one is turned round, so that all face one way.
fn strip(indices: impl Iterator<Item = u32>, restart: Option<u32>) -> Listed {
    let indices: Vec<u32> = indices.collect();
    let (mut since_restart, mut count) = (0, 0);
    let triangle = |window: &[u32]| {
        if window.iter().any(|index| Some(*index) == restart) {
            since_restart = 0;
            return GAP;
        }
        since_restart += 1;
        count += 1;
        let (a, b, c) = (window[0], window[1], window[2]);
        if since_restart % 2 == 1 { [a, b, c] } else { [b, a, c] }
    };
    let vertices = indices.windows(3).map(triangle).collect();
    Listed { vertices, count }
}

/// The sum of three values, each weighted by a barycentric coordinate.
pub(super) fn interpolate<T: Mul<f32, Output = T> + Add<Output = T>>(weights: Vec3, [a, b, c]: [T; 3]) -> T {
    a * weights.x + b * weights.y + c * weights.z
}
