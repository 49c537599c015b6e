//! What levels look like from where they are switched to.

use bevy::prelude::*;
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    lod::simplify::{MeshChain, SimplifyTarget},
    mesh::{MeshBvh, TriangleMesh},
};

use crate::models::meshes;

/// Pixels along a side of a picture.
const SIZE: usize = 512;
/// The error that is promised, in pixels.
const PROMISED: f32 = 1.0;
/// How far off a pixel may be, for it is compared with the middle of another.
const ALLOWED: f32 = PROMISED + std::f32::consts::FRAC_1_SQRT_2;

/// A camera that looks at the middle of a box along an axis.
struct View {
    eye: Vec3,
    turn: Quat,
    /// Pixels at a distance of one.
    focal: f32,
}

/// The depth along the view axis of what is seen in each pixel, infinite where nothing is.
type Picture = Vec<f32>;

impl View {
    /// From so far from the nearest side of the box.
    fn onto(min: Vec3, max: Vec3, direction: Vec3, distance: f32, focal: f32) -> Self {
        let (middle, half) = ((min + max) / 2.0, (max - min) / 2.0);
        Self {
            eye: middle + direction * (half.dot(direction.abs()) + distance),
            turn: Quat::from_rotation_arc(Vec3::Z, direction),
            focal,
        }
    }

    /// What is seen at a place on the screen.
    fn depth(&self, meshes: &[MeshBvh], at: Vec2) -> f32 {
        let offset = (at - SIZE as f32 / 2.0) / self.focal;
        let ray = Ray::new(
            self.eye,
            self.turn * Vec3::new(offset.x, -offset.y, -1.0),
            f32::INFINITY,
        );
        let ray = ray.expect("a finite view");
        let hits = meshes
            .iter()
            .filter_map(|mesh| mesh.closest_hit(&ray, Backfaces::Include));
        hits.map(|hit| hit.t).fold(f32::INFINITY, f32::min)
    }

    fn picture(&self, meshes: &[MeshBvh]) -> Picture {
        let middle = |index: usize| Vec2::new((index % SIZE) as f32 + 0.5, (index / SIZE) as f32 + 0.5);
        (0..SIZE * SIZE)
            .map(|index| self.depth(meshes, middle(index)))
            .collect()
    }
}

/// The farthest that something shown in one picture is from where the other shows something as near, in pixels; where
/// there is nothing within two pixels, infinite.
///
/// So neither silhouette reaches farther than that beyond the other, nor an edge inside of it, behind which is
/// something farther away. What is thinner than a pixel may lie between those of the other picture: there, `look` sees
/// more closely.
fn farthest_pixel(shown: &Picture, other: &Picture, slack: f32, look: impl Fn(Vec2) -> f32) -> f32 {
    let reach = 2;
    let mut farthest = 0.0f32;
    for (index, &depth) in shown.iter().enumerate() {
        if depth == f32::INFINITY || other[index] <= depth + slack {
            continue;
        }
        let (x, y) = ((index % SIZE) as isize, (index / SIZE) as isize);
        let mut nearest = f32::INFINITY;
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            let (x, y) = (x + dx, y + dy);
            let is_inside = [x, y].iter().all(|at| (0..SIZE as isize).contains(at));
            if is_inside && other[y as usize * SIZE + x as usize] <= depth + slack {
                nearest = nearest.min(Vec2::new(dx as f32, dy as f32).length());
            }
        }
        if nearest > ALLOWED {
            let between = |step: isize| step as f32 / 8.0;
            let steps = -8 * reach..=8 * reach;
            let offsets = steps
                .clone()
                .flat_map(|dy| steps.clone().map(move |dx| Vec2::new(between(dx), between(dy))));
            let middle = Vec2::new(x as f32, y as f32) + 0.5;
            let as_near = offsets.filter(|&offset| offset.length() < nearest && look(middle + offset) <= depth + slack);
            nearest = as_near.map(Vec2::length).fold(nearest, f32::min);
        }
        farthest = farthest.max(nearest);
    }
    farthest
}

fn bvh(mesh: &Mesh) -> MeshBvh {
    MeshBvh::build(&TriangleMesh::from_mesh(mesh).expect("a usable mesh"))
}

/// Compares pictures of a mesh and its levels, from all six sides, each from where it is switched to. Returns how many
/// pictures were compared.
fn assert_levels_keep_their_promise(mesh: &Mesh) -> usize {
    let original = [bvh(mesh)];
    let aabb = original[0].mesh().aabb();
    let (min, max) = (Vec3::from(aabb.min), Vec3::from(aabb.max));
    let targets = [0.5, 0.25, 0.125, 0.0625, 0.03125].map(SimplifyTarget::Ratio);
    let chain = MeshChain::build(mesh, &targets, false).expect("a usable mesh");
    assert!(chain.levels.len() >= 3, "{} levels", chain.levels.len());
    let mut compared = 0;
    for level in &chain.levels {
        let simple = [bvh(&level.mesh)];
        let error = level.deviation.at_most;
        // From a distance at which the whole mesh is in sight, through a lens that makes its error the one promised.
        let distance = 2.0 * (max - min).length();
        let focal = PROMISED * distance / error;
        for direction in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            let view = View::onto(min, max, direction, distance, focal);
            let [of_original, of_level] = [&original, &simple].map(|meshes| view.picture(meshes));
            // What is moved is moved in depth as well, and what is seen in a pixel slopes within it.
            let slack = 3.0 * error;
            for (shown, other, meshes) in [(&of_original, &of_level, &simple), (&of_level, &of_original, &original)] {
                let farthest = farthest_pixel(shown, other, slack, |at| view.depth(meshes, at));
                let triangles = level.triangles;
                assert!(
                    farthest <= ALLOWED,
                    "{triangles} triangles are {farthest} pixels off, seen along {direction}"
                );
            }
            compared += 1;
        }
    }
    compared
}

#[test]
fn levels_of_a_torus_are_no_farther_off_than_promised_where_they_are_switched_to() {
    let mesh = Mesh::from(Torus::new(0.5, 1.0).mesh().major_resolution(64).minor_resolution(32));
    assert!(assert_levels_keep_their_promise(&mesh) >= 18);
}

#[test]
fn levels_of_a_real_model_are_no_farther_off_than_promised_where_they_are_switched_to() {
    let Some(meshes) = meshes("FlightHelmet/FlightHelmet.gltf") else {
        return;
    };
    for mesh in &meshes {
        assert_levels_keep_their_promise(mesh);
    }
}
