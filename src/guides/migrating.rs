//! From `MeshPickingPlugin`, from bevy_mod_raycast, from `VisibilityRange`.
//!
//! For whoever has an app that works, and wants to know what to write instead, and what will be different.
//!
//! # From `MeshPickingPlugin`
//!
//! Take out `MeshPickingPlugin`, and put `SpatialPickingPlugin` in its place, or all the
//! [`SightlinePlugins`](crate::SightlinePlugins):
//!
//! ```no_run
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! App::new().add_plugins((DefaultPlugins, SpatialPickingPlugin)).run();
//! ```
//!
//! With both there, everything is picked twice, and a warning says so.
//!
//! **The same:** all pointer events and observers, `Pickable`, `MeshPickingSettings`, `MeshPickingCamera`,
//! `RayCastVisibility`, `RenderLayers`, the order of cameras, `SimplifiedMesh` and `RayCastBackfaces`. These stay
//! Bevy's own types.
//!
//! **Different:**
//!
//! | | Bevy | here |
//! |---|---|---|
//! | what is behind an entity without a `Pickable` | is in `PointerHits`, though no event reaches it | is left out; `SpatialPickingSettings::report_blocked` brings it back |
//! | skinned and morphed meshes | hit in their bind pose | hit where they are drawn |
//! | triangle strips, `NoFrustumCulling`, tiny triangles | missed | hit |
//! | a `SimplifiedMesh` that sticks out of the drawn mesh | missed outside of the box of the drawn one | hit |
//! | normals | of any length, wrong under non-uniform scale | unit length, right |
//! | `HitData::extra` | – | the whole [`RayHit`], by `extra_as::<RayHit>()` |
//! | levels of detail ([`ProxyLod`](crate::lod::ProxyLod)) | – | the finest is hit, unless [asked otherwise](crate::lod::LodHits) |
//! | moved after `PostUpdate` | seen at once, if the `GlobalTransform` is written | seen after the next |
//!
//!
//! Rays that you cast yourself by `MeshRayCast` are cast by [`SceneQuery`], which needs no `mut`:
//!
//! | `MeshRayCast` | [`SceneQuery`] |
//! |---|---|
//! | `cast_ray(ray, &settings).first()` | [`cast_ray(ray, &settings)`](crate::index::SceneQuery::cast_ray) |
//! | `never_early_exit()` | [`cast_ray_all`](crate::index::SceneQuery::cast_ray_all) |
//! | `with_early_exit_test(&blocks)` | [`cast_ray_until`](crate::index::SceneQuery::cast_ray_until) |
//! | `with_filter(&f)` | [`filter(&f)`](crate::index::SceneQuerySettings::filter), where `f` is `Sync` |
//! | `RayCastVisibility::VisibleInView`, the default | [`QueryVisibility::VisibleInView`]; the default is `Visible`, on screen or not |
//! | `RayMeshHit { point, normal, distance, uv, .. }` | [`RayHit { position, normal, distance, uv, .. }`](crate::index::RayHit) |
//! | `triangle`, `triangle_index`, `barycentric_coords` | [`triangle`](crate::index::RayHit::triangle)`: Option<`[`HitTriangle`]`>` |
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_sightline::prelude::*;
//!
//! fn as_mesh_ray_cast_has_it(scene: SceneQuery, enemies: Query<(), With<Name>>) {
//!     let is_enemy = |entity| enemies.contains(entity);
//!     let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::VisibleInView).filter(&is_enemy);
//!     let hit = scene.cast_ray(Ray3d::new(Vec3::ZERO, Dir3::X), &settings);
//!     println!("{:?}", hit.map(|hit| (hit.entity, hit.position)));
//! }
//! ```
//!
//! If everything in a small scene moves in every frame and there is one ray, Bevy's own has nothing to keep up and may
//! be quicker: see [`troubleshooting`](super::troubleshooting#it-is-slow).
//!
//! # From bevy_mod_raycast
//!
//! Its last versions are 0.17 for Bevy 0.13 and 0.18 for Bevy 0.14. Nothing has to be marked any more, and what was
//! deferred is either a pointer event or a query:
//!
//! | bevy_mod_raycast | here |
//! |---|---|
//! | `DeferredRaycastingPlugin::<T>` | [`SightlinePlugins`](crate::SightlinePlugins) |
//! | `Raycast` | [`SceneQuery`] |
//! | `Raycast::cast_ray` | [`SceneQuery::cast_ray`] |
//! | `RaycastSettings::never_early_exit` | [`SceneQuery::cast_ray_all`] |
//! | `RaycastSettings::with_early_exit_test` | [`SceneQuery::cast_ray_until`] |
//! | `RaycastSettings::with_filter` | [`SceneQuerySettings::filter`] |
//! | `RaycastVisibility::{Ignore, MustBeVisible, MustBeVisibleAndInView}` | [`QueryVisibility::{Any, Visible, VisibleInView}`](crate::index::QueryVisibility), of which `Visible` is the default |
//! | `RaycastMesh<T>` | nothing, or a marker of yours and a filter, or `RenderLayers` |
//! | `RaycastMesh::intersections` | an observer of `On<Pointer<Over>>`, or Bevy's `HoverMap` |
//! | `RaycastSource::new_cursor` | observers of Bevy's pointer events |
//! | `RaycastSource::new_transform_empty` | [`SceneQuery::cast_ray`] from a `GlobalTransform` |
//! | `RaycastSource::get_nearest_intersection` | what [`SceneQuery::cast_ray`] returns |
//! | `CursorRay` | Bevy's `RayMap`: a ray for each pointer and camera |
//! | `IntersectionData::{position, normal, distance}` | the fields of [`RayHit`] |
//! | `IntersectionData::{triangle, triangle_index, barycentric_coord}` | [`RayHit::triangle`], with [`vertices`](crate::index::HitTriangle::vertices), [`index`](crate::index::HitTriangle::index), [`barycentrics`](crate::index::HitTriangle::barycentrics) |
//! | `SimplifiedMesh { mesh }` | [`SimplifiedMesh(mesh)`](crate::index::SimplifiedMesh) |
//! | `NoBackfaceCulling` | [`RayCastBackfaces`](crate::index::RayCastBackfaces) |
//! | `Raycast::debug_cast_ray` | `gizmos.ray_hit(ray, hit)`, or the switch `rays` of `SightlineGizmos` |
//! | `ray_intersection_over_mesh` | [`TriangleMesh`](crate::mesh::TriangleMesh), [`MeshBvh`](crate::mesh::MeshBvh) |
//!
//! What was a source that points where it looks, and a set of meshes:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_sightline::prelude::*;
//!
//! #[derive(Component)]
//! struct Laser;
//!
//! // Was RaycastMesh<Laser>.
//! #[derive(Component)]
//! struct Target;
//!
//! fn shine(scene: SceneQuery, lasers: Query<&GlobalTransform, With<Laser>>, targets: Query<(), With<Target>>) {
//!     let is_target = |entity| targets.contains(entity);
//!     let settings = SceneQuerySettings::default().filter(&is_target);
//!     for laser in &lasers {
//!         if let Some(hit) = scene.cast_ray(Ray3d::new(laser.translation(), laser.forward()), &settings) {
//!             println!("{} at {}, facing {}", hit.entity, hit.position, hit.normal);
//!         }
//!     }
//! }
//! ```
//!
//! And the ray under the cursor:
//!
//! ```
//! use bevy::{picking::backend::ray::RayMap, prelude::*};
//! use bevy_sightline::prelude::*;
//!
//! fn under_the_cursor(scene: SceneQuery, rays: Res<RayMap>) {
//!     for (_, ray) in rays.iter() {
//!         println!("{:?}", scene.cast_ray(*ray, &SceneQuerySettings::default()));
//!     }
//! }
//! ```
//!
//! # From `VisibilityRange`
//!
//! A `VisibilityRange` sits on each entity and says from where to where that is drawn. A [`ProxyLod`] sits on their
//! parent, lists the levels, and of these each view shows exactly one: no gaps, and two only while they fade. Each
//! level shows all that is below its entity. What was
//!
//! | entity | `start_margin` | `end_margin` |
//! |---|---|---|
//! | fine | 0..0 | 20..25 |
//! | coarse | 20..25 | 70..75 |
//! | picture | 70..75 | 150..160 |
//!
//! becomes
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! # fn set(mut commands: Commands, root: Entity, [fine, coarse, picture]: [Entity; 3]) {
//! let levels = ProxyLod::new(LodMetric::Distance, fine).then(20.0, coarse).then(70.0, picture).then_nothing(150.0);
//! commands.entity(root).insert(levels.measured_to(LodReference::Center));
//! # }
//! ```
//!
//! and the `VisibilityRange`s are taken out. If they stay, both must agree for something to be drawn.
//!
//! | `VisibilityRange` | [`ProxyLod`] |
//! |---|---|
//! | distance from the camera to the origin of each entity | to the nearest point of the group's box, or with [`LodReference::Center`] to the centre of its bounds, the same for all levels |
//! | `use_aabb` | [`LodReference::Center`] |
//! | the origin | the same with [bounds](crate::lod::ProxyLod::with_bounds) around it |
//! | margins in metres, within which levels are dithered | [`LodSettings::cross_fade`], a time: with one active camera; with more, levels switch at once |
//! | – | [`LodSettings::hysteresis`]: a coarser level comes a tenth beyond its threshold; zero for at the threshold |
//! | HLOD: one range for the whole, and others on each part | a level lists the roots of other groups: see below |
//! | 32 views, cameras and shadow origins together | any number |
//! | – | shadows may be cast by coarser levels: [`LodSettings::shadow_bias`](crate::lod::LodSettings::shadow_bias) |
//! | rays hit what is drawn | rays hit the finest level, or with [`LodHits::Shown`] and [`QueryVisibility::VisibleInView`] what is drawn; pointers need only the first |
//! | something that is shown only *beyond* some distance, with nothing before | keep the `VisibilityRange`: it is respected |
//!
//! Thresholds by distance are wrong as soon as the player zooms. [`LodMetric::Height`] and [`LodMetric::PixelError`]
//! are not; for the latter, `AutoProxy` makes and measures the levels (feature
//! `simplify`).
//!
//! A block of houses, with one mesh in their place from afar, where each house has levels of its own:
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! # fn set(mut commands: Commands, block: Entity, houses: Vec<[Entity; 3]>, from_afar: Entity) {
//! for &[house, fine, coarse] in &houses {
//!     commands.entity(house).insert(ProxyLod::new(LodMetric::Height, fine).then(0.2, coarse));
//! }
//! let houses: Vec<Entity> = houses.iter().map(|[house, ..]| *house).collect();
//! commands.entity(block).insert(ProxyLod::new(LodMetric::Height, houses).then(0.3, from_afar));
//! # }
//! ```
//!
//! [`SceneQuery`]: crate::index::SceneQuery
//! [`SceneQuery::cast_ray`]: crate::index::SceneQuery::cast_ray
//! [`SceneQuery::cast_ray_all`]: crate::index::SceneQuery::cast_ray_all
//! [`SceneQuery::cast_ray_until`]: crate::index::SceneQuery::cast_ray_until
//! [`SceneQuerySettings::filter`]: crate::index::SceneQuerySettings::filter
//! [`QueryVisibility`]: crate::index::QueryVisibility
//! [`QueryVisibility::VisibleInView`]: crate::index::QueryVisibility::VisibleInView
//! [`RayHit`]: crate::index::RayHit
//! [`RayHit::triangle`]: crate::index::RayHit::triangle
//! [`HitTriangle`]: crate::index::HitTriangle
//! [`ProxyLod`]: crate::lod::ProxyLod
//! [`LodReference::Center`]: crate::lod::LodReference::Center
//! [`LodSettings::cross_fade`]: crate::lod::LodSettings::cross_fade
//! [`LodSettings::hysteresis`]: crate::lod::LodSettings::hysteresis
//! [`LodHits::Shown`]: crate::lod::LodHits::Shown
//! [`QueryVisibility::VisibleInView`]: crate::index::QueryVisibility::VisibleInView
//! [`LodMetric::Height`]: crate::lod::LodMetric::Height
//! [`LodMetric::PixelError`]: crate::lod::LodMetric::PixelError
