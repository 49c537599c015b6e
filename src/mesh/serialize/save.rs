//! From a hierarchy to bytes.

use super::{CHECKSUM, EMPTY_LANE, HEADER, Header, Lanes, MAGIC, NODE_LANE, VERSION, fingerprint::fingerprint};
use crate::{
    mesh::{MeshBvh, bvh::unpack_slots},
    spatial::wide::{Child, LANES, NodeIndex},
};

impl MeshBvh {
    /// The hierarchy as bytes, to be kept beside the mesh and read by [`from_bytes`](Self::from_bytes): some five bytes a
    /// triangle. The triangles themselves are not in it. In O(n).
    pub fn to_bytes(&self) -> Vec<u8> {
        let (nodes, slots) = self.in_order_of_file();
        let triangles = self.mesh();
        let header = Header {
            fingerprint: fingerprint(triangles),
            triangles: slots.len() as u32,
            nodes: nodes.len() as u32,
        };
        let length = HEADER + nodes.len() * LANES + slots.len() * size_of::<u32>() + CHECKSUM;
        let mut bytes = Vec::with_capacity(length);
        bytes.extend_from_slice(&MAGIC);
        for number in [VERSION, header.fingerprint, header.triangles, header.nodes] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes.extend(nodes.as_flattened());
        bytes.extend(slots.iter().flat_map(|&slot| triangles.number(slot).to_le_bytes()));
        bytes.extend_from_slice(&crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    /// The lanes of all nodes and the slots of all leaves, in the order in which they are saved.
    fn in_order_of_file(&self) -> (Vec<Lanes>, Vec<u32>) {
        enum Below {
            /// A node, and its place in the file.
            Node(NodeIndex, usize),
            Leaf(u32),
        }
        let mut file = vec![[EMPTY_LANE; LANES]; self.nodes().len()];
        let mut slots = Vec::with_capacity(self.mesh().len());
        let mut next = 1;
        let mut stack = vec![Below::Node(0, 0)];
        while let Some(below) = stack.pop() {
            let (node, place) = match below {
                Below::Node(node, place) => (node, place),
                Below::Leaf(leaf) => {
                    slots.extend(unpack_slots(leaf));
                    continue;
                }
            };
            let first = stack.len();
            for (lane, (_, child)) in self.nodes()[node as usize].lanes().enumerate() {
                let (kind, below) = match child {
                    Child::Node(child) => {
                        next += 1;
                        (NODE_LANE, Below::Node(child, next - 1))
                    }
                    Child::Leaf(leaf) => (unpack_slots(leaf).len() as u8, Below::Leaf(leaf)),
                };
                file[place][lane] = kind;
                stack.push(below);
            }
            // The first is to come first.
            stack[first..].reverse();
        }
        (file, slots)
    }
}
