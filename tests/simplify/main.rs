//! Proxies that are made of meshes.

mod auto_proxy;
mod chain;
mod clusters;
#[path = "../common/mod.rs"]
#[expect(dead_code, reason = "it is for all tests")]
mod common;
mod deviation;
mod merge;
mod meshes;
mod models;
mod silhouettes;
