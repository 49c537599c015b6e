//! Texture coordinates, worked out when they are asked for: an arc tangent takes longer than finding the hit.

use std::f32::consts::{PI, TAU};

use bevy::math::{DVec2, Vec2, Vec3};

/// How the texture coordinates of a hit are worked out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Chart {
    /// They are known.
    Plain(Vec2),
    /// The longitude and latitude of the normal, as `SphereMeshBuilder::ico` has them: u runs clockwise as seen from
    /// above, from the -x axis; v runs down, from the pole.
    Globe,
    /// As on `Triangle3d::mesh`: u along the first side, v at a right angle to it, in the smallest rectangle along that
    /// side that contains the triangle.
    Triangle {
        /// Of the second and the third vertex.
        weights: Vec2,
        /// Where the third vertex is along the first side, times the length of that.
        apex: f64,
        /// The length of the first side, squared.
        base: f64,
    },
    /// Each by an angle.
    Angles { u: Coordinate, v: Coordinate },
}

impl Chart {
    #[inline]
    pub fn plain(uv: DVec2) -> Self {
        Self::Plain(uv.as_vec2())
    }

    /// From 0 to 1 across a rectangle around the origin; backward along an axis whose half size is negative.
    #[inline]
    pub fn centered(point: DVec2, half_size: DVec2) -> Self {
        let along = |axis: usize| {
            if half_size[axis] == 0.0 {
                0.5
            } else {
                0.5 + 0.5 * point[axis] / half_size[axis]
            }
        };
        Self::plain(DVec2::new(along(0), along(1)))
    }

    #[inline]
    pub fn uv(self, normal: Vec3) -> Vec2 {
        let uv = match self {
            Self::Plain(uv) => uv,
            Self::Globe => {
                let Vec3 { x, y, z } = normal;
                Vec2::new(0.5 - z.atan2(x) / TAU, x.hypot(z).atan2(y) / PI)
            }
            Self::Triangle { weights, apex, base } => {
                let apex = if base > 0.0 { (apex / base) as f32 } else { 0.0 };
                let (from, to) = (apex.min(0.0), apex.max(1.0));
                Vec2::new((weights.x + apex * weights.y - from) / (to - from), weights.y)
            }
            Self::Angles { u, v } => Vec2::new(u.value(), v.value()),
        };
        uv.clamp(Vec2::ZERO, Vec2::ONE)
    }
}

/// A texture coordinate: an offset, and so much for every radian of the angle between a vector and the x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinate {
    pub offset: f32,
    /// Zero where the coordinate is the offset.
    pub per_radian: f32,
    pub angle_of: Vec2,
}

impl Coordinate {
    #[inline]
    pub fn plain(value: f64) -> Self {
        Self {
            offset: value as f32,
            per_radian: 0.0,
            angle_of: Vec2::X,
        }
    }

    /// From 0 to 1 with the angle of the vector, counter-clockwise from the x axis once around.
    #[inline]
    pub fn turn(vector: DVec2) -> Self {
        // Half a turn back, so that the arc tangent jumps where the coordinate does.
        Self {
            offset: 0.5,
            per_radian: 1.0 / TAU,
            angle_of: -vector.as_vec2(),
        }
    }

    /// This coordinate times `scale`, plus `offset`.
    #[inline]
    pub fn scaled(self, scale: f32, offset: f32) -> Self {
        Self {
            offset: self.offset * scale + offset,
            per_radian: self.per_radian * scale,
            ..self
        }
    }

    fn value(self) -> f32 {
        if self.per_radian == 0.0 {
            self.offset
        } else {
            self.offset + self.per_radian * self.angle_of.to_angle()
        }
    }
}
