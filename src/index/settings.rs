//! How the index is kept, and which entities a query considers.

use std::fmt;

use bevy::{
    camera::visibility::RenderLayers,
    ecs::{entity::Entity, reflect::ReflectResource, resource::Resource},
    reflect::{Reflect, std_traits::ReflectDefault},
};

use crate::{geometry::ray::triangle::Backfaces, spatial::uniform_grid::GridSettings};

/// How the [`SpatialIndex`](super::SpatialIndex) is kept. May be changed at any time.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct SpatialIndexSettings {
    /// The [`UniformGrid`](crate::spatial::UniformGrid) beside the tree, which answers
    /// [`neighbours_within`](super::SceneQuery::neighbours_within). By default there is one while that is asked, with cells
    /// of the size that it finds best; a size that is not positive and finite changes nothing, with a warning. Without it
    /// the tree answers, in the same way and more slowly.
    pub grid: Option<GridSettings>,
    /// For how many frames the grid is kept after it was last asked for: 600 by default. It is built in the frame after the
    /// first question, which the tree answers; what nobody asks has neither memory nor upkeep.
    pub grid_kept: u32,
    /// For how many frames the copy of a mesh is kept in which it was posed for rays, after the last that came near: the
    /// hierarchy and all triangles, some 100 bytes for each. 60 by default.
    pub posed_meshes_kept: u32,
    /// How the hierarchies of meshes are kept.
    pub meshes: MeshSettings,
}

impl Default for SpatialIndexSettings {
    fn default() -> Self {
        Self {
            grid: Some(GridSettings::default()),
            grid_kept: 600,
            posed_meshes_kept: 60,
            meshes: MeshSettings::default(),
        }
    }
}

/// How the hierarchies of meshes, [`MeshBvhs`](super::MeshBvhs), are kept. Changes no answer.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct MeshSettings {
    /// How much memory triangles and hierarchies may take, in bytes, before hierarchies are dropped. `None`, the default,
    /// is no limit.
    ///
    /// Those go first that no ray came near for longest; those that one came near within the last 60 frames stay, and so
    /// do all triangles, whatever the budget: answers stay exact.
    pub memory_budget: Option<usize>,
    /// Whether the hierarchies that are built from now on take less than half the memory, and rays up to twice as long.
    /// False by default.
    pub compact: bool,
    /// When the hierarchy of an edited mesh is built anew: when it costs rays so many times what it cost when it was
    /// built, by the surface area heuristic. 1.5 by default; infinity is never.
    pub rebuild_factor: f32,
}

impl Default for MeshSettings {
    fn default() -> Self {
        Self {
            memory_budget: None,
            compact: false,
            rebuild_factor: 1.5,
        }
    }
}

/// Which entities a query considers, by their visibility.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum QueryVisibility {
    /// All, hidden ones too, but for the coarser levels of a [`ProxyLod`](crate::lod::ProxyLod) for which the
    /// [finest one stands](crate::lod::LodHits).
    Any,
    /// Those that are not hidden, by their own `Visibility` or an ancestor's. Does not depend on cameras, and so is
    /// the same on a server.
    #[default]
    Visible,
    /// Those that some camera or light sees, as Bevy's `MeshRayCast` has it by default, and those that are not hidden and
    /// that no camera looks at because there is nothing to draw: a [`PickShape`](super::PickShape) without a mesh.
    VisibleInView,
}

/// Which entities a [`SceneQuery`](super::SceneQuery) considers, and how far it looks.
///
/// By default everything that is not hidden, without limit; of levels of detail the finest, whichever is shown.
///
/// ```
/// # use bevy::{camera::visibility::RenderLayers, prelude::*};
/// # use bevy_sightline::prelude::*;
/// # fn with(guard: Entity, doors: Query<(), With<Name>>) {
/// let enemies = RenderLayers::layer(2);
/// let is_door = |entity| doors.contains(entity);
/// let settings = SceneQuerySettings::default()
///     .with_max_distance(50.0)
///     .with_layers(&enemies)
///     .excluding(&[guard])
///     .filter(&is_door);
/// # }
/// ```
#[derive(Clone, Copy)]
pub struct SceneQuerySettings<'a> {
    /// How far a ray or a sweep reaches, and how far off the nearest entity may be, in world units. Infinite by default.
    pub max_distance: f32,
    /// Only entities that share a layer with these; entities without `RenderLayers` are on layer 0. `None`, the
    /// default, is no restriction.
    pub layers: Option<&'a RenderLayers>,
    /// Which entities by their visibility.
    pub visibility: QueryVisibility,
    /// Whether rays hit back faces. `None`, the default, leaves it to each entity: see [`crate::index`].
    pub backfaces: Option<Backfaces>,
    /// Entities that are passed over. Searched from end to end: for many, use [`predicate`](Self::predicate).
    pub excluded: &'a [Entity],
    /// Only entities for which this is true. Asked last: about entities that pass everything else, and of a ray only
    /// about those that it hits; by several threads where many rays are cast at once.
    pub predicate: Option<&'a (dyn Fn(Entity) -> bool + Sync)>,
}

impl Default for SceneQuerySettings<'_> {
    fn default() -> Self {
        Self {
            max_distance: f32::INFINITY,
            layers: None,
            visibility: QueryVisibility::default(),
            backfaces: None,
            excluded: &[],
            predicate: None,
        }
    }
}

impl<'a> SceneQuerySettings<'a> {
    /// Sets [`max_distance`](Self::max_distance).
    #[must_use]
    pub fn with_max_distance(self, max_distance: f32) -> Self {
        Self { max_distance, ..self }
    }

    /// Sets [`layers`](Self::layers).
    #[must_use]
    pub fn with_layers(self, layers: &'a RenderLayers) -> Self {
        Self {
            layers: Some(layers),
            ..self
        }
    }

    /// Sets [`visibility`](Self::visibility).
    #[must_use]
    pub fn with_visibility(self, visibility: QueryVisibility) -> Self {
        Self { visibility, ..self }
    }

    /// Sets [`backfaces`](Self::backfaces).
    #[must_use]
    pub fn with_backfaces(self, backfaces: Backfaces) -> Self {
        Self {
            backfaces: Some(backfaces),
            ..self
        }
    }

    /// Sets [`excluded`](Self::excluded).
    #[must_use]
    pub fn excluding(self, excluded: &'a [Entity]) -> Self {
        Self { excluded, ..self }
    }

    /// Sets [`predicate`](Self::predicate).
    #[must_use]
    pub fn filter(self, predicate: &'a (dyn Fn(Entity) -> bool + Sync)) -> Self {
        Self {
            predicate: Some(predicate),
            ..self
        }
    }
}

impl fmt::Debug for SceneQuerySettings<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneQuerySettings")
            .field("max_distance", &self.max_distance)
            .field("layers", &self.layers)
            .field("visibility", &self.visibility)
            .field("backfaces", &self.backfaces)
            .field("excluded", &self.excluded)
            .field("predicate", &self.predicate.map(|_| "Fn(Entity) -> bool"))
            .finish()
    }
}
