//! A material for each level: in one colour, or in those of things.

use bevy::{
    asset::RenderAssetUsages,
    image::ImageSampler,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

/// From the finest level to the proxy of a block. Trees and lamps have the first three.
pub const COLORS: [Srgba; 4] = [
    Srgba::rgb(1.00, 0.42, 0.32),
    Srgba::rgb(1.00, 0.84, 0.34),
    Srgba::rgb(0.46, 0.86, 0.46),
    Srgba::rgb(0.42, 0.62, 1.00),
];

/// The most colours that there may be, but for how bright they are.
const PLACES: usize = 64;

/// The colours of things at their brightest, as a row of pixels.
#[derive(Default)]
pub struct Palette(Vec<[u8; 4]>);

impl Palette {
    /// How bright a colour is, as the colour of a vertex, and where in the row it is.
    pub fn split(&mut self, color: Srgba) -> ([f32; 4], [f32; 2]) {
        let [red, green, blue, _] = LinearRgba::from(color).to_f32_array();
        let brightness = red.max(green).max(blue).max(f32::MIN_POSITIVE);
        let brightest = LinearRgba::rgb(red / brightness, green / brightness, blue / brightness);
        let brightest = Srgba::from(brightest).to_u8_array();
        let known = self.0.iter().position(|&other| other == brightest);
        let place = known.unwrap_or_else(|| {
            self.0.push(brightest);
            self.0.len() - 1
        });
        let along = (place as f32 + 0.5) / PLACES as f32;
        ([brightness, brightness, brightness, 1.0], [along, 0.5])
    }

    pub fn into_image(mut self) -> Image {
        self.0.resize(PLACES, [255; 4]);
        let size = Extent3d {
            width: PLACES as u32,
            ..default()
        };
        let mut image = Image::new(
            size,
            TextureDimension::D2,
            self.0.concat(),
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::default(),
        );
        image.sampler = ImageSampler::nearest();
        image
    }
}

/// The materials of the levels.
#[derive(Resource)]
pub struct Paints {
    levels: [Handle<StandardMaterial>; 4],
    /// The [`Palette`] of things.
    pub colors_of_things: Handle<Image>,
    are_colored: bool,
}

impl Paints {
    pub fn of_level(&self, level: usize) -> MeshMaterial3d<StandardMaterial> {
        MeshMaterial3d(self.levels[level].clone())
    }
}

pub fn plugin(app: &mut App) {
    app.add_systems(PreStartup, mix);
}

/// What only a window needs.
pub fn window_plugin(app: &mut App) {
    app.add_systems(Update, toggle);
}

fn mix(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
    let levels = COLORS.map(|color| {
        materials.add(StandardMaterial {
            base_color: color.into(),
            perceptual_roughness: 0.9,
            reflectance: 0.2,
            ..default()
        })
    });
    commands.insert_resource(Paints {
        levels,
        colors_of_things: default(),
        are_colored: true,
    });
}

fn toggle(
    keys: Res<ButtonInput<KeyCode>>,
    mut paints: ResMut<Paints>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if !keys.just_pressed(KeyCode::KeyC) {
        return;
    }
    paints.are_colored ^= true;
    for (handle, color) in paints.levels.iter().zip(COLORS) {
        if let Some(mut material) = materials.get_mut(handle) {
            (material.base_color, material.base_color_texture) = if paints.are_colored {
                (color.into(), None)
            } else {
                (Color::WHITE, Some(paints.colors_of_things.clone()))
            };
        }
    }
}
