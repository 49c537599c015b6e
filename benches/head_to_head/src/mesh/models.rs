//! What the rays are cast at.

use std::path::{Path, PathBuf};

use bevy::math::{Vec3, Vec3Swizzles};

use crate::Effort;

/// A list of triangles.
pub(crate) struct Model {
    pub name: &'static str,
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Of the box around it.
    pub center: Vec3,
    /// Half the diagonal of that.
    pub radius: f32,
}

impl Model {
    fn new(name: &'static str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        let min = positions.iter().fold(Vec3::INFINITY, |min, &p| min.min(p));
        let max = positions.iter().fold(Vec3::NEG_INFINITY, |max, &p| max.max(p));
        Self {
            name,
            positions,
            triangles,
            center: (min + max) / 2.0,
            radius: (max - min).length() / 2.0,
        }
    }

    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }

    pub fn all_corners(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> + '_ {
        (0..self.triangles.len() as u32).map(|triangle| self.corners(triangle))
    }
}

pub(crate) fn all(effort: Effort) -> Vec<Model> {
    let mut models = vec![sphere("sphere-70k", 76), terrain("terrain-70k", 187)];
    models.extend(helmet());
    if effort == Effort::Full {
        models.extend([sphere("sphere-1M", 289), terrain("terrain-1M", 707)]);
    }
    models
}

/// A sphere of radius 1 with dents of all sizes: a cube of `n`×`n` squares to a side, blown up.
fn sphere(name: &'static str, n: u32) -> Model {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let first = positions.len() as u32;
        let axis = side / 2;
        for [i, j] in corners(n) {
            // The tangent spaces them more evenly.
            let [u, v] = [i, j].map(|k| ((k as f32 / n as f32 * 2.0 - 1.0) * std::f32::consts::FRAC_PI_4).tan());
            let (point, outward) = if side % 2 == 0 { ([u, v], 1.0) } else { ([v, u], -1.0) };
            let mut cube = [0.0; 3];
            cube[axis] = outward;
            cube[(axis + 1) % 3] = point[0];
            cube[(axis + 2) % 3] = point[1];
            let direction = Vec3::from(cube).normalize();
            positions.push(direction * (1.0 + 0.15 * dents(direction * 2.0)));
        }
        triangles.extend(squares(n, first));
    }
    Model::new(name, positions, triangles)
}

/// A square of side 2 with hills of all sizes, y up.
fn terrain(name: &'static str, n: u32) -> Model {
    let position = |[i, j]: [u32; 2]| {
        let [x, z] = [i, j].map(|k| k as f32 / n as f32 * 2.0 - 1.0);
        Vec3::new(x, 0.3 * dents(Vec3::new(2.0 * x, 0.3, 2.0 * z)), z)
    };
    Model::new(name, corners(n).map(position).collect(), squares(n, 0).collect())
}

/// The corners of `n`×`n` squares.
fn corners(n: u32) -> impl Iterator<Item = [u32; 2]> {
    (0..=n).flat_map(move |j| (0..=n).map(move |i| [i, j]))
}

/// Two triangles for each of `n`×`n` squares, whose corners are numbered from `first`.
fn squares(n: u32, first: u32) -> impl Iterator<Item = [u32; 3]> {
    (0..n * n).flat_map(move |square| {
        let (a, right, up) = (first + square / n * (n + 1) + square % n, 1, n + 1);
        [[a, a + right, a + up + right], [a, a + up + right, a + up]]
    })
}

/// Waves in six sizes, each half as long and half as high as the one before, and turned: in -2..2.
fn dents(mut point: Vec3) -> f32 {
    let (mut height, mut sum) = (1.0, 0.0);
    for _ in 0..6 {
        sum +=
            height * (point.x.sin() * point.y.cos() + point.z.sin() * 0.5 + (point.x + point.y + point.z).cos() * 0.3);
        point = (point.yzx() * Vec3::new(1.6, -1.2, 0.0) + point.zxy() * Vec3::new(1.2, 1.6, 2.0)) + Vec3::splat(1.7);
        height *= 0.5;
    }
    sum
}

/// All its meshes in one: none of its nodes is placed.
fn helmet() -> Option<Model> {
    let folder = std::env::var_os("SIGHTLINE_MODELS").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models"),
        PathBuf::from,
    );
    let folder = [folder, PathBuf::from("../shared/models")]
        .into_iter()
        .map(|folder| folder.join("FlightHelmet"))
        .find(|folder| folder.is_dir());
    let Some(folder) = folder else {
        println!("# mesh/*-helmet: skipped, there is no FlightHelmet in $SIGHTLINE_MODELS or ../shared/models");
        return None;
    };
    let file = gltf::Gltf::open(folder.join("FlightHelmet.gltf")).expect("a glTF file");
    let buffer = std::fs::read(folder.join("FlightHelmet.bin")).expect("the buffer beside it");
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for primitive in file.meshes().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|_| Some(&buffer));
        let first = positions.len() as u32;
        positions.extend(reader.read_positions().expect("positions").map(Vec3::from));
        let indices = reader.read_indices().expect("indices").into_u32();
        let indices: Vec<u32> = indices.map(|index| first + index).collect();
        triangles.extend(indices.as_chunks::<3>().0);
    }
    Some(Model::new("helmet", positions, triangles))
}
