//! What the walker sees, and what is hidden from it.

use bevy::{
    camera::{
        primitives::{Aabb, Frustum},
        visibility::{RenderLayers, VisibilitySystems},
    },
    mesh::mark_3d_meshes_as_changed_if_their_assets_changed,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::walk::Walker;

/// What the walker sees and what it does not, of all that has a mesh, as of this frame.
#[derive(Resource, Clone, Default)]
pub struct Sight {
    /// In ascending order.
    pub seen: Vec<Entity>,
    /// Within the frustum, and behind something. In ascending order.
    pub hidden: Vec<Entity>,
}

/// When [`Sight`] is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub struct Look;

pub fn plugin(app: &mut App) {
    app.init_resource::<Sight>()
        .configure_sets(
            PostUpdate,
            Look.after(VisibilitySystems::CheckVisibility)
                // Materials that change now are drawn in this frame.
                .before(mark_3d_meshes_as_changed_if_their_assets_changed),
        )
        .add_systems(PostUpdate, look.in_set(Look));
}

/// Finds what the walker sees, and asks the index what else there is in its frustum.
pub fn look(
    walker: Single<(&VisibleSet, &Frustum, Option<&RenderLayers>), With<Walker>>,
    scene: SceneQuery,
    meshes: Query<(&Aabb, &GlobalTransform), With<Mesh3d>>,
    mut sight: ResMut<Sight>,
    mut in_frustum: Local<Vec<Entity>>,
) {
    let (visible, frustum, layers) = *walker;
    let mut settings = SceneQuerySettings::default();
    if let Some(layers) = layers {
        settings = settings.with_layers(layers);
    }
    scene.overlap_frustum(frustum, &settings, &mut in_frustum);
    let Sight { seen, hidden } = &mut *sight;
    seen.clear();
    seen.extend(visible.entities().iter().filter(|&&entity| meshes.contains(entity)));
    hidden.clear();
    // The index has world boxes: Bevy culls by those that turn with their entities.
    let is_in_frustum = |entity| {
        let found = meshes.get(entity);
        found.is_ok_and(|(aabb, place)| frustum.intersects_obb(aabb, &place.affine(), true, false))
    };
    hidden.extend(
        in_frustum
            .iter()
            .filter(|&&entity| !visible.contains(entity) && is_in_frustum(entity)),
    );
}
