//! Making levels of meshes, and handing them to entities.

use std::{sync::Arc, time::Duration};

use bevy::{
    asset::{AssetEvent, AssetId, AssetServer, Assets, Handle, LoadState},
    ecs::{
        change_detection::{DetectChanges, Ref, Res, ResMut},
        entity::{Entity, EntityHashMap, EntityHashSet},
        lifecycle::RemovedComponents,
        message::MessageReader,
        query::{Changed, Or, With},
        resource::Resource,
        system::{Commands, Query},
    },
    mesh::{Mesh, Mesh3d},
    platform::collections::{HashMap, HashSet},
};
use tracing::warn;

use super::{
    AutoProxy, MeshChain, ProxyFailed, ProxyReady, ProxyStats, SimplifyError, SimplifyTarget,
    auto_proxy::filled,
    job::{Job, most_jobs},
    progress::Stage,
};
use crate::{
    lod::{LodContent, LodMetric, ProxyLod},
    phase::phase,
};

/// The levels of all meshes that entities with [`AutoProxy`] use.
#[derive(Resource, Debug, Default)]
pub(super) struct AutoProxies {
    chains: HashMap<ChainKey, Chain>,
    users: EntityHashMap<User>,
    /// The users that have not been told yet how their levels have turned out.
    due: Vec<Entity>,
    /// The users that were given another mesh, and have lost their levels for it.
    given_another: Vec<GivenAnother>,
}

/// What levels are made of, and how.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct ChainKey {
    mesh: AssetId<Mesh>,
    /// By their bits.
    levels: Vec<(bool, u32)>,
    lock_borders: bool,
}

/// The levels of a mesh, and who uses them.
#[derive(Debug)]
struct Chain {
    targets: Vec<SimplifyTarget>,
    users: EntityHashSet,
    state: State,
    /// Whether it was said that there are none.
    has_warned: bool,
}

#[derive(Debug)]
enum State {
    /// For the asset, or for its turn.
    Waiting,
    Making(Job<Result<MeshChain, SimplifyError>>),
    /// The levels after the original, with their errors.
    Ready(Arc<[(Handle<Mesh>, f32)]>),
    Failed(SimplifyError),
}

/// An entity that has levels, or is to have some.
#[derive(Debug)]
struct User {
    key: ChainKey,
    /// The original.
    source: Handle<Mesh>,
}

/// When its group goes, an entity gets its original back: what it was given in the meantime has to be given once more.
#[derive(Debug)]
struct GivenAnother {
    entity: Entity,
    before: AssetId<Mesh>,
    now: Handle<Mesh>,
}

impl ChainKey {
    fn new(mesh: AssetId<Mesh>, proxy: &AutoProxy) -> Self {
        let bits = |target: &SimplifyTarget| match *target {
            SimplifyTarget::Error(error) => (true, error.to_bits()),
            SimplifyTarget::Ratio(ratio) => (false, ratio.to_bits()),
        };
        Self {
            mesh,
            levels: proxy.levels.iter().map(bits).collect(),
            lock_borders: proxy.lock_borders,
        }
    }
}

impl AutoProxies {
    /// Where each mesh is.
    pub fn stages(&self) -> impl Iterator<Item = Stage> + '_ {
        self.chains.values().map(|chain| match &chain.state {
            State::Waiting => Stage::Waiting,
            State::Making(job) => Stage::Making(job.fraction()),
            State::Ready(_) => Stage::Ready,
            State::Failed(_) => Stage::Failed,
        })
    }

    /// Has an entity use the levels of a mesh.
    fn acquire(&mut self, entity: Entity, source: Handle<Mesh>, proxy: &AutoProxy) {
        let key = ChainKey::new(source.id(), proxy);
        let chain = self.chains.entry(key.clone()).or_insert_with(|| Chain {
            targets: proxy.levels.clone(),
            users: EntityHashSet::default(),
            state: State::Waiting,
            has_warned: false,
        });
        chain.users.insert(entity);
        if matches!(chain.state, State::Ready(_) | State::Failed(_)) {
            self.due.push(entity);
        }
        self.users.insert(entity, User { key, source });
    }

    /// Takes an entity off its levels.
    fn release(&mut self, entity: Entity) -> Option<User> {
        let user = self.users.remove(&entity)?;
        if let Some(chain) = self.chains.get_mut(&user.key) {
            chain.users.remove(&entity);
            if chain.users.is_empty() {
                self.chains.remove(&user.key);
            }
        }
        Some(user)
    }

    /// The levels of an entity after the original, once they are there.
    fn levels(&self, user: &User) -> &[(Handle<Mesh>, f32)] {
        match self.chains.get(&user.key).map(|chain| &chain.state) {
            Some(State::Ready(levels)) => levels,
            _ => &[],
        }
    }
}

/// What is there of an entity with [`AutoProxy`].
type Watched = (
    Entity,
    Ref<'static, AutoProxy>,
    &'static Mesh3d,
    Option<&'static ProxyLod>,
);

/// Follows entities with [`AutoProxy`].
pub(super) fn follow_users(
    mut proxies: ResMut<AutoProxies>,
    changed: Query<Watched, Or<(Changed<AutoProxy>, Changed<Mesh3d>)>>,
    meshes: Query<&Mesh3d, With<AutoProxy>>,
    mut without_proxy: RemovedComponents<AutoProxy>,
    mut without_mesh: RemovedComponents<Mesh3d>,
    mut stats: ResMut<ProxyStats>,
    mut commands: Commands,
) {
    stats.make = Duration::ZERO;
    let _phase = phase!("sightline/simplify/make").adds_to(&mut stats.make);
    for entity in without_proxy.read().chain(without_mesh.read()) {
        if !meshes.contains(entity) {
            proxies.release(entity);
        }
    }
    for GivenAnother { entity, before, now } in std::mem::take(&mut proxies.given_another) {
        if meshes.get(entity).is_ok_and(|mesh| mesh.id() == before) {
            commands.entity(entity).try_insert(Mesh3d(now));
        }
    }
    for (entity, proxy, mesh, lod) in &changed {
        let user = proxies.users.get(&entity);
        let is_level = |user: &User| proxies.levels(user).iter().any(|(level, _)| level.id() == mesh.id());
        let source = match user {
            Some(user) if is_level(user) => user.source.clone(),
            // Levels that were made before: of a copy, or of this entity when it had the component last.
            None => lod
                .and_then(|lod| finest_of(lod, mesh.id()))
                .unwrap_or_else(|| mesh.0.clone()),
            Some(_) => mesh.0.clone(),
        };
        if user.is_some_and(|user| user.key == ChainKey::new(source.id(), &proxy)) {
            if proxy.is_changed() {
                proxies.due.push(entity);
            }
            continue;
        }
        if let Some(before) = proxies.release(entity)
            && lod.is_some()
        {
            commands.entity(entity).try_remove::<ProxyLod>();
            if before.source != source {
                proxies.given_another.push(GivenAnother {
                    entity,
                    before: before.source.id(),
                    now: source.clone(),
                });
            }
        }
        proxies.acquire(entity, source, &proxy);
    }
}

/// The finest mesh of a group of meshes, if an entity has one of them.
fn finest_of(lod: &ProxyLod, mesh: AssetId<Mesh>) -> Option<Handle<Mesh>> {
    let is_level = |content: &LodContent| matches!(content, LodContent::Mesh(level) if level.id() == mesh);
    match &lod.levels.first()?.content {
        LodContent::Mesh(finest) if lod.levels.iter().any(|level| is_level(&level.content)) => Some(finest.clone()),
        _ => None,
    }
}

/// Has the levels made anew of meshes that have been edited.
fn follow_edits(proxies: &mut AutoProxies, edited: &HashSet<AssetId<Mesh>>, commands: &mut Commands) {
    for (key, chain) in &mut proxies.chains {
        if edited.contains(&key.mesh) {
            if matches!(&chain.state, State::Ready(levels) if !levels.is_empty()) {
                for &user in &chain.users {
                    commands.entity(user).try_remove::<ProxyLod>();
                }
            }
            chain.state = State::Waiting;
        }
    }
}

/// Makes levels of the meshes that are loaded, and hands out those that are there.
pub(super) fn make_levels(
    mut proxies: ResMut<AutoProxies>,
    mut assets: ResMut<Assets<Mesh>>,
    server: Option<Res<AssetServer>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    users: Query<(&AutoProxy, Option<&ProxyLod>)>,
    mut stats: ResMut<ProxyStats>,
    mut commands: Commands,
) {
    let _phase = phase!("sightline/simplify/make").adds_to(&mut stats.make);
    let proxies = &mut *proxies;
    let edited: HashSet<AssetId<Mesh>> = (events.read())
        .filter_map(|event| match event {
            AssetEvent::Modified { id } | AssetEvent::Removed { id } => Some(*id),
            _ => None,
        })
        .collect();
    if !edited.is_empty() {
        follow_edits(proxies, &edited, &mut commands);
    }

    let making = |chain: &&Chain| matches!(chain.state, State::Making(_));
    let mut free = most_jobs().saturating_sub(proxies.chains.values().filter(making).count());
    for (key, chain) in &mut proxies.chains {
        if let State::Making(job) = &mut chain.state
            && let Some(made) = job.take_made()
        {
            free += 1;
            chain.state = match made {
                Ok(made) => State::Ready(hand_over(made, &mut assets)),
                Err(why) => State::Failed(why),
            };
            proxies.due.extend(&chain.users);
        }
        // What is edited in every frame is not simplified in between.
        if matches!(chain.state, State::Waiting) && !edited.contains(&key.mesh) {
            if let Some(mesh) = assets.get(key.mesh) {
                if free > 0 {
                    free -= 1;
                    chain.state = State::Making(start(mesh.clone(), chain.targets.clone(), key.lock_borders));
                }
            } else if has_failed(server.as_deref(), key.mesh) {
                chain.state = State::Failed(SimplifyError::NotLoaded);
                proxies.due.extend(&chain.users);
            }
        }
        if let State::Failed(why) = &chain.state
            && !std::mem::replace(&mut chain.has_warned, true)
            && let Some(user) = chain.users.iter().next()
        {
            warn!("there are no proxies for the mesh of {user}: {why}");
        }
    }

    for entity in std::mem::take(&mut proxies.due) {
        let (Some(user), Ok((proxy, lod))) = (proxies.users.get(&entity), users.get(entity)) else {
            continue;
        };
        match proxies.chains.get(&user.key).map(|chain| &chain.state) {
            Some(State::Ready(levels)) => {
                if !levels.is_empty() {
                    let finest = ProxyLod::new(LodMetric::PixelError(proxy.pixels), user.source.clone());
                    let group = levels
                        .iter()
                        .fold(finest, |group, (mesh, error)| group.then(*error, mesh.clone()));
                    let group = filled(lod, group);
                    if lod != Some(&group) {
                        commands.entity(entity).try_insert(group);
                    }
                }
                let levels = levels.len() + 1;
                commands.trigger(ProxyReady { entity, levels });
            }
            Some(&State::Failed(error)) => commands.trigger(ProxyFailed { entity, error }),
            _ => {}
        }
    }
}

/// Begins to make the levels of a mesh.
fn start(mesh: Mesh, targets: Vec<SimplifyTarget>, lock_borders: bool) -> Job<Result<MeshChain, SimplifyError>> {
    Job::start(move |progress| MeshChain::build_with(&mesh, &targets, lock_borders, Some(progress)).transpose())
}

/// Makes assets of levels.
fn hand_over(made: MeshChain, assets: &mut Assets<Mesh>) -> Arc<[(Handle<Mesh>, f32)]> {
    let of_level = |level: super::Simplified| (assets.add(level.mesh), level.deviation.at_most);
    made.levels.into_iter().map(of_level).collect()
}

/// Whether a mesh will never be loaded.
pub(super) fn has_failed(server: Option<&AssetServer>, mesh: AssetId<Mesh>) -> bool {
    server
        .and_then(|server| server.get_load_state(mesh))
        .is_some_and(|state| matches!(state, LoadState::Failed(_)))
}
