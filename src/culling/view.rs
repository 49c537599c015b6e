//! What a view sees, found anew in every frame, and told by what has changed.

use bevy::{
    camera::{
        primitives::{Aabb, Sphere},
        visibility::RenderLayers,
    },
    ecs::{change_detection::Tick, entity::Entity, system::Query},
    math::bounding::Aabb3d,
    tasks::{ComputeTaskPool, TaskPool},
    transform::components::GlobalTransform,
};

use super::{
    bits::Bits,
    candidates::{Candidates, ClassId, Pool, Record},
    shape::ViewShape,
};
use crate::{
    index::{Key, SpatialIndex, mask, ticks::ones},
    lod::{LodChoices, LodView, ViewLevels},
    occlusion::{Occluders, OcclusionBuffer, Surroundings, Viewpoint},
    spatial::aabb_tree::{Open, Sides},
};

/// In a smaller world no task is worth it.
const LEAST_SHARED: usize = 8192;

/// Subtrees for each part that is walked by itself, so that none takes much longer than the others.
const SUBTREES_PER_PART: usize = 8;

/// A camera or a shadow map, as it is in this frame.
#[derive(Clone, Debug)]
pub(super) struct Request {
    /// The camera or the light.
    pub viewer: Entity,
    pub shape: ViewShape,
    pub layers: RenderLayers,
    /// What it is that sees: one of the facts of a [`Record`].
    pub audience: u16,
    /// Whether nothing is out of sight for where it is.
    pub sees_everywhere: bool,
    /// From where it is decided what is in which range, if there is such a place.
    pub range_origin: Option<Entity>,
    /// Whose levels of detail are seen, if they are chosen.
    pub levels: Option<LodView>,
    /// From where it is asked what is hidden, if it is.
    pub viewpoint: Option<Viewpoint>,
}

/// A view from frame to frame.
#[derive(Debug, Default)]
pub(super) struct View {
    /// What was found in sight.
    found: Found,
    /// What was in sight in the last frame, on whatever layer.
    in_sight: Bits,
    /// What is seen.
    pub seen: Bits,
    seen_len: usize,
    /// What has changed in what is seen.
    pub changes: Vec<Change>,
    /// How many of the changes were counted.
    pub counted: usize,
    /// What is in sight, and is seen if it is in range.
    pub undecided: Vec<u32>,
    /// The layers of the last frame, if there was one.
    layers: Option<RenderLayers>,
    /// The version of the levels of detail of the last frame; zero for none.
    levels: u64,
    /// What belongs to levels that have switched, by number.
    switched: Bits,
    /// When its lists were last written.
    pub written: Option<Tick>,
    /// What hides things.
    pub occlusion: OcclusionBuffer,
}

/// What is in sight, by who has found it: each part of the tree, and those who were tested one by one.
#[derive(Debug, Default)]
struct Found {
    in_tree: Vec<Part>,
    one_by_one: Part,
    /// What the tree was asked for: as long as nothing changes, that is the answer.
    question: Option<Question>,
}

/// What one of them has found.
#[derive(Debug, Default)]
struct Part {
    bits: Bits,
    /// How many entities were tested by themselves in this frame.
    tested: usize,
}

/// What the tree is asked for.
#[derive(Debug)]
struct Question {
    shape: ViewShape,
    layers: RenderLayers,
    /// With the versions of the occluders and of the levels of detail.
    hidden_from: Option<(Viewpoint, u64, u64)>,
}

/// How an entity has changed for a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub entity: Entity,
    /// Its classes in the last frame, if it was seen.
    pub from: ClassId,
    /// Its classes, if it is seen.
    pub to: ClassId,
}

impl Change {
    pub fn has_come(&self) -> bool {
        self.from == ClassId::NOT_SEEN
    }

    pub fn has_gone(&self) -> bool {
        self.to == ClassId::NOT_SEEN
    }
}

/// The world that views look at.
#[derive(Clone, Copy)]
pub(super) struct Sights<'a, 'w, 's> {
    pub index: &'a SpatialIndex,
    /// Whether the index is of this frame.
    pub index_is_current: bool,
    /// Whether anything has moved, or changed otherwise.
    pub has_changed: bool,
    pub candidates: &'a Candidates,
    pub bounds: &'a Bounds<'w, 's>,
    pub layers: &'a Layers<'w, 's>,
    pub occluders: Option<&'a Occluders>,
    pub lods: Option<&'a LodChoices>,
}

/// What Bevy tests of an entity.
pub(super) type Bounds<'w, 's> =
    Query<'w, 's, (Option<&'static Aabb>, Option<&'static Sphere>, &'static GlobalTransform)>;

/// The layers of what is not on the default one.
pub(super) type Layers<'w, 's> = Query<'w, 's, &'static RenderLayers>;

/// Finds what is in sight of each view, in parallel where that pays, and what has changed. What `is_in_range` does not
/// know stays undecided.
pub(super) fn look(
    views: &mut [(&Request, &mut View)],
    sights: Sights,
    is_in_range: impl Fn(&Request, Entity) -> Option<bool> + Sync,
) {
    let pool = ComputeTaskPool::get_or_init(TaskPool::default);
    let threads = pool.thread_num();
    if sights.index.len() < LEAST_SHARED || threads <= 1 {
        for (request, view) in views.iter_mut() {
            request.look_around(sights, view);
            view.settle(request, sights, |entity| is_in_range(request, entity));
        }
        return;
    }

    let parts = threads.div_ceil(views.len().max(1));
    pool.scope(|scope| {
        for (request, view) in views.iter_mut() {
            let (request, view) = (&**request, &mut **view);
            // What hides must be drawn before what is behind it is tested.
            if parts == 1 || request.viewpoint.is_some() {
                scope.spawn(async move { request.look_around(sights, view) });
                continue;
            }
            let found = &mut view.found;
            let open = request.begin(sights, parts, found);
            let Found {
                in_tree, one_by_one, ..
            } = found;
            for (part, found) in in_tree.iter_mut().enumerate() {
                let mine: Vec<Open> = open.iter().copied().skip(part).step_by(parts).collect();
                if !mine.is_empty() {
                    scope.spawn(async move { request.walk(sights, &mine, found) });
                }
            }
            scope.spawn(async move { request.test_one_by_one(sights, one_by_one) });
        }
    });
    let is_in_range = &is_in_range;
    pool.scope(|scope| {
        for (request, view) in views.iter_mut() {
            let (request, view) = (&**request, &mut **view);
            scope.spawn(async move { view.settle(request, sights, |entity| is_in_range(request, entity)) });
        }
    });
}

impl Request {
    /// The levels of detail that are seen: the finest ones, if there are none.
    fn levels<'a>(&self, sights: Sights<'a, '_, '_>) -> Option<&'a ViewLevels> {
        Some(sights.lods?.levels_of(self.levels?))
    }

    fn pool<'a>(&self, candidates: &'a Candidates) -> &'a Pool {
        if self.audience == Record::FOR_CAMERAS {
            &candidates.for_cameras
        } else {
            &candidates.for_lights
        }
    }

    /// Finds all that is in sight.
    fn look_around(&self, sights: Sights, view: &mut View) {
        let View { found, occlusion, .. } = view;
        if let Some((viewpoint, occluders)) = self.viewpoint.as_ref().zip(sights.occluders) {
            // Whoever took the buffer away has spoilt what was found.
            if !occlusion.is_drawn() {
                found.question = None;
            }
            if self.ask_anew(sights, 1, found) {
                self.find_unhidden(sights, viewpoint, occluders, occlusion, &mut found.in_tree[0]);
            }
            self.test_one_by_one(sights, &mut found.one_by_one);
            self.leave_out_hidden(sights, occlusion, &mut found.one_by_one.bits);
            return;
        }
        let open = self.begin(sights, 1, found);
        if let Some(first) = found.in_tree.first_mut() {
            self.walk(sights, &open, first);
        }
        self.test_one_by_one(sights, &mut found.one_by_one);
    }

    /// Finds what is in sight and not hidden.
    fn find_unhidden(
        &self,
        sights: Sights,
        viewpoint: &Viewpoint,
        occluders: &Occluders,
        occlusion: &mut OcclusionBuffer,
        found: &mut Part,
    ) {
        let around = Surroundings {
            index: sights.index,
            occluders,
            half_spaces: &self.shape.half_spaces,
            mask: self.mask(),
        };
        // Only what is drawn for this camera hides something from it; what is in which range is not known yet.
        let levels = self.levels(sights);
        let may_occlude = |key: Key| {
            let record = sights.candidates.record(key.entity.index_u32());
            record.entity == key.entity
                && record.is(self.audience | Record::SHOWN)
                && !record.is(Record::RANGED)
                && record.is_shown_by(levels, sights.lods)
                && (occluders.layers(key.entity)).is_some_and(|layers| self.layers.intersects(layers))
        };
        let mut finder = Finder {
            request: self,
            sights,
            found,
        };
        occlusion.find_seen(viewpoint, &around, may_occlude, &mut finder);
        for key in occlusion.hidden_since() {
            found.bits.remove(key.entity.index_u32());
        }
    }

    /// Takes back what is hidden of what was tested one by one, but for what is never left out.
    fn leave_out_hidden(&self, sights: Sights, occlusion: &OcclusionBuffer, found: &mut Bits) {
        if self.sees_everywhere || !sights.index_is_current {
            return;
        }
        let pool = self.pool(sights.candidates);
        for number in pool
            .one_by_one
            .iter()
            .filter(|&number| !pool.never_hidden.contains(number))
        {
            let aabb = sights.index.aabb(sights.candidates.record(number).entity);
            if found.contains(number) && aabb.is_some_and(|aabb| occlusion.hides(&aabb)) {
                found.remove(number);
            }
        }
    }

    /// Forgets what was found, and opens the tree for so many parts, of which the first finds what is at its top.
    fn begin(&self, sights: Sights, parts: usize, found: &mut Found) -> Vec<Open> {
        if !self.ask_anew(sights, parts, found) {
            return Vec::new();
        }
        let subtrees = if parts > 1 { parts * SUBTREES_PER_PART } else { 1 };
        let mut finder = Finder {
            request: self,
            sights,
            found: &mut found.in_tree[0],
        };
        let tree = sights.index.tree();
        tree.open(&self.shape.half_spaces, self.mask(), subtrees, &mut finder)
    }

    /// Forgets what was found, in so many parts of the tree, unless it would be found again. Returns whether the tree is
    /// to be asked.
    fn ask_anew(&self, sights: Sights, parts: usize, found: &mut Found) -> bool {
        found.one_by_one.clear();
        found.in_tree.iter_mut().for_each(|part| part.tested = 0);
        if self.sees_everywhere || !sights.index_is_current {
            found.in_tree.iter_mut().for_each(Part::clear);
            found.question = None;
            return false;
        }
        let levels = self.levels(sights).map_or(0, ViewLevels::version);
        let hidden_from = (self.viewpoint.zip(sights.occluders))
            .map(|(viewpoint, occluders)| (viewpoint, occluders.version(), levels));
        let known = found.question.as_ref().filter(|_| !sights.has_changed);
        if known.is_some_and(|known| {
            known.shape.is_same(&self.shape)
                && known.layers == self.layers
                && match (&known.hidden_from, &hidden_from) {
                    (Some((one, occluders, levels)), Some((other, occluders_now, levels_now))) => {
                        one.is_same(other) && (occluders, levels) == (occluders_now, levels_now)
                    }
                    (None, None) => true,
                    _ => false,
                }
        }) {
            return false;
        }
        found.in_tree.iter_mut().for_each(Part::clear);
        found.question = Some(Question {
            shape: self.shape.clone(),
            layers: self.layers.clone(),
            hidden_from,
        });
        found.in_tree.resize_with(parts, Part::default);
        true
    }

    fn walk(&self, sights: Sights, open: &[Open], found: &mut Part) {
        let mut finder = Finder {
            request: self,
            sights,
            found,
        };
        for &open in open {
            let tree = sights.index.tree();
            tree.walk(&self.shape.half_spaces, self.mask(), open, &mut finder);
        }
    }

    /// Whether an entity that is on other layers than the default one is on one of those that are seen.
    fn is_on_layer(&self, sights: Sights, entity: Entity) -> bool {
        let layers = sights.layers.get(entity);
        // Whoever looks shares its layers with itself, even if it has none, as Bevy has it.
        entity == self.viewer || layers.is_ok_and(|layers| self.layers.intersects(layers))
    }

    fn mask(&self) -> u32 {
        mask::of_view(&self.layers)
    }

    fn test_one_by_one(&self, sights: Sights, found: &mut Part) {
        if self.sees_everywhere {
            return;
        }
        let pool = self.pool(sights.candidates);
        let mut test = |number| {
            found.tested += 1;
            if self.sees(sights, sights.candidates.record(number).entity) {
                found.bits.insert(number);
            }
        };
        pool.one_by_one.iter().for_each(&mut test);
        if !sights.index_is_current {
            pool.in_tree.iter().for_each(&mut test);
        }
    }

    /// Bevy's answer.
    fn sees(&self, sights: Sights, entity: Entity) -> bool {
        match sights.bounds.get(entity) {
            Ok((Some(aabb), _, transform)) => self.shape.sees(aabb, transform),
            Ok((None, Some(sphere), _)) => self.shape.sees_sphere(sphere),
            Ok((None, None, _)) | Err(_) => true,
        }
    }
}

/// Collects what the tree has in sight.
struct Finder<'a, 'w, 's> {
    request: &'a Request,
    sights: Sights<'a, 'w, 's>,
    found: &'a mut Part,
}

impl Finder<'_, '_, '_> {
    fn sees(&mut self, entity: Entity) -> bool {
        self.found.tested += 1;
        self.request.sees(self.sights, entity)
    }
}

impl Sides<Key> for Finder<'_, '_, '_> {
    #[inline]
    fn inside(&mut self, keys: &[Key]) {
        for key in keys {
            self.found.bits.insert(key.entity.index_u32());
        }
    }

    #[inline]
    fn across(&mut self, key: Key, aabb: &Aabb3d) {
        let number = key.entity.index_u32();
        let pool = self.request.pool(self.sights.candidates);
        // A sphere or a box whose centre is inside is not outside, whatever its size: nothing has to be looked up.
        let is_in = pool.centered.contains(number) && self.request.shape.half_spaces.surely_have_center(aabb);
        if is_in || pool.in_tree.contains(number) && self.sees(key.entity) {
            self.found.bits.insert(number);
        }
    }
}

impl Part {
    fn clear(&mut self) {
        self.bits.clear();
        self.tested = 0;
    }
}

impl View {
    /// How many entities were tested by themselves in this frame.
    pub fn tested(&self) -> usize {
        let in_tree: usize = self.found.in_tree.iter().map(|part| part.tested).sum();
        in_tree + self.found.one_by_one.tested
    }

    /// How many entities are seen.
    pub fn seen_len(&self) -> usize {
        self.seen_len
    }

    /// Begins a frame: no change is known yet, but of what is gone.
    pub fn begin_frame(&mut self, gone: &[(Entity, ClassId)]) {
        self.changes.clear();
        self.counted = 0;
        self.undecided.clear();
        for &(entity, from) in gone {
            if self.seen.remove(entity.index_u32()) {
                self.seen_len -= 1;
                self.changes.push(Change {
                    entity,
                    from,
                    to: ClassId::NOT_SEEN,
                });
            }
        }
    }

    /// Finds what has changed.
    fn settle(&mut self, request: &Request, sights: Sights, is_in_range: impl Fn(Entity) -> Option<bool>) {
        let candidates = sights.candidates;
        let pool = request.pool(candidates);
        let is_on_default_layer = request.layers.intersects(<&RenderLayers>::default());
        // What is on other layers now is in sight as it was.
        let has_other_layers = self.layers.as_ref() != Some(&request.layers);
        if has_other_layers {
            self.layers = Some(request.layers.clone());
        }
        let levels = request.levels(sights);
        let recheck_all = has_other_layers | !self.follow_levels(levels);

        let blocks = [&pool.in_tree, &pool.one_by_one, &pool.untested, &self.in_sight];
        let blocks = blocks.map(Bits::blocks).into_iter().max().unwrap_or(0);
        for block in 0..blocks {
            let found = if request.sees_everywhere {
                pool.in_tree.used(block) | pool.one_by_one.used(block)
            } else {
                let in_tree = self.found.in_tree.iter();
                in_tree.fold(self.found.one_by_one.bits.used(block), |used, found| {
                    used | found.bits.used(block)
                })
            };
            for word in ones(found | pool.untested.used(block) | self.in_sight.used(block)) {
                let word = block * 64 + word as usize;
                let tested = if request.sees_everywhere {
                    pool.in_tree.word(word) | pool.one_by_one.word(word)
                } else {
                    let in_tree = self.found.in_tree.iter();
                    let in_tree = in_tree.fold(0, |bits, found| bits | found.bits.word(word));
                    in_tree & pool.in_tree.word(word) | self.found.one_by_one.bits.word(word)
                };
                let now = tested | pool.untested.word(word);
                let before = self.in_sight.word(word);
                let recheck = if recheck_all {
                    u64::MAX
                } else {
                    candidates.changed.word(word) | candidates.ranged.word(word) | self.switched.word(word)
                };
                self.in_sight.set_word(word, now);
                for bit in ones(now ^ before | recheck & (now | before)) {
                    let number = word as u32 * 64 + bit;
                    let record = candidates.record(number);
                    let is_seen = now >> bit & 1 != 0
                        && record.is(request.audience | Record::SHOWN)
                        && record.is_shown_by(levels, sights.lods)
                        && if record.is(Record::ON_LAYERS) {
                            request.is_on_layer(sights, record.entity)
                        } else {
                            is_on_default_layer
                        };
                    if !is_seen || !record.is(Record::RANGED) {
                        self.note(number, is_seen, candidates);
                    } else if let Some(is_in_range) = is_in_range(record.entity) {
                        self.note(number, is_in_range, candidates);
                    } else {
                        self.undecided.push(number);
                    }
                }
            }
        }
    }

    /// Notes what has switched since the last frame; returns whether that is known.
    fn follow_levels(&mut self, levels: Option<&ViewLevels>) -> bool {
        self.switched.clear();
        let before = std::mem::replace(&mut self.levels, levels.map_or(0, ViewLevels::version));
        if self.levels == before {
            return true;
        }
        match levels.and_then(|levels| levels.switched_since(before)) {
            Some(switched) => {
                switched.iter().for_each(|&number| {
                    self.switched.insert(number);
                });
                true
            }
            None => false,
        }
    }

    /// Notes whether an entity is seen now.
    pub fn note(&mut self, number: u32, is_seen: bool, candidates: &Candidates) {
        let record = candidates.record(number);
        let was_seen = self.seen.contains(number);
        if is_seen != was_seen {
            self.seen.set(number, is_seen);
            self.seen_len = self.seen_len + usize::from(is_seen) - usize::from(was_seen);
        }
        let from = if was_seen {
            candidates.old_classes(number)
        } else {
            ClassId::NOT_SEEN
        };
        let to = if is_seen { record.classes } else { ClassId::NOT_SEEN };
        if from != to {
            self.changes.push(Change {
                entity: record.entity,
                from,
                to,
            });
        }
    }

    /// Lists all that is seen as if it had just come, in ascending order, written over `changes`.
    pub fn list_all(&self, candidates: &Candidates, changes: &mut Vec<Change>) {
        changes.clear();
        changes.extend(self.seen.iter().map(|number| {
            let record = candidates.record(number);
            Change {
                entity: record.entity,
                from: ClassId::NOT_SEEN,
                to: record.classes,
            }
        }));
        changes.sort_unstable_by_key(|change| change.entity);
    }
}

/// What has come, of some changes.
pub(super) fn come(changes: &[Change]) -> impl Iterator<Item = Entity> + Clone + '_ {
    changes
        .iter()
        .filter(|change| change.has_come())
        .map(|change| change.entity)
}

/// What has gone, of some changes.
pub(super) fn gone(changes: &[Change]) -> impl Iterator<Item = Entity> + Clone + '_ {
    changes
        .iter()
        .filter(|change| change.has_gone())
        .map(|change| change.entity)
}
