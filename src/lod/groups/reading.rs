//! Reading a [`ProxyLod`], as far as it makes sense.

use std::fmt;

use bevy::{
    asset::{AssetPath, Handle},
    camera::primitives::Aabb,
    ecs::entity::Entity,
    mesh::Mesh,
};
use smallvec::SmallVec;

use super::GroupId;
use crate::lod::{LodContent, LodHits, LodMetric, LodReference, ProxyLod, lens::MAX_LEVELS};

/// A group.
#[derive(Clone, Debug)]
pub(in crate::lod) struct Group {
    pub root: Entity,
    pub contents: Contents,
    pub metric: LodMetric,
    pub reference: LodReference,
    pub bias: f32,
    pub hits: LodHits,
    pub given_bounds: Option<Aabb>,
    pub thresholds: SmallVec<[f32; MAX_LEVELS]>,
    /// One bit for each level that could be shown.
    pub available: u8,
    /// Those of which some meshes are not loaded.
    pub missing: u8,
    /// The box around all of its meshes, if these are swapped.
    pub mesh_bounds: Option<Aabb>,
    /// Its bounds in the space of the root, as far as they are known.
    pub bounds: Option<Aabb>,
    /// Whether what it lists is elsewhere than right below its root, and so may move by itself unnoticed.
    pub is_loose: bool,
    /// Those of no nearer group.
    pub members: Vec<Entity>,
    /// The groups of which it shows or hides the roots.
    pub nested: Vec<GroupId>,
    /// The level whose mesh its root has.
    pub applied: Option<u8>,
    /// What else its root has been given.
    pub given: Given,
}

/// What an entity has been given because its meshes are swapped.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::lod) struct Given {
    /// A box around all of its meshes.
    pub has_bounds: bool,
    /// The finest mesh, for rays.
    pub has_simplified_mesh: bool,
}

/// What the levels of a group show.
#[derive(Clone, Debug)]
pub(in crate::lod) enum Contents {
    Meshes(SmallVec<[MeshLevel; 4]>),
    /// Nothing is an empty list.
    Entities(SmallVec<[Vec<Entity>; 4]>),
}

/// A mesh that is swapped in.
#[derive(Clone, Debug)]
pub(in crate::lod) enum MeshLevel {
    Mesh(Handle<Mesh>),
    Streamed(AssetPath<'static>),
    Nothing,
}

/// What is wrong with a group; it is shown all the same, as far as that goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::lod) enum Flaw {
    TooManyLevels,
    MixedContents,
    NothingBeforeOthers,
    Threshold,
    Bias,
    /// An entity is listed by two groups.
    Shared(Entity),
    /// The group is part of itself.
    Cycle,
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::TooManyLevels => write!(f, "it has more than {MAX_LEVELS} levels; those after are left out"),
            Self::MixedContents => write!(
                f,
                "it has levels that are meshes and levels that are entities; those unlike the first are left out"
            ),
            Self::NothingBeforeOthers => write!(
                f,
                "a level that shows nothing is not the last; those after are left out"
            ),
            Self::Threshold => write!(
                f,
                "a threshold, or how many pixels of error there may be, is NaN or negative, or thresholds are not in order; levels may never be shown"
            ),
            Self::Bias => write!(f, "its bias is not a positive number, and counts as 1"),
            Self::Shared(entity) => write!(f, "{entity} is part of another group, and not of this one"),
            Self::Cycle => write!(f, "it is part of itself"),
        }
    }
}

impl Group {
    /// Reads a component, as far as it makes sense.
    pub(super) fn read(root: Entity, lod: &ProxyLod, flaws: &mut Vec<Flaw>) -> Self {
        let mut thresholds = SmallVec::new();
        let is_mesh = |content: &LodContent| matches!(content, LodContent::Mesh(_) | LodContent::Streamed(_));
        let first_is_mesh = lod.levels.iter().find_map(|level| match level.content {
            LodContent::Nothing => None,
            _ => Some(is_mesh(&level.content)),
        });
        let mut contents = if first_is_mesh == Some(false) {
            Contents::Entities(SmallVec::new())
        } else {
            Contents::Meshes(SmallVec::new())
        };
        for (number, level) in lod.levels.iter().enumerate() {
            if thresholds.len() == MAX_LEVELS {
                flaws.push(Flaw::TooManyLevels);
                break;
            }
            match (&mut contents, &level.content) {
                (Contents::Meshes(levels), LodContent::Mesh(mesh)) => levels.push(MeshLevel::Mesh(mesh.clone())),
                (Contents::Meshes(levels), LodContent::Streamed(path)) => {
                    levels.push(MeshLevel::Streamed(path.clone()));
                }
                (Contents::Meshes(levels), LodContent::Nothing) => levels.push(MeshLevel::Nothing),
                (Contents::Entities(levels), LodContent::Entities(entities)) => levels.push(entities.clone()),
                (Contents::Entities(levels), LodContent::Nothing) => levels.push(Vec::new()),
                _ => {
                    flaws.push(Flaw::MixedContents);
                    continue;
                }
            }
            thresholds.push(level.threshold);
            if level.content == LodContent::Nothing && number + 1 < lod.levels.len() {
                flaws.push(Flaw::NothingBeforeOthers);
                break;
            }
        }
        let rest = thresholds.get(1..).unwrap_or(&[]);
        let are_numbers = rest.iter().all(|&threshold: &f32| threshold >= 0.0);
        let are_in_order = rest.windows(2).all(|pair| match lod.metric {
            LodMetric::Height => pair[0] >= pair[1],
            LodMetric::Distance => pair[0] <= pair[1],
            LodMetric::PixelError(_) => true,
        });
        let is_sound = !matches!(lod.metric, LodMetric::PixelError(pixels) if pixels.is_nan() || pixels <= 0.0);
        if !are_numbers || !are_in_order || !is_sound {
            flaws.push(Flaw::Threshold);
        }
        let is_sound = lod.bias > 0.0 && lod.bias.is_finite();
        if !is_sound {
            flaws.push(Flaw::Bias);
        }
        Self {
            root,
            contents,
            metric: lod.metric,
            reference: lod.reference,
            bias: if is_sound { lod.bias } else { 1.0 },
            hits: lod.hits,
            given_bounds: lod.bounds,
            thresholds,
            available: 0,
            missing: 0,
            mesh_bounds: None,
            bounds: None,
            is_loose: false,
            members: Vec::new(),
            nested: Vec::new(),
            applied: None,
            given: Given::default(),
        }
    }

    /// How many levels there are.
    pub fn levels(&self) -> usize {
        self.thresholds.len()
    }

    /// The entities that levels list, with the levels of each.
    pub(super) fn listed(&self) -> impl Iterator<Item = (Entity, u8)> + '_ {
        let levels: &[Vec<Entity>] = match &self.contents {
            Contents::Entities(levels) => levels,
            Contents::Meshes(_) => &[],
        };
        (levels.iter().enumerate())
            .flat_map(|(level, entities)| entities.iter().map(move |&entity| (entity, 1 << level)))
    }

    /// Whether some of its meshes are loaded when they come near.
    pub(in crate::lod) fn streams(&self) -> bool {
        match &self.contents {
            Contents::Meshes(levels) => levels.iter().any(|level| matches!(level, MeshLevel::Streamed(_))),
            Contents::Entities(_) => false,
        }
    }

    /// The levels that show a mesh.
    pub(super) fn mesh_levels(&self) -> u8 {
        match &self.contents {
            Contents::Meshes(levels) => levels.iter().enumerate().fold(0, |bits, (number, level)| {
                bits | u8::from(!matches!(level, MeshLevel::Nothing)) << number
            }),
            Contents::Entities(_) => 0,
        }
    }
}
