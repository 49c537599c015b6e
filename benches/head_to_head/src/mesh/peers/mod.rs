//! The peers, each with the best that a user in a default build can make of it.

pub(crate) mod bvh;
pub(crate) mod obvhs;
pub(crate) mod parry;
