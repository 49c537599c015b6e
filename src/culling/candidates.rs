//! What can be seen at all, and what is known of it: kept from frame to frame, and looked at anew only where something
//! has changed.

use std::any::TypeId;

use bevy::{
    camera::{
        primitives::{Aabb, Sphere},
        visibility::{
            InheritedVisibility, NoCpuCulling, NoFrustumCulling, RenderLayers, ViewVisibility, VisibilityClass,
            VisibilityRange,
        },
    },
    ecs::{
        entity::Entity,
        query::{Has, QueryData, Without},
        system::Query,
    },
    light::{DirectionalLight, NotShadowCaster},
    mesh::{Mesh3d, morph::MeshMorphWeights, skinning::SkinnedMesh},
    platform::collections::HashMap,
    transform::components::GlobalTransform,
};
use smallvec::SmallVec;

use super::bits::Bits;
use crate::{
    index::{HitSurface, PickShape, SimplifiedMesh, SpatialIndex},
    lod::{LodChoices, ViewLevels},
    occlusion::NoOcclusionCulling,
};

/// Everything that views may see, by its index in the world.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    records: Vec<Record>,
    /// How many there are.
    len: usize,
    /// What cameras may see.
    pub for_cameras: Pool,
    /// What may cast shadows.
    pub for_lights: Pool,
    /// Whatever has a `VisibilityRange`, and so may come and go as views move.
    pub ranged: Bits,
    /// Whatever cameras see.
    by_cameras: Bits,
    /// Whatever is seen in shadow maps.
    in_shadow_maps: Bits,
    shadow_map_len: usize,
    /// What has changed in this frame.
    pub changed: Bits,
    /// What is there, or has a mark, and had not in the last frame.
    pub new: Vec<Entity>,
    /// What was there in the last frame and is not any more, with the classes that it had.
    pub gone: Vec<(Entity, ClassId)>,
    /// The classes of what has changed in this frame, as they were in the last frame.
    old_classes: HashMap<u32, ClassId>,
    /// All lists of classes that there are, by their number.
    classes: Vec<Classes>,
    /// Those that lack what all that is seen needs, and may be given it unnoticed.
    pub incomplete: Vec<Entity>,
}

/// Candidates by the way in which they are tested.
#[derive(Debug, Default)]
pub(super) struct Pool {
    /// The boxes of the index contain theirs: the tree decides.
    pub in_tree: Bits,
    /// Of those: the boxes of the index are around no more than theirs, and so have the same centres.
    pub centered: Bits,
    /// Each is tested by itself.
    pub one_by_one: Bits,
    /// These have nothing to test.
    pub untested: Bits,
    /// Of those that are tested one by one: they are seen behind whatever hides others.
    pub never_hidden: Bits,
}

/// What is known of a candidate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    /// [`Entity::PLACEHOLDER`] if nobody with this index is a candidate.
    pub entity: Entity,
    /// By how many cameras it is seen.
    cameras: u32,
    /// In how many shadow maps it is seen.
    shadow_maps: u32,
    pub classes: ClassId,
    facts: u16,
}

/// The number of a list of visibility classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ClassId(u16);

/// The classes of an entity, as [`VisibilityClass`] has them.
pub(super) type Classes = SmallVec<[TypeId; 1]>;

impl ClassId {
    /// Of what is not seen.
    pub const NOT_SEEN: Self = Self(u16::MAX);
}

impl Record {
    const NOBODY: Self = Self {
        entity: Entity::PLACEHOLDER,
        cameras: 0,
        shadow_maps: 0,
        classes: ClassId(0),
        facts: 0,
    };

    /// It and its ancestors are not hidden.
    pub const SHOWN: u16 = 1;
    /// It has what cameras look for.
    pub const FOR_CAMERAS: u16 = 1 << 1;
    /// It has what directional lights look for.
    pub const FOR_CASCADES: u16 = 1 << 2;
    /// It has what point lights and spot lights look for.
    pub const FOR_LOCAL_LIGHTS: u16 = 1 << 3;
    /// It is on other layers than those that entities are on by default.
    pub const ON_LAYERS: u16 = 1 << 4;
    /// It has a `VisibilityRange`.
    pub const RANGED: u16 = 1 << 5;
    /// It has a `ViewVisibility`.
    const HAS_MARK: u16 = 1 << 6;
    /// It belongs to a level of detail.
    const LEVELED: u16 = 1 << 7;

    #[inline]
    pub fn is(&self, facts: u16) -> bool {
        self.facts & facts == facts
    }

    /// Whether it is what a view shows, as far as levels of detail go.
    #[inline]
    pub fn is_shown_by(&self, levels: Option<&ViewLevels>, lods: Option<&LodChoices>) -> bool {
        !self.is(Self::LEVELED) || lods.is_none_or(|lods| lods.shows_in(levels, self.entity.index_u32()))
    }
}

/// What decides how an entity is seen.
#[derive(QueryData)]
pub(super) struct Seen {
    pub entity: Entity,
    inherited: &'static InheritedVisibility,
    classes: Option<&'static VisibilityClass>,
    has_place: Has<GlobalTransform>,
    has_view_visibility: Has<ViewVisibility>,
    has_layers: Has<RenderLayers>,
    aabb: Option<&'static Aabb>,
    has_sphere: Has<Sphere>,
    has_mesh: Has<Mesh3d>,
    is_ranged: Has<VisibilityRange>,
    is_never_culled: Has<NoFrustumCulling>,
    is_never_hidden: Has<NoOcclusionCulling>,
    has_skin: Has<SkinnedMesh>,
    has_morph_weights: Has<MeshMorphWeights>,
    has_pick_shape: Has<PickShape>,
    has_simplified_mesh: Has<SimplifiedMesh>,
    has_hit_surface: Has<HitSurface>,
    casts_no_shadow: Has<NotShadowCaster>,
    is_directional_light: Has<DirectionalLight>,
}

/// All entities that may be seen. Bevy leaves those with `NoCpuCulling` to the GPU.
pub(super) type Seeables<'w, 's> = Query<'w, 's, Seen, Without<NoCpuCulling>>;

impl Candidates {
    #[inline]
    pub fn record(&self, number: u32) -> &Record {
        self.records.get(number as usize).unwrap_or(&Record::NOBODY)
    }

    pub fn classes(&self, id: ClassId) -> &[TypeId] {
        self.classes.get(usize::from(id.0)).map_or(&[], |classes| classes)
    }

    /// The classes that a candidate had in the last frame.
    pub fn old_classes(&self, number: u32) -> ClassId {
        let old = self.old_classes.get(&number).copied();
        old.unwrap_or(self.record(number).classes)
    }

    /// How many candidates there are.
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn begin_frame(&mut self) {
        self.changed.clear();
        self.new.clear();
        self.gone.clear();
        self.old_classes.clear();
    }

    /// Looks at an entity as it is now, which is nothing to be seen if there is no `seen`.
    pub fn refresh(&mut self, entity: Entity, seen: Option<SeenItem>, index: &SpatialIndex, lods: Option<&LodChoices>) {
        let number = entity.index_u32();
        let occupant = self.record(number).entity;
        let Some(seen) = seen else {
            if occupant == entity {
                self.forget(number);
            }
            return;
        };
        if occupant != entity && occupant != Entity::PLACEHOLDER {
            self.forget(number);
        }
        self.changed.insert(number);
        self.ranged.set(number, seen.is_ranged);
        if !seen.has_view_visibility || seen.has_mesh && !seen.has_place {
            self.incomplete.push(entity);
        }

        let for_cameras = seen.has_place && seen.has_view_visibility;
        let casts_shadow = seen.has_mesh && !seen.casts_no_shadow && !seen.is_directional_light;
        let aabb = seen.aabb.filter(|_| seen.has_place && !seen.is_never_culled);
        let has_sphere = seen.has_sphere && seen.aabb.is_none() && !seen.is_never_culled;
        let test = match (aabb, index.local_aabb(entity)) {
            (Some(aabb), Some(local)) => Test::InTree {
                is_centered: local.min == aabb.min() && local.max == aabb.max(),
            },
            (Some(_), None) => Test::OneByOne,
            (None, _) => Test::None,
        };
        // The index knows where these are hit, or where they were before their meshes were swapped, and not where they are
        // drawn.
        let is_elsewhere = (seen.has_skin || seen.has_morph_weights)
            && (seen.has_pick_shape
                || seen.has_simplified_mesh
                || seen.has_hit_surface
                || lods.is_some_and(|lods| lods.swaps(entity)));
        // A lamp lights more than the box by which it is picked.
        let is_never_hidden = seen.is_never_hidden || is_elsewhere || has_sphere;
        let test_of_camera = if has_sphere || is_never_hidden && test != Test::None {
            Test::OneByOne
        } else {
            test
        };
        self.for_cameras.put(number, for_cameras.then_some(test_of_camera));
        self.for_cameras.never_hidden.set(number, is_never_hidden);
        self.for_lights.put(number, casts_shadow.then_some(test));

        let facts = [
            (Record::SHOWN, seen.inherited.get()),
            (Record::FOR_CAMERAS, for_cameras),
            (Record::FOR_CASCADES, casts_shadow),
            (Record::FOR_LOCAL_LIGHTS, casts_shadow && seen.has_view_visibility),
            (Record::ON_LAYERS, seen.has_layers),
            (Record::RANGED, seen.is_ranged),
            (Record::HAS_MARK, seen.has_view_visibility),
            (Record::LEVELED, lods.is_some_and(|lods| lods.is_member(entity))),
        ];
        let facts = facts.into_iter().filter(|&(_, is)| is);
        let classes = self.intern(seen.classes.map_or(&[], |classes| &classes.0));
        if self.records.len() <= number as usize {
            self.records.resize(number as usize + 1, Record::NOBODY);
        }
        let record = &mut self.records[number as usize];
        let is_new = record.entity != entity;
        if is_new || seen.has_view_visibility && !record.is(Record::HAS_MARK) {
            self.new.push(entity);
        }
        if is_new {
            self.len += 1;
        } else if record.classes != classes {
            self.old_classes.entry(number).or_insert(record.classes);
        }
        *record = Record {
            entity,
            classes,
            facts: facts.fold(0, |facts, (fact, _)| facts | fact),
            ..*record
        };
    }

    /// Counts that a camera, or a shadow map, has begun to see an entity, or ceased to. Returns by how many of those it
    /// is seen now, if it is a candidate.
    pub fn count(&mut self, entity: Entity, audience: u16, comes: bool) -> Option<u32> {
        let number = entity.index_u32();
        let record = self
            .records
            .get_mut(number as usize)
            .filter(|record| record.entity == entity)?;
        let is_camera = audience == Record::FOR_CAMERAS;
        let (count, seen) = if is_camera {
            (&mut record.cameras, &mut self.by_cameras)
        } else {
            (&mut record.shadow_maps, &mut self.in_shadow_maps)
        };
        *count = if comes { *count + 1 } else { *count - 1 };
        let count = *count;
        if comes && count == 1 {
            seen.insert(number);
            self.shadow_map_len += usize::from(!is_camera);
        } else if count == 0 {
            seen.remove(number);
            self.shadow_map_len -= usize::from(!is_camera);
        }
        Some(count)
    }

    /// Whether cameras, or shadow maps, see an entity.
    pub fn is_seen_by(&self, audience: u16, entity: Entity) -> bool {
        let number = entity.index_u32();
        let seen = if audience == Record::FOR_CAMERAS {
            &self.by_cameras
        } else {
            &self.in_shadow_maps
        };
        self.record(number).entity == entity && seen.contains(number)
    }

    /// All that is seen in shadow maps.
    pub fn in_shadow_maps(&self) -> &Bits {
        &self.in_shadow_maps
    }

    /// How much is seen in shadow maps.
    pub fn shadow_map_len(&self) -> usize {
        self.shadow_map_len
    }

    /// Whether cameras see an entity.
    pub fn is_seen_by_cameras(&self, number: u32) -> bool {
        self.by_cameras.contains(number)
    }

    fn forget(&mut self, number: u32) {
        let classes = self.old_classes(number);
        self.old_classes.remove(&number);
        let record = std::mem::replace(&mut self.records[number as usize], Record::NOBODY);
        self.gone.push((record.entity, classes));
        self.len -= 1;
        self.for_cameras.put(number, None);
        self.for_lights.put(number, None);
        self.ranged.remove(number);
        self.by_cameras.remove(number);
        self.shadow_map_len -= usize::from(self.in_shadow_maps.remove(number));
        self.changed.insert(number);
    }

    fn intern(&mut self, classes: &[TypeId]) -> ClassId {
        let known = self.classes.iter().position(|known| known[..] == *classes);
        let place = known.unwrap_or_else(|| {
            self.classes.push(classes.into());
            self.classes.len() - 1
        });
        ClassId(u16::try_from(place).expect("fewer lists of visibility classes than 65,535"))
    }
}

/// How a candidate is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Test {
    InTree { is_centered: bool },
    OneByOne,
    None,
}

impl Pool {
    fn put(&mut self, number: u32, test: Option<Test>) {
        self.in_tree.set(number, matches!(test, Some(Test::InTree { .. })));
        self.centered
            .set(number, matches!(test, Some(Test::InTree { is_centered: true })));
        self.one_by_one.set(number, test == Some(Test::OneByOne));
        self.untested.set(number, test == Some(Test::None));
        if test.is_none() {
            self.never_hidden.remove(number);
        }
    }
}
