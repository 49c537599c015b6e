//! What is known of single entities.

use bevy::{
    camera::primitives::Frustum,
    color::Color,
    ecs::{entity::Entity, system::Query},
    gizmos::gizmos::Gizmos,
    math::{Affine3A, bounding::Aabb3d},
    transform::components::GlobalTransform,
};

use super::{
    GizmoCount, ShowGizmos, SightlineGizmos,
    draw::{FRUSTUM, LEAF, VOLUME, World, visit_occluder_boxes},
    lods::GroupInView,
    nearest::Nearest,
    shapes::{BOX_LINES, Pen},
    views::Views,
    volumes::{Volumes, Wanted},
};
use crate::geometry::volume::BoundingKind;

/// What is drawn of an entity: a shape.
enum Part<'a> {
    Box(Aabb3d, Affine3A, Color),
    Volume(Entity, Aabb3d, BoundingKind),
    Group(GroupInView),
    Frustum(&'a Frustum),
}

/// Draws what [`ShowGizmos`] asks for, of the nearest entities first, in view or not.
pub(super) fn draw_entities(
    world: &World,
    views: &Views,
    shown: &Query<(Entity, &ShowGizmos)>,
    wanted: &mut Wanted,
    gizmos: &mut Gizmos<SightlineGizmos>,
) -> GizmoCount {
    let config = gizmos.config_ext;
    let mut nearest = Nearest::new(config.limit, BOX_LINES);
    for (entity, show) in shown {
        let aabb = world.index.aabb(entity);
        let place = world.places.get(entity).ok();
        let at = place.map(GlobalTransform::translation_vec3a);
        let around = aabb.or(at.map(|at| Aabb3d { min: at, max: at }));
        let distance = around.map_or(0.0, |around| views.distance_squared(&around));
        visit_parts(world, (entity, show), |part| nearest.offer(distance, part));
    }
    let mut volumes = Volumes {
        index: &world.index,
        meshes: &world.meshes,
        wanted,
    };
    nearest.draw(|part, left| {
        let mut pen = Pen { gizmos: &mut *gizmos };
        match part {
            Part::Volume(entity, aabb, kind) => volumes.draw(gizmos, (entity, &aabb), kind, VOLUME, left),
            Part::Box(local, place, color) if left >= BOX_LINES => pen.placed_box(&local, &place, color),
            Part::Frustum(frustum) if left >= BOX_LINES => pen.frustum(frustum, FRUSTUM),
            Part::Group(group) => {
                let choices = world
                    .choices
                    .as_deref()
                    .filter(|choices| group.most_lines(choices) <= left)?;
                let sphere = group.draw_sphere(gizmos, &config.palette, left)?;
                Some(sphere + group.draw_distances(gizmos, choices, &config.palette))
            }
            Part::Box(..) | Part::Frustum(_) => None,
        }
    })
}

/// Visits all that is asked for and there.
fn visit_parts<'a>(world: &'a World, (entity, show): (Entity, &ShowGizmos), mut visit: impl FnMut(Part<'a>)) {
    if let Some(aabb) = world.index.aabb(entity) {
        if show.leaf {
            visit(Part::Box(aabb, Affine3A::IDENTITY, LEAF));
        }
        if let Some(kind) = show.volume {
            visit(Part::Volume(entity, aabb, kind));
        }
    }
    if show.occluder
        && let Some(occluders) = &world.occluders
    {
        visit_occluder_boxes(occluders, entity, |local, place, color| {
            visit(Part::Box(local, *place, color));
        });
    }
    if show.lod
        && let Some(choices) = &world.choices
        && let Ok(place) = world.places.get(entity)
        && let Some(group) = GroupInView::find(choices, entity, place)
    {
        visit(Part::Group(group));
    }
    if show.frustum
        && let Some(frustum) = world.cameras.frustum(entity)
    {
        visit(Part::Frustum(frustum));
    }
}
