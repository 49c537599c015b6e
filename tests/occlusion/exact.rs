//! Which entities own a pixel: by a ray through the middle of every one.

use bevy::{
    camera::visibility::RenderLayers,
    math::{DMat4, DVec3},
    platform::collections::HashMap,
    prelude::*,
};
use bevy_sightline::prelude::*;

use super::city::{City, Part};
use crate::common::*;

/// Who owns the pixels of a view, row by row from the top.
pub struct Owners {
    pub size: UVec2,
    pub of_pixels: Vec<Option<Entity>>,
}

/// What an entity owns of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    pub pixels: u32,
    /// One of them, for the message of a failure.
    pub first: UVec2,
}

impl Owners {
    /// Of the view of a camera, as of the last update of the app: by its `Projection`, which must fit the size.
    ///
    /// The owner of a pixel is what the ray through its middle meets first beyond the near plane, on the layers of the
    /// camera, not hidden, and from the front: what a renderer draws there, if everything is opaque.
    pub fn find(app: &mut App, camera: Entity, size: UVec2) -> Self {
        /// Rays in one batch: enough for all threads, and not too many to keep.
        const BATCH: u32 = 1 << 16;
        let view = app.world().entity(camera);
        let clip_from_view = view.get::<Projection>().expect("a camera").get_clip_from_view();
        let place = view.get::<GlobalTransform>().expect("a camera");
        let layers = view.get::<RenderLayers>().cloned().unwrap_or_default();
        let view_from_clip = clip_from_view.as_dmat4().inverse();
        let world_from_clip = DMat4::from(place.affine().as_daffine3()) * view_from_clip;
        let ray_at = |pixel: u32| {
            let pixel = UVec2::new(pixel % size.x, pixel / size.x);
            let place = (pixel.as_dvec2() + 0.5) / size.as_dvec2() * 2.0 - 1.0;
            let at_depth = |depth| world_from_clip.project_point3(DVec3::new(place.x, -place.y, depth));
            let near = at_depth(1.0);
            let along = at_depth(0.5) - near;
            Ray3d::new(near.as_vec3(), Dir3::new(along.as_vec3()).expect("a view with a depth"))
        };
        let pixels = size.x * size.y;
        let of_pixels = query(app, |scene| {
            let settings = SceneQuerySettings::default().with_layers(&layers);
            let (mut rays, mut hits) = (Vec::new(), Vec::new());
            let mut owners = Vec::with_capacity(pixels as usize);
            for first in (0..pixels).step_by(BATCH as usize) {
                rays.clear();
                rays.extend((first..pixels.min(first + BATCH)).map(ray_at));
                scene.cast_rays(&rays, &settings, &mut hits);
                owners.extend(hits.iter().map(|hit| hit.map(|hit| hit.entity)));
            }
            owners
        });
        Self { size, of_pixels }
    }

    /// All entities that own a pixel.
    pub fn shares(&self) -> HashMap<Entity, Share> {
        let mut shares = HashMap::default();
        for (number, owner) in (0..).zip(&self.of_pixels) {
            let Some(owner) = owner else { continue };
            let first = UVec2::new(number % self.size.x, number / self.size.x);
            shares.entry(*owner).or_insert(Share { pixels: 0, first }).pixels += 1;
        }
        shares
    }
}

/// A camera with a view of these proportions, somewhere.
pub fn spawn_view(app: &mut App, size: UVec2, place: Transform) -> Entity {
    let projection = PerspectiveProjection {
        aspect_ratio: size.x as f32 / size.y as f32,
        ..default()
    };
    app.world_mut()
        .spawn((Camera3d::default(), Projection::from(projection), place))
        .id()
}

/// A camera at the origin that sees 10 by 10 of what is before it.
fn spawn_flat_view(app: &mut App) -> Entity {
    let projection = OrthographicProjection {
        area: Rect::from_center_half_size(Vec2::ZERO, Vec2::splat(5.0)),
        ..OrthographicProjection::default_3d()
    };
    app.world_mut()
        .spawn((Camera3d::default(), Projection::from(projection)))
        .id()
}

#[test]
fn a_square_owns_the_pixels_that_it_covers() {
    let mut app = headless_app();
    let camera = spawn_flat_view(&mut app);
    // From 1 to 4 to the right, and from 2 to 3 up: pixels are a tenth.
    let square = spawn_mesh(&mut app, Rectangle::new(3.0, 1.0), Transform::from_xyz(2.5, 2.5, -10.0));
    settle(&mut app);
    let owners = Owners::find(&mut app, camera, UVec2::new(100, 100));
    for (number, owner) in (0..).zip(&owners.of_pixels) {
        let (x, y) = (number % 100, number / 100);
        let is_covered = (60..90).contains(&x) && (20..30).contains(&y);
        assert_eq!(*owner, is_covered.then_some(square), "{x} {y}");
    }
    let first = UVec2::new(60, 20);
    assert_eq!(owners.shares()[&square], Share { pixels: 300, first });
}

#[test]
fn what_is_hidden_out_of_view_or_turned_away_owns_nothing() {
    let mut app = headless_app();
    let camera = spawn_flat_view(&mut app);
    let wall = spawn_mesh(
        &mut app,
        Cuboid::new(4.0, 4.0, 0.1),
        Transform::from_xyz(0.0, 0.0, -5.0),
    );
    spawn_cube(&mut app, Vec3::NEG_Z * 8.0);
    spawn_cube(&mut app, Vec3::X * 9.0 - Vec3::Z * 8.0);
    spawn_cube(&mut app, Vec3::Z * 3.0);
    let turned = Transform::from_xyz(3.5, 0.0, -8.0).with_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    spawn_mesh(&mut app, Rectangle::new(1.0, 1.0), turned);
    settle(&mut app);
    let shares = Owners::find(&mut app, camera, UVec2::new(50, 50)).shares();
    assert_eq!(shares.keys().copied().collect::<Vec<_>>(), [wall]);
}

#[test]
fn pixels_are_owned_by_what_a_scan_of_all_things_finds_first() {
    let mut rng = rng(60);
    let mut app = headless_app();
    let city = City::build(&mut app, 120, 5);
    let size = UVec2::new(48, 27);
    let camera = spawn_view(&mut app, size, city.view(1, &mut rng));
    settle(&mut app);
    let mut parts = app.world_mut().query_filtered::<Entity, With<Part>>();
    let things: Vec<Entity> = parts.iter(app.world()).collect();
    for number in 0..4 {
        let place = city.view(number, &mut rng);
        app.world_mut().entity_mut(camera).insert(place);
        app.update();
        let owners = Owners::find(&mut app, camera, size);
        let projection = app.world().get::<Projection>(camera).expect("a camera").clone();
        let mut view = Camera::default();
        view.computed.clip_from_view = projection.get_clip_from_view();
        let place = GlobalTransform::from(place);
        query(&mut app, |scene| {
            for (number, owner) in (0..).zip(&owners.of_pixels) {
                let pixel = UVec2::new(number % size.x, number / size.x).as_vec2() + 0.5;
                let ndc = (pixel / size.as_vec2() * 2.0 - 1.0) * Vec2::new(1.0, -1.0);
                let near = view.ndc_to_world(&place, ndc.extend(1.0)).expect("a point");
                let ray = Ray3d::new(near, Dir3::new(near - place.translation()).expect("a direction"));
                let distance_to = |thing: Entity| {
                    let is_it = |other| other == thing;
                    let alone = SceneQuerySettings::default().filter(&is_it);
                    scene.cast_ray(ray, &alone).map_or(f32::INFINITY, |hit| hit.distance)
                };
                let nearest = things
                    .iter()
                    .map(|&thing| distance_to(thing))
                    .fold(f32::INFINITY, f32::min);
                let found = owner.map_or(f32::INFINITY, distance_to);
                // The two rays differ in their last digits: at an outline one may miss what the other meets.
                let is_same = found == nearest || (found - nearest).abs() < 1e-3 * nearest;
                assert!(is_same, "{pixel}: {owner:?} at {found}, and something at {nearest}");
            }
        });
    }
}

#[test]
fn in_a_street_most_things_are_hidden_and_over_the_roofs_many_are_not() {
    let mut rng = rng(61);
    let mut app = headless_app();
    let city = City::build(&mut app, 2000, 6);
    let size = UVec2::new(320, 180);
    let camera = spawn_view(&mut app, size, Transform::default());
    settle(&mut app);
    let mut owned = [0; 4];
    for number in 0..40 {
        app.world_mut().entity_mut(camera).insert(city.view(number, &mut rng));
        app.update();
        let shares = Owners::find(&mut app, camera, size).shares();
        owned[number as usize % 4] += shares.len() / 10;
    }
    let [street, crossing, pavement, roofs] = owned;
    assert!((5..400).contains(&street) && (5..400).contains(&crossing), "{owned:?}");
    assert!(pavement < 400 && roofs > street, "{owned:?}");
}
