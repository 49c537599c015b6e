//! What a camera sees, in double precision: where things are on the screen, and which of them may be in a region.

use bevy::{
    camera::Camera,
    math::{Affine3A, DAffine3, DMat4, DVec2, DVec3, DVec4, bounding::Aabb3d},
    transform::components::GlobalTransform,
};

use super::outline::{Outline, ScreenRect};
use crate::{
    geometry::tolerance::{DOUBLE, SCREEN_CONTACT},
    spatial::traverse::Part,
};

/// A camera, and the part of a region that is on its screen.
///
/// Points on the screen are homogeneous: logical pixels and depth, times w. The view is where `0 <= z <= w`, as Bevy's
/// renderer has it, with the near plane at the upper end.
pub(super) struct View<'a> {
    pub outline: &'a Outline,
    /// The box of the outline, as far as it is in the viewport.
    pub rect: ScreenRect,
    /// A point of the screen is in the view and in the [`rect`](Self::rect), or touches that, if its product with none of
    /// these is negative: the near and the far plane come first.
    pub planes: [DVec4; 6],
    pub screen_from_view: DMat4,
    pub view_from_screen: DMat4,
    pub view_from_world: DAffine3,
}

/// The near and the far plane.
const DEPTHS: [DVec4; 2] = [DVec4::new(0.0, 0.0, -1.0, 1.0), DVec4::new(0.0, 0.0, 1.0, 0.0)];

impl<'a> View<'a> {
    /// `None` if no part of the region is on the screen, or the camera has no screen or a projection or transform without
    /// an inverse.
    pub fn new(camera: &Camera, transform: &GlobalTransform, outline: &'a Outline) -> Option<Self> {
        let viewport = camera.logical_viewport_rect()?;
        let (min, max) = (viewport.min.as_dvec2(), viewport.max.as_dvec2());
        let half_size = (max - min) / 2.0;
        let center = min.midpoint(max);
        let screen_from_clip = DMat4::from_cols(
            DVec4::X * half_size.x,
            DVec4::NEG_Y * half_size.y,
            DVec4::Z,
            DVec4::new(center.x, center.y, 0.0, 1.0),
        );
        let screen_from_view = screen_from_clip * camera.clip_from_view().as_dmat4();
        let view_from_screen = screen_from_view.inverse();
        let view_from_world = transform.affine().as_daffine3().inverse();
        let is_sound = screen_from_view.is_finite() && view_from_screen.is_finite() && view_from_world.is_finite();

        let rect = outline.bounds().intersection(&ScreenRect { min, max });
        let ScreenRect { min, max } = rect.grown(SCREEN_CONTACT);
        let [near, far] = DEPTHS;
        let planes = [
            near,
            far,
            DVec4::new(1.0, 0.0, 0.0, -min.x),
            DVec4::new(-1.0, 0.0, 0.0, max.x),
            DVec4::new(0.0, 1.0, 0.0, -min.y),
            DVec4::new(0.0, -1.0, 0.0, max.y),
        ];
        (is_sound && !rect.is_empty()).then_some(Self {
            outline,
            rect,
            planes,
            screen_from_view,
            view_from_screen,
            view_from_world,
        })
    }

    /// The view of the world.
    pub fn of_world(&self) -> PlacedView<'_> {
        self.of(&Affine3A::IDENTITY)
    }

    /// The view of what is placed in the world by `world_from_local`.
    pub fn of(&self, world_from_local: &Affine3A) -> PlacedView<'_> {
        let world_from_local = world_from_local.as_daffine3();
        let (view_from_world, world) = (DMat4::from(self.view_from_world), DMat4::from(world_from_local));
        let screen_from_local = self.screen_from_view * view_from_world * world;
        let magnitude = self.screen_from_view.abs() * view_from_world.abs() * world.abs();
        PlacedView {
            view: self,
            screen_from_local,
            view_from_local: self.view_from_world * world_from_local,
            planes: self.planes.map(|plane| LocalPlane {
                plane: screen_from_local.transpose() * plane,
                magnitude: magnitude.transpose() * plane.abs(),
            }),
        }
    }

    /// The point of the view at a place and a depth on the screen.
    pub fn unproject(&self, place: DVec2, depth: f64) -> DVec3 {
        let point = self.view_from_screen * place.extend(depth).extend(1.0);
        point.truncate() / point.w
    }
}

/// Where something that is placed in the world is on the screen.
pub(super) struct PlacedView<'a> {
    pub view: &'a View<'a>,
    pub view_from_local: DAffine3,
    screen_from_local: DMat4,
    planes: [LocalPlane; 6],
}

/// A plane of the view in some space.
struct LocalPlane {
    /// Negative in product with points that are outside.
    plane: DVec4,
    /// What was added up to get there.
    magnitude: DVec4,
}

impl PlacedView<'_> {
    /// Where a point is on the screen.
    pub fn project(&self, point: DVec3) -> DVec4 {
        self.screen_from_local * point.extend(1.0)
    }

    /// How much of a box is in the region.
    pub fn part_of(&self, aabb: &Aabb3d) -> Part {
        let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
        let (center, half_size) = (min.midpoint(max), (max - min) / 2.0);
        let farthest = min.abs().max(max.abs()).extend(1.0);
        let mut is_inside = [false; 6];
        for (is_inside, LocalPlane { plane, magnitude }) in is_inside.iter_mut().zip(&self.planes) {
            let middle = plane.dot(center.extend(1.0));
            let reach = plane.truncate().abs().dot(half_size);
            let rounding = DOUBLE * magnitude.dot(farthest);
            if middle + reach < -rounding {
                return Part::None;
            }
            *is_inside = middle - reach > rounding;
        }
        let is_within_rect = is_inside == [true; 6];
        let View { outline, rect, .. } = self.view;
        if outline.is_rect() {
            return if is_within_rect { Part::All } else { Part::Some };
        }
        let [before_near, before_far, ..] = is_inside;
        if !(before_near && before_far) {
            return Part::Some;
        }
        let image = self.image_of(aabb).intersection(rect);
        if image.is_empty() {
            Part::None
        } else if outline.enters(&image) {
            Part::Some
        } else if !outline.is_inside(image.center()) {
            Part::None
        } else if is_within_rect {
            Part::All
        } else {
            Part::Some
        }
    }

    /// A rectangle around the image of a box that is in front of the camera.
    fn image_of(&self, aabb: &Aabb3d) -> ScreenRect {
        let corners = corners(aabb.min.as_dvec3(), aabb.max.as_dvec3());
        let places = corners.map(|corner| place(self.project(corner)));
        ScreenRect::around(places).grown(SCREEN_CONTACT)
    }
}

/// The place on the screen of a homogeneous point.
pub(super) fn place(point: DVec4) -> DVec2 {
    point.truncate().truncate() / point.w
}

/// The corners of a box.
pub(super) fn corners(min: DVec3, max: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let at = |axis: usize| if corner >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(at(0), at(1), at(2))
    })
}
