//! How many entities a camera sees, and how many it does not for which reason.

use bevy::ecs::entity::Entity;

use crate::culling::{VisibilityReason, VisibilityReasons};

/// How many entities are looked at in a frame, so that a large world costs no more than a small one.
const PER_FRAME: usize = 4096;

/// The reasons, in the order in which they are told.
pub(super) const REASONS: [(VisibilityReason, &str); 11] = [
    (VisibilityReason::Visible, "visible"),
    (VisibilityReason::OutsideFrustum, "outside of the view"),
    (VisibilityReason::Occluded, "behind something"),
    (VisibilityReason::OutOfRange, "out of range"),
    (VisibilityReason::OtherLevel, "another level of detail"),
    (VisibilityReason::Hidden, "hidden"),
    (VisibilityReason::OnOtherLayers, "on other layers"),
    (VisibilityReason::LeftToGpu, "left to the GPU"),
    (VisibilityReason::NotVisual, "nothing to be seen"),
    (VisibilityReason::InactiveCamera, "the camera is not active"),
    (VisibilityReason::NotYet, "changed since"),
];

/// A count that goes through all entities, some in each frame, over and over.
#[derive(Debug, Default)]
pub(super) struct Census {
    camera: Option<Entity>,
    left: Vec<Entity>,
    counting: [usize; REASONS.len()],
    /// The last count that was complete.
    counted: Option<[usize; REASONS.len()]>,
    /// Which reasons there have been.
    told: [bool; REASONS.len()],
}

impl Census {
    /// Goes on with the count for a camera, beginning anew with another camera and after all have been counted. A reason that
    /// was told once is told from then on, even of none: what stands below must not jump under the mouse.
    pub fn go_on(
        &mut self,
        camera: Entity,
        reasons: &VisibilityReasons,
        all: impl Iterator<Item = Entity>,
    ) -> Option<impl Iterator<Item = (&'static str, usize)>> {
        if self.camera != Some(camera) {
            *self = Self {
                camera: Some(camera),
                ..Self::default()
            };
        }
        if self.left.is_empty() {
            self.left.extend(all);
            self.counting = Default::default();
        }
        let rest = self.left.len().saturating_sub(PER_FRAME);
        for entity in self.left.drain(rest..) {
            let reason = reasons.of(entity, camera);
            if let Some(number) = REASONS.iter().position(|&(known, _)| Some(known) == reason) {
                self.counting[number] += 1;
            }
        }
        if self.left.is_empty() {
            self.counted = Some(self.counting);
            for (told, &count) in self.told.iter_mut().zip(&self.counting) {
                *told |= count > 0;
            }
        }
        let told = self.told;
        let counts = REASONS.iter().zip(self.counted?).zip(told);
        Some(counts.filter_map(|((&(_, name), count), told)| told.then_some((name, count))))
    }
}

/// What a reason means, and what can be done.
pub(super) fn advice(reason: VisibilityReason) -> &'static str {
    match reason {
        VisibilityReason::Visible => "It is in the list of this camera.",
        VisibilityReason::InactiveCamera => "The camera is not active: Camera::is_active.",
        VisibilityReason::NotVisual => "It lacks a GlobalTransform or a Visibility.",
        VisibilityReason::LeftToGpu => "It or the camera has NoCpuCulling: the GPU decides, and tells nobody.",
        VisibilityReason::Hidden => "Its Visibility, or that of an ancestor, is Hidden.",
        VisibilityReason::OnOtherLayers => "Its RenderLayers share none with those of the camera.",
        VisibilityReason::OutOfRange => "Its VisibilityRange does not reach to the camera, or begins beyond it.",
        VisibilityReason::OtherLevel => "Another level of its ProxyLod, or of a group around it, is shown.",
        VisibilityReason::OutsideFrustum => {
            "Its Aabb is outside of the frustum. If it should be seen: is the Aabb that of what is drawn? A shader that \
             moves vertices needs a larger one, or NoFrustumCulling."
        }
        VisibilityReason::Occluded => {
            "Its box is behind what occludes. If it should be seen: look at the occluders (Structures, what is drawn), \
             or give it NoOcclusionCulling."
        }
        VisibilityReason::NotYet => "It has changed since the lists were made; the next frame tells.",
    }
}
