//! How triangles are packed in the order of a hierarchy.

use super::{MeshBvh, pack_slots, unpack_range};
use crate::{
    mesh::triangles::TriangleMesh,
    spatial::{
        simd::with_huge_pages,
        wide::{Child, PackedChild, WideNode},
    },
};

impl MeshBvh {
    /// A hierarchy of `built` nodes, whose leaves are [ranges](pack_range) of `slots` of `mesh`. The triangles are packed in
    /// the order of the nodes and lanes that have them: what a ray visits one after the other lies side by side.
    pub(in crate::mesh) fn pack(mesh: &TriangleMesh, slots: &[u32], built: &[WideNode]) -> Self {
        let leaves = built.iter().flat_map(|node| &node.children);
        let mut packets = with_huge_pages(leaves.filter(|child| child.leaf().is_some()).count());
        let mut nodes = with_huge_pages(built.len());
        nodes.extend_from_slice(built);
        for child in nodes.iter_mut().flat_map(|node: &mut WideNode| &mut node.children) {
            if let Some(leaf) = child.leaf() {
                let range = unpack_range(leaf);
                *child = PackedChild::pack(Child::Leaf(pack_slots(packets.len() as u32, range.len() as u32)));
                packets.push(mesh.gather(slots[range].iter().copied()));
            }
        }
        Self {
            nodes,
            mesh: mesh.repacked(packets),
        }
    }
}
