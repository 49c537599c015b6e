//! What a simplified mesh should keep besides its shape, as numbers for each vertex.

use bevy::mesh::{Mesh, VertexAttributeValues};

use super::source::{finite, unit};

/// What a normal that is off by its length weighs, against a vertex that is off by the extent of the mesh.
///
/// On scanned models 0.5 doubles the distance of a level from the original, at as many triangles, and 0.1 is no farther
/// than without.
const NORMAL: f32 = 0.1;
/// The same for a channel of the vertex colour.
const COLOR: f32 = 0.1;
/// The same for joint weights.
const SKIN: f32 = 0.5;
/// The same for a displacement by the extent of the mesh.
const MORPH: f32 = 1.0;

/// Onto how many numbers the weights of all joints are projected.
const SKIN_DIMENSIONS: usize = 4;
/// The most displacements that are taken apart; of more, some are added up.
const MORPH_TARGETS: usize = 7;

/// Numbers for each vertex, that are interpolated over triangles, and are to change little.
#[derive(Debug)]
pub(super) struct Features {
    pub values: Vec<f32>,
    pub weights: Vec<f32>,
}

impl Features {
    /// Those of some vertices of a mesh of some extent.
    pub fn of(mesh: &Mesh, numbers: &[u32], extent: f32) -> Self {
        let mut columns: Vec<(f32, Box<dyn Fn(usize, &mut Vec<f32>) + '_>, usize)> = Vec::new();
        if let Ok(VertexAttributeValues::Float32x3(normals)) = mesh.try_attribute(Mesh::ATTRIBUTE_NORMAL) {
            let write = |vertex: usize, row: &mut Vec<f32>| row.extend(unit(normals[vertex]).to_array());
            columns.push((NORMAL, Box::new(write), 3));
        }
        if let Ok(VertexAttributeValues::Float32x4(colors)) = mesh.try_attribute(Mesh::ATTRIBUTE_COLOR) {
            let write = |vertex: usize, row: &mut Vec<f32>| {
                let color = finite(colors[vertex]).clamp(bevy::math::Vec4::ZERO, bevy::math::Vec4::ONE);
                row.extend(color.to_array());
            };
            columns.push((COLOR, Box::new(write), 4));
        }
        if let (Ok(VertexAttributeValues::Uint16x4(joints)), Ok(VertexAttributeValues::Float32x4(weights))) = (
            mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_INDEX),
            mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT),
        ) {
            let write = |vertex: usize, row: &mut Vec<f32>| row.extend(projected(joints[vertex], weights[vertex]));
            columns.push((SKIN, Box::new(write), SKIN_DIMENSIONS));
        }
        if let Ok(displacements) = mesh.try_morph_targets()
            && let vertices = mesh.count_vertices()
            && vertices > 0
            && displacements.len() >= vertices
            && extent > 0.0
        {
            let targets = displacements.len() / vertices;
            let kept = targets.min(MORPH_TARGETS);
            let write = move |vertex: usize, row: &mut Vec<f32>| {
                let start = row.len();
                row.resize(start + 3 * kept, 0.0);
                for target in 0..targets {
                    let moved = (displacements[target * vertices + vertex].position / extent).extend(0.0);
                    let moved = finite(moved.to_array()).to_array();
                    for (sum, moved) in row[start + 3 * (target % kept)..].iter_mut().zip(&moved[..3]) {
                        *sum += moved;
                    }
                }
            };
            columns.push((MORPH, Box::new(write), 3 * kept));
        }

        let mut values = Vec::new();
        for &number in numbers {
            for (_, write, _) in &columns {
                write(number as usize, &mut values);
            }
        }
        let of_column = |&(weight, _, width): &(f32, _, usize)| std::iter::repeat_n(weight, width);
        Self {
            values,
            weights: columns.iter().flat_map(of_column).collect(),
        }
    }
}

/// The weights of all joints, as few numbers: the further apart these are, the further apart are those (Johnson and
/// Lindenstrauss, *Extensions of Lipschitz mappings into a Hilbert space*, 1984). What is interpolated between joints
/// is interpolated in them, too.
fn projected(joints: [u16; 4], weights: [f32; 4]) -> [f32; SKIN_DIMENSIONS] {
    let mut sum = [0.0; SKIN_DIMENSIONS];
    for (joint, weight) in joints.into_iter().zip(finite(weights).to_array()) {
        for (sum, along) in sum.iter_mut().zip(direction(joint)) {
            *sum += along * weight.clamp(0.0, 1.0);
        }
    }
    sum
}

/// A direction for each joint that looks random: splitmix64 (Steele, Lea and Flood, 2014).
fn direction(joint: u16) -> [f32; SKIN_DIMENSIONS] {
    let mut bits = (u64::from(joint) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^= bits >> 31;
    std::array::from_fn(|dimension| f32::from((bits >> (16 * dimension)) as u16) / f32::from(u16::MAX) - 0.5)
}
