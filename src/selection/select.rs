//! The query.

use std::{cell::Cell, ops::ControlFlow};

use bevy::{camera::Camera, ecs::entity::Entity, transform::components::GlobalTransform};

use super::{
    ScreenRegion, SelectionMode, SelectionPrecision, SelectionSettings,
    view::{PlacedView, View},
};
use crate::{
    geometry::{support::Support, surface::Surface},
    index::{Candidate, CandidateSurface, CandidateTriangles, SceneQuery, SceneQuerySettings},
    spatial::traverse::{Descent, Part},
};

/// Marquee and lasso: see [`crate::selection`].
impl SceneQuery<'_, '_> {
    /// All entities in a region of the screen, or touching it, as a camera sees them, in ascending order, written over
    /// `entities`: see [`crate::selection`].
    ///
    /// Those that the camera does not draw, by its render layers or because they are hidden, are found as `settings` says.
    /// `max_distance` and `backfaces` do not matter. Nothing is found by a camera that has no size yet, or whose projection
    /// or transform is NaN, infinite or flat.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::prelude::*;
    /// fn lasso(scene: SceneQuery, view: Single<(&Camera, &GlobalTransform)>, drawn: Local<Vec<Vec2>>) {
    ///     let Ok(lasso) = ScreenRegion::polygon(&drawn) else { return };
    ///     let wholly = SelectionSettings::default().with_mode(SelectionMode::Enclosed);
    ///     let mut found = Vec::new();
    ///     scene.select_on_screen(view.0, view.1, &lasso, &wholly, &SceneQuerySettings::default(), &mut found);
    /// }
    /// ```
    pub fn select_on_screen(
        &self,
        camera: &Camera,
        camera_transform: &GlobalTransform,
        region: &ScreenRegion,
        selection: &SelectionSettings,
        settings: &SceneQuerySettings,
        entities: &mut Vec<Entity>,
    ) {
        entities.clear();
        let outline = region.outline();
        let Some(view) = outline.and_then(|outline| View::new(camera, camera_transform, outline)) else {
            return;
        };
        let of_world = view.of_world();
        let is_selected = |candidate: &Candidate| {
            let surface = match selection.precision {
                SelectionPrecision::Mesh => candidate.surface(),
                SelectionPrecision::Bounds => None,
            };
            match surface {
                Some((CandidateSurface::Triangles(triangles), place)) => {
                    view.of(&place).selects_triangles(&triangles, selection.mode)
                }
                Some((CandidateSurface::Shape(shape), place)) => view.of(&place).selects_shape(shape, selection.mode),
                None => (candidate.aabb()).is_some_and(|aabb| of_world.selects_hull(&aabb, selection.mode)),
            }
        };
        self.select(settings, |aabb| of_world.part_of(aabb), is_selected, entities);
    }
}

impl PlacedView<'_> {
    fn selects_triangles(&self, triangles: &CandidateTriangles, mode: SelectionMode) -> bool {
        // One part that is wholly inside is enough, or one that is not is too much.
        let (decisive, selects) = match mode {
            SelectionMode::Touching => (Part::All, true),
            SelectionMode::Enclosed => (Part::None, false),
        };
        let is_decided = Cell::new(false);
        let stop_if = |decides: bool| {
            is_decided.set(decides);
            if decides { Descent::Stop } else { Descent::Skip }
        };
        triangles.descend(
            |aabb| match self.part_of(aabb) {
                Part::Some => Descent::Enter,
                part => stop_if(part == decisive),
            },
            |corners| {
                stop_if(match mode {
                    SelectionMode::Touching => self.triangle_touches(corners),
                    SelectionMode::Enclosed => !self.triangle_is_enclosed(corners),
                })
            },
        );
        is_decided.get() == selects
    }

    fn selects_shape(&self, shape: &dyn Surface, mode: SelectionMode) -> bool {
        // The same of the hulls.
        let decisive = mode == SelectionMode::Touching;
        let decided = shape.visit_hulls(&mut |hull| {
            if self.selects_hull(hull, mode) == decisive {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        decided.is_break() == decisive
    }

    fn selects_hull(&self, hull: &dyn Support, mode: SelectionMode) -> bool {
        match mode {
            SelectionMode::Touching => self.hull_touches(hull),
            SelectionMode::Enclosed => self.hull_is_enclosed(hull),
        }
    }
}
