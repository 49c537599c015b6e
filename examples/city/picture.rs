//! A picture of the view without a renderer: one ray per pixel, and one more towards the sun.

use std::{error::Error, path::PathBuf, time::Instant};

use bevy::{
    asset::RenderAssetUsages,
    ecs::system::SystemParam,
    mesh::VertexAttributeValues,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
    tasks::{ComputeTaskPool, ParallelSliceMut},
};
use bevy_sightline::prelude::*;

use crate::{
    headless::make_folder_of,
    scenery::{SKY, TO_SUN},
};

const WIDTH: u32 = 1280;
const HEIGHT: u32 = 720;

/// Draws what the camera sees into a PNG file, and returns the milliseconds that the rays took.
pub fn draw(
    In(file): In<PathBuf>,
    scene: SceneQuery,
    camera: Single<(&Camera, &GlobalTransform)>,
    paint: Paint,
) -> Result<f64, Box<dyn Error + Send + Sync>> {
    let (camera, camera_transform) = *camera;
    let size = camera.logical_viewport_size().ok_or("the camera has no viewport")?;

    let mut pixels = vec![[0_u8; 4]; (WIDTH * HEIGHT) as usize];
    let start = Instant::now();
    pixels.par_chunk_map_mut(ComputeTaskPool::get(), WIDTH as usize, |row, pixels| {
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let place = Vec2::new(column as f32 + 0.5, row as f32 + 0.5) / Vec2::new(WIDTH as f32, HEIGHT as f32);
            let color = camera
                .viewport_to_world(camera_transform, place * size)
                .map_or(LinearRgba::BLACK, |ray| shade(&scene, &paint, ray));
            *pixel = Srgba::from(color).to_u8_array();
        }
    });
    let ms = start.elapsed().as_secs_f64() * 1e3;

    let extent = Extent3d {
        width: WIDTH,
        height: HEIGHT,
        depth_or_array_layers: 1,
    };
    let image = Image::new(
        extent,
        TextureDimension::D2,
        pixels.into_flattened(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::MAIN_WORLD,
    );
    make_folder_of(&file)?;
    image.try_into_dynamic()?.save(&file)?;
    Ok(ms)
}

/// The light that a ray sees: the paint by the direction of the normal, with shadow and haze.
fn shade(scene: &SceneQuery, paint: &Paint, ray: Ray3d) -> LinearRgba {
    let settings = SceneQuerySettings::default();
    let sky = SKY.to_linear();
    let Some(hit) = scene.cast_ray(ray, &settings) else {
        return sky;
    };
    let to_sun = Dir3::new(TO_SUN).expect("the sun is somewhere");
    let toward = hit.normal.dot(*to_sun).max(0.0);
    // Started off the surface, so as not to meet it again.
    let shadow_ray = Ray3d::new(hit.position + hit.normal * 1e-3 * hit.distance.max(1.0), to_sun);
    let in_sun = toward > 0.0 && !scene.any_hit(shadow_ray, &settings);
    let light = 0.30 + 0.12 * hit.normal.y + if in_sun { toward } else { 0.0 };
    let haze = 1.0 - (-hit.distance / 2500.0).exp();
    (paint.at(&hit) * light).mix(&sky, haze)
}

/// What colours things have.
#[derive(SystemParam)]
pub struct Paint<'w, 's> {
    meshes: Res<'w, Assets<Mesh>>,
    materials: Res<'w, Assets<StandardMaterial>>,
    things: Query<'w, 's, (&'static Mesh3d, &'static MeshMaterial3d<StandardMaterial>)>,
}

impl Paint<'_, '_> {
    /// The colour of the material where a ray has hit, times that of the vertices.
    fn at(&self, hit: &RayHit) -> LinearRgba {
        let Ok((mesh, material)) = self.things.get(hit.entity) else {
            return LinearRgba::WHITE;
        };
        let base = self
            .materials
            .get(material)
            .map_or(Color::WHITE, |material| material.base_color);
        let vertices = self.meshes.get(mesh).and_then(|mesh| vertex_color(mesh, hit.triangle?));
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
