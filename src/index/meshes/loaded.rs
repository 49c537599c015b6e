//! The triangles of a mesh that is loaded, and the hierarchy over them.

use std::{ops::Deref, sync::Arc};

use super::build::Build;
use crate::{
    index::{MeshSettings, triangles::TrianglesRef},
    mesh::{MeshBvh, MeshEdit, TriangleMesh},
    spatial::BuildStrategy,
};

/// How a hierarchy is built that rays wait for, or that is soon worn again.
const IN_HASTE: BuildStrategy = BuildStrategy::Ploc;
/// How a hierarchy is built of a mesh that stays as it is, beside the use of another.
const AT_LEISURE: BuildStrategy = BuildStrategy::Reinsertion;

/// The triangles of a mesh as it is now, with the hierarchy over them if there is one. Shared with what is being built.
#[derive(Clone, Debug)]
pub(in crate::index) enum Triangles {
    Bare(Arc<TriangleMesh>),
    Built(Arc<MeshBvh>),
}

impl Triangles {
    pub fn as_ref(&self) -> TrianglesRef<'_> {
        match self {
            Self::Bare(mesh) => TrianglesRef::Listed(mesh),
            Self::Built(bvh) => TrianglesRef::Hierarchy(bvh),
        }
    }
}

impl Deref for Triangles {
    type Target = TriangleMesh;

    #[inline]
    fn deref(&self) -> &TriangleMesh {
        match self {
            Self::Bare(mesh) => mesh,
            Self::Built(bvh) => bvh.mesh(),
        }
    }
}

/// A mesh that is loaded.
#[derive(Debug)]
pub(in crate::index) struct Loaded {
    pub triangles: Triangles,
    /// The next hierarchy: of the same triangles, with their vertices where they are or where they were.
    build: Option<Build>,
    /// What the hierarchy cost when it was built.
    cost_when_built: f64,
    /// Whether hierarchies are built to take little memory.
    compact: bool,
    /// Whether the vertices have been edited: who is edited once is edited again.
    is_edited: bool,
}

impl Loaded {
    pub fn new(mesh: TriangleMesh, compact: bool) -> Self {
        Self {
            compact,
            triangles: Triangles::Bare(Arc::new(mesh)),
            build: None,
            cost_when_built: 0.0,
            is_edited: false,
        }
    }

    /// From now on hierarchies are built to take little memory, or not.
    pub fn set_compact(&mut self, compact: bool) {
        self.compact = compact;
    }

    /// What rays are tested against is a hierarchy.
    pub fn has_hierarchy(&self) -> bool {
        matches!(self.triangles, Triangles::Built(_))
    }

    /// How much of the next hierarchy is done, if one is being built.
    pub fn progress(&self) -> Option<f32> {
        self.build.as_ref().map(Build::fraction)
    }

    /// Begins to build a hierarchy, if there is none and none on its way: in haste, for rays test all triangles until it
    /// is there.
    pub fn build(&mut self) {
        if let (Triangles::Bare(mesh), None) = (&self.triangles, &self.build) {
            self.build = Some(Build::start(Triangles::Bare(Arc::clone(mesh)), IN_HASTE, self.compact));
        }
    }

    /// Takes over the triangles of the mesh after an edit; returns what has changed.
    ///
    /// Where its vertices have but moved, the hierarchy follows them at once, and is built anew beside its use when it
    /// costs [`rebuild_factor`](MeshSettings::rebuild_factor) times what it cost when it was built. A build that is under
    /// way goes on, for its result can follow too: a mesh that is edited every frame gets its hierarchy in the end.
    pub fn edit(&mut self, edited: TriangleMesh, settings: MeshSettings) -> MeshEdit {
        let edit = self.triangles.edit_to(&edited);
        if edit == MeshEdit::Topology {
            *self = Self::new(edited, settings.compact);
            self.is_edited = true;
            return edit;
        }
        self.is_edited |= edit == MeshEdit::Positions;
        if let Some(build) = &mut self.build {
            build.is_outdated = true;
        }
        match &mut self.triangles {
            Triangles::Bare(mesh) => *mesh = Arc::new(edited),
            Triangles::Built(bvh) => {
                let bvh = Arc::make_mut(bvh);
                bvh.take_vertices_of(&edited, edit);
                let is_worn = edit == MeshEdit::Positions
                    && bvh.sah_cost() > self.cost_when_built * f64::from(settings.rebuild_factor);
                if is_worn && self.build.is_none() {
                    self.build = Some(Build::start(Triangles::Bare(Arc::new(edited)), IN_HASTE, self.compact));
                }
            }
        }
        edit
    }

    /// Takes over the hierarchy that was being built, if it is done; returns whether it was. The first one of a mesh that
    /// nobody edits is followed by a better one.
    pub fn collect_built(&mut self) -> bool {
        let Some(mut bvh) = self.build.as_mut().and_then(Build::take_built) else {
            return false;
        };
        self.cost_when_built = bvh.sah_cost();
        if self.build.take().is_some_and(|build| build.is_outdated) {
            bvh.take_vertices_of(&self.triangles, MeshEdit::Positions);
        }
        let is_first = !self.has_hierarchy();
        self.triangles = Triangles::Built(Arc::new(bvh));
        if is_first && !self.is_edited {
            self.build = Some(Build::start(self.triangles.clone(), AT_LEISURE, self.compact));
        }
        true
    }

    /// The triangles without their hierarchy, and without any that is being built.
    pub fn without_hierarchy(self) -> Self {
        Self {
            triangles: match self.triangles {
                Triangles::Built(bvh) => Triangles::Bare(Arc::new(Arc::unwrap_or_clone(bvh).into_mesh())),
                bare => bare,
            },
            build: None,
            cost_when_built: 0.0,
            ..self
        }
    }

    /// The size of the triangles and the hierarchy, in bytes.
    pub fn memory(&self) -> usize {
        match &self.triangles {
            Triangles::Bare(mesh) => mesh.memory(),
            Triangles::Built(bvh) => bvh.memory(),
        }
    }
}
