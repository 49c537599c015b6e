//! Tall buildings.

use crate::Level;
use crate::color::*;
use crate::math::{Vec3, cos_sin, vec3};
use crate::outline::{Outline, arc, arched, rounded, spread};
use crate::shape::{Shape, level_ring};

/// Three glass drums with floor slabs and fins, and a copper dome with a mast.
pub fn round(level: Level) -> Shape {
    const FLOOR: f32 = 3.5;
    let segments = level.pick(32, 16, 10);
    let mut tower = Shape::cylinder(9.6, 0.8, segments).painted(PAVING);
    let mut y = 0.8;
    for (radius, floors) in [(9.0, 6), (7.4, 5), (5.8, 3)] {
        let height = FLOOR * floors as f32;
        let glass = GLASS.mix(LIMESTONE, level.pick(0.0, 0.0, 0.15));
        tower += Shape::cylinder(radius - 0.3, height, segments)
            .painted(glass)
            .at(0.0, y, 0.0);
        let slab = Shape::cylinder(radius, level.pick(0.7, 0.7, 1.0), segments).painted(LIMESTONE);
        for floor in (1..=floors).filter(|&floor| level != Level::Far || (floors - floor) % 2 == 0) {
            tower += slab.clone().at(0.0, y + FLOOR * floor as f32 - 0.7, 0.0);
        }
        if level == Level::Full {
            let fin = Shape::cuboid(0.3, height - 0.1, 0.4).painted(SANDSTONE);
            tower += fin.at(0.0, y, radius - 0.15).around(16);
        }
        y += height;
    }
    let mut dome: Outline = vec![[5.0, -0.7]];
    dome.extend(arc([0.0, 0.0], 5.0, [0.0, 0.25], level.pick(6, 3, 2)));
    let dome = Shape::lathe(&dome, segments).scaled(1.0, 0.75, 1.0);
    tower += dome.painted(COPPER).at(0.0, y + 0.5, 0.0);
    let mast = Shape::lathe(&[[0.5, 0.0], [0.25, 1.6], [0.2, 1.7], [0.0, 7.0]], level.pick(12, 6, 4));
    tower + mast.painted(BRASS).at(0.0, y + 4.0, 0.0)
}

/// A square tower that makes a quarter turn on its way up.
pub fn twisted(level: Level) -> Shape {
    const FLOORS: usize = 20;
    const FLOOR: f32 = 3.0;
    const WIDTH: f32 = 15.0;
    let plan = rounded(WIDTH, WIDTH, 1.6, 1);
    let turned = |plan: &[[f32; 2]], y: f32| -> Vec<Vec3> {
        let (cos, sin) = cos_sin(0.25 * y / (FLOORS as f32 * FLOOR));
        let turn = |p: Vec3| vec3(p.x * cos + p.z * sin, p.y, p.z * cos - p.x * sin);
        level_ring(plan, y).into_iter().map(turn).collect()
    };
    let body = |plan: &[[f32; 2]], from: f32, to: f32, steps: usize| {
        let height = |i| from + (to - from) * i as f32 / steps as f32;
        let rings: Vec<_> = (0..=steps).map(|i| turned(plan, height(i))).collect();
        Shape::loft(&rings).smooth()
    };
    let top = FLOORS as f32 * FLOOR;
    let glass = DEEP_GLASS.mix(GLASS, 0.4).mix(PLASTER, level.pick(0.0, 0.0, 0.1));
    let mut tower = body(&plan, 0.0, top, level.pick(FLOORS * 2, FLOORS, FLOORS / 2)).painted(glass);
    let wider: Outline = plan.iter().map(|&[x, z]| [x * 1.035, z * 1.035]).collect();
    for floor in (0..=FLOORS).step_by(level.pick(1, 1, 4)) {
        let y = floor as f32 * FLOOR;
        tower += body(&wider, y, y + 0.8, 1).painted(PLASTER);
    }
    if level == Level::Full {
        for x in spread(5, 13.0) {
            let blade = [[x - 0.15, 7.3], [x + 0.15, 7.3], [x + 0.15, 7.75], [x - 0.15, 7.75]];
            tower += body(&blade, 0.1, top, FLOORS).painted(BRASS).around(4);
        }
    }
    let crown: Outline = plan.iter().map(|&[x, z]| [x * 0.7, z * 0.7]).collect();
    tower += body(&crown, top - 0.1, top + 3.0, 1).painted(PLASTER.mix(STEEL, 0.5));
    tower
        + Shape::cone(0.4, 8.0, level.pick(8, 4, 3))
            .painted(STEEL)
            .at(0.0, top + 2.9, 0.0)
}

/// Art deco: setbacks with stone piers, brick spandrels between dark windows, and a copper crown.
pub fn stepped(level: Level) -> Shape {
    let mut tower = Shape::cuboid(23.0, 1.2, 23.0).painted(PAVING);
    let mut y = 1.2;
    for (width, floors, piers) in [(21.5, 5, 9), (17.0, 5, 7), (12.5, 4, 5), (8.0, 3, 4)] {
        let height = floors as f32 * 3.4;
        let wall = level.pick(
            DEEP_GLASS,
            DEEP_GLASS.mix(DARK_BRICK, 0.2),
            DEEP_GLASS.mix(SANDSTONE, 0.75),
        );
        tower += Shape::cuboid(width - 0.6, height, width - 0.6)
            .painted(wall)
            .at(0.0, y, 0.0);
        if level != Level::Far {
            let piers = level.pick(piers, piers / 2, 0);
            let pier = Shape::cuboid(level.pick(0.9, 1.4, 0.0), height + 0.6, width + 0.3).painted(SANDSTONE);
            tower += pier.copied(spread(piers, width - 2.6).map(|x| [x, y, 0.0]));
            tower += pier
                .turned_y(0.25)
                .copied(spread(piers, width - 2.6).map(|z| [0.0, y, z]));
            let corner = Shape::cuboid(1.5, height + 1.0, 1.5).painted(LIMESTONE);
            tower += corner.at(width / 2.0 - 0.65, y, width / 2.0 - 0.65).around(4);
        }
        if level == Level::Full {
            for floor in 0..floors {
                let band = Shape::cuboid(width - 0.3, 1.2, width - 0.3).painted(DARK_BRICK);
                tower += band.at(0.0, y + floor as f32 * 3.4, 0.0);
            }
        }
        y += height;
        let cornice = Shape::cuboid(width + 0.1, 0.9, width + 0.1).painted(LIMESTONE);
        tower += cornice.at(0.0, y - 0.45, 0.0);
    }
    for (width, height) in [(5.6, 1.8), (4.0, 1.6)] {
        tower += Shape::cuboid(width, height, width).painted(LIMESTONE).at(0.0, y, 0.0);
        y += height;
    }
    tower += Shape::taper([3.4, 3.4], [0.5, 0.5], 5.0)
        .painted(COPPER)
        .at(0.0, y, 0.0);
    tower += Shape::cone(0.25, 4.5, level.pick(8, 4, 3))
        .painted(BRASS)
        .at(0.0, y + 4.9, 0.0);
    if level == Level::Far {
        return tower;
    }
    let arch = arched(4.0, 6.0, level.pick(10, 4, 2));
    tower += Shape::extrude(&arch, 0.8).painted(LIMESTONE).at(0.0, 1.0, 10.7);
    let door = arched(3.0, 5.3, level.pick(10, 4, 2));
    tower
        + Shape::extrude(&door, 1.0)
            .painted(BRASS.mix(IRON, 0.6))
            .at(0.0, 1.0, 10.7)
}

/// A slab of glass on a recessed lobby, ruled by floors and mullions, beside a core of stone.
pub fn glass(level: Level) -> Shape {
    const HEIGHT: f32 = 52.0;
    let mut tower = Shape::cuboid(24.0, 0.4, 14.0).painted(PAVING);
    tower += Shape::cuboid(20.0, 5.0, 9.0).painted(DEEP_GLASS).at(0.0, 0.3, 0.0);
    let pane = GLASS.mix(PLASTER, level.pick(0.0, 0.05, 0.16));
    tower += Shape::cuboid(22.0, HEIGHT - 5.0, 12.0).painted(pane).at(0.0, 5.0, 0.0);
    let floors = level.pick(15, 8, 4);
    for y in spread(floors, HEIGHT - 5.0 + (HEIGHT - 5.0) / floors as f32) {
        tower += Shape::cuboid(22.3, 0.5, 12.3).painted(PLASTER).at(0.0, y + 28.2, 0.0);
    }
    let mullions = level.pick(18, 6, 0);
    let mullion = Shape::cuboid(0.18, HEIGHT - 4.6, 12.7).painted(STEEL);
    tower += mullion.copied(spread(mullions, 22.0).map(|x| [x, 4.9, 0.0]));
    let across = Shape::cuboid(22.7, HEIGHT - 4.6, 0.18).painted(STEEL);
    tower += across.copied(spread(mullions / 2, 12.0).map(|z| [0.0, 4.9, z]));
    let core = Shape::cuboid(5.0, HEIGHT + 5.0, 5.0).painted(SANDSTONE);
    tower += core.at(-6.5, 0.3, -4.4);
    tower += Shape::cuboid(9.0, 2.8, 6.0).painted(CONCRETE).at(4.5, HEIGHT, 0.0);
    if level != Level::Far {
        let post = Shape::cylinder(0.4, 5.0, level.pick(12, 6, 4)).painted(LIMESTONE);
        tower += post.copied(spread(5, 24.0).map(|x| [x, 0.2, 5.4]));
    }
    if level == Level::Full {
        let fan = Shape::cylinder(0.9, 0.6, 16).painted(STEEL);
        tower += fan.copied(spread(3, 7.5).map(|x| [x + 4.5, HEIGHT + 2.6, 0.0]));
        tower += Shape::cuboid(7.0, 0.3, 2.4).painted(STEEL).at(0.0, 3.6, 5.8);
    }
    tower
}

/// Streamlined bands of brick and glass around rounded corners.
pub fn office_block(level: Level) -> Shape {
    const FLOORS: usize = 6;
    let plan = |inset: f32| {
        let steps = level.pick(8, 3, 1);
        rounded(20.0 - 2.0 * inset, 15.0 - 2.0 * inset, 4.5 - inset, steps)
    };
    let prism = |inset: f32, height: f32| Shape::prism(&plan(inset), height).smooth();
    let floor_height = 3.6;
    let top = 1.0 + FLOORS as f32 * floor_height;
    let mut block = prism(-0.2, 1.0).painted(PAVING);
    let window = DEEP_GLASS.mix(PLASTER, level.pick(0.0, 0.03, 0.0));
    block += prism(0.35, top - 1.0).painted(window).at(0.0, 0.9, 0.0);
    for floor in 1..=FLOORS {
        let y = 1.0 + floor as f32 * floor_height;
        block += prism(0.0, 1.9).painted(BRICK).at(0.0, y - 0.9, 0.0);
        if level == Level::Full {
            let ledge = prism(-0.12, 0.2).painted(LIMESTONE);
            block += ledge.copied([[0.0, y + 0.95, 0.0], [0.0, y - 1.05, 0.0]]);
        }
    }
    block += prism(-0.12, 0.25).painted(LIMESTONE).at(0.0, top + 0.95, 0.0);
    let mullions = level.pick(9, 3, 0);
    let along = Shape::cuboid(0.3, top - 1.0, 14.7).painted(LIMESTONE);
    block += along.copied(spread(mullions, 12.5).map(|x| [x, 0.95, 0.0]));
    let across = Shape::cuboid(19.7, top - 1.0, 0.3).painted(LIMESTONE);
    block += across.copied(spread(mullions * 2 / 3, 8.0).map(|z| [0.0, 0.95, z]));
    block += Shape::cuboid(6.0, 3.0, 5.0).painted(CONCRETE).at(-3.0, top, -2.0);
    if level != Level::Far {
        block += Shape::cuboid(5.0, 0.35, 2.6).painted(LIMESTONE).at(0.0, 4.0, 7.6);
        block += Shape::cuboid(3.6, 2.8, 0.5)
            .painted(BRASS.mix(IRON, 0.5))
            .at(0.0, 1.0, 7.2);
        let plant = Shape::cuboid(2.4, 1.3, 1.8).painted(STEEL);
        block += plant.copied([[4.0, top + 0.9, 2.0], [4.0, top + 0.9, -2.0]]);
    }
    block
}
