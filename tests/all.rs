//! All integration tests, in one binary: one module for each behaviour.

mod bounded_by;
mod boxes;
mod common;
mod differential;
mod geometry;
mod layering;
mod mesh;
mod mesh_build;
mod mesh_contacts;
mod pick_shape;
mod picking;
mod properties;
mod regressions;
mod scene_query;
mod spatial;
mod sync;
