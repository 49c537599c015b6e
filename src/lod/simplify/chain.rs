//! The levels of one mesh.

use bevy::mesh::Mesh;

use super::{Simplified, Simplifier, SimplifyError, SimplifyTarget, simplifier::NEGLIGIBLE};
use crate::spatial::BuildProgress;

/// Simpler meshes for one mesh, from finest to coarsest: each with fewer triangles and a larger error than the one
/// before.
#[derive(Clone, Debug, Default)]
pub struct MeshChain {
    /// The levels after the original.
    pub levels: Vec<Simplified>,
    /// How many triangles the original has.
    pub triangles: usize,
    /// The longest side of the box of the original.
    pub extent: f32,
}

/// A level is worth its memory if it has at most this fraction of the triangles of the level before.
const SMALLER: f32 = 0.8;

impl MeshChain {
    /// Makes a level for each target, every one from the original.
    ///
    /// A level that has no less than four fifths of the triangles of the one before is left out, and so is one that a
    /// coarser one is no farther from the original than.
    ///
    /// # Errors
    ///
    /// If the mesh cannot be read, or a target is NaN or negative.
    pub fn build(mesh: &Mesh, targets: &[SimplifyTarget], lock_borders: bool) -> Result<Self, SimplifyError> {
        let made = Self::build_with(mesh, targets, lock_borders, None)?;
        Ok(made.expect("nothing calls it off"))
    }

    /// The same; nothing if `progress` was told to cancel.
    pub fn build_with(
        mesh: &Mesh,
        targets: &[SimplifyTarget],
        lock_borders: bool,
        progress: Option<&BuildProgress>,
    ) -> Result<Option<Self>, SimplifyError> {
        let is_cancelled = || progress.is_some_and(BuildProgress::is_cancelled);
        for target in targets {
            target.checked()?;
        }
        let simplifier = Simplifier::new(mesh)?;
        let mut made = Vec::with_capacity(targets.len());
        for (number, &target) in targets.iter().enumerate() {
            if is_cancelled() {
                return Ok(None);
            }
            let Some(level) = simplifier.simplify_with(target, lock_borders, progress)? else {
                return Ok(None);
            };
            made.push(level);
            if let Some(progress) = progress {
                progress.reach((number + 1) as f32 / targets.len() as f32);
            }
        }
        Ok(Some(Self {
            levels: worthwhile(made, simplifier.triangles(), simplifier.extent() * NEGLIGIBLE),
            triangles: simplifier.triangles(),
            extent: simplifier.extent(),
        }))
    }
}

/// The levels that are simpler than those before, and nearer to the original than those after.
fn worthwhile(mut made: Vec<Simplified>, triangles: usize, negligible: f32) -> Vec<Simplified> {
    let error = |level: &Simplified| level.deviation.at_most.max(negligible);
    made.sort_by_key(|level| std::cmp::Reverse(level.triangles));
    let mut kept: Vec<Simplified> = Vec::with_capacity(made.len());
    for level in made {
        // What has more triangles and is no nearer is of no use.
        while kept.last().is_some_and(|finer| error(finer) >= error(&level)) {
            kept.pop();
        }
        let before = kept.last().map_or(triangles, |finer| finer.triangles);
        if level.triangles as f32 <= SMALLER * before as f32 {
            kept.push(level);
        }
    }
    kept
}
