//! What to look at when something is wrong, and what each warning means.
//!
//! For whoever picks nothing, picks the wrong thing, misses something on the screen, sees levels pop, or waits.
//!
//! The quickest look is the inspector (feature `inspector`, `F1`): its tab *Query* has the ray under the mouse and what
//! became of it, *Culling* says why the selected thing is not seen, *Index* lists what is left out and why. Without it:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_sightline::prelude::*;
//!
//! fn what_is_wrong(
//!     thing: Single<Entity, With<Name>>,
//!     camera: Single<Entity, With<Camera>>,
//!     scene: SceneQuery,
//!     why: VisibilityReasons,
//! ) {
//!     println!("in the index: {:?}", scene.index().aabb(*thing));
//!     println!("left out: {:?}", scene.index().refused().find(|(entity, _)| entity == &*thing));
//!     println!("for this camera: {:?}", why.of(*thing, *camera));
//! }
//! ```
//!
//! # Nothing is picked
//!
//! | what may be | how to know, and the cure |
//! |---|---|
//! | There are no pointers: Bevy's `DefaultPickingPlugins` are not there, or its feature `bevy_picking` is off | `SpatialPickingStats::rays` stays zero |
//! | A UI node lies over the scene and takes it all, one that is not seen too | give it `Pickable::IGNORE`; `PointerHits` names it |
//! | `MeshPickingSettings::require_markers` is set | entities need a `Pickable`, cameras a `MeshPickingCamera` |
//! | `Pickable::IGNORE` or [`NoSpatialIndex`] is on the entity | each entity with a mesh has its own; they are not passed down |
//! | The camera shares no `RenderLayers` with it | entities without are on layer 0 |
//! | The mesh is not on the CPU: `RenderAssetUsages::RENDER_WORLD` alone | a [warning](#warnings); create it with `RenderAssetUsages::default()` |
//! | Its faces look away: a plane from behind, a sphere from inside | [`RayCastBackfaces`], or [`SceneQuerySettings::with_backfaces`] |
//! | It has neither a mesh nor a [`PickShape`]: lights, empty parents, what only a shader draws | give it a `PickShape` |
//! | It was spawned in this frame | it is there after the next `PostUpdate` |
//! | It is a sprite | feature `sprite`, and `SpriteIndexPlugin`, which is one of the `SightlinePlugins` |
//! | The pointer's ray asks for what is in view, and no camera sees it | `MeshPickingSettings::ray_cast_visibility` |
//! | Its data are NaN or infinite | it is among [`SpatialIndex::refused`], with a [warning](#warnings) |
//!
//! Events of a glTF scene: observe the entity with the `WorldAssetRoot`, to which they come up, or every mesh.
//!
//! # The wrong thing is picked
//!
//! - **An observer of the whole app hears several times of one thing**, and of the window: events go up from what was
//!   hit. Observe the entity, or compare `event.entity` with `event.original_event_target()`.
//! - **Something unseen is in front:** a transparent mesh, a trigger with a mesh, a sky. Rays know nothing of materials
//!   and textures. `Pickable::IGNORE` lets pointers through, `NoSpatialIndex` or [`SceneQuerySettings::filter`] rays.
//! - **It is hit where it was:** it moved after `PostUpdate`, or its `GlobalTransform` was written after
//!   [`SpatialIndexSystems::Sync`].
//! - **It is hit beside what is drawn:** a shader moves the vertices, or rays hit something else in its place:
//!   `PickShape`, then `SimplifiedMesh`, then [`HitSurface`]. Rays go through the holes of sprites, and `AlphaTest`
//!   says what a hole is.
//! - **A ray finds what is far off the screen, or its own caster:** the default is
//!   [`QueryVisibility::Visible`], in view or not; leave the caster out with [`SceneQuerySettings::excluding`].
//! - **A far object is hit by details that are not drawn:** rays hit the finest level, whichever is shown; ask for
//!   [`LodHits::Shown`]. Pointers need no more; rays of your own at levels that are entities ask for
//!   [`QueryVisibility::VisibleInView`] too, or they hit all levels, shown or not.
//! - **A box query finds too much:** [`overlap`](crate::index::SceneQuery::overlap), sweeps and neighbours know world
//!   boxes and not meshes; [`touching_meshes`](crate::index::SceneQuery::touching_meshes) knows triangles.
//!
//! # Something disappears
//!
//! First let Bevy cull. If it is still gone, the cause is elsewhere:
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! fn compare(mut culling: ResMut<ViewCullingSettings>) {
//!     culling.enabled = false;
//! }
//! ```
//!
//! Then ask [`VisibilityReasons`]:
//!
//! | answer | what to do |
//! |---|---|
//! | [`InactiveCamera`](crate::culling::VisibilityReason::InactiveCamera) | `Camera::is_active` |
//! | [`NotVisual`](crate::culling::VisibilityReason::NotVisual) | it lacks a `GlobalTransform` or a `Visibility` |
//! | [`LeftToGpu`](crate::culling::VisibilityReason::LeftToGpu) | `NoCpuCulling`: only the GPU knows |
//! | [`Hidden`](crate::culling::VisibilityReason::Hidden) | its `Visibility`, or that of an ancestor |
//! | [`OnOtherLayers`](crate::culling::VisibilityReason::OnOtherLayers) | `RenderLayers` of it and of the camera; they are not passed down |
//! | [`OutOfRange`](crate::culling::VisibilityReason::OutOfRange) | its `VisibilityRange` |
//! | [`OtherLevel`](crate::culling::VisibilityReason::OtherLevel) | another level of its [`ProxyLod`] is shown, or of a group around it: the thresholds |
//! | [`OutsideFrustum`](crate::culling::VisibilityReason::OutsideFrustum) | is its `Aabb` around what is drawn? See below |
//! | [`Occluded`](crate::culling::VisibilityReason::Occluded) | what hides it must not: see below |
//! | [`NotYet`](crate::culling::VisibilityReason::NotYet) | the next frame tells |
//!
//! - **A shader moves vertices out of the box** (wind, water, terrain): nobody can know. Give the entity a larger
//!   `Aabb` with `NoAutoAabb`, or `NoFrustumCulling`; against occlusion, [`NoOcclusionCulling`].
//! - **An occluder is not solid where it is drawn:** transparent, cut out by its texture, dissolved or moved by a
//!   shader, or not drawn yet. Take its [`Occluder`] off. [`Occluder::Box`] says that the thing fills its box,
//!   [`Occluder::Proxy`] that the proxy lies within. The gizmos show both (`SightlineGizmos::occluders`).
//! - **Through a thin gap, far off:** [`RasterMode::Fast`] may hide what is seen only there. `Strict`, the default,
//!   does not.
//! - **A `GlobalTransform` or `Aabb` is written between `SpatialIndexSystems::Sync` and `CheckVisibility`:** write it
//!   before.
//!
//! # Levels pop or flicker
//!
//! | what is seen | why, and what to do |
//! |---|---|
//! | a switch is noticed | it comes too near: raise [`LodSettings::bias`], or the thresholds. [`LodMetric::PixelError`] with one pixel does not show, if its thresholds are measured errors in the space of the root, as `AutoProxy` makes them |
//! | it switches back and forth | [`LodSettings::hysteresis`] is too small; [`LodSettings::min_dwell`] lets each level stay |
//! | it pops when one zooms | [`LodMetric::Distance`] knows no zoom |
//! | levels do not fade | [`LodSettings::cross_fade`] is zero by default; it is for levels that are entities, one active camera, and at most 1,024 fading at a time |
//! | several levels at once | an entity is not in the list of any level and so is always shown, or there is no `ViewCullingPlugin`, which leaves levels out |
//! | everything at the finest level | [`LodSettings::enabled`]; no active `Camera3d` for meshes that are swapped; a bias that is no positive number, with a [warning](#warnings) |
//! | the wrong level for its size | its bounds are those of the first level: set [`ProxyLod::with_bounds`] |
//! | a coarse level stays | it is streamed and not loaded: `sightline/lod/streaming`, `failed`, and `memory` against [`LodStreamingSettings::memory_budget`] |
//! | a shadow switches apart from the thing | [`LodSettings::shadow_bias`] is not 1 |
//!
//! [`LodChoices`] tells which level is shown where, and [`LodSwapped`] of each switch.
//!
//! # It is slow
//!
//! Measure an optimised build: [`getting_started`](super::getting_started#a-new-project) has the lines for
//! `Cargo.toml`. Then look at the [diagnostics](crate::debug::diagnostics), as text or in the inspector:
//!
//! | path | if it is large |
//! |---|---|
//! | `sightline/index/reconciled` | something writes `Mesh3d`, `Aabb`, `RenderLayers` or the like in every frame, equal or not: write on change (`set_if_neq`) |
//! | `sightline/index/moved` | everything moves: see below. What is not asked for, such as particles, may have [`NoSpatialIndex`] |
//! | `sightline/index/structures` | everything moves; where few ask for `neighbours_within`, and seldom, without a grid: [`SpatialIndexSettings::grid`]` = None` |
//! | `sightline/index/posed_for_rays` | rays come near many skinned meshes: give them a `PickShape` |
//! | `sightline/meshes/building` | meshes were loaded, or are edited in every frame; until a hierarchy is there, rays test all triangles |
//! | `sightline/picking/backend` | many pointers or cameras, or `report_blocked` |
//! | `sightline/culling/tested` | much that is not in the tree, skinned meshes above all; or a view that cuts through everything |
//! | `sightline/occlusion/triangles`, `over_budget` | occluders with many triangles: `Occluder::Auto` or `Box` in place of `Mesh`, a smaller [`OcclusionBudget`] |
//! | `sightline/lod/looked_at` | groups that move, or a camera that leaps |
//! | `sightline/gizmos/drawn` | gizmos are switched on |
//!
//! Of your own rays: cast many at once ([`cast_rays`](crate::index::SceneQuery::cast_rays)); ask
//! [`any_hit`](crate::index::SceneQuery::any_hit) where yes or no will do; limit the distance; exclude many by a filter
//! and few by a list, which is searched from end to end; and see in [`index`](crate::index#what-a-ray-hits) what makes
//! an entity cheaper to hit. [`SceneQuery::trace_ray`] tells what a ray did.
//!
//! **When Bevy's own is faster.** Keeping an index pays by what is asked of it. Where nearly everything moves in every
//! frame, following it costs more than Bevy's scan of all entities, for culling as for levels of detail: the tables of
//! [figures](crate#how-fast) say how much. Leave culling to Bevy then ([`ViewCullingSettings::enabled`]), or take only
//! the plugins that you ask. With a thousand entities both are done in a tenth of a millisecond, and it hardly matters.
//!
//! # Warnings
//!
//! Each is given once for each thing that it is about. `{…}` stands for what it names.
//!
//! | warning | what it means, and the cure |
//! |---|---|
//! | `{name} ({entity}) is left out of the spatial index: {why}` | No query finds it until its data are good again. By `{why}`: a `GlobalTransform` that is NaN or infinite (mostly a division by zero, or a zero vector normalised); an `Aabb` that is NaN, infinite or negative; joints, morph weights or vertex weights that are NaN, infinite or missing; a `PickShape` that is empty or has no end (take a large `Plane3d` for an `InfinitePlane3d`); bounds so large that they overflow in the world |
//! | `mesh {id} (used by {entity}): rays cannot hit it: {why}` | Its entities keep their boxes, and no ray hits them. Its topology is lines or points; it was moved to the render world (create it with `RenderAssetUsages::MAIN_WORLD` too); it has no positions, or not as `Float32x3`; or no triangle of it is sound. For something else to be hit: `SimplifiedMesh` or `PickShape` |
//! | `mesh {id} (used by {entity}): rays cannot hit {n} of its {m} triangles: …` | Indices out of range, or positions that are NaN or infinite: mend the mesh. The other triangles are hit |
//! | `the grid stays as it is, for there is none with these settings: {settings}` | [`SpatialIndexSettings::grid`] has a cell size that is not positive and finite |
//! | `SpatialPickingPlugin replaces MeshPickingPlugin: with both, everything is picked twice` | Take out `MeshPickingPlugin` |
//! | `Bevy's own sprite picking stays: sprites with a Pickable are picked twice` | It is not where this version of Bevy has it: use the version that this crate is for, or set `SpritePickingSettings::require_markers` and mark no camera |
//! | `image {id} (used by {name}, {entity}) counts as opaque, for its pixels cannot be read: {why}` | It is compressed, only in the render world, or too short: sprites with it have no holes for rays. Load it for the main world uncompressed, or set `AlphaTest::Off`, which asks nothing of the pixels |
//! | `ViewCullingPlugin leaves the culling of views to Bevy: that is not as this version of Bevy has it` | The systems to be replaced were not found: another version of Bevy, or a plugin has taken them out. All is drawn as Bevy has it; `SoftwareOcclusion` and levels that are entities need ours |
//! | `to the camera {camera} nothing is hidden: depth is not reversed, its near plane is very oblique, or its place is NaN or infinite` | Occlusion is off for this camera: look at its `Projection`, if that is one of your own, and at its transform |
//! | `{name} ({entity}) does not occlude: {why}` | It has an `Occluder` and hides nothing: it is skinned or morphed (`Occluder::Box` and `Proxy` work), or its `GlobalTransform` or `Aabb` is not finite |
//! | `the mesh {id} of {name} ({entity}) does not occlude: {why}` | For `Auto` it must be closed, not inside out, and thick enough for a box inside: mend it, or take another kind of `Occluder`. For all kinds it needs triangles, as for rays |
//! | `the levels of detail of {name} ({entity}) are not shown as they should be: {why}` | Its [`ProxyLod`] makes no sense as a whole. By `{why}`: more than eight levels; meshes and entities mixed; `Nothing` before the end; thresholds that are NaN, negative or out of order (they fall for `Height` and rise for `Distance`); a bias that is no positive number; an entity that is part of two groups; a group that is part of itself |
//! | `for the camera {camera} all is shown in full detail: its place, its projection or a bias is no good` | A transform that is not finite, a degenerate projection, or a [`LodBias`], [`LodSettings::bias`] that is no positive number |
//! | `a level of detail of {entity} cannot be loaded from {path}, and others stand in for it: {error}` | The path of a [`LodContent::Streamed`] names no mesh that can be loaded: it wants a label, as in `"oak.glb#Mesh0/Primitive0"` |
//! | `there are no proxies for the mesh of {entity}: {why}` | `AutoProxy` (feature `simplify`): the mesh has no triangles, attributes of different lengths, or is too large; a target is NaN or negative; or it could not be loaded. It is shown as it is |
//! | `the proxy of the block {root} has no material, and no other will have one: …` | `ClusterProxy`: from afar nothing is drawn in place of the block. Say which materials proxies keep: `SightlinePlugins.set(AutoProxyPlugin::default().with_material::<MeshMaterial3d<StandardMaterial>>())` |
//! | `there is no proxy for the block {root}: {why}` | `ClusterProxy` (feature `simplify`): the same of its parts, or they have attributes of a format that cannot be merged. The parts stay |
//!
//! What stops the app at its start: a plugin that is added twice, or beside the group that it is in, is named by Bevy;
//! and `SightlineInspectorPlugin` must come after the `DefaultPlugins`.
//!
//! [`NoSpatialIndex`]: crate::index::NoSpatialIndex
//! [`RayCastBackfaces`]: crate::index::RayCastBackfaces
//! [`PickShape`]: crate::index::PickShape
//! [`SpatialIndex::refused`]: crate::index::SpatialIndex::refused
//! [`SpatialIndexSettings::grid`]: crate::index::SpatialIndexSettings::grid
//! [`SpatialIndexSystems::Sync`]: crate::index::SpatialIndexSystems::Sync
//! [`HitSurface`]: crate::index::HitSurface
//! [`QueryVisibility::Visible`]: crate::index::QueryVisibility::Visible
//! [`QueryVisibility::VisibleInView`]: crate::index::QueryVisibility::VisibleInView
//! [`SceneQuery::trace_ray`]: crate::index::SceneQuery::trace_ray
//! [`SceneQuerySettings::filter`]: crate::index::SceneQuerySettings::filter
//! [`SceneQuerySettings::excluding`]: crate::index::SceneQuerySettings::excluding
//! [`SceneQuerySettings::with_backfaces`]: crate::index::SceneQuerySettings::with_backfaces
//! [`VisibilityReasons`]: crate::culling::VisibilityReasons
//! [`ViewCullingSettings::enabled`]: crate::culling::ViewCullingSettings::enabled
//! [`NoOcclusionCulling`]: crate::occlusion::NoOcclusionCulling
//! [`Occluder`]: crate::occlusion::Occluder
//! [`Occluder::Box`]: crate::occlusion::Occluder::Box
//! [`Occluder::Proxy`]: crate::occlusion::Occluder::Proxy
//! [`OcclusionBudget`]: crate::occlusion::OcclusionBudget
//! [`RasterMode::Fast`]: crate::raster::RasterMode::Fast
//! [`ProxyLod`]: crate::lod::ProxyLod
//! [`ProxyLod::with_bounds`]: crate::lod::ProxyLod::with_bounds
//! [`LodBias`]: crate::lod::LodBias
//! [`LodChoices`]: crate::lod::LodChoices
//! [`LodContent::Streamed`]: crate::lod::LodContent::Streamed
//! [`LodHits::Shown`]: crate::lod::LodHits::Shown
//! [`LodMetric::Distance`]: crate::lod::LodMetric::Distance
//! [`LodMetric::PixelError`]: crate::lod::LodMetric::PixelError
//! [`LodSettings::bias`]: crate::lod::LodSettings::bias
//! [`LodSettings::cross_fade`]: crate::lod::LodSettings::cross_fade
//! [`LodSettings::enabled`]: crate::lod::LodSettings::enabled
//! [`LodSettings::hysteresis`]: crate::lod::LodSettings::hysteresis
//! [`LodSettings::min_dwell`]: crate::lod::LodSettings::min_dwell
//! [`LodSettings::shadow_bias`]: crate::lod::LodSettings::shadow_bias
//! [`LodStreamingSettings::memory_budget`]: crate::lod::LodStreamingSettings::memory_budget
//! [`LodSwapped`]: crate::lod::LodSwapped
