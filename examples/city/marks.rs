//! What is drawn around what is under the mouse, and around what is selected.

use bevy::{
    camera::primitives::Aabb,
    color::palettes::tailwind::{SKY_500, YELLOW_300},
    picking::pointer::PointerInteraction,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    interaction::{Hovered, Selected},
    scenery::Thing,
};

/// As many selected things have a box.
const MOST_BOXES: usize = 500;

pub fn window_plugin(app: &mut App) {
    // Later than all that moves, so that the boxes do not lag behind.
    app.add_systems(PostUpdate, (draw_hit, draw_boxes).after(TransformSystems::Propagate));
}

/// Draws the triangle that was hit, as far as is known which, and the normal there.
fn draw_hit(pointers: Query<&PointerInteraction>, mut gizmos: Gizmos) {
    for (_, hit) in pointers.iter().filter_map(PointerInteraction::get_nearest_hit) {
        let (Some(position), Some(normal)) = (hit.position, hit.normal) else {
            continue;
        };
        let normal = normal.normalize_or_zero();
        if let Some(triangle) = hit.extra_as::<RayHit>().and_then(|hit| hit.triangle) {
            // A little in front of the surface, so as not to flicker.
            let lift = normal * 0.002 * hit.depth;
            gizmos.lineloop(triangle.vertices.map(|vertex| vertex + lift), YELLOW_300);
        }
        gizmos.arrow(position, position + normal * 0.08 * hit.depth, YELLOW_300);
    }
}

/// Draws the bounds of what is under the pointer in white, and of what is selected in blue.
fn draw_boxes(
    hovered: Query<(&Aabb, &GlobalTransform), (With<Thing>, With<Hovered>)>,
    selected: Query<(&Aabb, &GlobalTransform), (With<Thing>, With<Selected>)>,
    mut gizmos: Gizmos,
) {
    let hovered = hovered.iter().map(|bounds| (bounds, Srgba::WHITE));
    let selected = selected.iter().take(MOST_BOXES).map(|bounds| (bounds, SKY_500));
    for ((aabb, place), color) in hovered.chain(selected) {
        let fit = Transform::from_translation(aabb.center.into()).with_scale(2.0 * Vec3::from(aabb.half_extents));
        gizmos.cube(place.mul_transform(fit), color);
    }
}
