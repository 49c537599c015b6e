//! Which meshes of the world touch, and where.

use std::ops::ControlFlow;

use bevy::ecs::entity::Entity;

use super::SceneQuery;
use crate::{
    geometry::triangle_triangle::TriangleContact, index::SceneQuerySettings, mesh::PlacedMesh, spatial::SpatialQueries,
};

/// Two triangles of two entities that touch.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshContact {
    /// Their numbers in the meshes of the first and of the second entity.
    pub triangles: [u32; 2],
    /// Where they touch, in world space.
    pub contact: TriangleContact,
}

/// Mesh against mesh. Surfaces are compared, not solids: a mesh that floats inside another does not touch it. The mesh of
/// an entity is that which rays hit, or whose volume they hit: see [`crate::index`]; one without a mesh touches nothing. Every mesh touches itself.
impl SceneQuery<'_, '_> {
    /// Whether the meshes of two entities touch. Exact up to the rounding of their transforms: see
    /// [`PlacedMesh::visit_touching`].
    pub fn meshes_touch(&self, a: Entity, b: Entity) -> bool {
        let (Some(a), Some(b)) = (self.placed_mesh(a), self.placed_mesh(b)) else {
            return false;
        };
        a.intersects(&b)
    }

    /// Where the meshes of two entities touch, written over `contacts`: one contact for each pair of triangles that do,
    /// in ascending order of the triangles. Together the segments are the curve in which the two surfaces meet.
    pub fn mesh_contacts(&self, a: Entity, b: Entity, contacts: &mut Vec<MeshContact>) {
        contacts.clear();
        let (Some(a), Some(b)) = (self.placed_mesh(a), self.placed_mesh(b)) else {
            return;
        };
        a.visit_touching(&b, |pair| {
            contacts.push(MeshContact {
                triangles: pair.triangles,
                contact: pair.contact(),
            });
            ControlFlow::Continue(())
        });
        contacts.sort_unstable_by_key(|contact| contact.triangles);
    }

    /// All other entities whose mesh touches that of `entity`, in ascending order, written over `entities`.
    ///
    /// Only what is near is looked at: what the index finds in the world box of `entity`. `max_distance` and
    /// `backfaces` of the settings do not matter.
    pub fn touching_meshes(&self, entity: Entity, settings: &SceneQuerySettings, entities: &mut Vec<Entity>) {
        entities.clear();
        let (Some(mesh), Some(aabb)) = (self.placed_mesh(entity), self.index.aabb(entity)) else {
            return;
        };
        self.boxes(settings).visit_region(&aabb, |other| {
            let touches = |other| self.placed_mesh(other).is_some_and(|other| mesh.intersects(&other));
            if other != entity && touches(other) {
                entities.push(other);
            }
            ControlFlow::Continue(())
        });
        entities.sort_unstable();
    }

    /// The mesh of an entity in its place.
    fn placed_mesh(&self, entity: Entity) -> Option<PlacedMesh<'_>> {
        let surface = self.index.surface_of(entity).filter(|_| self.exists(entity))?;
        let mesh = self.meshes.used_slot(surface.mesh()?)?;
        Some(self.tested(surface, mesh)?.placed(surface.world_from_local()))
    }
}
