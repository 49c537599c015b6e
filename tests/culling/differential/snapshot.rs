//! What a user can see of culling in a frame.

use std::{
    any::TypeId,
    collections::{BTreeMap, BTreeSet},
    fmt,
};

use bevy::{
    camera::visibility::{
        CascadesVisibleEntities, CubemapVisibleEntities, VisibilitySystems, VisibleEntities, VisibleMeshEntities,
    },
    ecs::entity_disabling::Disabled,
    light::{SimulationLightSystems, cluster::ClusterVisibilityClass},
    prelude::*,
};

use super::{
    cast::ScriptSystems,
    things::{Rock, Tree},
};

/// Something that can be said of an entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fact {
    /// The value of its `ViewVisibility` when the frame is over.
    ViewVisibility,
    /// A system in `Update` has seen its `ViewVisibility` change.
    ChangedInUpdate,
    /// It was visible when the cameras were done, and before the lights began.
    SeenByCameras,
    /// A system in `Last` has seen its `ViewVisibility` change.
    ChangedInLast,
    /// What it sees of a class.
    Sees(&'static str),
    /// A system in `Last` has seen a change of its component with this name.
    ListsChanged(&'static str),
    /// What casts shadows in a cascade that it has for a camera.
    Cascade(Entity, usize),
    /// What casts shadows on a face of its cube.
    Face(usize),
    /// What casts shadows in its cone.
    Cone,
}

/// What is said.
#[derive(Clone, PartialEq, Eq)]
pub enum Value {
    Yes,
    Is(ViewVisibility),
    Entities(Vec<Entity>),
}

impl fmt::Debug for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Yes => write!(formatter, "yes"),
            Self::Is(visibility) => visibility.fmt(formatter),
            Self::Entities(entities) => entities.fmt(formatter),
        }
    }
}

/// All there is to see in a frame. What is not in it is false, and an empty list of a camera is no list: which classes
/// have those depends, in Bevy's own, on which threads have met them.
pub type Snapshot = BTreeMap<(Entity, Fact), Value>;

/// Those of which something was noted within a frame.
#[derive(Resource, Default)]
struct Notes(Vec<(Entity, Fact)>);

type Everybody = Allow<Disabled>;

/// Takes notes while frames run.
pub fn plugin(app: &mut App) {
    let in_update = |things: Query<(Entity, Ref<ViewVisibility>), Everybody>, mut notes: ResMut<Notes>| {
        let changed = things.iter().filter(|(_, visibility)| visibility.is_changed());
        notes.0.extend(changed.map(|(thing, _)| (thing, Fact::ChangedInUpdate)));
    };
    let behind_cameras = |things: Query<(Entity, &ViewVisibility), Everybody>, mut notes: ResMut<Notes>| {
        let seen = things.iter().filter(|(_, visibility)| visibility.get());
        notes.0.extend(seen.map(|(thing, _)| (thing, Fact::SeenByCameras)));
    };
    let in_last = |things: Query<(Entity, Ref<ViewVisibility>), Everybody>, mut notes: ResMut<Notes>| {
        let changed = things.iter().filter(|(_, visibility)| visibility.is_changed());
        notes.0.extend(changed.map(|(thing, _)| (thing, Fact::ChangedInLast)));
    };
    app.init_resource::<Notes>()
        .add_systems(Update, in_update.before(ScriptSystems))
        .add_systems(
            PostUpdate,
            behind_cameras
                .after(VisibilitySystems::CheckVisibility)
                .before(SimulationLightSystems::CheckLightVisibility)
                .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
        )
        .add_systems(
            Last,
            (
                in_last,
                note_lists::<VisibleEntities>("VisibleEntities"),
                note_lists::<CascadesVisibleEntities>("CascadesVisibleEntities"),
                note_lists::<CubemapVisibleEntities>("CubemapVisibleEntities"),
                note_lists::<VisibleMeshEntities>("VisibleMeshEntities"),
            )
                .before(ScriptSystems),
        );
}

fn note_lists<C: Component>(name: &'static str) -> impl FnMut(Query<(Entity, Ref<C>), Everybody>, ResMut<Notes>) {
    move |lists, mut notes| {
        let changed = lists.iter().filter(|(_, lists)| lists.is_changed());
        notes
            .0
            .extend(changed.map(|(entity, _)| (entity, Fact::ListsChanged(name))));
    }
}

/// What there was to see in the frame that is over.
pub fn take(app: &mut App) -> Snapshot {
    let world = app.world_mut();
    let notes = std::mem::take(&mut world.resource_mut::<Notes>().0);
    let mut snapshot: Snapshot = notes.into_iter().map(|fact| (fact, Value::Yes)).collect();
    let mut things = world.query_filtered::<(Entity, &ViewVisibility), Everybody>();
    for (thing, &visibility) in things.iter(world) {
        snapshot.insert((thing, Fact::ViewVisibility), Value::Is(visibility));
    }
    let mut cameras = world.query_filtered::<(Entity, &VisibleEntities), Everybody>();
    for (camera, lists) in cameras.iter(world) {
        for (class, entities) in lists.entities.iter().filter(|(_, entities)| !entities.is_empty()) {
            let fact = Fact::Sees(class_name(*class));
            snapshot.insert((camera, fact), Value::Entities(entities.clone()));
        }
    }
    let mut suns = world.query_filtered::<(Entity, &CascadesVisibleEntities), Everybody>();
    for (sun, views) in suns.iter(world) {
        for (&view, cascades) in &views.entities {
            for (number, list) in cascades.iter().enumerate() {
                let fact = Fact::Cascade(view, number);
                snapshot.insert((sun, fact), Value::Entities(list.entities.clone()));
            }
        }
    }
    let mut lamps = world.query_filtered::<(Entity, &CubemapVisibleEntities), Everybody>();
    for (lamp, faces) in lamps.iter(world) {
        for (number, list) in faces.iter().enumerate() {
            snapshot.insert((lamp, Fact::Face(number)), Value::Entities(list.entities.clone()));
        }
    }
    let mut spots = world.query_filtered::<(Entity, &VisibleMeshEntities), Everybody>();
    for (spot, list) in spots.iter(world) {
        snapshot.insert((spot, Fact::Cone), Value::Entities(list.entities.clone()));
    }
    snapshot
}

fn class_name(class: TypeId) -> &'static str {
    let names = [
        (TypeId::of::<Mesh3d>(), "Mesh3d"),
        (TypeId::of::<Mesh2d>(), "Mesh2d"),
        (TypeId::of::<Tree>(), "Tree"),
        (TypeId::of::<Rock>(), "Rock"),
        (TypeId::of::<ClusterVisibilityClass>(), "ClusterVisibilityClass"),
    ];
    let name = names.iter().find(|(id, _)| *id == class);
    name.map_or("another class", |(_, name)| name)
}

/// How much there was to see in some frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub seen: usize,
    pub appeared_or_left: usize,
    pub in_cascades: usize,
    pub on_faces: usize,
    pub in_cones: usize,
}

impl Tally {
    pub fn count(&mut self, snapshot: &Snapshot) {
        for ((_, fact), value) in snapshot {
            let count = match value {
                Value::Entities(entities) => entities.len(),
                _ => 1,
            };
            match fact {
                Fact::Sees(_) => self.seen += count,
                Fact::ChangedInLast => self.appeared_or_left += count,
                Fact::Cascade(..) => self.in_cascades += count,
                Fact::Face(_) => self.on_faces += count,
                Fact::Cone => self.in_cones += count,
                _ => (),
            }
        }
    }
}

/// Where two snapshots differ.
pub struct Difference {
    pub message: String,
    /// Everybody in question.
    pub concerns: BTreeSet<Entity>,
}

/// The first difference, if there is any.
pub fn difference(bevys: &Snapshot, ours: &Snapshot) -> Option<Difference> {
    let keys: BTreeSet<_> = bevys.keys().chain(ours.keys()).collect();
    let differs = |key| bevys.get(key) != ours.get(key);
    let different: Vec<_> = keys.into_iter().filter(|key| differs(*key)).collect();
    let key @ (entity, fact) = *different.first()?;
    let (theirs, our) = (bevys.get(key), ours.get(key));
    let mut concerns = BTreeSet::from([*entity]);
    let mut detail = String::new();
    if let (Some(Value::Entities(theirs)), Some(Value::Entities(our))) = (theirs, our) {
        let lacking: Vec<_> = theirs.iter().filter(|entity| !our.contains(entity)).collect();
        let excess: Vec<_> = our.iter().filter(|entity| !theirs.contains(entity)).collect();
        concerns.extend(lacking.iter().chain(&excess).copied());
        detail = format!("; lacking {lacking:?}, too many {excess:?}");
    }
    let others = different.len() - 1;
    Some(Difference {
        message: format!(
            "entity {entity}, {fact:?}: Bevy has {theirs:?}, ours {our:?}{detail}; {others} others differ"
        ),
        concerns,
    })
}
