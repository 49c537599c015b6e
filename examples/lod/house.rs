//! Houses, each in three levels of detail, and as part of the proxy of its block.

use bevy::prelude::*;

use crate::solid::Solid;

/// How far each level deviates from the finest, in metres: the second lacks frames, sills, rails and tiles; the third
/// lacks balconies and eaves.
pub const ERRORS: [f32; 3] = [0.0, 0.15, 0.9];
/// The same for the house in the proxy of its block, which has a hipped roof and one colour.
pub const PROXY_ERROR: f32 = 1.2;

const FLOOR: f32 = 3.0;
/// From the ground to the first floor, from the wall to the edge of the roof, and how thick that is.
const BASE: f32 = 0.4;
const EAVES: f32 = 0.5;
const THICKNESS: f32 = 0.18;
/// Of the roof, in metres for each metre.
const RISE: f32 = 0.65;
/// How much of the ridge is left in the proxy.
const HIP: f32 = 0.72;
/// The windows are at these places along the front, as parts of the width.
const WINDOWS: [f32; 4] = [-0.37, -0.125, 0.125, 0.37];
/// Half of the width, and the height of a window with that of its sill.
const WINDOW: f32 = 0.5;
const WINDOW_HEIGHT: f32 = 1.5;
const SILL: f32 = 0.9;
/// Where balconies are, how far they reach out, and half of their width.
const BALCONY: f32 = 0.8;
const BALCONY_WIDTH: f32 = 1.1;
const RAIL: f32 = 0.95;

const GLASS: Srgba = Srgba::rgb(0.42, 0.52, 0.62);
const FRAME: Srgba = Srgba::rgb(0.97, 0.97, 0.95);
const STONE: Srgba = Srgba::rgb(0.80, 0.79, 0.76);
const IRON: Srgba = Srgba::rgb(0.45, 0.46, 0.50);
const BRICK: Srgba = Srgba::rgb(0.78, 0.56, 0.47);

/// A kind of house, whose front looks along +z.
#[derive(Clone, Copy)]
pub struct Style {
    floors: u32,
    width: f32,
    depth: f32,
    wall: Srgba,
    roof: Srgba,
    shutter: Srgba,
}

pub const STYLES: [Style; 4] = [
    Style {
        floors: 2,
        width: 8.6,
        depth: 9.0,
        wall: Srgba::rgb(0.96, 0.91, 0.80),
        roof: Srgba::rgb(0.82, 0.52, 0.42),
        shutter: Srgba::rgb(0.50, 0.68, 0.55),
    },
    Style {
        floors: 3,
        width: 9.2,
        depth: 9.6,
        wall: Srgba::rgb(0.95, 0.95, 0.93),
        roof: Srgba::rgb(0.62, 0.62, 0.68),
        shutter: Srgba::rgb(0.52, 0.62, 0.78),
    },
    Style {
        floors: 3,
        width: 8.8,
        depth: 9.2,
        wall: Srgba::rgb(0.93, 0.80, 0.72),
        roof: Srgba::rgb(0.74, 0.55, 0.50),
        shutter: Srgba::rgb(0.86, 0.84, 0.78),
    },
    Style {
        floors: 4,
        width: 9.4,
        depth: 10.0,
        wall: Srgba::rgb(0.84, 0.89, 0.94),
        roof: Srgba::rgb(0.80, 0.57, 0.45),
        shutter: Srgba::rgb(0.74, 0.56, 0.48),
    },
];

/// A wall: where its bottom middle is, and how it is turned.
#[derive(Clone, Copy)]
struct Wall {
    place: Transform,
    openings: &'static [f32],
    width: f32,
    has_balconies: bool,
}

impl Style {
    fn eaves_height(&self) -> f32 {
        BASE + self.floors as f32 * FLOOR
    }

    fn ridge_height(&self) -> f32 {
        self.eaves_height() + RISE * self.depth / 2.0
    }

    /// The levels, from finest to coarsest.
    pub fn levels(&self) -> [Solid; 3] {
        [self.fine(), self.plain(), self.coarse()]
    }

    fn walls(&self) -> [Wall; 4] {
        let (x, z) = (self.width / 2.0, self.depth / 2.0);
        let wall = |out: Vec3, openings, width, has_balconies| Wall {
            place: Transform::from_translation(out).looking_to(-out, Vec3::Y),
            openings,
            width,
            has_balconies,
        };
        [
            wall(Vec3::Z * z, &WINDOWS, self.width, true),
            wall(Vec3::NEG_Z * z, &WINDOWS, self.width, false),
            wall(Vec3::X * x, &WINDOWS[1..3], self.depth, false),
            wall(Vec3::NEG_X * x, &WINDOWS[1..3], self.depth, false),
        ]
    }

    /// For each opening of a wall its middle above the floor, with whether it is the door, and whether it has a balcony.
    fn openings(&self, wall: &Wall) -> impl Iterator<Item = (Vec3, bool, bool)> {
        let wall = *wall;
        (0..self.floors).flat_map(move |floor| {
            wall.openings.iter().enumerate().map(move |(number, along)| {
                let place = Vec3::new(along * wall.width, BASE + floor as f32 * FLOOR, 0.0);
                let is_front = wall.has_balconies;
                (
                    place,
                    is_front && floor == 0 && number == 1,
                    is_front && floor > 0 && number % 2 == 0,
                )
            })
        })
    }

    /// Walls with gables.
    fn shell(&self) -> Solid {
        let mut solid = Solid::default();
        let (x, z) = (self.width / 2.0, self.depth / 2.0);
        let (eaves, ridge) = (self.eaves_height(), self.ridge_height());
        for turn in [1.0, -1.0] {
            let (x, z) = (x * turn, z * turn);
            let front = [(-x, 0.0), (x, 0.0), (x, eaves), (-x, eaves)].map(|(x, y)| Vec3::new(x, y, z));
            solid.polygon(&front, self.wall);
            let gable = [(z, 0.0), (-z, 0.0), (-z, eaves), (0.0, ridge), (z, eaves)];
            solid.polygon(&gable.map(|(z, y)| Vec3::new(x, y, z)), self.wall);
        }
        solid
    }

    /// The upper edge of the slope that looks along +z, for a roof that reaches so far over the walls: from the left of
    /// the eaves counter-clockwise.
    fn slope(&self, over: f32, lift: f32) -> [Vec3; 4] {
        let (x, z) = (self.width / 2.0 + over, self.depth / 2.0 + over);
        let (eaves, ridge) = (self.eaves_height() - RISE * over + lift, self.ridge_height() + lift);
        [
            Vec3::new(-x, eaves, z),
            Vec3::new(x, eaves, z),
            Vec3::new(x, ridge, 0.0),
            Vec3::new(-x, ridge, 0.0),
        ]
    }

    /// Both halves of a roof of which one is given.
    fn both_slopes(half: &Solid, solid: &mut Solid) {
        for turn in [0.0, std::f32::consts::PI] {
            solid.add(half, &Transform::from_rotation(Quat::from_rotation_y(turn)));
        }
    }

    /// A box under a roof.
    fn coarse(&self) -> Solid {
        let mut solid = self.shell();
        let mut half = Solid::default();
        half.polygon(&self.slope(EAVES / 2.0, THICKNESS), self.roof);
        Self::both_slopes(&half, &mut solid);
        solid
    }

    /// Has windows, a door, balconies, a chimney and eaves, and all of that is flat or a box.
    fn plain(&self) -> Solid {
        let mut solid = self.shell();
        let mut half = Solid::default();
        let (upper, lower) = (self.slope(EAVES, THICKNESS), self.slope(EAVES, 0.0));
        half.polygon(&upper, self.roof);
        half.polygon(&[lower[3], lower[2], lower[1], lower[0]], STONE);
        half.polygon(&[lower[0], lower[1], upper[1], upper[0]], STONE);
        half.polygon(&[lower[1], lower[2], upper[2], upper[1]], STONE);
        half.polygon(&[lower[3], lower[0], upper[0], upper[3]], STONE);
        Self::both_slopes(&half, &mut solid);
        self.add_chimney(&mut solid, false);
        for wall in self.walls() {
            let mut on_wall = Solid::default();
            for (place, is_door, has_balcony) in self.openings(&wall) {
                let (sill, height, fill) = pane(is_door || has_balcony, is_door, self.shutter);
                for (border, out, color) in [(0.12, 0.03, FRAME), (0.0, 0.05, fill)] {
                    let half = WINDOW + border;
                    let (low, high) = ((sill - border).max(0.0), sill + height + border);
                    let pane = [(-half, low), (half, low), (half, high), (-half, high)];
                    on_wall.polygon(&pane.map(|(x, y)| place + Vec3::new(x, y, out)), color);
                }
                if has_balcony {
                    let box_at = |solid: &mut Solid, min: [f32; 3], max: [f32; 3], color| {
                        solid.cuboid(place + Vec3::from(min), place + Vec3::from(max), color);
                    };
                    box_at(
                        &mut on_wall,
                        [-BALCONY_WIDTH, -0.15, 0.0],
                        [BALCONY_WIDTH, 0.0, BALCONY],
                        STONE,
                    );
                    let front = BALCONY - 0.06;
                    box_at(
                        &mut on_wall,
                        [-BALCONY_WIDTH, 0.0, front],
                        [BALCONY_WIDTH, RAIL, BALCONY],
                        IRON,
                    );
                }
            }
            solid.add(&on_wall, &wall.place);
        }
        solid
    }

    /// All there is.
    fn fine(&self) -> Solid {
        let mut solid = self.shell();
        self.add_tiles(&mut solid);
        self.add_chimney(&mut solid, true);
        for wall in self.walls() {
            let mut on_wall = Solid::default();
            let half = wall.width / 2.0;
            for floor in 0..self.floors {
                let y = BASE + floor as f32 * FLOOR;
                on_wall.cuboid(Vec3::new(-half, y - 0.22, 0.0), Vec3::new(half, y - 0.08, 0.07), STONE);
            }
            for (place, is_door, has_balcony) in self.openings(&wall) {
                let mut opening = self.opening(is_door, has_balcony);
                if has_balcony {
                    add_balcony(&mut opening);
                }
                on_wall.add(&opening, &Transform::from_translation(place));
            }
            solid.add(&on_wall, &wall.place);
        }
        solid
    }

    /// A window or a door, in its frame, with a sill or steps, and shutters.
    fn opening(&self, is_door: bool, has_balcony: bool) -> Solid {
        let mut solid = Solid::default();
        let (sill, height, fill) = pane(is_door || has_balcony, is_door, self.shutter);
        let (low, high) = (sill, sill + height);
        let pane = [(-WINDOW, low), (WINDOW, low), (WINDOW, high), (-WINDOW, high)];
        solid.polygon(&pane.map(|(x, y)| Vec3::new(x, y, 0.02)), fill);
        let mut bar = |left: f32, low: f32, right: f32, high: f32, out: f32, color: Srgba| {
            solid.cuboid(Vec3::new(left, low, 0.0), Vec3::new(right, high, out), color);
        };
        bar(-WINDOW - 0.12, low, -WINDOW, high, 0.08, FRAME);
        bar(WINDOW, low, WINDOW + 0.12, high, 0.08, FRAME);
        bar(-WINDOW - 0.16, high, WINDOW + 0.16, high + 0.14, 0.12, STONE);
        if is_door {
            bar(-0.9, -BASE, 0.9, -BASE / 2.0, 0.9, STONE);
            bar(-0.8, -BASE / 2.0, 0.8, 0.0, 0.55, STONE);
            return solid;
        }
        bar(-0.03, low, 0.03, high, 0.06, FRAME);
        bar(-WINDOW, low + 0.62 * height, WINDOW, low + 0.66 * height, 0.06, FRAME);
        bar(-WINDOW - 0.2, low - 0.08, WINDOW + 0.2, low, 0.16, STONE);
        for side in [-1.0, 1.0] {
            let (near, far) = (side * (WINDOW + 0.14), side * (WINDOW + 0.58));
            bar(near.min(far), low, near.max(far), high, 0.05, self.shutter);
        }
        solid
    }

    /// Rows of tiles, each a little above the one below it.
    fn add_tiles(&self, solid: &mut Solid) {
        const ROWS: usize = 14;
        let mut half = Solid::default();
        let [left, right, top_right, top_left] = self.slope(EAVES, 0.0);
        half.polygon(&[top_left, top_right, right, left], STONE);
        for row in 0..ROWS {
            let [from, to] = [row, row + 1].map(|row| row as f32 / ROWS as f32);
            let (up, shade) = (Vec3::Y * THICKNESS, 0.94 + 0.06 * (row % 2) as f32);
            let color = Srgba::from_vec3(self.roof.to_vec3() * shade);
            let [a, b] = [left.lerp(top_left, from), right.lerp(top_right, from)];
            let [c, d] = [right.lerp(top_right, to), left.lerp(top_left, to)];
            let (high, low) = (up * 1.4, up * 0.8);
            half.polygon(&[a + high, b + high, c + low, d + low], color);
            let under = if row == 0 { Vec3::ZERO } else { low };
            half.polygon(&[a + under, b + under, b + high, a + high], color);
            half.polygon(&[b, c, c + low, b + high], STONE);
            half.polygon(&[d, a, a + high, d + low], STONE);
        }
        Self::both_slopes(&half, solid);
        let (x, ridge) = (self.width / 2.0 + EAVES, self.ridge_height() + THICKNESS);
        solid.cuboid(
            Vec3::new(-x, ridge - 0.1, -0.12),
            Vec3::new(x, ridge + 0.1, 0.12),
            self.roof,
        );
    }

    fn add_chimney(&self, solid: &mut Solid, is_fine: bool) {
        let foot = Vec3::new(self.width * 0.28, self.eaves_height() + 0.8, -self.depth * 0.18);
        let top = foot.with_y(self.ridge_height() + 0.5);
        let half = Vec3::new(0.45, 0.0, 0.35);
        solid.cuboid(foot - half, top + half, BRICK);
        if is_fine {
            solid.cuboid(top - half * 1.2, top + half * 1.2 + Vec3::Y * 0.12, STONE);
            for side in [-0.2, 0.2] {
                solid.pole(top + Vec3::new(side, 0.1, 0.0), 0.12, 0.35, 8, BRICK);
            }
        }
    }

    /// For the proxy of a block: four walls and a hipped roof.
    pub fn proxy(&self) -> Solid {
        let mut solid = Solid::default();
        let (x, z) = (self.width / 2.0, self.depth / 2.0);
        let (eaves, ridge) = (self.eaves_height(), self.ridge_height());
        let end = x * HIP;
        for turn in [1.0, -1.0] {
            let (x, z, end) = (x * turn, z * turn, end * turn);
            let corners = [[-x, z], [x, z], [x, -z]];
            let at = |corner: usize, y: f32| Vec3::new(corners[corner][0], y, corners[corner][1]);
            solid.polygon(&[at(0, 0.0), at(1, 0.0), at(1, eaves), at(0, eaves)], self.wall);
            solid.polygon(&[at(1, 0.0), at(2, 0.0), at(2, eaves), at(1, eaves)], self.wall);
            let [left, right] = [-end, end].map(|x| Vec3::new(x, ridge, 0.0));
            solid.polygon(&[at(0, eaves), at(1, eaves), right, left], self.roof);
            solid.polygon(&[at(1, eaves), at(2, eaves), right], self.roof);
        }
        solid
    }
}

/// The height of the sill, that of the pane above it, and its colour.
fn pane(is_high: bool, is_door: bool, door: Srgba) -> (f32, f32, Srgba) {
    let color = if is_door { door } else { GLASS };
    if is_high {
        (0.0, SILL + WINDOW_HEIGHT, color)
    } else {
        (SILL, WINDOW_HEIGHT, color)
    }
}

fn add_balcony(solid: &mut Solid) {
    let (width, front) = (BALCONY_WIDTH, BALCONY - 0.05);
    solid.cuboid(Vec3::new(-width, -0.15, 0.0), Vec3::new(width, 0.0, BALCONY), STONE);
    solid.cuboid(
        Vec3::new(-width, RAIL - 0.06, front - 0.03),
        Vec3::new(width, RAIL, BALCONY),
        IRON,
    );
    for side in [-width, width - 0.06] {
        solid.cuboid(
            Vec3::new(side, RAIL - 0.06, 0.0),
            Vec3::new(side + 0.06, RAIL, front),
            IRON,
        );
    }
    let bars = 15;
    for bar in 0..=bars {
        let x = -width + 0.03 + bar as f32 / bars as f32 * (2.0 * width - 0.06);
        solid.pole(Vec3::new(x, 0.0, front), 0.025, RAIL, 4, IRON);
    }
    for bar in 1..5 {
        for x in [-width + 0.03, width - 0.03] {
            solid.pole(Vec3::new(x, 0.0, bar as f32 / 5.0 * front), 0.025, RAIL, 4, IRON);
        }
    }
}
