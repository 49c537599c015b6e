//! Cars, driving towards +z.

use crate::Level;
use crate::color::*;
use crate::math::{Vec3, vec3};
use crate::outline::{Outline, arc, rounded};
use crate::shape::Shape;

/// What tells one car from another: measures of its side, as (z, y), and its looks.
struct Car {
    half_width: f32,
    axles: [f32; 2],
    wheel: f32,
    /// The body from the front bumper's lower edge over bonnet and boot to the rear bumper's.
    body: Outline,
    /// The waist and the roof of the cabin, from the rear to the front each.
    waist: [f32; 3],
    roof: [f32; 3],
    paint: Color,
}

impl Car {
    /// The side of the body with its wheel arches.
    fn side(&self, level: Level) -> Outline {
        let mut side = self.body.clone();
        if level == Level::Far {
            return side;
        }
        for axle in self.axles {
            side.extend(arc(
                [axle, self.wheel],
                self.wheel + 0.07,
                [0.5, 0.0],
                level.pick(10, 4, 0),
            ));
        }
        side
    }

    /// A cross-section at `x`, drawn in by `inset` all around its middle.
    fn section(side: &[[f32; 2]], x: f32, inset: f32) -> Vec<Vec3> {
        let point = |&[z, y]: &[f32; 2]| vec3(x, 0.62 + (y - 0.62) * (1.0 - inset * 1.6), z * (1.0 - inset));
        side.iter().rev().map(point).collect()
    }

    fn shape(&self, level: Level) -> Shape {
        let x = self.half_width;
        let side = self.side(level);
        let section = |x, inset| Self::section(&side, x, inset);
        let rings = match level {
            Level::Full => vec![
                section(-x, 0.045),
                section(0.06 - x, 0.01),
                section(0.2 - x, 0.0),
                section(x - 0.2, 0.0),
                section(x - 0.06, 0.01),
                section(x, 0.045),
            ],
            Level::Middle => vec![
                section(-x, 0.04),
                section(0.15 - x, 0.0),
                section(x - 0.15, 0.0),
                section(x, 0.04),
            ],
            Level::Far => vec![section(-x, 0.01), section(x, 0.01)],
        };
        let mut car = Shape::loft(&rings).smooth().painted(self.paint);
        car += self.cabin(level);
        for axle in self.axles {
            car += self
                .wheel(level)
                .at(x - level.pick(0.2, 0.2, 0.17), self.wheel, axle)
                .both_sides();
        }
        car
    }

    /// Glass under a roof, with pillars.
    fn cabin(&self, level: Level) -> Shape {
        let ([rear, front, waist], [roof_rear, roof_front, top]) = (self.waist, self.roof);
        let (low, high) = (self.half_width - 0.1, self.half_width - 0.24);
        let ring = |x: f32, rear: f32, front: f32, y: f32| {
            vec![
                vec3(-x, y, front),
                vec3(x, y, front),
                vec3(x, y, rear),
                vec3(-x, y, rear),
            ]
        };
        let rings = [
            ring(low, rear, front, waist - 0.04),
            ring(high, roof_rear, roof_front, top - 0.05),
        ];
        let mut cabin = Shape::loft(&rings).painted(DEEP_GLASS);
        let (length, middle) = (roof_front - roof_rear, (roof_front + roof_rear) / 2.0);
        let plan = |grow: f32| rounded(2.0 * high + grow, length + grow, 0.12, level.pick(3, 1, 1));
        let roof = match level {
            Level::Full => {
                let ring = |grow, y| crate::shape::level_ring(&plan(grow), y);
                Shape::loft(&[ring(0.1, 0.0), ring(0.06, 0.05), ring(-0.2, 0.09)]).smooth()
            }
            Level::Middle => Shape::prism(&plan(0.08), 0.09),
            Level::Far => Shape::cuboid(2.0 * high + 0.08, 0.09, length + 0.08),
        };
        cabin += roof.painted(self.paint).at(0.0, top - 0.09, middle);
        if level == Level::Far {
            return cabin;
        }
        let pillar = |z: f32, roof_z: f32| {
            let (foot, head) = (vec3(low, waist - 0.08, z), vec3(high, top - 0.06, roof_z));
            Shape::tube(&[(foot, 0.05), (head, 0.05)], level.pick(6, 4, 3))
        };
        let between = (rear + front) / 2.0 - 0.1;
        let pillars = pillar(rear, roof_rear) + pillar(front, roof_front) + pillar(between, between);
        cabin + pillars.painted(self.paint).both_sides()
    }

    /// A wheel on the right-hand side, its hub outwards along +x.
    fn wheel(&self, level: Level) -> Shape {
        let (r, round) = (self.wheel, level.pick(24, 12, 8));
        let tyre = match level {
            Level::Full => Shape::lathe(
                &[
                    [r - 0.04, -0.1],
                    [r, -0.06],
                    [r, 0.16],
                    [r - 0.05, 0.2],
                    [r * 0.66, 0.2],
                    [r * 0.62, 0.16],
                ],
                round,
            ),
            Level::Middle => Shape::lathe(&[[r, -0.1], [r, 0.16], [r - 0.06, 0.2]], round),
            Level::Far => Shape::cylinder(r, 0.2, round),
        };
        let mut wheel = tyre.painted(RUBBER);
        if level != Level::Far {
            wheel += Shape::cylinder(r * 0.6, 0.02, level.pick(20, 6, 4)).painted(STEEL).at(
                0.0,
                level.pick(0.15, 0.19, 0.0),
                0.0,
            );
        }
        if level == Level::Full {
            wheel += Shape::cylinder(r * 0.16, 0.05, 8).painted(STEEL).at(0.0, 0.15, 0.0);
            let spoke = Shape::cuboid(r * 0.13, 0.04, r * 0.5)
                .painted(IRON)
                .at(0.0, 0.15, r * 0.32);
            wheel += spoke.around(5);
        }
        wheel.turned_z(-0.25)
    }
}

/// A box for one side, and its mirror image for the other.
fn pair(size: [f32; 3], color: Color, at: [f32; 3]) -> Shape {
    let [width, height, depth] = size;
    let [x, y, z] = at;
    Shape::cuboid(width, height, depth)
        .painted(color)
        .at(x, y, z)
        .both_sides()
}

/// A family car.
pub fn car_sedan(level: Level) -> Shape {
    let body = vec![
        [2.16, 0.3],
        [2.2, 0.5],
        [2.12, 0.72],
        [1.0, 0.92],
        [-1.55, 0.96],
        [-2.1, 0.9],
        [-2.2, 0.6],
        [-2.14, 0.3],
    ];
    let sedan = Car {
        half_width: 0.89,
        axles: [-1.3, 1.35],
        wheel: 0.32,
        body,
        waist: [-1.75, 1.05, 0.94],
        roof: [-1.0, 0.25, 1.44],
        paint: TEAL,
    };
    let mut car = sedan.shape(level);
    car += pair([0.36, 0.13, 0.2], LAMPLIGHT, [0.58, 0.58, 2.08]);
    car += pair([0.4, 0.14, 0.2], RED, [0.58, 0.68, -2.1]);
    car += pair([0.22, 0.14, 0.1], TEAL, [0.86, 0.94, 0.62]);
    if level == Level::Far {
        return car;
    }
    let bumper = Shape::prism(&rounded(1.72, 0.3, 0.1, level.pick(3, 1, 1)), 0.16).painted(IRON);
    car += bumper.copied([[0.0, 0.32, 2.08], [0.0, 0.32, -2.08]]);
    car += Shape::cuboid(0.66, 0.12, 0.16).painted(RUBBER).at(0.0, 0.58, 2.12);
    if level == Level::Full {
        car += pair([0.04, 0.03, 0.18], STEEL, [0.885, 0.8, -0.75]);
        car += pair([0.04, 0.03, 0.18], STEEL, [0.885, 0.8, 0.3]);
        car += pair([0.05, 0.06, 1.75], IRON, [0.87, 0.3, 0.02]);
        car += Shape::cuboid(0.5, 0.12, 0.06)
            .painted(CREAM)
            .copied([[0.0, 0.36, 2.22], [0.0, 0.62, -2.2]]);
        car += pair([0.1, 0.08, 0.06], AMBER, [0.8, 0.48, 2.17]);
        let slat = Shape::cuboid(0.64, 0.02, 0.18).painted(STEEL);
        car += slat.copied([0.6, 0.635, 0.67].map(|y| [0.0, y, 2.12]));
    }
    car
}

/// A delivery van.
pub fn car_van(level: Level) -> Shape {
    let body = vec![
        [2.46, 0.35],
        [2.5, 0.6],
        [2.42, 0.95],
        [1.75, 1.15],
        [1.15, 1.98],
        [0.95, 2.1],
        [-2.35, 2.14],
        [-2.46, 2.0],
        [-2.5, 0.55],
        [-2.46, 0.35],
    ];
    let van = Car {
        half_width: 0.98,
        axles: [-1.5, 1.55],
        wheel: 0.35,
        body,
        waist: [0.2, 1.3, 1.2],
        roof: [0.3, 0.9, 1.9],
        paint: CREAM,
    };
    let mut car = van.shape(level);
    car += pair([0.3, 0.2, 0.3], LAMPLIGHT, [0.7, 0.72, 2.32]);
    car += pair([0.16, 0.5, 0.2], RED, [0.84, 0.85, -2.42]);
    let windscreen = Shape::cuboid(1.66, 0.88, 0.06).painted(DEEP_GLASS).turned_x(-0.1);
    car += windscreen.at(0.0, 1.18, 1.74);
    let door: Outline = vec![[1.5, 1.2], [1.04, 1.85], [0.35, 1.85], [0.35, 1.2]];
    let door = Shape::extrude(&door, 1.97).painted(DEEP_GLASS).turned_y(-0.25);
    car += door;
    car += pair([0.16, 0.26, 0.12], RUBBER, [1.03, 1.22, 1.3]);
    car += pair([0.06, 0.06, 2.9], STEEL, [0.72, 2.13, -0.8]);
    car += pair([0.02, 0.2, 3.5], TEAL, [0.975, 0.95, -0.6]);
    if level == Level::Far {
        return car;
    }
    let bumper = Shape::prism(&rounded(1.9, 0.3, 0.1, level.pick(3, 1, 1)), 0.22).painted(IRON);
    car += bumper.copied([[0.0, 0.36, 2.4], [0.0, 0.36, -2.4]]);
    car += Shape::cuboid(0.9, 0.2, 0.2).painted(RUBBER).at(0.0, 0.72, 2.4);
    car += pair([0.66, 0.6, 0.06], DEEP_GLASS, [0.42, 1.3, -2.47]);
    if level == Level::Full {
        car += pair([0.04, 0.04, 0.2], IRON, [0.98, 1.05, 0.45]);
        car += pair([0.03, 0.04, 2.0], IRON, [0.975, 1.25, -1.3]);
        car += pair([0.05, 0.08, 1.9], IRON, [0.96, 0.34, 0.02]);
        car += Shape::cuboid(0.03, 1.5, 0.08).painted(IRON).at(0.0, 0.55, -2.47);
        car += Shape::cuboid(0.5, 0.13, 0.06)
            .painted(CREAM)
            .copied([[0.0, 0.42, 2.54], [0.45, 0.7, -2.5]]);
        let rack = Shape::cuboid(1.5, 0.06, 0.06).painted(STEEL);
        car += rack.copied([-2.0, -1.2, -0.4, 0.4].map(|z| [0.0, 2.17, z]));
    }
    car
}
