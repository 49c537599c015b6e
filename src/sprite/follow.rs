//! The system that keeps the surfaces of sprites in step with the world.

use std::sync::Arc;

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    ecs::{
        change_detection::{DetectChanges, Res, ResMut},
        entity::{Entity, EntityHashMap, EntityHashSet},
        entity_disabling::Disabled,
        lifecycle::RemovedComponents,
        message::MessageReader,
        name::NameOrEntity,
        query::{Changed, Or, QueryData, With},
        resource::Resource,
        system::{Commands, Local, Query, SystemParam},
    },
    image::{Image, TextureAtlasLayout},
    platform::collections::{HashMap, HashSet},
    sprite::{Anchor, Sprite},
};
use smallvec::SmallVec;
use tracing::warn;

use super::{
    AlphaTest, SpriteIndexSettings, SpriteIndexStats, layout::SpriteLayout, mask::AlphaMask, surface::SpriteSurface,
};
use crate::{
    geometry::surface::Surface,
    index::{DerivedShape, PickShape},
    phase::phase,
};

/// Which pixels can be hit, of all images that sprites use.
///
/// Not reflected, for all of it is made of components and assets.
#[derive(Resource, Debug, Default)]
pub struct SpriteMasks {
    images: HashMap<AssetId<Image>, ImageMasks>,
    layouts: HashMap<AssetId<TextureAtlasLayout>, EntityHashSet>,
    sprites: EntityHashMap<KnownSprite>,
    /// The images that the user has been told of.
    warned: HashSet<AssetId<Image>>,
}

/// One image.
#[derive(Debug, Default)]
struct ImageMasks {
    users: EntityHashSet,
    /// By the bits of the threshold: `None` if there are no holes.
    masks: SmallVec<[(u32, Option<Arc<AlphaMask>>); 1]>,
}

/// What a sprite was when its surface was made.
#[derive(Debug)]
struct KnownSprite {
    image: AssetId<Image>,
    layout: Option<AssetId<TextureAtlasLayout>>,
    surface: Option<Arc<SpriteSurface>>,
}

/// Everything that the surface of a sprite depends on, but for assets.
#[derive(QueryData)]
pub(super) struct Drawn {
    name: NameOrEntity,
    sprite: &'static Sprite,
    anchor: &'static Anchor,
    alpha_test: Option<&'static AlphaTest>,
}

/// The sprites that have changed.
#[derive(SystemParam)]
pub(super) struct Changes<'w, 's> {
    all: Query<'w, 's, Entity, With<Sprite>>,
    changed: Query<'w, 's, Entity, (With<Sprite>, Or<(Changed<Sprite>, Changed<Anchor>, Changed<AlphaTest>)>)>,
    removed_sprites: RemovedComponents<'w, 's, Sprite>,
    removed_anchors: RemovedComponents<'w, 's, Anchor>,
    removed_tests: RemovedComponents<'w, 's, AlphaTest>,
    enabled: RemovedComponents<'w, 's, Disabled>,
    images: MessageReader<'w, 's, AssetEvent<Image>>,
    layouts: MessageReader<'w, 's, AssetEvent<TextureAtlasLayout>>,
    settings: Res<'w, SpriteIndexSettings>,
}

impl Changes<'_, '_> {
    /// Writes those sprites, and what no longer is one, over `dirty`. Forgets the masks of images that have changed.
    fn find(&mut self, masks: &mut SpriteMasks, dirty: &mut Vec<Entity>) {
        dirty.clear();
        for id in self.images.read().filter_map(changed_asset) {
            dirty.extend(masks.forget_image(id));
        }
        for id in self.layouts.read().filter_map(changed_asset) {
            dirty.extend(masks.layouts.get(&id).into_iter().flatten());
        }
        dirty.extend(self.removed_sprites.read());
        dirty.extend(self.removed_anchors.read());
        dirty.extend(self.removed_tests.read());
        dirty.extend(self.enabled.read());
        if self.settings.is_changed() {
            dirty.extend(&self.all);
        } else {
            dirty.extend(&self.changed);
        }
        // One entity may be in several lists.
        dirty.sort_unstable();
        dirty.dedup();
    }
}

fn changed_asset<A: bevy::asset::Asset>(event: &AssetEvent<A>) -> Option<AssetId<A>> {
    match *event {
        AssetEvent::Added { id }
        | AssetEvent::Modified { id }
        | AssetEvent::Removed { id }
        | AssetEvent::Unused { id } => Some(id),
        AssetEvent::LoadedWithDependencies { .. } => None,
    }
}

/// Gives every sprite that has changed in any way that matters its surface, and takes it from what no longer is one.
pub(super) fn follow_sprites(
    mut commands: Commands,
    mut changes: Changes,
    drawn: Query<Drawn>,
    mut shapes: Query<&mut DerivedShape>,
    images: Res<Assets<Image>>,
    layouts: Res<Assets<TextureAtlasLayout>>,
    mut masks: ResMut<SpriteMasks>,
    mut stats: ResMut<SpriteIndexStats>,
    mut dirty: Local<Vec<Entity>>,
) {
    let phase = phase!("sightline/sprite/follow");
    changes.find(&mut masks, &mut dirty);
    let reconciled = dirty.len();
    let mut new = Vec::new();
    for entity in dirty.drain(..) {
        let item = drawn.get(entity).ok();
        let surface = match &item {
            Some(item) => {
                masks.watch(entity, item.sprite);
                masks.surface(item, &changes.settings, &images, &layouts)
            }
            None => {
                masks.forget_sprite(entity);
                None
            }
        };
        match (surface, shapes.get_mut(entity)) {
            (None, Err(_)) => {}
            (None, Ok(_)) => {
                masks.set_surface(entity, None);
                commands.entity(entity).try_remove::<DerivedShape>();
            }
            // A sprite that has only changed its colour.
            (Some(surface), Ok(_)) if masks.has_surface(entity, &surface) => {}
            (Some(surface), shape) => {
                let surface = Arc::new(surface);
                masks.set_surface(entity, Some(surface.clone()));
                let derived = DerivedShape(PickShape::from(surface as Arc<dyn Surface>));
                match shape {
                    Ok(mut shape) => *shape = derived,
                    Err(_) => new.push((entity, derived)),
                }
            }
        }
    }
    if !new.is_empty() {
        commands.try_insert_batch(new);
    }
    *stats = SpriteIndexStats {
        sprites: masks.sprites.len(),
        reconciled,
        follow: phase.end(),
    };
}

impl SpriteMasks {
    /// The bytes that the masks take.
    pub fn memory(&self) -> usize {
        let masks = self.images.values().flat_map(|image| &image.masks);
        masks
            .filter_map(|(_, mask)| mask.as_deref())
            .map(AlphaMask::memory)
            .sum()
    }

    /// The surface of a sprite, or `None` if it has no size.
    fn surface(
        &mut self,
        item: &DrawnItem,
        settings: &SpriteIndexSettings,
        images: &Assets<Image>,
        layouts: &Assets<TextureAtlasLayout>,
    ) -> Option<SpriteSurface> {
        let sprite = item.sprite;
        let image = images.get(&sprite.image);
        let atlas = sprite
            .texture_atlas
            .as_ref()
            .and_then(|atlas| layouts.get(&atlas.layout));
        let layout = SpriteLayout::new(sprite, item.anchor, image.map(Image::size_f32), atlas)?;
        let mask = match *item.alpha_test.unwrap_or(&settings.alpha_test) {
            AlphaTest::Off => None,
            AlphaTest::Above(threshold) => image.and_then(|image| self.mask(image, threshold, item)),
        };
        Some(SpriteSurface { layout, mask })
    }

    /// The mask of the image of a sprite, made now if there is none yet; `None` if it has no holes.
    fn mask(&mut self, image: &Image, threshold: f32, item: &DrawnItem) -> Option<Arc<AlphaMask>> {
        let id = item.sprite.image.id();
        let of_image = self.images.entry(id).or_default();
        let known = of_image.masks.iter().find(|(bits, _)| *bits == threshold.to_bits());
        if let Some((_, mask)) = known {
            return mask.clone();
        }
        let mask = AlphaMask::new(image, threshold).unwrap_or_else(|why| {
            if self.warned.insert(id) {
                let (name, entity) = (&item.name, item.name.entity);
                warn!("image {id} (used by {name}, {entity}) counts as opaque, for its pixels cannot be read: {why}");
            }
            None
        });
        let mask = mask.map(Arc::new);
        // What no sprite uses any more goes when there is something new.
        let is_used = |mask: &Option<Arc<AlphaMask>>| mask.as_ref().is_none_or(|mask| Arc::strong_count(mask) > 1);
        of_image.masks.retain(|(_, mask)| is_used(mask));
        of_image.masks.push((threshold.to_bits(), mask.clone()));
        mask
    }

    /// Has a sprite looked at again when its assets change.
    fn watch(&mut self, entity: Entity, sprite: &Sprite) {
        let image = sprite.image.id();
        let layout = sprite.texture_atlas.as_ref().map(|atlas| atlas.layout.id());
        let known = self.sprites.get(&entity);
        if known.is_some_and(|known| (known.image, known.layout) == (image, layout)) {
            return;
        }
        self.forget_sprite(entity);
        self.images.entry(image).or_default().users.insert(entity);
        if let Some(layout) = layout {
            self.layouts.entry(layout).or_default().insert(entity);
        }
        let surface = None;
        self.sprites.insert(entity, KnownSprite { image, layout, surface });
    }

    fn forget_sprite(&mut self, entity: Entity) {
        let Some(known) = self.sprites.remove(&entity) else {
            return;
        };
        if let Some(image) = self.images.get_mut(&known.image) {
            image.users.remove(&entity);
            if image.users.is_empty() {
                self.images.remove(&known.image);
            }
        }
        if let Some((layout, users)) = known.layout.and_then(|id| Some((id, self.layouts.get_mut(&id)?))) {
            users.remove(&entity);
            if users.is_empty() {
                self.layouts.remove(&layout);
            }
        }
    }

    /// Forgets what an image was, and returns the sprites that use it.
    fn forget_image(&mut self, id: AssetId<Image>) -> impl Iterator<Item = Entity> + '_ {
        let image = self.images.get_mut(&id);
        let users = image.map(|image| {
            image.masks.clear();
            &image.users
        });
        users.into_iter().flatten().copied()
    }

    fn has_surface(&self, entity: Entity, surface: &SpriteSurface) -> bool {
        let known = self.sprites.get(&entity).and_then(|known| known.surface.as_deref());
        known.is_some_and(|known| known == surface)
    }

    fn set_surface(&mut self, entity: Entity, surface: Option<Arc<SpriteSurface>>) {
        if let Some(known) = self.sprites.get_mut(&entity) {
            known.surface = surface;
        }
    }
}
