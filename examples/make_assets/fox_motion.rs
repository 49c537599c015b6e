//! How the fox moves: a gallop, and standing while it looks around.

use crate::fox::joint::*;
use crate::math::{Vec3, cos_sin, vec3};
use crate::rig::{Clip, Joint, Pose, Turn};

/// Metres a second over ground at which the feet of the gallop do not slide.
const SPEED: f32 = 3.0;
const STRIDE_SECONDS: f32 = 0.48;
/// The share of a stride for which a foot is on the ground.
const STANCE: f32 = 0.2;

/// A foot: the first joint of its leg, when in the stride it comes down, and how high it is lifted.
struct Foot {
    leg: usize,
    down: f32,
    lift: f32,
    /// Where it is halfway through its stance, against its place when standing.
    ahead: f32,
}

/// A gallop: the hind feet push one after the other, the fox flies, lands on its fore feet, and gathers itself.
pub fn run(joints: &[Joint]) -> Clip {
    const FEET: [Foot; 4] = [
        foot(HINDLEG, 0.0, 0.10, 0.015),
        foot(HINDLEG + 3, 0.09, 0.10, 0.015),
        foot(FORELEG, 0.44, 0.13, -0.005),
        foot(FORELEG + 3, 0.55, 0.13, -0.005),
    ];
    let pose = |phase: f32| {
        let wave = |peak: f32| cos_sin(phase - peak).0;
        let mut stance = Stance::new(joints);
        stance.pose.root += vec3(
            0.0,
            0.014 * wave(0.9) + 0.01 * cos_sin(2.0 * (phase - 0.41)).0 - 0.022,
            0.0,
        );
        let arch = 0.4 + 0.6 * wave(0.92);
        let pitch = -0.018 * wave(0.3);
        let (hips, spine, chest) = (pitch - 0.052 * arch, 0.05 * arch, 0.045 * arch);
        stance.turn(HIPS, Turn::nod(hips));
        stance.turn(SPINE, Turn::nod(spine));
        stance.turn(CHEST, Turn::nod(chest));
        // The head is carried low and still.
        let against = -(hips + spine + chest);
        stance.turn(NECK, Turn::nod(0.05 + 0.6 * against));
        stance.turn(HEAD, Turn::nod(-0.045 + 0.4 * against));
        stance.turn(JAW, Turn::nod(0.025 + 0.01 * wave(0.5)));
        for (ear, side) in [(EAR, -1.0), (EAR + 1, 1.0)] {
            stance.turn(ear, Turn::nod(-0.05 + 0.015 * wave(0.6)).after(Turn::tilt(0.01 * side)));
        }
        stance.turn(TAIL, Turn::nod(0.03 - hips + 0.03 * wave(0.55)));
        for i in 1..5 {
            stance.turn(TAIL + i, Turn::nod(0.008 + 0.032 * wave(0.55 + 0.11 * i as f32)));
        }
        for foot in FEET {
            let (step, pitch) = foot.step(phase);
            stance.put_foot(foot.leg, step, pitch);
        }
        stance.pose
    };
    clip("run", STRIDE_SECONDS, 24, pose)
}

const fn foot(leg: usize, down: f32, lift: f32, ahead: f32) -> Foot {
    Foot { leg, down, lift, ahead }
}

impl Foot {
    /// How far from its place when standing the toe is, and how far the foot is turned.
    fn step(&self, phase: f32) -> (Vec3, f32) {
        const DOWN: f32 = -0.03;
        const OFF: f32 = 0.12;
        const FOLDED: f32 = 0.26;
        let half = SPEED * STRIDE_SECONDS * STANCE / 2.0;
        let since = (phase - self.down).rem_euclid(1.0);
        if since < STANCE {
            let t = since / STANCE;
            let pitch = DOWN + (OFF - DOWN) * t * t;
            return (vec3(0.0, 0.0, self.ahead + half * (1.0 - 2.0 * t)), pitch);
        }
        let t = (since - STANCE) / (1.0 - STANCE);
        let pitch = if t < 0.4 {
            OFF + (FOLDED - OFF) * ease(t / 0.4)
        } else {
            FOLDED + (DOWN - FOLDED) * ease((t - 0.4) / 0.6)
        };
        let lift = self.lift * ease((4.0 * t * (1.0 - t)).min(1.0));
        (vec3(0.0, lift, self.ahead + half * (2.0 * ease(t) - 1.0)), pitch)
    }
}

/// Breathes, looks to either side, pricks its ears and swings its tail.
pub fn look_around(joints: &[Joint]) -> Clip {
    const SECONDS: f32 = 6.0;
    let pose = |phase: f32| {
        let curve = |keys: &[(f32, f32)]| {
            let after = keys.iter().position(|key| key.0 >= phase * SECONDS).unwrap_or(0);
            let (from, to) = (keys[after.max(1) - 1], keys[after.max(1)]);
            from.1 + (to.1 - from.1) * ease((phase * SECONDS - from.0) / (to.0 - from.0))
        };
        let breath = cos_sin(3.0 * phase).0;
        let look = curve(&[
            (0.0, 0.0),
            (0.7, 0.0),
            (1.3, 0.15),
            (2.6, 0.17),
            (3.2, -0.13),
            (4.6, -0.16),
            (5.3, 0.0),
            (6.0, 0.0),
        ]);
        let up = curve(&[
            (0.0, 0.0),
            (1.3, -0.03),
            (2.6, -0.02),
            (3.9, 0.02),
            (5.0, -0.02),
            (6.0, 0.0),
        ]);
        let tilt = curve(&[
            (0.0, 0.0),
            (3.4, 0.0),
            (3.8, 0.035),
            (4.5, 0.035),
            (5.0, 0.0),
            (6.0, 0.0),
        ]);
        let flick = curve(&[
            (0.0, 0.0),
            (1.6, 0.0),
            (1.7, 0.05),
            (1.85, 0.0),
            (2.0, 0.04),
            (2.15, 0.0),
            (6.0, 0.0),
        ]);

        let mut stance = Stance::new(joints);
        stance.pose.root += vec3(0.0, 0.0025 * breath - 0.003, 0.0);
        stance.turn(CHEST, Turn::nod(-0.003 * breath));
        stance.turn(NECK, Turn::shake(0.45 * look).after(Turn::nod(-0.015 + 0.5 * up)));
        stance.turn(
            HEAD,
            Turn::shake(0.55 * look)
                .after(Turn::tilt(tilt))
                .after(Turn::nod(0.015 + 0.5 * up)),
        );
        stance.turn(EAR, Turn::shake(0.3 * look + flick).after(Turn::tilt(-flick)));
        stance.turn(EAR + 1, Turn::shake(0.3 * look - 0.4 * flick));
        for i in 0..5 {
            let swing = cos_sin(2.0 * phase - 0.13 * i as f32).0;
            let hang = [-0.05, -0.015, 0.0, 0.03, 0.04][i];
            stance.turn(TAIL + i, Turn::shake(0.022 * swing).after(Turn::nod(hang)));
        }
        for leg in [FORELEG, FORELEG + 3, HINDLEG, HINDLEG + 3] {
            stance.put_foot(leg, Vec3::ZERO, 0.0);
        }
        stance.pose
    };
    clip("look_around", SECONDS, 60, pose)
}

fn clip(name: &'static str, seconds: f32, steps: usize, pose: impl Fn(f32) -> Pose) -> Clip {
    let phase = |i| (i % steps) as f32 / steps as f32;
    Clip {
        name,
        seconds,
        poses: (0..=steps).map(|i| pose(phase(i))).collect(),
    }
}

fn ease(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}

/// A pose in the making, from the one in which the skin was made.
struct Stance<'a> {
    joints: &'a [Joint],
    pose: Pose,
}

impl<'a> Stance<'a> {
    fn new(joints: &'a [Joint]) -> Self {
        let pose = Pose {
            root: joints[0].at,
            turns: vec![Turn::NONE; joints.len()],
        };
        Self { joints, pose }
    }

    fn turn(&mut self, joint: usize, turn: Turn) {
        self.pose.turns[joint] = turn;
    }

    /// Where a joint is, and how far it is turned in all.
    fn place(&self, joint: usize) -> (Vec3, Turn) {
        let Some(parent) = self.joints[joint].parent else {
            return (self.pose.root, self.pose.turns[joint]);
        };
        let (at, turn) = self.place(parent);
        let arm = self.joints[joint].at - self.joints[parent].at;
        (at + turn.apply(arm), turn.after(self.pose.turns[joint]))
    }

    /// Bends a leg within its plane so that its toe is `step` from where it stands, the foot turned by `pitch`.
    fn put_foot(&mut self, leg: usize, step: Vec3, pitch: f32) {
        let flat = |v: Vec3| vec3(0.0, v.y, v.z);
        let bone = |i: usize| flat(self.joints[leg + i].end - self.joints[leg + i].at);
        let (upper, lower) = (bone(0), bone(1));
        let foot = Turn::nod(pitch);
        let (top, _) = self.place(leg);
        let (top, toe) = (flat(top), flat(self.joints[leg + 2].end + step));

        // Two sides of a triangle are the bones, the third is from the hip to the ankle.
        let reach = toe - foot.apply(bone(2)) - top;
        let (a, b) = (upper.length(), lower.length());
        let c = reach.length().min(0.998 * (a + b));
        let way = reach.normalized();
        let across = upper.cross(lower).normalized().cross(way);
        let along = (a * a - b * b + c * c) / (2.0 * c);
        let aside = (a * a - along * along).max(0.0).sqrt();
        let knee = way * along - across * aside;

        let thigh = Turn::between(upper, knee);
        let shank = Turn::between(lower, way * c - knee);
        let (_, hips) = self.place(self.joints[leg].parent.expect("a leg hangs on a body"));
        self.turn(leg, hips.inverse().after(thigh));
        self.turn(leg + 1, thigh.inverse().after(shank));
        self.turn(leg + 2, shank.inverse().after(foot));
    }
}
