//! What a block consists of.

use bevy::{
    asset::{AssetId, AssetServer, Assets, Handle},
    camera::visibility::Visibility,
    ecs::{
        entity::{Entity, EntityHashSet},
        hierarchy::Children,
        world::{EntityRef, World},
    },
    math::Affine3A,
    mesh::{Mesh, Mesh3d, morph::MeshMorphWeights, skinning::SkinnedMesh},
    transform::components::Transform,
};

use super::proxies::has_failed;
use crate::lod::{LodContent, ProxyLod};

/// The parts of a block that can be merged, and where they are.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub parts: Vec<Part>,
    /// The children of the root below which there are parts.
    pub children: Vec<Entity>,
    /// Whether all meshes are loaded.
    pub is_loaded: bool,
}

/// A mesh in a block.
#[derive(Debug)]
pub(super) struct Part {
    pub entity: Entity,
    pub mesh: AssetId<Mesh>,
    /// In the space of the root.
    pub place: Affine3A,
}

impl Block {
    /// Looks for the parts below a root.
    pub fn below(root: EntityRef, world: &World) -> Self {
        let mut block = Self {
            is_loaded: true,
            ..Self::default()
        };
        let mut proxies = EntityHashSet::default();
        note_proxies(root, &mut proxies);
        for &child in children(root) {
            let before = block.parts.len();
            block.visit(child, Affine3A::IDENTITY, true, &mut proxies, world);
            if block.parts.len() > before {
                block.children.push(child);
            }
        }
        block
    }

    /// Takes what is below an entity, in the space of its parent, that is not a level of something.
    fn visit(&mut self, entity: Entity, parent: Affine3A, is_shown: bool, proxies: &mut EntityHashSet, world: &World) {
        let Ok(entity) = world.get_entity(entity) else {
            return;
        };
        if proxies.contains(&entity.id()) {
            return;
        }
        let is_shown = match entity.get::<Visibility>() {
            Some(Visibility::Visible) => true,
            Some(Visibility::Hidden) => false,
            Some(Visibility::Inherited) | None => is_shown,
        };
        let place = match entity.get::<Transform>() {
            Some(transform) => parent * transform.compute_affine(),
            None => parent,
        };
        note_proxies(entity, proxies);
        let is_posed = entity.contains::<SkinnedMesh>() || entity.contains::<MeshMorphWeights>();
        if let Some(mesh) = finest(entity)
            && is_shown
            && !is_posed
            && !has_failed(world.get_resource::<AssetServer>(), mesh.id())
        {
            let assets = world.get_resource::<Assets<Mesh>>();
            self.is_loaded &= assets.is_some_and(|assets| assets.contains(mesh));
            self.parts.push(Part {
                entity: entity.id(),
                mesh: mesh.id(),
                place,
            });
        }
        for &child in children(entity) {
            self.visit(child, place, is_shown, proxies, world);
        }
    }
}

fn children(entity: EntityRef<'_>) -> &[Entity] {
    entity.get::<Children>().map_or(&[], |children| children)
}

/// The mesh of an entity, whichever of its levels is shown.
fn finest(entity: EntityRef<'_>) -> Option<&Handle<Mesh>> {
    let shown = entity.get::<Mesh3d>()?;
    match entity.get::<ProxyLod>().and_then(|lod| lod.levels.first()) {
        Some(level) if let LodContent::Mesh(finest) = &level.content => Some(finest),
        _ => Some(&shown.0),
    }
}

/// Notes the coarser levels of an entity: they stand in for what is there already.
fn note_proxies(entity: EntityRef, proxies: &mut EntityHashSet) {
    let Some(lod) = entity.get::<ProxyLod>() else {
        return;
    };
    let mut levels = lod.levels.iter().map(|level| match &level.content {
        LodContent::Entities(entities) => &entities[..],
        _ => &[],
    });
    let finest = levels.next().unwrap_or_default();
    proxies.extend(levels.flatten().filter(|level| !finest.contains(level)));
}
