//! Vectors, turns and noise, made of basic arithmetic and square roots alone: those round the same way on every
//! platform, and so the files come out the same everywhere.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A point or a direction, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3 {
    pub x: f32,
    pub y: f32,
    pub z: f32,
}

/// Short for the vector (`x`, `y`, `z`).
pub const fn vec3(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    pub const ZERO: Self = vec3(0.0, 0.0, 0.0);
    pub const Y: Self = vec3(0.0, 1.0, 0.0);

    pub fn dot(self, other: Self) -> f32 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub fn cross(self, other: Self) -> Self {
        vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    pub fn length(self) -> f32 {
        self.dot(self).sqrt()
    }

    pub fn normalized(self) -> Self {
        self * (1.0 / self.length())
    }

    pub fn lerp(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }

    pub fn min(self, other: Self) -> Self {
        vec3(self.x.min(other.x), self.y.min(other.y), self.z.min(other.z))
    }

    pub fn max(self, other: Self) -> Self {
        vec3(self.x.max(other.x), self.y.max(other.y), self.z.max(other.z))
    }

    /// The product component by component.
    pub fn scaled(self, by: Self) -> Self {
        vec3(self.x * by.x, self.y * by.y, self.z * by.z)
    }

    pub fn to_array(self) -> [f32; 3] {
        [self.x, self.y, self.z]
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        vec3(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl AddAssign for Vec3 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        vec3(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f32> for Vec3 {
    type Output = Self;
    fn mul(self, by: f32) -> Self {
        vec3(self.x * by, self.y * by, self.z * by)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

/// Cosine and sine of an angle given in whole turns; exact at every quarter.
pub fn cos_sin(turns: f32) -> (f32, f32) {
    let quarter = (turns * 4.0).round();
    let angle = f64::from(turns - quarter / 4.0) * std::f64::consts::TAU;
    let square = angle * angle;
    let cos = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)));
    let sin = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)));
    let (cos, sin) = (cos as f32, sin as f32);
    match quarter.rem_euclid(4.0) as u8 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// A number between -1 and 1 that looks random but belongs to its lattice cell and `seed`.
fn hash(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    let mut bits = seed.wrapping_mul(0x9e37_79b9);
    for axis in [x, y, z] {
        bits = (bits ^ axis.cast_unsigned()).wrapping_mul(0x85eb_ca6b);
        bits ^= bits >> 13;
        bits = bits.wrapping_mul(0xc2b2_ae35);
        bits ^= bits >> 16;
    }
    (bits >> 8) as f32 / (1 << 23) as f32 - 1.0
}

/// Smooth noise between -1 and 1 with features about one unit wide.
pub fn noise(at: Vec3, seed: u32) -> f32 {
    let [x, y, z] = at.to_array().map(|c| c.floor() as i32);
    let ease = |c: f32| {
        let t = c - c.floor();
        t * t * (3.0 - 2.0 * t)
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let edge = |y, z| mix(hash(x, y, z, seed), hash(x + 1, y, z, seed), ease(at.x));
    let face = |z| mix(edge(y, z), edge(y + 1, z), ease(at.y));
    mix(face(z), face(z + 1), ease(at.z))
}
