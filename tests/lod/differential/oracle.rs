//! Which level each view shows, by the documentation alone: anew in every frame, for all groups, in double precision.

use std::collections::HashMap;

use bevy::{
    camera::{ShadowLodOrigin, primitives::Aabb},
    math::{DAffine3, DMat4, DVec3},
};

use super::*;

/// By so much of a threshold, single precision may differ.
const TOLERANCE: f64 = 1e-5;

/// Who looks: a camera or another origin, for itself or for shadow maps.
pub type Looker = (Entity, bool);

/// Knows what was chosen in the last frame, for hysteresis.
#[derive(Default)]
pub struct Oracle {
    wanted: HashMap<(Entity, Looker), usize>,
    /// Everything about this frame.
    groups: HashMap<Entity, Known>,
    lookers: HashMap<Looker, Sight>,
    listed: HashMap<Entity, Vec<(Entity, u32)>>,
    /// What may be part of bounds.
    bodies: Vec<Entity>,
    bounds: HashMap<Entity, Option<(DVec3, DVec3)>>,
    pub main: Option<Entity>,
    follows_cameras: bool,
}

struct Known {
    lod: ProxyLod,
    available: u32,
    shown: HashMap<Looker, usize>,
}

#[derive(Clone)]
struct Sight {
    eye: DVec3,
    clip_from_view: DMat4,
    height: f64,
    bias: f64,
}

impl Known {
    fn is_swapped(&self) -> bool {
        matches!(self.lod.levels[0].content, LodContent::Mesh(_))
    }
}

fn place(world: &World, entity: Entity) -> Option<DAffine3> {
    Some(world.get::<GlobalTransform>(entity)?.affine().as_daffine3())
}

/// The box around a transformed box.
fn moved(place: &DAffine3, (min, max): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let corners = (0..8).map(|corner| {
        let pick = |axis: usize| if corner >> axis & 1 == 1 { max[axis] } else { min[axis] };
        place.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    });
    corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corner| {
        (low.min(corner), high.max(corner))
    })
}

fn as_box(aabb: &Aabb) -> (DVec3, DVec3) {
    (aabb.min().as_dvec3(), aabb.max().as_dvec3())
}

impl Oracle {
    /// The group to which an entity belongs, with its levels there, one bit for each.
    fn owner(&self, world: &World, entity: Entity) -> Option<(Entity, u32)> {
        match self.groups.get(&entity) {
            Some(own) if own.is_swapped() => {
                let meshes = own.lod.levels.iter().enumerate();
                let shown = meshes.filter(|(_, level)| level.content != LodContent::Nothing);
                Some((entity, shown.fold(0, |bits, (number, _)| bits | 1 << number)))
            }
            _ => self.holder(world, entity),
        }
    }

    /// The group whose level lists an entity, or the nearest of what it is below.
    fn holder(&self, world: &World, entity: Entity) -> Option<(Entity, u32)> {
        let mut at = entity;
        loop {
            let by = self.listed.get(&at).into_iter().flatten();
            if let Some(&by) = by.clone().find(|&&(root, _)| root != entity) {
                return Some(by);
            }
            at = world.get::<ChildOf>(at)?.parent();
        }
    }

    /// Whether a view shows an entity.
    pub fn shows(&self, world: &World, looker: Looker, entity: Entity) -> bool {
        let mut within = self.owner(world, entity);
        while let Some((root, levels)) = within {
            if levels >> self.level(root, looker) & 1 == 0 {
                return false;
            }
            within = self.holder(world, root);
        }
        true
    }

    /// The level that a view shows of a group.
    pub fn level(&self, root: Entity, looker: Looker) -> usize {
        let group = &self.groups[&root];
        let looker = match (group.is_swapped(), self.main) {
            (true, Some(main)) => (main, false),
            (true, None) => return 0,
            (false, _) if self.follows_cameras => (looker.0, false),
            (false, _) => looker,
        };
        group.shown.get(&looker).copied().unwrap_or(0)
    }

    /// The bounds of a group in the space of its root.
    fn bounds(&self, world: &World, root: Entity) -> Option<(DVec3, DVec3)> {
        let group = &self.groups[&root];
        if let Some(given) = &group.lod.bounds {
            return Some(as_box(given));
        }
        if group.is_swapped() {
            return world.get::<Aabb>(root).map(as_box);
        }
        let root_from_world = place(world, root)?.inverse();
        let is_first = |within: Option<(Entity, u32)>| within.is_some_and(|(by, levels)| by == root && levels & 1 == 1);
        let mut around: Option<(DVec3, DVec3)> = None;
        for &entity in &self.bodies {
            let bounds = if self.groups.contains_key(&entity) && is_first(self.holder(world, entity)) {
                self.bounds(world, entity)
            } else if is_first(self.owner(world, entity)) {
                world.get::<Aabb>(entity).map(as_box)
            } else {
                None
            };
            if let Some((bounds, world_from_entity)) = bounds.zip(place(world, entity)) {
                let (min, max) = moved(&(root_from_world * world_from_entity), bounds);
                let (low, high) = around.unwrap_or((min, max));
                around = Some((low.min(min), high.max(max)));
            }
        }
        around
    }

    /// By how much each level is not enough: it is enough from one down.
    fn lacks(&self, world: &World, root: Entity, sight: &Sight) -> Option<Vec<f64>> {
        let lod = &self.groups[&root].lod;
        let (min, max) = self.bounds[&root]?;
        let world_from_root = place(world, root)?;
        let half = (max - min) / 2.0;
        let center = world_from_root.transform_point3((min + max) / 2.0);
        let corner = |signs: DVec3| (world_from_root.matrix3 * (half * signs)).length();
        let diameter = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(y, z)| 2.0 * corner(DVec3::new(1.0, y, z)))
            .into_iter()
            .fold(0.0, f64::max);
        let matrix = world_from_root.matrix3;
        let stretch = [matrix.x_axis, matrix.y_axis, matrix.z_axis]
            .map(DVec3::length)
            .into_iter()
            .fold(0.0, f64::max);
        let distance = match lod.reference {
            LodReference::Center => center.distance(sight.eye),
            LodReference::NearestPoint => {
                let (min, max) = moved(&world_from_root, (min, max));
                sight.eye.clamp(min, max).distance(sight.eye)
            }
        };
        // A unit at distance one, or anywhere, as a fraction of the viewport.
        let is_orthographic = sight.clip_from_view.w_axis.w == 1.0;
        let unit = sight.clip_from_view.y_axis.y / 2.0;
        let away = if is_orthographic { 1.0 } else { distance };
        let bias = sight.bias * f64::from(lod.bias);
        let lacks = lod.levels.iter().skip(1).map(|level| {
            let threshold = f64::from(level.threshold);
            let (seen, allowed) = match lod.metric {
                LodMetric::Height => (diameter * unit * bias / away, threshold),
                LodMetric::PixelError(pixels) => (
                    threshold * stretch * unit * sight.height * bias / away,
                    f64::from(pixels),
                ),
                LodMetric::Distance => (threshold * bias / distance, 1.0),
            };
            seen / allowed
        });
        Some(std::iter::once(0.0).chain(lacks).collect())
    }

    /// Brings everything up to date. What is chosen on a threshold is taken from `found`, which must be one of both.
    pub fn choose(&mut self, world: &mut World, found: impl Fn(&World, Entity, Entity) -> Option<usize>) {
        let settings = *world.resource::<LodSettings>();
        let mut lods = world.query::<(Entity, &ProxyLod)>();
        let mut cameras = world.query::<(Entity, &Camera, &Projection, &GlobalTransform, Option<&LodBias>)>();
        let mut origins =
            world.query_filtered::<(Entity, &GlobalTransform), (With<ShadowLodOrigin>, Without<Camera>)>();
        let mut bodies = world.query_filtered::<Entity, Or<(With<Aabb>, With<ProxyLod>)>>();
        let world = &*world;
        self.listed.clear();
        self.groups.clear();
        for (root, lod) in lods.iter(world) {
            let mut available = 0;
            for (number, level) in lod.levels.iter().enumerate() {
                let LodContent::Entities(entities) = &level.content else {
                    available |= 1 << number;
                    continue;
                };
                for &entity in entities.iter().filter(|&&entity| world.get_entity(entity).is_ok()) {
                    let by = self.listed.entry(entity).or_default();
                    match by.iter_mut().find(|(by, _)| *by == root) {
                        Some((_, levels)) => *levels |= 1 << number,
                        None => by.push((root, 1 << number)),
                    }
                    available |= 1 << number;
                }
            }
            let lod = lod.clone();
            self.groups.insert(
                root,
                Known {
                    lod,
                    available,
                    shown: HashMap::new(),
                },
            );
        }

        self.bodies = bodies.iter(world).collect();
        self.bounds = self
            .groups
            .keys()
            .map(|&root| (root, self.bounds(world, root)))
            .collect();
        self.lookers.clear();
        self.follows_cameras = settings.shadow_bias == 1.0;
        let mut main: Option<(isize, Entity)> = None;
        let mut look = |entity: Entity, sight: Sight| {
            let shadow = Sight {
                bias: sight.bias * f64::from(settings.shadow_bias),
                ..sight.clone()
            };
            self.lookers.insert((entity, false), sight);
            if settings.shadow_bias != 1.0 {
                self.lookers.insert((entity, true), shadow);
            }
        };
        for (entity, camera, projection, place, bias) in cameras.iter(world).filter(|(_, camera, ..)| camera.is_active)
        {
            let size = camera.physical_viewport_size();
            look(
                entity,
                Sight {
                    eye: place.translation().as_dvec3(),
                    clip_from_view: projection.get_clip_from_view().as_dmat4(),
                    height: size.map_or(f64::from(settings.viewport_height), |size| f64::from(size.y)),
                    bias: f64::from(bias.map_or(1.0, |bias| bias.0)) * f64::from(settings.bias),
                },
            );
            if main.is_none_or(|main| (camera.order, entity) < main) {
                main = Some((camera.order, entity));
            }
        }
        for (entity, place) in origins.iter(world) {
            look(
                entity,
                Sight {
                    eye: place.translation().as_dvec3(),
                    clip_from_view: Projection::default().get_clip_from_view().as_dmat4(),
                    height: f64::from(settings.viewport_height),
                    bias: f64::from(settings.bias),
                },
            );
        }
        self.main = main.map(|(_, camera)| camera);

        let before = std::mem::take(&mut self.wanted);
        let roots: Vec<Entity> = self.groups.keys().copied().collect();
        for root in roots {
            for (&looker, sight) in &self.lookers {
                let group = &self.groups[&root];
                let last = group.lod.levels.len() - 1;
                let known = before
                    .get(&(root, looker))
                    .copied()
                    .filter(|&level| level <= last)
                    .unwrap_or(0);
                let lacks = self.lacks(world, root, sight);
                let choose = |by: f64| {
                    let Some(lacks) = &lacks else { return 0 };
                    let enough = |level: usize, stay: f64| lacks[level] * stay * by <= 1.0;
                    let coarsest = |stay| (0..=last).rev().find(|&level| enough(level, stay)).unwrap_or(0);
                    let without = coarsest(1.0);
                    let stay = 1.0 + f64::from(settings.hysteresis);
                    if without < known {
                        without
                    } else {
                        known.max(coarsest(stay))
                    }
                };
                let (finer, coarser) = (choose(1.0 + TOLERANCE), choose(1.0 - TOLERANCE));
                let is_told = !looker.1 && (!group.is_swapped() || self.main == Some(looker.0));
                let found = found(world, root, looker.0).filter(|_| finer != coarser && is_told);
                let wanted = found.unwrap_or_else(|| choose(1.0)).clamp(finer, coarser);
                self.wanted.insert((root, looker), wanted);
            }
        }
        for (&(root, looker), &wanted) in &self.wanted {
            let group = self.groups.get_mut(&root).expect("it was chosen for");
            let is_there = group.available >> wanted & 1 == 1 || group.available == 0;
            let shown = if is_there {
                wanted
            } else {
                group.available.trailing_zeros() as usize
            };
            group.shown.insert(looker, shown);
        }
    }

    pub fn roots(&self) -> impl Iterator<Item = Entity> {
        self.groups.keys().copied()
    }

    pub fn is_swapped(&self, root: Entity) -> bool {
        self.groups[&root].is_swapped()
    }
}
