//! Rays, queries, culling and levels of detail without a window, a renderer or a GPU.
//!
//! For whoever writes a server, a test, or a tool on the command line.
//!
//! # Features
//!
//! ```toml
//! [dependencies]
//! bevy_sightline = { version = "0.1.0", default-features = false }
//!
//! [dependencies.bevy]
//! version = "0.19.1"
//! default-features = false
//! features = ["async_executor", "bevy_log", "multi_threaded", "std"]
//! ```
//!
//! Without its default features the crate is the index with all queries, selection, levels of detail, occlusion and
//! culling. It brings the crates of Bevy that it needs, among which there is no renderer, no `winit` and no picking.
//! Add `picking` for pointers that you make yourself, and `simplify` to have levels made. Its own `RayCastBackfaces`
//! and `SimplifiedMesh`, in [`index`](crate::index), stand in for those of `bevy_picking` where that is not there.
//!
//! # The least plugins
//!
//! None of Bevy's is demanded. What is missing takes away only what it would have done:
//!
//! | Bevy's plugin | without it |
//! |---|---|
//! | `MinimalPlugins` | there is nothing that runs the app |
//! | `TransformPlugin` | you write `GlobalTransform`s yourself |
//! | `AssetPlugin`, `MeshPlugin` | there are no meshes; [`PickShape`](crate::index::PickShape) needs none |
//! | `ImagePlugin`, `WindowPlugin`, `CameraPlugin` | `Visibility` is not passed down, and no view is culled; meshes have their boxes from the index |
//! | `LightPlugin` | there are no lists for shadow maps |
//! | `InputPlugin`, `DefaultPickingPlugins` | there are no pointers (feature `picking`) |
//!
//! This is a whole server:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_sightline::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, TransformPlugin, SightlinePlugins));
//! app.world_mut().spawn((PickShape::new(Capsule3d::new(0.4, 1.2)), Transform::from_xyz(0.0, 1.0, -8.0)));
//! app.add_systems(FixedUpdate, shoot);
//! app.update();
//!
//! fn shoot(scene: SceneQuery) {
//!     let ray = Ray3d::new(Vec3::Y, Dir3::NEG_Z);
//!     let hit = scene.cast_ray(ray, &SceneQuerySettings::default());
//!     println!("{:?}", hit.map(|hit| hit.entity));
//! }
//! ```
//!
//! `app.run()` goes on for ever, as `ScheduleRunnerPlugin`, one of the `MinimalPlugins`, is told to:
//! `MinimalPlugins.set(ScheduleRunnerPlugin::run_loop(Duration::from_millis(16)))`.
//!
//! # Shapes instead of meshes
//!
//! [`PickShape`](crate::index::PickShape) gives an entity a surface for rays: one of Bevy's primitives, a
//! [`SurfaceGroup`](crate::geometry::surface::SurfaceGroup) of them, or anything that implements
//! [`Surface`](crate::geometry::surface::Surface). It is exact, takes no memory to speak of when it is shared, and
//! brings its own bounds. It needs an end: a large `Plane3d` stands for the ground. Give the entity a `Visibility` if
//! it is to be hidden.
//!
//! # When answers are new
//!
//! The index is brought up to date once in each `app.update()`, in `PostUpdate`. So all fixed steps of a frame see the
//! end of the frame before, however many there are, and before the first `PostUpdate` nothing is found. A server that
//! wants each step to see the one before runs one step per update: put the simulation into `Update`, or let time go on
//! by one step each time ([`TimeUpdateStrategy::FixedTimesteps(1)`](bevy::time::TimeUpdateStrategy)).
//!
//! # Ask a `World`
//!
//! Without a system, by a `SystemState` that you keep:
//!
//! ```
//! use bevy::{ecs::system::SystemState, prelude::*};
//! use bevy_sightline::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, TransformPlugin, SightlinePlugins));
//! let ball = app.world_mut().spawn(PickShape::new(Sphere::new(1.0))).id();
//! app.update();
//!
//! let mut state = SystemState::<SceneQuery>::new(app.world_mut());
//! let scene = state.get(app.world()).expect("the plugin is there");
//! let settings = SceneQuerySettings::default();
//! assert!(!scene.line_of_sight(Vec3::Z * 5.0, Vec3::NEG_Z * 5.0, &settings));
//! assert_eq!(scene.nearest(Vec3::X * 3.0, &settings).map(|nearest| nearest.key), Some(ball));
//! ```
//!
//! # Several worlds
//!
//! Each `App`, and each `SubApp` with the plugins, has an index of its own; they know nothing of each other. A `SubApp`
//! lacks two things that an `App` has:
//!
//! ```
//! use bevy::{app::{Main, MainSchedulePlugin, SubApp}, ecs::schedule::ScheduleLabel, prelude::*};
//! use bevy_sightline::prelude::*;
//!
//! let mut match_1 = SubApp::new();
//! match_1.update_schedule = Some(Main.intern());
//! match_1.init_resource::<AppTypeRegistry>();
//! match_1.add_plugins((MainSchedulePlugin, TransformPlugin, SightlinePlugins));
//! match_1.finish();
//! match_1.cleanup();
//! # bevy::tasks::ComputeTaskPool::get_or_init(bevy::tasks::TaskPool::default);
//! match_1.update();
//! ```
//!
//! # What a player sees
//!
//! Culling and occlusion need no renderer. A server that has a camera for a player knows what is in the player's view,
//! and what is hidden behind a wall: to send less, and to tell no cheat where anybody is. This wants `CameraPlugin`,
//! which wants `ImagePlugin` and `WindowPlugin`; it opens no window:
//!
//! ```
//! use bevy::{camera::CameraPlugin, image::ImagePlugin, mesh::MeshPlugin, prelude::*, window::WindowPlugin};
//! use bevy_sightline::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin))
//!     .add_plugins((ImagePlugin::default(), MeshPlugin, WindowPlugin::default(), CameraPlugin))
//!     .add_plugins(SightlinePlugins);
//! app.finish();
//! app.cleanup();
//!
//! let (wall, cube) = {
//!     let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
//!     (meshes.add(Cuboid::new(8.0, 6.0, 1.0)), meshes.add(Cuboid::default()))
//! };
//! let world = app.world_mut();
//! let player = world.spawn((Camera3d::default(), SoftwareOcclusion::default())).id();
//! world.spawn((Mesh3d(wall), Occluder::Box, Transform::from_xyz(0.0, 0.0, -10.0)));
//! let mut spawn = |z| world.spawn((Mesh3d(cube.clone()), Transform::from_xyz(0.0, 0.0, z))).id();
//! let [before, behind] = [-5.0, -20.0].map(&mut spawn);
//! app.update();
//! app.update();
//!
//! let seen = app.world().get::<VisibleSet>(player).expect("every camera has one");
//! assert!(seen.contains(before) && !seen.contains(behind));
//! ```
//!
//! [`visible_fraction`](crate::index::SceneQuery::visible_fraction) tells how much of somebody a camera sees, and
//! [`visible_fraction_from`](crate::index::SceneQuery::visible_fraction_from) does without a camera. Without a window
//! the height of a viewport is not known: levels of detail take
//! [`LodSettings::viewport_height`](crate::lod::LodSettings) for it.
