//! All that can be drawn, and how it is switched.

use bevy::{
    camera::{primitives::Frustum, visibility::RenderLayers},
    camera_controller::free_camera::FreeCamera,
    prelude::*,
};
use bevy_sightline::{
    debug::gizmos::SightlineGizmoSystems,
    prelude::*,
    spatial::{KdTree, Octree, SpatialQueries, SpatialUpdates, kd_tree::SplitMethod},
};

use crate::options::Options;

/// The layer of all gizmos, which the free camera alone shows.
pub const MARKS: usize = 1;

/// Something that is drawn of the whole scene.
pub struct Kind {
    pub key: KeyCode,
    pub name: &'static str,
    /// Switches it on and off, or on to the next.
    pub switch: fn(&mut SightlineGizmos),
    pub count: fn(&SightlineGizmoStats) -> GizmoCount,
}

pub const KINDS: [Kind; 8] = [
    Kind {
        key: KeyCode::Digit1,
        name: "nodes",
        switch: |gizmos| gizmos.nodes ^= true,
        count: |stats| stats.nodes,
    },
    Kind {
        key: KeyCode::Digit2,
        name: "cells",
        switch: |gizmos| gizmos.cells ^= true,
        count: |stats| stats.cells,
    },
    Kind {
        key: KeyCode::Digit3,
        name: "leaves",
        switch: |gizmos| gizmos.leaves ^= true,
        count: |stats| stats.leaves,
    },
    Kind {
        key: KeyCode::Digit4,
        name: "volumes",
        switch: |gizmos| gizmos.volumes = next_volume(gizmos.volumes),
        count: |stats| stats.volumes,
    },
    Kind {
        key: KeyCode::Digit5,
        name: "frusta",
        switch: |gizmos| gizmos.frusta ^= true,
        count: |stats| stats.frusta,
    },
    Kind {
        key: KeyCode::Digit6,
        name: "occluders",
        switch: |gizmos| gizmos.occluders ^= true,
        count: |stats| stats.occluders,
    },
    Kind {
        key: KeyCode::Digit7,
        name: "rays",
        switch: |gizmos| gizmos.rays ^= true,
        count: |stats| stats.rays,
    },
    Kind {
        key: KeyCode::Digit8,
        name: "lods",
        switch: |gizmos| gizmos.lods ^= true,
        count: |stats| stats.lods,
    },
];

fn next_volume(kind: Option<BoundingKind>) -> Option<BoundingKind> {
    match kind {
        None => Some(BoundingKind::Obb),
        Some(BoundingKind::Obb) => Some(BoundingKind::Hull),
        Some(BoundingKind::Hull) => Some(BoundingKind::Sphere),
        Some(BoundingKind::Sphere) => Some(BoundingKind::Aabb),
        Some(BoundingKind::Aabb) => None,
    }
}

/// A structure that the index does not keep, built of its boxes.
#[derive(Resource, Default)]
pub enum Structure {
    #[default]
    None,
    Octree(Octree<Entity>),
    KdTree(KdTree<Entity>),
}

impl Structure {
    pub fn name(&self) -> &'static str {
        match self {
            Self::None => "octree, k-d tree",
            Self::Octree(_) => "octree",
            Self::KdTree(_) => "k-d tree",
        }
    }
}

/// How much was drawn of it.
#[derive(Resource, Default)]
pub struct StructureCount(pub GizmoCount);

pub fn plugin(app: &mut App) {
    app.init_resource::<Structure>()
        .init_resource::<StructureCount>()
        .add_systems(Startup, configure)
        .add_systems(PostUpdate, draw_structure.after(SightlineGizmoSystems));
}

fn configure(mut store: ResMut<GizmoConfigStore>, options: Res<Options>) {
    let (config, gizmos) = store.config_mut::<SightlineGizmos>();
    config.line.width = 1.5;
    config.render_layers = RenderLayers::layer(MARKS);
    gizmos.limit = options.limit as usize;
}

/// Goes on to the next structure.
pub fn switch_structure(scene: SceneQuery, mut structure: ResMut<Structure>) {
    let mut boxes = Vec::new();
    let settings = SceneQuerySettings::default();
    scene
        .boxes(&settings)
        .visit_all(|entity, aabb| boxes.push((entity, *aabb)));
    *structure = match &*structure {
        Structure::None => {
            let mut octree = Octree::new();
            octree.insert_many(boxes);
            Structure::Octree(octree)
        }
        Structure::Octree(_) => KdTree::new(boxes, SplitMethod::Sah).map_or(Structure::None, Structure::KdTree),
        Structure::KdTree(_) => Structure::None,
    };
}

fn draw_structure(
    structure: Res<Structure>,
    eye: Single<(&GlobalTransform, &Frustum), With<FreeCamera>>,
    mut count: ResMut<StructureCount>,
    mut gizmos: Gizmos<SightlineGizmos>,
) {
    let (place, frustum) = *eye;
    let style = StructureStyle {
        depths: gizmos.config_ext.depths.clone(),
        limit: gizmos.config_ext.limit,
        within: Some(frustum.0),
        nearest_to: Some(place.translation()),
        ..default()
    };
    count.0 = match &*structure {
        Structure::None => GizmoCount::default(),
        Structure::Octree(octree) => gizmos.octree(octree, &style),
        Structure::KdTree(tree) => gizmos.kd_tree(tree, &style),
    };
}
