//! Meshes that are loaded when a level comes near, and dropped when it has been far for long.

use std::time::Duration;

use bevy::{
    asset::{AssetPath, AssetServer, Assets, Handle, LoadState},
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        reflect::ReflectResource,
        resource::Resource,
    },
    mesh::{Indices, Mesh},
    platform::collections::HashMap,
    reflect::{Reflect, std_traits::ReflectDefault},
    time::Time,
};
use tracing::warn;

use super::{
    LodChoices, LodStats,
    groups::{Contents, GroupId, MeshLevel},
    place::Change,
};
use crate::phase::phase;

/// So many groups are looked at in a frame, in turn.
const GROUPS_PER_FRAME: usize = 1024;

/// How the meshes of [`LodContent::Streamed`](super::LodContent::Streamed) levels are loaded and dropped.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct LodStreamingSettings {
    /// How many bytes of vertices and indices may be loaded. What was needed longest ago is dropped first; what is shown
    /// stays, whatever it takes, and as long as there is no room nothing else is loaded.
    pub memory_budget: usize,
    /// A level is loaded from so many times its distance on, at both ends: at least 1.
    pub margin: f32,
    /// A mesh is dropped when it has not been near for so long, in the time of [`Time`].
    pub unload_after: Duration,
}

impl Default for LodStreamingSettings {
    fn default() -> Self {
        Self {
            memory_budget: 512 << 20,
            margin: 1.25,
            unload_after: Duration::from_secs(10),
        }
    }
}

/// The meshes that levels name by their paths.
#[derive(Resource, Debug, Default)]
pub(super) struct StreamedMeshes {
    meshes: HashMap<AssetPath<'static>, Streamed>,
    /// The groups that have such levels, as of these changes.
    pub groups: Vec<GroupId>,
    known: u64,
    /// Whose turn it is, and how often it was that of the first: in each round, all groups are looked at.
    next: usize,
    round: u64,
}

/// What streaming has loaded.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct LodStreamingStats {
    /// Meshes that are loaded.
    pub loaded: usize,
    /// Meshes that are being loaded.
    pub loading: usize,
    /// Meshes that could not be loaded.
    pub failed: usize,
    /// Bytes of vertices and indices of those that are loaded.
    pub memory: usize,
}

#[derive(Debug)]
struct Streamed {
    /// As long as it is to be kept.
    handle: Option<Handle<Mesh>>,
    is_loaded: bool,
    has_failed: bool,
    /// Its bytes, if it was ever loaded.
    size: usize,
    /// When it was last near, and when it was last asked for, in seconds.
    near_at: f64,
    wanted_at: f64,
    /// The round in which it was last shown.
    shown_in: Option<u64>,
    users: Vec<GroupId>,
}

impl Streamed {
    const NEW: Self = Self {
        handle: None,
        is_loaded: false,
        has_failed: false,
        size: 0,
        near_at: f64::NEG_INFINITY,
        wanted_at: f64::NEG_INFINITY,
        shown_in: None,
        users: Vec::new(),
    };

    /// Its bytes, if it is loaded.
    fn memory(&self) -> usize {
        if self.is_loaded { self.size } else { 0 }
    }

    fn unload(&mut self, changed: &mut Vec<GroupId>) {
        (self.handle, self.is_loaded) = (None, false);
        changed.extend(&self.users);
    }

    /// Whether it is shown, or was in the last round.
    fn is_shown(&self, round: u64) -> bool {
        self.shown_in.is_some_and(|shown| shown + 1 >= round)
    }
}

impl StreamedMeshes {
    /// A mesh that is loaded.
    pub fn loaded(&self, path: &AssetPath<'static>) -> Option<&Handle<Mesh>> {
        let mesh = self.meshes.get(path)?;
        mesh.handle.as_ref().filter(|_| mesh.is_loaded)
    }

    /// Begins anew with these groups.
    pub fn follow(&mut self, choices: &LodChoices) {
        self.known = choices.streaming_changes;
        self.groups.clear();
        self.meshes.values_mut().for_each(|mesh| mesh.users.clear());
        for id in choices.groups.ids() {
            let Some(Contents::Meshes(levels)) = choices.groups.get(id).map(|group| &group.contents) else {
                continue;
            };
            let mut streams = false;
            for level in levels {
                if let MeshLevel::Streamed(path) = level {
                    streams = true;
                    let mesh = self.meshes.entry(path.clone()).or_insert(Streamed::NEW);
                    mesh.users.push(id);
                }
            }
            if streams {
                self.groups.push(id);
            }
        }
        self.meshes.retain(|_, mesh| !mesh.users.is_empty());
    }

    /// Finds out what is near, of a part of the groups in each frame.
    fn look_around(&mut self, choices: &LodChoices, margin: f32, now: f64) {
        for _ in 0..self.groups.len().min(GROUPS_PER_FRAME) {
            self.next = (self.next + 1) % self.groups.len();
            self.round += u64::from(self.next == 0);
            let id = self.groups[self.next];
            let Some((group, levels)) = choices.groups.get(id).and_then(|group| match &group.contents {
                Contents::Meshes(levels) => Some((group, levels)),
                Contents::Entities(_) => None,
            }) else {
                continue;
            };
            let reaches = &choices.groups.reaches[id as usize];
            let view = choices.main_levels();
            let near = view.map_or(u8::MAX, |view| view.near(reaches, margin));
            let wanted = view.and_then(|view| view.wanted(id));
            // Something has to be shown, whatever it takes.
            let is_bare = levels.iter().all(|level| match level {
                MeshLevel::Streamed(path) => self.loaded(path).is_none(),
                MeshLevel::Mesh(_) => false,
                MeshLevel::Nothing => true,
            });
            for (number, level) in (0..).zip(levels) {
                let MeshLevel::Streamed(path) = level else {
                    continue;
                };
                let Some(mesh) = self.meshes.get_mut(path) else {
                    continue;
                };
                let is_shown = group.applied == Some(number) || is_bare && wanted == Some(number);
                if is_shown {
                    mesh.shown_in = Some(self.round);
                }
                if near >> number & 1 == 1 || is_shown {
                    mesh.near_at = now;
                }
                if wanted == Some(number) {
                    mesh.wanted_at = now;
                }
            }
        }
    }

    /// Takes in what has been loaded, and what could not be. The groups that this changes are added to `changed`.
    fn take_in(
        &mut self,
        server: &AssetServer,
        assets: &Assets<Mesh>,
        choices: &LodChoices,
        changed: &mut Vec<GroupId>,
    ) {
        for (path, mesh) in self.meshes.iter_mut().filter(|(_, mesh)| !mesh.is_loaded) {
            let Some(handle) = &mesh.handle else {
                continue;
            };
            if let Some(asset) = assets.get(handle) {
                (mesh.is_loaded, mesh.size) = (true, size_of_mesh(asset));
                changed.extend(&mesh.users);
            } else if let LoadState::Failed(error) = server.load_state(handle) {
                let user = mesh.users.first().and_then(|&id| choices.groups.get(id));
                let of_user = user.map_or(String::new(), |user| format!(" of {}", user.root));
                warn!("a level of detail{of_user} cannot be loaded from {path}, and others stand in for it: {error}");
                (mesh.handle, mesh.has_failed) = (None, true);
            }
        }
    }

    /// Drops what was last near before some time.
    fn drop_far(&mut self, before: f64, changed: &mut Vec<GroupId>) {
        let round = self.round;
        let far = self
            .meshes
            .values_mut()
            .filter(|mesh| mesh.near_at < before && !mesh.is_shown(round));
        for mesh in far.filter(|mesh| mesh.handle.is_some()) {
            mesh.unload(changed);
        }
    }

    /// Drops what was needed longest ago, until the rest fits.
    fn make_room(&mut self, budget: usize, changed: &mut Vec<GroupId>) {
        let round = self.round;
        let mut memory: usize = self.meshes.values().map(Streamed::memory).sum();
        while memory > budget {
            let droppable = self
                .meshes
                .values_mut()
                .filter(|mesh| mesh.is_loaded && !mesh.is_shown(round));
            let by_need = |a: &&mut Streamed, b: &&mut Streamed| {
                (a.wanted_at.total_cmp(&b.wanted_at)).then(a.near_at.total_cmp(&b.near_at))
            };
            let Some(least) = droppable.min_by(by_need) else {
                break;
            };
            memory -= least.memory();
            least.unload(changed);
        }
    }

    /// Begins to load what is near now, as far as there is room; what is asked for may take that of what is not shown.
    fn load_near(&mut self, budget: usize, now: f64, server: &AssetServer) {
        let round = self.round;
        let kept = |mesh: &&Streamed| mesh.handle.is_some();
        let mut memory: usize = self.meshes.values().filter(kept).map(|mesh| mesh.size).sum();
        let shown = self.meshes.values().filter(kept).filter(|mesh| mesh.is_shown(round));
        let mut shown: usize = shown.map(|mesh| mesh.size).sum();
        let near = self.meshes.iter_mut().filter(|(_, mesh)| mesh.near_at == now);
        for (path, mesh) in near.filter(|(_, mesh)| mesh.handle.is_none() && !mesh.has_failed) {
            let is_wanted = mesh.wanted_at == now;
            if mesh.is_shown(round) || memory + mesh.size < budget || is_wanted && shown + mesh.size < budget {
                mesh.handle = Some(server.load(path.clone()));
                memory += mesh.size;
                shown += if is_wanted { mesh.size } else { 0 };
            }
        }
    }

    fn stats(&self) -> LodStreamingStats {
        self.meshes
            .values()
            .fold(LodStreamingStats::default(), |stats, mesh| LodStreamingStats {
                loaded: stats.loaded + usize::from(mesh.is_loaded),
                loading: stats.loading + usize::from(mesh.handle.is_some() && !mesh.is_loaded),
                failed: stats.failed + usize::from(mesh.has_failed),
                memory: stats.memory + mesh.memory(),
            })
    }
}

/// Whether anything is streamed, or was until now.
pub(super) fn streams(meshes: Res<StreamedMeshes>, choices: Res<LodChoices>) -> bool {
    !meshes.meshes.is_empty() || meshes.known != choices.streaming_changes
}

/// Loads what has come near, and drops what has been far for long.
pub(super) fn stream_meshes(
    settings: Res<LodStreamingSettings>,
    server: Option<Res<AssetServer>>,
    assets: Option<Res<Assets<Mesh>>>,
    time: Option<Res<Time>>,
    mut choices: ResMut<LodChoices>,
    mut meshes: ResMut<StreamedMeshes>,
    mut stats: ResMut<LodStreamingStats>,
    mut lod_stats: ResMut<LodStats>,
) {
    let _phase = phase!("sightline/lod/choose").adds_to(&mut lod_stats.choose);
    let choices = choices.bypass_change_detection();
    let meshes = meshes.bypass_change_detection();
    if meshes.known != choices.streaming_changes {
        meshes.follow(choices);
    }
    let (Some(server), Some(assets)) = (server, assets) else {
        return;
    };
    if meshes.meshes.is_empty() {
        stats.set_if_neq(LodStreamingStats::default());
        return;
    }
    let now = time.map_or(0.0, |time| time.elapsed_secs_f64());

    meshes.look_around(choices, settings.margin.max(1.0), now);
    let mut changed = Vec::new();
    meshes.take_in(&server, &assets, choices, &mut changed);
    meshes.drop_far(now - settings.unload_after.as_secs_f64(), &mut changed);
    meshes.make_room(settings.memory_budget, &mut changed);
    meshes.load_near(settings.memory_budget, now, &server);
    for id in changed {
        choices.pending.note(id, Change::Resized);
    }
    stats.set_if_neq(meshes.stats());
}

/// The bytes of the vertices and indices of a mesh.
fn size_of_mesh(mesh: &Mesh) -> usize {
    let indices = mesh.indices().map_or(0, |indices| match indices {
        Indices::U16(indices) => 2 * indices.len(),
        Indices::U32(indices) => 4 * indices.len(),
    });
    mesh.get_vertex_buffer_size() + indices
}
