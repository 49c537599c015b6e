//! Rays at a box, evenly spread over all that may be seen of it.

use std::f64::consts::PI;

use bevy::math::{DVec2, DVec3, Vec3, bounding::Aabb3d};

use crate::geometry::ray::Ray;

/// Infinitely many rays that meet a box, or come near. The first so many are spread evenly, for every number.
///
/// They follow the sequence R₂ (Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018).
#[derive(Clone, Copy, Debug)]
pub(super) enum Pattern {
    /// From a point, evenly by solid angle.
    ///
    /// Directions are places on a cylinder around the point: by Archimedes, a sphere is projected onto that without a
    /// change of areas, so that a rectangle of azimuths and heights is a set of directions to draw from.
    FromPoint {
        eye: Vec3,
        /// To the right, along the axis of the cylinder, and towards the box.
        frame: [DVec3; 3],
        /// Azimuth and height: where the rectangle begins, and its size.
        first: DVec2,
        size: DVec2,
    },
    /// Parallel to each other, evenly over a rectangle.
    Parallel {
        direction: DVec3,
        /// A corner of the rectangle, and its sides.
        corner: DVec3,
        sides: [DVec3; 2],
    },
}

/// The steps of the sequence: powers of the reciprocal of the root of x³ = x + 1.
const STEPS: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);

impl Pattern {
    /// Rays from a point.
    pub fn from_point(eye: Vec3, aabb: &Aabb3d) -> Self {
        let to_corners = corners(aabb).map(|corner| corner - eye.as_dvec3());
        let to_middle = to_corners[0].midpoint(to_corners[7]);
        let forward = to_middle.try_normalize().unwrap_or(DVec3::NEG_Z);
        let frame @ [right, up, _] = frame(forward, aabb);
        let places = to_corners.map(|corner| DVec3::new(corner.dot(right), corner.dot(up), corner.dot(forward)));

        let nearest = places.iter().map(|place| place.z).fold(f64::INFINITY, f64::min);
        let farthest = places.iter().map(|place| place.z.hypot(place.x)).fold(0.0, f64::max);
        // The box is around the point, or so near that its azimuths end nowhere.
        if nearest <= 0.0 {
            return Self::FromPoint {
                eye,
                frame,
                first: DVec2::new(-PI, -1.0),
                size: DVec2::new(2.0 * PI, 2.0),
            };
        }
        // Heights as large as they may be: for what is above, from as near to the axis as the box comes.
        let height = |y: f64, is_outward: bool| y / y.hypot(if is_outward { nearest } else { farthest });
        let (mut first, mut last) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for place in places {
            let azimuth = place.x.atan2(place.z);
            first = first.min(DVec2::new(azimuth, height(place.y, place.y < 0.0)));
            last = last.max(DVec2::new(azimuth, height(place.y, place.y > 0.0)));
        }
        Self::FromPoint {
            eye,
            frame,
            first,
            size: last - first,
        }
    }

    /// Rays along a unit vector, from one side of the box.
    pub fn parallel(direction: DVec3, aabb: &Aabb3d) -> Self {
        let [right, up, _] = frame(direction, aabb);
        let corners = corners(aabb);
        let extent = |axis: DVec3| {
            let along = corners.map(|corner| corner.dot(axis));
            let first = along.into_iter().fold(f64::INFINITY, f64::min);
            let last = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
            (first, last - first)
        };
        let ((x, width), (y, height), (z, _)) = (extent(right), extent(up), extent(direction));
        Self::Parallel {
            direction,
            corner: right * x + up * y + direction * z,
            sides: [right * width, up * height],
        }
    }

    /// A ray by its number; `None` if it overflows.
    pub fn ray(&self, number: u32) -> Option<Ray> {
        let place = (DVec2::splat(0.5) + f64::from(number) * STEPS).fract();
        let (origin, direction) = match *self {
            Self::FromPoint {
                eye,
                frame: [right, up, forward],
                first,
                size,
            } => {
                let DVec2 { x: azimuth, y: height } = first + size * place;
                let (sin, cos) = azimuth.sin_cos();
                let around = right * sin + forward * cos;
                (eye, around * (1.0 - height * height).max(0.0).sqrt() + up * height)
            }
            Self::Parallel {
                direction,
                corner,
                sides: [width, height],
            } => ((corner + width * place.x + height * place.y).as_vec3(), direction),
        };
        Ray::new(origin, direction.as_vec3(), f32::INFINITY)
    }
}

/// Axes to the right, up and forward, of which the second is along what is longest of a box as it is seen.
fn frame(forward: DVec3, aabb: &Aabb3d) -> [DVec3; 3] {
    let size = Vec3::from(aabb.max - aabb.min).as_dvec3();
    // Of three axes across each other, one at least is not along the view.
    let across = DVec3::AXES.map(|axis| axis.reject_from_normalized(forward));
    let lengths = [0, 1, 2].map(|axis| across[axis].length() * size[axis]);
    let longest = (0..3).max_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
    let up = longest.and_then(|longest| across[longest].try_normalize());
    let up = up.filter(|_| lengths.iter().any(|&length| length > 0.0));
    let up = up.unwrap_or_else(|| forward.any_orthonormal_vector());
    [forward.cross(up), up, forward]
}

fn corners(aabb: &Aabb3d) -> [DVec3; 8] {
    let (min, max) = (Vec3::from(aabb.min).as_dvec3(), Vec3::from(aabb.max).as_dvec3());
    std::array::from_fn(|corner| {
        let at = |axis: usize| if corner >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(at(0), at(1), at(2))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxed(min: [f32; 3], max: [f32; 3]) -> Aabb3d {
        Aabb3d::from_min_max(Vec3::from(min), Vec3::from(max))
    }

    /// Boxes of many shapes, near the origin and far from it, with the origin inside of the last.
    fn boxes() -> Vec<Aabb3d> {
        vec![
            boxed([-1.0, -1.0, -6.0], [1.0, 1.0, -4.0]),
            boxed([3.0, -5.0, 2.0], [3.1, 40.0, 2.1]),
            boxed([-50.0, -1.0, -50.0], [50.0, -1.0, 50.0]),
            boxed([0.5, 0.5, 0.5], [9.0, 0.6, 9.0]),
            boxed([1e4, 1e4, -1e4], [1.0001e4, 1.0002e4, -0.9999e4]),
            boxed([-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]),
        ]
    }

    /// Whether a ray goes close by a corner of a box.
    fn goes_to(ray: &Ray, corner: Vec3, aabb: &Aabb3d) -> bool {
        let aside = (corner - Vec3::from(ray.origin())).reject_from(ray.direction().into());
        aside.length() < 0.06 * (aabb.max - aabb.min).length()
    }

    #[test]
    fn every_corner_of_a_box_is_among_what_rays_go_to() {
        for aabb in boxes() {
            for pattern in [
                Pattern::from_point(Vec3::ZERO, &aabb),
                Pattern::parallel(DVec3::new(0.48, -0.6, 0.64), &aabb),
            ] {
                let rays: Vec<Ray> = (0..4000).filter_map(|n| pattern.ray(n)).collect();
                for corner in corners(&aabb) {
                    let is_met = rays.iter().any(|ray| goes_to(ray, corner.as_vec3(), &aabb));
                    assert!(is_met, "{pattern:?} {corner}");
                }
            }
        }
    }

    #[test]
    fn rays_from_a_point_are_as_dense_everywhere() {
        // Around the point, so that all directions are drawn from: each octant has an eighth of them.
        let pattern = Pattern::from_point(Vec3::ZERO, &boxed([-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]));
        let mut octants = [0; 8];
        for n in 0..8000 {
            let ray = pattern.ray(n).expect("nothing overflows");
            octants[ray.direction().cmpgt(bevy::math::Vec3A::ZERO).bitmask() as usize] += 1;
        }
        assert!(octants.iter().all(|&n| (970..1030).contains(&n)), "{octants:?}");
    }

    #[test]
    fn a_box_without_a_size_or_around_the_eye_has_rays_too() {
        for aabb in [boxed([0.0; 3], [0.0; 3]), boxed([2.0; 3], [2.0; 3])] {
            for pattern in [
                Pattern::from_point(Vec3::ZERO, &aabb),
                Pattern::parallel(DVec3::Y, &aabb),
            ] {
                assert!(pattern.ray(7).is_some());
            }
        }
    }
}
