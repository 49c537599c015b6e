//! Materials, and whatever else, that are swapped with meshes.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::common::{add_mesh, headless_app_with};

/// What stands for a material here.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
struct Paint(u8);

/// A rock of three levels, the second from 10 metres on and the third from 20, and a camera at z.
fn scene(paints: &[u8], z: f32) -> (App, Entity, Entity) {
    let mut app = headless_app_with(|app| {
        app.add_plugins(LevelVariantsPlugin::<Paint>::default());
    });
    let meshes = [1.0, 0.9, 0.8].map(|size| add_mesh(&mut app, Cuboid::from_length(size)));
    let [fine, mid, far] = meshes;
    let lod = ProxyLod::new(LodMetric::Distance, fine).then(10.0, mid).then(20.0, far);
    let variants = LevelVariants(paints.iter().map(|&paint| Paint(paint)).collect());
    let rock = app.world_mut().spawn((lod, variants, Transform::default())).id();
    let place = Transform::from_xyz(0.0, 0.0, z);
    let camera = app.world_mut().spawn((Camera3d::default(), place)).id();
    app.update();
    (app, rock, camera)
}

fn paint(app: &App, rock: Entity) -> Option<Paint> {
    app.world().get(rock).copied()
}

#[test]
fn an_entity_begins_with_the_variant_of_the_level_that_it_shows() {
    for (z, expected) in [(5.0, 0), (15.0, 1), (50.0, 2)] {
        let (app, rock, _) = scene(&[0, 1, 2], z);
        assert_eq!(paint(&app, rock), Some(Paint(expected)), "at {z}");
    }
}

#[test]
fn a_variant_is_swapped_with_its_mesh() {
    let (mut app, rock, camera) = scene(&[0, 1, 2], 5.0);
    for (z, expected) in [(50.0, 2), (15.0, 1), (5.0, 0)] {
        app.world_mut()
            .get_mut::<Transform>(camera)
            .expect("a camera")
            .translation
            .z = z;
        app.update();
        assert_eq!(paint(&app, rock), Some(Paint(expected)), "at {z}");
    }
}

#[test]
fn levels_without_a_variant_have_the_last() {
    let (app, rock, _) = scene(&[7, 8], 50.0);
    assert_eq!(paint(&app, rock), Some(Paint(8)));
    let (app, rock, _) = scene(&[], 50.0);
    assert_eq!(paint(&app, rock), None);
}
