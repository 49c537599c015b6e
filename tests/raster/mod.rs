//! The masked depth buffer.

mod scene;
mod specification;
mod strict;
