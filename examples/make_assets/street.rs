//! What stands on a pavement.

use crate::Level;
use crate::color::*;
use crate::math::{Vec3, cos_sin, vec3};
use crate::outline::{Outline, arc, rounded, spread};
use crate::shape::Shape;

/// A cast-iron post with two lanterns on curved arms.
pub fn lamp_street(level: Level) -> Shape {
    let round = level.pick(14, 7, 4);
    let post = match level {
        Level::Full => Shape::lathe(
            &[
                [0.24, 0.0],
                [0.24, 0.2],
                [0.17, 0.28],
                [0.14, 0.75],
                [0.17, 0.85],
                [0.09, 0.95],
                [0.06, 4.2],
                [0.1, 4.28],
                [0.05, 4.36],
                [0.05, 4.75],
                [0.0, 5.0],
            ],
            round,
        ),
        Level::Middle => Shape::lathe(
            &[[0.24, 0.0], [0.15, 0.8], [0.07, 0.95], [0.06, 4.7], [0.0, 5.0]],
            round,
        ),
        Level::Far => Shape::lathe(&[[0.2, 0.0], [0.06, 1.0], [0.03, 5.0]], 3),
    };
    let steps = level.pick(8, 3, 1);
    let arm: Vec<(Vec3, f32)> = (0..=steps)
        .map(|i| {
            let (cos, sin) = cos_sin(0.5 - 0.5 * i as f32 / steps as f32);
            (vec3(0.33 + 0.33 * cos, 4.3 + 0.3 * sin, 0.0), 0.035)
        })
        .collect();
    let mut side = Shape::tube(&arm, level.pick(7, 4, 3));
    side += Shape::lathe(&[[0.2, 0.0], [0.2, 0.04], [0.03, 0.18], [0.0, 0.24]], round).at(0.66, 4.22, 0.0);
    let mut lantern = Shape::lathe(&[[0.08, 3.86], [0.17, 4.23]], round).painted(LAMPLIGHT);
    if level == Level::Full {
        let rim = Shape::lathe(&[[0.0, 3.76], [0.1, 3.82], [0.1, 3.87]], round);
        lantern += rim.painted(IRON);
        let bar = Shape::tube(&[(vec3(0.09, 3.85, 0.0), 0.012), (vec3(0.18, 4.23, 0.0), 0.012)], 4);
        lantern += bar.painted(IRON).around(6);
    }
    post.painted(IRON) + (side.painted(IRON) + lantern.at(0.66, 0.0, 0.0)).both_sides()
}

/// Wooden slats between cast sides.
pub fn bench(level: Level) -> Shape {
    let mut bench = Shape::default();
    let slat = |depth: f32| Shape::prism(&rounded(1.8, depth, 0.02, 1), 0.04).painted(WOOD);
    match level {
        Level::Full => {
            bench += slat(0.1).copied(spread(4, 0.48).map(|z| [0.0, 0.43, z + 0.04]));
            for (y, z) in [(0.56, -0.23), (0.69, -0.26), (0.82, -0.29)] {
                bench += slat(0.1).turned_x(0.23).at(0.0, y, z);
            }
        }
        Level::Middle | Level::Far => {
            bench += Shape::cuboid(1.8, 0.05, 0.48).painted(WOOD).at(0.0, 0.42, 0.04);
            bench += Shape::cuboid(1.8, 0.38, 0.05)
                .turned_x(-0.03)
                .painted(WOOD)
                .at(0.0, 0.5, -0.23);
        }
    }
    let side: Outline = match level {
        Level::Full => vec![
            [0.32, 0.0],
            [0.32, 0.62],
            [-0.18, 0.62],
            [-0.3, 0.9],
            [-0.35, 0.88],
            [-0.24, 0.5],
            [-0.32, 0.0],
            [-0.24, 0.0],
            [-0.18, 0.4],
            [0.26, 0.4],
            [0.26, 0.0],
        ],
        Level::Middle => vec![
            [0.32, 0.0],
            [0.32, 0.62],
            [-0.2, 0.62],
            [-0.3, 0.9],
            [-0.35, 0.88],
            [-0.32, 0.0],
        ],
        Level::Far => vec![[0.32, 0.0], [0.32, 0.55], [-0.35, 0.9], [-0.32, 0.0]],
    };
    let mut cast = Shape::extrude(&side, 0.06).painted(IRON).turned_y(-0.25);
    if level == Level::Full {
        let hole: Outline = vec![[0.3, 0.64], [0.3, 0.67], [-0.2, 0.67], [-0.2, 0.64]];
        cast += Shape::extrude(&hole, 0.09).painted(WOOD).turned_y(-0.25);
        cast += Shape::cuboid(0.12, 0.03, 0.12)
            .painted(IRON)
            .copied([[0.0, 0.0, 0.28], [0.0, 0.0, -0.28]]);
    }
    if level == Level::Far {
        return bench + cast.copied([[-0.8, 0.0, 0.0], [0.8, 0.0, 0.0]]);
    }
    bench + cast.at(0.8, 0.0, 0.0).both_sides()
}

/// A red barrel with a bonnet and three caps.
pub fn hydrant(level: Level) -> Shape {
    let round = level.pick(20, 10, 6);
    let barrel = match level {
        Level::Full => Shape::lathe(
            &[
                [0.2, 0.0],
                [0.2, 0.06],
                [0.14, 0.07],
                [0.13, 0.5],
                [0.17, 0.51],
                [0.17, 0.57],
                [0.14, 0.58],
                [0.13, 0.66],
                [0.08, 0.73],
                [0.035, 0.75],
                [0.035, 0.82],
                [0.0, 0.83],
            ],
            round,
        ),
        Level::Middle => Shape::lathe(
            &[[0.2, 0.0], [0.14, 0.07], [0.15, 0.58], [0.07, 0.74], [0.04, 0.83]],
            round,
        ),
        Level::Far => Shape::lathe(&[[0.18, 0.0], [0.15, 0.58], [0.05, 0.83]], round),
    };
    let mut hydrant = barrel.painted(RED);
    let cap = |radius: f32, reach: f32| -> Shape {
        let sides = level.pick(14, 6, 4);
        let neck = Shape::cylinder(radius * 0.8, reach, sides).painted(RED);
        let lid = Shape::cylinder(radius, 0.05, sides).at(0.0, reach - 0.04, 0.0);
        let nut = Shape::cylinder(radius * 0.3, 0.04, 5).at(0.0, reach, 0.0);
        let cap = match level {
            Level::Full => neck + (lid + nut).painted(CREAM),
            Level::Middle => neck + lid.painted(CREAM),
            Level::Far => Shape::cylinder(radius, reach, sides).painted(CREAM),
        };
        cap.turned_y(0.125).turned_x(0.25)
    };
    hydrant += cap(0.09, 0.21).at(0.0, 0.38, 0.0);
    hydrant += cap(0.065, 0.2).turned_y(0.25).at(0.0, 0.42, 0.0).both_sides();
    if level == Level::Full {
        let bolt = Shape::cylinder(0.018, 0.03, 6).painted(STEEL).at(0.17, 0.05, 0.0);
        hydrant += bolt.around(8);
    }
    hydrant
}

/// A pole with lights to the front and back, and one for those on foot.
pub fn traffic_light(level: Level) -> Shape {
    let round = level.pick(12, 6, 4);
    let pole = Shape::lathe(
        &[[0.16, 0.0], [0.16, 0.25], [0.07, 0.4], [0.06, 3.9], [0.0, 4.0]],
        round,
    );
    let mut light = pole.painted(IRON);
    let mut head = Shape::prism(&rounded(0.36, 0.24, 0.06, level.pick(3, 1, 1)), 1.1).painted(RUBBER);
    if level == Level::Full {
        head += Shape::cuboid(0.56, 1.3, 0.03).painted(RUBBER).at(0.0, -0.1, -0.02);
    }
    for (y, color) in [(0.9, RED), (0.55, AMBER), (0.2, GREEN)] {
        let lens = Shape::cylinder(0.12, 0.04, level.pick(16, 8, 4)).painted(color);
        head += lens.turned_y(0.125).turned_x(0.25).at(0.0, y, 0.1);
        if level == Level::Full {
            let hood = arc([0.0, 0.0], 0.15, [-0.05, 0.55], 8);
            let inner = arc([0.0, 0.0], 0.13, [0.55, -0.05], 8);
            head += Shape::extrude(&[hood, inner].concat(), 0.2)
                .painted(RUBBER)
                .at(0.0, y, 0.2);
        }
    }
    let bracket = Shape::cuboid(0.06, 0.06, 0.2).painted(IRON);
    let heights = level.pick(&[2.9, 3.6][..], &[2.9, 3.6], &[3.3]);
    let head = head.at(0.0, 2.75, 0.24) + bracket.copied(heights.iter().map(|&y| [0.0, y, 0.1]));
    light += head.around(2);
    let mut walk = Shape::cuboid(0.24, 0.5, 0.26).painted(RUBBER);
    for (y, color) in [(0.35, RED), (0.13, GREEN)] {
        walk += Shape::cuboid(0.15, 0.15, 0.3).painted(color).at(0.0, y - 0.07, 0.0);
    }
    light += walk.at(0.2, 1.9, 0.0);
    if level == Level::Full {
        light += Shape::cuboid(0.14, 0.24, 0.12).painted(AMBER).at(0.0, 1.05, 0.09);
        light += Shape::cylinder(0.03, 0.03, 10)
            .painted(STEEL)
            .turned_x(0.25)
            .at(0.0, 1.17, 0.14);
        light += Shape::cylinder(0.26, 0.06, 16).painted(CONCRETE);
    }
    light
}

/// A shelter of glass under a curved roof, with a bench, a poster and a sign.
pub fn bus_stop(level: Level) -> Shape {
    let steps = level.pick(10, 4, 2);
    let upper: Outline = (0..=steps)
        .map(|i| i as f32 / steps as f32)
        .map(|t| [1.0 - 2.0 * t, 2.5 + 0.7 * t * (1.0 - t)])
        .collect();
    let lower = upper.iter().rev().map(|&[z, y]| [z, y - 0.08]);
    let roof: Outline = lower.chain(upper.iter().copied()).collect();
    let mut stop = Shape::extrude(&roof, 4.4).smooth().turned_y(-0.25).painted(TEAL);
    stop += Shape::cuboid(4.2, 0.1, 1.9).painted(PAVING);
    let post = Shape::cuboid(0.09, 2.46, 0.09).painted(IRON);
    let pane = |width: f32| Shape::cuboid(width, 1.85, 0.03).painted(GLASS.mix(WATER, 0.4));
    match level {
        Level::Far => stop += pane(3.8).at(0.0, 0.3, -0.75),
        Level::Full | Level::Middle => {
            stop += pane(0.93).copied(spread(4, 3.9).map(|x| [x, 0.35, -0.75]));
            stop += post.copied(spread(level.pick(5, 2, 0), level.pick(4.85, 7.6, 0.0)).map(|x| [x, 0.08, -0.75]));
        }
    }
    stop += pane(1.4).turned_y(0.25).at(-1.92, 0.35, 0.0);
    stop += post.copied([[-1.92, 0.08, 0.75], [1.92, 0.08, 0.75]]);
    let frame = Shape::cuboid(0.2, 2.1, 1.3).painted(IRON).at(1.92, 0.1, -0.05);
    stop += frame + Shape::cuboid(0.24, 1.7, 1.05).painted(AMBER).at(1.92, 0.3, -0.05);
    stop += Shape::cuboid(2.4, 0.07, 0.4).painted(WOOD).at(-0.3, 0.5, -0.45);
    if level == Level::Full {
        stop += Shape::cuboid(0.08, 0.45, 0.3)
            .painted(IRON)
            .copied([[-1.2, 0.07, -0.45], [0.6, 0.07, -0.45]]);
        stop += Shape::cuboid(3.9, 0.06, 0.06)
            .painted(IRON)
            .copied([[0.0, 0.3, -0.75], [0.0, 2.2, -0.75]]);
        let sun = Shape::cylinder(0.32, 0.26, 20)
            .turned_z(0.25)
            .painted(RED)
            .at(2.05, 1.4, -0.1);
        stop += sun + Shape::cuboid(0.25, 0.14, 0.9).painted(CREAM).at(1.92, 0.55, -0.05);
        let timetable = Shape::cuboid(0.5, 0.7, 0.06).painted(CREAM).at(-0.95, 1.2, -0.74);
        stop += timetable + Shape::cuboid(1.6, 0.24, 0.06).painted(CREAM).at(0.0, 2.44, 0.98);
        let rod = Shape::tube(&[(vec3(0.0, 2.38, 0.85), 0.03), (vec3(0.0, 2.38, -0.85), 0.03)], 6);
        stop += rod.painted(IRON).copied(spread(4, 5.1).map(|x| [x, 0.0, 0.0]));
    }
    stop
}
