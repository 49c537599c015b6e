//! Exact hits on triangle meshes: their triangles, and a bounding volume hierarchy over them.
//!
//! Knows Bevy's [`Mesh`](bevy::mesh::Mesh) and nothing else of Bevy. Everything is in the local space of the mesh.

pub mod bvh;
pub mod mesh_mesh;
mod packet;
pub mod triangles;

pub use bvh::MeshBvh;
pub use mesh_mesh::{PlacedMesh, TrianglePair};
pub use triangles::{HULL_CORNERS, TriangleHit, TriangleMesh, UnusableMesh};
