//! Tree, grid, k-d tree, octree or a list; how to build them; what asks what.
//!
//! For whoever keeps boxes, points or meshes of their own. If yours are entities, [`SceneQuery`] asks structures that
//! are kept for you, and all that is left to choose is in the [last section](#what-scenequery-asks).
//!
//! # Which structure
//!
//! All hold boxes with a small `Copy` key, answer [`SpatialQueries`], and give the very same answers. They differ in
//! what is cheap; the table in [`spatial`](crate::spatial#which-to-choose) has the figures.
//!
//! | yours | take |
//! |---|---|
//! | anything, of any size, that moves or may move; or you do not know yet | [`AabbTree`] |
//! | a crowd of like size that moves all over, asked for neighbours, pairs, or what is in a cell | [`UniformGrid`] |
//! | points that never move, asked for the nearest | [`PointKdTree`] |
//! | boxes that never move, in great numbers, asked by rays and frusta | [`KdTree`], which then is a little ahead of the tree |
//! | what is loaded, drawn or counted by regions and levels | [`Octree`], by its [nodes](crate::spatial::Octree::visit_nodes) |
//! | a handful, or the reference of a test | [`BruteForce`] |
//!
//! What speaks against each:
//!
//! - the tree wears as things travel: call [`optimize`](crate::spatial::AabbTree::optimize) once a frame;
//! - the grid takes rays less well, and a density that varies over orders of magnitude not well at all;
//! - the k-d trees cannot change: whatever moves has them built anew, which takes several times as long as for a tree;
//! - the octree is behind the tree in nearly everything but its levels;
//! - the list takes as long as there are boxes, and pairs take the square of that.
//!
//! # How to build it
//!
//! One by one ([`insert`](crate::spatial::SpatialUpdates::insert)) is for what comes in the course of a game. All at
//! once ([`insert_many`](crate::spatial::SpatialUpdates::insert_many)) is many times cheaper and better.
//!
//! [`BuildStrategy`] decides how a tree, or the hierarchy of a mesh, is built from many; its documentation has the
//! figures:
//!
//! | when | strategy |
//! |---|---|
//! | in a running game | `Ploc`, which is the default of trees |
//! | once, while loading or beside the use of something quicker, for rays ever after | `Reinsertion`, the default of meshes |
//! | to compare with the textbook | `MiddleSplit`, `MedianSplit`, `BinnedSah` |
//!
//! A k-d tree is split by the surface area heuristic ([`SplitMethod::Sah`]), or, built several times faster and as good
//! for points that are spread evenly, at the median.
//!
//! # Without Bevy's ECS
//!
//! The structures know no entities, and need no app:
//!
//! ```
//! use bevy::math::{Vec3, Vec3A, bounding::{Aabb3d, BoundingSphere}};
//! use bevy_sightline::{
//!     geometry::ray::Ray,
//!     spatial::{AabbTree, BuildStrategy, PointKdTree, SpatialQueries, SpatialUpdates, kd_tree::SplitMethod},
//! };
//!
//! // Built at once, and then asked by many rays.
//! let mut walls = AabbTree::new();
//! let boxes = (0..1000).map(|wall| (wall, Aabb3d::new(Vec3::X * wall as f32 * 3.0, Vec3::ONE)));
//! let leaves: Vec<_> = walls.insert_many(boxes).into_iter().flatten().collect();
//! walls.rebuild_with(BuildStrategy::Reinsertion);
//!
//! // The key tells what is in the box: this is the test against it, here the sphere inside.
//! let ray = Ray::new(Vec3::new(30.0, 50.0, 0.5), Vec3::NEG_Y, f32::INFINITY).expect("a direction");
//! let hit = walls.closest_hit(&ray, |wall, rest| {
//!     let sphere = BoundingSphere::new(Vec3::X * wall as f32 * 3.0, 1.0);
//!     rest.sphere_intersection_at(&sphere).map(|t| (t, ()))
//! });
//! assert_eq!(hit.map(|(wall, ..)| wall), Some(10));
//!
//! // What moves is told by its leaf; upkeep once a frame.
//! walls.update(leaves[10], Aabb3d::new(Vec3::Z * 100.0, Vec3::ONE)).expect("a sound box");
//! walls.optimize();
//! assert_eq!(walls.closest_box(&ray), None);
//!
//! // Points, for the nearest ever after.
//! let wells = (0..100).map(|well| (well, Vec3A::X * well as f32));
//! let wells = PointKdTree::from_points(wells, SplitMethod::Median).expect("finite points");
//! let mut nearest = Vec::new();
//! wells.k_nearest(Vec3A::X * 41.9, 2, f32::INFINITY, &mut nearest);
//! assert_eq!(nearest.iter().map(|well| well.key).collect::<Vec<_>>(), [42, 41]);
//! ```
//!
//! A large tree is built anew on another thread while it is in use:
//! [`begin_rebuild`](crate::spatial::AabbTree::begin_rebuild), [`run`](crate::spatial::aabb_tree::Rebuild::run),
//! [`adopt`](crate::spatial::AabbTree::adopt).
//!
//! The triangles of a mesh have a hierarchy of their own, in the local space of the mesh:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_sightline::{
//!     geometry::ray::{Ray, triangle::Backfaces},
//!     mesh::{MeshBvh, TriangleMesh},
//! };
//!
//! let sphere = Sphere::new(1.0).mesh().ico(20).expect("not too fine");
//! let triangles = TriangleMesh::from_mesh(&sphere).expect("triangles");
//! let bvh = MeshBvh::build(&triangles);
//! let ray = Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z, f32::INFINITY).expect("a direction");
//! let hit = bvh.closest_hit(&ray, Backfaces::Cull).expect("the sphere is ahead");
//! assert!((hit.t - 4.0).abs() < 0.01);
//! ```
//!
//! # What `SceneQuery` asks
//!
//! | question | by |
//! |---|---|
//! | rays, lines of sight, selection | the tree, and then the hierarchy of each mesh that is met, or the shape of the entity |
//! | regions, sweeps, the nearest, pairs | the tree; entities are their world boxes |
//! | [`neighbours_within`](crate::index::SceneQuery::neighbours_within) | the grid, which is there while this is asked; without one the tree, with the same answer |
//! | what cameras and lights see, what is drawn as gizmos | the tree |
//!
//! So the grid is for `neighbours_within` alone. If you never call that, nor draw its cells, there is none; if your crowd is of one size, you
//! may give that as its [`CellSize`](crate::spatial::uniform_grid::CellSize).
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::{prelude::*, spatial::uniform_grid::{CellSize, GridSettings}};
//! # let mut app = App::new();
//! app.add_plugins(SightlinePlugins);
//! let of_people = GridSettings { cell_size: CellSize::Fixed(2.0) };
//! app.world_mut().resource_mut::<SpatialIndexSettings>().grid = Some(of_people);
//! ```
//!
//! What rays hit of each entity, triangles, a simpler mesh, a volume or a shape, is chosen entity by entity: the table
//! is in [`index`](crate::index#what-a-ray-hits). Feature `inspector`: the tab *Structures* builds the other structures
//! over the entities of your own scene, and tells what each costs there.
//!
//! [`SceneQuery`]: crate::index::SceneQuery
//! [`SceneQuery::neighbours_within`]: crate::index::SceneQuery::neighbours_within
//! [`SpatialQueries`]: crate::spatial::SpatialQueries
//! [`SpatialUpdates::insert`]: crate::spatial::SpatialUpdates::insert
//! [`SpatialUpdates::insert_many`]: crate::spatial::SpatialUpdates::insert_many
//! [`AabbTree`]: crate::spatial::AabbTree
//! [`UniformGrid`]: crate::spatial::UniformGrid
//! [`KdTree`]: crate::spatial::KdTree
//! [`PointKdTree`]: crate::spatial::PointKdTree
//! [`Octree`]: crate::spatial::Octree
//! [`BruteForce`]: crate::spatial::BruteForce
//! [`BuildStrategy`]: crate::spatial::BuildStrategy
//! [`SplitMethod::Sah`]: crate::spatial::kd_tree::SplitMethod::Sah
