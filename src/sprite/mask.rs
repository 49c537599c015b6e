//! Which pixels of an image can be hit: one bit for each.

use bevy::{
    color::Alpha,
    image::{Image, TextureAccessError, TextureFormatPixelInfo},
    math::{DVec2, UVec2},
};

/// Which pixels of an image can be hit.
#[derive(Debug)]
pub(super) struct AlphaMask {
    size: UVec2,
    /// Row by row from the top, without a gap between rows.
    opaque: Box<[u64]>,
}

/// Why the pixels of an image cannot be read.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unreadable {
    #[error("{0}")]
    Pixels(#[from] TextureAccessError),
    #[error("it has fewer bytes than pixels")]
    Truncated,
}

impl AlphaMask {
    /// The pixels whose alpha is above `threshold`; `None` if that is all of them.
    pub fn new(image: &Image, threshold: f32) -> Result<Option<Self>, Unreadable> {
        let size = image.size();
        let len = size.x as usize * size.y as usize;
        if len == 0 {
            return Ok(None);
        }
        let format = image.texture_descriptor.format;
        let data = image.data.as_deref().ok_or(TextureAccessError::Uninitialized)?;
        // The colour of a pixel that is not there would panic.
        if data.len() < len * format.pixel_size()? {
            return Err(Unreadable::Truncated);
        }
        image.get_color_at(0, 0)?;

        let rgba8_srgb = Image::default().texture_descriptor.format;
        let mask = if format == rgba8_srgb || format == rgba8_srgb.remove_srgb_suffix() {
            // What nearly all images are: one look at one byte for each pixel.
            let is_opaque: [bool; 256] = std::array::from_fn(|alpha| alpha as f32 / 255.0 > threshold);
            let pixels = data.chunks_exact(4).take(len);
            Self::from_pixels(size, pixels.map(|pixel| is_opaque[usize::from(pixel[3])]))
        } else {
            let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
            let is_opaque = |(x, y)| image.get_color_at(x, y).is_ok_and(|color| color.alpha() > threshold);
            Self::from_pixels(size, pixels.map(is_opaque))
        };
        Ok((!mask.is_full()).then_some(mask))
    }

    fn from_pixels(size: UVec2, mut pixels: impl Iterator<Item = bool>) -> Self {
        let len = size.x as usize * size.y as usize;
        let words = (0..len.div_ceil(64)).map(|_| {
            let bits = pixels.by_ref().take(64).enumerate();
            bits.fold(0, |word, (bit, opaque)| word | u64::from(opaque) << bit)
        });
        let opaque = words.collect();
        Self { size, opaque }
    }

    fn is_full(&self) -> bool {
        let opaque: u64 = self.opaque.iter().map(|word| u64::from(word.count_ones())).sum();
        opaque == u64::from(self.size.x) * u64::from(self.size.y)
    }

    /// Whether a point of the image can be hit, in pixels from the top left corner. Beyond the image is what is at its edge.
    pub fn is_opaque_at(&self, point: DVec2) -> bool {
        let pixel = point.max(DVec2::ZERO).as_uvec2().min(self.size - UVec2::ONE);
        let index = pixel.y as usize * self.size.x as usize + pixel.x as usize;
        self.opaque[index / 64] >> (index % 64) & 1 != 0
    }

    /// The bytes that the mask takes.
    pub fn memory(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.opaque)
    }
}
