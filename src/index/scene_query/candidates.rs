//! What layers above ask of entities one by one: where they are, and what their surfaces are made of.

use bevy::{
    ecs::entity::Entity,
    math::{Affine3A, Vec3A, bounding::Aabb3d},
};

use super::SceneQuery;
use crate::{
    geometry::surface::Surface,
    index::{SceneQuerySettings, spatial_index::Key, surface::Shape, triangles::TrianglesRef},
    spatial::traverse::{Descent, Part},
};

/// An entity of which some part may be in a region.
pub(crate) struct Candidate<'a, 'w, 's> {
    scene: &'a SceneQuery<'w, 's>,
    key: Key,
}

/// What rays hit on an entity.
pub(crate) enum CandidateSurface<'a> {
    Triangles(CandidateTriangles<'a>),
    Shape(&'a dyn Surface),
}

/// The triangles that rays hit on an entity, posed if it is.
pub(crate) struct CandidateTriangles<'a>(TrianglesRef<'a>);

impl SceneQuery<'_, '_> {
    /// The entities that the settings accept and that are in a region, in ascending order, written over `entities`: those
    /// whose world box is wholly inside, as `part_of` says, and of those of whose box some may be, those that `is_inside`
    /// says. `part_of` must say that all of a box is inside only where it would say so of every box in that.
    pub(crate) fn select(
        &self,
        settings: &SceneQuerySettings,
        part_of: impl FnMut(&Aabb3d) -> Part,
        mut is_inside: impl FnMut(&Candidate) -> bool,
        entities: &mut Vec<Entity>,
    ) {
        entities.clear();
        self.tree(settings).visit_parts(part_of, |key, part| {
            let is_selected = self.admit(key, settings)
                && (part == Part::All || is_inside(&Candidate { scene: self, key }))
                && self.confirm(key.entity, settings);
            entities.extend(is_selected.then_some(key.entity));
        });
        entities.sort_unstable();
    }
}

impl<'a> Candidate<'a, '_, '_> {
    /// Its world box.
    pub fn aabb(&self) -> Option<Aabb3d> {
        self.scene.index.aabb(self.key.entity)
    }

    /// What rays hit on it, with where that is; `None` if there is nothing, or it is not loaded.
    pub fn surface(&self) -> Option<(CandidateSurface<'a>, Affine3A)> {
        let scene = self.scene;
        let placed = scene.index.surface(self.key.slot)?;
        let triangles = |mesh| {
            let triangles = scene.tested(placed, scene.meshes.used_slot(mesh)?)?;
            Some(CandidateSurface::Triangles(CandidateTriangles(triangles)))
        };
        let surface = match placed.shape {
            Shape::Mesh(mesh, _) => triangles(mesh)?,
            Shape::Volume(mesh, kind) => match scene.meshes.slot(mesh)?.surface(kind) {
                Some(volume) => CandidateSurface::Shape(volume),
                None => triangles(mesh)?,
            },
            Shape::Analytic(ref shape) => CandidateSurface::Shape(shape.surface()),
        };
        Some((surface, placed.world_from_local()))
    }
}

impl CandidateTriangles<'_> {
    /// Goes down the hierarchy, if there is one yet, as `visit_box` says of each box, and asks `visit_triangle` about the
    /// corners of each triangle that it comes to. In the space of the mesh.
    pub fn descend(
        &self,
        visit_box: impl FnMut(&Aabb3d) -> Descent,
        visit_triangle: impl FnMut([Vec3A; 3]) -> Descent,
    ) {
        match self.0 {
            TrianglesRef::Listed(mesh) => mesh.descend(visit_box, visit_triangle),
            TrianglesRef::Hierarchy(bvh) => bvh.descend(visit_box, visit_triangle),
        }
    }
}
