//! What every view shows, to be asked.

use bevy::{
    camera::primitives::Aabb,
    ecs::{entity::Entity, resource::Resource},
    platform::collections::HashMap,
};

use super::{groups::Groups, lens::MAX_LEVELS, place::Pending, view_levels::ViewLevels};

/// Which levels are shown, in every view, as of the last [`LodSystems::Choose`](super::LodSystems::Choose).
///
/// Not reflected, for all of it is found anew where a scene is loaded.
#[derive(Resource, Debug, Default)]
pub struct LodChoices {
    pub(super) groups: Groups,
    pub(super) views: HashMap<LodView, ViewLevels>,
    /// Of all other views: the finest levels.
    pub(super) others: ViewLevels,
    /// The camera for which meshes are swapped.
    pub(super) main: Option<Entity>,
    /// What belongs to other levels than before, or to some and not before, or not any more.
    pub(super) reassigned: Vec<Entity>,
    pub(super) pending: Pending,
    /// The roots that have other children than before: what hangs elsewhere moves by itself.
    pub(super) other_children: Vec<Entity>,
    /// Whether shadow maps are as cameras are.
    pub(super) shadows_follow_cameras: bool,
    /// New whenever the levels that are loaded when they come near may have changed.
    pub(super) streaming_changes: u64,
    /// The last version that was given to a view.
    pub(super) versions: u64,
}

/// Who looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum LodView {
    Camera(Entity),
    /// Shadow maps whose levels are chosen from the place of a camera, or of something else.
    Shadows(Entity),
}

impl LodChoices {
    /// The level that a camera shows of a group, from zero for the finest. `group` is the root. `None` if it is none, or
    /// the camera is not active. Of a group whose meshes are swapped, all cameras show what the
    /// [main camera](super::LodSettings::main_camera) does. The group may be hidden as a whole, by a coarser level of a
    /// group that it is in: see [`shown_level`](Self::shown_level).
    pub fn level(&self, group: Entity, view: Entity) -> Option<usize> {
        let id = self.groups.of_root(group)?;
        let camera = self.views.get(&LodView::Camera(view))?;
        let levels = if self.groups.is_swapped(id) {
            self.main_levels()?
        } else {
            camera
        };
        Some(usize::from(levels.level(id)))
    }

    /// The same if the group is shown at all: `None` where a coarser level of a group that it is in stands in for it.
    pub fn shown_level(&self, group: Entity, view: Entity) -> Option<usize> {
        let levels = self.levels_of(LodView::Camera(view));
        let id = self.groups.of_root(group)?;
        let is_shown = self.groups.shows_group(Some(levels), self.main_levels(), id);
        self.level(group, view).filter(|_| is_shown)
    }

    /// The level of which an entity has the mesh, from zero for the finest, if it is the root of a group whose meshes are
    /// swapped.
    pub fn swapped_level(&self, group: Entity) -> Option<usize> {
        let group = self.groups.get(self.groups.of_root(group)?)?;
        group.applied.map(usize::from)
    }

    /// Whether a camera shows an entity as far as levels of detail go: whether it belongs to the level that is shown of its
    /// group, and so up to the outermost. True of whatever belongs to none.
    pub fn shows(&self, view: Entity, entity: Entity) -> bool {
        self.groups.of_member(entity).is_none()
            || self.shows_in(Some(self.levels_of(LodView::Camera(view))), entity.index_u32())
    }

    /// The root of the group to which an entity belongs, with the levels that show it.
    pub fn group_of(&self, entity: Entity) -> Option<(Entity, impl Iterator<Item = usize> + use<>)> {
        let within = self.groups.of_member(entity)?;
        let root = self.groups.get(within.group)?.root;
        Some((
            root,
            (0..MAX_LEVELS).filter(move |level| within.levels >> level & 1 == 1),
        ))
    }

    /// How many groups there are.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there is no group.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The camera for which meshes are swapped, if there is any.
    pub fn main_camera(&self) -> Option<Entity> {
        self.main
    }

    /// The roots of all groups, in no promised order.
    pub fn roots(&self) -> impl Iterator<Item = Entity> + '_ {
        self.groups.ids().filter_map(|id| Some(self.groups.get(id)?.root))
    }

    /// The bounds of a group in the space of its root, by which its size and distance are told; `None` as long as nothing
    /// is known of them. `group` is the root.
    pub fn bounds(&self, group: Entity) -> Option<Aabb> {
        self.groups.get(self.groups.of_root(group)?)?.bounds
    }

    /// The distances in world units from which on a camera shows the levels of a group, by the [metric](super::LodMetric) and
    /// all biases: zero for the finest, infinite for what is never shown. `group` is the root. `None` if it is none, the
    /// camera is not active, or distances decide nothing, as with orthographic cameras.
    pub fn distances(&self, group: Entity, view: Entity) -> Option<impl Iterator<Item = f32> + '_> {
        let id = self.groups.of_root(group)?;
        let levels = self.views.get(&LodView::Camera(view))?;
        self.groups.reaches.get(id as usize)?.distances(levels.lens()?)
    }

    pub(crate) fn is_member(&self, entity: Entity) -> bool {
        self.groups.of_member(entity).is_some()
    }

    /// Whether an entity is the root of a group whose meshes are swapped.
    pub(crate) fn swaps(&self, entity: Entity) -> bool {
        let id = self.groups.of_root(entity);
        id.is_some_and(|id| self.groups.is_swapped(id))
    }

    /// Whether a view shows the entity of this number, which belongs to some level.
    #[inline]
    pub(crate) fn shows_in(&self, levels: Option<&ViewLevels>, number: u32) -> bool {
        self.groups.shows(levels, self.main_levels(), number)
    }

    pub(crate) fn levels_of(&self, view: LodView) -> &ViewLevels {
        let view = match view {
            LodView::Shadows(origin) if self.shadows_follow_cameras => LodView::Camera(origin),
            view => view,
        };
        self.views.get(&view).unwrap_or(&self.others)
    }

    /// What belongs to other levels than in the last frame.
    pub(crate) fn reassigned(&self) -> &[Entity] {
        &self.reassigned
    }

    pub(super) fn has_groups(&self) -> bool {
        self.groups.len() > 0
    }

    /// Whether a group has changed since meshes were last swapped.
    pub(super) fn has_pending(&self) -> bool {
        !self.pending.ids().is_empty()
    }

    pub(super) fn main_levels(&self) -> Option<&ViewLevels> {
        self.views.get(&LodView::Camera(self.main?))
    }
}
