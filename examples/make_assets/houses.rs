//! Buildings of a few floors.

use crate::Level;
use crate::color::*;
use crate::outline::{Outline, gabled, rect, spread};
use crate::shape::Shape;

/// A window to set into a wall that faces +z, its sill at the origin.
fn window(level: Level, width: f32, height: f32) -> Shape {
    let pane = Shape::cuboid(width, height, 0.2).painted(DEEP_GLASS);
    if level != Level::Full {
        return pane;
    }
    let frame = Shape::cuboid(width + 0.24, height + 0.24, 0.14)
        .painted(PLASTER)
        .at(0.0, -0.12, 0.0);
    let sill = Shape::cuboid(width + 0.4, 0.14, 0.5)
        .painted(LIMESTONE)
        .at(0.0, -0.2, 0.0);
    let bar = Shape::cuboid(0.08, height, 0.26).painted(PLASTER);
    pane + frame + sill + bar
}

/// Six floors with balconies to the street.
pub fn apartment_block(level: Level) -> Shape {
    const FLOOR: f32 = 3.1;
    let floors = (0..6).map(|floor| 0.6 + floor as f32 * FLOOR);
    let mut block = Shape::cuboid(18.4, 0.7, 12.4).painted(PAVING);
    block += Shape::cuboid(18.0, 19.0, 12.0).painted(SANDSTONE).at(0.0, 0.6, 0.0);
    block += Shape::cuboid(18.1, 3.2, 12.1).painted(LIMESTONE).at(0.0, 0.5, 0.0);
    block += Shape::cuboid(18.6, 0.5, 12.6).painted(LIMESTONE).at(0.0, 19.4, 0.0);
    block += Shape::cuboid(4.0, 2.4, 4.0).painted(CONCRETE).at(0.0, 19.8, -2.0);
    if level == Level::Far {
        let panes = Shape::cuboid(16.6, 1.5, 12.2) + Shape::cuboid(18.2, 1.5, 6.5);
        let panes = panes.painted(DEEP_GLASS.mix(SANDSTONE, 0.4));
        let balcony = Shape::cuboid(5.4, 1.05, 1.5).painted(CREAM);
        let balconies = balcony.copied([[-5.8, 0.0, 6.7], [5.8, 0.0, 6.7]]);
        for y in floors.skip(1) {
            block += panes.clone().at(0.0, y + 1.0, 0.0) + balconies.clone().at(0.0, y, 0.0);
        }
        return block;
    }
    let pane = window(level, 1.5, 1.7);
    for (floor, y) in floors.enumerate() {
        for (bay, x) in spread(6, 17.4).enumerate() {
            block += pane.clone().turned_y(0.5).at(x, y + 0.95, -6.05);
            match (floor, bay) {
                (0, 2) => block += Shape::cuboid(1.8, 2.6, 0.3).painted(TEAL).at(x, y - 0.1, 6.0),
                (0, _) | (_, 2 | 3) => block += pane.clone().at(x, y + 0.95, 6.05),
                _ => block += Shape::cuboid(1.7, 2.3, 0.2).painted(DEEP_GLASS).at(x, y + 0.1, 6.0),
            }
        }
        if floor > 0 {
            block += balcony(level).copied([[-5.8, y, 6.7], [5.8, y, 6.7]]);
        }
        let side = pane.copied([[-2.6, 0.0, 9.08], [2.6, 0.0, 9.08]]);
        block += (side.clone().turned_y(0.25) + side.turned_y(-0.25)).at(0.0, y + 0.95, 0.0);
    }
    block + Shape::cuboid(3.0, 0.25, 1.8).painted(LIMESTONE).at(-1.45, 3.2, 6.8)
}

fn balcony(level: Level) -> Shape {
    let slab = Shape::cuboid(5.4, 0.2, 1.5).painted(LIMESTONE);
    let rail = Shape::prism(
        &[
            [-2.6, -0.75],
            [-2.5, -0.75],
            [-2.5, 0.6],
            [2.5, 0.6],
            [2.5, -0.75],
            [2.6, -0.75],
            [2.6, 0.7],
            [-2.6, 0.7],
        ],
        0.95,
    );
    let balcony = slab + rail.painted(CREAM).at(0.0, 0.1, 0.0);
    if level != Level::Full {
        return balcony;
    }
    let screen = Shape::cuboid(0.12, 2.6, 1.4).painted(WOOD).at(0.0, 0.1, 0.0);
    balcony + Shape::cuboid(5.3, 0.08, 0.16).painted(IRON).at(0.0, 1.05, 0.65) + screen
}

/// Two floors of brick under a pitched roof, with a chimney, a dormer and a porch.
pub fn row_house(level: Level) -> Shape {
    let mut house = Shape::cuboid(8.1, 0.4, 9.8).painted(PAVING);
    house += gable(9.4, 5.6, 8.5, 8.0).painted(BRICK).turned_y(0.25);
    house += roof(9.4, 5.6, 8.5, 8.0, 0.3).painted(SLATE).turned_y(0.25);
    house += Shape::cuboid(0.9, 3.0, 1.3).painted(DARK_BRICK).at(2.9, 6.6, -1.6);
    let door = Shape::cuboid(1.1, 2.3, 0.3).painted(TEAL).at(-2.3, 0.3, 4.7);
    if level == Level::Far {
        let panes = Shape::cuboid(1.5, 1.6, 9.6).painted(DEEP_GLASS);
        return house + door + panes.copied([[1.7, 1.1, 0.0], [1.7, 3.7, 0.0], [-2.2, 3.7, 0.0]]);
    }
    house += door;
    house += Shape::cuboid(2.0, 0.4, 1.1).painted(LIMESTONE).at(-2.3, 0.0, 4.9);
    for (x, y, width) in [(1.7, 1.1, 2.0), (2.1, 3.6, 1.2), (-2.3, 3.6, 1.2)] {
        let pane = window(level, width, 1.5);
        house += pane.clone().at(x, y, 4.73) + pane.turned_y(0.5).at(x, y, -4.73);
    }
    let pots = Shape::cylinder(0.2, 0.5, level.pick(10, 5, 3)).painted(ROOF_TILE);
    house += pots.copied([[2.9, 9.55, -1.9], [2.9, 9.55, -1.3]]);
    house += gable(1.7, 1.3, 2.1, 2.4).painted(PLASTER).at(-0.5, 5.6, 2.6);
    house += roof(1.7, 1.3, 2.1, 2.5, 0.12).painted(SLATE).at(-0.5, 5.6, 2.65);
    if level == Level::Full {
        house += window(level, 0.9, 0.9).at(-0.5, 5.95, 3.82);
        house += Shape::cuboid(1.6, 2.7, 0.2).painted(PLASTER).at(-2.3, 0.3, 4.7);
        house += Shape::cuboid(0.8, 0.3, 0.4).painted(GLASS).at(-2.3, 2.65, 4.65);
        house += Shape::blob(1, |_| 0.07).painted(BRASS).at(-1.9, 1.3, 4.88);
        house += Shape::cuboid(8.06, 0.25, 9.5).painted(LIMESTONE).at(0.0, 3.05, 0.0);
        let pipe = Shape::cylinder(0.07, 5.4, 8).painted(IRON);
        house += pipe.at(3.8, 0.1, 4.78);
        let posts = Shape::cylinder(0.09, 2.6, 8).painted(PLASTER);
        house += posts.copied([[-3.15, 0.3, 5.3], [-1.45, 0.3, 5.3]]);
    }
    house += Shape::taper([2.2, 1.0], [2.2, 0.3], 0.35)
        .painted(SLATE)
        .at(-2.3, 2.85, 5.0);
    house
}

fn gable(width: f32, eaves: f32, ridge: f32, depth: f32) -> Shape {
    Shape::extrude(&gabled(width, eaves, ridge), depth)
}

/// The two slopes over a gable, `thick` and hanging over the walls a little.
fn roof(width: f32, eaves: f32, ridge: f32, depth: f32, thick: f32) -> Shape {
    let (x, hang) = (width / 2.0, thick * 1.2);
    let low = eaves - hang * (ridge - eaves) / x;
    let outline: Outline = vec![
        [x + hang, low],
        [x + hang, low + thick],
        [0.0, ridge + thick],
        [-x - hang, low + thick],
        [-x - hang, low],
        [0.0, ridge - 0.02],
    ];
    Shape::extrude(&outline, depth + hang)
}

/// A shop on a cut corner under a striped awning, with a flat above.
pub fn corner_shop(level: Level) -> Shape {
    let plan = |grow: f32| -> Outline {
        let (x, z, cut) = (5.0 + grow, 5.0 + grow, 2.4 + 0.6 * grow);
        vec![[-x, -z], [x, -z], [x, z - cut], [x - cut, z], [-x, z]]
    };
    let tier = |grow: f32, y: f32, height: f32| Shape::prism(&plan(grow), height).at(0.0, y, 0.0);
    let mut shop = tier(0.1, 0.0, 0.5).painted(PAVING);
    shop += tier(-0.25, 0.4, 3.2).painted(GLASS);
    shop += tier(0.0, 3.4, 4.2).painted(PLASTER);
    shop += tier(0.08, 3.4, 0.8).painted(TEAL);
    shop += tier(0.3, 7.4, 0.5).painted(LIMESTONE);
    shop += Shape::cuboid(9.0, 3.2, 0.5).painted(PLASTER).at(-0.5, 0.3, -4.75);
    shop += Shape::cuboid(1.2, 1.4, 1.2).painted(DARK_BRICK).at(-3.0, 7.8, -3.0);
    let stripes = level.pick(12, 6, 1);
    let width = 7.4 / stripes as f32;
    for (i, x) in spread(stripes, 7.4).enumerate() {
        let color = if stripes == 1 {
            RED.mix(CREAM, 0.5)
        } else if i % 2 == 0 {
            RED
        } else {
            CREAM
        };
        let profile = vec![[0.0, 0.55], [-0.3, 0.55], [-1.6, -0.2], [-1.6, -0.45]];
        let stripe = Shape::extrude(&profile, width).turned_y(0.25).painted(color);
        shop += stripe.at(x - 1.2, 3.0, 5.0);
    }
    let piers = [[-4.8, 0.3, 4.8], [2.45, 0.3, 4.8], [4.8, 0.3, 2.45], [4.8, 0.3, -4.8]];
    if level == Level::Far {
        let panes = Shape::cuboid(7.0, 1.7, 0.2).painted(DEEP_GLASS.mix(PLASTER, 0.4));
        shop += panes.clone().at(-1.2, 5.0, 5.0) + panes.turned_y(0.25).at(5.0, 5.0, -1.2);
        return shop;
    }
    shop += Shape::cuboid(0.6, 3.2, 0.6).painted(LIMESTONE).copied(piers);
    let panes = window(level, 1.2, 1.7).copied(spread(3, 7.2).map(|x| [x, 5.0, 0.0]));
    shop += panes.clone().at(-1.2, 0.0, 5.02);
    shop += panes.clone().turned_y(0.25).at(5.02, 0.0, -1.2);
    shop += window(level, 1.4, 1.9).turned_y(0.125).at(3.82, 4.9, 3.82);
    shop += Shape::cuboid(1.3, 2.5, 0.2)
        .painted(WOOD)
        .turned_y(0.125)
        .at(3.72, 0.4, 3.72);
    if level == Level::Full {
        shop += panes.turned_y(0.5).at(0.0, 0.0, -5.02);
        let mullion = Shape::cuboid(0.12, 3.1, 0.2).painted(WOOD);
        shop += mullion.copied(spread(5, 7.2).map(|x| [x - 1.2, 0.4, 4.78]));
        shop += mullion.copied(spread(5, 7.2).map(|z| [4.78, 0.4, z - 1.2]));
        let lettering = Shape::cuboid(0.34, 0.36, 0.1).painted(CREAM);
        shop += lettering
            .copied(spread(8, 4.2).map(|z| [0.0, 3.62, z]))
            .at(5.08, 0.0, -1.2);
        let stall = Shape::taper([1.7, 0.8], [1.9, 1.0], 0.5).painted(WOOD);
        shop += stall.copied([[-3.4, 0.5, 5.5], [-1.2, 0.5, 5.5]]);
        let fruit = Shape::blob(1, |_| 0.17);
        for (i, x) in spread(12, 3.9).enumerate() {
            let color = [AMBER, RED, GREEN][i / 2 % 3];
            shop += fruit
                .copied([[x - 2.3, 1.03, 5.3], [x - 2.3, 1.03, 5.7]])
                .painted(color);
        }
    }
    shop
}

/// Brick under a saw-tooth roof with north light, and gates to the front.
pub fn warehouse(level: Level) -> Shape {
    const TEETH: usize = 4;
    let tooth = 24.0 / TEETH as f32;
    let mut saw: Outline = vec![[-12.0, 0.0], [12.0, 0.0]];
    for i in (0..TEETH).rev() {
        let x = i as f32 * tooth - 12.0;
        saw.extend([[x + tooth, 6.0], [x + 0.6, 9.0]]);
    }
    saw.push([-12.0, 6.0]);
    let mut hall = Shape::extrude(&saw, 15.4).painted(BRICK);
    hall += Shape::cuboid(24.4, 0.6, 16.0).painted(PAVING);
    for x in (0..TEETH).map(|i| i as f32 * tooth - 12.0) {
        let slope: Outline = vec![
            [x + 0.5, 8.95],
            [x + tooth + 0.1, 5.95],
            [x + tooth + 0.1, 6.25],
            [x + 0.55, 9.3],
        ];
        hall += Shape::extrude(&slope, 15.8).painted(SLATE);
        let light: Outline = vec![[x + 0.06, 6.4], [x + 0.2, 6.2], [x + 0.7, 8.7], [x + 0.45, 8.7]];
        hall += Shape::extrude(&light, 14.4).painted(GLASS);
    }
    let gates = spread(3, 21.0);
    let gate = Shape::cuboid(3.8, 4.0, 15.7).painted(COPPER);
    hall += gate.copied(gates.clone().map(|x| [x, 0.5, 0.0]));
    if level == Level::Far {
        return hall;
    }
    let lintel = Shape::cuboid(4.6, 0.5, 16.0).painted(LIMESTONE);
    hall += lintel.copied(gates.clone().map(|x| [x, 4.4, 0.0]));
    let pier = Shape::cuboid(0.8, 5.6, 15.9).painted(DARK_BRICK);
    hall += pier.copied(spread(TEETH, 28.0).map(|x| [x, 0.2, 0.0]));
    let side = Shape::cuboid(24.25, 5.6, 0.7).painted(DARK_BRICK);
    hall += side.copied(spread(level.pick(5, 3, 0), 16.0).map(|z| [0.0, 0.2, z]));
    if level == Level::Full {
        let slat = Shape::cuboid(3.7, 0.12, 15.84).painted(COPPER.mix(IRON, 0.4));
        for y in spread(7, 4.0) {
            hall += slat.copied(gates.clone().map(|x| [x, y + 2.4, 0.0]));
        }
        for x in (0..TEETH).map(|i| i as f32 * tooth - 12.0) {
            let bar: Outline = vec![[x, 6.4], [x + 0.2, 6.15], [x + 0.7, 8.75], [x + 0.4, 8.75]];
            let bars = Shape::extrude(&bar, 0.16).painted(PLASTER);
            hall += bars.copied(spread(8, 14.0).map(|z| [0.0, 0.0, z]));
        }
        let lamps = Shape::cone(0.35, 0.4, 10).painted(IRON);
        hall += lamps.copied(gates.map(|x| [x, 5.1, 7.9]));
        let pane = Shape::prism(&rect(24.1, 1.8), 1.6).painted(DEEP_GLASS);
        hall += pane.copied(spread(4, 12.8).map(|z| [0.0, 2.6, z]));
    }
    let vent = Shape::lathe(&[[0.5, 0.0], [0.5, 1.4], [0.8, 1.5], [0.0, 2.0]], level.pick(14, 6, 4));
    hall + vent.painted(STEEL).copied([[-8.5, 7.4, 3.0], [3.5, 7.4, -3.0]])
}
