//! Meshes in a pose: displaced by morph targets, then skinned to joints, as Bevy's vertex shader draws them.
//!
//! A vertex at `p` is drawn at `Σ wᵢ Mᵢ (p + Σ mₖ dₖ)`, where `wᵢ` are its joint weights as the mesh has them,
//! whatever their sum, `Mᵢ` the matrices of its joints, and `dₖ` its displacements in the morph targets of weights `mₖ`
//! (linear blend skinning; Akenine-Möller, Haines and Hoffman, *Real-Time Rendering*, 4th edition, 2018, §4.4 and §4.5).

mod bounds;
mod posed;

use bevy::{
    math::{Affine3A, DMat3, Mat3A, Vec3, Vec3A, bounding::Aabb3d},
    mesh::{Mesh, VertexAttributeValues, morph::MorphAttributes},
};

pub use posed::PosedMesh;

use super::TriangleMesh;
use bounds::{PoseBounds, active_targets};

/// How a mesh is posed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// From the space of the mesh to that of the pose, for each joint: in Bevy's renderer the `GlobalTransform` of the
    /// joint times its inverse bind pose. Empty if the mesh is not skinned, and so stays in its own space.
    pub joints: Vec<Affine3A>,
    /// How much of each morph target is added. Empty if there are none.
    pub weights: Vec<f32>,
}

impl Pose {
    /// Whether nothing in it is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.joints.iter().all(Affine3A::is_finite) && self.weights.iter().all(|weight| weight.is_finite())
    }
}

/// What poses a mesh: a copy of its vertices with their joints and morph targets.
#[derive(Clone, Debug)]
pub struct MeshDeformer {
    positions: Vec<Vec3>,
    /// Empty if the mesh has no normals.
    normals: Vec<Vec3>,
    /// Empty if the mesh has no joints.
    influences: Vec<Influences>,
    /// Target by target, vertex by vertex.
    displacements: Vec<Displacement>,
    targets: usize,
    joints: usize,
    bounds: Option<PoseBounds>,
}

/// The joints that a vertex follows.
#[derive(Clone, Copy, Debug)]
struct Influences {
    joints: [u16; 4],
    weights: [f32; 4],
}

/// What a morph target adds to a vertex.
#[derive(Clone, Copy, Debug)]
struct Displacement {
    position: Vec3,
    normal: Vec3,
}

impl MeshDeformer {
    /// Copies what poses `mesh`, whose triangles are `triangles`. `None` if it has neither joints nor morph targets.
    pub fn from_mesh(mesh: &Mesh, triangles: &TriangleMesh) -> Option<Self> {
        let float3 = |attribute| {
            let values = mesh.try_attribute(attribute).ok()?.as_float3()?;
            Some(values.iter().copied().map(Vec3::from).collect::<Vec<_>>())
        };
        let positions = float3(Mesh::ATTRIBUTE_POSITION)?;
        let influences = match (
            mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_INDEX),
            mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT),
        ) {
            (Ok(VertexAttributeValues::Uint16x4(joints)), Ok(VertexAttributeValues::Float32x4(weights))) => {
                let influences = joints.iter().zip(weights);
                influences
                    .map(|(&joints, &weights)| Influences { joints, weights })
                    .collect()
            }
            _ => Vec::new(),
        };
        let displacements: Vec<Displacement> = mesh.try_morph_targets().map_or(Vec::new(), |targets| {
            let displacement = |target: &MorphAttributes| Displacement {
                position: target.position,
                normal: target.normal,
            };
            targets.iter().map(displacement).collect()
        });
        if influences.is_empty() && displacements.is_empty() {
            return None;
        }
        let highest = influences.iter().flat_map(|influences| influences.joints).max();
        let mut deformer = Self {
            normals: float3(Mesh::ATTRIBUTE_NORMAL)
                .filter(|normals| normals.len() == positions.len())
                .unwrap_or_default(),
            targets: displacements.len().checked_div(positions.len()).unwrap_or(0),
            joints: highest.map_or(0, |highest| usize::from(highest) + 1),
            positions,
            influences,
            displacements,
            bounds: None,
        };
        deformer.bounds = PoseBounds::new(&deformer, triangles);
        Some(deformer)
    }

    /// Whether the mesh has joints.
    pub fn is_skinned(&self) -> bool {
        !self.influences.is_empty()
    }

    /// How many joints a pose needs to have if it has any.
    pub fn joint_count(&self) -> usize {
        self.joints
    }

    /// How many morph targets the mesh has. More weights in a pose are of no effect.
    pub fn target_count(&self) -> usize {
        self.targets
    }

    /// The number of vertices of the mesh.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Whether the mesh can be posed: no vertex of a triangle has joint weights or displacements that are missing, NaN or
    /// infinite.
    pub fn is_sound(&self) -> bool {
        self.bounds.is_some()
    }

    /// A box around all triangles in a pose, rounding included. Conservative: made of one box for each joint. Infinite
    /// or NaN where a position might overflow, and `None` if the mesh is not [sound](Self::is_sound).
    ///
    /// # Panics
    ///
    /// If the pose has joints, and too few.
    pub fn aabb(&self, pose: &Pose) -> Option<Aabb3d> {
        self.bounds.as_ref().map(|bounds| bounds.aabb(pose))
    }

    /// Where all vertices are in a pose, written over `positions`: those of [`position`](Self::position).
    ///
    /// # Panics
    ///
    /// If the mesh is not [sound](Self::is_sound), or the pose has joints, and too few.
    pub fn write_positions(&self, pose: &Pose, positions: &mut Vec<Vec3>) {
        positions.clone_from(&self.positions);
        let vertices = self.vertex_count();
        for (target, weight) in self.active(pose) {
            let target = &self.displacements[target * vertices..][..vertices];
            for (position, displacement) in positions.iter_mut().zip(target) {
                *position += weight * displacement.position;
            }
        }
        if !pose.joints.is_empty() {
            // Vertices beyond the influences are of no triangle.
            for (position, influences) in positions.iter_mut().zip(&self.influences) {
                *position = influences.blend(&pose.joints).transform_point3(*position);
            }
        }
    }

    /// Where a vertex is in a pose.
    ///
    /// # Panics
    ///
    /// If the vertex is of no triangle, or the mesh is not [sound](Self::is_sound), or the pose has joints, and too few.
    pub fn position(&self, vertex: u32, pose: &Pose) -> Vec3 {
        let vertex = vertex as usize;
        let mut position = self.positions[vertex];
        for (target, weight) in self.active(pose) {
            position += weight * self.displacements[target * self.vertex_count() + vertex].position;
        }
        if pose.joints.is_empty() {
            position
        } else {
            self.influences[vertex].blend(&pose.joints).transform_point3(position)
        }
    }

    /// The unit normal of a vertex in a pose. Zero if the mesh has no normals, or if the skin is flat there.
    ///
    /// # Panics
    ///
    /// As [`position`](Self::position).
    pub fn normal(&self, vertex: u32, pose: &Pose) -> Vec3 {
        let vertex = vertex as usize;
        let Some(&(mut normal)) = self.normals.get(vertex) else {
            return Vec3::ZERO;
        };
        for (target, weight) in self.active(pose) {
            normal += weight * self.displacements[target * self.vertex_count() + vertex].normal;
        }
        if pose.joints.is_empty() {
            return normal.normalize_or_zero();
        }
        let blend = self.influences[vertex].blend(&pose.joints).matrix3;
        let blend = DMat3::from_cols(
            blend.x_axis.as_dvec3(),
            blend.y_axis.as_dvec3(),
            blend.z_axis.as_dvec3(),
        );
        let normal = blend.inverse().transpose() * normal.as_dvec3();
        normal.normalize_or_zero().as_vec3()
    }

    /// The targets that have an effect, with their weights.
    fn active<'a>(&self, pose: &'a Pose) -> impl Iterator<Item = (usize, f32)> + use<'a> {
        active_targets(&pose.weights, self.targets)
    }
}

impl Influences {
    /// The sum of the matrices of the joints by their weights.
    #[inline]
    fn blend(&self, joints: &[Affine3A]) -> Affine3A {
        let [a, b, c, d] = self.joints.map(|joint| &joints[usize::from(joint)]);
        let [wa, wb, wc, wd] = self.weights.map(Vec3A::splat);
        let sum = |column: fn(&Affine3A) -> Vec3A| wa * column(a) + wb * column(b) + wc * column(c) + wd * column(d);
        Affine3A {
            matrix3: Mat3A::from_cols(
                sum(|joint| joint.matrix3.x_axis),
                sum(|joint| joint.matrix3.y_axis),
                sum(|joint| joint.matrix3.z_axis),
            ),
            translation: sum(|joint| joint.translation),
        }
    }
}
