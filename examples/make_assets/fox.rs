//! A fox, as tall as a real one, with a skeleton under its fur.

use crate::color::*;
use crate::fox_motion;
use crate::math::{Vec3, noise, vec3};
use crate::rig::{Joint, Part, Rig};
use crate::shape::Shape;

/// The numbers of the joints.
pub mod joint {
    pub const HIPS: usize = 0;
    pub const SPINE: usize = 1;
    pub const CHEST: usize = 2;
    pub const NECK: usize = 3;
    pub const HEAD: usize = 4;
    pub const JAW: usize = 5;
    /// The left one; the right one follows.
    pub const EAR: usize = 6;
    /// The first of five.
    pub const TAIL: usize = 8;
    /// The first of three in the left leg, from the top; the right leg follows.
    pub const FORELEG: usize = 13;
    pub const HINDLEG: usize = 19;
}

/// Where the limbs bend, on the left side; the right side is its mirror image.
pub const FORELEG: [Vec3; 4] = [
    vec3(0.056, 0.335, 0.175),
    vec3(0.056, 0.235, 0.118),
    vec3(0.054, 0.085, 0.150),
    vec3(0.054, 0.015, 0.185),
];
pub const HINDLEG: [Vec3; 4] = [
    vec3(0.058, 0.355, -0.205),
    vec3(0.060, 0.245, -0.145),
    vec3(0.056, 0.135, -0.262),
    vec3(0.056, 0.015, -0.215),
];
const TAIL: [Vec3; 6] = [
    vec3(0.0, 0.388, -0.265),
    vec3(0.0, 0.375, -0.35),
    vec3(0.0, 0.340, -0.44),
    vec3(0.0, 0.300, -0.53),
    vec3(0.0, 0.275, -0.62),
    vec3(0.0, 0.268, -0.74),
];
const MIRROR: Vec3 = vec3(-1.0, 1.0, 1.0);

pub fn rig() -> Rig {
    let joints = skeleton();
    let clips = vec![fox_motion::run(&joints), fox_motion::look_around(&joints)];
    Rig {
        skin: skin(),
        joints,
        clips,
    }
}

fn skeleton() -> Vec<Joint> {
    use joint::*;
    let mut joints = Vec::new();
    let mut add = |name: &str, parent: Option<usize>, at: Vec3, end: Vec3| {
        joints.push(Joint {
            name: name.into(),
            parent,
            at,
            end,
        });
    };
    let (hips, spine, chest) = (vec3(0.0, 0.375, -0.24), vec3(0.0, 0.38, -0.08), vec3(0.0, 0.375, 0.07));
    let (neck, head, nose) = (vec3(0.0, 0.40, 0.225), vec3(0.0, 0.525, 0.345), vec3(0.0, 0.515, 0.55));
    add("hips", None, hips, spine);
    add("spine", Some(HIPS), spine, chest);
    add("chest", Some(SPINE), chest, neck);
    add("neck", Some(CHEST), neck, head);
    add("head", Some(NECK), head, nose);
    add("jaw", Some(HEAD), vec3(0.0, 0.508, 0.42), vec3(0.0, 0.495, 0.54));
    let (ear, ear_tip) = (vec3(0.048, 0.592, 0.36), vec3(0.07, 0.69, 0.35));
    add("ear_left", Some(HEAD), ear, ear_tip);
    add("ear_right", Some(HEAD), ear.scaled(MIRROR), ear_tip.scaled(MIRROR));
    for i in 0..5 {
        let parent = if i == 0 { HIPS } else { TAIL + i - 1 };
        add(
            &format!("tail_{}", i + 1),
            Some(parent),
            self::TAIL[i],
            self::TAIL[i + 1],
        );
    }
    for (bends, first, parent, names) in [
        (self::FORELEG, FORELEG, CHEST, ["upper_arm", "forearm", "hand"]),
        (self::HINDLEG, HINDLEG, HIPS, ["thigh", "shank", "foot"]),
    ] {
        for (side, flip, first) in [("left", vec3(1.0, 1.0, 1.0), first), ("right", MIRROR, first + 3)] {
            for (i, name) in names.into_iter().enumerate() {
                let parent = if i == 0 { parent } else { first + i - 1 };
                let [at, end] = [bends[i], bends[i + 1]].map(|p| p.scaled(flip));
                add(&format!("{name}_{side}"), Some(parent), at, end);
            }
        }
    }
    joints
}

/// An oval across a path in a plane beside the middle one: where it is, and how far it reaches to the sides, to the
/// upper and to the lower side of a path that goes towards +z.
struct Oval {
    at: Vec3,
    side: f32,
    up: f32,
    down: f32,
}

const fn oval(at: [f32; 3], side: f32, up: f32, down: f32) -> Oval {
    Oval {
        at: vec3(at[0], at[1], at[2]),
        side,
        up,
        down,
    }
}

/// A skin over ovals, rounded along the path with `steps` rings to each.
fn limb(ovals: &[Oval], segments: usize, steps: usize) -> Shape {
    let last = ovals.len() - 1;
    // A Catmull-Rom spline through the values of the ovals.
    let spline = |i: usize, t: f32, value: &dyn Fn(&Oval) -> f32| {
        let [a, b, c, d] = [i.saturating_sub(1), i, i + 1, (i + 2).min(last)].map(|i| value(&ovals[i]));
        b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
    };
    let mut along: Vec<Oval> = (0..last * steps)
        .map(|k| {
            let (i, t) = (k / steps, (k % steps) as f32 / steps as f32);
            let of = |value: &dyn Fn(&Oval) -> f32| spline(i, t, value);
            Oval {
                at: vec3(of(&|o| o.at.x), of(&|o| o.at.y), of(&|o| o.at.z)),
                side: of(&|o| o.side).max(0.0),
                up: of(&|o| o.up).max(0.0),
                down: of(&|o| o.down).max(0.0),
            }
        })
        .collect();
    let Oval { at, side, up, down } = ovals[last];
    along.push(Oval { at, side, up, down });
    let rings: Vec<Vec<Vec3>> = (0..along.len())
        .map(|i| {
            let way = along[(i + 1).min(along.len() - 1)].at - along[i.saturating_sub(1)].at;
            let way = way.normalized();
            let side = vec3(1.0, 0.0, 0.0);
            let side = (side - way * side.dot(way)).normalized();
            let up = way.cross(side);
            let oval = &along[i];
            let on_ring = |k: usize| {
                let (cos, sin) = crate::math::cos_sin(k as f32 / segments as f32);
                let height = if sin > 0.0 { oval.up } else { oval.down };
                oval.at + side * (oval.side * cos) + up * (height * sin)
            };
            (0..segments).map(on_ring).collect()
        })
        .collect();
    Shape::loft(&rings)
}

fn skin() -> Vec<Part> {
    use joint::*;
    let mut parts = vec![
        part(body(), &[HIPS, SPINE, CHEST, NECK, HEAD]),
        part(head(), &[HEAD]),
        part(jaw(), &[HEAD, JAW]),
        part(tail(), &[HIPS, TAIL, TAIL + 1, TAIL + 2, TAIL + 3, TAIL + 4]),
    ];
    let (ear, face, fore, hind) = (ear(), face(), foreleg(), hindleg());
    for (side, mirrored) in [false, true].into_iter().enumerate() {
        let of = |shape: &Shape| {
            if mirrored {
                shape.clone().mirrored()
            } else {
                shape.clone()
            }
        };
        parts.push(part(of(&ear), &[HEAD, EAR + side]));
        parts.push(part(of(&face), &[HEAD]));
        let (a, b) = (FORELEG + 3 * side, HINDLEG + 3 * side);
        parts.push(part(of(&fore), &[CHEST, a, a + 1, a + 2]));
        parts.push(part(of(&hind), &[HIPS, b, b + 1, b + 2]));
    }
    parts
}

fn part(shape: Shape, joints: &[usize]) -> Part {
    Part {
        shape,
        joints: joints.to_vec(),
    }
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Red above, cream below; `under` says how far below a point is, from 0 to 1.
fn coat(p: Vec3, under: f32) -> Color {
    let back = FOX_RED.mix(FOX_DARK, smoothstep(0.39, 0.46, p.y) * 0.5);
    let ragged = 0.25 * noise(p * 40.0, 3);
    back.mix(CREAM_FUR, smoothstep(0.4, 0.62, under + ragged * under))
}

fn body() -> Shape {
    let ovals = [
        oval([0.0, 0.385, -0.300], 0.012, 0.012, 0.012),
        oval([0.0, 0.383, -0.285], 0.050, 0.042, 0.045),
        oval([0.0, 0.375, -0.225], 0.080, 0.060, 0.075),
        oval([0.0, 0.375, -0.120], 0.074, 0.058, 0.066),
        oval([0.0, 0.370, 0.000], 0.078, 0.058, 0.084),
        oval([0.0, 0.365, 0.110], 0.086, 0.066, 0.112),
        oval([0.0, 0.380, 0.195], 0.080, 0.068, 0.116),
        oval([0.0, 0.425, 0.262], 0.077, 0.064, 0.102),
        oval([0.0, 0.475, 0.308], 0.073, 0.060, 0.086),
        oval([0.0, 0.518, 0.344], 0.062, 0.050, 0.060),
        oval([0.0, 0.545, 0.370], 0.020, 0.020, 0.020),
    ];
    limb(&ovals, 18, 2).smooth().painted_by(|p| {
        // The bib: the front of throat and chest, and the belly between the legs.
        let belly = smoothstep(0.33, 0.27, p.y) * smoothstep(0.07, 0.04, p.x.abs());
        let throat = smoothstep(0.02, -0.05, (p.y - 0.44) - (p.z - 0.26) * 0.9) * smoothstep(0.12, 0.22, p.z);
        coat(p, belly.max(throat * smoothstep(0.085, 0.05, p.x.abs())))
    })
}

fn head() -> Shape {
    let ovals = [
        oval([0.0, 0.545, 0.3185], 0.012, 0.012, 0.012),
        oval([0.0, 0.547, 0.332], 0.052, 0.044, 0.044),
        oval([0.0, 0.548, 0.368], 0.078, 0.056, 0.058),
        oval([0.0, 0.546, 0.405], 0.073, 0.054, 0.052),
        oval([0.0, 0.537, 0.440], 0.050, 0.041, 0.036),
        oval([0.0, 0.526, 0.468], 0.034, 0.027, 0.022),
        oval([0.0, 0.518, 0.500], 0.025, 0.020, 0.012),
        oval([0.0, 0.515, 0.529], 0.018, 0.016, 0.009),
        oval([0.0, 0.514, 0.540], 0.006, 0.006, 0.004),
    ];
    let head = limb(&ovals, 18, 2).smooth().painted_by(|p| {
        // White along the lips and over the cheeks, below a line that falls towards the nose.
        let line = 0.532 - (p.z - 0.40) * 0.11;
        let bridge = smoothstep(0.006, 0.02, p.x.abs());
        coat(
            p,
            smoothstep(line + 0.012, line - 0.012, p.y) * bridge.max(smoothstep(0.51, 0.50, p.y)),
        )
    });
    let nose = Shape::blob(1, |_| 0.0125).smooth().scaled(1.1, 0.85, 0.9);
    head + nose.painted(INK).at(0.0, 0.524, 0.536)
}

fn jaw() -> Shape {
    let ovals = [
        oval([0.0, 0.512, 0.400], 0.020, 0.008, 0.012),
        oval([0.0, 0.509, 0.440], 0.032, 0.006, 0.016),
        oval([0.0, 0.508, 0.480], 0.023, 0.005, 0.013),
        oval([0.0, 0.508, 0.512], 0.014, 0.004, 0.009),
        oval([0.0, 0.508, 0.523], 0.004, 0.002, 0.003),
    ];
    limb(&ovals, 10, 2).smooth().painted(CREAM_FUR)
}

/// The left ear, leaf-shaped, pale within and dark behind.
fn ear() -> Shape {
    let ovals = [
        oval([0.046, 0.568, 0.364], 0.036, 0.018, 0.024),
        oval([0.050, 0.600, 0.361], 0.033, 0.012, 0.020),
        oval([0.057, 0.632, 0.356], 0.023, 0.008, 0.013),
        oval([0.064, 0.662, 0.351], 0.011, 0.004, 0.006),
        oval([0.068, 0.682, 0.348], 0.001, 0.001, 0.001),
    ];
    limb(&ovals, 12, 2).smooth().painted_by(|p| {
        let tip = smoothstep(0.62, 0.68, p.y);
        let back = FOX_RED.mix(INK, smoothstep(0.59, 0.64, p.y) * 0.9);
        let in_front = smoothstep(-0.001, 0.006, p.z - (0.362 - (p.y - 0.572) * 0.12));
        back.mix(CREAM_FUR.mix(FOX_DARK, 0.2 + 0.5 * tip), in_front)
    })
}

/// The left eye and the tuft of the cheek.
fn face() -> Shape {
    let ball = |radius: f32| Shape::blob(1, |_| radius).smooth();
    let mut eye = ball(0.0150).scaled(0.7, 1.0, 0.9).painted(AMBER);
    eye += ball(0.0122).scaled(0.7, 1.1, 0.9).painted(INK).at(0.002, 0.0, 0.0045);
    eye += Shape::blob(0, |_| 0.0032)
        .painted(Color::WHITE)
        .at(0.007, 0.006, 0.0095);
    let tuft = |from: [f32; 3], to: [f32; 3], thick: f32| {
        let middle = std::array::from_fn(|i| from[i] * 0.55 + to[i] * 0.45);
        let ovals = [
            oval(from, thick * 0.9, thick * 1.3, thick * 1.3),
            oval(middle, thick * 0.8, thick * 1.1, thick * 1.1),
            oval(to, 0.001, 0.001, 0.001),
        ];
        limb(&ovals, 8, 2).smooth()
    };
    let upper = tuft([0.045, 0.540, 0.385], [0.112, 0.520, 0.352], 0.022);
    let lower = tuft([0.040, 0.525, 0.385], [0.092, 0.486, 0.362], 0.022);
    let tufts = (upper + lower).painted_by(|p| FOX_RED.mix(CREAM_FUR, smoothstep(0.548, 0.53, p.y)));
    eye.at(0.0500, 0.553, 0.4260) + tufts
}

fn tail() -> Shape {
    let round = |y: f32, z: f32, radius: f32| oval([0.0, y, z], radius, radius * 0.95, radius * 0.95);
    let ovals = [
        round(0.388, -0.262, 0.024),
        round(0.384, -0.300, 0.030),
        round(0.370, -0.360, 0.042),
        round(0.341, -0.440, 0.062),
        round(0.305, -0.530, 0.075),
        round(0.280, -0.610, 0.072),
        round(0.270, -0.680, 0.052),
        round(0.268, -0.735, 0.024),
        round(0.268, -0.765, 0.001),
    ];
    limb(&ovals, 14, 2).smooth().painted_by(|p| {
        let ragged = 0.02 * noise(p * 45.0, 5);
        let dusk = FOX_RED.mix(FOX_DARK, 0.6 * smoothstep(-0.45, -0.60, p.z));
        dusk.mix(CREAM_FUR, smoothstep(-0.620, -0.650, p.z + ragged))
    })
}

/// Red down to a black stocking.
fn stocking(p: Vec3) -> Color {
    let ragged = 0.03 * noise(p * 50.0, 7);
    coat(p, 0.0).mix(INK, smoothstep(0.215, 0.150, p.y + ragged))
}

/// A paw of the left side under a point.
fn paw(x: f32, z: f32) -> Shape {
    let ovals = [
        oval([x, 0.020, z - 0.032], 0.006, 0.006, 0.006),
        oval([x, 0.022, z - 0.022], 0.018, 0.020, 0.021),
        oval([x, 0.020, z + 0.012], 0.023, 0.018, 0.020),
        oval([x, 0.016, z + 0.040], 0.017, 0.011, 0.016),
        oval([x, 0.012, z + 0.049], 0.004, 0.003, 0.004),
    ];
    limb(&ovals, 10, 1).smooth()
}

fn foreleg() -> Shape {
    let ovals = [
        oval([0.050, 0.405, 0.160], 0.010, 0.020, 0.020),
        oval([0.054, 0.375, 0.163], 0.030, 0.052, 0.050),
        oval([0.056, 0.310, 0.158], 0.035, 0.052, 0.048),
        oval([0.056, 0.245, 0.130], 0.026, 0.034, 0.030),
        oval([0.055, 0.180, 0.130], 0.019, 0.022, 0.022),
        oval([0.054, 0.100, 0.147], 0.016, 0.017, 0.018),
        oval([0.054, 0.060, 0.156], 0.016, 0.017, 0.019),
        oval([0.054, 0.015, 0.162], 0.014, 0.016, 0.018),
    ];
    (limb(&ovals, 12, 2).smooth() + paw(0.054, 0.165)).painted_by(stocking)
}

fn hindleg() -> Shape {
    let ovals = [
        oval([0.050, 0.415, -0.205], 0.010, 0.022, 0.022),
        oval([0.054, 0.380, -0.207], 0.034, 0.062, 0.060),
        oval([0.058, 0.315, -0.195], 0.040, 0.066, 0.062),
        oval([0.060, 0.255, -0.180], 0.032, 0.046, 0.044),
        oval([0.059, 0.195, -0.212], 0.023, 0.028, 0.028),
        oval([0.057, 0.148, -0.252], 0.017, 0.019, 0.019),
        oval([0.056, 0.110, -0.256], 0.015, 0.016, 0.017),
        oval([0.056, 0.060, -0.244], 0.014, 0.014, 0.016),
        oval([0.056, 0.015, -0.236], 0.013, 0.015, 0.017),
    ];
    (limb(&ovals, 12, 2).smooth() + paw(0.056, -0.232)).painted_by(stocking)
}
