//! What parts of a block have to have in common to become one mesh, and what that mesh has of them.

use std::any::TypeId;

use bevy::ecs::{
    component::Component,
    resource::Resource,
    world::{EntityRef, EntityWorldMut},
};

/// The components that tell parts of a block apart, and that their proxies get: materials.
///
/// Not reflected, for it is made of code for these types.
#[derive(Resource, Clone, Debug, Default)]
pub struct ClusterMaterials {
    kinds: Vec<Kind>,
}

/// A type of component.
#[derive(Clone, Copy, Debug)]
struct Kind {
    id: TypeId,
    is_same: fn(EntityRef, EntityRef) -> bool,
    copy: fn(EntityRef) -> Option<Dressing>,
}

/// Gives a proxy a component.
pub(super) type Dressing = Box<dyn FnOnce(&mut EntityWorldMut) + Send + Sync>;

impl ClusterMaterials {
    /// Tells parts apart by a component from now on.
    pub fn add<C: Component + Clone + PartialEq>(&mut self) {
        let id = TypeId::of::<C>();
        if self.kinds.iter().all(|kind| kind.id != id) {
            self.kinds.push(Kind {
                id,
                is_same: |a, b| a.get::<C>() == b.get::<C>(),
                copy: |from| {
                    let value = from.get::<C>()?.clone();
                    Some(Box::new(move |to: &mut EntityWorldMut| {
                        to.insert(value);
                    }))
                },
            });
        }
    }

    /// Whether proxies get nothing of their parts, and so nothing that they could be drawn with.
    pub(super) fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Whether two parts may become one mesh.
    pub(super) fn are_same(&self, a: EntityRef, b: EntityRef) -> bool {
        self.kinds.iter().all(|kind| (kind.is_same)(a, b))
    }

    /// What the proxy of a part gets of it.
    pub(super) fn copies(&self, from: EntityRef) -> Vec<Dressing> {
        self.kinds.iter().filter_map(|kind| (kind.copy)(from)).collect()
    }
}
