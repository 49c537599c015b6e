//! A depth buffer on the CPU that answers one question: is a box hidden behind what has been drawn?
//!
//! The buffer is masked (Hasselgren, Andersson and Akenine-Möller, *Masked Software Occlusion Culling*, 2016): instead of
//! a depth for each pixel it keeps, for each block of 8×4 pixels, the farthest depth of all of them, and two more for those
//! that masks of 32 bits name. Eight blocks make a tile of 32×8 pixels, which is drawn and tested at once.
//!
//! # Conventions
//!
//! - **Clip space** is as Bevy's cameras have it: `x` to the right, `y` up, both in `-w..=w` within the view.
//! - **Depth** is `z / w`, larger is nearer: 1 at the near plane, 0 at the far plane or infinitely far, which Bevy calls
//!   reversed. It is linear on the screen on every plane, with perspective and without. What is nearer than the near
//!   plane (`z > w`) is cut away.
//! - **Pixels** are counted from the upper left; pixel `(i, j)` covers `i..i + 1` by `j..j + 1`.
//! - **Matrices** that draw are `f64`: the product of a camera's and an entity's loses what a game can see if it is made
//!   with `f32` far from the origin.
//!
//! # Two modes
//!
//! [`RasterMode::Strict`] never hides what can be seen: a pixel counts as covered if all of it is, each block is as far as
//! the farthest that covers any of it, and every rounding errs to the side of the seen. Convex boxes are drawn by their
//! outline, moved inward. The triangles of a mesh are drawn together, part by part: a pixel whose centre is in their picture,
//! and that no edge of its outline touches, is covered whole, for the boundary of a picture is its outline.
//!
//! [`RasterMode::Fast`] takes a pixel as covered if its centre is, as a renderer does. Through gaps between centres more
//! can be seen than it tells.
//!
//! # Example
//!
//! ```
//! use bevy::math::{DMat4, Mat4, UVec2, Vec3, Vec3A, bounding::Aabb3d};
//! use bevy_sightline::raster::{MaskedDepthBuffer, RasterMode};
//!
//! let clip_from_world = Mat4::perspective_infinite_reverse_rh(1.0, 16.0 / 9.0, 0.1);
//! let mut buffer = MaskedDepthBuffer::new(UVec2::new(1024, 512), RasterMode::Strict);
//! let wall = Aabb3d::new(Vec3A::new(0.0, 0.0, -10.0), Vec3A::new(4.0, 3.0, 0.5));
//! buffer.draw_box(&wall, &clip_from_world.as_dmat4());
//!
//! let crate_behind = Aabb3d::new(Vec3A::new(1.0, 0.0, -20.0), Vec3A::splat(0.5));
//! assert!(!buffer.is_aabb_visible(&crate_behind, &clip_from_world));
//! assert!(buffer.is_aabb_visible(&wall, &clip_from_world));
//! ```

mod batch;
mod buffer;
mod canvas;
mod clip;
mod cuboid;
mod fill;
mod image;
mod mesh;
mod outline;
mod plane;
mod query;
#[cfg(test)]
mod tests;
mod tile;
mod triangles;

pub use buffer::{Faces, MaskedDepthBuffer, RasterMode};
pub use mesh::OccluderMesh;
pub(crate) use query::PixelRect;
pub use query::ScreenRect;
