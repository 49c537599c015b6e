//! From `cargo new` to hovering, clicking, dragging, and asking what a ray hits.
//!
//! For whoever has a Bevy app, or begins one, and wants to know what is under the mouse or in the way.
//!
//! # A new project
//!
//! ```sh
//! cargo new lookout
//! cd lookout
//! cargo add bevy@0.19.1 bevy_sightline@0.1
//! ```
//!
//! Bevy and everything that tests triangles are slow without optimisation. These lines in `Cargo.toml` optimise what
//! you do not change, once:
//!
//! ```toml
//! [profile.dev]
//! opt-level = 1
//!
//! [profile.dev.package."*"]
//! opt-level = 3
//! ```
//!
//! # Pick
//!
//! One line, [`SightlinePlugins`](crate::SightlinePlugins), makes everything with a mesh pickable. The events are
//! Bevy's own, and nothing has to be marked:
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_sightline::prelude::*;
//!
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, SightlinePlugins)).add_systems(Startup, setup).run();
//! }
//!
//! fn setup(mut commands: Commands, assets: Res<AssetServer>) {
//!     let eye = Transform::from_xyz(0.0, 4.0, 9.0).looking_at(Vec3::ZERO, Vec3::Y);
//!     commands.spawn((Camera3d::default(), eye));
//!     commands.spawn((DirectionalLight::default(), eye));
//!     let cube = assets.add(Cuboid::default().into());
//!     for x in [-2.0, 0.0, 2.0] {
//!         let white = assets.add(StandardMaterial::default());
//!         commands
//!             .spawn((Mesh3d(cube.clone()), MeshMaterial3d(white), Transform::from_xyz(x, 0.0, 0.0)))
//!             .observe(|over: On<Pointer<Over>>| println!("over {}", over.entity));
//!     }
//! }
//! ```
//!
//! Observe the entity that you mean, as here. Events go up from what was hit to its parents, and in the end to the
//! window: an observer that is added to the whole app (`App::add_observer`) hears of each of them, and of the window
//! alone when nothing else is under the mouse. A glTF scene is hit by its meshes, and the events come up to the entity
//! with the `WorldAssetRoot`: observe that.
//!
//! # Highlight, click, drag
//!
//! ```
//! use bevy::{color::palettes::tailwind::AMBER_400, prelude::*};
//! use bevy_sightline::prelude::*;
//!
//! type Materials<'w, 's> = Query<'w, 's, &'static MeshMaterial3d<StandardMaterial>>;
//!
//! fn light_up(over: On<Pointer<Over>>, of: Materials, mut materials: ResMut<Assets<StandardMaterial>>) -> Result {
//!     let mut material = materials.get_mut(&of.get(over.entity)?.0).ok_or("no material")?;
//!     material.base_color = AMBER_400.into();
//!     Ok(())
//! }
//!
//! fn calm_down(out: On<Pointer<Out>>, of: Materials, mut materials: ResMut<Assets<StandardMaterial>>) -> Result {
//!     let mut material = materials.get_mut(&of.get(out.entity)?.0).ok_or("no material")?;
//!     material.base_color = Color::WHITE;
//!     Ok(())
//! }
//!
//! // The hit of a pointer has more than Bevy's: triangle, weights of its corners, texture coordinates.
//! fn tell(click: On<Pointer<Click>>) {
//!     if let Some(hit) = click.hit.extra_as::<RayHit>() {
//!         println!("{} at {}, facing {}, triangle {:?}", hit.entity, hit.position, hit.normal, hit.triangle);
//!     }
//! }
//!
//! // Along the ground.
//! fn drag(
//!     drag: On<Pointer<Drag>>,
//!     view: Single<(&Camera, &GlobalTransform)>,
//!     mut places: Query<&mut Transform>,
//! ) -> Result {
//!     let (camera, eye) = *view;
//!     let ray = camera.viewport_to_world(eye, drag.pointer_location.position)?;
//!     if let Some(point) = ray.plane_intersection_point(Vec3::ZERO, InfinitePlane3d::new(Vec3::Y)) {
//!         places.get_mut(drag.entity)?.translation = point;
//!     }
//!     Ok(())
//! }
//!
//! fn make_live(thing: &mut EntityCommands) {
//!     thing.observe(light_up).observe(calm_down).observe(tell).observe(drag);
//! }
//! ```
//!
//! `Pickable::IGNORE` on an entity lets the mouse through, and [`NoSpatialIndex`](crate::index::NoSpatialIndex) takes
//! it out of every query.
//!
//! # Ask
//!
//! [`SceneQuery`](crate::index::SceneQuery) in any system answers what a ray hits, what is near, what touches a region,
//! and what lies between two points:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_sightline::prelude::*;
//!
//! fn look_ahead(scene: SceneQuery, player: Single<(Entity, &GlobalTransform)>) {
//!     let (player, place) = *player;
//!     let not_itself = [player];
//!     let settings = SceneQuerySettings::default().with_max_distance(50.0).excluding(&not_itself);
//!     let ahead = Ray3d::new(place.translation(), place.forward());
//!     if let Some(hit) = scene.cast_ray(ahead, &settings) {
//!         println!("{} is {} m ahead", hit.entity, hit.distance);
//!     }
//!     if let Some(nearest) = scene.nearest(place.translation(), &settings) {
//!         println!("{} is nearest", nearest.key);
//!     }
//! }
//! ```
//!
//! It answers as of the last `PostUpdate`: what has been spawned or moved since is not yet found where it is now. A
//! system in `PostUpdate`, after [`SpatialIndexSystems::Sync`](crate::index::SpatialIndexSystems::Sync), sees this
//! frame. By default everything is found that is not hidden, on screen or not, and of levels of detail the finest: see
//! [`QueryVisibility`](crate::index::QueryVisibility) for the other ways.
//!
//! # Which plugins there are
//!
//! | in [`SightlinePlugins`](crate::SightlinePlugins) | what it does | feature |
//! |---|---|---|
//! | [`SpatialIndexPlugin`](crate::index::SpatialIndexPlugin) | keeps the index; `SceneQuery` | |
//! | [`ProxyLodPlugin`](crate::lod::ProxyLodPlugin) | levels of detail, where there is a `ProxyLod` | |
//! | [`OcclusionPlugin`](crate::occlusion::OcclusionPlugin) | what hides, where there is an `Occluder` | |
//! | [`ViewCullingPlugin`](crate::culling::ViewCullingPlugin) | culling for cameras and lights, in place of Bevy's | |
//! | `AutoProxyPlugin` | makes levels, where there is an `AutoProxy` | `simplify` |
//! | `SpatialPickingPlugin` | pointers | `picking`, default |
//! | `SpriteIndexPlugin` | sprites | `sprite` |
//! | `SightlineGizmosPlugin` | lines, where they are switched on | `gizmos`, default |
//!
//! Not in the group: [`SightlineDiagnosticsPlugin`](crate::debug::diagnostics::SightlineDiagnosticsPlugin),
//! `SightlineInspectorPlugin` (feature `inspector`), and
//! [`LevelVariantsPlugin`](crate::lod::LevelVariantsPlugin), one for each type of material.
//!
//! Each adds those by itself without which it does nothing: `SpatialIndexPlugin`, and for what makes levels
//! `ProxyLodPlugin`. Levels that are entities, occlusion, `VisibleSet` and `VisibilityReasons` need
//! `ViewCullingPlugin`: to have Bevy cull, leave it in, and set
//! [`ViewCullingSettings::enabled`](crate::culling::ViewCullingSettings::enabled) to false. So take single ones, or the
//! group without some:
//!
//! ```no_run
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! // Picking and queries alone.
//! App::new().add_plugins((DefaultPlugins, SpatialPickingPlugin));
//!
//! // All but what hides.
//! App::new().add_plugins((DefaultPlugins, SightlinePlugins.build().disable::<OcclusionPlugin>()));
//! ```
//!
//! Do not add one twice, nor one beside the group: Bevy panics and names it. `SpatialIndexPlugin`,
//! `ProxyLodPlugin` and `SightlineDiagnosticsPlugin` may be added by whoever needs them.
//!
//! # See what it does
//!
//! **Gizmos** draw what is in the index. All are off by default:
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! fn show(mut store: ResMut<GizmoConfigStore>) {
//!     let gizmos = store.config_mut::<SightlineGizmos>().1;
//!     (gizmos.leaves, gizmos.rays) = (true, true);
//! }
//! ```
//!
//! **Diagnostics** tell Bevy's `DiagnosticsStore` what each phase takes and how much it has to do; the paths are listed
//! in [`diagnostics`](crate::debug::diagnostics):
//!
//! ```no_run
//! # use bevy::{diagnostic::LogDiagnosticsPlugin, prelude::*};
//! # use bevy_sightline::prelude::*;
//! App::new()
//!     .add_plugins((DefaultPlugins, SightlinePlugins))
//!     .add_plugins((SightlineDiagnosticsPlugin, LogDiagnosticsPlugin::default()))
//!     .run();
//! ```
//!
//! **The inspector** is a panel with all of this, and with the reason why something is seen or not, hit or not. It is a
//! feature, for it brings `bevy_egui`:
//!
//! ```sh
//! cargo add bevy_sightline --features inspector
//! ```
//!
#![cfg_attr(feature = "inspector", doc = "```no_run")]
#![cfg_attr(not(feature = "inspector"), doc = "```ignore")]
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! // After the DefaultPlugins. F1 opens and closes it.
//! App::new().add_plugins((DefaultPlugins, SightlinePlugins, SightlineInspectorPlugin)).run();
//! ```
//!
//! # From here
//!
//! - What rays hit of an entity, and how to make it cheaper or more exact: [`index`](crate::index).
//! - Box and lasso: [`selection`](crate::selection). What cameras see: [`culling`](crate::culling). What hides what:
//!   [`occlusion`](crate::occlusion). Levels of detail: [`lod`](crate::lod).
//! - Something is wrong: [`troubleshooting`](super::troubleshooting).
