//! Several placed meshes as one.

use bevy::{
    asset::RenderAssetUsages,
    math::{Affine3A, Mat3A, Vec3},
    mesh::{Indices, Mesh, MeshVertexAttribute, MeshVertexAttributeId, PrimitiveTopology, VertexAttributeValues},
    platform::collections::HashSet,
};

use super::{
    SimplifyError,
    simplifier::with_triangles,
    source::{attributes, unit},
};
use crate::mesh::TriangleMesh;

/// Merges meshes, each with its place, into one triangle list.
///
/// Normals and tangents turn with their meshes, and what is mirrored is turned inside out, so that its outside stays
/// outside. The vertex attributes that all parts have survive; of a part without normals they are computed, without
/// texture coordinates they are zero, and without vertex colours white, if any other part has them. Parts that have no
/// surface, and triangles that are [unusable](TriangleMesh::from_mesh) or come to lie at infinity, are left out.
///
/// # Errors
///
/// If no part has a surface, and if vertex attributes differ in length or format, or have one that
/// [cannot be merged](Mesh::merge).
pub fn merge_meshes<'a>(parts: impl IntoIterator<Item = (&'a Mesh, Affine3A)>) -> Result<Mesh, SimplifyError> {
    let mut placed = Vec::new();
    let mut unusable = None;
    for (mesh, place) in parts {
        match listed(mesh) {
            Ok(mesh) => placed.push(transformed(mesh, &place)),
            Err(SimplifyError::Unusable(why)) => unusable = Some(why),
            Err(why) => return Err(why),
        }
    }
    let kept = common(&mut placed);
    let mut placed = placed.into_iter().map(|mesh| only(mesh, &kept));
    let Some(mut merged) = placed.next() else {
        return Err(unusable.unwrap_or(crate::mesh::UnusableMesh::NoTriangles).into());
    };
    for mesh in placed {
        merged.merge(&mesh).map_err(|_| SimplifyError::Unmergeable)?;
    }
    Ok(merged)
}

/// The usable triangles of a mesh as a list with 32-bit indices.
fn listed(mesh: &Mesh) -> Result<Mesh, SimplifyError> {
    let triangles = TriangleMesh::from_mesh(mesh)?;
    let vertices = triangles.vertex_count();
    for (attribute, values) in attributes(mesh) {
        if values.len() != vertices {
            return Err(SimplifyError::UnevenAttribute {
                name: attribute.name,
                values: values.len(),
                vertices,
            });
        }
    }
    let mut plain = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    for (attribute, values) in attributes(mesh) {
        plain.insert_attribute(*attribute, values.clone());
    }
    let mut listed = with_triangles(&plain, triangles.vertices_of_all().flatten().collect());
    let wide = listed
        .indices()
        .map(|indices| indices.iter().map(|index| index as u32).collect());
    listed.insert_indices(Indices::U32(wide.unwrap_or_default()));
    Ok(listed)
}

/// Moves a mesh.
fn transformed(mut mesh: Mesh, place: &Affine3A) -> Mesh {
    let normals = of_normals(&place.matrix3);
    let is_mirrored = place.matrix3.determinant() < 0.0;
    if let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        for position in positions {
            *position = place.transform_point3(Vec3::from(*position)).to_array();
        }
    }
    if let Some(VertexAttributeValues::Float32x3(values)) = mesh.attribute_mut(Mesh::ATTRIBUTE_NORMAL) {
        for normal in values {
            *normal = unit((normals * Vec3::from(*normal)).to_array()).to_array();
        }
    }
    if let Some(VertexAttributeValues::Float32x4(tangents)) = mesh.attribute_mut(Mesh::ATTRIBUTE_TANGENT) {
        for [x, y, z, side] in tangents {
            [*x, *y, *z] = unit((place.matrix3 * Vec3::new(*x, *y, *z)).to_array()).to_array();
            if is_mirrored {
                *side = -*side;
            }
        }
    }
    if is_mirrored && let Some(Indices::U32(indices)) = mesh.indices_mut() {
        for triangle in indices.as_chunks_mut::<3>().0 {
            triangle.swap(1, 2);
        }
    }
    mesh
}

/// What normals are turned by: the cofactors, which are the inverse transpose but for its length, and there where there
/// is no inverse. Mirrored with the surface.
fn of_normals(matrix: &Mat3A) -> Mat3A {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let cofactors = Mat3A::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if matrix.determinant() < 0.0 {
        cofactors * -1.0
    } else {
        cofactors
    }
}

/// Gives parts what others have and they need, and returns what all have then.
fn common(parts: &mut [Mesh]) -> HashSet<MeshVertexAttributeId> {
    let any_has =
        |parts: &[Mesh], attribute: MeshVertexAttribute| parts.iter().any(|part| part.contains_attribute(attribute));
    let normals = any_has(parts, Mesh::ATTRIBUTE_NORMAL);
    let filled = [
        (Mesh::ATTRIBUTE_UV_0, any_has(parts, Mesh::ATTRIBUTE_UV_0)),
        (Mesh::ATTRIBUTE_COLOR, any_has(parts, Mesh::ATTRIBUTE_COLOR)),
    ];
    for part in parts.iter_mut() {
        if normals && !part.contains_attribute(Mesh::ATTRIBUTE_NORMAL) {
            part.compute_normals();
        }
        let vertices = part.count_vertices();
        for (attribute, is_wanted) in filled {
            if is_wanted && !part.contains_attribute(attribute) {
                let values = if attribute.id == Mesh::ATTRIBUTE_COLOR.id {
                    VertexAttributeValues::Float32x4(vec![[1.0; 4]; vertices])
                } else {
                    VertexAttributeValues::Float32x2(vec![[0.0; 2]; vertices])
                };
                part.insert_attribute(attribute, values);
            }
        }
    }
    let of_part = |part: &Mesh| {
        attributes(part)
            .map(|(attribute, _)| attribute.id)
            .collect::<HashSet<_>>()
    };
    let mut all = parts.iter().map(of_part);
    let first = all.next().unwrap_or_default();
    all.fold(first, |common, of_part| {
        common.intersection(&of_part).copied().collect()
    })
}

/// A mesh with some of its attributes.
fn only(mut mesh: Mesh, kept: &HashSet<MeshVertexAttributeId>) -> Mesh {
    let others: Vec<_> = attributes(&mesh)
        .map(|(attribute, _)| attribute.id)
        .filter(|id| !kept.contains(id))
        .collect();
    for id in others {
        mesh.remove_attribute(id);
    }
    mesh
}
