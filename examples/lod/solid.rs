//! Coloured meshes, put together from a few shapes.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};

use crate::paint::Palette;

/// Triangles, counter-clockwise seen from outside.
#[derive(Clone, Default)]
pub struct Solid {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<Srgba>,
    indices: Vec<u32>,
}

impl Solid {
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    fn corner(&mut self, position: Vec3, normal: Vec3, color: Srgba) {
        self.positions.push(position.into());
        self.normals.push(normal.into());
        self.colors.push(color);
    }

    /// A flat and convex polygon.
    pub fn polygon(&mut self, corners: &[Vec3], color: Srgba) {
        let first = self.positions.len() as u32;
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize_or_zero();
        for &corner in corners {
            self.corner(corner, normal, color);
        }
        for next in 1..corners.len() as u32 - 1 {
            self.indices.extend([first, first + next, first + next + 1]);
        }
    }

    /// A box along the axes.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3, color: Srgba) {
        let corner = |x: bool, y: bool, z: bool| Vec3::select(BVec3::new(x, y, z), max, min);
        let (low, high) = (false, true);
        for x in [low, high] {
            let side = [(low, low), (low, high), (high, high), (high, low)].map(|(y, z)| corner(x, y, z));
            self.face(side, x, color);
        }
        for y in [low, high] {
            let side = [(low, low), (low, high), (high, high), (high, low)].map(|(z, x)| corner(x, y, z));
            self.face(side, y, color);
        }
        for z in [low, high] {
            let side = [(low, low), (low, high), (high, high), (high, low)].map(|(x, y)| corner(x, y, z));
            self.face(side, z, color);
        }
    }

    /// A side of a box, which runs clockwise about the axis that it is on the high or the low end of.
    fn face(&mut self, mut corners: [Vec3; 4], is_high: bool, color: Srgba) {
        if is_high {
            corners.reverse();
        }
        self.polygon(&corners, color);
    }

    /// A prism that stands on `foot`, open below.
    pub fn pole(&mut self, foot: Vec3, radius: f32, height: f32, sides: u32, color: Srgba) {
        let at = |side: u32, y: f32| {
            let (sin, cos) = (side as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
            foot + Vec3::new(radius * sin, y, radius * cos)
        };
        for side in 0..sides {
            let (here, there) = (side, (side + 1) % sides);
            self.polygon(
                &[at(here, 0.0), at(there, 0.0), at(there, height), at(here, height)],
                color,
            );
        }
        let top: Vec<Vec3> = (0..sides).map(|side| at(side, height)).collect();
        self.polygon(&top, color);
    }

    /// An ellipsoid: an icosahedron of which each edge is cut into `splits` + 1 parts.
    pub fn ball(&mut self, center: Vec3, radii: Vec3, splits: u32, color: Srgba) {
        let Ok(sphere) = Sphere::new(1.0).mesh().ico(splits) else {
            return;
        };
        let (Some(VertexAttributeValues::Float32x3(points)), Some(indices)) =
            (sphere.attribute(Mesh::ATTRIBUTE_POSITION), sphere.indices())
        else {
            return;
        };
        let first = self.positions.len() as u32;
        for &point in points {
            let point = Vec3::from(point);
            self.corner(center + radii * point, (point / radii).normalize_or_zero(), color);
        }
        self.indices.extend(indices.iter().map(|index| first + index as u32));
    }

    /// Adds a copy of another, turned and moved.
    pub fn add(&mut self, other: &Self, place: &Transform) {
        let first = self.positions.len() as u32;
        let points = other
            .positions
            .iter()
            .map(|&point| (*place * Vec3::from(point)).to_array());
        self.positions.extend(points);
        let normals = other
            .normals
            .iter()
            .map(|&normal| (place.rotation * Vec3::from(normal)).to_array());
        self.normals.extend(normals);
        self.colors.extend(&other.colors);
        self.indices.extend(other.indices.iter().map(|index| first + index));
    }

    /// Vertices have the brightness of their colours; what else makes a colour is in the palette.
    pub fn into_mesh(self, palette: &mut Palette) -> Mesh {
        let (brightness, places): (Vec<_>, Vec<_>) = self.colors.iter().map(|&color| palette.split(color)).unzip();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, brightness)
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, places)
            .with_inserted_indices(Indices::U32(self.indices))
    }
}
