//! Where a sprite lies, and which point of its image is where, as Bevy draws it.

use bevy::{
    image::TextureAtlasLayout,
    math::{BVec2, DVec2, Rect, URect, Vec2},
    sprite::{Anchor, SliceScaleMode, Sprite, SpriteImageMode, SpriteScalingMode, TextureSlicer},
};

/// The least stretch of a tile, as in Bevy.
const LEAST_STRETCH: f32 = 0.001;

/// Where a sprite lies in its local space, in the plane z = 0, and which point of its image is where.
#[derive(Debug, PartialEq)]
pub(super) struct SpriteLayout {
    pub rect: Rect,
    flip: BVec2,
    cells: Cells,
    image_size: Vec2,
}

/// The parts that a sprite is cut into, each of which is filled by itself.
#[derive(Debug, PartialEq)]
enum Cells {
    One(Cell),
    /// In rows, from the top left corner.
    Nine(Box<[Cell; 9]>),
}

/// A part of a sprite, and the part of the image that fills it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    /// From the top left corner of the sprite, with y down, in units of the local space.
    area: Rect,
    /// In pixels from the top left corner of the image.
    source: Rect,
    /// The size of one copy of the source, which is repeated to the right and down where it does not fill the area.
    tile: Vec2,
}

impl SpriteLayout {
    /// The layout of a sprite, or `None` if it has no size: none yet, if that depends on an image that is not there.
    pub fn new(
        sprite: &Sprite,
        anchor: &Anchor,
        image_size: Option<Vec2>,
        atlas: Option<&TextureAtlasLayout>,
    ) -> Option<Self> {
        let atlas_rect = atlas
            .zip(sprite.texture_atlas.as_ref())
            .and_then(|(layout, atlas)| layout.textures.get(atlas.index))
            .map(URect::as_rect);
        let known_size = image_size.or(atlas.map(|atlas| atlas.size.as_vec2()));
        let flip = BVec2::new(sprite.flip_x, sprite.flip_y);

        let (rect, cells) = (sprite.image_mode.uses_slices())
            .then(|| sliced(sprite, anchor, image_size, atlas, atlas_rect))
            .flatten()
            .or_else(|| whole(sprite, anchor, image_size, atlas_rect, flip))?;
        let image_size = known_size.unwrap_or(cells.source_end());
        let is_sound = rect.min.is_finite() && rect.max.is_finite() && rect.size().cmpgt(Vec2::ZERO).all();
        is_sound.then_some(Self {
            rect,
            flip,
            cells,
            image_size,
        })
    }

    /// The point of the image that is at a point of the sprite, in pixels from the top left corner.
    pub fn pixel_at(&self, point: DVec2) -> DVec2 {
        let (min, max) = (self.rect.min.as_dvec2(), self.rect.max.as_dvec2());
        let from_left = if self.flip.x { max.x - point.x } else { point.x - min.x };
        let from_top = if self.flip.y { point.y - min.y } else { max.y - point.y };
        self.cells.pixel_at(DVec2::new(from_left, from_top))
    }

    /// The texture coordinates of a point of the image.
    pub fn uv(&self, pixel: DVec2) -> Vec2 {
        (pixel / self.image_size.as_dvec2()).as_vec2()
    }
}

impl Cells {
    fn pixel_at(&self, point: DVec2) -> DVec2 {
        match self {
            Self::One(cell) => cell.pixel_at(point),
            Self::Nine(cells) => {
                // The last that begins before the point and is not empty, as where there is no border.
                let begins = |cell: &&Cell| {
                    let is_before = cell.area.min.as_dvec2().cmple(point.max(DVec2::ZERO)).all();
                    is_before && cell.area.size().cmpgt(Vec2::ZERO).all()
                };
                cells.iter().rfind(begins).unwrap_or(&cells[4]).pixel_at(point)
            }
        }
    }

    /// The lower right corner of what is used of the image.
    fn source_end(&self) -> Vec2 {
        match self {
            Self::One(cell) => cell.source.max,
            Self::Nine(cells) => cells[8].source.max,
        }
    }
}

impl Cell {
    fn pixel_at(&self, point: DVec2) -> DVec2 {
        let size = (self.area.size() / self.tile).as_dvec2();
        let tiles = (point - self.area.min.as_dvec2()) / self.tile.as_dvec2();
        // The far edge of the last copy is not the near edge of one more.
        let before = tiles.floor().min(size.ceil() - 1.0).max(DVec2::ZERO);
        self.source.min.as_dvec2() + self.source.size().as_dvec2() * (tiles - before)
    }

    fn stretched(area: Rect, source: Rect) -> Self {
        let tile = area.size();
        Self { area, source, tile }
    }

    /// As Bevy has it: copies are `stretch` times as large as their source, and neither larger than the area nor smaller
    /// than a pixel.
    fn tiled(area: Rect, source: Rect, stretch: f32, along: BVec2) -> Self {
        let copy = (source.size() * stretch.max(LEAST_STRETCH)).max(Vec2::ONE);
        let tile = Vec2::select(along, copy, area.size()).min(area.size());
        Self { area, source, tile }
    }
}

/// The layout of a sprite whose image covers it once.
fn whole(
    sprite: &Sprite,
    anchor: &Anchor,
    image_size: Option<Vec2>,
    atlas_rect: Option<Rect>,
    flip: BVec2,
) -> Option<(Rect, Cells)> {
    let mut source = match (atlas_rect, sprite.rect) {
        (Some(atlas), Some(rect)) => Some(Rect {
            min: rect.min + atlas.min,
            max: rect.max + atlas.min,
        }),
        (atlas, rect) => atlas.or(rect),
    }
    .or(image_size.map(|size| Rect::from_corners(Vec2::ZERO, size)))
    // Of an image that is not there nothing matters but where it will be.
    .or(sprite.custom_size.map(|_| Rect::from_corners(Vec2::ZERO, Vec2::ONE)))?;
    let asked = sprite.custom_size.unwrap_or(source.size());
    let (mut size, mut moved) = (asked, Vec2::ZERO);
    if let SpriteImageMode::Scale(mode) = sprite.image_mode {
        let ratio = asked / source.size();
        match mode {
            SpriteScalingMode::FitCenter | SpriteScalingMode::FitStart | SpriteScalingMode::FitEnd => {
                size = source.size() * ratio.min_element();
                let rest = (asked - size) * Vec2::new(1.0, -1.0);
                moved = match mode {
                    SpriteScalingMode::FitStart => rest,
                    SpriteScalingMode::FitEnd => -rest,
                    _ => Vec2::ZERO,
                };
            }
            SpriteScalingMode::FillCenter | SpriteScalingMode::FillStart | SpriteScalingMode::FillEnd => {
                let shown = ratio / ratio.max_element();
                let before = match mode {
                    SpriteScalingMode::FillStart => Vec2::ZERO,
                    SpriteScalingMode::FillEnd => Vec2::ONE - shown,
                    _ => (Vec2::ONE - shown) / 2.0,
                };
                // The window stays where it is when the image in it is mirrored.
                let before = Vec2::select(flip, Vec2::ONE - shown - before, before);
                let window = source.min + source.size() * before;
                source = Rect::from_corners(window, window + source.size() * shown);
            }
        }
    }
    let min = (size + moved) * (-anchor.as_vec() - 0.5);
    let area = Rect::from_corners(Vec2::ZERO, size);
    Some((Rect { min, max: min + size }, Cells::One(Cell::stretched(area, source))))
}

/// The layout of a sprite in slices or tiles; `None` where Bevy has none.
fn sliced(
    sprite: &Sprite,
    anchor: &Anchor,
    image_size: Option<Vec2>,
    atlas: Option<&TextureAtlasLayout>,
    atlas_rect: Option<Rect>,
) -> Option<(Rect, Cells)> {
    let (image_size, source) = if sprite.texture_atlas.is_some() {
        (atlas?.size.as_vec2(), atlas_rect?)
    } else {
        let size = image_size?;
        (size, sprite.rect.unwrap_or(Rect::from_corners(Vec2::ZERO, size)))
    };
    let (size, cells) = match &sprite.image_mode {
        SpriteImageMode::Sliced(slicer) => {
            let size = sprite.custom_size.unwrap_or(source.size());
            (size, nine_slices(slicer, source, size))
        }
        &SpriteImageMode::Tiled {
            tile_x,
            tile_y,
            stretch_value,
        } => {
            let size = sprite.custom_size.unwrap_or(image_size);
            let area = Rect::from_corners(Vec2::ZERO, size);
            let cell = Cell::tiled(area, source, stretch_value, BVec2::new(tile_x, tile_y));
            (size, Cells::One(cell))
        }
        SpriteImageMode::Auto | SpriteImageMode::Scale(_) => return None,
    };
    // Bevy anchors slices by the size that the sprite was given, not by that which it has.
    let anchored = sprite.custom_size.or(sprite.rect.map(|rect| rect.size()));
    let center = -anchor.as_vec() * anchored.unwrap_or(Vec2::ZERO);
    let rect = Rect {
        min: center - size / 2.0,
        max: center + size / 2.0,
    };
    Some((rect, cells))
}

fn nine_slices(slicer: &TextureSlicer, source: Rect, size: Vec2) -> Cells {
    let border = slicer.border;
    let area = Rect::from_corners(Vec2::ZERO, size);
    if (border.min_inset + border.max_inset).cmpge(source.size()).any() {
        return Cells::One(Cell::stretched(area, source));
    }
    let scale = (size / source.size()).min_element().min(slicer.max_corner_scale);
    let cuts = |rect: Rect, scale: f32| {
        [
            rect.min,
            rect.min + border.min_inset * scale,
            rect.max - border.max_inset * scale,
            rect.max,
        ]
    };
    let (area, source) = (cuts(area, scale), cuts(source, 1.0));
    Cells::Nine(Box::new(std::array::from_fn(|cell| {
        let (row, column) = (cell / 3, cell % 3);
        let part = |cuts: [Vec2; 4]| Rect {
            min: Vec2::new(cuts[column].x, cuts[row].y),
            max: Vec2::new(cuts[column + 1].x, cuts[row + 1].y),
        };
        let (area, source) = (part(area), part(source));
        // A corner is repeated along neither axis, a side along its own.
        let along = BVec2::new(column == 1, row == 1);
        let mode = if along.all() {
            slicer.center_scale_mode
        } else {
            slicer.sides_scale_mode
        };
        match mode {
            SliceScaleMode::Tile { stretch_value } if along.any() => Cell::tiled(area, source, stretch_value, along),
            _ => Cell::stretched(area, source),
        }
    })))
}
