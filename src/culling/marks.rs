//! Writing [`ViewVisibility`] as Bevy does, but only where it changes.
//!
//! Bevy sets every `ViewVisibility` back to *was visible* or *hidden* before views are asked, each view marks what it
//! sees, and what was visible and is not marked is hidden at last: so that a change is one only if it lasts. Here
//! nothing is set back but what no view sees any more, which is before [`CheckVisibility`] as far as cameras go:
//! whoever marks entities of their own there finds them as Bevy leaves them.
//!
//! [`CheckVisibility`]: bevy::camera::visibility::VisibilitySystems::CheckVisibility

use bevy::{
    camera::visibility::{NoCpuCulling, SetViewVisibility, ViewVisibility},
    ecs::{change_detection::DetectChangesMut, entity::Entity, query::Without, system::Query},
    reflect::tuple_struct::TupleStruct,
};

use super::{
    bits::Bits,
    candidates::{Candidates, Record},
    view::View,
};

/// What Bevy would mark.
pub(super) type ViewVisibilities<'w, 's> = Query<'w, 's, (Entity, &'static mut ViewVisibility), Without<NoCpuCulling>>;

/// To look up an entity takes as long as to pass by so many.
const LOOK_UP: usize = 16;

/// What is known of the marks.
#[derive(Debug)]
pub(super) struct Marks {
    /// Who is marked as visible.
    lit: Bits,
    /// Whether anything is known.
    is_known: bool,
    /// Those of whom this frame will know that they were visible before, and the last did not.
    fresh: Vec<Entity>,
    /// Those who were set back in this frame.
    set_back: Vec<Entity>,
    /// Those who were marked by others.
    foreign: Vec<Entity>,
    /// Those whom views see, and somebody has unmarked.
    unmarked: Vec<Entity>,
    was_visible: ViewVisibility,
}

impl Default for Marks {
    fn default() -> Self {
        Self {
            lit: Bits::default(),
            is_known: false,
            fresh: Vec::new(),
            set_back: Vec::new(),
            foreign: Vec::new(),
            unmarked: Vec::new(),
            was_visible: was_visible(),
        }
    }
}

/// What Bevy has a `ViewVisibility` be of what was visible, and has not been marked yet: the second of its two bits.
pub(super) fn was_visible() -> ViewVisibility {
    let mut visibility = ViewVisibility::HIDDEN;
    if let Some(bits) = visibility.field_mut(0).and_then(|bits| bits.try_downcast_mut::<u8>()) {
        *bits = 0b10;
    }
    debug_assert!(visibility != ViewVisibility::HIDDEN && !visibility.get());
    visibility
}

/// How cameras, or shadow maps, have come to see entities, and ceased to.
#[derive(Debug, Default)]
pub(super) struct Turnover {
    /// Whom one sees that none saw.
    pub appeared: Vec<Entity>,
    /// Whom none sees any more.
    pub lost: Vec<Entity>,
}

impl Turnover {
    /// Counts what a view has begun and ceased to see.
    pub fn count(&mut self, view: &mut View, audience: u16, candidates: &mut Candidates) {
        for change in &view.changes[std::mem::replace(&mut view.counted, view.changes.len())..] {
            if change.has_come() {
                self.come(change.entity, audience, candidates);
            } else if change.has_gone() {
                self.go(change.entity, audience, candidates);
            }
        }
    }

    /// Counts that a view is no more.
    pub fn drop_view(&mut self, view: &View, audience: u16, candidates: &mut Candidates) {
        for number in view.seen.iter() {
            self.go(candidates.record(number).entity, audience, candidates);
        }
    }

    fn come(&mut self, entity: Entity, audience: u16, candidates: &mut Candidates) {
        if candidates.count(entity, audience, true) == Some(1) {
            self.appeared.push(entity);
        }
    }

    fn go(&mut self, entity: Entity, audience: u16, candidates: &mut Candidates) {
        if candidates.count(entity, audience, false) == Some(0) {
            self.lost.push(entity);
        }
    }
}

impl Marks {
    /// Everything is to be found out anew.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Begins a frame: brings what is known up to date with what others have done. `gone` are no candidates any more,
    /// or have lost their marks; the marks of `changed` have changed since the last frame.
    pub fn begin_frame(
        &mut self,
        gone: impl Iterator<Item = Entity>,
        changed: impl Iterator<Item = Entity>,
        candidates: &Candidates,
        visibilities: &mut ViewVisibilities,
    ) {
        for entity in self.fresh.drain(..) {
            if let Ok((_, mut visibility)) = visibilities.get_mut(entity)
                && visibility.get()
            {
                *visibility.bypass_change_detection() = ViewVisibility::VISIBLE;
            }
        }
        for entity in gone {
            self.lit.remove(entity.index_u32());
            self.set_back(entity, visibilities);
        }
        if self.is_known {
            for entity in changed {
                if let Ok((_, visibility)) = visibilities.get(entity) {
                    self.look_at(entity, visibility.get(), candidates);
                }
            }
        } else {
            self.is_known = true;
            for (entity, visibility) in &*visibilities {
                self.look_at(entity, visibility.get(), candidates);
            }
        }
        let mut foreign = std::mem::take(&mut self.foreign);
        for entity in foreign.drain(..) {
            self.set_back(entity, visibilities);
        }
        self.foreign = foreign;
    }

    /// Finds out who has been marked or unmarked by others.
    fn look_at(&mut self, entity: Entity, is_marked: bool, candidates: &Candidates) {
        let number = entity.index_u32();
        if is_marked {
            if self.lit.insert(number) {
                self.foreign.push(entity);
            }
        } else {
            self.lit.remove(number);
            if is_seen(entity, candidates) {
                self.unmarked.push(entity);
            }
        }
    }

    /// Sets an entity back that no view sees, or of which it is to be decided anew. Not yet a change.
    pub fn set_back(&mut self, entity: Entity, visibilities: &mut ViewVisibilities) {
        if let Ok((_, mut visibility)) = visibilities.get_mut(entity)
            && visibility.get()
        {
            *visibility.bypass_change_detection() = self.was_visible;
            self.set_back.push(entity);
        }
    }

    /// Sets back what shadow maps saw in the last frame and cameras do not see in this one.
    pub fn set_back_shadows(&mut self, candidates: &Candidates, visibilities: &mut ViewVisibilities) {
        let was_visible = self.was_visible;
        let shadows = candidates.in_shadow_maps();
        let set_back = |number: u32, visibility: &mut ViewVisibility| {
            if visibility.get() && shadows.contains(number) && !candidates.is_seen_by_cameras(number) {
                *visibility = was_visible;
            }
        };
        for_each_shadow(candidates, visibilities, set_back);
    }

    /// Marks what shadow maps see still; `lost` is what none of them sees any more.
    pub fn mark_shadows(
        &mut self,
        lost: impl Iterator<Item = Entity>,
        candidates: &Candidates,
        visibilities: &mut ViewVisibilities,
    ) {
        let was_visible = self.was_visible;
        let shadows = candidates.in_shadow_maps();
        let mark = |number: u32, visibility: &mut ViewVisibility| {
            if *visibility == was_visible && shadows.contains(number) {
                *visibility = ViewVisibility::VISIBLE;
            }
        };
        for_each_shadow(candidates, visibilities, mark);
        // What cameras see is marked; what has been set back, and marked by others since, is theirs.
        self.set_back
            .extend(lost.filter(|lost| !candidates.is_seen_by_cameras(lost.index_u32())));
    }

    /// Marks what cameras, or then shadow maps, have begun to see, and of what was set back what they see still.
    pub fn mark(
        &mut self,
        appeared: impl Iterator<Item = Entity>,
        audience: u16,
        candidates: &Candidates,
        visibilities: &mut ViewVisibilities,
    ) {
        let sees = |entity: Entity| candidates.is_seen_by(audience, entity);
        for entity in appeared.filter(|&entity| sees(entity)) {
            mark_one(entity, visibilities, &mut self.lit, &mut self.fresh);
        }
        // To mark twice does no harm.
        for list in [&self.unmarked, &self.set_back] {
            for &entity in list.iter().filter(|&&entity| sees(entity)) {
                mark_one(entity, visibilities, &mut self.lit, &mut self.fresh);
            }
        }
    }

    /// Whether [`hide_unseen`](Self::hide_unseen) has anything to do.
    pub fn has_set_back(&self) -> bool {
        !(self.set_back.is_empty() && self.unmarked.is_empty())
    }

    /// Ends a frame: hides what was visible and is not marked.
    pub fn hide_unseen(&mut self, candidates: &Candidates, visibilities: &mut ViewVisibilities) {
        self.unmarked.clear();
        for entity in self.set_back.drain(..) {
            let Ok((_, mut visibility)) = visibilities.get_mut(entity) else {
                continue;
            };
            if visibility.get() {
                if !is_seen(entity, candidates) {
                    self.foreign.push(entity);
                }
                self.lit.insert(entity.index_u32());
            } else if *visibility == self.was_visible {
                *visibility = ViewVisibility::HIDDEN;
                self.lit.remove(entity.index_u32());
            }
        }
    }
}

/// Marks an entity, and notes that it is marked, and perhaps newly.
fn mark_one(entity: Entity, visibilities: &mut ViewVisibilities, lit: &mut Bits, fresh: &mut Vec<Entity>) {
    if let Ok((_, mut visibility)) = visibilities.get_mut(entity) {
        visibility.set_visible();
        // Others may have marked it in this frame.
        if *visibility != ViewVisibility::VISIBLE {
            fresh.push(entity);
        }
        lit.insert(entity.index_u32());
    }
}

/// Whether any view sees an entity.
fn is_seen(entity: Entity, candidates: &Candidates) -> bool {
    let audiences = [Record::FOR_CAMERAS, Record::FOR_CASCADES];
    audiences
        .into_iter()
        .any(|audience| candidates.is_seen_by(audience, entity))
}

/// Does something silently with every entity that is seen in a shadow map, and perhaps with others.
fn for_each_shadow(
    candidates: &Candidates,
    visibilities: &mut ViewVisibilities,
    mut act: impl FnMut(u32, &mut ViewVisibility),
) {
    let is_worth_a_sweep = candidates.shadow_map_len() * LOOK_UP > candidates.len();
    if is_worth_a_sweep && let Ok(tables) = visibilities.contiguous_iter_mut() {
        for (entities, mut column) in tables {
            let column = column.bypass_change_detection();
            for (entity, visibility) in entities.iter().zip(column) {
                act(entity.index_u32(), visibility);
            }
        }
        return;
    }
    for number in candidates.in_shadow_maps().iter() {
        if let Ok((_, mut visibility)) = visibilities.get_mut(candidates.record(number).entity) {
            act(number, visibility.bypass_change_detection());
        }
    }
}
