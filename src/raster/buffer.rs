//! The buffer itself.

use bevy::{
    math::UVec2,
    reflect::{Reflect, std_traits::ReflectDefault},
};

use super::{
    canvas::{Band, Canvas},
    clip::Vertex,
    outline::ObjectTile,
    tile::{NOTHING, TILE_HEIGHT, TILE_WIDTH, Tile},
};

/// How surely something is hidden that is told to be: see [`raster`](super).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum RasterMode {
    /// What can be seen is never told to be hidden.
    #[default]
    Strict,
    /// What can be seen only between the centres of pixels may be told to be hidden.
    Fast,
}

/// Which faces of meshes are drawn, by how their corners are ordered on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Faces {
    /// Those whose corners run counter-clockwise: enough for what is closed.
    #[default]
    Front,
    /// Those whose corners run clockwise.
    Back,
    /// All: for what is open and seen from both sides.
    Both,
}

/// A depth buffer to draw what hides into, and to ask what is hidden: see [`raster`](super).
///
/// The default has no pixels: it hides nothing, and nothing is seen in it.
#[derive(Clone, Debug, Default)]
pub struct MaskedDepthBuffer {
    pub(super) size: UVec2,
    pub(super) mode: RasterMode,
    pub(super) tiles: Vec<Tile>,
    pub(super) scratch: Scratch,
}

/// What drawing needs for a while, kept for its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Vertices on the screen: x, y, depth, and where they are outside.
    pub on_screen: Vec<[f32; 4]>,
    /// Vertices in double precision.
    pub vertices: Vec<Vertex>,
    /// Which triangles are drawn.
    pub is_drawn: Vec<bool>,
    /// What has been drawn of a mesh.
    pub object: Vec<ObjectTile>,
    /// To which tiles, by bands that are drawn side by side, of which the last is the first here.
    pub touched: Vec<Vec<u32>>,
}

/// A [`MaskedDepthBuffer`] that is drawn to.
pub(super) struct Begun<'a> {
    pub canvas: Canvas<'a>,
    /// For all bands but the last.
    pub touched: &'a mut [Vec<u32>],
    pub on_screen: &'a mut Vec<[f32; 4]>,
    pub vertices: &'a mut Vec<Vertex>,
    pub is_drawn: &'a mut Vec<bool>,
}

impl MaskedDepthBuffer {
    /// The least and the most pixels along either side.
    const SIDES: (u32, u32) = (8, 8192);

    /// An empty buffer of so many pixels, which hides nothing. Sides are brought within 8 to 8192.
    pub fn new(size: UVec2, mode: RasterMode) -> Self {
        let mut buffer = Self::default();
        buffer.begin(size, mode);
        buffer
    }

    /// The size in pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// How surely what is told to be hidden is so.
    pub fn mode(&self) -> RasterMode {
        self.mode
    }

    /// Takes a size, brought within 8 to 8192 along each side, and a mode, and forgets what was drawn.
    pub fn begin(&mut self, size: UVec2, mode: RasterMode) {
        self.mode = mode;
        let size = size.clamp(UVec2::splat(Self::SIDES.0), UVec2::splat(Self::SIDES.1));
        if size == self.size {
            self.clear();
            return;
        }
        self.size = size;
        let tiles = self.tiles_across() * self.size.y.div_ceil(TILE_HEIGHT);
        self.tiles.clear();
        self.tiles.resize(tiles as usize, Tile::EMPTY);
        self.scratch.object.clear();
    }

    /// Forgets what was drawn: nothing is hidden.
    pub fn clear(&mut self) {
        self.tiles.fill(Tile::EMPTY);
    }

    /// What is known of a pixel, counted from the upper left: that something at this depth or nearer covers it, or `None`
    /// if nothing is known to, or the pixel is outside.
    pub fn depth(&self, x: u32, y: u32) -> Option<f32> {
        if x >= self.size.x || y >= self.size.y {
            return None;
        }
        let tile = y / TILE_HEIGHT * self.tiles_across() + x / TILE_WIDTH;
        let depth = self.tiles[tile as usize].depth_at(x % TILE_WIDTH, y % TILE_HEIGHT);
        (depth > NOTHING).then_some(depth)
    }

    /// The bytes that are kept.
    pub fn memory(&self) -> usize {
        fn of<T>(list: &Vec<T>) -> usize {
            list.capacity() * size_of::<T>()
        }
        let scratch = &self.scratch;
        size_of_val(self)
            + of(&self.tiles)
            + of(&scratch.on_screen)
            + of(&scratch.vertices)
            + of(&scratch.is_drawn)
            + of(&scratch.object)
            + of(&scratch.touched)
            + scratch.touched.iter().map(of).sum::<usize>()
    }

    pub(super) fn tiles_across(&self) -> u32 {
        self.size.x.div_ceil(TILE_WIDTH)
    }

    /// All of it, to draw to by so many bands, with vertices and what has been found out about triangles.
    pub(super) fn begin_drawing(&mut self, bands: usize) -> Begun<'_> {
        let tiles_across = self.tiles_across();
        let Scratch {
            on_screen,
            vertices,
            is_drawn,
            object,
            touched: lists,
        } = &mut self.scratch;
        if self.mode == RasterMode::Strict {
            object.resize(self.tiles.len(), ObjectTile::EMPTY);
        }
        let bands = bands.max(1);
        lists.resize_with(lists.len().max(bands), Vec::new);
        let (touched, lists) = lists.split_at_mut(1);
        Begun {
            canvas: Canvas {
                size: self.size,
                band: Band {
                    tile_rows: 0..self.size.y.div_ceil(TILE_HEIGHT),
                    tiles_across,
                },
                tiles: &mut self.tiles,
                object,
                touched: &mut touched[0],
            },
            touched: lists,
            on_screen,
            vertices,
            is_drawn,
        }
    }
}
