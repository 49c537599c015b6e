//! What happens to cameras.

use std::any::TypeId;

use bevy::{
    camera::{
        CameraProjection, RenderTarget, ShadowLodOrigin, SubCameraView, Viewport,
        primitives::Frustum,
        visibility::{NoCpuCulling, RenderLayers, VisibleEntities},
    },
    ecs::entity_disabling::Disabled,
    math::{Vec3A, primitives::HalfSpace},
    prelude::*,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::{
    cast::{Cast, Change, Role, Way},
    things::{self, SIZE, random_layers},
};
use crate::common::{random_point, random_rotation};

/// More of them are not spawned.
const MOST: usize = 5;

pub const WAYS: &[Way] = &[
    (20, move_a_camera),
    (20, turn_a_camera),
    (6, look_elsewhere),
    (2, look_out_of_the_world),
    (6, switch_a_camera),
    (5, change_projection),
    (3, have_planes_by_hand),
    (4, have_layers),
    (2, lose_layers),
    (2, toggle::<NoCpuCulling>),
    (1, toggle::<ShadowLodOrigin>),
    (2, toggle::<Disabled>),
    (2, show_part_of_a_view),
    (1, render_nowhere),
    (2, be_carried),
    (3, have_its_lists_tampered_with),
    (1, lose_its_lists),
    (1, have_new_lists),
    (1, be_no_camera_and_then_again),
    (3, spawn),
    (2, despawn),
    (2, be_replaced),
    (4, move_a_carrier),
];

/// An off-centre perspective without a far plane.
#[derive(Clone, Debug)]
struct OffCentre {
    full: PerspectiveProjection,
    window: SubCameraView,
}

impl CameraProjection for OffCentre {
    fn get_clip_from_view(&self) -> Mat4 {
        self.full.get_clip_from_view_for_sub(&self.window)
    }

    fn get_clip_from_view_for_sub(&self, sub_view: &SubCameraView) -> Mat4 {
        self.full.get_clip_from_view_for_sub(sub_view)
    }

    fn update(&mut self, _: f32, _: f32) {}

    fn far(&self) -> f32 {
        f32::INFINITY
    }

    fn get_frustum_corners(&self, z_near: f32, z_far: f32) -> [Vec3A; 8] {
        self.full.get_frustum_corners(z_near, z_far)
    }
}

fn any_camera(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Entity> {
    cast.any(Role::Camera, rng)
}

fn toggle<C: Component + Default>(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_camera(rng, cast).map(|entity| Change::toggle::<C>(entity, rng))
}

fn random_projection(rng: &mut ChaCha8Rng) -> Projection {
    let perspective = PerspectiveProjection {
        fov: rng.random_range(0.2..2.0),
        aspect_ratio: rng.random_range(0.3..3.0),
        near: rng.random_range(0.05..2.0),
        far: rng.random_range(10.0..100.0),
        ..default()
    };
    match rng.random_range(0..9) {
        0 => PerspectiveProjection {
            far: f32::INFINITY,
            ..perspective
        }
        .into(),
        // No space at all, or none that numbers can tell.
        1 => PerspectiveProjection {
            fov: [0.0, f32::NAN, 7.0][rng.random_range(0..3)],
            ..perspective
        }
        .into(),
        // With a slanted near plane.
        2 => PerspectiveProjection {
            near_clip_plane: Vec4::new(0.3, 0.2, -0.9, -1.0),
            ..perspective
        }
        .into(),
        3 | 4 => {
            let half = Vec2::new(rng.random_range(1.0..30.0), rng.random_range(1.0..30.0));
            OrthographicProjection {
                area: Rect::from_center_half_size(random_point(rng, 5.0).truncate(), half),
                near: rng.random_range(-20.0..1.0),
                far: rng.random_range(5.0..100.0),
                ..OrthographicProjection::default_3d()
            }
            .into()
        }
        5 | 6 => Projection::custom(OffCentre {
            full: perspective,
            window: SubCameraView {
                full_size: UVec2::new(100, 80),
                offset: Vec2::new(rng.random_range(-90.0..90.0), rng.random_range(0.0..60.0)),
                size: UVec2::new(rng.random_range(1..60), 20),
            },
        }),
        _ => perspective.into(),
    }
}

/// Planes that no projection gives: none, all alike, all over the place, not numbers.
fn random_planes(rng: &mut ChaCha8Rng) -> Frustum {
    let kind = rng.random_range(0..4);
    let mut frustum = Frustum::default();
    for half_space in &mut frustum.half_spaces {
        *half_space = match kind {
            0 => HalfSpace::default(),
            1 => HalfSpace::new(Vec4::ZERO),
            2 => HalfSpace::new(Vec4::new(1.0, 0.0, 0.0, f32::NAN)),
            _ => HalfSpace::new(random_point(rng, 1.0).extend(rng.random_range(-5.0..30.0))),
        };
    }
    frustum
}

/// Mostly with something in front.
fn random_place(rng: &mut ChaCha8Rng) -> Transform {
    let place = Transform::from_translation(random_point(rng, 1.5 * SIZE));
    match rng.random_range(0..4) {
        0 => place.with_rotation(random_rotation(rng)),
        _ => place.looking_at(random_point(rng, 0.5 * SIZE), Vec3::Y),
    }
}

fn move_a_camera(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let by = random_point(rng, 4.0);
    let edit = move |place: &mut Transform| place.translation += by;
    Some(Change::edit(any_camera(rng, cast)?, &format!("moves by {by}"), edit))
}

fn turn_a_camera(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let angle = rng.random_range(-1.0..1.0);
    let edit = move |place: &mut Transform| place.rotate_y(angle);
    Some(Change::edit(
        any_camera(rng, cast)?,
        &format!("turns by {angle} rad"),
        edit,
    ))
}

fn look_elsewhere(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let place = random_place(rng);
    Some(Change::insert(
        any_camera(rng, cast)?,
        &format!("looks from {place:?}"),
        place,
    ))
}

fn look_out_of_the_world(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let place = Transform::from_xyz(3.0 * SIZE, 0.0, 0.0).looking_to(Vec3::X, Vec3::Y);
    Some(Change::insert(any_camera(rng, cast)?, "looks out of the world", place))
}

fn switch_a_camera(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let is_active = rng.random_bool(0.7);
    let edit = move |camera: &mut Camera| camera.is_active = is_active;
    Some(Change::edit(
        any_camera(rng, cast)?,
        &format!("is active: {is_active}"),
        edit,
    ))
}

fn change_projection(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let projection = random_projection(rng);
    Some(Change::insert(
        any_camera(rng, cast)?,
        &format!("has {projection:?}"),
        projection,
    ))
}

/// They stay until the camera moves, if it has a projection.
fn have_planes_by_hand(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let planes = random_planes(rng);
    let edit = move |frustum: &mut Frustum| *frustum = planes;
    Some(Change::edit(any_camera(rng, cast)?, &format!("has {planes:?}"), edit))
}

fn have_layers(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (camera, layers) = (any_camera(rng, cast)?, random_layers(rng));
    Some(Change::insert(camera, &format!("has {layers:?}"), layers))
}

fn lose_layers(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_camera(rng, cast).map(Change::remove::<RenderLayers>)
}

/// Changes nothing of what is seen.
fn show_part_of_a_view(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let camera = any_camera(rng, cast)?;
    Some(Change::edit(
        camera,
        "shows a part of its view",
        |camera: &mut Camera| {
            camera.viewport = Some(Viewport::default());
            camera.sub_camera_view = Some(SubCameraView::default());
        },
    ))
}

fn render_nowhere(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let camera = any_camera(rng, cast)?;
    let nowhere = RenderTarget::None { size: UVec2::ONE };
    Some(Change::insert(camera, "renders nowhere", nowhere))
}

fn be_carried(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (camera, carrier) = (any_camera(rng, cast)?, cast.any(Role::Carrier, rng)?);
    Some(Change::insert(
        camera,
        &format!("is carried by {carrier}"),
        ChildOf(carrier),
    ))
}

fn have_its_lists_tampered_with(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (camera, thing) = (any_camera(rng, cast)?, cast.any(Role::Thing, rng)?);
    let what = format!("lists {thing} because somebody says so");
    Some(Change::edit(camera, &what, move |lists: &mut VisibleEntities| {
        lists.push(thing, TypeId::of::<Mesh3d>());
    }))
}

fn lose_its_lists(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_camera(rng, cast).map(Change::remove::<VisibleEntities>)
}

fn have_new_lists(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let camera = any_camera(rng, cast)?;
    Some(Change::insert(camera, "has new lists", VisibleEntities::default()))
}

/// Its lists stay as they are for as long as it is none.
fn be_no_camera_and_then_again(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let camera = any_camera(rng, cast)?;
    Some(if rng.random() {
        Change::remove::<Camera>(camera)
    } else {
        Change::insert(camera, "is a camera", Camera::default())
    })
}

pub fn spawn(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    if cast.count(Role::Camera) >= MOST {
        return None;
    }
    let (kind, place) = (rng.random_range(0..6), random_place(rng));
    let (projection, planes) = (random_projection(rng), random_planes(rng));
    let what = format!("is spawned, a camera of kind {kind} at {place:?} with {projection:?} or {planes:?}");
    Some(Change::spawn(Role::Camera, what, move |world, camera| {
        let mut camera = world.entity_mut(camera);
        camera.insert(place);
        match kind {
            0 => camera.insert(Camera2d),
            1 => camera.insert((Camera::default(), planes)),
            2 => camera.insert((Camera::default(), projection.clone())),
            _ => camera.insert((Camera3d::default(), projection.clone())),
        };
    }))
}

fn despawn(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_camera(rng, cast).map(Change::despawn)
}

/// By another camera, or by a thing.
fn be_replaced(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let camera = any_camera(rng, cast)?;
    let successor = if rng.random() { spawn } else { things::spawn };
    Some(successor(rng, cast)?.in_place_of(camera))
}

pub fn spawn_carrier(rng: &mut ChaCha8Rng) -> Change {
    let place = random_place(rng);
    let what = format!("is spawned, a carrier at {place:?}");
    Change::spawn(Role::Carrier, what, move |world, carrier| {
        world.entity_mut(carrier).insert((place, Visibility::default()));
    })
}

fn move_a_carrier(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let to = random_place(rng);
    let edit = move |place: &mut Transform| *place = to;
    Some(Change::edit(
        cast.any(Role::Carrier, rng)?,
        &format!("carries to {to:?}"),
        edit,
    ))
}
