//! Making proxies of blocks.

use std::sync::Arc;

use bevy::{
    asset::{AssetId, Assets},
    camera::visibility::Visibility,
    ecs::{
        change_detection::{Res, ResMut},
        entity::{Entity, EntityHashMap},
        hierarchy::ChildOf,
        lifecycle::RemovedComponents,
        query::{Changed, Has},
        resource::Resource,
        system::Query,
        world::{Mut, World},
    },
    math::Affine3A,
    mesh::{Mesh, Mesh3d},
    platform::collections::HashMap,
    transform::components::Transform,
};
use tracing::warn;

use super::{
    ClusterMaterials, ClusterProxy, ProxyFailed, ProxyReady, ProxyStats, Simplifier, SimplifyError,
    auto_proxy::filled,
    gather::Block,
    job::{Job, most_jobs},
    materials::Dressing,
    merge::merge_meshes,
    progress::Stage,
};
use crate::{
    lod::{LodMetric, ProxyLod},
    phase::phase,
    spatial::BuildProgress,
};

/// To get proxies that are drawn.
const HOW: &str = "name their types by AutoProxyPlugin::with_material";

/// The blocks that have a [`ClusterProxy`].
#[derive(Resource, Default)]
pub(super) struct ClusterProxies {
    clusters: EntityHashMap<Cluster>,
    /// Whether it was said that proxies have no materials.
    has_warned: bool,
}

#[derive(Default)]
struct Cluster {
    state: State,
    /// The proxies that are there.
    proxies: Vec<Entity>,
}

enum State {
    /// For its meshes, or for its turn; so many parts were there in the last frame.
    Waiting {
        parts: usize,
    },
    Making {
        job: Job<Result<Vec<Proxy>, SimplifyError>>,
        /// For each proxy.
        dressings: Vec<Vec<Dressing>>,
        /// What the proxies stand in for.
        children: Vec<Entity>,
    },
    Ready,
    Failed,
    /// Nobody asks for it any more.
    Off,
}

impl Default for State {
    fn default() -> Self {
        Self::Waiting { parts: 0 }
    }
}

/// The proxy of parts with the same materials.
struct Proxy {
    mesh: Mesh,
    /// In the space of the root.
    error: f32,
    /// What no error is smaller than.
    least: f32,
}

/// Parts with the same materials.
type Parts = Vec<(Arc<Mesh>, Affine3A)>;

impl ClusterProxies {
    /// Where each block is.
    pub fn stages(&self) -> impl Iterator<Item = Stage> + '_ {
        self.clusters.values().filter_map(|cluster| match &cluster.state {
            State::Waiting { .. } => Some(Stage::Waiting),
            State::Making { job, .. } => Some(Stage::Making(job.fraction())),
            State::Ready => Some(Stage::Ready),
            State::Failed => Some(Stage::Failed),
            State::Off => None,
        })
    }
}

/// Follows entities with [`ClusterProxy`].
pub(super) fn follow_clusters(
    mut clusters: ResMut<ClusterProxies>,
    changed: Query<Entity, Changed<ClusterProxy>>,
    all: Query<Has<ClusterProxy>>,
    mut removed: RemovedComponents<ClusterProxy>,
    mut stats: ResMut<ProxyStats>,
) {
    let _phase = phase!("sightline/simplify/make").adds_to(&mut stats.make);
    for entity in removed.read() {
        match all.get(entity) {
            Ok(true) => {}
            // Its proxies are to be found if it is asked for once more.
            Ok(false) => {
                let cluster = clusters.clusters.get_mut(&entity);
                cluster.into_iter().for_each(|cluster| cluster.state = State::Off);
            }
            Err(_) => {
                clusters.clusters.remove(&entity);
            }
        }
    }
    for entity in &changed {
        clusters.clusters.entry(entity).or_default().state = State::default();
    }
}

/// Whether something is to be made, or is being made.
pub(super) fn clusters_are_pending(clusters: Res<ClusterProxies>) -> bool {
    let is_pending = |cluster: &Cluster| matches!(cluster.state, State::Waiting { .. } | State::Making { .. });
    clusters.clusters.values().any(is_pending)
}

/// Makes proxies of blocks that are loaded, and puts up those that are there.
pub(super) fn make_clusters(world: &mut World) {
    let phase = phase!("sightline/simplify/make");
    world.resource_scope(|world, mut clusters: Mut<ClusterProxies>| {
        let ClusterProxies { clusters, has_warned } = &mut *clusters;
        let is_making = |cluster: &&Cluster| matches!(cluster.state, State::Making { .. });
        let mut free = most_jobs().saturating_sub(clusters.values().filter(is_making).count());
        for (&root, cluster) in clusters {
            match &mut cluster.state {
                State::Waiting { .. } if free > 0 => {
                    cluster.begin(root, world);
                    free -= usize::from(matches!(cluster.state, State::Making { .. }));
                }
                State::Making { job, .. } => {
                    if let Some(made) = job.take_made() {
                        cluster.finish(root, made, world);
                        if world.resource::<ClusterMaterials>().is_empty() && !std::mem::replace(has_warned, true) {
                            warn!("the proxy of the block {root} has no material, and no other will have one: {HOW}");
                        }
                    }
                }
                _ => {}
            }
        }
    });
    world.resource_mut::<ProxyStats>().make += phase.end();
}

impl Cluster {
    /// Begins to make the proxy, once all parts are there, and were in the last frame.
    fn begin(&mut self, root: Entity, world: &mut World) {
        for proxy in self.proxies.drain(..) {
            let _ = world.try_despawn(proxy);
        }
        let Ok(entity) = world.get_entity(root) else {
            return;
        };
        let Some(&settings) = entity.get::<ClusterProxy>() else {
            return;
        };
        let block = Block::below(entity, world);
        let State::Waiting { parts } = &mut self.state else {
            return;
        };
        let is_settled = std::mem::replace(parts, block.parts.len()) == block.parts.len();
        if !is_settled || !block.is_loaded || block.parts.is_empty() {
            return;
        }
        let (groups, dressings) = grouped(&block, world);
        self.state = State::Making {
            job: Job::start(move |progress| make(&groups, &settings, progress).transpose()),
            dressings,
            children: block.children,
        };
    }

    /// Puts up what was made.
    fn finish(&mut self, root: Entity, made: Result<Vec<Proxy>, SimplifyError>, world: &mut World) {
        let State::Making {
            dressings, children, ..
        } = std::mem::take(&mut self.state)
        else {
            return;
        };
        let made = match made {
            Ok(made) => made,
            Err(error) => {
                self.state = State::Failed;
                warn!("there is no proxy for the block {root}: {error}");
                world.trigger(ProxyFailed { entity: root, error });
                return;
            }
        };
        self.state = State::Ready;
        let Some(settings) = world.get::<ClusterProxy>(root).copied() else {
            return;
        };
        let error = made
            .iter()
            .map(|proxy| proxy.error.max(proxy.least))
            .fold(0.0, f32::max);
        for (Proxy { mesh, .. }, dressing) in made.into_iter().zip(dressings) {
            let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
            let mut proxy = world.spawn((Mesh3d(mesh), Transform::IDENTITY, Visibility::Inherited, ChildOf(root)));
            for dress in dressing {
                dress(&mut proxy);
            }
            self.proxies.push(proxy.id());
        }
        let children: Vec<Entity> = children
            .into_iter()
            .filter(|&child| world.get_entity(child).is_ok())
            .collect();
        let group = ProxyLod::new(LodMetric::PixelError(settings.pixels), children).then(error, self.proxies.clone());
        let group = filled(world.get::<ProxyLod>(root), group);
        world.entity_mut(root).insert(group);
        world.trigger(ProxyReady {
            entity: root,
            levels: 2,
        });
    }
}

/// The parts by their materials, and what the proxies of each get.
fn grouped(block: &Block, world: &World) -> (Vec<Parts>, Vec<Vec<Dressing>>) {
    let (materials, assets) = (world.resource::<ClusterMaterials>(), world.resource::<Assets<Mesh>>());
    let mut copies = HashMap::<AssetId<Mesh>, Arc<Mesh>>::default();
    let (mut groups, mut dressings) = (Vec::<(Entity, Parts)>::new(), Vec::new());
    for part in &block.parts {
        let Some(mesh) = assets.get(part.mesh) else {
            continue;
        };
        let mesh = Arc::clone(copies.entry(part.mesh).or_insert_with(|| Arc::new(mesh.clone())));
        let entity = world.entity(part.entity);
        let same = groups
            .iter_mut()
            .find(|(first, _)| materials.are_same(world.entity(*first), entity));
        match same {
            Some((_, parts)) => parts.push((mesh, part.place)),
            None => {
                groups.push((part.entity, vec![(mesh, part.place)]));
                dressings.push(materials.copies(entity));
            }
        }
    }
    (groups.into_iter().map(|(_, parts)| parts).collect(), dressings)
}

/// Merges and simplifies; nothing if it was called off.
fn make(
    groups: &[Parts],
    settings: &ClusterProxy,
    progress: &BuildProgress,
) -> Result<Option<Vec<Proxy>>, SimplifyError> {
    let mut made = Vec::with_capacity(groups.len());
    for (number, parts) in groups.iter().enumerate() {
        let merged = merge_meshes(parts.iter().map(|(mesh, place)| (&**mesh, *place)))?;
        if progress.is_cancelled() {
            return Ok(None);
        }
        let simplifier = Simplifier::new(&merged)?;
        let Some(simple) = simplifier.simplify_with(settings.target, settings.lock_borders, Some(progress))? else {
            return Ok(None);
        };
        made.push(Proxy {
            error: simple.deviation.at_most,
            least: simplifier.extent() * f32::EPSILON,
            mesh: simple.mesh,
        });
        progress.reach((number + 1) as f32 / groups.len() as f32);
    }
    Ok(Some(made))
}
