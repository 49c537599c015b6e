//! What must hold of a hierarchy between any two calls.

use bevy::math::bounding::Aabb3d;

use super::{
    MeshBvh,
    bvh::{LEAF_SIZE, unpack_slots},
};
use crate::spatial::wide::{Child, LANES, WideNode};

/// An invariant of a [`MeshBvh`] that does not hold: a bug in this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrokenMeshBvh {
    /// There is no root.
    #[error("there are triangles and no root")]
    NoRoot,
    /// The children of a node are not in its first lanes, or an empty lane is not empty.
    #[error("the lanes of node {0} are not in order")]
    Lanes(u32),
    /// A node has fewer than two children and is not a root with a leaf.
    #[error("node {0} has too few children")]
    ThinNode(u32),
    /// A child does not come after its parent, or is not there.
    #[error("a child of node {0} does not come after it, or is not there")]
    ChildBeforeParent(u32),
    /// A node has no parent, or several.
    #[error("node {0} is not held exactly once")]
    NotHeldOnce(u32),
    /// A leaf has no triangles, more than it may, or some that are not there.
    #[error("a leaf of node {0} has no triangles, too many, or some that are not there")]
    Leaf(u32),
    /// A triangle is in no leaf, or in several.
    #[error("the triangle in slot {0} is not in exactly one leaf")]
    NotInOneLeaf(u32),
    /// Two triangles have the same number.
    #[error("the triangle in slot {0} has the number of another")]
    SharedNumber(u32),
    /// There are fewer triangles in the leaves than in the mesh, or more.
    #[error("there are {leaves} triangles in the leaves and {mesh} in the mesh")]
    Count {
        /// In the leaves.
        leaves: usize,
        /// In the mesh.
        mesh: usize,
    },
    /// A box does not contain what is below it.
    #[error("a box of node {0} does not contain what is below it")]
    LooseBox(u32),
}

impl MeshBvh {
    /// Checks every invariant, in O(n log n).
    ///
    /// # Errors
    ///
    /// The first invariant that does not hold.
    pub fn validate(&self) -> Result<(), BrokenMeshBvh> {
        let (nodes, triangles) = (self.nodes(), self.mesh().len());
        if nodes.is_empty() && triangles > 0 {
            return Err(BrokenMeshBvh::NoRoot);
        }
        let mut node_held = vec![false; nodes.len()];
        let end = self.mesh().slots().last().map_or(0, |last| last as usize + 1);
        let mut slot_held = vec![true; end];
        for slot in self.mesh().slots() {
            slot_held[slot as usize] = false;
        }
        for (index, node) in (0..).zip(nodes) {
            if (node_held[index as usize]) != (index > 0) {
                return Err(BrokenMeshBvh::NotHeldOnce(index));
            }
            validate_lanes(index, node)?;
            for (aabb, child) in node.lanes() {
                match child {
                    Child::Node(child) => self.validate_child(index, &aabb, child, &mut node_held)?,
                    Child::Leaf(leaf) => self.validate_leaf(index, &aabb, leaf, &mut slot_held)?,
                }
            }
        }
        if let Some(lost) = slot_held.iter().position(|held| !held) {
            return Err(BrokenMeshBvh::NotInOneLeaf(lost as u32));
        }
        let mut numbers: Vec<(u32, u32)> = self
            .mesh()
            .slots()
            .map(|slot| (self.mesh().number(slot), slot))
            .collect();
        numbers.sort_unstable();
        match numbers.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(BrokenMeshBvh::SharedNumber(pair[1].1)),
            None if numbers.len() != triangles => Err(BrokenMeshBvh::Count {
                leaves: numbers.len(),
                mesh: triangles,
            }),
            None => Ok(()),
        }
    }

    fn validate_child(&self, parent: u32, aabb: &Aabb3d, child: u32, held: &mut [bool]) -> Result<(), BrokenMeshBvh> {
        if child <= parent || child as usize >= held.len() {
            return Err(BrokenMeshBvh::ChildBeforeParent(parent));
        }
        if std::mem::replace(&mut held[child as usize], true) {
            return Err(BrokenMeshBvh::NotHeldOnce(child));
        }
        if contains(aabb, &self.nodes()[child as usize].bounds()) {
            Ok(())
        } else {
            Err(BrokenMeshBvh::LooseBox(parent))
        }
    }

    fn validate_leaf(&self, parent: u32, aabb: &Aabb3d, leaf: u32, held: &mut [bool]) -> Result<(), BrokenMeshBvh> {
        let slots = unpack_slots(leaf);
        if slots.is_empty() || slots.len() > LEAF_SIZE || slots.end as usize > held.len() {
            return Err(BrokenMeshBvh::Leaf(parent));
        }
        for slot in slots {
            if std::mem::replace(&mut held[slot as usize], true) {
                return Err(BrokenMeshBvh::NotInOneLeaf(slot));
            }
            if !contains(aabb, &self.mesh().triangle_box(slot)) {
                return Err(BrokenMeshBvh::LooseBox(parent));
            }
        }
        Ok(())
    }
}

fn validate_lanes(index: u32, node: &WideNode) -> Result<(), BrokenMeshBvh> {
    let used = node.len();
    let is_present = |lane: usize| node.children[lane].node().is_some() || node.children[lane].leaf().is_some();
    let is_empty =
        |lane: usize| node.masks[lane] == 0 && (0..3).all(|axis| node.min[axis][lane] > node.max[axis][lane]);
    if !(0..used).all(is_present) || !(used..LANES).all(is_empty) {
        return Err(BrokenMeshBvh::Lanes(index));
    }
    let is_root_with_leaf = || index == 0 && used == 1 && node.children[0].leaf().is_some();
    if used >= 2 || is_root_with_leaf() {
        Ok(())
    } else {
        Err(BrokenMeshBvh::ThinNode(index))
    }
}

/// Not if a bound is NaN.
fn contains(outer: &Aabb3d, inner: &Aabb3d) -> bool {
    outer.min.cmple(inner.min).all() && inner.max.cmple(outer.max).all()
}

#[cfg(test)]
mod tests {
    use bevy::{
        asset::RenderAssetUsages,
        math::Vec3,
        mesh::{Mesh, PrimitiveTopology},
    };

    use super::*;
    use crate::{
        geometry::aabb::EMPTY,
        mesh::{TriangleMesh, bvh::pack_leaf},
        spatial::wide::EVERY_MASK,
    };

    /// Four triangles in a row.
    fn mesh() -> TriangleMesh {
        let positions = (0..4).flat_map(|x| [Vec3::ZERO, Vec3::Y, Vec3::Z].map(|corner| corner + Vec3::X * x as f32));
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions.collect::<Vec<_>>());
        TriangleMesh::from_mesh(&mesh).expect("a usable mesh")
    }

    fn node(children: &[Child]) -> WideNode {
        let mut node = WideNode::EMPTY;
        for &child in children {
            node.push(&EMPTY, EVERY_MASK, child);
        }
        node
    }

    fn leaf(first: u32, count: u32) -> Child {
        Child::Leaf(pack_leaf(first, count))
    }

    fn hierarchy(nodes: &[WideNode]) -> MeshBvh {
        let mesh = mesh();
        let mut bvh = MeshBvh::pack(&mesh, &[0, 1, 2, 3], nodes, false);
        bvh.refit(&mesh.positions());
        bvh
    }

    fn verdict(nodes: Vec<WideNode>) -> Result<(), BrokenMeshBvh> {
        hierarchy(&nodes).validate()
    }

    #[test]
    fn trees_over_all_triangles_are_valid() {
        assert_eq!(verdict(vec![node(&[leaf(0, 4)])]), Ok(()));
        assert_eq!(verdict(vec![node(&[leaf(0, 1), leaf(1, 3)])]), Ok(()));
        let nodes = vec![
            node(&[Child::Node(2), Child::Node(1)]),
            node(&[leaf(0, 1), leaf(1, 1)]),
            node(&[leaf(2, 1), leaf(3, 1)]),
        ];
        assert_eq!(verdict(nodes), Ok(()));
    }

    #[test]
    fn trees_that_lack_or_repeat_something_are_not() {
        assert_eq!(verdict(vec![]), Err(BrokenMeshBvh::NoRoot));
        assert_eq!(verdict(vec![node(&[])]), Err(BrokenMeshBvh::ThinNode(0)));
        let too_few = BrokenMeshBvh::Count { leaves: 3, mesh: 4 };
        assert_eq!(verdict(vec![node(&[leaf(0, 3)])]), Err(too_few));
        assert_eq!(
            verdict(vec![node(&[leaf(0, 4), leaf(1, 1)])]),
            Err(BrokenMeshBvh::SharedNumber(8))
        );
        let lost = vec![node(&[leaf(0, 2), leaf(2, 2)]), node(&[leaf(0, 2), leaf(2, 2)])];
        assert_eq!(verdict(lost), Err(BrokenMeshBvh::NotHeldOnce(1)));
        let shared = vec![node(&[Child::Node(1), Child::Node(1)]), node(&[leaf(0, 2), leaf(2, 2)])];
        assert_eq!(verdict(shared), Err(BrokenMeshBvh::NotHeldOnce(1)));
        let thin = vec![node(&[Child::Node(1), leaf(3, 1)]), node(&[leaf(0, 3)])];
        assert_eq!(verdict(thin), Err(BrokenMeshBvh::ThinNode(1)));
        let cycle = vec![node(&[Child::Node(0), leaf(0, 4)])];
        assert_eq!(verdict(cycle), Err(BrokenMeshBvh::ChildBeforeParent(0)));
    }

    #[test]
    fn boxes_that_are_too_small_are_noticed() {
        let bvh = hierarchy(&[node(&[leaf(0, 2), leaf(2, 2)])]);
        let second = bvh.nodes()[0].children[1].leaf().expect("a leaf");
        let verdict = |aabb: Aabb3d| bvh.validate_leaf(0, &aabb, second, &mut [false; 16]);
        let Aabb3d { min, max } = bvh.nodes()[0].aabb(1);
        assert_eq!(verdict(Aabb3d { min, max }), Ok(()));
        let loose = Err(BrokenMeshBvh::LooseBox(0));
        assert_eq!(verdict(Aabb3d { min, max: max - 0.1 }), loose);
        assert_eq!(
            verdict(Aabb3d {
                min: min * f32::NAN,
                max
            }),
            loose
        );
    }

    #[test]
    fn leaves_with_what_is_in_another_or_not_there_are_noticed() {
        let bvh = hierarchy(&[node(&[leaf(0, 2), leaf(2, 2)])]);
        let aabb = bvh.nodes()[0].aabb(1);
        let second = bvh.nodes()[0].children[1].leaf().expect("a leaf");
        let repeated = bvh.validate_leaf(0, &aabb, second, &mut [true; 16]);
        assert_eq!(repeated, Err(BrokenMeshBvh::NotInOneLeaf(8)));
        let beyond = bvh.validate_leaf(0, &aabb, second, &mut [false; 9]);
        assert_eq!(beyond, Err(BrokenMeshBvh::Leaf(0)));
    }
}
