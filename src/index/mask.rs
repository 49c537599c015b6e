//! The masks by which queries pass over whole subtrees.
//!
//! A leaf has one bit for each of its render layers, among the first if it is visible and among the next if it is
//! hidden. The layers from [`OVERFLOW`] on share a bit, so that a mask only ever admits too much: what it admits is
//! checked against the layers themselves. What only views look for has [one bit](STAND_IN), whatever its layers.

use bevy::camera::visibility::RenderLayers;

use super::{DetailLevel, QueryVisibility, SceneQuerySettings};

/// The bit of all layers for which there is no bit, and of what is on no layer: that is found where no layer is asked for.
const OVERFLOW: u32 = 14;
/// The bits of all layers.
const EVERY_LAYER: u32 = (1 << (OVERFLOW + 1)) - 1;

/// The bit of visible stand-ins for finer levels, which no query finds.
const STAND_IN: u32 = 1 << 31;

/// The mask of an entity.
pub(super) fn of_entity(layers: &RenderLayers, visible: bool, level: Option<DetailLevel>) -> u32 {
    if level == Some(DetailLevel::Coarser) {
        return if visible { STAND_IN } else { 0 };
    }
    let layers = of_layers(layers);
    if visible { layers } else { hidden(layers) }
}

/// The mask of everything that settings may accept.
pub(super) fn of_settings(settings: &SceneQuerySettings) -> u32 {
    let layers = settings.layers.map_or(EVERY_LAYER, of_layers);
    match settings.visibility {
        QueryVisibility::Any => layers | hidden(layers),
        QueryVisibility::Visible | QueryVisibility::VisibleInView => layers,
    }
}

/// The mask of everything that a view of these layers may see.
pub(crate) fn of_view(layers: &RenderLayers) -> u32 {
    of_layers(layers) | STAND_IN
}

/// The mask of what is visible on one of these layers.
fn of_layers(layers: &RenderLayers) -> u32 {
    let (first, others) = layers.bits().split_first().unwrap_or((&0, &[]));
    let own = *first as u32 & (EVERY_LAYER >> 1);
    let has_others = first >> OVERFLOW != 0 || others.iter().any(|&block| block != 0);
    own | u32::from(own == 0 || has_others) << OVERFLOW
}

fn hidden(layers: u32) -> u32 {
    layers << (OVERFLOW + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_layers() -> Vec<RenderLayers> {
        let mut all: Vec<_> = [0, 1, 13, 14, 15, 16, 31, 32, 63, 64, 200]
            .map(|layer| RenderLayers::from_layers(&[layer]))
            .into();
        all.extend([
            RenderLayers::none(),
            RenderLayers::from_layers(&[0, 13]),
            RenderLayers::from_layers(&[3, 77]),
        ]);
        all
    }

    #[test]
    fn whatever_settings_accept_their_mask_admits() {
        for entity in all_layers() {
            for visible in [true, false] {
                let mask = of_entity(&entity, visible, None);
                for visibility in [QueryVisibility::Any, QueryVisibility::Visible] {
                    let sees = visible || visibility == QueryVisibility::Any;
                    let settings = SceneQuerySettings::default().with_visibility(visibility);
                    assert_eq!(of_settings(&settings) & mask != 0, sees, "{entity:?}");
                    for layers in all_layers() {
                        let admits = of_settings(&settings.with_layers(&layers)) & mask != 0;
                        assert!(
                            admits || !sees || !layers.intersects(&entity),
                            "{entity:?} in {layers:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn layers_with_bits_of_their_own_are_told_apart() {
        let (ground, sky) = (RenderLayers::layer(0), RenderLayers::layer(13));
        let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::Any);
        assert_eq!(
            of_settings(&settings.with_layers(&sky)) & of_entity(&ground, true, None),
            0
        );
    }

    #[test]
    fn coarser_levels_are_found_by_views_alone() {
        for layers in all_layers() {
            let mask = of_entity(&layers, true, Some(DetailLevel::Coarser));
            let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::Any);
            assert_eq!(of_settings(&settings) & mask, 0);
            assert_ne!(of_view(&layers) & mask, 0);
        }
    }
}
