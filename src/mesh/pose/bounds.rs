//! A box around a mesh in any pose, from one box for each joint.
//!
//! The vertices that a joint moves lie, before they are moved, in one box. Its image under the matrix of the joint is in
//! a box `Y` around all such images. If the weights of a vertex are not negative and their sum is `s`, then it is drawn
//! at `s` times a point of the convex hull of those images, and so in `sY`. In general it is drawn at the difference of two
//! such points: one for the sum of its positive weights, one for that of the others.

use bevy::math::{
    Affine3A, Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use super::{MeshDeformer, Pose};
use crate::{
    geometry::{
        aabb::{EMPTY, EVERYTHING, union},
        rounding, tolerance,
    },
    mesh::TriangleMesh,
};

/// What the box around a mesh in a pose is computed from.
#[derive(Clone, Debug)]
pub(super) struct PoseBounds {
    /// All vertices.
    whole: Part,
    /// For each joint that moves any vertex, those vertices.
    of_joints: Vec<(usize, Part)>,
    /// The least and the greatest sum of the positive weights of a vertex, and of the negative ones without their sign.
    positive: [f32; 2],
    negative: [f32; 2],
}

/// Some of the vertices.
#[derive(Clone, Debug)]
struct Part {
    /// The box around them.
    base: Aabb3d,
    /// For each morph target, the box around their displacements.
    displacements: Vec<Aabb3d>,
}

/// The box around a part that is displaced.
struct Morphed {
    aabb: Aabb3d,
    /// The sum of the magnitudes that were added up.
    reach: Vec3A,
}

impl PoseBounds {
    /// Of the vertices of the triangles. `None` if what moves one of them is missing, NaN or infinite.
    pub fn new(deformer: &MeshDeformer, triangles: &TriangleMesh) -> Option<Self> {
        let vertices = deformer.positions.len();
        let mut is_used = vec![false; vertices];
        for vertex in triangles.vertices_of_all().flatten() {
            is_used[vertex as usize] = true;
        }
        let empty = Part {
            base: EMPTY,
            displacements: vec![EMPTY; deformer.targets],
        };
        let mut whole = empty.clone();
        let mut of_joints: Vec<Option<Part>> = vec![None; deformer.joints];
        let (mut positive, mut negative) = ([f64::INFINITY, 0.0], [f64::INFINITY, 0.0]);
        for (vertex, _) in is_used.into_iter().enumerate().filter(|&(_, is_used)| is_used) {
            whole.add(deformer, vertex)?;
            if !deformer.is_skinned() {
                continue;
            }
            let influences = deformer.influences.get(vertex)?;
            let (mut plus, mut minus) = (0.0, 0.0);
            for (joint, weight) in influences.joints.into_iter().zip(influences.weights) {
                if !weight.is_finite() {
                    return None;
                }
                if weight != 0.0 {
                    let part = of_joints[usize::from(joint)].get_or_insert_with(|| empty.clone());
                    part.add(deformer, vertex)?;
                }
                let sum = if weight > 0.0 { &mut plus } else { &mut minus };
                *sum += f64::from(weight.abs());
            }
            positive = [positive[0].min(plus), positive[1].max(plus)];
            negative = [negative[0].min(minus), negative[1].max(minus)];
        }
        let outward = |[least, greatest]: [f64; 2]| [rounding::down(least), rounding::up(greatest)];
        let of_joints = of_joints.into_iter().enumerate();
        Some(Self {
            whole,
            of_joints: of_joints.filter_map(|(joint, part)| Some((joint, part?))).collect(),
            positive: outward(positive),
            negative: outward(negative),
        })
    }

    /// The box around the mesh in a pose.
    pub fn aabb(&self, pose: &Pose) -> Aabb3d {
        let whole = self.whole.morphed(pose);
        let (aabb, magnitude) = if pose.joints.is_empty() {
            (whole.aabb, whole.reach)
        } else {
            self.skinned(pose)
        };
        // One that is not a number would get lost among others.
        if !magnitude.is_finite() {
            return EVERYTHING;
        }
        let morphing = active_targets(&pose.weights, self.whole.displacements.len()).count();
        let relative = tolerance::POSED_BOX + morphing as f32 * tolerance::MORPHED;
        // What underflows in a matrix is multiplied by a coordinate.
        let underflow = tolerance::UNDERFLOW * (1.0 + whole.reach.element_sum());
        let for_rays = (aabb.max - aabb.min).max_element() * tolerance::TRIANGLE_BOX;
        let slack = magnitude * relative + Vec3A::splat(underflow + for_rays);
        Aabb3d {
            min: aabb.min - slack,
            max: aabb.max + slack,
        }
    }

    /// The box without slack, and the largest sum of the magnitudes that were added up.
    fn skinned(&self, pose: &Pose) -> (Aabb3d, Vec3A) {
        let (mut images, mut magnitude) = (EMPTY, Vec3A::ZERO);
        for (joint, part) in &self.of_joints {
            let (image, size) = part.morphed(pose).image(&pose.joints[*joint]);
            if !size.is_finite() {
                return (EVERYTHING, Vec3A::INFINITY);
            }
            images = union(&images, &image);
            magnitude = magnitude.max(size);
        }
        if self.of_joints.is_empty() {
            // Without any weight, everything is drawn at the origin.
            images = Aabb3d {
                min: Vec3A::ZERO,
                max: Vec3A::ZERO,
            };
        }
        let (plus, minus) = (scaled(&images, self.positive), scaled(&images, self.negative));
        let aabb = Aabb3d {
            min: plus.min - minus.max,
            max: plus.max - minus.min,
        };
        (aabb, magnitude * (self.positive[1] + self.negative[1]))
    }
}

impl Part {
    /// `None` if a coordinate is missing, NaN or infinite.
    fn add(&mut self, deformer: &MeshDeformer, vertex: usize) -> Option<()> {
        let add = |aabb: &mut Aabb3d, point: Vec3A| {
            *aabb = union(aabb, &Aabb3d { min: point, max: point });
            point.is_finite().then_some(())
        };
        add(&mut self.base, deformer.positions[vertex].into())?;
        for (target, around) in self.displacements.iter_mut().enumerate() {
            let displacement = deformer.displacements.get(target * deformer.positions.len() + vertex)?;
            add(around, displacement.position.into())?;
        }
        Some(())
    }

    fn morphed(&self, pose: &Pose) -> Morphed {
        let mut aabb = self.base;
        let mut reach = aabb.min.abs().max(aabb.max.abs());
        for (target, weight) in active_targets(&pose.weights, self.displacements.len()) {
            let around = &self.displacements[target];
            let (a, b) = (around.min * weight, around.max * weight);
            aabb.min += a.min(b);
            aabb.max += a.max(b);
            reach += a.abs().max(b.abs());
        }
        Morphed { aabb, reach }
    }
}

impl Morphed {
    /// The box around its image, and the sum of the magnitudes that were added up: see
    /// [`Volume::transformed_by_affine`](crate::geometry::volume::Volume::transformed_by_affine).
    #[inline]
    fn image(&self, transform: &Affine3A) -> (Aabb3d, Vec3A) {
        let [x, y, z] = [
            transform.matrix3.x_axis.abs(),
            transform.matrix3.y_axis.abs(),
            transform.matrix3.z_axis.abs(),
        ];
        let absolute = |vector: Vec3A| x * vector.x + y * vector.y + z * vector.z;
        let center = transform.transform_point3a(self.aabb.center());
        let half_size = absolute(self.aabb.half_size());
        let image = Aabb3d {
            min: center - half_size,
            max: center + half_size,
        };
        (image, absolute(self.reach) + transform.translation.abs())
    }
}

/// The box around all multiples of a box by a number between two that are not negative.
fn scaled(aabb: &Aabb3d, [least, greatest]: [f32; 2]) -> Aabb3d {
    Aabb3d {
        min: (aabb.min * least).min(aabb.min * greatest),
        max: (aabb.max * least).max(aabb.max * greatest),
    }
}

/// The first so many targets as far as they have an effect, with their weights.
pub(super) fn active_targets(weights: &[f32], targets: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
    let weights = weights.iter().copied().take(targets).enumerate();
    weights.filter(|&(_, weight)| weight != 0.0)
}
