//! Closed polygons in the plane, counter-clockwise, from which solids are pulled up.

use crate::math::cos_sin;

pub type Outline = Vec<[f32; 2]>;

/// A rectangle around the origin.
pub fn rect(width: f32, height: f32) -> Outline {
    let (x, y) = (width / 2.0, height / 2.0);
    vec![[-x, -y], [x, -y], [x, y], [-x, y]]
}

/// Points on a circle's arc, both ends among them; angles are in turns, counter-clockwise from +x.
pub fn arc(center: [f32; 2], radius: f32, turns: [f32; 2], steps: usize) -> Outline {
    (0..=steps)
        .map(|i| {
            let (cos, sin) = cos_sin(turns[0] + (turns[1] - turns[0]) * i as f32 / steps as f32);
            [center[0] + radius * cos, center[1] + radius * sin]
        })
        .collect()
}

/// A rectangle around the origin whose corners are rounded in `steps` steps; one step is a chamfer.
pub fn rounded(width: f32, height: f32, radius: f32, steps: usize) -> Outline {
    let (x, y) = (width / 2.0 - radius, height / 2.0 - radius);
    [[x, y], [-x, y], [-x, -y], [x, -y]]
        .into_iter()
        .zip([0.0, 0.25, 0.5, 0.75])
        .flat_map(|(center, start)| arc(center, radius, [start, start + 0.25], steps))
        .collect()
}

/// An upright rectangle on y = 0 with a half circle on top: a church window, a doorway.
pub fn arched(width: f32, height: f32, steps: usize) -> Outline {
    let radius = width / 2.0;
    let mut outline = vec![[-radius, 0.0], [radius, 0.0]];
    outline.extend(arc([0.0, height - radius], radius, [0.0, 0.5], steps));
    outline
}

/// A wall on y = 0 with pointed top: the front of a house.
pub fn gabled(width: f32, eaves: f32, ridge: f32) -> Outline {
    let x = width / 2.0;
    vec![[-x, 0.0], [x, 0.0], [x, eaves], [0.0, ridge], [-x, eaves]]
}

/// The middles of `count` equal parts of a line of length `span` around the origin.
pub fn spread(count: usize, span: f32) -> impl Iterator<Item = f32> + Clone {
    let pitch = span / count as f32;
    (0..count).map(move |i| (i as f32 + 0.5) * pitch - span / 2.0)
}
