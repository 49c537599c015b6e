//! Rays through the triangles of one mesh, one thread, against the peers and their tests of triangles.
//!
//! The models are a displaced sphere and a terrain of 70,000 and a million triangles, and the flight helmet of the glTF
//! sample models, which is looked for in the folder that `SIGHTLINE_MODELS` names, or in `../shared/models`.
//!
//! All rays see both sides of a triangle. An answer is a parameter and the number of a triangle; ours has barycentric
//! coordinates besides. The peers test as Möller and Trumbore do, through which rays slip, but for Embree, which is
//! robust here, and is raced in rows of its own.
//!
//! In the cases `camera-packets`, a row of a picture is asked for at once, which a peer that knows no such question answers
//! ray by ray.
//!
//! Memory is what is allocated and kept to answer with: nodes, triangles, and the numbers of the triangles. Ours has the
//! numbers of the vertices and their normals and texture coordinates besides.

mod build;
#[cfg(feature = "embree")]
mod embree;
mod models;
mod ours;
mod peers;
mod rays;
mod refit;

use bevy_sightline::geometry::ray::Ray;

use self::{
    models::Model,
    peers::{bvh::Flat, obvhs, parry::Parry},
};
use crate::{
    Effort,
    allocated::allocated,
    spatial::{
        OURS,
        race::{Side, race, report},
    },
};

/// Rays in a turn.
const TURN: usize = 1024;

/// A parameter, and the number of a triangle.
type Hit = (f32, u32);

/// Queries along rays.
trait MeshRays {
    fn closest(&self, ray: &Ray) -> Option<Hit>;

    /// The closest of each of many rays: together if the side can do that.
    fn closest_of_each(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.extend(rays.iter().map(|ray| self.closest(ray)));
    }

    fn any(&self, ray: &Ray) -> bool;
}

/// One that is raced, by its name, and the bytes that it takes.
struct Named {
    name: &'static str,
    rays: Box<dyn MeshRays>,
    bytes: usize,
}

impl Named {
    fn new<T: MeshRays + 'static>(name: &'static str, build: impl FnOnce() -> T) -> Self {
        let (rays, bytes) = allocated(build);
        Self {
            name,
            rays: Box::new(rays),
            bytes,
        }
    }
}

pub(crate) fn run(effort: Effort) {
    for model in models::all(effort) {
        let ours = || Named::new(OURS, || ours::build(&ours::source(&model)));
        let mut sides = vec![ours()];
        for (name, params) in obvhs::BEST_BINARY {
            sides.push(Named::new(name, || obvhs::Binary::build(&model, params).reordered()));
        }
        for (name, params) in obvhs::BEST_WIDE {
            sides.push(Named::new(name, || obvhs::Wide::build(&model, params)));
        }
        sides.push(Named::new("parry3d 0.31", || Parry::build(&model)));
        sides.push(Named::new("bvh 0.13 flat", || Flat::build(&model)));
        race_rays(&model, "", &sides, effort);
        report_memory(&model, "", &sides);
        sides[0] = Named::new(OURS, || ours::build_compact(&ours::source(&model)));
        race_incoherent(&model, "-compact", &sides, effort);
        report_memory(&model, "-compact", &sides);
        drop(sides);
        build::run(&model, effort);
        refit::run(&model, effort);

        #[cfg(feature = "embree")]
        {
            let mut sides = vec![ours()];
            sides.extend(embree::Embree::best(&model));
            race_rays(&model, "-embree", &sides, effort);
            report_memory(&model, "-embree", &sides);
        }
    }
}

fn race_rays(model: &Model, suffix: &str, sides: &[Named], effort: Effort) {
    let case = |name: &str| format!("mesh/{name}-{}{suffix}", model.name);
    let incoherent = race_incoherent(model, suffix, sides, effort);
    let hits = rays::surface(model, &incoherent, &*sides[0].rays);
    let closest = |name, rays: &[Ray]| {
        let sides = &mut by(sides, |side, ray| side.closest(ray));
        race(&case(name), TURN, rays, sides, |a, b| same(model, a, b));
    };
    closest("closest-bounce", &rays::bounces(&hits));
    let camera = rays::camera(model, effort);
    closest("closest-camera", &camera);
    let packets = &mut at_once(sides);
    race(&case("camera-packets"), TURN, &camera, packets, |a, b| {
        same(model, a, b)
    });
    let shadows = rays::shadows(model, &hits);
    let sides = &mut by(sides, |side, ray| side.any(ray));
    race(&case("any"), TURN, &shadows, sides, |a, b| a == b);
}

fn race_incoherent(model: &Model, suffix: &str, sides: &[Named], effort: Effort) -> Vec<Ray> {
    let turns = match effort {
        Effort::Quick => 20,
        Effort::Full => 100,
    };
    let incoherent = rays::incoherent(model, TURN * turns);
    let case = format!("mesh/closest-incoherent-{}{suffix}", model.name);
    let sides = &mut by(sides, |side, ray| side.closest(ray));
    race(&case, TURN, &incoherent, sides, |a, b| same(model, a, b));
    incoherent
}

fn by<'a, A: 'a>(sides: &'a [Named], query: fn(&dyn MeshRays, &Ray) -> A) -> Vec<Side<'a, Ray, A>> {
    let side = |side: &'a Named| Side::new(side.name, move |ray| query(&*side.rays, ray));
    sides.iter().map(side).collect()
}

fn at_once(sides: &[Named]) -> Vec<Side<'_, Ray, Option<Hit>>> {
    let side = |side| {
        let Named { name, rays, .. }: &Named = side;
        Side::of_turns(name, |turn: &[Ray], hits| rays.closest_of_each(turn, hits))
    };
    sides.iter().map(side).collect()
}

/// Whether two hits are as near, within a ten-thousandth; or within a millionth of the size of the model, which is what
/// `f32` resolves where a ray starts close to what it hits.
fn same(model: &Model, a: &Option<Hit>, b: &Option<Hit>) -> bool {
    match (a, b) {
        (Some((a, _)), Some((b, _))) => (a - b).abs() <= (1e-4 * a.max(*b)).max(1e-6 * model.radius),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// The figures are bytes for a thousand triangles.
fn report_memory(model: &Model, suffix: &str, sides: &[Named]) {
    let per_thousand = |side: &Named| (side.name, side.bytes as f64 * 1e3 / model.triangles.len() as f64);
    let case = format!("mesh/memory-{}{suffix}", model.name);
    report(&case, sides.iter().map(per_thousand).collect());
}
