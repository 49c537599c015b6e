//! What belongs to a level: what it lists, and all that is below.

use super::*;

fn cube(app: &App, statue: &Statue) -> Mesh3d {
    app.world().get::<Mesh3d>(statue.levels[0]).expect("a mesh").clone()
}

/// A statue whose second level is shown, and a camera.
fn second_of_three(app: &mut App) -> (Entity, Statue) {
    let (camera, statue) = (spawn_camera(app, 15.0), spawn_statue_by_distance(app));
    assert_eq!(look(app, camera, &statue), 1);
    (camera, statue)
}

#[test]
fn what_is_below_a_listed_entity_belongs_to_its_level() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    let mesh = cube(&app, &statue);
    let mut parents = statue.levels.clone();
    for _ in 0..3 {
        for parent in &mut parents {
            *parent = spawn(&mut app, (mesh.clone(), ChildOf(*parent)));
        }
        app.update();
        let shown: Vec<bool> = parents.iter().map(|&child| sees(&app, camera, child)).collect();
        assert_eq!(shown, [false, true, false]);
    }
}

#[test]
fn what_is_below_the_root_alone_belongs_to_no_level() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    let mesh = cube(&app, &statue);
    let label = spawn(&mut app, (mesh, ChildOf(statue.root)));
    for distance in [5.0, 15.0, 50.0] {
        look_from(&mut app, camera, distance, &statue);
        assert!(sees(&app, camera, label));
        assert!(choices(&app).group_of(label).is_none());
    }
}

#[test]
fn what_is_hung_elsewhere_belongs_there_from_then_on() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    let mesh = cube(&app, &statue);
    let sword = spawn(&mut app, (mesh, ChildOf(statue.levels[1])));
    app.update();
    assert!(sees(&app, camera, sword));
    for (level, is_shown) in [(0, false), (1, true), (2, false)] {
        set_parent(&mut app, sword, statue.levels[level]);
        app.update();
        assert_eq!(sees(&app, camera, sword), is_shown);
    }
    remove::<ChildOf>(&mut app, sword);
    app.update();
    assert!(sees(&app, camera, sword));
    assert!(choices(&app).group_of(sword).is_none());
}

#[test]
fn a_listed_entity_belongs_to_its_level_wherever_it_hangs() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    remove::<ChildOf>(&mut app, statue.levels[1]);
    assert_eq!(look(&mut app, camera, &statue), 1);
    remove::<ChildOf>(&mut app, statue.levels[2]);
    assert_eq!(look(&mut app, camera, &statue), 1);
    // Below another level of its own group.
    set_parent(&mut app, statue.levels[1], statue.levels[0]);
    for (distance, level) in [(15.0, 1), (5.0, 0), (50.0, 2), (15.0, 1)] {
        assert_eq!(look_from(&mut app, camera, distance, &statue), level);
    }
}

#[test]
fn an_entity_may_be_listed_by_several_levels() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 3, |levels| {
        ProxyLod::new(LodMetric::Distance, vec![levels[0], levels[2]])
            .then(10.0, vec![levels[2]])
            .then(20.0, vec![levels[1], levels[2], levels[2]])
    });
    for (distance, expected) in [(5.0, vec![0, 2]), (15.0, vec![2]), (50.0, vec![1, 2])] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        let expected: Vec<Entity> = expected.into_iter().map(|i: usize| statue.levels[i]).collect();
        assert_eq!(listed(&app, camera), expected);
    }
}

#[test]
fn the_root_may_be_a_level_itself() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let root = spawn_cube(&mut app, Vec3::ZERO);
    let mesh = app.world().get::<Mesh3d>(root).unwrap().clone();
    let arm = spawn(&mut app, (mesh.clone(), ChildOf(root)));
    let coarse = spawn(&mut app, (mesh, ChildOf(root)));
    insert(&mut app, root, lod(LodMetric::Distance, &[root, coarse], &[10.0]));
    app.update();
    assert_eq!(listed(&app, camera), [root, arm]);
    insert(&mut app, camera, at_distance(15.0));
    app.update();
    assert_eq!(listed(&app, camera), [coarse]);
}

#[test]
fn in_the_place_of_what_is_despawned_the_finest_that_is_left_is_shown() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    despawn(&mut app, statue.levels[1]);
    app.update();
    assert_eq!(listed(&app, camera), [statue.levels[0]]);
    assert_eq!(choices(&app).level(statue.root, camera), Some(0));
    despawn(&mut app, statue.levels[0]);
    app.update();
    assert_eq!(listed(&app, camera), [statue.levels[2]]);
    insert(&mut app, camera, at_distance(2.0));
    app.update();
    assert_eq!(listed(&app, camera), [statue.levels[2]]);
    despawn(&mut app, statue.levels[2]);
    app.update();
    assert_eq!(listed(&app, camera), []);
}

#[test]
fn without_the_component_all_levels_are_entities_like_others() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    remove::<ProxyLod>(&mut app, statue.root);
    app.update();
    assert_eq!(listed(&app, camera), statue.levels);
    assert!(choices(&app).is_empty());
    for &level in &statue.levels {
        assert!(
            !app.world()
                .entity(level)
                .contains::<bevy_sightline::index::DetailLevel>()
        );
    }
    insert(&mut app, statue.root, by_distance(&statue.levels));
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn a_component_that_is_taken_and_given_in_one_frame_is_as_before() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    remove::<ProxyLod>(&mut app, statue.root);
    insert(&mut app, statue.root, by_distance(&statue.levels));
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn levels_that_outlive_their_root_are_entities_like_others() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    for &level in &statue.levels {
        remove::<ChildOf>(&mut app, level);
    }
    despawn(&mut app, statue.root);
    app.update();
    assert_eq!(listed(&app, camera), statue.levels);
}

#[test]
fn an_entity_with_the_number_of_one_that_is_gone_belongs_to_nothing() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    let mesh = cube(&app, &statue);
    let gone = statue.levels[0];
    despawn(&mut app, gone);
    let new: Vec<Entity> = (0..300).map(|_| spawn(&mut app, mesh.clone())).collect();
    app.update();
    assert!(new.iter().all(|&new| sees(&app, camera, new)));
}

#[test]
fn groups_come_and_go_with_their_numbers() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let mut statues: Vec<Statue> = Vec::new();
    for round in 0..12 {
        for _ in 0..3 {
            statues.push(spawn_statue_by_distance(&mut app));
        }
        if round % 2 == 1 {
            for statue in statues.drain(..4) {
                despawn(&mut app, statue.root);
            }
        }
        let distance = [15.0, 5.0, 50.0][round % 3];
        insert(&mut app, camera, at_distance(distance));
        app.update();
        let expected = [1, 0, 2][round % 3];
        assert!(statues.iter().all(|statue| shown(&app, camera, statue) == expected));
        assert_eq!(choices(&app).len(), statues.len());
    }
}

#[test]
fn levels_may_be_added_taken_and_exchanged() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    let [a, b, c] = [statue.levels[0], statue.levels[1], statue.levels[2]];
    insert(
        &mut app,
        statue.root,
        lod(LodMetric::Distance, &[c, a, b], &[10.0, 20.0]),
    );
    app.update();
    assert_eq!(listed(&app, camera), [a]);
    insert(&mut app, statue.root, lod(LodMetric::Distance, &[c, a], &[20.0]));
    app.update();
    assert_eq!(listed(&app, camera), [b, c], "the second is listed no more");
    insert(&mut app, statue.root, ProxyLod::new(LodMetric::Distance, a));
    app.update();
    assert_eq!(listed(&app, camera), [a, b, c]);
}

#[test]
fn who_is_hidden_stays_hidden() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    insert(&mut app, statue.levels[1], Visibility::Hidden);
    app.update();
    assert_eq!(listed(&app, camera), []);
    insert(&mut app, statue.levels[1], Visibility::Inherited);
    assert_eq!(look(&mut app, camera, &statue), 1);
    insert(&mut app, statue.root, Visibility::Hidden);
    app.update();
    assert_eq!(listed(&app, camera), []);
}

#[test]
fn what_is_disabled_is_of_its_level_when_it_is_back() {
    use bevy::ecs::entity_disabling::Disabled;
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    insert(&mut app, statue.levels[0], Disabled);
    app.update();
    // The group is read anew meanwhile.
    app.world_mut().get_mut::<ProxyLod>(statue.root).unwrap().set_changed();
    app.update();
    remove::<Disabled>(&mut app, statue.levels[0]);
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn a_group_that_begins_disabled_is_followed_when_it_is_enabled() {
    use bevy::ecs::entity_disabling::Disabled;
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    let all = [&[statue.root][..], &statue.levels].concat();
    for &entity in &all {
        insert(&mut app, entity, Disabled);
    }
    app.update();
    app.update();
    for &entity in &all {
        remove::<Disabled>(&mut app, entity);
        // Bevy looks at none of these while they are disabled, and later only if they have changed.
        insert(&mut app, entity, (Transform::default(), Visibility::Inherited));
    }
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn a_level_taken_from_an_inner_group_belongs_to_where_it_hangs() {
    let mut app = app();
    let (camera, outer) = second_of_three(&mut app);
    let mesh = cube(&app, &outer);
    let inner = spawn(
        &mut app,
        (Transform::default(), Visibility::default(), ChildOf(outer.levels[0])),
    );
    let parts: Vec<Entity> = (0..2)
        .map(|_| spawn(&mut app, (mesh.clone(), ChildOf(inner))))
        .collect();
    insert(&mut app, inner, lod(LodMetric::Distance, &parts, &[10.0]));
    assert_eq!(look_from(&mut app, camera, 5.0, &outer), 0);
    assert!(sees(&app, camera, parts[0]) && !sees(&app, camera, parts[1]));
    insert(&mut app, inner, lod(LodMetric::Distance, &parts[..1], &[]));
    app.update();
    assert!(sees(&app, camera, parts[0]) && sees(&app, camera, parts[1]));
    assert_eq!(look_from(&mut app, camera, 15.0, &outer), 1);
    assert!(!sees(&app, camera, parts[0]) && !sees(&app, camera, parts[1]));
}

#[test]
fn an_entity_in_two_groups_is_part_of_one_and_then_of_the_other() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let [shared, first, second] = [(); 3].map(|()| spawn_cube(&mut app, Vec3::ZERO));
    let groups = [first, second].map(|fine| {
        let root = spawn(&mut app, Transform::default());
        insert(&mut app, root, lod(LodMetric::Distance, &[fine, shared], &[10.0]));
        app.update();
        root
    });
    assert_eq!(choices(&app).group_of(shared).map(|(root, _)| root), Some(groups[0]));
    assert!(sees(&app, camera, shared) && !sees(&app, camera, first));
    // The other has nothing to show in its place.
    assert!(sees(&app, camera, second));
    despawn(&mut app, groups[0]);
    app.update();
    assert_eq!(choices(&app).group_of(shared).map(|(root, _)| root), Some(groups[1]));
    assert!(sees(&app, camera, shared) && sees(&app, camera, first) && !sees(&app, camera, second));
}

#[test]
fn what_is_hung_elsewhere_is_measured_where_it_is_though_all_move_at_once() {
    let mut app = app();
    let (camera, statue) = second_of_three(&mut app);
    let cart = spawn(&mut app, (Transform::default(), Visibility::default()));
    set_parent(&mut app, statue.levels[0], cart);
    assert_eq!(look(&mut app, camera, &statue), 1);
    // The root goes away, and the first level towards the camera.
    insert(&mut app, statue.root, Transform::from_xyz(0.0, 0.0, -100.0));
    insert(&mut app, cart, Transform::from_xyz(0.0, 0.0, 10.0));
    assert_eq!(look(&mut app, camera, &statue), 0);
}
