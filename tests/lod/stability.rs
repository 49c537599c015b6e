//! Levels that stay: hysteresis, minimum dwell, and each switch once.

use std::time::Duration;

use bevy::time::TimeUpdateStrategy;

use super::*;

/// The levels along a way.
fn walk(app: &mut App, camera: Entity, statue: &Statue, way: impl IntoIterator<Item = f32>) -> Vec<usize> {
    let levels = way.into_iter().map(|distance| look_from(app, camera, distance, statue));
    levels.collect()
}

fn switches(levels: &[usize]) -> usize {
    levels.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

#[test]
fn a_coarser_level_comes_a_tenth_beyond_its_threshold_and_a_finer_one_at_it() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    let levels = walk(&mut app, camera, &statue, [9.9, 10.1, 10.99, 11.01, 10.01, 9.99, 10.5]);
    assert_eq!(levels, [0, 0, 0, 1, 1, 0, 0]);
}

#[test]
fn the_first_choice_is_made_as_if_the_finest_had_been_shown() {
    for (distance, level) in [(10.5, 0), (11.5, 1), (21.0, 1), (22.5, 2)] {
        let mut app = app();
        let (camera, statue) = (spawn_camera(&mut app, distance), spawn_statue_by_distance(&mut app));
        assert_eq!(look(&mut app, camera, &statue), level);
    }
}

#[test]
fn hysteresis_is_relative_to_the_distance_and_can_be_set() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).hysteresis = 0.5;
    assert_eq!(
        walk(&mut app, camera, &statue, [14.9, 15.1, 29.9, 30.1, 20.1]),
        [0, 1, 1, 2, 2]
    );
    settings(&mut app).hysteresis = 0.0;
    assert_eq!(
        walk(&mut app, camera, &statue, [19.9, 20.1, 19.9, 9.9, 10.1]),
        [1, 2, 1, 0, 1]
    );
}

#[test]
fn a_way_across_a_threshold_switches_once() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    for step in [0.013, 0.37, 2.9] {
        let steps = (14.0 / step) as u32;
        let away = (0..steps).map(|i| 5.0 + step * i as f32);
        let levels = walk(&mut app, camera, &statue, away.clone());
        assert_eq!((switches(&levels), levels.last()), (1, Some(&1)));
        let levels = walk(&mut app, camera, &statue, away.rev());
        assert_eq!((switches(&levels), levels.last()), (1, Some(&0)));
    }
}

#[test]
fn to_tremble_on_a_threshold_switches_nothing() {
    for metric in [LodMetric::Distance, LodMetric::Height, LodMetric::ONE_PIXEL] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        // Each takes over at 10 m.
        let threshold = match metric {
            LodMetric::Distance => 10.0,
            LodMetric::Height => 3f32.sqrt() * 1.2071068 / 10.0,
            LodMetric::PixelError(_) => 10.0 / 1.2071068 / 1080.0,
        };
        let statue = spawn_statue(&mut app, 2, |levels| lod(metric, levels, &[threshold]));
        for (start, about) in [(5.0, 10.0), (5.0, 11.0), (15.0, 11.0), (15.0, 10.45)] {
            let first = walk(&mut app, camera, &statue, [start])[0];
            let amplitude = if about == 10.0 { 0.9 } else { 0.4 };
            let side = if start < about && about == 11.0 {
                -amplitude - 0.01
            } else {
                0.0
            };
            let tremble = (0..40).map(|i| about + side + amplitude * (1.7 * i as f32).sin());
            let levels = walk(&mut app, camera, &statue, tremble);
            assert_eq!(levels, vec![first; 40], "{metric:?} from {start} m at {about} m");
        }
    }
}

#[test]
fn a_leap_over_several_levels_is_one_switch() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    assert_eq!(walk(&mut app, camera, &statue, [1.0, 500.0, 1.0, 500.0]), [0, 2, 0, 2]);
}

#[test]
fn a_level_stays_for_its_time() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).min_dwell = Duration::from_millis(350);
    // It is shown first in a frame, and then in three more.
    assert_eq!(
        walk(&mut app, camera, &statue, [5.0, 50.0, 50.0, 50.0, 50.0]),
        [0, 0, 0, 0, 2]
    );
    assert_eq!(
        walk(&mut app, camera, &statue, [15.0, 5.0, 15.0, 15.0, 15.0]),
        [2, 2, 2, 1, 1]
    );
}

#[test]
fn what_was_wanted_for_a_while_is_forgotten() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).min_dwell = Duration::from_millis(250);
    let levels = walk(&mut app, camera, &statue, [5.0, 50.0, 50.0, 5.0, 5.0, 5.0, 50.0]);
    assert_eq!(levels, [0, 0, 0, 0, 0, 0, 2]);
}

#[test]
fn a_shorter_time_counts_at_once() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).min_dwell = Duration::from_secs(3600);
    assert_eq!(walk(&mut app, camera, &statue, [5.0, 50.0]), [0, 0]);
    settings(&mut app).min_dwell = Duration::ZERO;
    assert_eq!(walk(&mut app, camera, &statue, [50.0]), [2]);
}

#[test]
fn a_level_that_is_no_more_does_not_stay_for_its_time() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
    let (camera, statue) = (spawn_camera(&mut app, 50.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).min_dwell = Duration::from_secs(3600);
    assert_eq!(look(&mut app, camera, &statue), 2);
    app.world_mut().get_mut::<ProxyLod>(statue.root).unwrap().levels.pop();
    despawn(&mut app, statue.levels[2]);
    let rest = Statue {
        root: statue.root,
        levels: statue.levels[..2].into(),
    };
    assert_eq!(look(&mut app, camera, &rest), 1);
}

#[test]
fn an_entity_that_is_no_more_is_replaced_while_its_level_stays() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
    let (camera, statue) = (spawn_camera(&mut app, 50.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).min_dwell = Duration::from_secs(3600);
    assert_eq!(look(&mut app, camera, &statue), 2);
    despawn(&mut app, statue.levels[2]);
    insert(&mut app, camera, at_distance(15.0));
    app.update();
    assert_eq!(listed(&app, camera).len(), 1);
}
