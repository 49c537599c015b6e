//! Why a camera sees an entity, or does not: for tools.

use bevy::{
    camera::{
        Camera,
        primitives::{Aabb, Frustum, Sphere},
        visibility::{
            InheritedVisibility, NoCpuCulling, NoFrustumCulling, RenderLayers, ViewVisibility, VisibilityRange,
            VisibleEntities, VisibleEntityRanges,
        },
    },
    ecs::{
        change_detection::Res,
        entity::Entity,
        query::Has,
        system::{Query, SystemParam},
    },
    reflect::Reflect,
    transform::components::GlobalTransform,
};

use super::{
    ViewCullingSettings, VisibleSet,
    shape::{ViewKind, ViewShape},
};
use crate::{
    index::SpatialIndex,
    lod::LodChoices,
    occlusion::{NoOcclusionCulling, OcclusionBuffer},
};

/// Why a camera sees an entity, or does not. Of several reasons not to, the first in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Debug, Clone, PartialEq, Hash)]
#[non_exhaustive]
pub enum VisibilityReason {
    /// It is seen.
    Visible,
    /// The camera is not active, and sees nothing.
    InactiveCamera,
    /// It is left to the GPU, which tells nobody (`NoCpuCulling`).
    LeftToGpu,
    /// It has nothing that could be seen: no `GlobalTransform`, or no `Visibility`.
    NotVisual,
    /// It or an ancestor is hidden (`Visibility`).
    Hidden,
    /// It is on none of the layers of the camera (`RenderLayers`).
    OnOtherLayers,
    /// The camera is too near or too far for it (`VisibilityRange`).
    OutOfRange,
    /// Another level of detail is shown in its place ([`ProxyLod`](crate::lod::ProxyLod)).
    OtherLevel,
    /// It is outside of the view.
    OutsideFrustum,
    /// It is behind what [occludes](crate::occlusion).
    Occluded,
    /// Nothing speaks against it: it has changed since views were last culled.
    NotYet,
}

/// Tells why cameras see entities, or do not. Each answer tests anew: for tools, and not for all entities in every frame.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::culling::VisibilityReasons;
/// fn why_is_it_gone(selected: Single<Entity, With<Name>>, camera: Single<Entity, With<Camera>>, reasons: VisibilityReasons) {
///     println!("{:?}", reasons.of(*selected, *camera));
/// }
/// ```
#[derive(SystemParam)]
pub struct VisibilityReasons<'w, 's> {
    cameras: Query<
        'w,
        's,
        (
            &'static Camera,
            &'static Frustum,
            &'static VisibleSet,
            &'static VisibleEntities,
            Option<&'static RenderLayers>,
            Option<&'static OcclusionBuffer>,
        ),
    >,
    entities: Query<
        'w,
        's,
        (
            Option<&'static GlobalTransform>,
            Option<&'static InheritedVisibility>,
            Has<ViewVisibility>,
            Option<&'static RenderLayers>,
            Option<&'static Aabb>,
            Option<&'static Sphere>,
            Has<NoFrustumCulling>,
            Has<NoOcclusionCulling>,
            Has<NoCpuCulling>,
            Has<VisibilityRange>,
        ),
    >,
    ranges: Option<Res<'w, VisibleEntityRanges>>,
    lods: Option<Res<'w, LodChoices>>,
    index: Res<'w, SpatialIndex>,
    /// None where Bevy alone culls.
    settings: Option<Res<'w, ViewCullingSettings>>,
}

impl VisibilityReasons<'_, '_> {
    /// Why a camera sees an entity, or does not, as of the last `PostUpdate`; `None` if one of them does not exist, or the
    /// camera has no [`VisibleSet`], as without [`ViewCullingPlugin`](super::ViewCullingPlugin).
    pub fn of(&self, entity: Entity, camera: Entity) -> Option<VisibilityReason> {
        let (settings, frustum, seen, lists, camera_layers, occlusion) = self.cameras.get(camera).ok()?;
        let (
            place,
            inherited,
            has_mark,
            layers,
            aabb,
            sphere,
            is_never_culled,
            is_never_hidden,
            is_left_to_gpu,
            is_ranged,
        ) = self.entities.get(entity).ok()?;
        let is_culled_here = self.settings.as_deref().is_some_and(|settings| settings.enabled);
        let is_seen = if is_culled_here {
            seen.contains(entity)
        } else {
            lists.entities.values().any(|list| list.contains(&entity))
        };
        let is_occluded = || {
            let may_be = is_culled_here && !is_never_culled && !is_never_hidden;
            let hides =
                |occlusion: &OcclusionBuffer| self.index.aabb(entity).is_some_and(|aabb| occlusion.hides(&aabb));
            may_be && occlusion.is_some_and(hides)
        };
        let is_out_of_range = || {
            let ranges = self.ranges.as_deref();
            is_ranged && ranges.is_some_and(|ranges| !ranges.entity_is_in_range_of_view(entity, camera))
        };
        let is_outside = || {
            let shape = ViewShape::new(frustum, ViewKind::Camera);
            let sees = match (aabb, sphere, place) {
                (Some(aabb), _, Some(place)) => shape.sees(aabb, place),
                (None, Some(sphere), _) => shape.sees_sphere(sphere),
                _ => true,
            };
            !is_never_culled && !sees
        };
        let shares_layer = camera_layers.unwrap_or_default().intersects(layers.unwrap_or_default());
        Some(if !settings.is_active {
            VisibilityReason::InactiveCamera
        } else if is_left_to_gpu {
            VisibilityReason::LeftToGpu
        } else if is_seen {
            VisibilityReason::Visible
        } else if place.is_none() || inherited.is_none() || !has_mark {
            VisibilityReason::NotVisual
        } else if inherited.is_some_and(|inherited| !inherited.get()) {
            VisibilityReason::Hidden
        } else if entity != camera && !shares_layer {
            VisibilityReason::OnOtherLayers
        } else if is_out_of_range() {
            VisibilityReason::OutOfRange
        } else if self.lods.as_deref().is_some_and(|lods| !lods.shows(camera, entity)) {
            VisibilityReason::OtherLevel
        } else if is_outside() {
            VisibilityReason::OutsideFrustum
        } else if is_occluded() {
            VisibilityReason::Occluded
        } else {
            VisibilityReason::NotYet
        })
    }
}
