//! Recorded frames of occluders, drawn and asked about boxes: how long it takes, and how much of what is hidden is found.
//!
//! The frames are those that come with Intel's *MaskedOcclusionCulling*, converted; looked for in the folder that
//! `SIGHTLINE_DATA` names, or in `../shared/data`. What is hidden, a depth buffer in double precision says at 1920×1080.

use std::{
    fs,
    path::{Path, PathBuf},
};

use bevy::math::{DMat4, DVec2, DVec3, DVec4, Mat4, UVec2, Vec3, bounding::Aabb3d};
use bevy_sightline::raster::{Faces, MaskedDepthBuffer, OccluderMesh, RasterMode};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::compare::{median_ns, time};

const BOXES: usize = 20_000;
const EXACT_SIZE: UVec2 = UVec2::new(1920, 1080);
const SIZES: [(u32, u32); 4] = [(256, 128), (512, 256), (1024, 512), (1920, 1080)];

/// What hides, as it was recorded.
struct Occluder {
    clip_from_model: DMat4,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

pub(super) fn run(rounds: usize) {
    let folder = std::env::var_os("SIGHTLINE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    for number in 0.. {
        let Ok(bytes) = fs::read(folder.join(format!("occluders_{number}.bin"))) else {
            if number == 0 {
                println!("# occlusion/frames: skipped, there are none in $SIGHTLINE_DATA or ../shared/data");
            }
            return;
        };
        measure(number, &read(&bytes), rounds);
    }
}

fn measure(number: usize, occluders: &[Occluder], rounds: usize) {
    let triangles: usize = occluders.iter().map(|occluder| occluder.triangles.len()).sum();
    let exact = exact_depths(occluders);
    let clip_from_view = clip_from_view(occluders);
    let boxes = boxes(occluders, &clip_from_view, number as u64);
    let is_hidden: Vec<bool> = boxes
        .iter()
        .map(|aabb| is_hidden(aabb, &clip_from_view, &exact))
        .collect();
    let hidden = is_hidden.iter().filter(|&&is_hidden| is_hidden).count();
    println!("# occlusion/frame-{number}: {triangles} triangles, {hidden} of {BOXES} boxes are hidden");
    let meshes: Vec<OccluderMesh> = occluders
        .iter()
        .map(|occluder| OccluderMesh::new(&occluder.positions, &occluder.triangles))
        .collect();
    let clip_from_view = clip_from_view.as_mat4();
    for (mode, size) in [RasterMode::Fast, RasterMode::Strict]
        .into_iter()
        .flat_map(|mode| SIZES.map(|size| (mode, size)))
    {
        let mut buffer = MaskedDepthBuffer::new(size.into(), mode);
        let (mut drawing, mut asking) = (Vec::new(), Vec::new());
        let mut visible = vec![false; BOXES];
        for _ in 0..rounds {
            let draw = || {
                buffer.clear();
                for (occluder, mesh) in occluders.iter().zip(&meshes) {
                    buffer.draw_mesh(mesh, &occluder.clip_from_model, Faces::Front);
                }
            };
            drawing.push(time(draw).0);
            visible.fill(false);
            asking.push(time(|| buffer.for_each_visible(&boxes, &clip_from_view, |number| visible[number] = true)).0);
        }
        let found = is_hidden
            .iter()
            .zip(&visible)
            .filter(|&(is_hidden, visible)| *is_hidden && !visible)
            .count();
        let wrong = is_hidden
            .iter()
            .zip(&visible)
            .filter(|&(is_hidden, visible)| !is_hidden && !visible)
            .count();
        println!(
            "# occlusion/frame-{number}-{mode:?}-{}x{}: drawn in {:.3} ms, {:.1} ns a box, {:.2}% of what is hidden found, \
             {wrong} that are not",
            size.0,
            size.1,
            median_ns(drawing) as f64 / 1e6,
            median_ns(asking) as f64 / BOXES as f64,
            100.0 * found as f64 / hidden as f64,
        );
    }
}

fn read(bytes: &[u8]) -> Vec<Occluder> {
    let mut at = 0;
    let mut word = || {
        at += 4;
        u32::from_le_bytes(bytes[at - 4..at].try_into().expect("four bytes"))
    };
    let [magic, version, _, _] = std::array::from_fn(|_| word());
    assert_eq!(
        (&magic.to_le_bytes(), version),
        (b"OCCL", 1),
        "not a frame of occluders"
    );
    let near = f32::from_bits(word());
    let meshes = word();
    let occluders = (0..meshes).map(|_| {
        let (vertices, indices) = (word(), word());
        let mut clip_from_model = Mat4::from_cols_array(&std::array::from_fn(|_| f32::from_bits(word())));
        // Only the distance along the view is of use: depth is as Bevy has it, the near plane over that.
        for column in 0..4 {
            clip_from_model.col_mut(column).z = 0.0;
        }
        clip_from_model.w_axis.z = near;
        let mut number = || f32::from_bits(word());
        let positions = (0..vertices).map(|_| Vec3::new(number(), number(), number())).collect();
        let triangles = (0..indices / 3).map(|_| [word(), word(), word()]).collect();
        Occluder {
            clip_from_model: clip_from_model.as_dmat4(),
            positions,
            triangles,
        }
    });
    occluders.collect()
}

/// The projection of the camera, from its view space with the depth axis away from it.
fn clip_from_view(occluders: &[Occluder]) -> DMat4 {
    let matrix = &occluders[0].clip_from_model;
    let length = |row: usize| matrix.row(row).truncate().length();
    DMat4::from_cols(
        DVec4::X * length(0) / length(3),
        DVec4::Y * length(1) / length(3),
        DVec4::W,
        DVec4::Z * matrix.w_axis.z,
    )
}

/// Boxes about vertices on the screen, from a thousandth to three hundredths of their distances large.
fn boxes(occluders: &[Occluder], clip_from_view: &DMat4, seed: u64) -> Vec<Aabb3d> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let view_from_clip = clip_from_view.inverse();
    let near = clip_from_view.w_axis.z;
    let mut boxes = Vec::with_capacity(BOXES);
    while boxes.len() < BOXES {
        let occluder = &occluders[rng.random_range(0..occluders.len())];
        let vertex = occluder.positions[rng.random_range(0..occluder.positions.len())];
        let clip = occluder.clip_from_model * vertex.as_dvec3().extend(1.0);
        if clip.w < near || clip.x.abs() > clip.w || clip.y.abs() > clip.w {
            continue;
        }
        let size = clip.w * 10f64.powf(rng.random_range(-3.0..-1.5));
        let mut vector = |from: f64| DVec3::from_array(std::array::from_fn(|_| rng.random_range(from..1.0)));
        let center = (view_from_clip * clip).truncate() + vector(-1.0) * 3.0 * size;
        let half = vector(0.3) * size;
        if center.z - half.z > near {
            boxes.push(Aabb3d::new(center.as_vec3(), half.as_vec3()));
        }
    }
    boxes
}

fn to_pixels(clip: DVec4) -> DVec2 {
    let size = EXACT_SIZE.as_dvec2();
    DVec2::new(
        (0.5 + 0.5 * clip.x / clip.w) * size.x,
        (0.5 - 0.5 * clip.y / clip.w) * size.y,
    )
}

/// Whether every pixel of a box' rectangle is nearer than its nearest point along the view.
fn is_hidden(aabb: &Aabb3d, clip_from_view: &DMat4, exact: &[f64]) -> bool {
    let ends = [aabb.min.as_dvec3(), aabb.max.as_dvec3()];
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for corner in 0..8 {
        let end = |axis: usize| ends[corner >> axis & 1][axis];
        let pixel = to_pixels(*clip_from_view * DVec4::new(end(0), end(1), end(2), 1.0));
        (min, max) = (min.min(pixel), max.max(pixel));
    }
    let nearest = clip_from_view.w_axis.z / ends[0].z;
    let first = min.floor().max(DVec2::ZERO).as_uvec2();
    let end = max.ceil().max(DVec2::ZERO).as_uvec2().min(EXACT_SIZE);
    (first.y..end.y).all(|y| (first.x..end.x).all(|x| exact[(y * EXACT_SIZE.x + x) as usize] > nearest))
}

/// The depth of each pixel at its centre.
fn exact_depths(occluders: &[Occluder]) -> Vec<f64> {
    let mut depths = vec![-1.0; (EXACT_SIZE.x * EXACT_SIZE.y) as usize];
    for occluder in occluders {
        for triangle in &occluder.triangles {
            let corners = triangle
                .map(|vertex| occluder.clip_from_model * occluder.positions[vertex as usize].as_dvec3().extend(1.0));
            let mut polygon = Vec::with_capacity(4);
            for (index, &from) in corners.iter().enumerate() {
                let to = corners[(index + 1) % 3];
                let (here, there) = (from.w - from.z, to.w - to.z);
                polygon.extend((here >= 0.0).then_some(from));
                polygon.extend(((here >= 0.0) != (there >= 0.0)).then(|| from.lerp(to, here / (here - there))));
            }
            let polygon: Vec<DVec3> = polygon
                .iter()
                .map(|&clip| to_pixels(clip).extend(clip.z / clip.w))
                .collect();
            for next in 2..polygon.len() {
                draw([polygon[0], polygon[next - 1], polygon[next]], &mut depths);
            }
        }
    }
    depths
}

fn draw([a, b, c]: [DVec3; 3], depths: &mut [f64]) {
    let cross = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    let area = cross(a.truncate(), b.truncate(), c.truncate());
    // Rows are counted downward: front faces are negative.
    if area >= 0.0 {
        return;
    }
    let min = a.min(b).min(c).truncate().floor().max(DVec2::ZERO).as_uvec2();
    let max = a
        .max(b)
        .max(c)
        .truncate()
        .ceil()
        .max(DVec2::ZERO)
        .as_uvec2()
        .min(EXACT_SIZE);
    for y in min.y..max.y {
        for x in min.x..max.x {
            let at = UVec2::new(x, y).as_dvec2() + 0.5;
            let weights = [
                cross(b.truncate(), c.truncate(), at) / area,
                cross(c.truncate(), a.truncate(), at) / area,
                cross(a.truncate(), b.truncate(), at) / area,
            ];
            if weights.iter().all(|&weight| weight >= 0.0) {
                let depth = &mut depths[(y * EXACT_SIZE.x + x) as usize];
                *depth = depth.max(weights[0] * a.z + weights[1] * b.z + weights[2] * c.z);
            }
        }
    }
}
