//! Nothing that owns a pixel is left out, and of what owns none most is.

use bevy::{platform::collections::HashSet, prelude::*};
use bevy_sightline::prelude::*;

use super::{
    city::{City, Part},
    exact::{Owners, spawn_view},
    look,
};
use crate::common::*;

/// Of all that was in view.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    in_view: usize,
    owners: usize,
    kept: usize,
}

impl Counts {
    /// The share that was left out of what owns no pixel.
    fn left_out(self) -> f32 {
        (self.in_view - self.kept) as f32 / (self.in_view - self.owners) as f32
    }
}

/// Looks around in a city whose buildings hide what is behind them.
///
/// # Panics
///
/// If something is left out that owns a pixel.
fn look_around(buildings: Occluder, size: UVec2, views: impl IntoIterator<Item = u32>, seed: u64) -> Counts {
    let rng = &mut rng(seed);
    let mut app = headless_app();
    let city = City::build(&mut app, 2000, seed);
    let mut parts = app.world_mut().query::<(Entity, &Part)>();
    let is_building = |(entity, part): (Entity, &Part)| (*part == Part::Building).then_some(entity);
    let built: Vec<Entity> = parts.iter(app.world()).filter_map(is_building).collect();
    for building in built {
        app.world_mut().entity_mut(building).insert(buildings.clone());
    }
    let [open, camera] = [0; 2].map(|_| spawn_view(&mut app, size, Transform::IDENTITY));
    app.world_mut().entity_mut(camera).insert(SoftwareOcclusion::default());
    settle(&mut app);
    while app.world().resource::<Occluders>().making() > 0 {
        app.update();
    }
    let mut counts = Counts::default();
    for number in views {
        let place = city.view(number, rng);
        for camera in [open, camera] {
            app.world_mut().entity_mut(camera).insert(place);
        }
        counts.in_view += look(&mut app, open).len();
        let seen: HashSet<Entity> = look(&mut app, camera).into_iter().collect();
        counts.kept += seen.len();
        let owners = Owners::find(&mut app, camera, size).shares();
        counts.owners += owners.len();
        for (entity, share) in owners {
            let part = app.world().get::<Part>(entity);
            assert!(
                seen.contains(&entity),
                "view {number}: {entity}, {part:?}, owns {share:?} from {place:?}"
            );
        }
    }
    println!("{buildings:?} {size}: {counts:?}, {:.3} left out", counts.left_out());
    counts
}

const SMALL: UVec2 = UVec2::new(480, 270);

#[test]
fn boxes_hide_nothing_that_owns_a_pixel() {
    assert!(look_around(Occluder::Box, SMALL, 0..24, 80).left_out() > 0.5);
}

#[test]
fn boxes_found_in_meshes_hide_nothing_that_owns_a_pixel() {
    assert!(look_around(Occluder::Auto, SMALL, 0..24, 81).left_out() > 0.5);
}

#[test]
fn triangles_hide_nothing_that_owns_a_pixel() {
    assert!(look_around(Occluder::Mesh, SMALL, 0..24, 82).left_out() > 0.5);
}

/// From the streets and the crossings.
const IN_THE_STREETS: [u32; 4] = [0, 1, 4, 5];

#[test]
fn boxes_leave_out_four_fifths_of_what_cannot_be_seen_from_the_street() {
    let counts = look_around(Occluder::Box, UVec2::new(1920, 1080), IN_THE_STREETS, 83);
    assert!(counts.left_out() >= 0.8, "{counts:?}");
}

#[test]
fn boxes_found_in_meshes_leave_out_half_of_what_cannot_be_seen_from_the_street() {
    let counts = look_around(Occluder::Auto, UVec2::new(1920, 1080), IN_THE_STREETS, 83);
    assert!(counts.left_out() >= 0.5, "{counts:?}");
}
