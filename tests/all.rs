//! All integration tests, in one binary: one module for each behaviour.

mod bounded_by;
mod boxes;
mod common;
mod culling;
mod differential;
mod edge;
mod geometry;
#[cfg(feature = "gizmos")]
mod gizmos;
mod guides;
mod inner_boxes;
mod layering;
mod line_of_sight;
mod lod;
mod mesh;
mod mesh_assets;
mod mesh_batches;
mod mesh_build;
mod mesh_contacts;
mod mesh_queries;
mod mesh_serialize;
mod occlusion;
mod pick_shape;
mod picking;
mod properties;
mod query_modes;
mod raster;
mod ray_trace;
mod regressions;
mod scene_query;
mod selection;
mod skinned_picking;
mod spatial;
mod sync;
mod watertight;
