//! The bounding volumes of one mesh.

use bevy::{
    math::Vec3A,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};
use smallvec::SmallVec;

use super::Triangles;
use crate::{
    geometry::{
        surface::VolumeSurface,
        volume::{AnyVolume, BoundingKind},
    },
    mesh::TriangleMesh,
};

/// What a volume is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::index) enum Role {
    /// Rays are tested against it before the triangles are: it has the slack that their test needs, and as a hull few
    /// corners.
    Guard,
    /// Rays hit it in place of the triangles: it is as tight as its kind can be.
    Surface,
}

/// The bounding volumes that entities have asked for of one mesh, one of each kind and role.
#[derive(Debug, Default)]
pub(in crate::index) struct Volumes(SmallVec<[(Role, BoundingKind, State); 1]>);

#[derive(Debug)]
enum State {
    /// There are no triangles to bound.
    Waiting,
    Building {
        task: Task<Option<VolumeSurface>>,
        /// Whether the triangles have changed since it began.
        is_outdated: bool,
    },
    /// `None` if the volume would overflow.
    Ready(Option<VolumeSurface>),
}

impl Volumes {
    pub fn kinds(&self) -> impl Iterator<Item = BoundingKind> + '_ {
        self.0.iter().map(|&(_, kind, _)| kind)
    }

    /// The volume, as far as it is built.
    #[inline]
    pub fn get(&self, role: Role, kind: BoundingKind) -> Option<&VolumeSurface> {
        let mut all = self.0.iter();
        match all.find(|(its_role, its_kind, _)| (*its_role, *its_kind) == (role, kind)) {
            Some((_, _, State::Ready(volume))) => volume.as_ref(),
            _ => None,
        }
    }

    /// Has a volume built, unless it is known.
    pub fn request(&mut self, role: Role, kind: BoundingKind, triangles: Option<&Triangles>) {
        if !self
            .0
            .iter()
            .any(|&(its_role, its_kind, _)| (its_role, its_kind) == (role, kind))
        {
            self.0.push((role, kind, State::of(role, kind, triangles)));
        }
    }

    /// Forgets the volumes, and has them built for other triangles.
    pub fn rebuild(&mut self, triangles: Option<&Triangles>) {
        for (role, kind, state) in &mut self.0 {
            match state {
                // One at a time, however often the mesh is edited: a volume that is half built cannot be called back.
                State::Building { is_outdated, .. } if triangles.is_some() => *is_outdated = true,
                _ => *state = State::of(*role, *kind, triangles),
            }
        }
    }

    /// Takes over what has been built; returns whether that is a surface which rays hit.
    pub fn collect_built(&mut self, triangles: Option<&Triangles>) -> bool {
        let mut has_surface = false;
        for (role, kind, state) in &mut self.0 {
            if let State::Building { task, is_outdated } = state
                && let Some(built) = check_ready(task)
            {
                if *is_outdated {
                    *state = State::of(*role, *kind, triangles);
                } else {
                    has_surface |= *role == Role::Surface;
                    *state = State::Ready(built);
                }
            }
        }
        has_surface
    }

    pub fn is_building(&self) -> bool {
        let mut all = self.0.iter();
        all.any(|(_, _, state)| matches!(state, State::Building { .. }))
    }
}

impl State {
    fn of(role: Role, kind: BoundingKind, triangles: Option<&Triangles>) -> Self {
        let Some(triangles) = triangles else {
            return Self::Waiting;
        };
        if (role, kind) == (Role::Surface, BoundingKind::Aabb) {
            return Self::Ready(Some(VolumeSurface::new(AnyVolume::Aabb(triangles.aabb()))));
        }
        let build = move |mesh: &TriangleMesh| {
            let volume = match role {
                Role::Guard => mesh.bounding_volume(kind),
                Role::Surface => kind.enclosing(mesh.corners_of_all().flatten().map(Vec3A::from)).ok(),
            };
            volume.map(VolumeSurface::new)
        };
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
        let triangles = triangles.clone();
        Self::Building {
            task: pool.spawn(async move { build(&triangles) }),
            is_outdated: false,
        }
    }
}
