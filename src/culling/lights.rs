//! What the shadow maps of lights see.

use std::any::TypeId;

use bevy::{
    camera::{
        Camera, RenderTarget, ShadowLodOrigin,
        primitives::{CascadesFrusta, CubemapFrusta, Frustum, Sphere},
        visibility::{
            CascadesVisibleEntities, CubemapVisibleEntities, RenderLayers, ViewVisibility, VisibleEntities,
            VisibleEntityRanges, VisibleMeshEntities,
        },
    },
    ecs::{
        change_detection::{DetectChanges, Res, ResMut, Tick},
        entity::{Entity, EntityHashSet},
        query::{Or, With, Without},
        system::{Local, ParamSet, Query, SystemParam},
    },
    light::{DirectionalLight, PointLight, SpotLight, cluster::ClusterVisibilityClass, get_shadow_lod_origin},
    transform::components::GlobalTransform,
};

use super::{
    ViewCulling, ViewCullingStats, ViewKey,
    candidates::{Candidates, Record},
    marks::ViewVisibilities,
    shape::{ViewKind, ViewShape},
    sorted::amend,
    view::{Bounds, Change, Layers, Request, Sights, View, come, gone, look},
};
use crate::{
    index::SpatialIndex,
    lod::{LodChoices, LodView},
    phase::phase,
};

/// A shadow map that is drawn in this frame.
#[derive(Debug)]
pub(super) struct Shadow {
    key: ViewKey,
    request: Request,
    view: View,
    /// Whether its list is as it was left.
    is_untouched: bool,
}

/// The lights with what they see.
#[derive(SystemParam)]
pub(super) struct Lights<'w, 's> {
    directional: Query<
        'w,
        's,
        (
            Entity,
            &'static DirectionalLight,
            &'static CascadesFrusta,
            &'static mut CascadesVisibleEntities,
            Option<&'static RenderLayers>,
        ),
        Without<SpotLight>,
    >,
    point: Query<
        'w,
        's,
        (
            &'static PointLight,
            &'static GlobalTransform,
            &'static CubemapFrusta,
            &'static mut CubemapVisibleEntities,
            Option<&'static RenderLayers>,
        ),
    >,
    spot: Query<
        'w,
        's,
        (
            &'static SpotLight,
            &'static GlobalTransform,
            &'static Frustum,
            &'static mut VisibleMeshEntities,
            Option<&'static RenderLayers>,
        ),
    >,
}

/// What decides which light casts shadows, and from where the detail of what casts them is chosen.
#[derive(SystemParam)]
pub(super) struct LightViews<'w, 's> {
    cameras: Query<'w, 's, &'static VisibleEntities>,
    targets: Query<'w, 's, (Entity, &'static RenderTarget), With<Camera>>,
    origins: Query<'w, 's, Entity, With<ShadowLodOrigin>>,
    local: Query<'w, 's, Entity, Or<(With<PointLight>, With<SpotLight>)>>,
}

impl LightViews<'_, '_> {
    /// From where the detail is chosen of what point lights and spot lights see.
    pub fn lod_origin(&mut self) -> Option<Entity> {
        get_shadow_lod_origin(
            self.targets.transmute_lens_filtered(),
            self.origins.transmute_lens_filtered(),
            self.local.transmute_lens_filtered(),
        )
    }
}

/// Buffers, kept for their memory.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    shadows: Vec<Shadow>,
    checked: EntityHashSet,
    local: Vec<Entity>,
    lists: Lists,
}

/// Whether there are lights, or have just been.
pub(super) fn has_shadow_maps(
    lights: Query<(), Or<(With<CascadesFrusta>, With<CubemapFrusta>, With<SpotLight>)>>,
    culling: Res<ViewCulling>,
) -> bool {
    !lights.is_empty() || culling.views.keys().any(|key| !matches!(key, ViewKey::Camera(_)))
}

/// Finds what the shadow maps of lights see, and writes it to where Bevy has it.
pub(super) fn cull_lights(
    mut lights: Lights,
    mut light_views: LightViews,
    index: Res<SpatialIndex>,
    ranges: Option<Res<VisibleEntityRanges>>,
    lods: Option<Res<LodChoices>>,
    bounds: Bounds,
    layers: Layers,
    mut visibilities: ParamSet<(ViewVisibilities, Query<&ViewVisibility>)>,
    mut culling: ResMut<ViewCulling>,
    mut stats: ResMut<ViewCullingStats>,
    mut buffers: Local<Buffers>,
) {
    let phase = phase!("sightline/culling/lights");
    let ViewCulling {
        candidates,
        views,
        marks,
        turnover,
        index_is_current,
        ..
    } = &mut *culling;
    let buffers = &mut *buffers;
    let shadows = &mut buffers.shadows;
    let mut begin = |key: ViewKey, shape, layers: Option<&RenderLayers>, audience, range_origin, written: Tick| {
        let view = views.remove(&key).unwrap_or_default();
        shadows.push(Shadow {
            key,
            request: Request {
                viewer: key.viewer(),
                shape,
                layers: layers.unwrap_or_default().clone(),
                audience,
                sees_everywhere: false,
                range_origin,
                levels: range_origin.map(LodView::Shadows),
                // What is hidden from a camera still casts its shadow.
                viewpoint: None,
            },
            is_untouched: view.written == Some(written),
            view,
        });
    };

    let is_visible = visibilities.p1();
    for (light, settings, frusta, mut visible, layers) in &mut lights.directional {
        let written = visible.last_changed();
        visible.entities.retain(|camera, _| frusta.frusta.contains_key(camera));
        for (&camera, frusta) in &frusta.frusta {
            let cascades = visible.entities.entry(camera).or_default();
            cascades.resize_with(frusta.len(), VisibleMeshEntities::default);
        }
        let is_seen = is_visible.get(light).is_ok_and(|visibility| visibility.get());
        if !settings.shadow_maps_enabled || !is_seen {
            visible.entities.clear();
            continue;
        }
        for (&camera, frusta) in &frusta.frusta {
            for (number, frustum) in frusta.iter().enumerate() {
                let key = ViewKey::Cascade { light, camera, number };
                let shape = ViewShape::new(frustum, ViewKind::Cascade);
                begin(key, shape, layers, Record::FOR_CASCADES, Some(camera), written);
            }
        }
    }

    let lod_origin = light_views.lod_origin();
    buffers.checked.clear();
    buffers.local.clear();
    for visible in &light_views.cameras {
        let in_view = visible.get(TypeId::of::<ClusterVisibilityClass>()).iter();
        buffers
            .local
            .extend(in_view.filter(|&&light| buffers.checked.insert(light)));
    }
    for &light in &buffers.local {
        if let Ok((settings, place, frusta, visible, layers)) = lights.point.get_mut(light)
            && settings.shadow_maps_enabled
        {
            for (number, frustum) in frusta.iter().enumerate() {
                let shape = ViewShape::new(frustum, reach(place, settings.range));
                let key = ViewKey::CubeFace { light, number };
                begin(
                    key,
                    shape,
                    layers,
                    Record::FOR_LOCAL_LIGHTS,
                    lod_origin,
                    visible.last_changed(),
                );
            }
        }
        if let Ok((settings, place, frustum, visible, layers)) = lights.spot.get_mut(light)
            && settings.shadow_maps_enabled
        {
            let shape = ViewShape::new(frustum, reach(place, settings.range));
            let key = ViewKey::SpotLight(light);
            begin(
                key,
                shape,
                layers,
                Record::FOR_LOCAL_LIGHTS,
                lod_origin,
                visible.last_changed(),
            );
        }
    }

    let sights = Sights {
        index: &index,
        index_is_current: *index_is_current,
        has_changed: index.is_changed() || !candidates.changed.is_empty(),
        candidates,
        bounds: &bounds,
        layers: &layers,
        occluders: None,
        lods: lods.as_deref(),
    };
    let mut pairs: Vec<_> = shadows
        .iter_mut()
        .map(|shadow| (&shadow.request, &mut shadow.view))
        .collect();
    look(&mut pairs, sights, |request, entity| {
        let Some(ranges) = ranges.as_deref() else {
            return Some(true);
        };
        let sees = |origin| ranges.entity_is_in_range_of_view(entity, origin);
        Some(request.range_origin.is_some_and(sees))
    });

    // Whoever is no camera and has not looked is a light that does not any more.
    views.retain(|key, view| {
        let is_camera = matches!(key, ViewKey::Camera(_));
        if !is_camera {
            turnover.drop_view(view, Record::FOR_CASCADES, candidates);
        }
        is_camera
    });
    stats.shadow_maps = shadows.len();
    for mut shadow in shadows.drain(..) {
        stats.tested += shadow.view.tested();
        stats.casters += shadow.view.seen_len();
        turnover.count(&mut shadow.view, shadow.request.audience, candidates);
        shadow.view.changes.sort_unstable_by_key(|change| change.entity);
        match shadow.key {
            ViewKey::Camera(_) => {}
            ViewKey::Cascade { light, camera, number } => {
                if let Ok((.., mut visible, _)) = lights.directional.get_mut(light)
                    && let Some(list) = visible
                        .entities
                        .get_mut(&camera)
                        .and_then(|lists| lists.get_mut(number))
                {
                    buffers.lists.write(&mut shadow, candidates, list);
                    shadow.view.written = Some(visible.last_changed());
                }
            }
            ViewKey::CubeFace { light, number } => {
                if let Ok((.., mut visible, _)) = lights.point.get_mut(light) {
                    buffers.lists.write(&mut shadow, candidates, visible.get_mut(number));
                    shadow.view.written = Some(visible.last_changed());
                }
            }
            ViewKey::SpotLight(light) => {
                if let Ok((.., mut visible, _)) = lights.spot.get_mut(light) {
                    buffers.lists.write(&mut shadow, candidates, &mut visible);
                    shadow.view.written = Some(visible.last_changed());
                }
            }
        }
        views.insert(shadow.key, shadow.view);
    }
    let mut visibilities = visibilities.p0();
    marks.mark_shadows(turnover.lost.drain(..), candidates, &mut visibilities);
    let appeared = turnover.appeared.drain(..);
    marks.mark(appeared, Record::FOR_CASCADES, candidates, &mut visibilities);
    stats.lights = phase.end();
}

/// How Bevy tests for the map of a light that reaches so far.
fn reach(place: &GlobalTransform, range: f32) -> ViewKind {
    ViewKind::Local(Sphere {
        center: place.translation_vec3a(),
        radius: range,
    })
}

/// Buffers for the lists of lights, kept for their memory.
#[derive(Debug, Default)]
struct Lists {
    changes: Vec<Change>,
    buffer: Vec<Entity>,
}

impl Lists {
    /// Brings the list of a shadow map up to date, in ascending order.
    fn write(&mut self, shadow: &mut Shadow, candidates: &Candidates, list: &mut VisibleMeshEntities) {
        let list = &mut list.entities;
        // Whoever has touched the list has spoilt it.
        let all = if shadow.is_untouched {
            &shadow.view.changes
        } else {
            list.clear();
            shadow.view.list_all(candidates, &mut self.changes);
            &self.changes
        };
        amend(list, gone(all), come(all), &mut self.buffer);
    }
}
