//! Eight triangles side by side, as one step of a ray tests them.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};

use crate::{
    geometry::{
        ray::triangle::{Backfaces, SMALLEST_EDGE_FUNCTION, TriangleIntersection, TriangleRay},
        tolerance,
    },
    spatial::simd::{LANES, Simd},
};

/// Up to eight triangles, in the first lanes. The other lanes repeat one of them, so that they have no say in the bounds.
/// Five cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct TrianglePacket {
    /// By corner and axis.
    corners: [[[f32; LANES]; 3]; 3],
    /// The numbers of the triangles in the mesh.
    numbers: [u32; LANES],
}

/// The number of a lane without a triangle.
pub(super) const NONE: u32 = u32::MAX;

impl TrianglePacket {
    /// A packet of one to eight triangles with their numbers.
    #[inline]
    pub fn new(triangles: impl Iterator<Item = ([Vec3A; 3], u32)>) -> Self {
        let mut packet = Self {
            corners: [[[0.0; LANES]; 3]; 3],
            numbers: [NONE; LANES],
        };
        let mut count = 0;
        for (corners, number) in triangles {
            packet.place(count, corners.map(Vec3::from));
            packet.numbers[count] = number;
            count += 1;
        }
        packet.pad(count);
        packet
    }

    /// The number of triangles.
    #[inline]
    pub fn len(&self) -> usize {
        self.numbers.iter().filter(|&&number| number != NONE).count()
    }

    #[inline]
    pub fn number(&self, lane: usize) -> u32 {
        self.numbers[lane]
    }

    #[inline]
    pub fn corners(&self, lane: usize) -> [Vec3A; 3] {
        self.corners.map(|[x, y, z]| Vec3A::new(x[lane], y[lane], z[lane]))
    }

    /// Moves the corners of every triangle to where `corners_of` says for its number.
    #[inline(always)]
    pub fn move_corners(&mut self, mut corners_of: impl FnMut(u32) -> [Vec3; 3]) {
        let mut count = 0;
        while count < LANES && self.numbers[count] != NONE {
            self.place(count, corners_of(self.numbers[count]));
            count += 1;
        }
        self.pad(count);
    }

    #[inline(always)]
    fn place(&mut self, lane: usize, corners: [Vec3; 3]) {
        for (packed, corner) in self.corners.iter_mut().zip(corners) {
            packed[0][lane] = corner.x;
            packed[1][lane] = corner.y;
            packed[2][lane] = corner.z;
        }
    }

    /// Repeats the last of `count` triangles in the lanes behind it.
    #[inline(always)]
    fn pad(&mut self, count: usize) {
        for values in self.corners.iter_mut().flatten() {
            let last = values[count - 1];
            values[count..].fill(last);
        }
    }

    /// The lanes that a ray may hit: all that it does hit, and those whose edges it comes too close to for a decision in
    /// single precision. Also lanes that hold no triangle.
    ///
    /// Computes the edge functions exactly as [`TriangleRay::triangle_intersection`] does, in the same order. One that
    /// is far enough from zero has the sign of the exact one, for rounding is monotonic.
    #[inline(always)]
    pub fn candidates<S: Simd>(&self, simd: S, ray: &TriangleRay, backfaces: Backfaces) -> u32 {
        let ([kx, ky, kz], origin, shear) = (ray.axes, ray.origin, ray.shear);
        let (origin_x, origin_y, origin_z) = (simd.splat(origin[0]), simd.splat(origin[1]), simd.splat(origin[2]));
        let (shear_x, shear_y) = (simd.splat(shear[0]), simd.splat(shear[1]));
        let (mut x, mut y) = ([origin_x; 3], [origin_y; 3]);
        for corner in 0..3 {
            let packed = &self.corners[corner];
            let z = simd.sub(simd.load(&packed[kz]), origin_z);
            x[corner] = simd.sub(simd.sub(simd.load(&packed[kx]), origin_x), simd.mul(shear_x, z));
            y[corner] = simd.sub(simd.sub(simd.load(&packed[ky]), origin_y), simd.mul(shear_y, z));
        }
        let ([ax, bx, cx], [ay, by, cy]) = (x, y);
        let u = simd.sub(simd.mul(cx, by), simd.mul(cy, bx));
        let v = simd.sub(simd.mul(ax, cy), simd.mul(ay, cx));
        let w = simd.sub(simd.mul(bx, ay), simd.mul(by, ax));

        // A NaN, of what overflows, is never outside by itself.
        let least = simd.min(simd.min(u, v), w);
        let outside = simd.le(least, simd.splat(-SMALLEST_EDGE_FUNCTION));
        match backfaces {
            Backfaces::Cull => !outside,
            Backfaces::Include => {
                let greatest = simd.max(simd.max(u, v), w);
                !(outside & simd.le(simd.splat(SMALLEST_EDGE_FUNCTION), greatest))
            }
        }
    }

    /// Where a ray meets the triangle of a lane, as [`TriangleRay::triangle_intersection`] tells.
    #[inline(always)]
    pub fn intersection(
        &self,
        lane: usize,
        ray: &TriangleRay,
        t_max: f32,
        backfaces: Backfaces,
    ) -> Option<TriangleIntersection> {
        let [kx, ky, kz] = ray.axes;
        let [a, b, c] = &self.corners;
        let a = [a[kx][lane], a[ky][lane], a[kz][lane]];
        let b = [b[kx][lane], b[ky][lane], b[kz][lane]];
        let c = [c[kx][lane], c[ky][lane], c[kz][lane]];
        ray.intersection_along_axes([a, b, c], t_max, backfaces)
    }

    /// The union of [`triangle_box`] over the triangles.
    #[inline(always)]
    pub fn bounds<S: Simd>(&self, simd: S) -> Aabb3d {
        let zero = simd.splat(0.0);
        let (mut low, mut high, mut longest) = ([zero; 3], [zero; 3], zero);
        for axis in 0..3 {
            let a = simd.load(&self.corners[0][axis]);
            let b = simd.load(&self.corners[1][axis]);
            let c = simd.load(&self.corners[2][axis]);
            low[axis] = simd.min(simd.min(a, b), c);
            high[axis] = simd.max(simd.max(a, b), c);
            longest = simd.max(longest, simd.sub(high[axis], low[axis]));
        }
        let slack = simd.mul(longest, simd.splat(tolerance::TRIANGLE_BOX));
        let (mut min, mut max) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            min[axis] = simd.min_lane(simd.sub(low[axis], slack));
            // The greatest is the least of the negated, negated.
            max[axis] = -simd.min_lane(simd.sub(zero, simd.add(high[axis], slack)));
        }
        Aabb3d {
            min: min.into(),
            max: max.into(),
        }
    }
}

/// The box of a triangle, with the slack that its ray test needs: see [`tolerance::TRIANGLE_BOX`].
pub(super) fn triangle_box([a, b, c]: [Vec3A; 3]) -> Aabb3d {
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let slack = Vec3A::splat((max - min).max_element() * tolerance::TRIANGLE_BOX);
    Aabb3d {
        min: min - slack,
        max: max + slack,
    }
}

#[cfg(test)]
mod tests;
