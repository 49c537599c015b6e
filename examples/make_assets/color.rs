//! The palette: warm stone and brick, slate, teal glass, muted greens. Written as the sRGB one sees, kept as the linear
//! light that glTF stores in vertices.

/// Linear red, green, blue and alpha, a byte each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Color(pub [u8; 4]);

/// The linear colour of an sRGB `0xRRGGBB`.
const fn srgb(hex: u32) -> Color {
    let [_, r, g, b] = hex.to_be_bytes();
    Color([linear(r), linear(g), linear(b), 255])
}

/// A polynomial within half a per cent of the sRGB curve, and the same on every platform.
const fn linear(byte: u8) -> u8 {
    let c = byte as f32 / 255.0;
    (c * (c * (c * 0.305_306 + 0.682_171_1) + 0.012_522_878) * 255.0 + 0.5) as u8
}

impl Color {
    pub const WHITE: Self = Self([255; 4]);

    /// This colour with a share `t` of `other`: what the two look like from afar.
    pub fn mix(self, other: Self, t: f32) -> Self {
        Self(std::array::from_fn(|i| {
            let (a, b) = (f32::from(self.0[i]), f32::from(other.0[i]));
            (a + (b - a) * t + 0.5) as u8
        }))
    }
}

pub const LIMESTONE: Color = srgb(0xd9cbb0);
pub const SANDSTONE: Color = srgb(0xc8ad86);
pub const PLASTER: Color = srgb(0xe9e1d0);
pub const CONCRETE: Color = srgb(0xb4b0a8);
pub const PAVING: Color = srgb(0x8f8b84);
pub const ASPHALT: Color = srgb(0x55565a);
pub const BRICK: Color = srgb(0xa4604a);
pub const DARK_BRICK: Color = srgb(0x7c4638);
pub const SLATE: Color = srgb(0x4f5a66);
pub const ROOF_TILE: Color = srgb(0x9c5440);
pub const COPPER: Color = srgb(0x74a394);
pub const GLASS: Color = srgb(0x3f7780);
pub const DEEP_GLASS: Color = srgb(0x2b4c59);
pub const WATER: Color = srgb(0x5fa3b3);
pub const STEEL: Color = srgb(0x9aa3a8);
pub const IRON: Color = srgb(0x3a4247);
pub const BRASS: Color = srgb(0xc9a257);
pub const BRONZE: Color = srgb(0x7d8f78);
pub const WOOD: Color = srgb(0x9a6f47);
pub const BARK: Color = srgb(0x6b5240);
pub const LEAF: Color = srgb(0x7c9a55);
pub const SHADE_LEAF: Color = srgb(0x4a6b3f);
pub const NEEDLE: Color = srgb(0x55805f);
pub const SHADE_NEEDLE: Color = srgb(0x30523f);
pub const RUBBER: Color = srgb(0x2c2d30);
pub const TEAL: Color = srgb(0x2f7f86);
pub const CREAM: Color = srgb(0xefe6cf);
pub const RED: Color = srgb(0xb8463a);
pub const AMBER: Color = srgb(0xe0a03c);
pub const GREEN: Color = srgb(0x4fa06a);
pub const LAMPLIGHT: Color = srgb(0xfff0c4);
pub const SKIN: Color = srgb(0xd9a583);
pub const HAIR: Color = srgb(0x4b3328);
pub const COAT: Color = srgb(0x3d6478);
pub const DENIM: Color = srgb(0x3b4658);
pub const FOX_RED: Color = srgb(0xd9742b);
pub const FOX_DARK: Color = srgb(0x9c4a22);
pub const CREAM_FUR: Color = srgb(0xf6ecdc);
pub const INK: Color = srgb(0x2a2224);
