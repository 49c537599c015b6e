//! The component that gives an entity a surface without a mesh.

use std::{fmt, sync::Arc};

use bevy::{ecs::component::Component, transform::components::Transform};

use crate::geometry::surface::Surface;

/// The surface that rays hit on an entity, in its local space, in place of its mesh; it needs no mesh at all.
///
/// Any [`Surface`]: a primitive of Bevy's, a [`SurfaceGroup`](crate::geometry::surface::SurfaceGroup) of them, or your
/// own. Clones share it. It must have an end ([`Surface::aabb`]): an `InfinitePlane3d` has none, a large `Plane3d` does.
///
/// Under a transform that flattens it, it is hit by no ray. An entity that is not drawn, for it has no mesh, counts as in
/// view as long as it is not hidden: give it a `Visibility` to let it be hidden with its parents.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((PickShape::new(Capsule3d::new(0.4, 1.2)), Transform::from_xyz(0.0, 1.0, 0.0)));
/// # }
/// ```
///
/// Not reflected, for it may be a surface of your own: a scene that is loaded has none, and is to be given it by code.
#[derive(Component, Clone)]
#[require(Transform)]
pub struct PickShape(Arc<dyn Surface>);

impl PickShape {
    /// A shape of its own.
    pub fn new(surface: impl Surface + 'static) -> Self {
        Self(Arc::new(surface))
    }

    /// The surface.
    pub fn surface(&self) -> &dyn Surface {
        &*self.0
    }
}

impl From<Arc<dyn Surface>> for PickShape {
    fn from(surface: Arc<dyn Surface>) -> Self {
        Self(surface)
    }
}

/// The surface that a plugin of this crate has worked out from other components, and keeps in step with them. What the
/// user says with a [`PickShape`] goes before it. Hit from both sides.
#[derive(Component, Clone, Debug)]
pub(crate) struct DerivedShape(pub PickShape);

impl fmt::Debug for PickShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("PickShape").field(&self.0.aabb()).finish()
    }
}
