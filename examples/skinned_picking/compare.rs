//! Whether rays meet what is drawn: the outline on the screen against one ray per pixel, with the time held.

use std::{error::Error, path::Path};

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::{
        render_resource::{Extent3d, TextureDimension, TextureFormat},
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
};
use bevy_sightline::prelude::*;

use crate::{
    meadow::{self, ModelFile, Unfitted},
    options::Options,
    reference::Reference,
};

/// Times in each animation.
const TIMES: usize = 4;
/// Frames until what is drawn is what was set, and until the first drawing at all.
const SETTLE: u32 = 4;
const PATIENCE: u32 = 2000;
/// The share of the pixels of the model that may differ.
const LIMIT: f64 = 0.005;

/// Far from any colour that the model could have.
const BACKGROUND: [u8; 3] = [255, 0, 255];

/// Where the comparison stands.
#[derive(Resource, Default)]
struct Progress {
    clip: usize,
    time: usize,
    /// Whether the animations are held at that time, and for how many frames they have been.
    held: bool,
    frames: u32,
    waiting: bool,
    worst: f64,
}

pub fn plugin(app: &mut App) {
    let [r, g, b] = BACKGROUND;
    app.insert_resource(ClearColor(Color::srgb_u8(r, g, b)))
        .init_resource::<Progress>()
        .add_systems(Startup, (meadow::load_model, set_up).chain())
        .add_systems(Update, (meadow::fit, whiten, (hold, look, capture).chain()));
}

fn set_up(mut commands: Commands, options: Res<Options>, assets: Res<AssetServer>) {
    commands.spawn((
        Transform::default(),
        Visibility::default(),
        children![meadow::model(&options, &assets, &[], 0.0)],
    ));
    commands.spawn((
        Camera3d::default(),
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
    ));
}

/// Paints everything evenly, so that no pixel is like the background.
fn whiten(
    mut painted: Query<&mut MeshMaterial3d<StandardMaterial>, Added<MeshMaterial3d<StandardMaterial>>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for mut material in &mut painted {
        let old = materials.get(&material.0);
        let white = StandardMaterial {
            unlit: true,
            cull_mode: old.map_or(StandardMaterial::default().cull_mode, |old| old.cull_mode),
            ..default()
        };
        material.0 = materials.add(white);
    }
}

/// Holds the animations where the comparison is.
fn hold(
    mut commands: Commands,
    mut progress: ResMut<Progress>,
    unfitted: Query<(), With<Unfitted>>,
    file: Res<ModelFile>,
    files: Res<Assets<Gltf>>,
    clips: Res<Assets<AnimationClip>>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    mut players: Query<(Entity, &mut AnimationPlayer)>,
) {
    let Some(gltf) = files.get(&file.0).filter(|_| !progress.held && unfitted.is_empty()) else {
        return;
    };
    progress.held = true;
    for (entity, mut player) in &mut players {
        let Some(clip) = gltf.animations.get(progress.clip) else {
            continue;
        };
        let seconds = clips.get(clip).map_or(0.0, AnimationClip::duration);
        let (graph, node) = AnimationGraph::from_clip(clip.clone());
        player.stop_all();
        // Off the key frames, and off the ends.
        let share = (progress.time as f32 + 0.37) / TIMES as f32;
        player.play(node).seek_to(share * seconds).pause();
        commands.entity(entity).insert(AnimationGraphHandle(graphs.add(graph)));
    }
}

/// Looks at the model from its side and a little from above, so that it fills the window.
fn look(
    progress: Res<Progress>,
    things: Query<Entity, With<Mesh3d>>,
    reference: Reference,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    if progress.frames > SETTLE {
        return;
    }
    let triangles = things.iter().filter_map(|thing| reference.triangles(thing)).flatten();
    let bounds = triangles.flatten().fold(None, |bounds: Option<(Vec3, Vec3)>, corner| {
        let corner = corner.as_vec3();
        let (min, max) = bounds.unwrap_or((corner, corner));
        Some((min.min(corner), max.max(corner)))
    });
    if let Some((min, max)) = bounds {
        let (middle, radius) = ((min + max) / 2.0, (max - min).length() / 2.0);
        let from = Vec3::new(0.8, 0.45, 0.6).normalize() * radius * 2.4;
        **camera = Transform::from_translation(middle + from).looking_at(middle, Vec3::Y);
    }
}

/// Takes a picture of the window once everything has come to rest.
fn capture(
    mut commands: Commands,
    mut progress: ResMut<Progress>,
    scene: SceneQuery,
    mut exit: MessageWriter<AppExit>,
) {
    if progress.waiting || !progress.held || scene.meshes().building() > 0 {
        return;
    }
    progress.frames += 1;
    if progress.frames > PATIENCE {
        eprintln!("nothing is drawn");
        exit.write(AppExit::error());
    }
    if progress.frames > 3 * SETTLE {
        progress.waiting = true;
        commands.spawn(Screenshot::primary_window()).observe(compare);
    }
}

/// Compares the picture with one ray for the middle of each of its pixels.
fn compare(
    screenshot: On<ScreenshotCaptured>,
    mut progress: ResMut<Progress>,
    scene: SceneQuery,
    camera: Single<(&Camera, &GlobalTransform)>,
    file: Res<ModelFile>,
    files: Res<Assets<Gltf>>,
    options: Res<Options>,
    mut exit: MessageWriter<AppExit>,
) -> Result {
    progress.waiting = false;
    let image = screenshot.image.clone().try_into_dynamic()?.to_rgb8();
    let size = UVec2::from(image.dimensions());
    let drawn: Vec<bool> = image.pixels().map(|pixel| pixel.0 != BACKGROUND).collect();
    let drawn_pixels = count(&drawn);
    // Bevy draws nothing until it has compiled its shaders.
    if drawn_pixels == 0 || drawn_pixels == drawn.len() {
        return Ok(());
    }

    let (camera, transform) = *camera;
    let viewport = camera.logical_viewport_size().ok_or("a camera without a viewport")?;
    let rays = (0..size.y).flat_map(|y| (0..size.x).map(move |x| Vec2::new(x as f32 + 0.5, y as f32 + 0.5)));
    let rays: Vec<Ray3d> = rays
        .map(|pixel| camera.viewport_to_world(transform, pixel / size.as_vec2() * viewport))
        .collect::<Result<_, _>>()?;
    let mut hits = Vec::new();
    scene.cast_rays(&rays, &SceneQuerySettings::default(), &mut hits);
    let met: Vec<bool> = hits.iter().map(Option::is_some).collect();

    let differing = drawn.iter().zip(&met).filter(|(drawn, met)| drawn != met).count();
    let share = differing as f64 / drawn_pixels as f64;
    progress.worst = progress.worst.max(share);
    let gltf = files.get(&file.0).ok_or("the model has gone")?;
    let clip = gltf.animations.get(progress.clip);
    let is_clip = |handle: &&Handle<AnimationClip>| Some(*handle) == clip;
    let named = gltf.named_animations.iter().find(|(_, handle)| is_clip(handle));
    println!(
        "{:<16} {} of {TIMES}: drawn {drawn_pixels:>7} pixels, met by rays {:>7}, differing {differing:>5}: {:.3} %",
        named.map_or("at rest", |(name, _)| name),
        progress.time + 1,
        count(&met),
        100.0 * share,
    );

    progress.held = false;
    progress.frames = 0;
    progress.time += 1;
    if progress.time == TIMES {
        progress.time = 0;
        progress.clip += 1;
    }
    if progress.clip >= gltf.animations.len() {
        save(&options.picture, size, &drawn, &met)?;
        println!("at worst {:.3} %", 100.0 * progress.worst);
        let passed = progress.worst <= LIMIT;
        exit.write(if passed { AppExit::Success } else { AppExit::error() });
    }
    Ok(())
}

fn count(pixels: &[bool]) -> usize {
    pixels.iter().filter(|is_set| **is_set).count()
}

/// Writes a picture of the last comparison: grey where both agree, red where only the drawing is, blue where only rays
/// meet something.
fn save(file: &Path, size: UVec2, drawn: &[bool], met: &[bool]) -> Result<(), Box<dyn Error + Send + Sync>> {
    let color = |(&drawn, &met): (&bool, &bool)| match (drawn, met) {
        (true, true) => [150, 150, 150, 255],
        (true, false) => [255, 0, 0, 255],
        (false, true) => [0, 80, 255, 255],
        (false, false) => [245, 245, 245, 255],
    };
    let image = Image::new(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        drawn.iter().zip(met).flat_map(color).collect(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::MAIN_WORLD,
    );
    file.parent().map_or(Ok(()), std::fs::create_dir_all)?;
    image.try_into_dynamic()?.save(file)?;
    Ok(())
}
