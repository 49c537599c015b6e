//! Whatever happens, the lists are those of the same scene without levels of detail, but for what an oracle leaves out,
//! which knows the documentation and nothing else.

mod oracle;
mod script;

use std::collections::HashMap;

use bevy::{
    camera::visibility::{CascadesVisibleEntities, CubemapVisibleEntities, VisibleMeshEntities},
    light::cluster::ClusterVisibilityClass,
};

use super::*;
use oracle::{Looker, Oracle};
use script::Script;

/// What was told in a frame.
#[derive(Resource, Default)]
struct Told(Vec<LodSwapped>);

/// A list of something that looks.
struct List {
    name: String,
    looker: Option<Looker>,
    entities: Vec<Entity>,
}

/// The lists of all cameras that are active, and of all lights.
fn lists(world: &World, script: &Script, origin: Option<Entity>) -> Vec<List> {
    let mut all = Vec::new();
    for &camera in &script.cameras {
        if world.get::<Camera>(camera).expect("a camera").is_active {
            let lists = world.get::<VisibleEntities>(camera).expect("a camera");
            let entities = lists.get(TypeId::of::<Mesh3d>()).to_vec();
            let name = format!("camera {camera}");
            all.push(List {
                name,
                looker: Some((camera, false)),
                entities,
            });
        }
    }
    let [lamp, spot, sun] = script.lights;
    // Of those that no camera lists, the shadow maps stay as they were.
    let is_listed = |light: &Entity| {
        let mut lists = script
            .cameras
            .iter()
            .filter_map(|&camera| world.get::<VisibleEntities>(camera));
        lists.any(|lists| lists.get(TypeId::of::<ClusterVisibilityClass>()).contains(light))
    };
    let looker = origin.map(|origin| (origin, true));
    if is_listed(&lamp) {
        let faces = world.get::<CubemapVisibleEntities>(lamp).expect("a lamp");
        all.extend((0..6).map(|face| List {
            name: format!("face {face}"),
            looker,
            entities: faces.get(face).entities.clone(),
        }));
    }
    if is_listed(&spot) {
        let list = world.get::<VisibleMeshEntities>(spot).expect("a spot");
        all.push(List {
            name: "spot".into(),
            looker,
            entities: list.entities.clone(),
        });
    }
    let mut cascades: Vec<_> = world
        .get::<CascadesVisibleEntities>(sun)
        .expect("a sun")
        .entities
        .iter()
        .collect();
    cascades.sort_by_key(|(camera, _)| **camera);
    for (&camera, lists) in cascades {
        for (number, list) in lists.iter().enumerate() {
            let (name, entities) = (format!("cascade {number} of {camera}"), list.entities.clone());
            all.push(List {
                name,
                looker: Some((camera, true)),
                entities,
            });
        }
    }
    all
}

/// Bevy's own choice of where the levels of lamps and spots are chosen from.
fn shadow_origin(world: &mut World) -> Option<Entity> {
    let mut origins = world.query_filtered::<Entity, With<bevy::camera::ShadowLodOrigin>>();
    let mut cameras = world.query_filtered::<Entity, With<Camera>>();
    origins.iter(world).min().or_else(|| cameras.iter(world).min())
}

fn assert_agrees_for(seed: u64, frames: usize) {
    let (mut ours, mut plain) = (app(), app());
    ours.init_resource::<Told>();
    ours.add_observer(|swapped: On<LodSwapped>, mut told: ResMut<Told>| told.0.push(*swapped));
    plain.init_resource::<Told>();
    plain.add_observer(|_: On<LodSwapped>| panic!("there are no groups"));
    let mut script = Script::begin(ours.world_mut(), seed, true);
    let mut plain_script = Script::begin(plain.world_mut(), seed, false);
    let mut oracle = Oracle::default();
    let mut last: HashMap<(Entity, Entity), usize> = HashMap::new();
    for frame in 0..frames {
        script.play(ours.world_mut());
        plain_script.play(plain.world_mut());
        ours.update();
        plain.update();
        let told = std::mem::take(&mut ours.world_mut().resource_mut::<Told>().0);

        let choices = |world: &World, root, camera| world.resource::<LodChoices>().level(root, camera);
        oracle.choose(ours.world_mut(), choices);
        let at = format!("seed {seed}, frame {frame}");
        let origin = shadow_origin(ours.world_mut());
        let world = ours.world();
        let active = || {
            script
                .cameras
                .iter()
                .filter(|&&camera| world.get::<Camera>(camera).unwrap().is_active)
        };
        let mut levels = HashMap::new();
        for root in oracle.roots() {
            for &camera in active() {
                let (found, expected) = (choices(world, root, camera), oracle.level(root, (camera, false)));
                assert_eq!(found, Some(expected), "{at}: group {root} for {camera}");
                levels.insert((root, camera), expected);
            }
        }
        let (lists, all) = (
            lists(world, &script, origin),
            self::lists(plain.world(), &plain_script, origin),
        );
        assert_eq!(lists.len(), all.len());
        for (list, all) in lists.iter().zip(&all) {
            let shows = |&&entity: &&Entity| list.looker.is_none_or(|looker| oracle.shows(world, looker, entity));
            let expected: Vec<Entity> = all.entities.iter().filter(shows).copied().collect();
            assert_eq!(list.entities, expected, "{at}: the list of {}", list.name);
        }
        for (&(root, view), &to) in levels.iter().filter(|((root, _), _)| !oracle.is_swapped(*root)) {
            let of_it = told.iter().filter(|told| (told.entity, told.view) == (root, view));
            let of_it: Vec<_> = of_it.map(|told| (told.from, told.to)).collect();
            let from = last.get(&(root, view)).copied();
            let expected: Vec<_> = from
                .filter(|&from| from != to)
                .map(|from| (from, to))
                .into_iter()
                .collect();
            assert_eq!(of_it, expected, "{at}: told of {root} for {view}");
        }
        last = levels;
    }
}

#[test]
fn lists_and_choices_are_those_of_the_oracle_whatever_happens() {
    let asked = std::env::var("LOD_SCENES")
        .ok()
        .map(|scenes| scenes.parse().expect("a number of scenes"));
    for seed in 0..asked.unwrap_or(12) {
        assert_agrees_for(seed, 150);
    }
}
