//! What a camera shows: how many groups at which level, and how many triangles that takes.

use bevy::{
    camera::primitives::Frustum,
    ecs::{entity::EntityHashMap, system::SystemParam},
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::town::{Finest, House, Models, SmallThing};

/// What is in the frustum of a camera.
#[derive(Clone, Copy, Default)]
pub struct Tally {
    /// Houses by level; the last are those that the proxy of their block stands for.
    pub houses: [usize; 4],
    /// Trees and lamps by level; those at the last are not shown.
    pub small: [usize; 4],
    pub shown: usize,
    /// As many triangles would be shown of the same things at the finest level.
    pub full: usize,
}

impl Tally {
    /// Of the triangles, in percent.
    pub fn percent(&self) -> f64 {
        100.0 * self.shown as f64 / self.full.max(1) as f64
    }
}

/// How often views have switched levels.
#[derive(Resource, Default)]
pub struct Switches(EntityHashMap<usize>);

impl Switches {
    /// Those of a view since this was last asked.
    pub fn take(&mut self, view: Entity) -> usize {
        self.0.remove(&view).unwrap_or_default()
    }
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Switches>().add_observer(count_switch);
}

fn count_switch(swapped: On<LodSwapped>, mut switches: ResMut<Switches>) {
    *switches.0.entry(swapped.view).or_default() += 1;
}

/// Counts what cameras show.
#[derive(SystemParam)]
pub struct Counter<'w, 's> {
    choices: Res<'w, LodChoices>,
    models: Res<'w, Models>,
    views: Query<'w, 's, (&'static VisibleSet, &'static Frustum)>,
    meshes: Query<'w, 's, &'static Mesh3d>,
    houses: Query<'w, 's, (Entity, &'static GlobalTransform, &'static Finest, &'static ChildOf), With<House>>,
    small: Query<'w, 's, (Entity, &'static GlobalTransform, &'static Finest), With<SmallThing>>,
}

impl Counter<'_, '_> {
    pub fn count(&self, view: Entity) -> Tally {
        let mut tally = Tally::default();
        let Ok((visible, frustum)) = self.views.get(view) else {
            return tally;
        };
        let is_in = |place: &GlobalTransform, finest: &Finest| {
            frustum.intersects_obb(&finest.bounds, &place.affine(), true, false)
        };
        tally.shown = (self.meshes.iter_many(visible.entities()))
            .map(|mesh| self.models.triangles(mesh))
            .sum();
        for (house, place, finest, block) in &self.houses {
            if is_in(place, finest) {
                tally.full += finest.triangles;
                tally.houses[self.level_of_house(house, block.parent(), view)] += 1;
            }
        }
        for (thing, place, finest) in &self.small {
            if is_in(place, finest) {
                tally.full += finest.triangles;
                let level = self.choices.level(thing, view).unwrap_or_default();
                // Lamps have one level less than trees, and what is in a garden goes with its block.
                let is_shown = visible.contains(thing);
                tally.small[if is_shown { level.min(2) } else { 3 }] += 1;
            }
        }
        tally
    }

    /// How many houses two cameras show at different levels.
    pub fn differences(&self, views: [Entity; 2]) -> usize {
        let differs = |house: Entity, block: Entity| {
            let [one, other] = views.map(|view| self.level_of_house(house, block, view));
            one != other
        };
        let houses = self.houses.iter();
        houses
            .filter(|(house, _, _, block)| differs(*house, block.parent()))
            .count()
    }

    fn level_of_house(&self, house: Entity, block: Entity, view: Entity) -> usize {
        if self.choices.level(block, view) == Some(1) {
            return 3;
        }
        self.choices.level(house, view).unwrap_or_default()
    }
}
