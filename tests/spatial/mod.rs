//! The structures of the spatial layer.

mod aabb_tree;
mod differential;
mod kd_tree;
mod octree;
mod trace;
mod uniform_grid;
