//! All integration tests, in one binary: one module for each behaviour.

mod aabb_tree;
mod common;
mod differential;
mod geometry;
mod layering;
mod mesh;
mod picking;
mod regressions;
mod scene_query;
mod sync;
