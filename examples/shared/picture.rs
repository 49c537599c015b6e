//! A picture of the view without a renderer: one ray per pixel and one more towards the sun, and lines over it.

use std::{error::Error, fs, path::Path};

use bevy::{
    asset::RenderAssetUsages,
    ecs::system::SystemParam,
    mesh::VertexAttributeValues,
    picking::mesh_picking::ray_cast::SimplifiedMesh,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
    tasks::{ComputeTaskPool, ParallelSliceMut},
};
use bevy_sightline::prelude::*;

/// The pixels, with how far away is what they show.
pub struct Picture<'a> {
    size: UVec2,
    view: View<'a>,
    pixels: Vec<(LinearRgba, f32)>,
}

/// A camera and where it is.
pub type View<'a> = (&'a Camera, &'a GlobalTransform);

impl<'a> Picture<'a> {
    /// Asks `shade` for the colour of what the ray of each pixel sees, and for how far along the ray that is.
    pub fn ray_cast(size: UVec2, view: View<'a>, shade: impl Fn(Ray3d) -> (LinearRgba, f32) + Sync) -> Self {
        let (camera, transform) = view;
        let viewport = camera.logical_viewport_rect().expect("a camera with a viewport");
        let mut pixels = vec![(LinearRgba::BLACK, f32::INFINITY); size.element_product() as usize];
        pixels.par_chunk_map_mut(ComputeTaskPool::get(), size.x as usize, |row, pixels| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let place = Vec2::new(column as f32 + 0.5, row as f32 + 0.5) / size.as_vec2();
                if let Ok(ray) = camera.viewport_to_world(transform, viewport.min + place * viewport.size()) {
                    let (color, along) = shade(ray);
                    // Rays begin on the near plane.
                    *pixel = (color, ray.get_point(along).distance(transform.translation()));
                }
            }
        });
        Self { size, view, pixels }
    }

    /// Draws a line in world space, four pixels wide, and thinned out where it is behind something.
    pub fn line(&mut self, [from, to]: [Vec3; 2], color: impl Into<LinearRgba>) {
        let (camera, transform) = self.view;
        let viewport = camera.logical_viewport_rect().expect("a camera with a viewport");
        let scale = self.size.as_vec2() / viewport.size();
        let pixel_at = |point| {
            camera
                .world_to_viewport(transform, point)
                .ok()
                .map(|place| (place - viewport.min) * scale)
        };
        let (Some(start), Some(end)) = (pixel_at(from), pixel_at(to)) else {
            return;
        };
        let color = color.into();
        let steps = (start.distance(end) * 1.5).ceil().clamp(1.0, 10_000.0) as u32;
        for step in 0..=steps {
            let point = from.lerp(to, step as f32 / steps as f32);
            let distance = point.distance(transform.translation());
            let Some(place) = pixel_at(point).map(Vec2::as_ivec2) else {
                continue;
            };
            for offset in (0..16).map(|i| IVec2::new(i % 4 - 1, i / 4 - 1)) {
                self.blend(place + offset, distance, color);
            }
        }
    }

    fn blend(&mut self, place: IVec2, distance: f32, color: LinearRgba) {
        let Ok(place) = UVec2::try_from(place) else {
            return;
        };
        if place.cmplt(self.size).all() {
            let (under, behind) = &mut self.pixels[(place.y * self.size.x + place.x) as usize];
            let strength = if distance <= *behind * 1.002 { 1.0 } else { 0.02 };
            *under = under.mix(&color, strength);
        }
    }

    /// This picture with another of the same height to the right of it. The lines in both are drawn before.
    #[allow(dead_code, reason = "not every example has two views")]
    pub fn beside(&self, right: &Self) -> Self {
        let row = |picture: &Self, y: u32| {
            let start = (y * picture.size.x) as usize;
            picture.pixels[start..start + picture.size.x as usize].to_vec()
        };
        Self {
            size: self.size + right.size.with_y(0),
            view: self.view,
            pixels: (0..self.size.y)
                .flat_map(|y| [row(self, y), row(right, y)].concat())
                .collect(),
        }
    }

    /// Writes a PNG of half the width and height, each pixel the mean of four, and makes the folder for it.
    pub fn save(&self, file: &Path) -> Result<(), Box<dyn Error + Send + Sync>> {
        let half = self.size / 2;
        let at = |x: u32, y: u32| self.pixels[(y * self.size.x + x) as usize].0;
        // What is in the shade is dark, not transparent.
        let mean = |x: u32, y: u32| {
            let (x, y) = (2 * x, 2 * y);
            ((at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) * 0.25).with_alpha(1.0)
        };
        let pixels = (0..half.y).flat_map(|y| (0..half.x).map(move |x| mean(x, y)));
        let image = Image::new(
            Extent3d {
                width: half.x,
                height: half.y,
                depth_or_array_layers: 1,
            },
            TextureDimension::D2,
            pixels.flat_map(|color| Srgba::from(color).to_u8_array()).collect(),
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::MAIN_WORLD,
        );
        file.parent().map_or(Ok(()), fs::create_dir_all)?;
        image.try_into_dynamic()?.save(file)?;
        Ok(())
    }
}

/// The sky and the sun of a picture.
#[derive(Clone, Copy)]
pub struct Daylight {
    pub sky: Srgba,
    pub to_sun: Vec3,
    /// How far one sees before the haze takes two thirds of the colour.
    pub haze: f32,
}

/// Looks at the scene along rays, and knows what colours things have.
#[derive(SystemParam)]
pub struct Painter<'w, 's> {
    scene: SceneQuery<'w, 's>,
    meshes: Res<'w, Assets<Mesh>>,
    materials: Res<'w, Assets<StandardMaterial>>,
    things: Query<
        'w,
        's,
        (
            AnyOf<(&'static SimplifiedMesh, &'static Mesh3d)>,
            &'static MeshMaterial3d<StandardMaterial>,
        ),
    >,
}

impl Painter<'_, '_> {
    /// The light that a ray sees, and from how far: the paint by the direction of the normal, with shadow and haze.
    #[allow(dead_code, reason = "not every example shows all there is")]
    pub fn shade(&self, ray: Ray3d, daylight: &Daylight) -> (LinearRgba, f32) {
        self.shade_what(&SceneQuerySettings::default(), ray, daylight)
    }

    /// The same of what the settings admit.
    pub fn shade_what(&self, settings: &SceneQuerySettings, ray: Ray3d, daylight: &Daylight) -> (LinearRgba, f32) {
        let sky = LinearRgba::from(daylight.sky);
        let Some(hit) = self.scene.cast_ray(ray, settings) else {
            return (sky, f32::INFINITY);
        };
        let to_sun = Dir3::new(daylight.to_sun).expect("the sun is somewhere");
        let toward = hit.normal.dot(*to_sun).max(0.0);
        // Started off the surface, so as not to meet it again.
        let shadow_ray = Ray3d::new(hit.position + hit.normal * 1e-3 * hit.distance.max(1.0), to_sun);
        let in_sun = toward > 0.0 && !self.scene.any_hit(shadow_ray, settings);
        let light = 0.30 + 0.12 * hit.normal.y + if in_sun { toward } else { 0.0 };
        let haze = 1.0 - (-hit.distance / daylight.haze).exp();
        ((self.paint(&hit) * light).mix(&sky, haze), hit.distance)
    }

    /// The colour of the material where a ray has hit, times that of the vertices.
    fn paint(&self, hit: &RayHit) -> LinearRgba {
        let Ok(((hit_mesh, shown_mesh), material)) = self.things.get(hit.entity) else {
            return LinearRgba::WHITE;
        };
        let mesh = hit_mesh.map(|mesh| &mesh.0).or(shown_mesh.map(|mesh| &mesh.0));
        let base = self
            .materials
            .get(material)
            .map_or(Color::WHITE, |material| material.base_color);
        let mesh = mesh.and_then(|mesh| self.meshes.get(mesh));
        let vertices = mesh.and_then(|mesh| vertex_color(mesh, hit.triangle?));
        let (base, vertices) = (LinearRgba::from(base).to_vec4(), vertices.unwrap_or(Vec4::ONE));
        LinearRgba::from_vec4(base * vertices)
    }
}

/// The interpolated vertex colour, linear, if the mesh has colours and indices.
fn vertex_color(mesh: &Mesh, triangle: HitTriangle) -> Option<Vec4> {
    let VertexAttributeValues::Float32x4(colors) = mesh.attribute(Mesh::ATTRIBUTE_COLOR)? else {
        return None;
    };
    let first = 3 * triangle.index as usize;
    let weighted = mesh.indices()?.iter().skip(first).zip(triangle.barycentrics.to_array());
    Some(
        weighted
            .map(|(vertex, weight)| Vec4::from(colors[vertex]) * weight)
            .sum(),
    )
}
