//! Real models through their animations, where there are any: set `SIGHTLINE_MODELS` to their folder, or keep it beside
//! the repository.

use std::path::PathBuf;

use bevy::{
    animation::{AnimationPlugin, graph::AnimationGraph},
    asset::LoadState,
    camera::CameraPlugin,
    gltf::{Gltf, GltfPlugin},
    image::ImagePlugin,
    mesh::{MeshPlugin, morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
    window::WindowPlugin,
    world_serialization::{WorldAssetRoot, WorldSerializationPlugin},
};
use bevy_sightline::prelude::*;
use rand::Rng;

use super::{
    both_sides, on_triangle,
    reference::{Reference, bounds},
};
use crate::common::{query, random_dir, random_point, ray_towards, rng, settle};

/// How many times are looked at, and rays cast at each.
const TIMES: usize = 20;
const RAYS: usize = 500;

#[test]
fn the_fox_is_hit_where_its_animations_take_it() {
    assert_animated_model_is_hit_where_it_is_drawn("animated/Fox.glb", 1);
}

#[test]
fn the_morph_stress_test_is_hit_where_its_animations_take_it() {
    assert_animated_model_is_hit_where_it_is_drawn("animated/MorphStressTest.gltf", 2);
}

fn models() -> PathBuf {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    std::env::var_os("SIGHTLINE_MODELS").map_or_else(beside, PathBuf::from)
}

fn assert_animated_model_is_hit_where_it_is_drawn(name: &'static str, seed: u64) {
    let models = models();
    if !models.join(name).exists() {
        eprintln!("skipped: there is no {name} in {}", models.display());
        return;
    }
    let rng = &mut rng(seed);
    let mut app = app(&models);
    let gltf = load(&mut app, name);
    let assets = app.world().resource::<Assets<Gltf>>();
    let gltf = assets.get(&gltf).expect("it is loaded");
    let (scene, clips) = (gltf.scenes[0].clone(), gltf.animations.clone());
    app.world_mut()
        .spawn((WorldAssetRoot(scene), Transform::default(), Visibility::default()));
    let mut players = app.world_mut().query_filtered::<Entity, With<AnimationPlayer>>();
    while players.iter(app.world()).next().is_none() {
        app.update();
    }
    settle(&mut app);
    let mut posed = app
        .world_mut()
        .query_filtered::<Entity, (With<Mesh3d>, Or<(With<SkinnedMesh>, With<MeshMorphWeights>)>)>();
    let posed: Vec<Entity> = posed.iter(app.world()).collect();
    assert!(!posed.is_empty(), "the model is skinned or morphed");

    let mut hits = 0;
    for _ in 0..TIMES {
        seek(
            &mut app,
            &clips,
            rng.random_range(0..clips.len()),
            rng.random_range(0.0..1.0),
        );
        let references: Vec<Reference> = posed.iter().map(|&entity| Reference::of(&app, entity)).collect();
        let all: Vec<_> = references
            .iter()
            .flat_map(|reference| reference.triangles.clone())
            .collect();
        let (min, max) = bounds(&all);
        let (middle, half) = (((min + max) / 2.0).as_vec3(), ((max - min) / 2.0).as_vec3());
        for _ in 0..RAYS {
            let origin = middle + *random_dir(rng) * 3.0 * half.length();
            let ray = ray_towards(origin, middle + random_point(rng, 1.0) * half);
            query(&mut app, |scene| {
                for (&entity, reference) in posed.iter().zip(&references) {
                    let only = |hit| hit == entity;
                    let hit = scene.cast_ray(ray, &both_sides().filter(&only));
                    hits += usize::from(hit.is_some());
                    reference.check(ray, hit.map(|hit| on_triangle(&hit)));
                }
            });
        }
    }
    println!("{name}: {} rays, {hits} hits", TIMES * RAYS);
    assert!(hits > TIMES * RAYS / 10);
}

fn app(models: &std::path::Path) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin {
            file_path: models.display().to_string(),
            ..default()
        },
        TransformPlugin,
        ImagePlugin::default(),
        MeshPlugin,
        WindowPlugin::default(),
        CameraPlugin,
        WorldSerializationPlugin,
        AnimationPlugin,
        GltfPlugin::default(),
        SpatialIndexPlugin,
    ));
    app.finish();
    app.cleanup();
    app
}

fn load(app: &mut App, name: &'static str) -> Handle<Gltf> {
    let server = app.world().resource::<AssetServer>().clone();
    let gltf = server.load(name);
    while !server.is_loaded_with_dependencies(&gltf) {
        if let LoadState::Failed(why) = server.load_state(&gltf) {
            panic!("{name}: {why}");
        }
        app.update();
    }
    gltf
}

/// Puts all players at a share of a clip.
fn seek(app: &mut App, clips: &[Handle<AnimationClip>], clip: usize, share: f32) {
    let world = app.world_mut();
    let duration = world
        .resource::<Assets<AnimationClip>>()
        .get(&clips[clip])
        .expect("loaded")
        .duration();
    let (graph, node) = AnimationGraph::from_clip(clips[clip].clone());
    let graph = world.resource_mut::<Assets<AnimationGraph>>().add(graph);
    let mut players = world.query::<(Entity, &mut AnimationPlayer)>();
    let mut found = Vec::new();
    for (entity, mut player) in players.iter_mut(world) {
        player.stop_all();
        player.play(node).seek_to(share * duration).pause();
        found.push(entity);
    }
    for entity in found {
        world.entity_mut(entity).insert(AnimationGraphHandle(graph.clone()));
    }
    // The graph is made ready in the first frame, and followed in the second.
    app.update();
    app.update();
}
