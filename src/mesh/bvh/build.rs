//! How a hierarchy is built.

use super::{LEAF_SIZE, MeshBvh, pack_slots};
use crate::{
    mesh::triangles::TriangleMesh,
    spatial::{
        BuildStrategy,
        build::{BuildItem, Builder},
        simd::with_huge_pages,
        wide::{Child, EVERY_MASK, PackedChild, WideNode},
    },
};

impl MeshBvh {
    /// Builds the hierarchy top down by the binned surface area heuristic, in O(n log n).
    pub fn build(mesh: &TriangleMesh) -> Self {
        let mut items: Vec<BuildItem> = mesh
            .slots()
            .map(|slot| BuildItem::new(&mesh.triangle_box(slot), EVERY_MASK, slot))
            .collect();
        let mut nodes = Vec::new();
        // A leaf is a range of the items at first.
        Builder::default().build(
            BuildStrategy::BinnedSah,
            LEAF_SIZE,
            &mut items,
            &mut nodes,
            |items, first, _, _| pack_slots(first as u32, items.len() as u32),
            |_, _, _| {},
        );
        Self::pack(mesh, &items, &nodes)
    }

    /// Packs the triangles, `items` by their slots in `mesh`, in the order of the nodes and lanes that have them: what a
    /// ray visits one after the other lies side by side.
    fn pack(mesh: &TriangleMesh, items: &[BuildItem], built: &[WideNode]) -> Self {
        let leaves = built.iter().flat_map(|node| &node.children);
        let mut packets = with_huge_pages(leaves.filter(|child| child.leaf().is_some()).count());
        let mut nodes = with_huge_pages(built.len());
        nodes.extend_from_slice(built);
        for child in nodes.iter_mut().flat_map(|node: &mut WideNode| &mut node.children) {
            if let Some(leaf) = child.leaf() {
                let (first, count) = ((leaf >> 3) as usize, (leaf & 7) as usize + 1);
                *child = PackedChild::pack(Child::Leaf(pack_slots(packets.len() as u32, count as u32)));
                packets.push(mesh.gather(items[first..first + count].iter().map(BuildItem::index)));
            }
        }
        Self {
            nodes,
            mesh: mesh.repacked(packets),
        }
    }
}
