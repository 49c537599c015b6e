//! Moving all vertices, and fitting the tree to them.

use bevy::math::Vec3;

use super::{
    MeshRays, TURN,
    models::Model,
    ours,
    peers::{obvhs, parry::Parry},
    rays, same,
};
use crate::{
    Effort,
    spatial::{
        OURS,
        race::{Side, measure, report},
    },
};

/// A tree that follows the vertices.
pub(crate) trait Refit: MeshRays {
    /// Moves vertex `i` to `positions[i]`.
    fn refit(&mut self, positions: &[Vec3]);
}

pub(crate) fn run(model: &Model, _: Effort) {
    let mut sides: Vec<(&str, Box<dyn Refit>)> = vec![
        (OURS, Box::new(ours::build(&ours::source(model)))),
        ("obvhs 0.4 Bvh2", Box::new(obvhs::Refitted::build(model))),
        ("parry3d 0.31", Box::new(Parry::build(model))),
    ];
    race_refits(model, "", &mut sides);

    #[cfg(feature = "embree")]
    {
        sides.truncate(1);
        sides.push((
            super::embree::REFITTED,
            Box::new(super::embree::Embree::refittable(model)),
        ));
        race_refits(model, "-embree", &mut sides);
    }
}

/// Lets the model swell here and shrink there, in turn with the other way round.
fn race_refits(model: &Model, suffix: &str, sides: &mut [(&'static str, Box<dyn Refit>)]) {
    let swollen = |sign: f32| -> Vec<Vec3> {
        let swell = |&position: &Vec3| {
            let from_center = position - model.center;
            position + from_center * sign * 0.05 * (position.dot(Vec3::new(5.0, 7.0, 3.0)) / model.radius).sin()
        };
        model.positions.iter().map(swell).collect()
    };
    let poses = [swollen(1.0), swollen(-1.0)];
    let rounds = (2_000_000 / model.triangles.len()).clamp(6, 40);
    let frames: Vec<&[Vec3]> = poses.iter().map(Vec::as_slice).cycle().take(rounds).collect();
    let case = format!("mesh/refit-{}{suffix}", model.name);
    let mut refits: Vec<Side<&[Vec3], ()>> = (sides.iter_mut())
        .map(|(name, side)| Side::new(name, |positions: &&[Vec3]| side.refit(positions)))
        .collect();
    let figures = measure(&case, 1, &frames, &mut refits, |(), ()| true);
    drop(refits);
    report(&case, figures);

    let rays = rays::incoherent(model, 4 * TURN);
    let mut closest: Vec<_> = (sides.iter())
        .map(|(name, side)| Side::new(name, |ray| side.closest(ray)))
        .collect();
    measure(&format!("{case}, rays after it"), TURN, &rays, &mut closest, |a, b| {
        same(model, a, b)
    });
}
