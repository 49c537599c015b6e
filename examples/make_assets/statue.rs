//! A figure that no building block can make: the surface of a smooth field, found by marching tetrahedra.

use crate::Level;
use crate::color::*;
use crate::math::{Vec3, cos_sin, noise, vec3};
use crate::outline::rounded;
use crate::shape::Shape;

/// A bronze dancer in a long robe on a stone plinth.
pub fn statue(level: Level) -> Shape {
    let tier = |width: f32, height: f32, y: f32| {
        Shape::prism(&rounded(width, width, 0.08, 1), height)
            .painted(LIMESTONE)
            .at(0.0, y, 0.0)
    };
    let mut statue = tier(2.6, 0.3, 0.0) + tier(2.2, 0.3, 0.28) + tier(1.8, 1.5, 0.55) + tier(2.1, 0.25, 2.0);
    statue += Shape::cuboid(1.0, 0.5, 1.86).painted(BRASS).at(0.0, 1.1, 0.0);
    let figure = surface(level.pick(0.054, 0.09, 0.15), level.pick(0.0, 0.015, 0.04))
        .smooth()
        .painted_by(|p| {
            let patina = 0.5 + 0.5 * noise(p * 2.5, 3) + 0.25 * noise(p * 9.0, 4);
            BRONZE.mix(COPPER, patina.clamp(0.0, 1.0) * 0.6)
        });
    statue + figure.at(0.0, 2.2, 0.0)
}

/// The distance to a limb that runs from one ball to another.
fn limb(p: Vec3, a: (Vec3, f32), b: (Vec3, f32)) -> f32 {
    let (way, from) = (b.0 - a.0, p - a.0);
    let t = (from.dot(way) / way.dot(way)).clamp(0.0, 1.0);
    (from - way * t).length() - (a.1 + (b.1 - a.1) * t)
}

/// The lesser of two distances, with the corner between them filled up to `round`.
fn blend(a: f32, b: f32, round: f32) -> f32 {
    let overlap = (round - (a - b).abs()).max(0.0) / round;
    a.min(b) - overlap * overlap * round / 4.0
}

/// About how far `p` is outside the figure, in metres.
fn figure(p: Vec3) -> f32 {
    // The spine sways and the robe winds around it in folds that fade towards the waist.
    let (sway, _) = cos_sin(0.25 + p.y * 0.22);
    let spine = vec3(p.x + 0.16 * sway, p.y, p.z + 0.05 * sway);
    let flare = (1.0 - p.y / 1.75).clamp(0.0, 1.0);
    let around = {
        let (cos, sin) = cos_sin(p.y * 0.16);
        let turned = vec3(spine.x * cos + spine.z * sin, 0.0, spine.z * cos - spine.x * sin);
        let unit = turned * (1.0 / turned.length().max(0.05));
        // The cosine of seven times the angle, by complex powers.
        let mut power = (1.0, 0.0);
        for _ in 0..7 {
            power = (power.0 * unit.x - power.1 * unit.z, power.0 * unit.z + power.1 * unit.x);
        }
        power.0
    };
    let robe = limb(spine, (vec3(0.0, 0.1, 0.0), 0.5), (vec3(0.0, 1.7, 0.0), 0.2)) - 0.055 * flare * around;
    let robe = robe.max(-p.y);
    let hips = limb(spine, (vec3(-0.1, 1.65, 0.0), 0.23), (vec3(0.1, 1.65, 0.0), 0.23));
    let chest = limb(spine, (vec3(-0.13, 2.3, 0.02), 0.2), (vec3(0.13, 2.34, 0.02), 0.2));
    let waist = limb(spine, (vec3(0.0, 1.6, 0.0), 0.19), (vec3(0.0, 2.3, 0.0), 0.19));
    let neck = limb(spine, (vec3(0.0, 2.4, 0.0), 0.1), (vec3(0.02, 2.75, 0.03), 0.085));
    let head = limb(spine, (vec3(0.02, 2.84, 0.06), 0.135), (vec3(0.03, 2.95, 0.03), 0.15));
    let bun = limb(spine, (vec3(0.03, 2.98, -0.14), 0.08), (vec3(0.03, 3.02, -0.16), 0.09));

    let raised = [vec3(0.3, 2.42, 0.0), vec3(0.62, 2.78, 0.12), vec3(0.52, 3.3, 0.22)];
    let held = [vec3(-0.3, 2.36, 0.0), vec3(-0.62, 1.98, 0.08), vec3(-0.42, 1.68, 0.42)];
    let mut arms = f32::INFINITY;
    for [shoulder, elbow, hand] in [raised, held] {
        let upper = limb(spine, (shoulder, 0.12), (elbow, 0.09));
        let lower = limb(spine, (elbow, 0.09), (hand, 0.082));
        let palm = limb(spine, (hand, 0.085), (hand + (hand - elbow) * 0.3, 0.055));
        arms = arms.min(blend(blend(upper, lower, 0.06), palm, 0.05));
    }
    let torso = blend(blend(robe, hips, 0.25), blend(waist, chest, 0.3), 0.2);
    let top = blend(blend(head, bun, 0.06), neck, 0.08);
    blend(blend(torso, top, 0.14), arms, 0.12)
}

/// The surface `off` the figure, in tetrahedra that cut cubes of size `cell`; coarse cells need it thicker, or they
/// lose its wrists.
fn surface(cell: f32, off: f32) -> Shape {
    const LOW: Vec3 = vec3(-1.1, -0.1, -1.0);
    const HIGH: Vec3 = vec3(1.1, 3.7, 1.0);
    let [nx, ny, nz] = (HIGH - LOW).to_array().map(|side| (side / cell).ceil() as usize + 1);
    let place = |[x, y, z]: [usize; 3]| LOW + vec3(x as f32, y as f32, z as f32) * cell;
    let mut field = Vec::with_capacity(nx * ny * nz);
    for z in 0..nz {
        for y in 0..ny {
            field.extend((0..nx).map(|x| figure(place([x, y, z])) - off));
        }
    }
    let node = |at: [usize; 3]| (place(at), field[(at[2] * ny + at[1]) * nx + at[0]]);

    let mut shape = Shape::default();
    let cubes = (0..nz - 1).flat_map(|z| (0..ny - 1).flat_map(move |y| (0..nx - 1).map(move |x| [x, y, z])));
    for cube in cubes {
        // Six ways along three edges from one end of the cube's diagonal to the other: a tetrahedron each.
        for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let mut at = cube;
            let mut corners = [node(at); 4];
            for (corner, axis) in corners[1..].iter_mut().zip(order) {
                at[axis] += 1;
                *corner = node(at);
            }
            cut(&mut shape, corners);
        }
    }
    shape
}

/// Adds the part of the surface within one tetrahedron, given its corners and the field there.
fn cut(shape: &mut Shape, corners: [(Vec3, f32); 4]) {
    let (inside, outside): (Vec<_>, Vec<_>) = corners.into_iter().partition(|corner| corner.1 < 0.0);
    // Kept off the corners, for no triangle is to shrink to a point.
    let crossing = |a: (Vec3, f32), b: (Vec3, f32)| a.0.lerp(b.0, (a.1 / (a.1 - b.1)).clamp(0.08, 0.92));
    let rim: Vec<Vec3> = match (inside.as_slice(), outside.as_slice()) {
        (&[a], &[b, c, d]) => vec![crossing(a, b), crossing(a, c), crossing(a, d)],
        (&[b, c, d], &[a]) => vec![crossing(b, a), crossing(c, a), crossing(d, a)],
        (&[a, b], &[c, d]) => vec![crossing(a, c), crossing(a, d), crossing(b, d), crossing(b, c)],
        _ => return,
    };
    let outwards = outside[0].0 - inside[0].0;
    for i in 1..rim.len() - 1 {
        let [a, b, c] = [rim[0], rim[i], rim[i + 1]];
        let faces_out = (b - a).cross(c - a).dot(outwards) > 0.0;
        shape.push(if faces_out { [a, b, c] } else { [a, c, b] });
    }
}
