//! Components that say how an entity takes part.

use bevy::ecs::{component::Component, reflect::ReflectComponent};
use bevy::reflect::{Reflect, std_traits::ReflectDefault};

use crate::geometry::volume::BoundingKind;

/// Keeps an entity out of the spatial index: no query, ray or pick finds it. Its children are not affected.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct NoSpatialIndex;

/// That views show an entity at some distances only, with others in its place at others: kept by
/// [`ProxyLodPlugin`](crate::lod::ProxyLodPlugin) on whatever is part of a [`ProxyLod`](crate::lod::ProxyLod).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq, Hash)]
pub enum DetailLevel {
    /// It is found by queries whether it is shown or not: of it, [`QueryVisibility::VisibleInView`] asks no more than
    /// [`QueryVisibility::Visible`].
    ///
    /// [`QueryVisibility::VisibleInView`]: super::QueryVisibility::VisibleInView
    /// [`QueryVisibility::Visible`]: super::QueryVisibility::Visible
    Finest,
    /// It stands in for something finer, and is found by no query.
    Coarser,
    /// It is found like any other entity.
    #[default]
    AsShown,
}

/// The kind of bounding volume that a ray must enter before the triangles of the entity's mesh are tested, in the local
/// space of the mesh.
///
/// [`BoundingKind`] tells what each kind costs and saves. By default it is the box, which is that of the root of the
/// mesh's hierarchy, and so costs nothing more. The other volumes are built in the background, once per mesh asset, and
/// change no answer, whether they are ready or not. A [`PickShape`](super::PickShape) brings its own: see
/// [`BoundedSurface`](crate::geometry::surface::BoundedSurface).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct BoundedBy(pub BoundingKind);

/// What rays hit on an entity with a mesh: the triangles, or a bounding volume of them, which costs less and is hit where
/// the triangles are not.
///
/// [`crate::index`] compares it with the other ways to make rays cheaper. A mesh all of whose entities are hit as volumes
/// gets no hierarchy. Like [`PickShape`](super::PickShape), a volume is a solid in the local space of the mesh, hit as
/// [`VolumeSurface`](crate::geometry::surface::VolumeSurface) says: only where rays enter it, unless back faces count. The
/// hits have a distance and a normal, but neither a triangle nor texture coordinates.
///
/// The triangles are hit instead while the volume is being built, in the background, once per mesh asset, except that the
/// axis-aligned box is there at once; if the volume would overflow; and under a transform that flattens the entity. A
/// `PickShape` comes before all this.
///
/// A skinned or morphed mesh is not posed then: its volume is that of the mesh as it was made, at the place of the entity.
///
/// [`BoundedBy`], which changes no answer, is about entities whose triangles are hit, and does nothing for others.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::prelude::*;
/// # fn spawn(mut commands: Commands, rock: Handle<Mesh>) {
/// commands.spawn((Mesh3d(rock), HitSurface::Volume(BoundingKind::Hull)));
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum HitSurface {
    /// The triangles.
    #[default]
    Mesh,
    /// The tightest volume of this kind around the triangles; of kind `Hull`, their convex hull, with all its corners.
    Volume(BoundingKind),
}

#[cfg(feature = "picking")]
pub use bevy::picking::mesh_picking::ray_cast::{RayCastBackfaces, SimplifiedMesh};

#[cfg(not(feature = "picking"))]
pub use without_bevy_picking::{RayCastBackfaces, SimplifiedMesh};

/// The two components of `bevy_picking` that matter to rays, for programs that do without that crate.
#[cfg(not(feature = "picking"))]
mod without_bevy_picking {
    use super::*;
    use bevy::{asset::Handle, mesh::Mesh};

    /// Makes rays hit the back faces of an entity too.
    #[derive(Component, Clone, Copy, Debug, Default, Reflect)]
    #[reflect(Component, Default, Clone)]
    pub struct RayCastBackfaces;

    /// The mesh that rays hit in place of the one that is drawn.
    #[derive(Component, Clone, Debug, Reflect)]
    #[reflect(Component, Clone)]
    pub struct SimplifiedMesh(pub Handle<Mesh>);
}
