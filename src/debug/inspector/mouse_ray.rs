//! The ray under the mouse, as long as it is over the scene.

use bevy::{
    camera::Camera,
    ecs::{
        change_detection::{Res, ResMut},
        entity::Entity,
        resource::Resource,
        system::Query,
    },
    math::Ray3d,
    picking::{backend::ray::RayMap, pointer::PointerId},
};
use bevy_egui::input::EguiWantsInput;

/// The last ray under the mouse, with its camera.
#[derive(Resource, Debug, Default)]
pub(super) struct MouseRay {
    pub ray: Option<(Entity, Ray3d)>,
    /// It stays, wherever the mouse goes.
    pub is_held: bool,
    /// Of this frame: egui tells only in the next one whether the mouse was over the panel.
    newest: Option<(Entity, Ray3d)>,
}

/// Follows the mouse while it is not over the panel. Of several cameras under it, the one that draws last.
pub(super) fn follow_mouse(
    rays: Option<Res<RayMap>>,
    cameras: Query<&Camera>,
    egui: Option<Res<EguiWantsInput>>,
    mut mouse: ResMut<MouseRay>,
) {
    let of_mouse = rays.iter().flat_map(|rays| rays.iter());
    let of_mouse = of_mouse.filter(|(id, _)| id.pointer == PointerId::Mouse);
    let last = of_mouse.max_by_key(|(id, _)| (cameras.get(id.camera).map_or(0, |camera| camera.order), id.camera));
    let newest = last.map(|(id, ray)| (id.camera, *ray));
    let before = std::mem::replace(&mut mouse.newest, newest);
    let of_scene = match egui {
        Some(egui) => before.filter(|_| !egui.wants_any_pointer_input()),
        None => newest,
    };
    if !mouse.is_held && of_scene.is_some() {
        mouse.ray = of_scene;
    }
}
