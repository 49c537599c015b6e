//! What is asked of world boxes: what is where, what is near, what is in the way of something that moves, what touches.

use std::ops::ControlFlow;

use bevy::{
    ecs::entity::Entity,
    math::{Ray3d, Vec3, Vec3A, bounding::Aabb3d, primitives::ViewFrustum},
};

use super::SceneQuery;
use crate::{
    geometry::{
        aabb::union,
        intersection::Frustum,
        ray::Ray,
        sweep::{AabbSweep, SphereSweep},
    },
    index::{SceneQuerySettings, spatial_index::Key},
    spatial::{Neighbour, Region, SpatialQueries, Sweep, Trace, Visit},
};

/// The first contact of something that moves, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SweepHit {
    /// The entity whose world box was touched.
    pub entity: Entity,
    /// How far the moving shape has come.
    pub distance: f32,
    /// Where its centre is then.
    pub center: Vec3,
}

/// Entities stand for their world boxes here, whatever shape they have: as [`crate::index`] says, the image of their
/// local bounds under their `GlobalTransform`, aligned to the axes of the world. Boxes are closed, so that what touches
/// counts.
impl SceneQuery<'_, '_> {
    /// The world boxes of all entities that the settings accept, to be asked as [`SpatialQueries`] has it: the methods
    /// below, and all that are not among them.
    ///
    /// ```
    /// # use bevy::{math::bounding::Aabb3d, prelude::*};
    /// # use bevy_sightline::{prelude::*, spatial::SpatialQueries};
    /// fn is_there_room(scene: SceneQuery) -> bool {
    ///     let settings = SceneQuerySettings::default();
    ///     let mut free = true;
    ///     let site = Aabb3d::new(Vec3::ZERO, Vec3::splat(5.0));
    ///     scene.boxes(&settings).visit_region(&site, |_| {
    ///         free = false;
    ///         std::ops::ControlFlow::Break(())
    ///     });
    ///     free
    /// }
    /// ```
    pub fn boxes<'a>(&'a self, settings: &'a SceneQuerySettings<'a>) -> impl SpatialQueries<Entity> + 'a {
        Boxes { scene: self, settings }
    }

    /// All entities whose world box touches a region, in ascending order, written over `entities`.
    ///
    /// A region is an `Aabb3d`, a `BoundingSphere`, an [`Obb`](crate::geometry::obb::Obb), a
    /// [`ConvexHull`](crate::geometry::convex_hull::ConvexHull), a `ViewFrustum` or a
    /// [`Frustum`](crate::geometry::intersection::Frustum): see [`Region`] for how exact each is. `max_distance` and
    /// `backfaces` of the settings do not matter.
    ///
    /// ```
    /// # use bevy::{math::bounding::BoundingSphere, prelude::*};
    /// # use bevy_sightline::prelude::*;
    /// fn blast(scene: SceneQuery, mut commands: Commands, mut hit: Local<Vec<Entity>>) {
    ///     let blast = BoundingSphere::new(Vec3::ZERO, 8.0);
    ///     scene.overlap(&blast, &SceneQuerySettings::default(), &mut hit);
    ///     hit.iter().for_each(|&entity| commands.entity(entity).despawn());
    /// }
    /// ```
    pub fn overlap(&self, region: &impl Region, settings: &SceneQuerySettings, entities: &mut Vec<Entity>) {
        self.boxes(settings).find_in_region(region, entities);
        entities.sort_unstable();
    }

    /// All entities whose world box touches a view frustum, such as a camera's, in ascending order, written over
    /// `entities`.
    ///
    /// As exactly as [`overlap`](Self::overlap) by a [`Frustum`](crate::geometry::intersection::Frustum), which this is:
    /// unlike culling, which passes over edges and the far plane.
    ///
    /// ```
    /// # use bevy::{camera::primitives::Frustum, prelude::*};
    /// # use bevy_sightline::prelude::*;
    /// fn in_view(scene: SceneQuery, camera: Single<&Frustum, With<Camera>>, mut seen: Local<Vec<Entity>>) {
    ///     scene.overlap_frustum(&camera, &SceneQuerySettings::default(), &mut seen);
    /// }
    /// ```
    pub fn overlap_frustum(&self, frustum: &ViewFrustum, settings: &SceneQuerySettings, entities: &mut Vec<Entity>) {
        self.overlap(&Frustum::from(frustum), settings, entities);
    }

    /// The entity whose world box is nearest to a point, no farther off than the maximum distance of the settings; of
    /// several at one distance the smallest entity. Zero is the distance from inside a box.
    ///
    /// Nothing is near a point with a NaN or infinite coordinate.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::prelude::*;
    /// fn attract(scene: SceneQuery, magnet: Single<&GlobalTransform, With<PointLight>>) {
    ///     let settings = SceneQuerySettings::default().with_max_distance(10.0);
    ///     if let Some(nearest) = scene.nearest(magnet.translation(), &settings) {
    ///         println!("{} is {} m off", nearest.key, nearest.distance_squared.sqrt());
    ///     }
    /// }
    /// ```
    pub fn nearest(&self, point: Vec3, settings: &SceneQuerySettings) -> Option<Neighbour<Entity>> {
        let mut nearest: Option<Neighbour<Entity>> = None;
        self.visit_near(point, settings, |entity, distance_squared| {
            let is_nearer =
                |nearest: Neighbour<Entity>| (distance_squared, entity) < (nearest.distance_squared, nearest.key);
            if !nearest.is_none_or(is_nearer) {
                return Visit::Continue;
            }
            nearest = Some(Neighbour {
                key: entity,
                distance_squared,
            });
            Visit::Shorten(distance_squared)
        });
        nearest
    }

    /// The `k` entities whose world boxes are nearest to a point, nearest first, written over `nearest`: as many times
    /// [`nearest`](Self::nearest).
    pub fn k_nearest(
        &self,
        point: Vec3,
        k: usize,
        settings: &SceneQuerySettings,
        nearest: &mut Vec<Neighbour<Entity>>,
    ) {
        nearest.clear();
        if point.is_finite() {
            self.boxes(settings)
                .k_nearest(point.into(), k, settings.max_distance, nearest);
        }
    }

    /// All entities whose world box is within `radius` of a point, nearest first and of those at one distance the smaller
    /// first, written over `neighbours`.
    ///
    /// The limit is included: the square of the distance is at most that of the radius, both rounded. Nothing is near a
    /// point with a NaN or infinite coordinate. `max_distance` and `backfaces` of the settings do not matter.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::{prelude::*, spatial::Neighbour};
    /// fn flock(scene: SceneQuery, birds: Query<(Entity, &GlobalTransform)>, mut near: Local<Vec<Neighbour<Entity>>>) {
    ///     for (bird, place) in &birds {
    ///         let others = SceneQuerySettings::default();
    ///         scene.neighbours_within(place.translation(), 3.0, &others.excluding(&[bird]), &mut near);
    ///         println!("{bird} has {} others around it", near.len());
    ///     }
    /// }
    /// ```
    pub fn neighbours_within(
        &self,
        point: Vec3,
        radius: f32,
        settings: &SceneQuerySettings,
        neighbours: &mut Vec<Neighbour<Entity>>,
    ) {
        neighbours.clear();
        if !point.is_finite() {
            return;
        }
        let boxes = Boxes { scene: self, settings };
        let mut visit = |key, distance_squared| {
            neighbours.extend(boxes.accept(key).map(|key| Neighbour { key, distance_squared }));
            Visit::Continue
        };
        match self.index.ask_grid() {
            Some(grid) => grid.visit_near(point.into(), radius, |key, distance_squared| {
                if self.admit_visibility(key, settings) {
                    visit(key, distance_squared)
                } else {
                    Visit::Continue
                }
            }),
            None => boxes.tree().visit_near(point.into(), radius, visit),
        }
        neighbours.sort_unstable_by(|a, b| (a.distance_squared.total_cmp(&b.distance_squared)).then(a.key.cmp(&b.key)));
    }

    /// The first world box that a sphere touches whose centre moves along a ray, up to the maximum distance of the
    /// settings. Of several touched at once, the smallest entity.
    ///
    /// No contact is missed, and none is reported too late: see [`crate::geometry::sweep`] for the digits. `None` also
    /// if the ray is not finite, or the radius is negative, NaN or infinite.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::prelude::*;
    /// fn pull_camera_in(scene: SceneQuery, player: Single<(Entity, &GlobalTransform)>) -> f32 {
    ///     let (player, place) = *player;
    ///     let back = Ray3d::new(place.translation(), place.back());
    ///     let settings = SceneQuerySettings::default().with_max_distance(5.0);
    ///     let hit = scene.sweep_sphere(back, 0.3, &settings.excluding(&[player]));
    ///     hit.map_or(5.0, |hit| hit.distance)
    /// }
    /// ```
    pub fn sweep_sphere(&self, path: Ray3d, radius: f32, settings: &SceneQuerySettings) -> Option<SweepHit> {
        let path = Ray::from_ray3d(path, settings.max_distance)?;
        self.first_touched(&SphereSweep::new(path, radius)?, settings)
    }

    /// The first world box that a box touches whose centre moves along a ray, and which reaches `half_size` from it along
    /// each axis of the world. Otherwise like [`sweep_sphere`](Self::sweep_sphere); `None` also if a coordinate of the
    /// half size is negative, NaN or infinite.
    pub fn sweep_aabb(&self, path: Ray3d, half_size: Vec3, settings: &SceneQuerySettings) -> Option<SweepHit> {
        let path = Ray::from_ray3d(path, settings.max_distance)?;
        self.first_touched(&AabbSweep::new(path, half_size)?, settings)
    }

    /// All pairs of entities whose world boxes touch, written over `pairs`: each pair once, the smaller entity first, in
    /// ascending order.
    ///
    /// `max_distance` and `backfaces` of the settings do not matter.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::prelude::*;
    /// fn collide(scene: SceneQuery, mut pairs: Local<Vec<[Entity; 2]>>) {
    ///     scene.pairs(&SceneQuerySettings::default(), &mut pairs);
    ///     for [a, b] in &*pairs {
    ///         println!("{a} may touch {b}");
    ///     }
    /// }
    /// ```
    pub fn pairs(&self, settings: &SceneQuerySettings, pairs: &mut Vec<[Entity; 2]>) {
        pairs.clear();
        self.boxes(settings).visit_pairs(|a, b| {
            pairs.push([a.min(b), a.max(b)]);
            ControlFlow::Continue(())
        });
        pairs.sort_unstable();
    }

    fn first_touched(&self, sweep: &impl Sweep, settings: &SceneQuerySettings) -> Option<SweepHit> {
        let (entity, distance) = self.boxes(settings).first_touched(sweep)?;
        let center = sweep.ray().at(distance).into();
        Some(SweepHit {
            entity,
            distance,
            center,
        })
    }

    /// Visits what is no farther from a point than the maximum distance of the settings.
    fn visit_near(&self, point: Vec3, settings: &SceneQuerySettings, visit: impl FnMut(Entity, f32) -> Visit) {
        if point.is_finite() {
            self.boxes(settings)
                .visit_near(point.into(), settings.max_distance, visit);
        }
    }
}

/// See [`SceneQuery::boxes`].
struct Boxes<'a, 'w, 's> {
    scene: &'a SceneQuery<'w, 's>,
    settings: &'a SceneQuerySettings<'a>,
}

impl Boxes<'_, '_, '_> {
    fn accept(&self, key: Key) -> Option<Entity> {
        self.scene.accept(key, self.settings)
    }

    fn tree(&self) -> impl SpatialQueries<Key> + '_ {
        self.scene.tree(self.settings)
    }

    /// Hands a visit on for what is accepted.
    fn visiting(&self, mut visit: impl FnMut(Entity, f32) -> Visit) -> impl FnMut(Key, f32) -> Visit {
        move |key, t| self.accept(key).map_or(Visit::Continue, |entity| visit(entity, t))
    }
}

/// [`len`](Self::len) and [`bounds`](Self::bounds) visit every entity.
impl SpatialQueries<Entity> for Boxes<'_, '_, '_> {
    fn len(&self) -> usize {
        let mut len = 0;
        self.visit_all(|_, _| len += 1);
        len
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let mut bounds: Option<Aabb3d> = None;
        self.visit_all(|_, aabb| bounds = Some(bounds.map_or(*aabb, |bounds| union(&bounds, aabb))));
        bounds
    }

    fn memory(&self) -> usize {
        self.tree().memory()
    }

    fn visit_all(&self, mut visit: impl FnMut(Entity, &Aabb3d)) {
        self.tree().visit_all(|key, aabb| {
            if let Some(entity) = self.accept(key) {
                visit(entity, aabb);
            }
        });
    }

    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(Entity, f32) -> Visit) {
        self.tree().visit_ray(ray, self.visiting(visit));
    }

    fn trace_ray(&self, ray: &Ray, visit: impl FnMut(Entity, f32) -> Visit) -> Trace<Entity> {
        self.tree().trace_ray(ray, self.visiting(visit)).map(|key| key.entity)
    }

    fn visit_sweep<S: Sweep>(&self, sweep: &S, visit: impl FnMut(Entity, f32) -> Visit) {
        self.tree().visit_sweep(sweep, self.visiting(visit));
    }

    fn visit_region<R: Region>(&self, region: &R, mut visit: impl FnMut(Entity) -> ControlFlow<()>) {
        self.tree().visit_region(region, |key| {
            self.accept(key).map_or(ControlFlow::Continue(()), &mut visit)
        });
    }

    fn visit_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(Entity, f32) -> Visit) {
        self.tree().visit_near(point, max_distance, self.visiting(visit));
    }

    fn visit_pairs(&self, mut visit: impl FnMut(Entity, Entity) -> ControlFlow<()>) {
        self.tree().visit_pairs(|a, b| match (self.accept(a), self.accept(b)) {
            (Some(a), Some(b)) => visit(a, b),
            _ => ControlFlow::Continue(()),
        });
    }
}
