//! Landmarks.

use crate::Level;
use crate::color::*;
use crate::math::{Vec3, cos_sin, vec3};
use crate::outline::{Outline, arc, arched, gabled, spread};
use crate::shape::{Shape, circle};

/// A nave with side windows and buttresses, a round apse and a spire over the door.
pub fn church(level: Level) -> Shape {
    let round = level.pick(10, 4, 2);
    let mut church = Shape::cuboid(11.0, 0.5, 25.0).painted(PAVING).at(0.0, 0.0, 1.0);
    church += Shape::extrude(&gabled(9.0, 7.5, 12.0), 17.0).painted(LIMESTONE);
    let slopes: Outline = vec![
        [5.0, 6.9],
        [5.0, 7.3],
        [0.0, 12.4],
        [-5.0, 7.3],
        [-5.0, 6.9],
        [0.0, 11.95],
    ];
    church += Shape::extrude(&slopes, 17.3).painted(SLATE);
    let apse = Shape::cylinder(3.8, 6.5, level.pick(20, 10, 6)).painted(LIMESTONE);
    let cap = Shape::cone(4.2, 3.2, level.pick(20, 10, 6))
        .painted(SLATE)
        .at(0.0, 6.4, 0.0);
    church += (apse + cap).at(0.0, 0.3, -8.3);

    church += Shape::cuboid(5.0, 16.0, 5.0).painted(LIMESTONE).at(0.0, 0.3, 10.0);
    let eight = |radius, y| circle(radius, y, 8);
    let spire = Shape::loft(&[eight(3.1, 0.0), eight(2.2, 1.6), eight(0.0, 13.5)]).painted(SLATE);
    church += spire.turned_y(1.0 / 16.0).at(0.0, 16.2, 10.0);
    church += Shape::cuboid(5.5, 0.6, 5.5).painted(SANDSTONE).at(0.0, 15.8, 10.0);
    let cross = Shape::cuboid(0.16, 2.0, 0.16) + Shape::cuboid(1.1, 0.16, 0.14).at(0.0, 1.2, 0.0);
    church += cross.painted(BRASS).at(0.0, 29.4, 10.0);

    let opening = |width: f32, height: f32, depth: f32| Shape::extrude(&arched(width, height, round), depth);
    church += opening(1.9, 3.8, 0.6).painted(WOOD).at(0.0, 0.4, 12.4);
    if level == Level::Far {
        let panes = opening(1.1, 4.2, 9.3).painted(DEEP_GLASS).turned_y(0.25);
        return church + panes.copied([[0.0, 2.2, -4.0], [0.0, 2.2, 2.0]]);
    }
    let bell = opening(1.5, 3.0, 5.2).painted(DEEP_GLASS);
    church += (bell.clone() + bell.turned_y(0.25)).at(0.0, 11.8, 10.0);
    for z in spread(5, 15.0) {
        church += opening(1.2, 4.4, 9.2)
            .painted(DEEP_GLASS)
            .turned_y(0.25)
            .at(0.0, 2.0, z - 0.5);
        if level == Level::Full {
            church += opening(1.6, 4.7, 9.1)
                .painted(SANDSTONE)
                .turned_y(0.25)
                .at(0.0, 1.9, z - 0.5);
        }
    }
    let buttress: Outline = vec![[4.4, 0.0], [6.0, 0.0], [5.8, 3.6], [5.2, 4.6], [4.4, 6.6]];
    let buttresses = Shape::extrude(&buttress, 0.7).painted(SANDSTONE).both_sides();
    church += buttresses.copied(spread(level.pick(6, 4, 0), 18.0).map(|z| [0.0, 0.3, z - 0.5]));
    if level == Level::Full {
        church += opening(2.6, 4.3, 0.4).painted(SANDSTONE).at(0.0, 0.4, 12.4);
        let rose = Shape::cylinder(1.3, 0.5, 24).painted(SANDSTONE) + Shape::cylinder(1.05, 0.6, 24).painted(GLASS);
        let spokes = Shape::cuboid(2.1, 0.65, 0.12).painted(SANDSTONE);
        let spokes = spokes.clone() + spokes.clone().turned_y(1.0 / 6.0) + spokes.turned_y(1.0 / 3.0);
        church += (rose + spokes).turned_x(0.25).at(0.0, 7.6, 12.15);
        let corner = Shape::cuboid(0.9, 15.0, 0.9).painted(SANDSTONE).at(2.3, 0.3, 2.3);
        church += corner.around(4).at(0.0, 0.0, 10.0);
        let pinnacle = Shape::taper([0.8, 0.8], [0.0, 0.0], 2.2)
            .painted(SANDSTONE)
            .at(2.3, 16.3, 2.3);
        church += pinnacle.around(4).at(0.0, 0.0, 10.0);
        church += Shape::cuboid(5.2, 0.35, 5.2).painted(SANDSTONE).at(0.0, 10.8, 10.0);
    }
    church += Shape::cuboid(3.2, 0.25, 1.5).painted(PAVING).at(0.0, 0.4, 12.9);
    church
}

/// A tank on splayed legs with a cone for a hat and a walkway around it.
pub fn water_tower(level: Level) -> Shape {
    let segments = level.pick(24, 12, 8);
    let thin = level.pick(8, 5, 3);
    let tank = Shape::lathe(&[[0.6, 11.6], [2.4, 12.4], [3.4, 13.4], [3.4, 18.0]], segments).painted(WOOD);
    let hat = Shape::lathe(&[[3.7, 18.0], [3.7, 18.15], [0.4, 20.6], [0.0, 21.2]], segments).painted(SLATE);
    let mut tower = tank + hat + Shape::cylinder(3.9, 0.25, segments).painted(IRON).at(0.0, 13.3, 0.0);
    tower += Shape::cylinder(0.35, 12.0, thin).painted(STEEL);
    let foot = |y: f32| vec3(4.2 - 1.4 * y / 14.0, y, 0.0);
    let leg = Shape::tube(&[(foot(0.3), 0.26), (foot(13.5), 0.22)], thin).painted(IRON);
    let pad = Shape::taper([1.3, 1.3], [0.9, 0.9], 0.5)
        .painted(CONCRETE)
        .at(4.2, 0.0, 0.0);
    tower += (leg + pad).around(6);
    if level == Level::Far {
        return tower;
    }
    let sixth = |p: Vec3| {
        let (cos, sin) = cos_sin(1.0 / 6.0);
        vec3(p.x * cos, p.y, -p.x * sin)
    };
    for y in [4.4, 8.8] {
        let ring = Shape::tube(&[(foot(y), 0.12), (sixth(foot(y)), 0.12)], thin);
        tower += ring.painted(IRON).around(6);
    }
    if level == Level::Full {
        for (low, high) in [(0.6, 4.4), (4.4, 8.8), (8.8, 13.2)] {
            let rod = Shape::tube(&[(foot(low), 0.05), (sixth(foot(high)), 0.05)], 5);
            let other = Shape::tube(&[(sixth(foot(low)), 0.05), (foot(high), 0.05)], 5);
            tower += (rod + other).painted(STEEL).around(6);
        }
        for y in [14.2, 15.6, 17.0] {
            tower += Shape::cylinder(3.46, 0.14, segments).painted(IRON).at(0.0, y, 0.0);
        }
        let post = Shape::cylinder(0.04, 1.0, 5).at(3.8, 13.5, 0.0);
        tower += post.painted(STEEL).around(18);
        let outer = Shape::lathe(
            &[[3.76, 14.5], [3.84, 14.5], [3.84, 14.56], [3.76, 14.56], [3.76, 14.5]],
            24,
        );
        tower += outer.painted(STEEL);
        let rung = Shape::cuboid(0.5, 0.05, 0.05).painted(STEEL);
        tower += rung.copied((0..30).map(|i| [0.0, 0.5 + 0.43 * i as f32, 3.6]));
        let stile = Shape::cuboid(0.06, 14.2, 0.06).painted(STEEL);
        tower += stile.copied([[-0.25, 0.2, 3.6], [0.25, 0.2, 3.6]]);
    }
    tower
}

/// A triumphal gate with one great arch through it.
pub fn arch_gate(level: Level) -> Shape {
    let steps = level.pick(24, 10, 6);
    let mut gate: Outline = vec![[-8.0, 0.0], [-3.2, 0.0], [-3.2, 7.0]];
    let vault = arc([0.0, 7.0], 3.2, [0.5, 0.0], steps);
    gate.extend(&vault[1..]);
    gate.extend([[3.2, 0.0], [8.0, 0.0], [8.0, 14.0], [-8.0, 14.0]]);
    let mut shape = Shape::extrude(&gate, 6.0).smooth().painted(LIMESTONE);
    let tier = |width: f32, height: f32, depth: f32, y: f32| Shape::cuboid(width, height, depth).at(0.0, y, 0.0);
    shape += tier(17.2, 0.9, 7.2, 12.6).painted(SANDSTONE);
    shape += tier(14.8, 3.4, 5.2, 13.4).painted(LIMESTONE);
    shape += tier(15.4, 0.6, 5.8, 16.6).painted(SANDSTONE);
    let plinth = Shape::cuboid(5.4, 1.6, 6.8).painted(SANDSTONE).at(5.6, 0.0, 0.0);
    shape += plinth.both_sides();
    if level == Level::Far {
        return shape;
    }
    let column = Shape::lathe(
        &[
            [0.75, 0.0],
            [0.75, 0.4],
            [0.55, 0.6],
            [0.48, 8.6],
            [0.75, 9.2],
            [0.75, 9.6],
        ],
        level.pick(16, 7, 4),
    );
    let pair = column.copied([[4.1, 1.5, 3.0], [7.1, 1.5, 3.0], [4.1, 1.5, -3.0], [7.1, 1.5, -3.0]]);
    shape += pair.painted(PLASTER).both_sides();
    let entablature = tier(16.9, 1.0, 7.4, 11.0).painted(LIMESTONE);
    if level == Level::Middle {
        let attic = Shape::cuboid(9.0, 1.8, 5.5).painted(BRONZE).at(0.0, 14.2, 0.0);
        return shape + entablature + attic;
    }
    let wedge: Outline = vec![[-0.45, 9.9], [0.45, 9.9], [0.7, 11.4], [-0.7, 11.4]];
    shape += Shape::extrude(&wedge, 7.0).painted(SANDSTONE);
    let (inner, outer) = (
        arc([0.0, 7.0], 3.15, [0.5, 0.0], 24),
        arc([0.0, 7.0], 3.75, [0.0, 0.5], 24),
    );
    shape += Shape::extrude(&[outer, inner].concat(), 6.4).painted(SANDSTONE);
    shape += entablature;
    let relief = Shape::cuboid(2.2, 1.8, 5.5).painted(BRONZE);
    shape += relief.copied(spread(5, 13.0).map(|x| [x, 14.2, 0.0]));
    let medallion = Shape::cylinder(0.9, 6.3, 20)
        .turned_x(0.25)
        .painted(BRONZE)
        .at(5.6, 8.6, -3.15);
    shape += medallion.both_sides();
    let dentil = Shape::cuboid(0.4, 0.4, 7.0).painted(PLASTER);
    shape += dentil.copied(spread(18, 16.6).map(|x| [x, 12.2, 0.0]));
    shape
}

/// Three arches carry a humped road from left to right.
pub fn bridge_arch(level: Level) -> Shape {
    let steps = level.pick(16, 8, 4);
    let deck = |x: f32| 5.0 - 3.2 * (x / 13.0) * (x / 13.0);
    let hump = |lift: f32| -> Outline {
        let count = level.pick(16, 8, 6);
        (0..=count)
            .map(|i| 13.0 - 26.0 * i as f32 / count as f32)
            .map(|x| [x, deck(x) + lift])
            .collect()
    };
    let mut wall: Outline = vec![[-13.0, 0.0]];
    for (x, radius) in [(-7.0, 2.1), (0.0, 3.4), (7.0, 2.1)] {
        wall.extend(arc([x, 0.0], radius, [0.5, 0.0], steps));
    }
    wall.push([13.0, 0.0]);
    wall.extend(hump(0.0));
    let mut bridge = Shape::extrude(&wall, 6.0).smooth().painted(LIMESTONE);
    let band = |from: f32, to: f32, depth: f32| {
        let lower: Outline = hump(from).into_iter().rev().collect();
        Shape::extrude(&[lower, hump(to)].concat(), depth)
            .smooth()
            .scaled(1.002, 1.0, 1.0)
    };
    bridge += band(-0.2, 0.08, 5.9).painted(ASPHALT);
    let parapet = band(-0.35, 0.85, 0.4).painted(SANDSTONE);
    bridge += parapet.copied([[0.0, 0.0, -3.0], [0.0, 0.0, 3.0]]);
    let pier: Outline = vec![
        [-0.8, -3.0],
        [0.0, -4.2],
        [0.8, -3.0],
        [0.8, 3.0],
        [0.0, 4.2],
        [-0.8, 3.0],
    ];
    let pier = Shape::prism(&pier, 2.2).painted(SANDSTONE);
    bridge += pier.copied([[-4.2, 0.0, 0.0], [4.2, 0.0, 0.0]]);
    if level == Level::Far {
        return bridge;
    }
    for (x, radius) in [(-7.0, 2.1), (0.0, 3.4), (7.0, 2.1)] {
        let ring = [
            arc([x, 0.0], radius + 0.35, [0.0, 0.5], steps),
            arc([x, 0.0], radius - 0.05, [0.5, 0.0], steps),
        ];
        bridge += Shape::extrude(&ring.concat(), 6.5).smooth().painted(SANDSTONE);
    }
    let post = Shape::cuboid(0.7, 1.7, 0.7).painted(LIMESTONE);
    for x in [-12.6, -4.2, 4.2, 12.6] {
        bridge += post.copied([[x, deck(x) - 0.5, -3.0], [x, deck(x) - 0.5, 3.0]]);
    }
    if level == Level::Full {
        let cap = Shape::taper([0.9, 0.9], [0.2, 0.2], 0.4).painted(LIMESTONE);
        let globe = Shape::blob(2, |_| 0.28).smooth().painted(LAMPLIGHT).at(0.0, 0.55, 0.0);
        for x in [-12.6, -4.2, 4.2, 12.6] {
            bridge += (cap.clone() + globe.clone()).copied([[x, deck(x) + 1.15, -3.0], [x, deck(x) + 1.15, 3.0]]);
        }
        bridge += band(0.8, 0.95, 0.55)
            .painted(LIMESTONE)
            .copied([[0.0, 0.0, -3.0], [0.0, 0.0, 3.0]]);
    }
    bridge
}

/// Ten columns around a floor of steps, under a copper dome with a lantern.
pub fn pavilion_dome(level: Level) -> Shape {
    let segments = level.pick(40, 20, 10);
    let lathe = |profile: &[[f32; 2]]| Shape::lathe(profile, segments);
    let mut pavilion = Shape::default();
    for (i, radius) in [6.0, 5.6, 5.2].into_iter().enumerate().step_by(level.pick(1, 1, 2)) {
        pavilion += lathe(&[[radius, 0.0], [radius, 0.25 * (i + 1) as f32]]).painted(PAVING.mix(LIMESTONE, 0.5));
    }
    let ring = [
        [4.1, 5.3],
        [5.0, 5.3],
        [5.0, 6.0],
        [5.4, 6.2],
        [5.4, 6.5],
        [4.1, 6.5],
        [4.1, 5.3],
    ];
    pavilion += lathe(&ring).painted(LIMESTONE);
    let steps = level.pick(9, 5, 3);
    let dome = |radius: f32| arc([0.0, 6.4], radius, [0.0, 0.23], steps);
    pavilion += lathe(&dome(4.8)).painted(COPPER);
    pavilion += Shape::cylinder(0.8, 1.3, level.pick(16, 8, 5))
        .painted(LIMESTONE)
        .at(0.0, 10.9, 0.0);
    let hat = [[1.0, 0.0], [0.9, 0.4], [0.4, 0.9], [0.06, 1.2], [0.0, 2.2]];
    pavilion += Shape::lathe(&hat, level.pick(16, 8, 5))
        .painted(COPPER)
        .at(0.0, 12.1, 0.0);
    let column = match level {
        Level::Full => Shape::lathe(
            &[
                [0.5, 0.0],
                [0.5, 0.2],
                [0.34, 0.35],
                [0.28, 4.2],
                [0.5, 4.5],
                [0.5, 4.7],
            ],
            14,
        ),
        Level::Middle => Shape::lathe(&[[0.42, 0.0], [0.28, 4.7]], 7),
        Level::Far => Shape::lathe(&[[0.42, 0.0], [0.32, 4.7]], 4),
    };
    pavilion += column.painted(PLASTER).at(0.0, 0.7, 4.55).around(10);
    if level == Level::Full {
        for i in 0..10 {
            let rib = dome(4.85).into_iter().map(|[x, y]| (vec3(x, y, 0.0), 0.1));
            let rib = Shape::tube(&rib.collect::<Vec<_>>(), 5).painted(COPPER.mix(BRONZE, 0.5));
            pavilion += rib.turned_y((i as f32 + 0.5) / 10.0);
        }
        pavilion += Shape::cuboid(0.3, 0.3, 0.2)
            .painted(PLASTER)
            .at(0.0, 5.75, 5.0)
            .around(40);
    }
    pavilion
}

/// Two bowls over a round pool, with falling water.
pub fn fountain(level: Level) -> Shape {
    let segments = level.pick(40, 20, 10);
    let lathe = |profile: &[[f32; 2]]| Shape::lathe(profile, segments);
    let mut fountain = lathe(&[[3.9, 0.0], [3.9, 0.2]]).painted(PAVING);
    let pool = [
        [3.4, 0.1],
        [3.5, 0.6],
        [3.7, 0.65],
        [3.7, 0.85],
        [3.2, 0.85],
        [3.1, 0.3],
    ];
    fountain += lathe(&pool).painted(LIMESTONE);
    fountain += lathe(&[[3.16, 0.2], [3.16, 0.68]]).painted(WATER);
    let bowl = |radius: f32| {
        let rim = [
            [0.2, 0.0],
            [radius * 0.6, 0.12],
            [radius, 0.45],
            [radius, 0.55],
            [radius * 0.9, 0.55],
        ];
        let water = lathe(&[[radius * 0.93, 0.46], [radius * 0.93, 0.51]]).painted(WATER);
        lathe(&rim).painted(SANDSTONE) + water.at(0.0, 0.06, 0.0)
    };
    fountain += bowl(1.7).at(0.0, 1.75, 0.0) + bowl(0.9).at(0.0, 2.95, 0.0);
    let stem = [
        [0.8, 0.3],
        [0.7, 0.7],
        [0.3, 1.0],
        [0.26, 1.5],
        [0.45, 1.8],
        [0.2, 2.2],
        [0.2, 3.1],
    ];
    fountain += Shape::lathe(&stem, level.pick(20, 8, 4)).painted(SANDSTONE);
    let jet = [[0.16, 3.4], [0.07, 4.1], [0.1, 4.3], [0.0, 4.5]];
    fountain += Shape::lathe(&jet, level.pick(12, 6, 3)).painted(WATER.mix(Color::WHITE, 0.4));
    let fall = |radius: f32, top: f32, bottom: f32, reach: f32| -> Shape {
        let steps = level.pick(6, 3, 1);
        let path = (0..=steps).map(|i| i as f32 / steps as f32).map(|t| {
            let drop = (top - bottom) * (t * t * 1.2 - t * 0.2);
            (vec3(radius + reach * t, top - drop, 0.0), 0.05 + 0.03 * t)
        });
        Shape::tube(&path.collect::<Vec<_>>(), level.pick(6, 4, 3))
    };
    if level != Level::Far {
        let falls = fall(1.6, 2.3, 0.6, 0.7).around(10) + fall(0.8, 3.5, 2.2, 0.4).around(6);
        fountain += falls.painted(WATER.mix(Color::WHITE, 0.4));
    }
    fountain
}
