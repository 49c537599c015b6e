//! Levels of detail: which model is shown by less from where on, with `bevy_sightline` and with Bevy's own ranges.
//!
//! Both go by the distance from the camera to the centre of a thing, so that both show the same. With `bevy_sightline`
//! the mesh of a thing is swapped; Bevy has an entity for each level.

use bevy::{camera::visibility::VisibilityRange, platform::collections::HashMap, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    options::Options,
    plan::PITCH,
    scenery::{Models, Thing, file_of, is_building},
    traffic::spawn_travellers,
};

/// From so many metres on, one mesh stands in for a block.
pub const BLOCK: f32 = 600.0;
/// Bevy's ranges go by the distance to each thing, and not to the block that it is in: so much longer it shows them, in
/// metres, so that there is no hole.
const OVERLAP: f32 = PITCH;
/// By so much Bevy's ranges are longer for rounding, in metres.
const SLACK: f32 = 0.1;

/// From where on a model is shown by less, in metres.
#[derive(Clone, Copy)]
pub struct Reach {
    pub middle: f32,
    pub far: f32,
    /// Not at all.
    pub nothing: Option<f32>,
}

impl Reach {
    /// By the size of the model.
    pub fn of(model: &str) -> Self {
        let (middle, far, nothing) = match model {
            "hydrant" | "bench" | "person" => (30.0, 80.0, Some(220.0)),
            "lamp_street" | "traffic_light" | "bus_stop" => (45.0, 110.0, Some(340.0)),
            "car_sedan" | "car_van" => (50.0, 120.0, Some(600.0)),
            "tree_oak" | "tree_pine" => (70.0, 170.0, None),
            model if model.starts_with("tower") => (280.0, 540.0, None),
            model if is_building(model) => (160.0, 330.0, None),
            _ => (80.0, 200.0, None),
        };
        Self { middle, far, nothing }
    }
}

/// What rays hit.
#[derive(Resource, Clone, Copy)]
pub struct Hits(pub LodHits);

/// Another level of a thing that it is a child of, where each is an entity.
#[derive(Component)]
pub struct OtherLevel {
    pub is_coarsest: bool,
}

/// The meshes of all levels, so that they are there when they are needed.
#[derive(Resource, Default)]
pub struct Levels(HashMap<&'static str, [Handle<Mesh>; 3]>);

impl Levels {
    fn of(&mut self, model: &'static str, assets: &AssetServer) -> &[Handle<Mesh>; 3] {
        let load = || [0, 1, 2].map(|level| assets.load(file_of(model, level)));
        self.0.entry(model).or_insert_with(load)
    }

    /// The coarsest mesh of a model.
    pub fn coarsest(&self, model: &str) -> Option<&Handle<Mesh>> {
        self.0.get(model).map(|levels| &levels[2])
    }

    pub fn are_loaded(&self, meshes: &Assets<Mesh>) -> bool {
        let mut all = self.0.values().flatten();
        !self.0.is_empty() && all.all(|mesh| meshes.contains(mesh))
    }
}

pub fn plugin(app: &mut App) {
    let is_plain = app.world().resource::<Options>().plain;
    app.init_resource::<Levels>();
    if is_plain {
        app.add_systems(PostStartup, spawn_levels.after(spawn_travellers));
    } else {
        app.insert_resource(Hits(LodHits::Finest))
            .add_systems(PostStartup, list_levels.after(spawn_travellers));
    }
}

/// With `bevy_sightline`.
fn list_levels(
    mut commands: Commands,
    things: Query<(Entity, &Thing)>,
    assets: Res<AssetServer>,
    hits: Res<Hits>,
    mut levels: ResMut<Levels>,
) {
    for (entity, thing) in &things {
        let Reach { middle, far, nothing } = Reach::of(thing.model);
        let [finest, second, coarsest] = levels.of(thing.model, &assets).clone();
        let lod = ProxyLod::new(LodMetric::Distance, finest)
            .then(middle, second)
            .then(far, coarsest)
            .measured_to(LodReference::Center)
            .hit_as(hits.0);
        let lod = nothing.into_iter().fold(lod, ProxyLod::then_nothing);
        commands.entity(entity).insert(lod);
    }
}

/// With Bevy alone: the thing itself is the finest level.
fn spawn_levels(
    mut commands: Commands,
    things: Query<(Entity, &Thing)>,
    assets: Res<AssetServer>,
    models: Res<Models>,
    mut levels: ResMut<Levels>,
) {
    for (entity, thing) in &things {
        let Reach { middle, far, nothing } = Reach::of(thing.model);
        let end = nothing.unwrap_or(f32::INFINITY);
        let end = thing.block.map_or(end, |_| end.min(BLOCK + OVERLAP)) + SLACK;
        let [_, second, coarsest] = levels.of(thing.model, &assets).clone();
        commands.entity(entity).insert(range(0.0, middle));
        for (mesh, range, is_coarsest) in [(second, range(middle, far), false), (coarsest, range(far, end), true)] {
            let look = (Mesh3d(mesh), MeshMaterial3d(models.painted.clone()));
            let level = OtherLevel { is_coarsest };
            commands.spawn((level, look, Transform::default(), range, ChildOf(entity)));
        }
    }
}

/// By the distance to the centre.
fn range(start: f32, end: f32) -> VisibilityRange {
    VisibilityRange {
        use_aabb: true,
        ..VisibilityRange::abrupt(start, end)
    }
}

/// Where Bevy shows what stands in for a block.
pub fn range_of_block() -> VisibilityRange {
    range(BLOCK - SLACK, f32::INFINITY)
}

/// Where Bevy shows the coarsest level of what is in no block.
pub fn range_without_block(model: &str) -> VisibilityRange {
    let Reach { far, nothing, .. } = Reach::of(model);
    range(far, nothing.unwrap_or(f32::INFINITY))
}
