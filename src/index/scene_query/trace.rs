//! Rays, and their way.

use bevy::math::Ray3d;

use super::{
    SceneQuery,
    rays::{Nearest, backfaces},
};
use crate::{
    geometry::ray::Ray,
    index::{
        SceneQuerySettings,
        spatial_index::Key,
        surface::Shape,
        trace::{EntityTest, EntityTrace, RayTrace},
    },
    spatial::{SpatialQueries, Visit},
};

impl SceneQuery<'_, '_> {
    /// What [`cast_ray`](Self::cast_ray) does to find the nearest hit: the nodes of the tree that the ray enters, and what
    /// is tested there, in order, by that very search.
    ///
    /// For tools and for the curious: it allocates for every step, and tests again what it tells about. The predicate of
    /// the settings is asked as often as by `cast_ray`. Empty for a ray with a NaN or infinite origin.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::prelude::*;
    /// fn how_much_work(scene: SceneQuery, eye: Single<&GlobalTransform, With<Camera>>) {
    ///     let ray = Ray3d::new(eye.translation(), eye.forward());
    ///     let trace = scene.trace_ray(ray, &SceneQuerySettings::default());
    ///     println!("{} nodes, {} boxes", trace.tree.nodes().count(), trace.tree.boxes_tested());
    ///     println!("{} entities, {} triangles", trace.entities_tested(), trace.triangles_tested());
    /// }
    /// ```
    pub fn trace_ray(&self, ray: Ray3d, settings: &SceneQuerySettings) -> RayTrace {
        let Some(ray) = Ray::from_ray3d(ray, settings.max_distance) else {
            return RayTrace::default();
        };
        let mut entities = Vec::new();
        let mut nearest = Nearest::none(&ray);
        let tree = self.tree(settings).trace_ray(&ray, |key, entered_at| {
            let rest = *nearest.rest();
            let hit = self.hit_surface(key, &rest, settings);
            let wish = nearest.offer(self, key, &ray, settings);
            entities.push(EntityTrace {
                entity: key.entity,
                entered_at,
                test: self.surface_test(key, &rest, settings),
                hit: hit.and_then(|hit| self.ray_hit(&ray, &hit)),
                is_nearest: wish != Visit::Continue,
            });
            wish
        });
        RayTrace {
            tree: tree.map(|key| key.entity),
            entities,
            hit: nearest.hit().and_then(|hit| self.ray_hit(&ray, hit)),
        }
    }

    /// What [`hit_surface`](Self::hit_surface) tests.
    fn surface_test(&self, key: Key, ray: &Ray, settings: &SceneQuerySettings) -> EntityTest {
        let surface = self.index.surface(key.slot).filter(|_| self.admit(key, settings));
        let Some(surface) = surface else {
            return EntityTest::None;
        };
        let local = surface.ray_to_local(ray);
        let (mesh, bounded_by) = match surface.shape {
            Shape::Analytic(_) => return EntityTest::Shape,
            Shape::Mesh(mesh, bounded_by) => (self.meshes.used_slot(mesh), Some(bounded_by)),
            Shape::Volume(mesh, kind) => match self.meshes.slot(mesh) {
                Some(slot) if slot.surface(kind).is_some() && local.is_some() => return EntityTest::Shape,
                slot => (slot, None),
            },
        };
        let Some(mesh) = mesh else {
            return EntityTest::None;
        };
        let triangles = match bounded_by {
            Some(_) => self.tested(surface, mesh),
            None => mesh.tested(),
        };
        let Some(triangles) = triangles else {
            return EntityTest::None;
        };
        let guard = bounded_by.filter(|_| surface.pose.is_none());
        if guard.zip(local).is_some_and(|(kind, local)| mesh.misses(kind, &local)) {
            return EntityTest::BoundingVolume;
        }
        match local.zip(triangles.hierarchy()) {
            Some((local, bvh)) => EntityTest::Hierarchy {
                trace: bvh.trace_closest_hit(&local, backfaces(surface, settings)).1,
                world_from_mesh: surface.world_from_local(),
            },
            None => EntityTest::Triangles(triangles.mesh().len()),
        }
    }
}
