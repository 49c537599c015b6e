//! Coloured solids: a few ways to make one, and ways to paint, move and join them.

use std::collections::BTreeMap;
use std::ops::{Add, AddAssign};

use crate::color::Color;
use crate::math::{Vec3, cos_sin, vec3};
use crate::outline::{Outline, rect};

#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub position: Vec3,
    pub normal: Vec3,
    pub color: Color,
}

/// Triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub triangles: Vec<[Corner; 3]>,
}

/// The least and the greatest coordinates of a shape.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl AddAssign for Shape {
    fn add_assign(&mut self, mut other: Self) {
        self.triangles.append(&mut other.triangles);
    }
}

impl Add for Shape {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

/// How to make one: every solid stands on y = 0 around the y axis unless it says otherwise, is white, and is closed.
impl Shape {
    /// Adds a flat triangle, unless it has no area.
    pub fn push(&mut self, points: [Vec3; 3]) {
        let [a, b, c] = points;
        let normal = (b - a).cross(c - a);
        if normal.length() > 1e-7 {
            let normal = normal.normalized();
            self.triangles.push(points.map(|position| Corner {
                position,
                normal,
                color: Color::WHITE,
            }));
        }
    }

    /// Fills a flat polygon by cutting off its ears, the smallest first.
    fn fill(&mut self, polygon: impl Iterator<Item = Vec3>) {
        let mut left: Vec<Vec3> = polygon.collect();
        let turn = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - b);
        let normal = (1..left.len() - 1).fold(Vec3::ZERO, |sum, i| sum + turn([left[0], left[i], left[i + 1]]));
        while left.len() > 2 {
            let around = |i: usize| {
                [
                    left[(i + left.len() - 1) % left.len()],
                    left[i],
                    left[(i + 1) % left.len()],
                ]
            };
            let is_ear = |&i: &usize| {
                let [a, b, c] = around(i);
                let covers = |&p: &Vec3| {
                    let within = |from: Vec3, to: Vec3| turn([from, to, p]).dot(normal) >= 0.0;
                    ![a, b, c].contains(&p) && within(a, b) && within(b, c) && within(c, a)
                };
                turn([a, b, c]).dot(normal) > 0.0 && !left.iter().any(covers)
            };
            let across = |&i: &usize| {
                let [a, _, c] = around(i);
                (c - a).length()
            };
            let ears = (0..left.len()).filter(is_ear);
            let ear = ears.min_by(|i, j| across(i).total_cmp(&across(j))).unwrap_or(0);
            self.push(around(ear));
            left.remove(ear);
        }
    }

    /// Skins a stack of rings that each run counter-clockwise about the way the stack goes, and closes both ends.
    pub fn loft(rings: &[Vec<Vec3>]) -> Self {
        let mut shape = Self::default();
        shape.fill(rings[0].iter().rev().copied());
        for pair in rings.windows(2) {
            let count = pair[0].len();
            for (i, j) in (0..count).map(|i| (i, (i + 1) % count)) {
                let [a, b, c, d] = [pair[0][i], pair[0][j], pair[1][j], pair[1][i]];
                shape.push([a, b, c]);
                shape.push([a, c, d]);
            }
        }
        shape.fill(rings[rings.len() - 1].iter().copied());
        shape
    }

    /// An outline in x and y made `depth` thick, half of it to either side of z = 0.
    pub fn extrude(outline: &[[f32; 2]], depth: f32) -> Self {
        let ring = |z| outline.iter().map(|&[x, y]| vec3(x, y, z)).collect();
        Self::loft(&[ring(-depth / 2.0), ring(depth / 2.0)])
    }

    /// A ground plan in x and z pulled up.
    pub fn prism(plan: &[[f32; 2]], height: f32) -> Self {
        Self::loft(&[level_ring(plan, 0.0), level_ring(plan, height)])
    }

    pub fn cuboid(width: f32, height: f32, depth: f32) -> Self {
        Self::prism(&rect(width, depth), height)
    }

    /// A box whose top is of another size than its bottom (width and depth each): plinth, hipped roof, pyramid.
    pub fn taper(bottom: [f32; 2], top: [f32; 2], height: f32) -> Self {
        let ring = |[width, depth]: [f32; 2], y| level_ring(&rect(width, depth), y);
        Self::loft(&[ring(bottom, 0.0), ring(top, height)])
    }

    /// A surface of revolution through points (radius, height), from the bottom to the top along the outside.
    pub fn lathe(profile: &[[f32; 2]], segments: usize) -> Self {
        let rings: Vec<_> = profile.iter().map(|&[radius, y]| circle(radius, y, segments)).collect();
        Self::loft(&rings).smooth()
    }

    pub fn cylinder(radius: f32, height: f32, segments: usize) -> Self {
        Self::lathe(&[[radius, 0.0], [radius, height]], segments)
    }

    pub fn cone(radius: f32, height: f32, segments: usize) -> Self {
        Self::lathe(&[[radius, 0.0], [0.0, height]], segments)
    }

    /// A round pipe along points that each have a radius.
    pub fn tube(path: &[(Vec3, f32)], segments: usize) -> Self {
        let mut side = Vec3::ZERO;
        let rings: Vec<Vec<Vec3>> = (0..path.len())
            .map(|i| {
                let way = (path[(i + 1).min(path.len() - 1)].0 - path[i.saturating_sub(1)].0).normalized();
                if i == 0 {
                    side = if way.z.abs() < 0.8 {
                        vec3(0.0, 0.0, 1.0)
                    } else {
                        vec3(1.0, 0.0, 0.0)
                    };
                }
                side = (side - way * side.dot(way)).normalized();
                let up = way.cross(side);
                let (center, radius) = path[i];
                let on_ring = |k| {
                    let (cos, sin) = cos_sin(k as f32 / segments as f32);
                    center + side * (radius * cos) + up * (radius * sin)
                };
                (0..segments).map(on_ring).collect()
            })
            .collect();
        Self::loft(&rings).smooth()
    }

    /// A ball around the origin, faceted as an icosahedron split `splits` times, whose radius depends on the direction.
    pub fn blob(splits: usize, radius: impl Fn(Vec3) -> f32) -> Self {
        let mut faces = icosahedron();
        for _ in 0..splits {
            faces = faces
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalized);
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        let mut shape = Self::default();
        for face in faces {
            shape.push(face.map(|way| way * radius(way)));
        }
        shape
    }
}

/// How to change one.
impl Shape {
    /// Rounds the shading over edges that are less sharp than about 63 degrees.
    pub fn smooth(mut self) -> Self {
        const CREASE: f32 = 0.45;
        let key = |p: Vec3| p.to_array().map(|c| (c * 4096.0).round() as i32);
        let mut faces_at = BTreeMap::<_, Vec<(Vec3, Vec3)>>::new();
        for [a, b, c] in self.triangles.iter().map(|t| t.map(|corner| corner.position)) {
            let area = (b - a).cross(c - a);
            for point in [a, b, c] {
                faces_at.entry(key(point)).or_default().push((area, area.normalized()));
            }
        }
        for triangle in &mut self.triangles {
            let [a, b, c] = triangle.map(|corner| corner.position);
            let own = (b - a).cross(c - a).normalized();
            for corner in triangle {
                let near = faces_at[&key(corner.position)]
                    .iter()
                    .filter(|(_, normal)| normal.dot(own) > CREASE);
                corner.normal = near.fold(Vec3::ZERO, |sum, &(area, _)| sum + area).normalized();
            }
        }
        self
    }

    pub fn painted(self, color: Color) -> Self {
        self.painted_by(|_| color)
    }

    /// Paints each corner by its position.
    pub fn painted_by(mut self, color: impl Fn(Vec3) -> Color) -> Self {
        for corner in self.triangles.iter_mut().flatten() {
            corner.color = color(corner.position);
        }
        self
    }

    pub fn at(mut self, x: f32, y: f32, z: f32) -> Self {
        for corner in self.triangles.iter_mut().flatten() {
            corner.position += vec3(x, y, z);
        }
        self
    }

    /// Stretches along the axes, all by more than zero.
    pub fn scaled(mut self, x: f32, y: f32, z: f32) -> Self {
        for corner in self.triangles.iter_mut().flatten() {
            corner.position = corner.position.scaled(vec3(x, y, z));
            corner.normal = corner.normal.scaled(vec3(1.0 / x, 1.0 / y, 1.0 / z)).normalized();
        }
        self
    }

    /// Moves every corner; the shading stays as it is.
    pub fn moved(mut self, to: impl Fn(Vec3) -> Vec3) -> Self {
        for corner in self.triangles.iter_mut().flatten() {
            corner.position = to(corner.position);
        }
        self
    }

    /// Turns about the x axis, from +y towards +z.
    pub fn turned_x(self, turns: f32) -> Self {
        let (cos, sin) = cos_sin(turns);
        self.turned(|v| vec3(v.x, v.y * cos - v.z * sin, v.y * sin + v.z * cos))
    }

    /// Turns about the y axis, from +z towards +x.
    pub fn turned_y(self, turns: f32) -> Self {
        let (cos, sin) = cos_sin(turns);
        self.turned(|v| vec3(v.x * cos + v.z * sin, v.y, v.z * cos - v.x * sin))
    }

    /// Turns about the z axis, from +x towards +y.
    pub fn turned_z(self, turns: f32) -> Self {
        let (cos, sin) = cos_sin(turns);
        self.turned(|v| vec3(v.x * cos - v.y * sin, v.x * sin + v.y * cos, v.z))
    }

    fn turned(mut self, turn: impl Fn(Vec3) -> Vec3) -> Self {
        for corner in self.triangles.iter_mut().flatten() {
            corner.position = turn(corner.position);
            corner.normal = turn(corner.normal);
        }
        self
    }

    /// Copies of this shape at each of the offsets.
    pub fn copied(&self, offsets: impl IntoIterator<Item = [f32; 3]>) -> Self {
        let mut copies = Self::default();
        for [x, y, z] in offsets {
            copies += self.clone().at(x, y, z);
        }
        copies
    }

    /// `count` copies of this shape around the y axis, this one the first.
    pub fn around(&self, count: usize) -> Self {
        let mut copies = Self::default();
        for i in 0..count {
            copies += self.clone().turned_y(i as f32 / count as f32);
        }
        copies
    }

    /// The mirror image in the plane x = 0.
    pub fn mirrored(mut self) -> Self {
        let flip = vec3(-1.0, 1.0, 1.0);
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
            for corner in triangle {
                corner.position = corner.position.scaled(flip);
                corner.normal = corner.normal.scaled(flip);
            }
        }
        self
    }

    /// This shape and its mirror image in the plane x = 0.
    pub fn both_sides(self) -> Self {
        let mirrored = self.clone().mirrored();
        self + mirrored
    }

    pub fn bounds(&self) -> Bounds {
        let far = vec3(f32::INFINITY, f32::INFINITY, f32::INFINITY);
        let empty = Bounds { min: far, max: -far };
        self.triangles.iter().flatten().fold(empty, |bounds, corner| Bounds {
            min: bounds.min.min(corner.position),
            max: bounds.max.max(corner.position),
        })
    }

    /// Moves and stretches this shape so that it fills `target`.
    pub fn fitted(self, target: Bounds) -> Self {
        let Bounds { min, max } = self.bounds();
        let (from, to) = ((max - min).to_array(), (target.max - target.min).to_array());
        let [x, y, z] = std::array::from_fn(|i| to[i] / from[i]);
        self.at(-min.x, -min.y, -min.z)
            .scaled(x, y, z)
            .at(target.min.x, target.min.y, target.min.z)
    }
}

/// A level ring through a plan in x and z, counter-clockwise about +y.
pub fn level_ring(plan: &[[f32; 2]], y: f32) -> Vec<Vec3> {
    plan.iter().rev().map(|&[x, z]| vec3(x, y, z)).collect()
}

/// A level ring of `segments` points around the y axis.
pub fn circle(radius: f32, y: f32, segments: usize) -> Vec<Vec3> {
    let plan: Outline = (0..segments)
        .map(|i| {
            let (cos, sin) = cos_sin(i as f32 / segments as f32);
            [radius * cos, radius * sin]
        })
        .collect();
    level_ring(&plan, y)
}

fn icosahedron() -> Vec<[Vec3; 3]> {
    let (poles, (ring, rise)) = ([Vec3::Y, -Vec3::Y], (0.894_427_2, 0.447_213_6));
    let point = |i: usize, y: f32, shift: f32| {
        let (cos, sin) = cos_sin((i as f32 + shift) / 5.0);
        vec3(ring * sin, y, ring * cos)
    };
    (0..5)
        .flat_map(|i| {
            let [a, b] = [point(i, rise, 0.0), point(i + 1, rise, 0.0)];
            let [c, d] = [point(i, -rise, 0.5), point(i + 1, -rise, 0.5)];
            [[poles[0], a, b], [a, c, b], [b, c, d], [poles[1], d, c]]
        })
        .collect()
}
