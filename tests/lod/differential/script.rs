//! What happens: the same in the app with levels of detail, and in the one without.

use std::collections::BTreeMap;

use bevy::{
    camera::{
        OrthographicProjection, PerspectiveProjection, RenderTargetInfo, ShadowLodOrigin,
        primitives::Aabb,
        visibility::{NoAutoAabb, NoFrustumCulling, RenderLayers, VisibilityRange},
    },
    light::CascadeShadowConfigBuilder,
};
use rand::{Rng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

use super::*;

/// Plays the same part in each world.
pub struct Script {
    rng: ChaCha8Rng,
    /// Whether there are levels of detail.
    has_lods: bool,
    meshes: Vec<Handle<Mesh>>,
    lods: BTreeMap<Entity, ProxyLod>,
    /// Those whose component was taken away.
    idle: BTreeMap<Entity, ProxyLod>,
    blocks: Vec<Entity>,
    in_blocks: Vec<Entity>,
    /// What is listed.
    parts: Vec<Entity>,
    /// What hangs below that, or nowhere.
    things: Vec<Entity>,
    pub cameras: Vec<Entity>,
    pub lights: [Entity; 3],
    origin: Option<Entity>,
}

impl Script {
    pub fn begin(world: &mut World, seed: u64, has_lods: bool) -> Self {
        // Entities of the app itself come before.
        while world.spawn_empty().id().index_u32() < 3000 {}
        let mut assets = world.resource_mut::<Assets<Mesh>>();
        let meshes = (0..4).map(|_| assets.add(Cuboid::default())).collect();
        let place = Transform::from_xyz(0.0, 60.0, 30.0).looking_at(Vec3::ZERO, Vec3::Y);
        let lamp = PointLight {
            shadow_maps_enabled: true,
            range: 200.0,
            ..default()
        };
        let spot = SpotLight {
            shadow_maps_enabled: true,
            range: 200.0,
            outer_angle: 1.2,
            ..default()
        };
        let sun = DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        };
        let cascades = CascadeShadowConfigBuilder {
            num_cascades: 2,
            maximum_distance: 200.0,
            ..default()
        };
        let lights = [
            // Lists of lamps that no camera sees are left as they were.
            world.spawn((lamp, place, NoFrustumCulling)).id(),
            world.spawn((spot, place, NoFrustumCulling)).id(),
            world.spawn((sun, cascades.build(), place)).id(),
        ];
        let mut script = Self {
            rng: rng(seed),
            has_lods,
            meshes,
            lods: BTreeMap::new(),
            idle: BTreeMap::new(),
            blocks: Vec::new(),
            in_blocks: Vec::new(),
            parts: Vec::new(),
            things: Vec::new(),
            cameras: Vec::new(),
            lights,
            origin: None,
        };
        for _ in 0..2 {
            script.spawn_camera(world);
        }
        for _ in 0..6 {
            script.spawn_group(world);
        }
        script.spawn_block(world);
        script
    }

    /// Goes on by a frame.
    pub fn play(&mut self, world: &mut World) {
        self.move_cameras(world);
        if self.rng.random_bool(0.6) {
            for _ in 0..self.rng.random_range(1..4) {
                self.act(world);
                self.forget_gone(world);
            }
        }
    }

    fn place(&mut self, size: f32) -> Transform {
        let scale = match self.rng.random_range(0..8) {
            0 => Vec3::splat(-1.0),
            1 => Vec3::new(2.0, 0.5, 1.5),
            2 => Vec3::splat(self.rng.random_range(0.2..4.0)),
            _ => Vec3::ONE,
        };
        Transform {
            translation: random_point(&mut self.rng, size),
            rotation: random_rotation(&mut self.rng),
            scale,
        }
    }

    fn cube(&mut self) -> Mesh3d {
        Mesh3d(self.meshes.choose(&mut self.rng).expect("some").clone())
    }

    fn some(&mut self, of: &[Entity]) -> Option<Entity> {
        of.choose(&mut self.rng).copied()
    }

    fn set_lod(&mut self, world: &mut World, root: Entity, lod: ProxyLod) {
        if self.has_lods {
            world.entity_mut(root).insert(lod.clone());
        }
        self.lods.insert(root, lod);
    }

    /// Thresholds for coarser levels, that fit to the metric.
    fn thresholds(&mut self, metric: LodMetric, levels: usize) -> Vec<f32> {
        let mut thresholds: Vec<f32> = (1..levels)
            .map(|_| match metric {
                LodMetric::Height => self.rng.random_range(0.01..0.4),
                LodMetric::PixelError(_) => self.rng.random_range(0.01..0.4),
                LodMetric::Distance => self.rng.random_range(5.0..90.0),
            })
            .collect();
        match metric {
            LodMetric::Height => thresholds.sort_by(|a, b| b.total_cmp(a)),
            LodMetric::Distance => thresholds.sort_by(f32::total_cmp),
            LodMetric::PixelError(_) => {}
        }
        thresholds
    }

    fn lod(&mut self, contents: Vec<LodContent>) -> ProxyLod {
        let metric = match self.rng.random_range(0..3) {
            0 => LodMetric::Height,
            1 => LodMetric::PixelError(self.rng.random_range(0.5..8.0)),
            _ => LodMetric::Distance,
        };
        let thresholds = self.thresholds(metric, contents.len());
        let mut contents = contents.into_iter();
        let mut lod = ProxyLod::new(metric, contents.next().expect("a level"));
        for (content, threshold) in contents.zip(thresholds) {
            lod = lod.then(threshold, content);
        }
        if self.rng.random_bool(0.5) {
            lod = lod.measured_to(LodReference::Center);
        }
        if self.rng.random_bool(0.2) {
            lod = lod.with_bounds(Aabb::from_min_max(
                Vec3::new(-2.0, -1.0, -3.0),
                Vec3::new(1.0, 2.0, 3.0),
            ));
        }
        let bias = self.rng.random_range(0.5..2.0);
        lod.with_bias(bias)
    }

    fn spawn_group(&mut self, world: &mut World) -> Entity {
        let place = self.place(50.0);
        let levels = self.rng.random_range(1..5);
        let mut contents: Vec<LodContent> = Vec::new();
        let root = if self.rng.random_bool(0.3) {
            let first = self.rng.random_range(0..4);
            contents.extend((0..levels).map(|i| LodContent::from(self.meshes[(first + i) % 4].clone())));
            let mesh = Mesh3d(self.meshes[first].clone());
            let around = Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(0.5));
            world.spawn((mesh, around, NoAutoAabb, place)).id()
        } else {
            let root = world.spawn((place, Visibility::default())).id();
            for _ in 0..levels {
                let parts = (0..self.rng.random_range(1..3)).map(|_| {
                    let (cube, place) = (self.cube(), self.place(3.0));
                    let part = world.spawn((cube, place, ChildOf(root))).id();
                    self.parts.push(part);
                    part
                });
                contents.push(parts.collect::<Vec<_>>().into());
            }
            root
        };
        if levels > 1 && self.rng.random_bool(0.3) {
            contents.push(LodContent::Nothing);
        }
        let lod = self.lod(contents);
        self.set_lod(world, root, lod);
        root
    }

    /// A group that shows other groups, or one cube.
    fn spawn_block(&mut self, world: &mut World) {
        let place = Transform {
            scale: Vec3::ONE,
            ..self.place(20.0)
        };
        let root = world.spawn((place, Visibility::default())).id();
        let near = world
            .spawn((Transform::default(), Visibility::default(), ChildOf(root)))
            .id();
        let mut listed = vec![near];
        let free: Vec<Entity> = (self.lods.keys().copied())
            .filter(|group| !self.in_blocks.contains(group))
            .collect();
        for _ in 0..self.rng.random_range(1..4) {
            if let Some(group) = self.some(&free).filter(|group| !self.in_blocks.contains(group)) {
                if self.rng.random_bool(0.5) {
                    world.entity_mut(near).add_child(group);
                } else {
                    world.entity_mut(root).add_child(group);
                    listed.push(group);
                }
                self.in_blocks.push(group);
            }
        }
        let proxy = (self.cube(), Transform::from_scale(Vec3::splat(5.0)), ChildOf(root));
        let proxy = world.spawn(proxy).id();
        self.parts.push(proxy);
        let lod = self.lod(vec![listed.into(), proxy.into()]);
        self.set_lod(world, root, lod);
        self.blocks.push(root);
    }

    fn spawn_camera(&mut self, world: &mut World) {
        let place = self.camera_place(60.0);
        let order = self.rng.random_range(-3i32..3) as isize;
        let camera = Camera { order, ..default() };
        self.cameras
            .push(world.spawn((Camera3d::default(), camera, place)).id());
    }

    fn camera_place(&mut self, size: f32) -> Transform {
        let from = random_point(&mut self.rng, size);
        Transform::from_translation(from).looking_at(random_point(&mut self.rng, 20.0), Vec3::Y)
    }

    fn move_cameras(&mut self, world: &mut World) {
        for camera in self.cameras.clone() {
            let kind = self.rng.random_range(0..100);
            let leap = match kind {
                0..40 => continue,
                40..90 => None,
                90..98 => Some(60.0),
                98 => Some(1e3),
                _ => Some(1e7),
            };
            let place = leap.map(|size| self.camera_place(size));
            let step = random_point(&mut self.rng, 1.5);
            let mut old = world.get_mut::<Transform>(camera).expect("a camera");
            match place {
                Some(place) => *old = place,
                None => old.translation += step,
            }
        }
    }

    /// Does something at random.
    fn act(&mut self, world: &mut World) {
        let groups: Vec<Entity> = self.lods.keys().copied().collect();
        let (parts, things) = (self.parts.clone(), self.things.clone());
        let (group, part, thing) = (self.some(&groups), self.some(&parts), self.some(&things));
        let camera = self.cameras.clone();
        let camera = self.some(&camera);
        match self.rng.random_range(0..34) {
            0..5 => {
                if let Some(group) = group {
                    let is_block = self.blocks.contains(&group);
                    let place = self.place(50.0);
                    let scale = if is_block { Vec3::splat(1.5) } else { place.scale };
                    world.entity_mut(group).insert(Transform { scale, ..place });
                }
            }
            5..8 => {
                if let Some(part) = part {
                    let place = self.place(5.0);
                    world.entity_mut(part).insert(place);
                }
            }
            8 => _ = self.spawn_group(world),
            9 if self.blocks.len() < 4 => self.spawn_block(world),
            10 if self.lods.len() > 4 => {
                if let Some(group) = group {
                    world.despawn(group);
                }
            }
            11..13 => {
                let (cube, place) = (self.cube(), self.place(5.0));
                let thing = world.spawn((cube, place)).id();
                if let Some(part) = part {
                    world.entity_mut(part).add_child(thing);
                }
                self.things.push(thing);
            }
            13..16 => {
                if let Some((thing, part)) = thing.zip(part) {
                    match self.rng.random_range(0..3) {
                        0 => _ = world.entity_mut(thing).remove::<ChildOf>(),
                        1 => _ = world.entity_mut(group.unwrap_or(part)).add_child(thing),
                        _ => _ = world.entity_mut(part).add_child(thing),
                    }
                }
            }
            16 => {
                if let Some(gone) = self.some(&[part, thing].into_iter().flatten().collect::<Vec<_>>()) {
                    world.despawn(gone);
                }
            }
            17 => {
                if let Some(group) = group {
                    world.entity_mut(group).remove::<ProxyLod>();
                    self.idle.extend(self.lods.remove_entry(&group));
                }
            }
            18..20 => {
                let idle: Vec<Entity> = self.idle.keys().copied().collect();
                if let Some((root, lod)) = self.some(&idle).and_then(|root| self.idle.remove_entry(&root)) {
                    self.set_lod(world, root, lod);
                }
            }
            20..22 => {
                if let Some(group) = group {
                    let mut lod = self.lods[&group].clone();
                    lod.bias = self.rng.random_range(0.3..3.0);
                    let thresholds = self.thresholds(lod.metric, lod.levels.len());
                    for (level, threshold) in lod.levels[1..].iter_mut().zip(thresholds) {
                        level.threshold = threshold;
                    }
                    self.set_lod(world, group, lod);
                }
            }
            22 => self.unsettle(world),
            23..25 => self.decorate(world, group, part, thing),
            25..27 => {
                let (fov, height) = (self.rng.random_range(0.1..2.0), self.rng.random_range(5.0..200.0));
                let projection: Projection = if self.rng.random_bool(0.6) {
                    PerspectiveProjection { fov, ..default() }.into()
                } else {
                    OrthographicProjection {
                        area: Rect::new(-height, -height / 2.0, height, height / 2.0),
                        ..OrthographicProjection::default_3d()
                    }
                    .into()
                };
                if let Some(camera) = camera {
                    world.entity_mut(camera).insert(projection);
                }
            }
            27..29 => {
                if let Some(camera) = camera {
                    let mut settings = world.get_mut::<Camera>(camera).expect("a camera");
                    settings.is_active = !settings.is_active;
                }
            }
            29 => {
                if let Some(camera) = camera {
                    let bias = self.rng.random_range(0.5..2.0);
                    let height = self.rng.random_range(100..2000);
                    world.entity_mut(camera).insert(LodBias(bias));
                    let mut settings = world.get_mut::<Camera>(camera).expect("a camera");
                    settings.order = self.rng.random_range(-3i32..3) as isize;
                    settings.computed.target_info = Some(RenderTargetInfo {
                        physical_size: UVec2::new(2 * height, height),
                        scale_factor: 1.0,
                    });
                }
            }
            30 if self.cameras.len() < 4 => self.spawn_camera(world),
            31 if self.cameras.len() > 1 => {
                if let Some(camera) = camera {
                    world.despawn(camera);
                }
            }
            32 => match self.origin.take() {
                Some(origin) => _ = world.despawn(origin),
                None => {
                    let place = self.camera_place(60.0);
                    self.origin = Some(world.spawn((ShadowLodOrigin, place)).id());
                }
            },
            33 => {
                let mut culling = world.resource_mut::<ViewCullingSettings>();
                culling.enabled = !culling.enabled;
            }
            _ => {}
        }
    }

    /// Changes how levels are chosen.
    fn unsettle(&mut self, world: &mut World) {
        let (bias, hysteresis) = (self.rng.random_range(0.5..2.0), self.rng.random_range(0.0..0.4));
        let is_biased = self.rng.random_bool(0.5);
        let mut settings = world.resource_mut::<LodSettings>();
        (settings.bias, settings.hysteresis) = (bias, hysteresis);
        settings.shadow_bias = if is_biased { 0.4 } else { 1.0 };
        settings.viewport_height = 1080.0 * bias;
    }

    /// Gives something a property that has to do with how it is seen, or takes it.
    fn decorate(&mut self, world: &mut World, group: Option<Entity>, part: Option<Entity>, thing: Option<Entity>) {
        let some: Vec<Entity> = [group, part, thing].into_iter().flatten().collect();
        let Some(one) = self.some(&some) else { return };
        let mut one = world.entity_mut(one);
        match self.rng.random_range(0..10) {
            0 => _ = one.insert(Visibility::Hidden),
            1 | 2 => _ = one.insert(Visibility::Inherited),
            3 => _ = one.insert(RenderLayers::layer(2)),
            4 => _ = one.insert(RenderLayers::from_layers(&[0, 3])),
            5 => _ = one.insert(NoSpatialIndex),
            6 => _ = one.insert(NoFrustumCulling),
            7 => _ = one.insert(VisibilityRange::abrupt(0.0, 40.0)),
            _ => _ = one.remove::<(RenderLayers, NoSpatialIndex, NoFrustumCulling, VisibilityRange)>(),
        }
    }

    fn forget_gone(&mut self, world: &World) {
        let is_there = |entity: &Entity| world.get_entity(*entity).is_ok();
        for list in [
            &mut self.blocks,
            &mut self.in_blocks,
            &mut self.parts,
            &mut self.things,
            &mut self.cameras,
        ] {
            list.retain(is_there);
        }
        self.lods.retain(|root, _| is_there(root));
        self.idle.retain(|root, _| is_there(root));
    }
}
