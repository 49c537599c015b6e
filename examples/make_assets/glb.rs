//! The binary form of glTF 2.0: a JSON chunk that says what there is, and a binary chunk with the numbers.

use std::collections::BTreeMap;

use crate::math::Vec3;
use crate::shape::{Corner, Shape};

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

const MATERIAL: &str = r#"{
    "name":"painted","doubleSided":false,
    "pbrMetallicRoughness":{"baseColorFactor":[1,1,1,1],"metallicFactor":0,"roughnessFactor":0.8}
}"#;

/// A file with one mesh, one node and one scene for each of the shapes.
pub fn encode(shapes: &[(String, Shape)]) -> Vec<u8> {
    let mut chunk = Chunk::default();
    let meshes = list(shapes.iter().map(|(name, shape)| chunk.mesh(name, shape)));
    let nodes = list(
        shapes
            .iter()
            .zip(0..)
            .map(|((name, _), i)| format!(r#"{{"name":"{name}","mesh":{i}}}"#)),
    );
    let scenes = list(
        shapes
            .iter()
            .zip(0..)
            .map(|((name, _), i)| format!(r#"{{"name":"{name}","nodes":[{i}]}}"#)),
    );
    let (views, accessors) = (list(chunk.views), list(chunk.accessors));
    let json = format!(
        r#"{{
"asset":{{"version":"2.0","generator":"bevy_sightline make_assets"}},
"scene":0,
"scenes":{scenes},
"nodes":{nodes},
"meshes":{meshes},
"materials":[{MATERIAL}],
"accessors":{accessors},
"bufferViews":{views},
"buffers":[{{"byteLength":{}}}]
}}"#,
        chunk.bytes.len()
    );

    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    put(&mut file, 2);
    put(&mut file, 12 + 8 + json.len() + 8 + chunk.bytes.len());
    for (kind, content) in [(b"JSON", json), (b"BIN\0", chunk.bytes)] {
        put(&mut file, content.len());
        file.extend(kind);
        file.extend(content);
    }
    file
}

fn put(file: &mut Vec<u8>, number: usize) {
    let number = u32::try_from(number).expect("a file of less than 4 GiB");
    file.extend(number.to_le_bytes());
}

fn list(items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<_> = items.into_iter().collect();
    format!("[{}]", items.join(","))
}

/// The binary chunk as it grows, and the JSON of the views and accessors into it.
#[derive(Default)]
struct Chunk {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Chunk {
    fn mesh(&mut self, name: &str, shape: &Shape) -> String {
        let (vertices, indices) = weld(shape);
        let floats = |get: fn(&Vertex) -> &[u32]| vertices.iter().flat_map(get).flat_map(|f| f.to_le_bytes()).collect();
        let count = vertices.len();

        let bounds = shape.bounds();
        let [min, max] = [bounds.min, bounds.max].map(|corner| list(corner.to_array().map(|c| c.to_string())));
        let range = format!(r#","min":{min},"max":{max}"#);
        let position = self.accessor(
            floats(|v| &v.position),
            VERTICES,
            FLOAT,
            count,
            &format!(r#""VEC3"{range}"#),
        );
        let normal = self.accessor(floats(|v| &v.normal), VERTICES, FLOAT, count, r#""VEC3""#);
        let uv = self.accessor(floats(|v| &v.uv), VERTICES, FLOAT, count, r#""VEC2""#);
        let colors = vertices.iter().flat_map(|v| v.color).collect();
        let color = self.accessor(colors, VERTICES, UNSIGNED_BYTE, count, r#""VEC4","normalized":true"#);

        let short: Result<Vec<u16>, _> = indices.iter().map(|&i| u16::try_from(i)).collect();
        let (content, kind): (Vec<u8>, _) = match short {
            Ok(short) if count <= usize::from(u16::MAX) => {
                (short.iter().flat_map(|i| i.to_le_bytes()).collect(), UNSIGNED_SHORT)
            }
            _ => (indices.iter().flat_map(|i| i.to_le_bytes()).collect(), UNSIGNED_INT),
        };
        let index = self.accessor(content, INDICES, kind, indices.len(), r#""SCALAR""#);
        format!(
            r#"{{"name":"{name}","primitives":[{{
    "attributes":{{"POSITION":{position},"NORMAL":{normal},"TEXCOORD_0":{uv},"COLOR_0":{color}}},
    "indices":{index},"material":0
}}]}}"#
        )
    }

    /// Appends numbers, with a view and an accessor of their own, and says the accessor's index.
    fn accessor(&mut self, content: Vec<u8>, target: u32, kind: u32, count: usize, more: &str) -> usize {
        let index = self.accessors.len();
        let (offset, length) = (self.bytes.len(), content.len());
        self.bytes.extend(content);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length},"target":{target}}}"#
        ));
        self.accessors.push(format!(
            r#"{{"bufferView":{index},"componentType":{kind},"count":{count},"type":{more}}}"#
        ));
        index
    }
}

/// A vertex as the bits of its numbers, by which equal ones are told.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Vertex {
    position: [u32; 3],
    normal: [u32; 3],
    uv: [u32; 2],
    color: [u8; 4],
}

/// Makes corners that are alike one vertex.
fn weld(shape: &Shape) -> (Vec<Vertex>, Vec<u32>) {
    let mut vertices = Vec::new();
    let mut known = BTreeMap::new();
    let mut indices = Vec::with_capacity(shape.triangles.len() * 3);
    for triangle in &shape.triangles {
        let [a, b, c] = triangle.map(|corner| corner.position);
        let facing = (b - a).cross(c - a);
        for corner in triangle {
            let vertex = vertex(corner, facing);
            let index = *known.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            });
            indices.push(index);
        }
    }
    (vertices, indices)
}

/// Texture coordinates are metres on the side of a box that the triangle faces most.
fn vertex(corner: &Corner, facing: Vec3) -> Vertex {
    let Vec3 { x, y, z } = corner.position;
    let [along_x, along_y, along_z] = facing.to_array().map(f32::abs);
    let uv = if along_y >= along_x && along_y >= along_z {
        [x, z * facing.y.signum()]
    } else if along_x >= along_z {
        [-z * facing.x.signum(), -y]
    } else {
        [x * facing.z.signum(), -y]
    };
    // Adding zero makes a negative zero a plain one.
    let bits = |value: f32| (value + 0.0).to_bits();
    Vertex {
        position: corner.position.to_array().map(bits),
        normal: corner.normal.to_array().map(bits),
        uv: uv.map(bits),
        color: corner.color.0,
    }
}
