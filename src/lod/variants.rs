//! Other components that are swapped with meshes, such as materials.

use std::marker::PhantomData;

use bevy::{
    app::{App, Plugin, PostUpdate},
    camera::visibility::VisibilitySystems,
    ecs::{
        change_detection::Res,
        component::Component,
        entity::Entity,
        observer::On,
        query::{Changed, Or},
        reflect::ReflectComponent,
        schedule::IntoScheduleConfigs,
        system::{Commands, Query},
    },
    reflect::Reflect,
};

use super::{LodChoices, LodSwapped, LodSystems, ProxyLod, ProxyLodPlugin};

/// What an entity has as its `C` by the level that it shows, beside a [`ProxyLod`] whose meshes are swapped: for level after
/// level, of which those that are not listed have the last. Needs the [`LevelVariantsPlugin`] of the same type.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::prelude::*;
/// # fn add(app: &mut App) {
/// app.add_plugins(LevelVariantsPlugin::<MeshMaterial3d<StandardMaterial>>::default());
/// # }
/// # fn spawn(mut commands: Commands, [near, far]: [Handle<Mesh>; 2], [bark, leaves]: [Handle<StandardMaterial>; 2]) {
/// commands.spawn((
///     ProxyLod::new(LodMetric::Height, near).then(0.1, far),
///     LevelVariants(vec![MeshMaterial3d(bark), MeshMaterial3d(leaves)]),
/// ));
/// # }
/// ```
///
/// For scenes and tools, register it with your type: `app.register_type::<LevelVariants<MyMaterial>>()`.
#[derive(Component, Clone, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone)]
pub struct LevelVariants<C: Component + Clone>(pub Vec<C>);

/// Gives entities with [`LevelVariants`] those of the level that they show. Adds [`ProxyLodPlugin`] by itself.
#[derive(Clone, Copy, Debug)]
pub struct LevelVariantsPlugin<C>(PhantomData<C>);

impl<C> Default for LevelVariantsPlugin<C> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<C: Component + Clone> Plugin for LevelVariantsPlugin<C> {
    fn build(&self, app: &mut App) {
        app.add_plugins(ProxyLodPlugin)
            .add_observer(swap_variant::<C>)
            .add_systems(
                PostUpdate,
                begin_with_variants::<C>
                    .after(LodSystems::Choose)
                    .before(VisibilitySystems::CheckVisibility),
            );
    }
}

fn swap_variant<C: Component + Clone>(
    swapped: On<LodSwapped>,
    lods: Option<Res<LodChoices>>,
    variants: Query<&LevelVariants<C>>,
    mut commands: Commands,
) {
    if lods.is_some_and(|lods| lods.swapped_level(swapped.entity).is_some())
        && let Ok(variants) = variants.get(swapped.entity)
    {
        give(swapped.entity, variants, swapped.to, &mut commands);
    }
}

/// Those that are new show some level already.
fn begin_with_variants<C: Component + Clone>(
    lods: Option<Res<LodChoices>>,
    changed: Query<(Entity, &LevelVariants<C>), Or<(Changed<LevelVariants<C>>, Changed<ProxyLod>)>>,
    mut commands: Commands,
) {
    for (entity, variants) in &changed {
        if let Some(level) = lods.as_ref().and_then(|lods| lods.swapped_level(entity)) {
            give(entity, variants, level, &mut commands);
        }
    }
}

fn give<C: Component + Clone>(entity: Entity, variants: &LevelVariants<C>, level: usize, commands: &mut Commands) {
    if let Some(variant) = variants.0.get(level).or(variants.0.last()) {
        commands.entity(entity).try_insert(variant.clone());
    }
}
