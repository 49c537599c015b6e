//! The buffer as a picture.

use bevy::{asset::RenderAssetUsages, image::Image};

use super::buffer::MaskedDepthBuffer;

/// What nothing covers.
const UNCOVERED: [u8; 4] = [24, 28, 40, 255];

impl MaskedDepthBuffer {
    /// A picture of what is known, for people: the nearer the brighter, relative to what is nearest, and dark where
    /// nothing is known to hide anything. In sRGB, with as many pixels as the buffer.
    pub fn to_image(&self) -> Image {
        let mut image = Image::default();
        self.write_to_image(&mut image);
        image
    }

    /// The same in an image that is there, of which the memory is kept.
    pub fn write_to_image(&self, image: &mut Image) {
        let size = self.size();
        let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
        let depths = || pixels.clone().map(|(x, y)| self.depth(x, y));
        let nearest = depths().flatten().fold(f32::MIN_POSITIVE, f32::max);
        let mut data = image.data.take().unwrap_or_default();
        data.clear();
        data.extend(depths().flat_map(|depth| {
            depth.map_or(UNCOVERED, |depth| {
                // Depths fall so fast with distance that their square root shows more.
                let brightness = 64.0 + 191.0 * (depth.max(0.0) / nearest).sqrt();
                let gray = brightness as u8;
                [gray, gray, gray, 255]
            })
        }));
        let default = Image::default();
        image.texture_descriptor.format = default.texture_descriptor.format;
        image.texture_descriptor.size.width = size.x;
        image.texture_descriptor.size.height = size.y;
        image.asset_usage = RenderAssetUsages::default();
        image.data = Some(data);
    }
}
