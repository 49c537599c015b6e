//! The levels of a mesh.

use bevy::prelude::*;
use bevy_sightline::lod::simplify::{MeshChain, SimplifyError, SimplifyTarget};

fn ratios(ratios: &[f32]) -> Vec<SimplifyTarget> {
    ratios.iter().copied().map(SimplifyTarget::Ratio).collect()
}

#[test]
fn each_level_has_fewer_triangles_and_a_larger_error_than_the_one_before() {
    let mesh = Mesh::from(Torus::new(0.5, 1.0).mesh().major_resolution(64).minor_resolution(32));
    // In any order.
    let chain = MeshChain::build(&mesh, &ratios(&[0.1, 0.5, 0.02, 0.25]), false).expect("a usable mesh");
    assert_eq!(chain.levels.len(), 4);
    let mut before = (chain.triangles, 0.0);
    for level in &chain.levels {
        assert!(level.triangles < before.0 && level.deviation.at_most > before.1);
        before = (level.triangles, level.deviation.at_most);
    }
}

#[test]
fn a_level_that_is_hardly_smaller_is_left_out() {
    let mesh = Mesh::from(Torus::new(0.5, 1.0).mesh().major_resolution(64).minor_resolution(32));
    let chain = MeshChain::build(&mesh, &ratios(&[1.0, 0.9, 0.5, 0.45]), false).expect("a usable mesh");
    let triangles: Vec<usize> = chain.levels.iter().map(|level| level.triangles).collect();
    assert_eq!(triangles.len(), 1, "{triangles:?}");
}

#[test]
fn a_level_that_a_coarser_one_is_as_near_as_is_left_out() {
    let flat = Mesh::from(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(20));
    let chain = MeshChain::build(&flat, &ratios(&[0.5, 0.25, 0.01]), false).expect("a usable mesh");
    assert_eq!(chain.levels.len(), 1);
    assert!(chain.levels[0].triangles < 10);
}

#[test]
fn a_bad_target_is_an_error() {
    let built = MeshChain::build(&Mesh::from(Cuboid::default()), &ratios(&[0.5, -1.0]), false);
    assert_eq!(built.err(), Some(SimplifyError::BadTarget(SimplifyTarget::Ratio(-1.0))));
}
