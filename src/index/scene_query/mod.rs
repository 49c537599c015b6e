//! The system parameter through which a game asks the index.

mod boxes;
mod candidates;
mod mesh_contacts;
mod pattern;
mod rays;
mod sight;
mod trace;

pub use boxes::SweepHit;
pub(crate) use candidates::{Candidate, CandidateSurface, CandidateTriangles};
pub use mesh_contacts::MeshContact;

use bevy::{
    camera::visibility::{RenderLayers, ViewVisibility, VisibilityClass},
    ecs::{
        change_detection::Res,
        entity::Entity,
        query::Has,
        system::{Query, SystemParam},
    },
};

use super::{
    DetailLevel, MeshBvhs, PosedMeshes, QueryVisibility, SceneQuerySettings, SpatialIndex, mask, mesh_slot::MeshSlot,
    spatial_index::Key, surface::PlacedSurface, triangles::TrianglesRef, views::CameraViews,
};
use crate::{mesh::PosedMesh, spatial::aabb_tree::Masked};

/// Asks what a ray hits and what is where, in world space.
///
/// Answers from the [`SpatialIndex`] as of the last `PostUpdate`: what has moved since is found where it was, and what
/// has been despawned since is not found. Read-only, so that any number of systems may ask at the same time.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::prelude::*;
/// fn what_is_ahead(scene: SceneQuery, eye: Single<&GlobalTransform, With<Camera>>) {
///     let ray = Ray3d::new(eye.translation(), eye.forward());
///     if let Some(hit) = scene.cast_ray(ray, &SceneQuerySettings::default()) {
///         println!("{} is {} m ahead", hit.entity, hit.distance);
///     }
/// }
/// ```
#[derive(SystemParam)]
pub struct SceneQuery<'w, 's> {
    index: Res<'w, SpatialIndex>,
    meshes: Res<'w, MeshBvhs>,
    poses: Res<'w, PosedMeshes>,
    views: Res<'w, CameraViews>,
    /// Every entity that still exists and is not disabled.
    entities: Query<
        'w,
        's,
        (
            Option<&'static ViewVisibility>,
            Has<VisibilityClass>,
            Option<&'static DetailLevel>,
        ),
    >,
}

impl SceneQuery<'_, '_> {
    /// The index that is asked.
    pub fn index(&self) -> &SpatialIndex {
        &self.index
    }

    /// The meshes that are hit.
    pub fn meshes(&self) -> &MeshBvhs {
        &self.meshes
    }

    /// The skinned and morphed entities.
    pub fn poses(&self) -> &PosedMeshes {
        &self.poses
    }

    /// The mesh of a surface in its pose, if it is posed.
    fn posed(&self, surface: &PlacedSurface) -> Option<&PosedMesh> {
        let pose = surface.pose?;
        self.poses.posed(pose, self.meshes.used_slot(surface.mesh()?)?)
    }

    /// What rays are tested against of the mesh of a surface: in its pose, if it is posed.
    fn tested<'a>(&'a self, surface: &PlacedSurface, mesh: &'a MeshSlot) -> Option<TrianglesRef<'a>> {
        match surface.pose {
            Some(pose) => self.poses.posed(pose, mesh).map(TrianglesRef::of_posed),
            None => mesh.tested(),
        }
    }

    /// Whether an entity of the index still exists and is not disabled.
    fn exists(&self, entity: Entity) -> bool {
        self.entities.contains(entity)
    }

    /// The tree as far as the settings may accept what is in it.
    fn tree(&self, settings: &SceneQuerySettings) -> Masked<'_, Key> {
        self.index.tree().masked(mask::of_settings(settings))
    }

    /// The entity, if the settings accept it.
    fn accept(&self, key: Key, settings: &SceneQuerySettings) -> Option<Entity> {
        (self.admit(key, settings) && self.confirm(key.entity, settings)).then_some(key.entity)
    }

    /// Whether the settings admit an entity of the [`tree`](Self::tree), as far as the index knows. Its mask has decided
    /// about visibility, and about layers unless some are asked for: mostly there is nothing to look up.
    fn admit(&self, key: Key, settings: &SceneQuerySettings) -> bool {
        let on_layers = |layers: &RenderLayers| layers.intersects(&self.index.entry(key.slot).layers);
        settings.layers.is_none_or(on_layers) && !settings.excluded.contains(&key.entity)
    }

    /// Whether the settings admit the visibility of an entity: for those that do not come from the tree.
    fn admit_visibility(&self, key: Key, settings: &SceneQuerySettings) -> bool {
        let entry = self.index.entry(key.slot);
        entry.level != Some(DetailLevel::Coarser) && (settings.visibility == QueryVisibility::Any || entry.visible)
    }

    /// Whether the settings accept an entity that the index [admits](Self::admit): asks the world, and the user.
    fn confirm(&self, entity: Entity, settings: &SceneQuerySettings) -> bool {
        // Fails for what was despawned or disabled since the index was brought up to date.
        let Ok((view_visibility, is_drawn, level)) = self.entities.get(entity) else {
            return false;
        };
        // No view ever looks at what is not drawn, and what is finest is hit in place of what stands in for it.
        let in_view = settings.visibility != QueryVisibility::VisibleInView
            || !is_drawn
            || level == Some(&DetailLevel::Finest)
            || view_visibility.is_some_and(|view_visibility| view_visibility.get());
        in_view && settings.predicate.is_none_or(|predicate| predicate(entity))
    }
}
