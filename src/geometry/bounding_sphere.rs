//! Bounding spheres: what [`BoundingSphere`] lacks.

use bevy::math::{
    Affine3A, DMat3, DVec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};

use super::{
    ray::Ray,
    rounding, tolerance,
    volume::{ExactAffine, UnboundablePoints, Volume, finite},
};

/// More operations on [`BoundingSphere`].
pub trait BoundingSphereExt: Sized {
    /// A small sphere around all `points`, in their space, in linear time whatever the points; as a rule a few percent
    /// wider than the smallest.
    ///
    /// Source: Ritter, *An Efficient Bounding Sphere*, Graphics Gems, 1990, and the refinement by shrinking and growing
    /// again of Ericson, *Real-Time Collision Detection*, 2005, §4.3.5.
    ///
    /// # Errors
    ///
    /// As [`Volume::enclosing`].
    fn ritter(points: impl IntoIterator<Item = Vec3A>) -> Result<Self, UnboundablePoints>;
}

impl BoundingSphereExt for BoundingSphere {
    fn ritter(points: impl IntoIterator<Item = Vec3A>) -> Result<Self, UnboundablePoints> {
        let points = finite(points)?;
        // Relative to a point of theirs, so that a small cloud far out keeps its digits.
        let origin = points[0].as_dvec3();
        let local: Vec<_> = points.iter().map(|point| point.as_dvec3() - origin).collect();
        let mut ball = Ball::of_distant_pair(&local);
        local.iter().for_each(|&point| ball.grow(point));
        let mut best = ball;
        for pass in 0..RITTER_PASSES {
            ball.radius_squared = (best.radius_squared.sqrt() * RITTER_SHRINKAGE).powi(2);
            ball.center = best.center;
            // Another order finds another sphere.
            if pass % 2 == 0 {
                local.iter().rev().for_each(|&point| ball.grow(point));
            } else {
                local.iter().for_each(|&point| ball.grow(point));
            }
            if ball.radius_squared < best.radius_squared {
                best = ball;
            }
        }
        around(best.center + origin, &points)
    }
}

/// How often a sphere is shrunk and grown again; more gains little.
const RITTER_PASSES: usize = 8;

/// What a sphere is shrunk to before it grows again: Ericson's 95 %.
const RITTER_SHRINKAGE: f64 = 0.95;

impl Volume for BoundingSphere {
    /// The smallest sphere, up to the rounding of its centre to `f32`.
    ///
    /// A handful of passes over the points, so linear in practice, as proven only for the randomized algorithm of
    /// Welzl. Source: Gärtner, *Fast and Robust Smallest Enclosing Balls*, ESA 1999, §3: the farthest point joins the
    /// points that the sphere is known to rest on, until there is none outside.
    fn enclosing(points: impl IntoIterator<Item = Vec3A>) -> Result<Self, UnboundablePoints> {
        let points = finite(points)?;
        around(smallest_center(&points), &points)
    }

    /// The smallest sphere around both, up to the rounding of its centre.
    fn merged(&self, other: &Self) -> Self {
        let (a, b) = (self.center.as_dvec3(), other.center.as_dvec3());
        let (ra, rb) = (f64::from(self.radius()), f64::from(other.radius()));
        let apart = a.distance(b);
        let contains = |outer: f64, inner: f64| {
            outer >= (apart + inner) * (1.0 + tolerance::DOUBLE) || apart == 0.0 && outer >= inner
        };
        if contains(ra, rb) {
            return *self;
        }
        if contains(rb, ra) {
            return *other;
        }
        let center = (a + (b - a) * (0.5 + 0.5 * (rb - ra) / apart)).as_vec3a();
        let exact = center.as_dvec3();
        sound(center, (exact.distance(a) + ra).max(exact.distance(b) + rb))
    }

    /// The smallest sphere around the image, up to rounding: the largest singular value of the matrix scales its
    /// radius.
    fn transformed_by_affine(&self, transform: &Affine3A) -> Self {
        let transform = ExactAffine::new(transform);
        let radius = f64::from(self.radius());
        let center = transform.transform_point(self.center.as_dvec3());
        let rounded = center.as_vec3a();
        let rounding = transform.rounding(self.center.as_dvec3().abs() + radius);
        sound(
            rounded,
            largest_singular_value(&transform.matrix) * radius
                + rounded.as_dvec3().distance(center)
                + rounding.length(),
        )
    }

    fn grown(&self, amount: f32) -> Self {
        sound(self.center, f64::from(self.radius()) + f64::from(amount))
    }

    fn contains_point(&self, point: Vec3A) -> bool {
        let radius = f64::from(self.radius());
        point.as_dvec3().distance_squared(self.center.as_dvec3()) <= radius * radius * (1.0 + tolerance::DOUBLE)
    }

    #[inline]
    fn ray_intersection_at(&self, ray: &Ray) -> Option<f32> {
        ray.sphere_intersection_at(self)
    }

    /// Infinite where the sphere reaches beyond the range of `f32`.
    fn aabb(&self) -> Aabb3d {
        let (center, radius) = (self.center.as_dvec3(), f64::from(self.radius()));
        Aabb3d {
            min: rounding::down3(center - radius),
            max: rounding::up3(center + radius),
        }
    }

    fn volume(&self) -> f32 {
        (4.0 / 3.0 * std::f64::consts::PI * f64::from(self.radius()).powi(3)) as f32
    }

    fn surface_area(&self) -> f32 {
        (4.0 * std::f64::consts::PI * f64::from(self.radius()).powi(2)) as f32
    }
}

/// The sphere about the rounded `center` that contains all `points`.
fn around(center: DVec3, points: &[Vec3A]) -> Result<BoundingSphere, UnboundablePoints> {
    let center = center.as_vec3a();
    let exact = center.as_dvec3();
    let farthest = points
        .iter()
        .map(|point| point.as_dvec3().distance_squared(exact))
        .fold(0.0, f64::max);
    let radius = rounding::up(farthest.sqrt());
    if center.is_finite() && radius.is_finite() {
        Ok(BoundingSphere::new(center, radius))
    } else {
        Err(UnboundablePoints::Overflow)
    }
}

/// The sphere with a radius that was computed in double precision, or, if that or the centre is not finite, the sphere
/// without end.
fn sound(center: Vec3A, radius: f64) -> BoundingSphere {
    let radius = rounding::up(radius * (1.0 + tolerance::DOUBLE));
    if center.is_finite() && radius.is_finite() {
        BoundingSphere::new(center, radius)
    } else {
        BoundingSphere::new(Vec3A::ZERO, f32::INFINITY)
    }
}

/// The square root of the largest eigenvalue of `matrixᵀ · matrix`, in closed form. Source: Smith, *Eigenvalues of a
/// Symmetric 3 × 3 Matrix*, CACM 4(4), 1961.
fn largest_singular_value(matrix: &DMat3) -> f64 {
    let gram = matrix.transpose() * *matrix;
    let diagonal = DVec3::new(gram.x_axis.x, gram.y_axis.y, gram.z_axis.z);
    let mean = diagonal.element_sum() / 3.0;
    let off_diagonal = DVec3::new(gram.y_axis.x, gram.z_axis.x, gram.z_axis.y).length_squared();
    let spread = (((diagonal - mean).length_squared() + 2.0 * off_diagonal) / 6.0).sqrt();
    if spread == 0.0 {
        return mean.sqrt();
    }
    let half_determinant = ((gram - DMat3::from_diagonal(DVec3::splat(mean))) * spread.recip()).determinant() / 2.0;
    let angle = half_determinant.clamp(-1.0, 1.0).acos() / 3.0;
    (mean + 2.0 * spread * angle.cos()).sqrt()
}

/// The centre of the smallest sphere around the points, of which there is one at least.
fn smallest_center(points: &[Vec3A]) -> DVec3 {
    let mut support = vec![points[0].as_dvec3()];
    let mut ball = Ball {
        center: support[0],
        radius_squared: 0.0,
    };
    loop {
        let (farthest, distance_squared) = points.iter().map(|point| point.as_dvec3()).fold(
            (support[0], ball.radius_squared),
            |(farthest, most), point| {
                let distance_squared = point.distance_squared(ball.center);
                if distance_squared > most {
                    (point, distance_squared)
                } else {
                    (farthest, most)
                }
            },
        );
        if distance_squared <= ball.radius_squared {
            return ball.center;
        }
        let (larger, rests_on) = Ball::smallest_through(farthest, &support);
        // The radius grows with every point; where it does not, what sticks out is rounding.
        if larger.radius_squared <= ball.radius_squared {
            return ball.center;
        }
        (ball, support) = (larger, rests_on);
    }
}

/// A sphere in double precision.
#[derive(Clone, Copy)]
struct Ball {
    center: DVec3,
    radius_squared: f64,
}

impl Ball {
    /// The smallest sphere around `new` and the `others`, four at most, which is known to rest on `new`, and the points
    /// that it rests on.
    fn smallest_through(new: DVec3, others: &[DVec3]) -> (Self, Vec<DVec3>) {
        (1usize..1 << others.len())
            .filter(|chosen| chosen.count_ones() <= 3)
            .filter_map(|chosen| {
                let mut rests_on: Vec<_> = (0..others.len())
                    .filter(|other| chosen >> other & 1 == 1)
                    .map(|other| others[other])
                    .collect();
                let center = circumcenter(new, &rests_on)?;
                rests_on.push(new);
                // Not the distance to one of the points that define it: the candidate that reaches all with the least
                // radius is the right one, without any tolerance.
                let radius_squared = (others.iter().chain([&new]))
                    .map(|point| point.distance_squared(center))
                    .fold(0.0, f64::max);
                Some((Self { center, radius_squared }, rests_on))
            })
            .min_by(|(a, _), (b, _)| a.radius_squared.total_cmp(&b.radius_squared))
            .unwrap_or_else(|| {
                (
                    Self {
                        center: new,
                        radius_squared: 0.0,
                    },
                    vec![new],
                )
            })
    }

    /// The sphere on the most distant of the three pairs of points that are extremal along an axis.
    fn of_distant_pair(points: &[DVec3]) -> Self {
        let pairs = (0..3).map(|axis| {
            points.iter().fold([points[0]; 2], |[low, high], &point| {
                [
                    if point[axis] < low[axis] { point } else { low },
                    if point[axis] > high[axis] { point } else { high },
                ]
            })
        });
        let [a, b] = pairs
            .max_by(|[a, b], [c, d]| a.distance_squared(*b).total_cmp(&c.distance_squared(*d)))
            .unwrap_or([points[0]; 2]);
        let center = a.midpoint(b);
        Self {
            center,
            radius_squared: center.distance_squared(a),
        }
    }

    /// The smallest sphere around this one and a point.
    fn grow(&mut self, point: DVec3) {
        let distance_squared = point.distance_squared(self.center);
        if distance_squared > self.radius_squared {
            let distance = distance_squared.sqrt();
            let radius = self.radius_squared.sqrt().midpoint(distance);
            self.center += (point - self.center) * ((distance - radius) / distance);
            self.radius_squared = radius * radius;
        }
    }
}

/// The centre of the smallest sphere through `point` and one to three others, or `None` where they do not define one.
fn circumcenter(point: DVec3, others: &[DVec3]) -> Option<DVec3> {
    let center = match *others {
        [a] => (a - point) / 2.0,
        [a, b] => {
            let (a, b) = (a - point, b - point);
            let normal = a.cross(b);
            (b.cross(normal) * a.length_squared() + normal.cross(a) * b.length_squared())
                / (2.0 * normal.length_squared())
        }
        [a, b, c] => {
            let (a, b, c) = (a - point, b - point, c - point);
            (b.cross(c) * a.length_squared() + c.cross(a) * b.length_squared() + a.cross(b) * c.length_squared())
                / (2.0 * a.dot(b.cross(c)))
        }
        _ => return None,
    };
    center.is_finite().then_some(point + center)
}
