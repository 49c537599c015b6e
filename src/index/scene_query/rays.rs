//! Rays, and what they hit.

use bevy::{
    ecs::entity::Entity,
    math::{Ray3d, Vec3},
    tasks::{ComputeTaskPool, ParallelSliceMut, TaskPool},
};

use super::SceneQuery;
use crate::{
    geometry::{
        ray::{Ray, triangle::Backfaces},
        surface::{Surface, SurfaceHit},
    },
    index::{
        HitTriangle, RayHit, SceneQuerySettings,
        spatial_index::Key,
        surface::{PlacedSurface, Shape},
    },
    mesh::{PosedMesh, TriangleHit},
    spatial::{SpatialQueries, Visit},
};

/// Fewer rays than this are not worth a task.
const LEAST_RAYS: usize = 32;

/// Tasks per thread, so that none waits long for another.
const TASKS_PER_THREAD: usize = 4;

/// Rays hit surfaces, exactly: see [`crate::index`].
impl SceneQuery<'_, '_> {
    /// The nearest hit of a ray.
    ///
    /// Exact: the surfaces themselves are tested, as [`crate::index`] says. Of hits at one distance, up to rounding,
    /// the smallest entity wins, by its [`Ord`]; flat surfaces are first told apart by their planes in double precision. A ray with a NaN or infinite origin hits nothing.
    pub fn cast_ray(&self, ray: Ray3d, settings: &SceneQuerySettings) -> Option<RayHit> {
        self.closest(&Ray::from_ray3d(ray, settings.max_distance)?, settings)
    }

    /// The nearest hit of a ray, with the parameter of the ray for the distance.
    pub(super) fn closest(&self, ray: &Ray, settings: &SceneQuerySettings) -> Option<RayHit> {
        let mut nearest = Nearest::none(ray);
        self.tree(settings)
            .visit_ray(ray, |key, _| nearest.offer(self, key, ray, settings));
        self.ray_hit(ray, &nearest.hit?)
    }

    /// The nearest hit of each of many rays, written over `hits` in the order of the rays: what
    /// [`cast_ray`](Self::cast_ray) tells of each, on all threads.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::prelude::*;
    /// fn look_around(scene: SceneQuery, eyes: Query<&GlobalTransform, With<Camera>>, mut seen: Local<Vec<Option<RayHit>>>) {
    ///     let rays: Vec<Ray3d> = eyes.iter().map(|eye| Ray3d::new(eye.translation(), eye.forward())).collect();
    ///     scene.cast_rays(&rays, &SceneQuerySettings::default(), &mut seen);
    ///     let nearest = seen.iter().flatten().map(|hit| hit.distance).reduce(f32::min);
    /// }
    /// ```
    pub fn cast_rays(&self, rays: &[Ray3d], settings: &SceneQuerySettings, hits: &mut Vec<Option<RayHit>>) {
        hits.clear();
        let pool = ComputeTaskPool::get_or_init(TaskPool::default);
        let threads = pool.thread_num();
        if rays.len() < LEAST_RAYS || threads <= 1 {
            hits.extend(rays.iter().map(|&ray| self.cast_ray(ray, settings)));
            return;
        }
        hits.resize(rays.len(), None);
        let step = rays.len().div_ceil(threads * TASKS_PER_THREAD).max(LEAST_RAYS / 2);
        hits.par_chunk_map_mut(pool, step, |chunk, hits| {
            for (hit, &ray) in hits.iter_mut().zip(&rays[chunk * step..]) {
                *hit = self.cast_ray(ray, settings);
            }
        });
    }

    /// All hits of a ray, nearest first, written over `hits`: for each entity its nearest.
    ///
    /// Hits at one distance come in the order in which [`cast_ray`](Self::cast_ray) prefers them; of hits that differ by
    /// no more than rounding, either may come first.
    pub fn cast_ray_all(&self, ray: Ray3d, settings: &SceneQuerySettings, hits: &mut Vec<RayHit>) {
        self.cast_ray_until(ray, settings, |_| false, hits);
    }

    /// All hits of a ray up to the nearest entity for which `blocks` is true, nearest first, written over `hits`.
    ///
    /// Like [`cast_ray_all`](Self::cast_ray_all), with the ray ending where it is blocked; the hit that blocks it, and
    /// others at that distance, are among the hits.
    pub fn cast_ray_until(
        &self,
        ray: Ray3d,
        settings: &SceneQuerySettings,
        blocks: impl Fn(Entity) -> bool,
        hits: &mut Vec<RayHit>,
    ) {
        hits.clear();
        let Some(ray) = Ray::from_ray3d(ray, settings.max_distance) else {
            return;
        };
        let mut rest = ray;
        let mut blocked_at = f32::INFINITY;
        self.tree(settings).visit_ray(&ray, |key, _| {
            let hit = self.hit_surface(key, &rest, settings);
            let Some(hit) = hit.filter(|hit| self.confirm(hit.entity, settings)) else {
                return Visit::Continue;
            };
            let Some(ray_hit) = self.ray_hit(&ray, &hit) else {
                return Visit::Continue;
            };
            hits.push(ray_hit);
            if !blocks(hit.entity) {
                return Visit::Continue;
            }
            blocked_at = blocked_at.min(ray_hit.distance);
            rest = rest.with_t_max(hit.t());
            Visit::Shorten(hit.t())
        });
        hits.retain(|hit| hit.distance <= blocked_at);
        let depth = |hit: &RayHit| {
            let surface = self.index.surface_of(hit.entity);
            surface.map_or(0.0, |surface| exact_depth(surface, &ray, hit.distance))
        };
        hits.sort_unstable_by(|a, b| {
            (a.distance.total_cmp(&b.distance))
                .then_with(|| depth(a).total_cmp(&depth(b)))
                .then(a.entity.cmp(&b.entity))
        });
    }

    /// Whether a ray hits anything. Cheaper than [`cast_ray`](Self::cast_ray): it stops at the first hit it finds.
    pub fn any_hit(&self, ray: Ray3d, settings: &SceneQuerySettings) -> bool {
        Ray::from_ray3d(ray, settings.max_distance).is_some_and(|ray| self.blocks(&ray, None, settings))
    }

    /// Whether a ray hits anything but `exception`.
    pub(super) fn blocks(&self, ray: &Ray, exception: Option<Entity>, settings: &SceneQuerySettings) -> bool {
        self.tree(settings).any_hit(ray, |key, ray| {
            exception != Some(key.entity)
                && self.admit(key, settings)
                && (self.index.surface(key.slot)).is_some_and(|surface| self.is_hit(surface, ray, settings))
                && self.confirm(key.entity, settings)
        })
    }

    /// Where a ray first hits one entity, if the settings admit it.
    pub(super) fn meets(&self, key: Key, ray: &Ray, settings: &SceneQuerySettings) -> Option<f32> {
        self.hit_surface(key, ray, settings).map(|hit| hit.t())
    }

    /// The nearest hit on one entity, if the settings admit it, before it is [confirmed](Self::confirm).
    pub(super) fn hit_surface(&self, key: Key, ray: &Ray, settings: &SceneQuerySettings) -> Option<EntityHit<'_>> {
        let surface = self.index.surface(key.slot).filter(|_| self.admit(key, settings))?;
        let backfaces = backfaces(surface, settings);
        let hit = match surface.shape {
            Shape::Mesh(mesh, bounded_by) => {
                let mesh = self.meshes.used_slot(mesh)?;
                let misses = |local: &Ray| surface.pose.is_none() && mesh.misses(bounded_by, local);
                let triangles = self.tested(surface, mesh)?;
                Hit::Triangle(triangles.closest_hit(surface, ray, backfaces, misses)?)
            }
            Shape::Volume(mesh, kind) => {
                let mesh = self.meshes.slot(mesh)?;
                match (mesh.surface(kind), surface.ray_to_local(ray)) {
                    (Some(volume), Some(local)) => Hit::Surface(volume.closest_hit(&local, backfaces)?),
                    _ => Hit::Triangle(mesh.tested()?.closest_hit(surface, ray, backfaces, |_| false)?),
                }
            }
            Shape::Analytic(ref shape) => {
                let local = surface.ray_to_local(ray)?;
                let hit = shape.surface().closest_hit(&local, backfaces);
                // A surface of the user's own may be wrong.
                let mut hit = hit.filter(|hit| local.has_parameter(hit.t))?;
                if let Some(exact) = surface.plane_parameter(ray) {
                    hit.t = (exact as f32).clamp(ray.t_min(), ray.t_max());
                }
                Hit::Surface(hit)
            }
        };
        let entity = key.entity;
        Some(EntityHit { entity, surface, hit })
    }

    /// Whether a ray hits a surface anywhere.
    fn is_hit(&self, surface: &PlacedSurface, ray: &Ray, settings: &SceneQuerySettings) -> bool {
        let backfaces = backfaces(surface, settings);
        match surface.shape {
            Shape::Mesh(mesh, bounded_by) => self.meshes.used_slot(mesh).is_some_and(|mesh| {
                let misses = |local: &Ray| surface.pose.is_none() && mesh.misses(bounded_by, local);
                self.tested(surface, mesh)
                    .is_some_and(|triangles| triangles.any_hit(surface, ray, backfaces, misses))
            }),
            Shape::Volume(mesh, kind) => {
                self.meshes
                    .slot(mesh)
                    .is_some_and(|mesh| match (mesh.surface(kind), surface.ray_to_local(ray)) {
                        (Some(volume), Some(local)) => volume.any_hit(&local, backfaces),
                        _ => (mesh.tested())
                            .is_some_and(|triangles| triangles.any_hit(surface, ray, backfaces, |_| false)),
                    })
            }
            Shape::Analytic(ref shape) => {
                let local = surface.ray_to_local(ray);
                local.is_some_and(|local| shape.surface().any_hit(&local, backfaces))
            }
        }
    }

    /// Where the corners of a triangle of an entity are, in world space: of the triangle with this number in the mesh that
    /// rays hit, as [`HitTriangle::index`] has it. A mark that keeps a triangle and barycentrics stays on a mesh that moves.
    ///
    /// As of the last `PostUpdate`, posed if the mesh is skinned or morphed. `None` if the entity is not in the index, or
    /// has no such triangle.
    pub fn triangle(&self, entity: Entity, triangle: u32) -> Option<[Vec3; 3]> {
        let surface = self.index.surface_of(entity).filter(|_| self.exists(entity))?;
        let slot = self.meshes.slot(surface.mesh()?)?;
        let mesh = slot.triangles()?;
        let corners = match surface.pose {
            Some(pose) => {
                let posed = self.poses.get(pose).filter(|posed| posed.is_of(slot))?;
                let position = |vertex| posed.deformer.position(vertex, &posed.pose);
                mesh.vertices_of(triangle)?.map(position)
            }
            None => mesh.corners_of(triangle)?,
        };
        Some(corners.map(|corner| surface.world_from_local().transform_point3(corner)))
    }

    /// The normal of a mesh in its pose at a hit, in the space of the surface.
    fn posed_normal(&self, surface: &PlacedSurface, posed: &PosedMesh, hit: &TriangleHit) -> Vec3 {
        let entity = surface.pose.and_then(|pose| self.poses.get(pose));
        entity.map_or(Vec3::ZERO, |entity| posed.normal(hit, &entity.deformer, &entity.pose))
    }

    /// Puts what is known of a hit into world space.
    pub(super) fn ray_hit(&self, ray: &Ray, EntityHit { entity, surface, hit }: &EntityHit) -> Option<RayHit> {
        let (distance, normal, triangle, uv) = match hit {
            Hit::Surface(hit) => {
                let normal = surface.normal_to_world(hit.normal);
                // Those of a volume are not those of the mesh.
                let uv = surface.mesh().is_none().then(|| hit.uv());
                (hit.t, normal, None, uv)
            }
            Hit::Triangle(hit) => {
                let posed = self.posed(surface);
                let mesh = match posed {
                    Some(posed) => posed.mesh(),
                    None => self.meshes.triangles(surface.mesh()?)?,
                };
                let place = |vertex| surface.world_from_local().transform_point3(vertex);
                let vertices @ [a, b, c] = mesh.triangle(hit).map(place);
                let distance = surface.local_from_world().map_or(hit.t, |local_from_world| {
                    ray.refined_under(&local_from_world, mesh.triangle(hit), hit.t)
                        .clamp(ray.t_min(), ray.t_max())
                });
                let normal = match surface.local_from_world() {
                    Some(_) => {
                        let normal =
                            posed.map_or_else(|| mesh.normal(hit), |posed| self.posed_normal(surface, posed, hit));
                        surface.normal_to_world(normal.normalize_or_zero())
                    }
                    // A flattened mesh has but the normals of its triangles.
                    None => (b - a).cross(c - a).normalize_or_zero(),
                };
                let triangle = HitTriangle {
                    index: hit.triangle,
                    vertices,
                    barycentrics: hit.barycentrics,
                };
                (distance, normal, Some(triangle), mesh.uv(hit))
            }
        };
        Some(RayHit {
            entity: *entity,
            distance,
            position: ray.at(distance).into(),
            normal: if normal == Vec3::ZERO {
                -Vec3::from(ray.direction()).normalize_or_zero()
            } else {
                normal
            },
            triangle,
            uv,
        })
    }
}

/// The nearest hit so far.
pub(super) struct Nearest<'a> {
    /// The ray as far as it still matters.
    rest: Ray,
    hit: Option<EntityHit<'a>>,
}

impl<'a> Nearest<'a> {
    #[inline]
    pub fn none(ray: &Ray) -> Self {
        Self { rest: *ray, hit: None }
    }

    pub fn rest(&self) -> &Ray {
        &self.rest
    }

    pub fn hit(&self) -> Option<&EntityHit<'a>> {
        self.hit.as_ref()
    }

    /// Takes the hit of the ray on an entity for the nearest, if it is.
    #[inline(always)]
    pub fn offer(&mut self, scene: &'a SceneQuery, key: Key, ray: &Ray, settings: &SceneQuerySettings) -> Visit {
        let Some(hit) = scene.hit_surface(key, &self.rest, settings) else {
            return Visit::Continue;
        };
        let precedes = self.hit.as_ref().is_none_or(|nearest| hit.precedes(nearest, ray));
        if !precedes || !scene.confirm(key.entity, settings) {
            return Visit::Continue;
        }
        self.rest = self.rest.with_t_max(hit.t());
        Visit::Shorten(self.hit.insert(hit).t())
    }
}

/// A hit on the surface of an entity.
pub(super) struct EntityHit<'a> {
    entity: Entity,
    surface: &'a PlacedSurface,
    hit: Hit,
}

/// A hit in the local space of what was hit, with the parameter of the ray in the world.
enum Hit {
    Triangle(TriangleHit),
    Surface(SurfaceHit),
}

impl EntityHit<'_> {
    /// Whether this hit comes before another on the ray.
    fn precedes(&self, other: &Self, ray: &Ray) -> bool {
        let depth = |hit: &Self| exact_depth(hit.surface, ray, hit.t());
        let order = (self.t().total_cmp(&other.t()))
            .then_with(|| depth(self).total_cmp(&depth(other)))
            .then(self.entity.cmp(&other.entity));
        order.is_lt()
    }

    fn t(&self) -> f32 {
        match &self.hit {
            Hit::Triangle(hit) => hit.t,
            Hit::Surface(hit) => hit.t,
        }
    }
}

pub(super) fn backfaces(surface: &PlacedSurface, settings: &SceneQuerySettings) -> Backfaces {
    settings.backfaces.unwrap_or(surface.backfaces)
}

/// The parameter of a hit, as far as it is known beyond single precision: it decides between hits at one distance.
fn exact_depth(surface: &PlacedSurface, ray: &Ray, t: f32) -> f64 {
    surface.plane_parameter(ray).unwrap_or(f64::from(t))
}
