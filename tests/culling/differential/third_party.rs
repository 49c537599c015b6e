//! A plugin that is neither Bevy's nor ours, and makes entities visible too.

use bevy::{
    camera::visibility::{NoCpuCulling, SetViewVisibility, VisibilitySystems},
    prelude::*,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::cast::{Cast, Change, Role, Way};

/// Those that it makes visible.
#[derive(Resource, Default)]
struct Spotted(Vec<Entity>);

pub fn spot(app: &mut App) {
    let make_visible = |spotted: Res<Spotted>, mut things: Query<&mut ViewVisibility, Without<NoCpuCulling>>| {
        let mut things = things.iter_many_mut(&spotted.0);
        while let Some(mut visibility) = things.fetch_next() {
            visibility.set_visible();
        }
    };
    app.init_resource::<Spotted>()
        .add_systems(PostUpdate, make_visible.in_set(VisibilitySystems::CheckVisibility));
}

pub const WAYS: &[Way] = &[(2, spot_one), (2, lose_sight_of_one)];

fn spot_one(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let role = if rng.random_bool(0.9) { Role::Thing } else { Role::Light };
    let thing = cast.any(role, rng)?;
    Some(Change::new(format!("{thing} is spotted"), move |world| {
        world.resource_mut::<Spotted>().0.push(thing);
    }))
}

fn lose_sight_of_one(rng: &mut ChaCha8Rng, _: &Cast) -> Option<Change> {
    let number = rng.random_range(0..1000);
    Some(Change::new("one is no longer spotted".to_owned(), move |world| {
        let spotted = &mut world.resource_mut::<Spotted>().0;
        if !spotted.is_empty() {
            spotted.swap_remove(number % spotted.len());
        }
    }))
}
