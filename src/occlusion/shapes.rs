//! The shapes that are made of mesh assets: one for all instances.

use std::{ops::Deref, sync::Arc};

use bevy::{
    asset::{AssetId, Assets},
    ecs::entity::{Entity, EntityHashSet},
    mesh::Mesh,
    platform::collections::HashMap,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};

use super::{OccluderRefusal, OccluderShape};
use crate::{
    index::MeshBvhs,
    mesh::{InnerBoxSettings, InnerBoxes, TriangleMesh},
    raster::OccluderMesh,
    spatial::BuildProgress,
};

/// What is made of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Form {
    Boxes,
    Triangles,
}

impl Form {
    const ALL: [Self; 2] = [Self::Boxes, Self::Triangles];
}

/// Which shape.
pub(super) type ShapeKey = (AssetId<Mesh>, Form);

/// What shapes are made of.
pub(super) struct Sources<'a> {
    /// Has copies, also of what only the GPU has by now.
    pub bvhs: &'a MeshBvhs,
    /// Whether those copies are of this frame; if not, they may be of before an edit.
    pub is_current: bool,
    pub assets: Option<&'a Assets<Mesh>>,
}

/// The shapes of all meshes that some entity occludes by, or has occluded by.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    slots: HashMap<ShapeKey, Slot>,
    /// The shapes that are being made.
    making: Vec<ShapeKey>,
    inner: InnerBoxSettings,
}

/// A shape, and who uses it.
#[derive(Debug, Default)]
struct Slot {
    users: EntityHashSet,
    state: State,
    /// Whether it was said that there is none.
    warned: bool,
}

#[derive(Debug, Default)]
enum State {
    /// The asset is not loaded, or gone.
    #[default]
    Missing,
    Making(Making),
    Done(Result<OccluderShape, OccluderRefusal>),
}

/// A shape that is being made; called off when it is dropped.
#[derive(Debug)]
struct Making {
    task: Task<Option<Result<OccluderShape, OccluderRefusal>>>,
    progress: Arc<BuildProgress>,
}

/// Dropping the task ends one that has not begun; one that runs has to be told.
impl Drop for Making {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

impl Shapes {
    /// The shape for a user; none if it is not there yet. Begins to make it for the first.
    pub fn acquire(
        &mut self,
        key: ShapeKey,
        user: Entity,
        sources: &Sources,
    ) -> Option<Result<OccluderShape, OccluderRefusal>> {
        let slot = self.slots.entry(key).or_default();
        slot.users.insert(user);
        if matches!(slot.state, State::Missing) {
            slot.make(key, sources, self.inner);
            if matches!(slot.state, State::Making(_)) {
                self.making.push(key);
            }
        }
        match &slot.state {
            State::Done(done) => Some(done.clone()),
            State::Missing | State::Making(_) => None,
        }
    }

    /// Whether it is still to be said that there is no such shape; it counts as said now.
    pub fn begin_warning(&mut self, key: ShapeKey) -> bool {
        let slot = self.slots.get_mut(&key);
        slot.is_some_and(|slot| !std::mem::replace(&mut slot.warned, true))
    }

    /// Takes a user off a shape, which is kept as long as its mesh.
    pub fn release(&mut self, key: ShapeKey, user: Entity) {
        if let Some(slot) = self.slots.get_mut(&key) {
            slot.users.remove(&user);
            if slot.users.is_empty() && matches!(slot.state, State::Missing) {
                self.slots.remove(&key);
            }
        }
    }

    /// Follows a mesh that was added, modified or removed; its users are to be looked at.
    pub fn follow_mesh(&mut self, mesh: AssetId<Mesh>, dirty: &mut Vec<Entity>) {
        for form in Form::ALL {
            self.forget((mesh, form), dirty);
        }
    }

    /// How boxes are looked for from now on: all are found anew if that is new.
    pub fn set_inner(&mut self, inner: InnerBoxSettings, dirty: &mut Vec<Entity>) {
        if self.inner == inner {
            return;
        }
        self.inner = inner;
        let all: Vec<ShapeKey> = self.slots.keys().copied().collect();
        for key in all.into_iter().filter(|&(_, form)| form == Form::Boxes) {
            self.forget(key, dirty);
        }
    }

    /// Any mesh may have changed.
    pub fn forget_all(&mut self, dirty: &mut Vec<Entity>) {
        let all: Vec<ShapeKey> = self.slots.keys().copied().collect();
        all.into_iter().for_each(|key| self.forget(key, dirty));
    }

    fn forget(&mut self, key: ShapeKey, dirty: &mut Vec<Entity>) {
        if let Some(slot) = self.slots.get_mut(&key) {
            dirty.extend(&slot.users);
            slot.state = State::Missing;
            if slot.users.is_empty() {
                self.slots.remove(&key);
            }
        }
    }

    /// Takes over what has been made; the users are to be looked at.
    pub fn collect_made(&mut self, dirty: &mut Vec<Entity>) {
        let Self { slots, making, .. } = self;
        making.retain(|key| {
            let Some(slot) = slots.get_mut(key) else {
                return false;
            };
            let State::Making(of_slot) = &mut slot.state else {
                return false;
            };
            let Some(made) = check_ready(&mut of_slot.task) else {
                return true;
            };
            slot.state = State::Done(made.expect("only what is dropped is called off"));
            dirty.extend(&slot.users);
            false
        });
    }

    /// How many shapes are being made.
    pub fn making(&self) -> usize {
        self.making.len()
    }
}

impl Slot {
    fn make(&mut self, (mesh, form): ShapeKey, sources: &Sources, inner: InnerBoxSettings) {
        let shared = sources.bvhs.shared_triangles(mesh);
        let from_asset = || sources.assets?.get(mesh).map(TriangleMesh::from_mesh);
        self.state = match (shared, from_asset) {
            (Some(triangles), _) if sources.is_current => State::Making(Making::start(triangles, form, inner)),
            (shared, from_asset) => match (from_asset(), shared) {
                (Some(Ok(triangles)), _) => State::Making(Making::start(Arc::new(triangles), form, inner)),
                (_, Some(triangles)) => State::Making(Making::start(triangles, form, inner)),
                (Some(Err(why)), None) => State::Done(Err(OccluderRefusal::Unusable(why))),
                (None, None) => State::Missing,
            },
        };
    }
}

impl Making {
    fn start(
        triangles: impl Deref<Target = TriangleMesh> + Send + 'static,
        form: Form,
        inner: InnerBoxSettings,
    ) -> Self {
        let progress = Arc::new(BuildProgress::default());
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn({
            let progress = Arc::clone(&progress);
            async move {
                match form {
                    Form::Boxes => {
                        let found = InnerBoxes::find_with(&triangles, &inner, Some(&progress))?;
                        let found = found.map(|found| OccluderShape::Boxes(found.boxes.into()));
                        Some(found.map_err(OccluderRefusal::NotSolid))
                    }
                    Form::Triangles => Some(Ok(OccluderShape::Mesh(Arc::new(occluder_mesh(&triangles))))),
                }
            }
        });
        Self { task, progress }
    }
}

/// The triangles of a mesh, as they are drawn.
fn occluder_mesh(mesh: &TriangleMesh) -> OccluderMesh {
    let positions: Vec<_> = mesh.corners_of_all().flatten().collect();
    let numbers = (0..positions.len() as u32 / 3).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner));
    OccluderMesh::new(&positions, &numbers.collect::<Vec<_>>())
}
