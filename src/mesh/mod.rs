//! Exact hits on triangle meshes: their triangles, and a bounding volume hierarchy over them.
//!
//! Knows Bevy's [`Mesh`](bevy::mesh::Mesh) and nothing else of Bevy. Everything is in the local space of the mesh.

pub mod build;
pub mod bvh;
pub mod inner_boxes;
pub mod mesh_mesh;
mod packet;
pub mod pose;
pub mod queries;
pub mod serialize;
pub mod triangles;
mod validate;

pub use build::MeshBuildSettings;
pub use bvh::MeshBvh;
pub use inner_boxes::{InnerBoxSettings, InnerBoxes, NotSolid};
pub use mesh_mesh::{PlacedMesh, TrianglePair};
pub use pose::{MeshDeformer, Pose, PosedMesh};
pub use queries::{SphereContact, SurfacePoint, TriangleRegion};
pub use serialize::UnreadableBvh;
pub(crate) use triangles::MeshEdit;
pub use triangles::{HULL_CORNERS, TriangleHit, TriangleMesh, UnusableMesh};
pub use validate::BrokenMeshBvh;
