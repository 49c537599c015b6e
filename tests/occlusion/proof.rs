//! Nothing that owns a pixel is left out.

use bevy::{platform::collections::HashSet, prelude::*};
use bevy_sightline::prelude::*;

use super::{
    city::{City, Part},
    exact::{Owners, spawn_view},
    look,
};
use crate::common::*;

/// Looks around in a city whose buildings hide what is behind them, and tells how many of the things in view were kept.
fn looks_around_in_a_city(buildings: Occluder, views: u32, seed: u64) -> f32 {
    let rng = &mut rng(seed);
    let mut app = headless_app();
    let city = City::build(&mut app, 2000, seed);
    let mut parts = app.world_mut().query::<(Entity, &Part)>();
    let is_building = |(entity, part): (Entity, &Part)| (*part == Part::Building).then_some(entity);
    let built: Vec<Entity> = parts.iter(app.world()).filter_map(is_building).collect();
    for building in built {
        app.world_mut().entity_mut(building).insert(buildings.clone());
    }
    let size = UVec2::new(480, 270);
    let [open, camera] = [0; 2].map(|_| spawn_view(&mut app, size, Transform::IDENTITY));
    app.world_mut().entity_mut(camera).insert(SoftwareOcclusion::default());
    settle(&mut app);
    while app.world().resource::<Occluders>().making() > 0 {
        app.update();
    }
    let (mut kept, mut in_view) = (0, 0);
    for number in 0..views {
        let place = city.view(number, rng);
        for camera in [open, camera] {
            app.world_mut().entity_mut(camera).insert(place);
        }
        in_view += look(&mut app, open).len();
        let seen: HashSet<Entity> = look(&mut app, camera).into_iter().collect();
        kept += seen.len();
        for (entity, share) in Owners::find(&mut app, camera, size).shares() {
            let part = app.world().get::<Part>(entity);
            assert!(
                seen.contains(&entity),
                "view {number}: {entity}, {part:?}, owns {share:?} from {place:?}"
            );
        }
    }
    kept as f32 / in_view as f32
}

#[test]
fn boxes_hide_nothing_that_owns_a_pixel() {
    let kept = looks_around_in_a_city(Occluder::Box, 24, 80);
    assert!(kept < 0.5, "{kept} of what is in view is kept");
}

#[test]
fn boxes_found_in_meshes_hide_nothing_that_owns_a_pixel() {
    let kept = looks_around_in_a_city(Occluder::Auto, 24, 81);
    assert!(kept < 0.5, "{kept} of what is in view is kept");
}

#[test]
fn triangles_hide_nothing_that_owns_a_pixel() {
    let kept = looks_around_in_a_city(Occluder::Mesh, 24, 82);
    assert!(kept < 0.5, "{kept} of what is in view is kept");
}
