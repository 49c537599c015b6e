//! Why a mesh cannot be simplified.

use bevy::reflect::Reflect;

use crate::mesh::UnusableMesh;

/// Why there is no simpler mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplifyError {
    /// The mesh has no surface.
    #[error(transparent)]
    Unusable(#[from] UnusableMesh),
    /// A vertex attribute has not as many values as there are positions.
    #[error("its attribute {name} has {values} values for {vertices} vertices")]
    UnevenAttribute {
        /// The name of the attribute.
        name: &'static str,
        /// How many values it has.
        values: usize,
        /// How many positions there are.
        vertices: usize,
    },
    /// Its positions are so far apart that their distances overflow.
    #[error("it is too large: the distances between its vertices overflow")]
    TooLarge,
    /// The target is NaN or negative.
    #[error("{0:?} is no target")]
    BadTarget(SimplifyTarget),
    /// The asset could not be loaded.
    #[error("its mesh could not be loaded")]
    NotLoaded,
    /// Parts of a block have a vertex attribute of a format that cannot be merged.
    #[error("its parts have vertex attributes that cannot be merged")]
    Unmergeable,
}

/// How far a mesh is simplified.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Debug, Clone, PartialEq)]
pub enum SimplifyTarget {
    /// As few triangles as can be while the measured error is at most this fraction of the longest side of the box of
    /// the original. Less than a ten-thousandth counts as that.
    Error(f32),
    /// This fraction of the triangles of the original, or a few less, whatever the error is.
    Ratio(f32),
}

impl SimplifyTarget {
    /// # Errors
    ///
    /// If the number is NaN or negative.
    pub(super) fn checked(self) -> Result<Self, SimplifyError> {
        let (Self::Error(number) | Self::Ratio(number)) = self;
        // NaN is not at least zero either.
        if number >= 0.0 {
            Ok(self)
        } else {
            Err(SimplifyError::BadTarget(self))
        }
    }
}
