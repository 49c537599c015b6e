//! Who takes part, and what happens to them: the same in both apps.

use std::sync::Arc;

use bevy::{
    ecs::{component::Mutable, schedule::ScheduleLabel},
    mesh::skinning::SkinnedMeshInverseBindposes,
    platform::collections::HashMap,
    prelude::*,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// The meshes that things have.
#[derive(Resource)]
pub struct Meshes(pub Vec<Handle<Mesh>>);

/// What the skinned mesh, which is the last of all, is bound with.
#[derive(Resource)]
pub struct Skin(pub Handle<SkinnedMeshInverseBindposes>);

impl Skin {
    pub const JOINTS: usize = 3;
}

/// What an entity is there for. It may well get the components of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// To be seen.
    Thing,
    /// A joint of a skinned thing.
    Joint,
    /// To see.
    Camera,
    /// To see what casts shadows.
    Light,
    /// To carry cameras and lights, whose transforms have to stay sound: Bevy panics otherwise.
    Carrier,
}

/// All entities that take part.
#[derive(Clone, Debug, Default)]
pub struct Cast(Vec<(Role, Entity)>);

impl Cast {
    pub fn enter(&mut self, role: Role, entity: Entity) {
        self.0.push((role, entity));
    }

    /// Forgets who is gone.
    pub fn retain(&mut self, is_there: impl Fn(Entity) -> bool) {
        self.0.retain(|(_, entity)| is_there(*entity));
    }

    pub fn of(&self, role: Role) -> impl Iterator<Item = Entity> {
        (self.0.iter()).filter_map(move |&(its, entity)| (its == role).then_some(entity))
    }

    pub fn count(&self, role: Role) -> usize {
        self.of(role).count()
    }

    /// One of them, if there is any.
    pub fn any(&self, role: Role, rng: &mut ChaCha8Rng) -> Option<Entity> {
        let count = self.count(role);
        (count > 0).then(|| self.of(role).nth(rng.random_range(0..count)))?
    }
}

/// When in a frame something happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum When {
    Between,
    Update,
    Last,
}

type Edit = dyn Fn(&mut World) + Send + Sync;
type Dress = dyn Fn(&mut World, Entity) + Send + Sync;

/// Something that happens to a world.
#[derive(Clone)]
pub struct Change {
    /// For the message of a failure; names all entities that it concerns.
    pub what: String,
    act: Act,
}

#[derive(Clone)]
enum Act {
    Edit(Arc<Edit>),
    Spawn {
        role: Role,
        dress: Arc<Dress>,
        in_place_of: Option<Entity>,
    },
}

impl Change {
    pub fn new(what: String, edit: impl Fn(&mut World) + Send + Sync + 'static) -> Self {
        let act = Act::Edit(Arc::new(edit));
        Self { what, act }
    }

    /// Spawns an entity, and gives it its components.
    pub fn spawn(role: Role, what: String, dress: impl Fn(&mut World, Entity) + Send + Sync + 'static) -> Self {
        let act = Act::Spawn {
            role,
            dress: Arc::new(dress),
            in_place_of: None,
        };
        Self { what, act }
    }

    /// Despawns an entity and spawns this one with its index, which is one generation older.
    pub fn in_place_of(mut self, entity: Entity) -> Self {
        if let Act::Spawn { in_place_of, .. } = &mut self.act {
            self.what += &format!(" in place of {entity}");
            *in_place_of = Some(entity);
        }
        self
    }

    /// What role it brings into being.
    pub fn role(&self) -> Option<Role> {
        match self.act {
            Act::Edit(_) => None,
            Act::Spawn { role, .. } => Some(role),
        }
    }

    /// Makes it happen, and tells who has come into being.
    pub fn act(&self, world: &mut World) -> Option<Entity> {
        match &self.act {
            Act::Edit(edit) => {
                edit(world);
                None
            }
            Act::Spawn { dress, in_place_of, .. } => {
                let old = in_place_of.filter(|old| world.get_entity(*old).is_ok());
                let place = old.and_then(|old| world.despawn_no_free(old));
                let entity = match place {
                    Some(place) => world.spawn_empty_at(place).expect("nobody is there").id(),
                    None => world.spawn_empty().id(),
                };
                dress(world, entity);
                Some(entity)
            }
        }
    }

    /// Edits a component in place, if it is there.
    pub fn edit<C: Component<Mutability = Mutable>>(
        entity: Entity,
        what: &str,
        edit: impl Fn(&mut C) + Send + Sync + 'static,
    ) -> Self {
        Self::new(format!("{entity} {what}"), move |world| {
            if let Some(mut component) = world.get_mut::<C>(entity) {
                edit(&mut component);
            }
        })
    }

    /// Inserts components, if the entity is there.
    pub fn insert<B: Bundle + Clone + Sync>(entity: Entity, what: &str, bundle: B) -> Self {
        Self::new(format!("{entity} {what}"), move |world| {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                entity.insert(bundle.clone());
            }
        })
    }

    /// Removes components, if they are there.
    pub fn remove<B: Bundle>(entity: Entity) -> Self {
        Self::new(format!("{entity} loses {}", short_name::<B>()), move |world| {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                entity.remove::<B>();
            }
        })
    }

    /// Removes a component where it is, and inserts it, less often, where it is not.
    pub fn toggle<C: Component + Default>(entity: Entity, rng: &mut ChaCha8Rng) -> Self {
        let may_insert = rng.random_bool(0.3);
        let (loses, name) = (if may_insert { "has or loses" } else { "loses" }, short_name::<C>());
        Self::new(format!("{entity} {loses} {name}"), move |world| {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                if entity.contains::<C>() {
                    entity.remove::<C>();
                } else if may_insert {
                    entity.insert(C::default());
                }
            }
        })
    }

    pub fn despawn(entity: Entity) -> Self {
        Self::new(format!("{entity} is despawned"), move |world| {
            if let Ok(entity) = world.get_entity_mut(entity) {
                entity.despawn();
            }
        })
    }
}

fn short_name<T>() -> &'static str {
    let name = std::any::type_name::<T>();
    name.rsplit("::").next().unwrap_or(name)
}

/// A kind of change: how often it happens, and how to draw one.
pub type Way = (u32, fn(&mut ChaCha8Rng, &Cast) -> Option<Change>);

/// Draws a change.
pub fn draw(ways: &[Way], rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let mut ticket = rng.random_range(0..ways.iter().map(|(weight, _)| weight).sum());
    let (_, way) = ways.iter().find(|(weight, _)| {
        let is_it = ticket < *weight;
        ticket = ticket.wrapping_sub(*weight);
        is_it
    })?;
    way(rng, cast)
}

/// What is to happen within the next frame.
#[derive(Resource, Default)]
pub struct Script(pub HashMap<When, Vec<Change>>);

/// Runs the changes that happen within frames.
pub fn run_scripts(app: &mut App) {
    app.init_resource::<Script>();
    add(app, Update, When::Update);
    add(app, Last, When::Last);

    fn add(app: &mut App, schedule: impl ScheduleLabel, when: When) {
        let run = move |world: &mut World| {
            let changes = world.resource_mut::<Script>().0.remove(&when).unwrap_or_default();
            for change in changes {
                change.act(world);
            }
        };
        app.add_systems(schedule, run.in_set(ScriptSystems));
    }
}

/// After everybody has looked.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ScriptSystems;
