//! Hierarchies in files.
//!
//! What is saved is what takes long to find: how the triangles are grouped. The triangles are those of the mesh, and the
//! boxes follow from them. All numbers are little endian:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `SIGHTBVH` |
//! | 4 | the version of the format, [`VERSION`] |
//! | 4 | the fingerprint of the mesh: a CRC-32 of its triangles, number and corners, in the order of their numbers |
//! | 4 | the number of triangles, `t` |
//! | 4 | the number of nodes, `n` |
//! | 8 `n` | the lanes of every node: 0 if empty, 1 to 8 for a leaf with as many triangles, 255 for a node |
//! | 4 `t` | the numbers of the triangles, leaf by leaf |
//! | 4 | a CRC-32 of all that is before |
//!
//! Nodes and leaves come in one order, from which follows which is meant: the children of a node stand side by side, and
//! behind them comes all that is below the first; leaves are met going down lane by lane. So no file can describe a cycle, a
//! child that is not there, leaves that overlap, or a box that is wrong: whatever passes is a hierarchy of the mesh, and
//! every such hierarchy gives the right answers.

mod fingerprint;
mod load;
mod save;

/// The version of the format that this crate writes, and the only one that it reads: a file of another is to be built
/// again.
pub const VERSION: u32 = 1;

/// Why the bytes are not a hierarchy of the mesh: it must be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum UnreadableBvh {
    /// It is something else.
    #[error("it does not begin as a saved hierarchy does")]
    NotABvh,
    /// It is of another version of this crate.
    #[error("its format has version {found}, not {VERSION}")]
    Version {
        /// The version that it has.
        found: u32,
    },
    /// Something is missing, or there is too much.
    #[error("it has {found} bytes, not {expected}")]
    Length {
        /// How long it is.
        found: u64,
        /// How long it should be by what it says of itself; for less than a header, the length of that.
        expected: u64,
    },
    /// It was damaged.
    #[error("its checksum does not match")]
    Checksum,
    /// It belongs to another mesh, or the mesh has changed.
    #[error("it was saved for another mesh")]
    OtherMesh,
    /// Its checksum matches, and yet no program of this crate wrote it.
    #[error("it does not describe a hierarchy over the triangles of the mesh")]
    Malformed,
}

const MAGIC: [u8; 8] = *b"SIGHTBVH";

/// The first bytes of every file.
#[derive(Clone, Copy, Debug)]
struct Header {
    fingerprint: u32,
    triangles: u32,
    nodes: u32,
}

/// The bytes of the header, and of the checksum.
const HEADER: usize = 24;
const CHECKSUM: usize = 4;

/// What is in the lanes of a node.
type Lanes = [u8; crate::spatial::wide::LANES];

/// Of a lane: nothing, or a node. Between the two, a leaf with so many triangles.
const EMPTY_LANE: u8 = 0;
const NODE_LANE: u8 = u8::MAX;
