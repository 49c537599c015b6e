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
#[path = "../readme/auto_proxy.rs"]
#[rustfmt::skip]
#[expect(dead_code, reason = "that it compiles is what it is for")]
mod readme_auto_proxy;
#[path = "../readme/cluster_proxy.rs"]
#[rustfmt::skip]
#[expect(dead_code, reason = "that it compiles is what it is for")]
mod readme_cluster_proxy;
mod silhouettes;
