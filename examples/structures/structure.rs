//! The structures, each built of the same boxes.

use std::collections::HashSet;

use bevy::math::bounding::Aabb3d;
use bevy_sightline::{
    geometry::ray::Ray,
    spatial::{
        AabbTree, BruteForce, BuildStrategy, Descend, KdTree, Octree, SpatialQueries, SpatialUpdates, Trace,
        UniformGrid,
        kd_tree::SplitMethod,
        uniform_grid::{CellSize, GridSettings},
    },
};

/// No box is larger.
const SMALL_CELL: f32 = 5.5;

/// A structure, and how it is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Tree(BuildStrategy),
    /// With cells as large as it finds best, or small ones.
    Grid {
        small: bool,
    },
    KdTree(SplitMethod),
    Octree,
    List,
}

impl Kind {
    pub const ALL: [Self; 11] = [
        Self::Tree(BuildStrategy::MiddleSplit),
        Self::Tree(BuildStrategy::MedianSplit),
        Self::Tree(BuildStrategy::BinnedSah),
        Self::Tree(BuildStrategy::Ploc),
        Self::Tree(BuildStrategy::Reinsertion),
        Self::Grid { small: false },
        Self::Grid { small: true },
        Self::KdTree(SplitMethod::Median),
        Self::KdTree(SplitMethod::Sah),
        Self::Octree,
        Self::List,
    ];

    /// Those that the keys choose first.
    pub const MAIN: [Self; 5] = [
        Self::Tree(BuildStrategy::Ploc),
        Self::Grid { small: true },
        Self::KdTree(SplitMethod::Sah),
        Self::Octree,
        Self::List,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Tree(BuildStrategy::MiddleSplit) => "AABB tree, middle",
            Self::Tree(BuildStrategy::MedianSplit) => "AABB tree, median",
            Self::Tree(BuildStrategy::BinnedSah) => "AABB tree, SAH",
            Self::Tree(BuildStrategy::Ploc) => "AABB tree, PLOC",
            Self::Tree(BuildStrategy::Reinsertion) => "AABB tree, reinsert",
            Self::Grid { small: false } => "uniform grid, auto",
            Self::Grid { small: true } => "uniform grid, small",
            Self::KdTree(SplitMethod::Median) => "k-d tree, median",
            Self::KdTree(SplitMethod::Sah) => "k-d tree, SAH",
            Self::Octree => "octree",
            Self::List => "plain list",
        }
    }

    /// The same structure, built in the next way.
    pub fn next_strategy(self) -> Self {
        let same = |kind: &Self| std::mem::discriminant(kind) == std::mem::discriminant(&self);
        let (before, after): (Vec<Self>, Vec<Self>) = Self::ALL
            .into_iter()
            .filter(same)
            .partition(|kind| Self::place(*kind) <= Self::place(self));
        after.into_iter().chain(before).next().unwrap_or(self)
    }

    fn place(kind: Self) -> usize {
        Self::ALL.iter().position(|&other| other == kind).unwrap_or(0)
    }
}

/// Boxes by their numbers.
pub enum Structure {
    Tree(Box<AabbTree<u32>>),
    Grid(UniformGrid<u32>),
    KdTree(KdTree<u32>),
    Octree(Octree<u32>),
    List(BruteForce<u32>),
}

/// What a structure is, in figures.
pub struct Built {
    /// Nodes or cells.
    pub parts: usize,
    pub depth: usize,
    pub bytes: usize,
}

/// What a ray hits: the number of the box, and where.
pub type Hit = Option<(u32, f32)>;

impl Structure {
    pub fn new(kind: Kind, boxes: &[Aabb3d]) -> Self {
        let numbered = || (0..).zip(boxes.iter().copied());
        match kind {
            Kind::Tree(strategy) => {
                let mut tree = AabbTree::new();
                tree.insert_many(numbered());
                tree.rebuild_with(strategy);
                Self::Tree(Box::new(tree))
            }
            Kind::Grid { small } => {
                let cell_size = if small {
                    CellSize::Fixed(SMALL_CELL)
                } else {
                    CellSize::Auto
                };
                Self::Grid(filled(UniformGrid::new(GridSettings { cell_size }), numbered()))
            }
            Kind::KdTree(method) => Self::KdTree(KdTree::new(numbered(), method).expect("all boxes are sound")),
            Kind::Octree => Self::Octree(filled(Octree::new(), numbered())),
            Kind::List => Self::List(filled(BruteForce::new(), numbered())),
        }
    }

    /// The first box along a ray.
    pub fn closest(&self, ray: &Ray) -> Hit {
        match self {
            Self::Tree(tree) => tree.closest_box(ray),
            Self::Grid(grid) => grid.closest_box(ray),
            Self::KdTree(tree) => tree.closest_box(ray),
            Self::Octree(tree) => tree.closest_box(ray),
            Self::List(list) => list.closest_box(ray),
        }
    }

    /// The first box along a ray, and the way to it.
    pub fn trace(&self, ray: &Ray) -> (Hit, Trace<u32>) {
        match self {
            Self::Tree(tree) => tree.trace_closest_box(ray),
            Self::Grid(grid) => grid.trace_closest_box(ray),
            Self::KdTree(tree) => tree.trace_closest_box(ray),
            Self::Octree(tree) => tree.trace_closest_box(ray),
            Self::List(list) => list.trace_closest_box(ray),
        }
    }

    /// How it divides space: the boxes of nodes, or cells.
    pub fn parts(&self) -> Vec<Aabb3d> {
        let mut parts = Vec::new();
        match self {
            Self::Tree(tree) => tree.visit_nodes(|_, aabb| parts.push(*aabb)),
            Self::Grid(grid) => grid.visit_cells(|_, cube, _| parts.push(*cube)),
            Self::KdTree(tree) => tree.visit_cells(|depth, aabb, count| {
                if depth == 0 || count > 1 {
                    parts.push(*aabb);
                }
            }),
            Self::Octree(tree) => tree.visit_nodes(|node| {
                parts.push(node.cell);
                Descend::Into
            }),
            Self::List(list) => parts.extend(list.bounds()),
        }
        parts
    }

    pub fn built(&self) -> Built {
        let (depth, bytes) = match self {
            Self::Tree(tree) => (tree.depth(), tree.memory()),
            Self::Grid(grid) => (levels(grid), grid.memory()),
            Self::KdTree(tree) => (tree.depth(), tree.memory()),
            Self::Octree(tree) => (tree.depth(), tree.memory()),
            Self::List(list) => (1, list.memory()),
        };
        Built {
            parts: self.parts().len(),
            depth,
            bytes,
        }
    }
}

/// How many sizes of cells there are.
fn levels(grid: &UniformGrid<u32>) -> usize {
    let mut levels = HashSet::new();
    grid.visit_cells(|cell, _, _| {
        levels.insert(cell.level());
    });
    levels.len()
}

fn filled<T: SpatialUpdates<u32>>(mut structure: T, boxes: impl Iterator<Item = (u32, Aabb3d)>) -> T {
    structure.insert_many(boxes);
    structure
}
