//! An object, or a group of objects, with its levels of detail.

use bevy::{
    asset::{AssetPath, Handle},
    camera::primitives::Aabb,
    ecs::{
        component::Component,
        entity::{Entity, EntityMapper, MapEntities},
        reflect::{ReflectComponent, ReflectMapEntities},
    },
    mesh::Mesh,
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// Levels of detail of an object, from finest to coarsest, of which each view shows exactly one.
///
/// On the root of a group. Its levels either show **entities**, mostly children of the root, with all that is below them:
/// then every camera, and the shadows of every light, choose for themselves. Or they are **meshes** that are swapped on
/// the entity itself, which is the cheapest, and the same in all views: the [main camera](super::LodSettings::main_camera)
/// chooses. The two do not go together in one group.
///
/// The levels of a group may show roots of other groups, to any depth: so one proxy stands in for a whole block of
/// houses, each with levels of its own (HLOD).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::prelude::*;
/// # fn spawn(mut commands: Commands, statue: Handle<Mesh>, figure: Handle<Mesh>, block: Handle<Mesh>) {
/// // A mesh that is swapped: below a fifth of the height of the view, and below a twentieth.
/// let levels = ProxyLod::new(LodMetric::Height, statue.clone())
///     .then(0.2, figure)
///     .then(0.05, block)
///     .then_nothing(0.002);
/// commands.spawn((Mesh3d(statue), levels));
/// # }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, MapEntities, Debug, Clone, PartialEq)]
#[component(map_entities)]
pub struct ProxyLod {
    /// The levels, from finest to coarsest: at most eight, with one that shows nothing. Those after are left out, with a
    /// warning.
    pub levels: Vec<LodLevel>,
    /// What decides between them.
    pub metric: LodMetric,
    /// To where distances are measured.
    pub reference: LodReference,
    /// Multiplies the size of the group in views: over 1, finer levels are shown from farther away.
    pub bias: f32,
    /// The bounds of the group in the space of the root, which decide how large it is and where. By default the union of
    /// the boxes of what the first level shows, or of all meshes where these are swapped.
    pub bounds: Option<Aabb>,
    /// What rays and picks hit.
    pub hits: LodHits,
}

/// A level of a [`ProxyLod`].
#[derive(Clone, Debug, PartialEq, Reflect)]
#[reflect(Debug, Clone, PartialEq)]
pub struct LodLevel {
    /// What it shows.
    pub content: LodContent,
    /// From where on it is shown in place of the level before, as the [`LodMetric`] says.
    pub threshold: f32,
}

/// What a level shows.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[reflect(Debug, Clone, PartialEq)]
pub enum LodContent {
    /// The entity of the group with this mesh.
    Mesh(Handle<Mesh>),
    /// The same, with a mesh that is loaded when the level comes near, and may be dropped when it is far: see
    /// [`LodStreamingSettings`](super::LodStreamingSettings).
    Streamed(AssetPath<'static>),
    /// These entities, with all that is below them.
    Entities(Vec<Entity>),
    /// Nothing: the group is too small to matter. Only as the last level.
    Nothing,
}

/// What decides which level a view shows.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Debug, Clone, PartialEq)]
pub enum LodMetric {
    /// The diameter of the group's bounding sphere, as a fraction of the height of the viewport. A level is shown where
    /// the group is smaller than its threshold, so that thresholds fall from level to level.
    Height,
    /// How far a level deviates from the finest, in pixels. The threshold of a level is its geometric error in the space
    /// of the root; the coarsest level whose error is at most so many physical pixels is shown.
    PixelError(f32),
    /// The distance from the camera, in world units, whatever the field of view. A level is shown from its threshold on.
    Distance,
}

impl LodMetric {
    /// At most one pixel of error.
    pub const ONE_PIXEL: Self = Self::PixelError(1.0);
}

/// To where the distance of a group is measured, the same for all of its levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum LodReference {
    /// The nearest point of the group's world box: nothing of it is nearer to the camera.
    #[default]
    NearestPoint,
    /// The centre of the group's bounds.
    Center,
}

/// What rays and picks hit of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum LodHits {
    /// The finest level, whichever is shown.
    #[default]
    Finest,
    /// What is shown. Pointers hit what their cameras show. Other rays hit, where levels are entities, what any camera shows
    /// if they ask for what is [visible in view](crate::index::QueryVisibility::VisibleInView), and else all levels, as all
    /// other queries do; where meshes are swapped, the mesh that is there.
    Shown,
}

impl Default for ProxyLod {
    /// No levels: everything is shown. By the pixel, if some are added.
    fn default() -> Self {
        Self {
            levels: Vec::new(),
            metric: LodMetric::ONE_PIXEL,
            reference: LodReference::default(),
            bias: 1.0,
            bounds: None,
            hits: LodHits::default(),
        }
    }
}

impl ProxyLod {
    /// Begins with the finest level.
    pub fn new(metric: LodMetric, finest: impl Into<LodContent>) -> Self {
        Self {
            levels: vec![LodLevel {
                content: finest.into(),
                threshold: match metric {
                    LodMetric::Height => f32::INFINITY,
                    LodMetric::PixelError(_) | LodMetric::Distance => 0.0,
                },
            }],
            metric,
            ..Self::default()
        }
    }

    /// Adds a coarser level, which is shown from a threshold on: see [`LodMetric`].
    pub fn then(mut self, threshold: f32, content: impl Into<LodContent>) -> Self {
        self.levels.push(LodLevel {
            content: content.into(),
            threshold,
        });
        self
    }

    /// Shows nothing from a threshold on.
    pub fn then_nothing(self, threshold: f32) -> Self {
        self.then(threshold, LodContent::Nothing)
    }

    /// Measures distances to another place.
    pub fn measured_to(self, reference: LodReference) -> Self {
        Self { reference, ..self }
    }

    /// Multiplies the size of the group in views.
    pub fn with_bias(self, bias: f32) -> Self {
        Self { bias, ..self }
    }

    /// Takes these bounds, in the space of the root, in place of those of the first level.
    pub fn with_bounds(self, bounds: Aabb) -> Self {
        Self {
            bounds: Some(bounds),
            ..self
        }
    }

    /// Has rays and picks hit something else.
    pub fn hit_as(self, hits: LodHits) -> Self {
        Self { hits, ..self }
    }
}

impl From<Handle<Mesh>> for LodContent {
    fn from(mesh: Handle<Mesh>) -> Self {
        Self::Mesh(mesh)
    }
}

impl From<Entity> for LodContent {
    fn from(entity: Entity) -> Self {
        Self::Entities(vec![entity])
    }
}

impl From<Vec<Entity>> for LodContent {
    fn from(entities: Vec<Entity>) -> Self {
        Self::Entities(entities)
    }
}

impl MapEntities for ProxyLod {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for level in &mut self.levels {
            if let LodContent::Entities(entities) = &mut level.content {
                for entity in entities {
                    *entity = mapper.get_mapped(*entity);
                }
            }
        }
    }
}
