//! How triangles are packed in the order of a hierarchy.

use super::{MeshBvh, pack_leaf, unpack_range};
use crate::{
    mesh::triangles::TriangleMesh,
    spatial::{
        simd::with_huge_pages,
        wide::{Child, PackedChild, WideNode},
    },
};

impl MeshBvh {
    /// A hierarchy of `built` nodes, whose leaves are [ranges](super::unpack_range) of `slots` of `mesh`. The triangles
    /// come in the order of the nodes and lanes that have them: what a ray visits one after the other lies side by side.
    pub(in crate::mesh) fn pack(mesh: &TriangleMesh, slots: &[u32], built: &[WideNode], compact: bool) -> Self {
        let mut nodes = with_huge_pages(built.len());
        nodes.extend_from_slice(built);
        let mut ranges = Vec::new();
        for child in nodes.iter_mut().flat_map(|node: &mut WideNode| &mut node.children) {
            if let Some(leaf) = child.leaf() {
                let range = unpack_range(leaf);
                *child = PackedChild::pack(Child::Leaf(pack_leaf(ranges.len() as u32, range.len() as u32)));
                ranges.push(range);
            }
        }
        let groups = ranges.into_iter().map(|range| slots[range].iter().copied());
        let mesh = if compact {
            mesh.indexed(groups)
        } else {
            let mut packets = with_huge_pages(groups.len());
            packets.extend(groups.map(|group| mesh.gather(group)));
            mesh.packed(packets)
        };
        Self { nodes, mesh }
    }
}
