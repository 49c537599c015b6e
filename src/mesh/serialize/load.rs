//! From bytes to a hierarchy. Nothing in the bytes is trusted.

use super::{
    CHECKSUM, EMPTY_LANE, HEADER, Header, Lanes, MAGIC, NODE_LANE, UnreadableBvh, VERSION, fingerprint::fingerprint,
};
use crate::{
    geometry::aabb::EMPTY,
    mesh::{
        MeshBvh, TriangleMesh,
        bvh::{LEAF_SIZE, pack_leaf},
    },
    spatial::wide::{Child, EVERY_MASK, LANES, WideNode},
};

impl MeshBvh {
    /// The hierarchy over `mesh` that [`to_bytes`](Self::to_bytes) made the bytes of, in O(n), and many times sooner than
    /// it is built.
    ///
    /// The mesh must have the same triangles, bit for bit. Whatever the bytes are, the hierarchy gives the same answers as
    /// one that was built, though perhaps not as fast.
    ///
    /// # Errors
    ///
    /// If the bytes are damaged, of another version, of another mesh, or something else altogether.
    pub fn from_bytes(bytes: &[u8], mesh: &TriangleMesh) -> Result<Self, UnreadableBvh> {
        let (header, body) = Header::read(bytes)?;
        if header.triangles as usize != mesh.len() || header.fingerprint != fingerprint(mesh) {
            return Err(UnreadableBvh::OtherMesh);
        }
        let (nodes, numbers) = body.split_at(header.nodes as usize * LANES);
        let nodes = read_nodes(nodes.as_chunks().0, header.triangles)?;
        let mut taken = vec![false; mesh.vertices().len()];
        let mut take = |number: u32| {
            let slot = mesh.slot_of(number)?;
            (!std::mem::replace(&mut taken[number as usize], true)).then_some(slot)
        };
        let order: Option<Vec<u32>> = (numbers.as_chunks().0.iter())
            .map(|&number| take(u32::from_le_bytes(number)))
            .collect();
        let order = order.ok_or(UnreadableBvh::Malformed)?;
        let mut bvh = Self::pack(mesh, &order, &nodes, false);
        bvh.refit(&mesh.positions());
        Ok(bvh)
    }
}

impl Header {
    /// The header and what is between it and the checksum, which is as long as the header says.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), UnreadableBvh> {
        if !bytes.starts_with(&MAGIC) {
            return Err(UnreadableBvh::NotABvh);
        }
        let wrong_length = |expected: u64| UnreadableBvh::Length {
            found: bytes.len() as u64,
            expected,
        };
        let (header, body) = bytes.split_at_checked(HEADER).ok_or(wrong_length(HEADER as u64))?;
        let number = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        if number(8) != VERSION {
            return Err(UnreadableBvh::Version { found: number(8) });
        }
        let header = Self {
            fingerprint: number(12),
            triangles: number(16),
            nodes: number(20),
        };
        let [triangles, nodes] = [header.triangles, header.nodes].map(u64::from);
        let expected = (HEADER + CHECKSUM) as u64 + nodes * LANES as u64 + triangles * size_of::<u32>() as u64;
        let body = (bytes.len() as u64 == expected).then(|| body.split_at(body.len() - CHECKSUM));
        let (body, checksum) = body.ok_or(wrong_length(expected))?;
        if crc32fast::hash(&bytes[..bytes.len() - CHECKSUM]).to_le_bytes() != *checksum {
            return Err(UnreadableBvh::Checksum);
        }
        Ok((header, body))
    }
}

/// The tree of these nodes, without boxes, over as many triangles.
fn read_nodes(file: &[Lanes], triangles: u32) -> Result<Vec<WideNode>, UnreadableBvh> {
    enum Below {
        Node(u32),
        Leaf { node: u32, lane: usize, len: u32 },
    }
    // With two children or more in every node there are fewer nodes than leaves: so much, and no more, is allocated.
    if file.len() > triangles as usize {
        return Err(UnreadableBvh::Malformed);
    }
    let mut nodes = vec![WideNode::EMPTY; file.len()];
    let (mut next_node, mut next_slot) = (1, 0);
    let mut stack = vec![Below::Node(0)];
    while let Some(below) = stack.pop() {
        let index = match below {
            Below::Node(index) => index,
            Below::Leaf { node, lane, len } => {
                if len > triangles - next_slot {
                    return Err(UnreadableBvh::Malformed);
                }
                let leaf = Child::Leaf(pack_leaf(next_slot, len));
                nodes[node as usize].set(lane, &EMPTY, EVERY_MASK, leaf);
                next_slot += len;
                continue;
            }
        };
        let lanes = used_lanes(file.get(index as usize).ok_or(UnreadableBvh::Malformed)?)?;
        let is_root_with_leaf = index == 0 && matches!(lanes, [kind] if *kind != NODE_LANE);
        if lanes.len() < 2 && !is_root_with_leaf {
            return Err(UnreadableBvh::Malformed);
        }
        let first = stack.len();
        for (lane, &kind) in lanes.iter().enumerate() {
            stack.push(if kind == NODE_LANE {
                nodes[index as usize].set(lane, &EMPTY, EVERY_MASK, Child::Node(next_node));
                next_node += 1;
                Below::Node(next_node - 1)
            } else {
                let len = u32::from(kind);
                Below::Leaf { node: index, lane, len }
            });
        }
        stack[first..].reverse();
    }
    if next_node as usize == file.len() && next_slot == triangles {
        Ok(nodes)
    } else {
        Err(UnreadableBvh::Malformed)
    }
}

/// The lanes that are not empty, if they are the first ones and each holds what a lane can hold.
fn used_lanes(lanes: &Lanes) -> Result<&[u8], UnreadableBvh> {
    let len = lanes
        .iter()
        .rposition(|&kind| kind != EMPTY_LANE)
        .map_or(0, |last| last + 1);
    let is_sound = |&kind: &u8| kind == NODE_LANE || (1..=LEAF_SIZE).contains(&usize::from(kind));
    let used = &lanes[..len];
    if used.iter().all(is_sound) {
        Ok(used)
    } else {
        Err(UnreadableBvh::Malformed)
    }
}
