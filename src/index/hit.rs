//! What a ray cast tells of a hit.

use bevy::{
    ecs::entity::Entity,
    math::{Vec2, Vec3},
};

/// A hit of a ray on an entity, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayHit {
    /// The entity that was hit.
    pub entity: Entity,
    /// The distance from the origin of the ray.
    pub distance: f32,
    /// The point that was hit.
    pub position: Vec3,
    /// The unit normal of the surface, on its front side: interpolated from the vertex normals where the mesh has
    /// any, else that of the triangle. Right under every transform, also mirrored and non-uniformly scaled ones.
    pub normal: Vec3,
    /// The triangle that was hit, if the surface is a mesh.
    pub triangle: Option<HitTriangle>,
    /// The texture coordinates (`UV_0`) at the hit, if the mesh has any.
    pub uv: Option<Vec2>,
}

/// The triangle that a ray has hit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HitTriangle {
    /// Its number in the mesh: in a list a third of the position of its first index, in a strip that position.
    pub index: u32,
    /// Its vertices in world space, in the order of the mesh.
    pub vertices: [Vec3; 3],
    /// The weights of the vertices at the hit: the hit is at their weighted sum.
    pub barycentrics: Vec3,
}
