//! The pure geometry layer.

mod aabb;
mod analytic_surfaces;
mod bounding_sphere;
mod closest_point;
mod convex_hull;
mod intersection;
mod obb;
mod primitive_bounds;
mod rays_and_boxes;
mod shapes;
mod surfaces;
mod sweep;
mod tightness;
mod triangle_triangle;
mod triangle_triangle_oracle;
mod volume;
