//! What a ray cast visits and tests on its way.

use bevy::{ecs::entity::Entity, math::Affine3A};

use super::RayHit;
use crate::spatial::Trace;

/// The way of a ray through the scene: what [`SceneQuery::trace_ray`](super::SceneQuery::trace_ray) tells. In world space,
/// with distances for parameters.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct RayTrace {
    /// The way through the tree: nodes and the boxes of entities.
    pub tree: Trace<Entity>,
    /// The entities whose boxes the ray enters, in the order in which they were visited: one for each of the
    /// [leaves](Trace::leaves) of the tree.
    pub entities: Vec<EntityTrace>,
    /// What the ray hits: what [`SceneQuery::cast_ray`](super::SceneQuery::cast_ray) tells.
    pub hit: Option<RayHit>,
}

/// What was done with an entity whose box a ray enters.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EntityTrace {
    /// The entity.
    pub entity: Entity,
    /// The distance at which the ray enters its box, in world units.
    pub entered_at: f32,
    /// What was held against the ray.
    pub test: EntityTest,
    /// The nearest hit on the entity, as far as the ray still mattered.
    pub hit: Option<RayHit>,
    /// Whether that became the nearest of all so far.
    pub is_nearest: bool,
}

/// What of an entity is held against a ray.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum EntityTest {
    /// Nothing: the settings do not admit it, or there is nothing on it that rays hit.
    None,
    /// The volume around its mesh, which the ray misses: the triangles are passed over.
    BoundingVolume,
    /// A shape or a volume that is hit in place of triangles.
    Shape,
    /// All triangles of a mesh, one by one: it has no hierarchy yet, or the transform of the entity is flat.
    Triangles(usize),
    /// A hierarchy of triangles.
    Hierarchy {
        /// The way through it, in the space of the mesh. The key of a leaf is the numbers of its triangles.
        trace: Trace<Vec<u32>>,
        /// Where the mesh is.
        world_from_mesh: Affine3A,
    },
}

impl RayTrace {
    /// How many entities had a surface held against the ray, not only a box.
    pub fn entities_tested(&self) -> usize {
        let tested = |entity: &&EntityTrace| !matches!(entity.test, EntityTest::None);
        self.entities.iter().filter(tested).count()
    }

    /// How many triangles were tested, of all entities.
    pub fn triangles_tested(&self) -> usize {
        self.entities.iter().map(|entity| entity.test.triangles()).sum()
    }

    /// The hits that were the nearest when they were found: the last one is [`hit`](Self::hit).
    pub fn hits(&self) -> impl Iterator<Item = &RayHit> {
        self.entities
            .iter()
            .filter(|entity| entity.is_nearest)
            .filter_map(|entity| entity.hit.as_ref())
    }
}

impl EntityTest {
    /// How many triangles were tested.
    pub fn triangles(&self) -> usize {
        match self {
            Self::None | Self::BoundingVolume | Self::Shape => 0,
            Self::Triangles(count) => *count,
            Self::Hierarchy { trace, .. } => trace.leaves().map(|leaf| leaf.key.len()).sum(),
        }
    }
}
