//! The binary form of glTF 2.0: a JSON chunk that says what there is, and a binary chunk with the numbers.

use std::collections::BTreeMap;

use crate::math::Vec3;
use crate::morph::Morph;
use crate::rig::{Clip, Influences, Joint, Pose, Rig};
use crate::shape::{Bounds, Corner, Shape};

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: Option<u32> = Some(34962);
const INDICES: Option<u32> = Some(34963);
/// For numbers that are no part of a mesh.
const OTHER: Option<u32> = None;

const MATERIAL: &str = r#"{
    "name":"painted","doubleSided":false,
    "pbrMetallicRoughness":{"baseColorFactor":[1,1,1,1],"metallicFactor":0,"roughnessFactor":0.8}
}"#;

/// A file with one mesh, one node and one scene for each of the shapes.
pub fn encode(shapes: &[(String, Shape)]) -> Vec<u8> {
    let mut chunk = Chunk::default();
    let meshes = list(
        shapes
            .iter()
            .map(|(name, shape)| chunk.mesh(name, &[(shape, &|_| RIGID)], &[])),
    );
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
    let content = format!(
        r#""scenes":{scenes},
"nodes":{nodes},
"meshes":{meshes}"#
    );
    chunk.into_file(&content)
}

/// A file with one skinned mesh, its skeleton and its animations, under one node of the given name.
pub fn encode_rig(name: &str, rig: &Rig) -> Vec<u8> {
    let mut chunk = Chunk::default();
    let follow: Vec<_> = rig
        .skin
        .iter()
        .map(|part| move |point| rig.influences(part, point))
        .collect();
    let parts: Vec<Part> = (rig.skin.iter().zip(&follow))
        .map(|(part, follow)| (&part.shape, follow as &dyn Fn(Vec3) -> Influences))
        .collect();
    let mesh = chunk.mesh(name, &parts, &[]);
    let skin = chunk.skin(name, &rig.joints);
    let animations = list(rig.clips.iter().map(|clip| chunk.animation(clip)));
    let count = rig.joints.len();
    let nodes = (0..count).map(|number| joint_node(&rig.joints, number)).chain([
        format!(r#"{{"name":"{name}_skin","mesh":0,"skin":0}}"#),
        format!(r#"{{"name":"{name}","children":[0,{count}]}}"#),
    ]);
    let content = format!(
        r#""scenes":[{{"name":"{name}","nodes":[{}]}}],
"nodes":{},
"meshes":[{mesh}],
"skins":[{skin}],
"animations":{animations}"#,
        count + 1,
        list(nodes),
    );
    chunk.into_file(&content)
}

/// A file with one mesh that has morph targets, and an animation of their weights.
pub fn encode_morph(name: &str, morph: &Morph) -> Vec<u8> {
    let mut chunk = Chunk::default();
    let targets: Vec<&Shape> = morph.targets.iter().map(|(_, target)| target).collect();
    let mesh = chunk.mesh(name, &[(&morph.base, &|_| RIGID)], &targets);
    let names = list(morph.targets.iter().map(|(name, _)| format!(r#""{name}""#)));
    let none = list(targets.iter().map(|_| "0".into()));

    let clip = &morph.clip;
    let count = clip.weights.len();
    let times = chunk.times(clip.seconds, count);
    let weights = clip.weights.iter().flatten().copied();
    let output = chunk.floats(weights, count * targets.len(), r#""SCALAR""#);
    let content = format!(
        r#""scenes":[{{"name":"{name}","nodes":[0]}}],
"nodes":[{{"name":"{name}","mesh":0}}],
"meshes":[{{"extras":{{"targetNames":{names}}},"weights":{none},{}],
"animations":[{{"name":"{}","samplers":[{{"input":{times},"output":{output}}}],
    "channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}]}}]"#,
        &mesh[1..],
        clip.name
    );
    chunk.into_file(&content)
}

/// A joint where it is in the pose in which the skin was made.
fn joint_node(joints: &[Joint], number: usize) -> String {
    let joint = &joints[number];
    let from = joint.parent.map_or(Vec3::ZERO, |parent| joints[parent].at);
    let children: Vec<String> = (0..joints.len())
        .filter(|&child| joints[child].parent == Some(number))
        .map(|child| child.to_string())
        .collect();
    let children = if children.is_empty() {
        String::new()
    } else {
        format!(r#","children":{}"#, list(children))
    };
    format!(
        r#"{{"name":"{}","translation":{}{children}}}"#,
        joint.name,
        numbers(joint.at - from)
    )
}

fn put(file: &mut Vec<u8>, number: usize) {
    let number = u32::try_from(number).expect("a file of less than 4 GiB");
    file.extend(number.to_le_bytes());
}

fn list(items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<_> = items.into_iter().collect();
    format!("[{}]", items.join(","))
}

fn numbers(vector: Vec3) -> String {
    list(vector.to_array().map(|c| c.to_string()))
}

/// A part of a mesh: its triangles, and which joints its vertices follow.
type Part<'a> = (&'a Shape, &'a dyn Fn(Vec3) -> Influences);

/// Follows no joint.
const RIGID: Influences = ([0; 4], [0; 4]);

/// The binary chunk as it grows, and the JSON of the views and accessors into it.
#[derive(Default)]
struct Chunk {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Chunk {
    /// The whole file, given the JSON of what refers to the accessors.
    fn into_file(self, content: &str) -> Vec<u8> {
        let (views, accessors) = (list(self.views), list(self.accessors));
        let json = format!(
            r#"{{
"asset":{{"version":"2.0","generator":"bevy_sightline make_assets"}},
"scene":0,
{content},
"materials":[{MATERIAL}],
"accessors":{accessors},
"bufferViews":{views},
"buffers":[{{"byteLength":{}}}]
}}"#,
            self.bytes.len()
        );
        let mut json = json.into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut file = b"glTF".to_vec();
        put(&mut file, 2);
        put(&mut file, 12 + 8 + json.len() + 8 + self.bytes.len());
        for (kind, content) in [(b"JSON", json), (b"BIN\0", self.bytes)] {
            put(&mut file, content.len());
            file.extend(kind);
            file.extend(content);
        }
        file
    }

    /// A mesh of parts; its morph targets have the same triangles as the first of them.
    fn mesh(&mut self, name: &str, parts: &[Part], targets: &[&Shape]) -> String {
        let Welded {
            vertices,
            corners,
            indices,
        } = weld(parts);
        let words = |get: fn(&Vertex) -> &[u32]| vertices.iter().flat_map(get).flat_map(|f| f.to_le_bytes()).collect();
        let bytes = |get: fn(&Vertex) -> [u8; 4]| vertices.iter().flat_map(get).collect();
        let count = vertices.len();

        let bounds = parts.iter().map(|(shape, _)| shape.bounds());
        let bounds = bounds
            .reduce(|a, b| Bounds {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            })
            .expect("a mesh of at least one part");
        let range = format!(r#","min":{},"max":{}"#, numbers(bounds.min), numbers(bounds.max));
        let position = self.accessor(
            words(|v| &v.position),
            VERTICES,
            FLOAT,
            count,
            &format!(r#""VEC3"{range}"#),
        );
        let normal = self.accessor(words(|v| &v.normal), VERTICES, FLOAT, count, r#""VEC3""#);
        let uv = self.accessor(words(|v| &v.uv), VERTICES, FLOAT, count, r#""VEC2""#);
        let parts_of_one = r#""VEC4","normalized":true"#;
        let color = self.accessor(bytes(|v| v.color), VERTICES, UNSIGNED_BYTE, count, parts_of_one);
        let mut attributes = format!(r#""POSITION":{position},"NORMAL":{normal},"TEXCOORD_0":{uv},"COLOR_0":{color}"#);
        if vertices.iter().any(|vertex| vertex.influences != RIGID) {
            let joints = self.accessor(bytes(|v| v.influences.0), VERTICES, UNSIGNED_BYTE, count, r#""VEC4""#);
            let weights = self.accessor(bytes(|v| v.influences.1), VERTICES, UNSIGNED_BYTE, count, parts_of_one);
            attributes += &format!(r#","JOINTS_0":{joints},"WEIGHTS_0":{weights}"#);
        }

        let base = parts[0].0;
        let targets: Vec<_> = targets
            .iter()
            .map(|target| self.target(base, target, &corners))
            .collect();
        let targets = if targets.is_empty() {
            String::new()
        } else {
            format!(r#","targets":{}"#, list(targets))
        };

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
    "attributes":{{{attributes}}},
    "indices":{index},"material":0{targets}
}}]}}"#
        )
    }

    /// What a morph target adds to each vertex.
    fn target(&mut self, base: &Shape, target: &Shape, corners: &[usize]) -> String {
        let corner = |shape: &Shape, number: usize| shape.triangles[number / 3][number % 3];
        let moved: Vec<(Vec3, Vec3)> = corners
            .iter()
            .map(|&number| (corner(base, number), corner(target, number)))
            .map(|(from, to)| (to.position - from.position, to.normal - from.normal))
            .collect();
        let far = moved[0].0;
        let (min, max) = moved
            .iter()
            .fold((far, far), |(min, max), (way, _)| (min.min(*way), max.max(*way)));
        let range = format!(r#""VEC3","min":{},"max":{}"#, numbers(min), numbers(max));
        let count = moved.len();
        let position = self.floats(moved.iter().flat_map(|(way, _)| way.to_array()), count, &range);
        let normal = self.floats(moved.iter().flat_map(|(_, turn)| turn.to_array()), count, r#""VEC3""#);
        format!(r#"{{"POSITION":{position},"NORMAL":{normal}}}"#)
    }

    /// The joints are the first nodes of the file.
    fn skin(&mut self, name: &str, joints: &[Joint]) -> String {
        let matrices = joints.iter().flat_map(|joint| {
            let [x, y, z] = (Vec3::ZERO - joint.at).to_array();
            [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]
        });
        let inverse = self.floats(matrices, joints.len(), r#""MAT4""#);
        let nodes = list((0..joints.len()).map(|number| number.to_string()));
        format!(r#"{{"name":"{name}","skeleton":0,"joints":{nodes},"inverseBindMatrices":{inverse}}}"#)
    }

    /// Turns every joint, and moves the first.
    fn animation(&mut self, clip: &Clip) -> String {
        let count = clip.poses.len();
        let times = self.times(clip.seconds, count);
        let roots = clip.poses.iter().flat_map(|pose| pose.root.to_array());
        let mut outputs = vec![(0, "translation", self.floats(roots, count, r#""VEC3""#))];
        for joint in 0..clip.poses[0].turns.len() {
            let turn = |pose: &Pose| {
                let turn = pose.turns[joint];
                let Vec3 { x, y, z } = turn.axis;
                [x, y, z, turn.w]
            };
            outputs.push((
                joint,
                "rotation",
                self.floats(clip.poses.iter().flat_map(turn), count, r#""VEC4""#),
            ));
        }
        let samplers = list(
            outputs
                .iter()
                .map(|(_, _, output)| format!(r#"{{"input":{times},"output":{output}}}"#)),
        );
        let channels = list(outputs.iter().zip(0..).map(|((node, path, _), sampler)| {
            format!(r#"{{"sampler":{sampler},"target":{{"node":{node},"path":"{path}"}}}}"#)
        }));
        format!(
            r#"{{"name":"{}","samplers":{samplers},"channels":{channels}}}"#,
            clip.name
        )
    }

    /// Equal times from zero.
    fn times(&mut self, seconds: f32, count: usize) -> usize {
        let times = (0..count).map(|i| seconds * i as f32 / (count - 1) as f32);
        self.floats(times, count, &format!(r#""SCALAR","min":[0],"max":[{seconds}]"#))
    }

    fn floats(&mut self, numbers: impl Iterator<Item = f32>, count: usize, more: &str) -> usize {
        let content = numbers.flat_map(|number| (number + 0.0).to_le_bytes()).collect();
        self.accessor(content, OTHER, FLOAT, count, more)
    }

    /// Appends numbers, with a view and an accessor of their own, and says the accessor's index.
    fn accessor(&mut self, content: Vec<u8>, target: Option<u32>, kind: u32, count: usize, more: &str) -> usize {
        let index = self.accessors.len();
        let (offset, length) = (self.bytes.len(), content.len());
        self.bytes.extend(content);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let target = target.map_or(String::new(), |target| format!(r#","target":{target}"#));
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}{target}}}"#
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
    influences: Influences,
}

/// A mesh in which corners that are alike are one vertex.
#[derive(Default)]
struct Welded {
    vertices: Vec<Vertex>,
    /// The first corner that is each vertex, counted through all triangles.
    corners: Vec<usize>,
    indices: Vec<u32>,
}

fn weld(parts: &[Part]) -> Welded {
    let mut welded = Welded::default();
    let mut known = BTreeMap::new();
    for (shape, influences) in parts {
        for triangle in &shape.triangles {
            let [a, b, c] = triangle.map(|corner| corner.position);
            let facing = (b - a).cross(c - a);
            for corner in triangle {
                let vertex = vertex(corner, facing, influences(corner.position));
                let index = *known.entry(vertex).or_insert_with(|| {
                    welded.vertices.push(vertex);
                    welded.corners.push(welded.indices.len());
                    welded.vertices.len() as u32 - 1
                });
                welded.indices.push(index);
            }
        }
    }
    welded
}

/// Texture coordinates are metres on the side of a box that the triangle faces most.
fn vertex(corner: &Corner, facing: Vec3, influences: Influences) -> Vertex {
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
        influences,
    }
}
