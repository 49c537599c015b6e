//! The city without a window: a synthetic mouse draws a box and a lasso, and every triangle says what they should select.

use std::{f32::consts::TAU, time::Instant};

use bevy::{math::DVec3, platform::collections::HashMap, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    marquee::{Choice, Selection},
    oracle::Eye,
    outline::{Marquee, draw_by_script},
    scenery::Ground,
    shared,
};

/// Runs the scene until it is loaded, draws, and checks what was selected.
pub fn run(mut app: App) -> AppExit {
    if let Err(message) = shared::load(&mut app) {
        eprintln!("{message}");
        return AppExit::error();
    }
    let middle = Vec2::new(640.0, 360.0);
    let with_box = [
        Vec2::new(330.0, 250.0),
        Vec2::new(700.0, 330.0),
        Vec2::new(880.0, 560.0),
    ];
    // A loop with a loop in it, which crosses itself.
    let lasso: Vec<Vec2> = (0..=120)
        .map(|step| step as f32 / 120.0 * 2.0 * TAU)
        .map(|angle| middle + Vec2::from_angle(angle) * Vec2::new(330.0, 230.0) * (0.62 + 0.38 * (angle / 2.0).cos()))
        .collect();
    for (name, places, is_lasso) in [("box", &with_box[..], false), ("lasso", &lasso, true)] {
        draw_by_script(&mut app, is_lasso.then_some(KeyCode::ShiftLeft), places);
        for mode in [SelectionMode::Touching, SelectionMode::Enclosed] {
            app.world_mut().resource_mut::<Choice>().0.mode = mode;
            app.update();
            let Ok(is_right) = app.world_mut().run_system_cached_with(check, (name, mode)) else {
                eprintln!("there is no camera");
                return AppExit::error();
            };
            if !is_right {
                eprintln!("not what every triangle says");
                return AppExit::error();
            }
        }
        app.world_mut().resource_mut::<Choice>().0.mode = SelectionMode::Touching;
    }
    AppExit::Success
}

/// Whether every triangle says the same as the selection.
fn check(
    In((name, mode)): In<(&'static str, SelectionMode)>,
    view: Single<(&Camera, &GlobalTransform)>,
    marquee: Res<Marquee>,
    selection: Res<Selection>,
    meshes: Res<Assets<Mesh>>,
    things: Query<(Entity, &Mesh3d, &GlobalTransform), Without<Ground>>,
    names: Query<&Name>,
) -> bool {
    let (camera, eye) = *view;
    let eye = Eye::new(camera, eye);
    let corners = marquee.corners();
    let mut triangles_of = HashMap::new();
    let mut tested = 0;
    let start = Instant::now();
    let mut expected: Vec<Entity> = things
        .iter()
        .filter(|(_, mesh, transform)| {
            let local: &Vec<[Vec3; 3]> = triangles_of.entry(mesh.id()).or_insert_with(|| {
                let triangles = meshes.get(mesh.id()).and_then(|mesh| mesh.triangles().ok());
                triangles
                    .into_iter()
                    .flatten()
                    .map(|triangle| triangle.vertices)
                    .collect()
            });
            tested += local.len();
            let place = transform.affine().as_daffine3();
            let place = |corner: Vec3| -> DVec3 { place.transform_point3(corner.as_dvec3()) };
            let triangles: Vec<[DVec3; 3]> = local.iter().map(|corners| corners.map(place)).collect();
            match mode {
                SelectionMode::Touching => eye.touches(&triangles, &corners),
                SelectionMode::Enclosed => eye.encloses(&triangles, &corners),
            }
        })
        .map(|(entity, ..)| entity)
        .collect();
    let seconds = start.elapsed().as_secs_f64();
    expected.sort_unstable();

    let mut kinds: HashMap<&str, usize> = HashMap::new();
    for name in names.iter_many(&selection.entities) {
        *kinds.entry(name.split(' ').next().unwrap_or(name)).or_default() += 1;
    }
    let mut kinds: Vec<(&str, usize)> = kinds.into_iter().collect();
    kinds.sort_unstable_by_key(|&(kind, count)| (usize::MAX - count, kind));
    println!(
        "{name}, {mode:?}: {} of {} things in {:.0} µs; {tested} triangles say the same in {seconds:.2} s: {}",
        selection.entities.len(),
        things.iter().len(),
        selection.micros,
        selection.entities == expected,
    );
    let most: Vec<String> = kinds
        .iter()
        .take(6)
        .map(|(kind, count)| format!("{count} {kind}"))
        .collect();
    println!("    {}", most.join(", "));
    !expected.is_empty() && selection.entities == expected
}
