//! What is switched on for the whole scene.

use bevy::{
    color::{
        Color,
        palettes::tailwind::{AMBER_300, CYAN_300, FUCHSIA_400, SLATE_300, VIOLET_400},
    },
    ecs::{
        change_detection::{Res, ResMut},
        entity::Entity,
        resource::Resource,
        system::{Local, Query, SystemParam},
    },
    gizmos::gizmos::Gizmos,
    math::{Affine3A, bounding::Aabb3d},
    transform::components::GlobalTransform,
};

use super::{
    GizmoCount, ShowGizmos, SightlineGizmoStats, SightlineGizmos,
    entities::draw_entities,
    lods::GroupInView,
    nearest::Nearest,
    scene::{Seen, find_in_view},
    shapes::{BOX_LINES, Pen, SPHERE_LINES},
    structures::Cells,
    views::{Cameras, Views},
    volumes::{Volumes, Wanted},
};
use crate::{
    geometry::volume::Volume,
    index::{MeshBvhs, SpatialIndex},
    lod::LodChoices,
    occlusion::{OccluderShape, Occluders},
    phase::phase,
};

/// The systems that draw are there.
#[derive(Resource, Debug, Default)]
pub(super) struct Begun;

pub(super) const LEAF: Color = Color::Srgba(SLATE_300);
pub(super) const VOLUME: Color = Color::Srgba(FUCHSIA_400);
pub(super) const FRUSTUM: Color = Color::Srgba(AMBER_300);
pub(super) const OCCLUDER: Color = Color::Srgba(VIOLET_400);
/// What occludes by triangles.
pub(super) const OCCLUDING_MESH: Color = Color::Srgba(CYAN_300);

/// All that is drawn from.
#[derive(SystemParam)]
pub(super) struct World<'w, 's> {
    pub cameras: Cameras<'w, 's>,
    pub index: Res<'w, SpatialIndex>,
    pub meshes: Res<'w, MeshBvhs>,
    pub occluders: Option<Res<'w, Occluders>>,
    pub choices: Option<Res<'w, LodChoices>>,
    pub places: Query<'w, 's, &'static GlobalTransform>,
}

/// Draws all but the rays of pointers.
pub(super) fn draw_all(
    world: World,
    shown: Query<(Entity, &ShowGizmos)>,
    mut wanted: ResMut<Wanted>,
    mut stats: ResMut<SightlineGizmoStats>,
    mut seen: Local<Vec<Seen>>,
    mut gizmos: Gizmos<SightlineGizmos>,
) {
    *stats = SightlineGizmoStats::default();
    let is_anything_on = gizmos.config_ext.is_any_on() || !shown.is_empty();
    if !(gizmos.config.enabled && is_anything_on) {
        return;
    }
    let phase = phase!("sightline/gizmos/draw");
    let config = gizmos.config_ext;
    let views = world.cameras.views(&gizmos.config.render_layers);
    if config.nodes {
        stats.nodes = cells(config, &views).draw(&mut gizmos, |cells| {
            world.index.descend_nodes(|depth, aabb| cells.descend(depth, aabb));
        });
    }
    if config.cells
        && let Some(grid) = world.index.ask_grid()
    {
        stats.cells = cells(config, &views).draw(&mut gizmos, |cells| cells.of_grid(grid));
    }
    if config.leaves || config.volumes.is_some() || config.occluders {
        find_in_view(&world.index, &views, &mut seen);
    }
    if config.leaves {
        stats.leaves = draw_leaves(&seen, &mut gizmos);
    }
    if let Some(kind) = config.volumes {
        let mut nearest = Nearest::new(config.limit, BOX_LINES);
        seen.iter().for_each(|seen| nearest.offer(seen.distance_squared, *seen));
        let mut volumes = Volumes {
            index: &world.index,
            meshes: &world.meshes,
            wanted: &mut wanted,
        };
        stats.volumes =
            nearest.draw(|seen, left| volumes.draw(&mut gizmos, (seen.entity, &seen.aabb), kind, VOLUME, left));
    }
    if config.frusta {
        stats.frusta = draw_frusta(&world.cameras, &mut gizmos);
    }
    if config.occluders
        && let Some(occluders) = &world.occluders
    {
        stats.occluders = draw_occluders(&seen, occluders, &mut gizmos);
    }
    if config.lods
        && let Some(choices) = &world.choices
    {
        stats.lods = draw_groups(choices, &world.places, &views, &mut gizmos);
    }
    if !shown.is_empty() {
        stats.entities = draw_entities(&world, &views, &shown, &mut wanted, &mut gizmos);
    }
    seen.clear();
    stats.draw = phase.end();
}

fn cells<'a>(config: &'a SightlineGizmos, views: &'a Views) -> Cells<'a> {
    Cells::in_view(&config.depths, &config.palette, config.limit, views)
}

fn draw_leaves(seen: &[Seen], gizmos: &mut Gizmos<SightlineGizmos>) -> GizmoCount {
    let mut nearest = Nearest::new(gizmos.config_ext.limit, BOX_LINES);
    seen.iter()
        .for_each(|seen| nearest.offer(seen.distance_squared, seen.aabb));
    nearest.draw(|aabb, left| {
        let fits = left >= BOX_LINES;
        fits.then(|| Pen { gizmos: &mut *gizmos }.aabb(&aabb, LEAF)).flatten()
    })
}

fn draw_frusta(cameras: &Cameras, gizmos: &mut Gizmos<SightlineGizmos>) -> GizmoCount {
    let mut all = Nearest::new(gizmos.config_ext.limit, BOX_LINES);
    cameras.frusta().for_each(|frustum| all.offer(0.0, frustum));
    all.draw(|frustum, left| {
        let fits = left >= BOX_LINES;
        fits.then(|| Pen { gizmos: &mut *gizmos }.frustum(frustum, FRUSTUM))
            .flatten()
    })
}

fn draw_occluders(seen: &[Seen], occluders: &Occluders, gizmos: &mut Gizmos<SightlineGizmos>) -> GizmoCount {
    let mut nearest = Nearest::new(gizmos.config_ext.limit, BOX_LINES);
    if !occluders.is_empty() {
        for seen in seen {
            visit_occluder_boxes(occluders, seen.entity, |local, place, color| {
                nearest.offer(seen.distance_squared, (local, *place, color));
            });
        }
    }
    nearest.draw(|(local, place, color), left| {
        let fits = left >= BOX_LINES;
        fits.then(|| Pen { gizmos: &mut *gizmos }.placed_box(&local, &place, color))
            .flatten()
    })
}

/// Visits the boxes by which an entity occludes, in its space, with the place of that; of triangles, the box around them.
pub(super) fn visit_occluder_boxes(
    occluders: &Occluders,
    entity: Entity,
    mut visit: impl FnMut(Aabb3d, &Affine3A, Color),
) {
    match occluders.get(entity) {
        Some((OccluderShape::Boxes(boxes), place)) => boxes.iter().for_each(|&local| visit(local, place, OCCLUDER)),
        Some((OccluderShape::Mesh(mesh), place)) => {
            if let Some(local) = mesh.aabb() {
                visit(local, place, OCCLUDING_MESH);
            }
        }
        None => {}
    }
}

fn draw_groups(
    choices: &LodChoices,
    places: &Query<&GlobalTransform>,
    views: &Views,
    gizmos: &mut Gizmos<SightlineGizmos>,
) -> GizmoCount {
    let config = gizmos.config_ext;
    let mut nearest = Nearest::new(config.limit, SPHERE_LINES);
    for root in choices.roots() {
        let Some(group) = places
            .get(root)
            .ok()
            .and_then(|place| GroupInView::find(choices, root, place))
        else {
            continue;
        };
        let around = group.sphere.aabb();
        if views.may_see(&around) && group.is_shown(choices) {
            nearest.offer(views.distance_squared(&around), group);
        }
    }
    nearest.draw(|group, left| group.draw_sphere(gizmos, &config.palette, left))
}
