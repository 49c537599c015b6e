//! One for many: groups whose levels show other groups.

use super::*;

/// A block of statues: up to 40 m each by itself, beyond that one cube for all; and each by itself up to 10 m the first of
/// its three levels, up to 20 m the second.
struct Block {
    root: Entity,
    near: Entity,
    statues: Vec<Statue>,
    proxy: Entity,
}

fn spawn_block(app: &mut App, statues: usize) -> Block {
    let root = spawn(app, (Transform::default(), Visibility::default()));
    let near = spawn(app, (Transform::default(), Visibility::default(), ChildOf(root)));
    let statues: Vec<Statue> = (0..statues).map(|_| spawn_statue_by_distance(app)).collect();
    for statue in &statues {
        set_parent(app, statue.root, near);
    }
    let proxy = spawn_cube(app, Vec3::ZERO);
    set_parent(app, proxy, root);
    insert(app, root, lod(LodMetric::Distance, &[near, proxy], &[40.0]));
    Block {
        root,
        near,
        statues,
        proxy,
    }
}

/// The level of each statue, after a frame, or nothing if the proxy is shown in the place of all: exactly one of both.
#[track_caller]
fn look_at(app: &mut App, camera: Entity, distance: f32, block: &Block) -> Option<usize> {
    insert(app, camera, at_distance(distance));
    app.update();
    look_at_still(app, camera, block)
}

#[track_caller]
fn look_at_still(app: &App, camera: Entity, block: &Block) -> Option<usize> {
    if sees(app, camera, block.proxy) {
        assert_eq!(listed(app, camera), [block.proxy]);
        return None;
    }
    let levels: Vec<usize> = block.statues.iter().map(|statue| shown(app, camera, statue)).collect();
    assert!(levels.iter().all(|&level| level == levels[0]));
    Some(levels[0])
}

#[test]
fn a_proxy_stands_in_for_many_with_levels_of_their_own() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 5.0), spawn_block(&mut app, 5));
    let way = [
        (5.0, Some(0)),
        (15.0, Some(1)),
        (30.0, Some(2)),
        (50.0, None),
        (30.0, Some(2)),
        (500.0, None),
    ];
    for (distance, expected) in way {
        assert_eq!(
            look_at(&mut app, camera, distance, &block),
            expected,
            "from {distance} m"
        );
    }
    assert_eq!(look_at(&mut app, camera, 1.0, &block), Some(0));
}

#[test]
fn each_view_has_its_own_representation_of_the_block() {
    let mut app = app();
    let block = spawn_block(&mut app, 3);
    let cameras = [(5.0, Some(0)), (30.0, Some(2)), (50.0, None)]
        .map(|(distance, expected)| (spawn_camera(&mut app, distance), expected));
    app.update();
    for (camera, expected) in cameras {
        assert_eq!(look_at_still(&app, camera, &block), expected);
    }
}

#[test]
fn blocks_are_nested_to_any_depth() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let mesh = add_mesh(&mut app, Cuboid::default());
    let mut inner = spawn(&mut app, Mesh3d(mesh.clone()));
    let mut shapes = vec![inner];
    for depth in 0..12 {
        let root = spawn(&mut app, (Transform::default(), Visibility::default()));
        let proxy = spawn(&mut app, (Mesh3d(mesh.clone()), ChildOf(root)));
        set_parent(&mut app, inner, root);
        let begin = 10.0 * 1.5f32.powi(depth);
        insert(&mut app, root, lod(LodMetric::Distance, &[inner, proxy], &[begin]));
        shapes.push(proxy);
        inner = root;
    }
    settings(&mut app).hysteresis = 0.0;
    for depth in (0..=12).chain((0..12).rev()) {
        insert(&mut app, camera, at_distance(10.0 * 1.5f32.powi(depth - 1) + 0.01));
        app.update();
        assert_eq!(listed(&app, camera), [shapes[depth as usize]], "at depth {depth}");
    }
}

#[test]
fn the_roots_of_groups_may_be_listed_themselves() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 5.0), spawn_block(&mut app, 2));
    let roots: Vec<Entity> = block.statues.iter().map(|statue| statue.root).collect();
    insert(
        &mut app,
        block.root,
        ProxyLod::new(LodMetric::Distance, roots).then(40.0, block.proxy),
    );
    for (distance, expected) in [(5.0, Some(0)), (15.0, Some(1)), (50.0, None), (5.0, Some(0))] {
        assert_eq!(look_at(&mut app, camera, distance, &block), expected);
    }
}

#[test]
fn who_moves_out_of_a_block_is_shown_by_itself() {
    let mut app = app();
    let (camera, mut block) = (spawn_camera(&mut app, 50.0), spawn_block(&mut app, 2));
    assert_eq!(look_at(&mut app, camera, 50.0, &block), None);
    let leaver = block.statues.pop().unwrap();
    remove::<ChildOf>(&mut app, leaver.root);
    assert_eq!(look(&mut app, camera, &leaver), 2);
    assert!(sees(&app, camera, block.proxy));
    set_parent(&mut app, leaver.root, block.near);
    block.statues.push(leaver);
    assert_eq!(look_at(&mut app, camera, 50.0, &block), None);
    assert_eq!(look_at(&mut app, camera, 15.0, &block), Some(1));
}

#[test]
fn who_is_listed_no_more_is_shown_by_itself() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 50.0), spawn_block(&mut app, 1));
    assert_eq!(look_at(&mut app, camera, 50.0, &block), None);
    insert(&mut app, block.root, ProxyLod::new(LodMetric::Distance, block.proxy));
    assert_eq!(look(&mut app, camera, &block.statues[0]), 2);
    finish_meshes(&mut app);
    let finest = block.statues[0].levels[0];
    let is_hit = query(&mut app, move |scene| {
        let mut hits = Vec::new();
        let ray = Ray3d::new(Vec3::Z * 100.0, Dir3::NEG_Z);
        scene.cast_ray_all(ray, &SceneQuerySettings::default(), &mut hits);
        hits.iter().any(|hit| hit.entity == finest)
    });
    assert!(is_hit);
}

#[test]
fn without_the_outer_component_each_is_shown_by_itself() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 50.0), spawn_block(&mut app, 2));
    assert_eq!(look_at(&mut app, camera, 50.0, &block), None);
    remove::<ProxyLod>(&mut app, block.root);
    app.update();
    assert!(block.statues.iter().all(|statue| shown(&app, camera, statue) == 2));
    assert!(sees(&app, camera, block.proxy));
}

#[test]
fn without_the_inner_component_its_levels_are_of_the_block() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 50.0), spawn_block(&mut app, 1));
    app.update();
    let statue = &block.statues[0];
    remove::<ProxyLod>(&mut app, statue.root);
    app.update();
    assert_eq!(listed(&app, camera), [block.proxy]);
    insert(&mut app, camera, at_distance(30.0));
    app.update();
    assert_eq!(listed(&app, camera), statue.levels);
}

#[test]
fn a_group_may_begin_within_a_block() {
    let mut app = app();
    let (camera, mut block) = (spawn_camera(&mut app, 50.0), spawn_block(&mut app, 1));
    app.update();
    let late = spawn_statue_by_distance(&mut app);
    set_parent(&mut app, late.root, block.near);
    block.statues.push(late);
    assert_eq!(look_at(&mut app, camera, 50.0, &block), None);
    assert_eq!(look_at(&mut app, camera, 5.0, &block), Some(0));
}

#[test]
fn a_group_within_a_coarser_level_is_shown_with_it() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let inner = spawn_statue_by_distance(&mut app);
    let fine = spawn_cube(&mut app, Vec3::ZERO);
    let root = spawn(&mut app, (Transform::default(), Visibility::default()));
    insert(&mut app, root, lod(LodMetric::Distance, &[fine, inner.root], &[15.0]));
    app.update();
    assert_eq!(listed(&app, camera), [fine]);
    assert_eq!(look_from(&mut app, camera, 18.0, &inner), 1);
    assert_eq!(look_from(&mut app, camera, 30.0, &inner), 2);
    assert!(!sees(&app, camera, fine));
}

#[test]
fn swapped_meshes_within_a_block_are_hidden_by_its_proxy() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 5.0), spawn_block(&mut app, 1));
    let meshes: Vec<_> = (0..2).map(|_| add_mesh(&mut app, Cuboid::default())).collect();
    let lod = ProxyLod::new(LodMetric::Distance, meshes[0].clone()).then(10.0, meshes[1].clone());
    let lamp = spawn(&mut app, (Mesh3d(meshes[0].clone()), lod, ChildOf(block.near)));
    for (distance, is_shown) in [(5.0, true), (50.0, false), (15.0, true)] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(sees(&app, camera, lamp), is_shown);
        let mesh = &app.world().get::<Mesh3d>(lamp).unwrap().0;
        assert_eq!(*mesh == meshes[0], distance < 10.0);
    }
    // What is hung below such an entity is of the block as well.
    let flag = spawn(&mut app, (Mesh3d(meshes[0].clone()), ChildOf(lamp)));
    app.update();
    assert!(sees(&app, camera, flag));
    insert(&mut app, camera, at_distance(50.0));
    app.update();
    assert_eq!(listed(&app, camera), [block.proxy]);
    assert!(!sees(&app, camera, flag));
}

#[test]
fn blocks_are_as_large_as_the_finest_of_all_that_is_in_them() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 5.0), spawn_block(&mut app, 2));
    settings(&mut app).hysteresis = 0.0;
    // The first is 10 m nearer, the coarser levels of the other 30 m.
    insert(&mut app, block.statues[0].root, Transform::from_xyz(0.0, 0.0, 10.0));
    for level in 1..3 {
        insert(
            &mut app,
            block.statues[1].levels[level],
            Transform::from_xyz(0.0, 0.0, 30.0),
        );
    }
    for (distance, level) in [(49.9, 0), (50.1, 1), (49.9, 0)] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(
            choices(&app).level(block.root, camera),
            Some(level),
            "from {distance} m"
        );
    }
    insert(&mut app, block.statues[0].root, Transform::default());
    app.update();
    assert_eq!(choices(&app).level(block.root, camera), Some(1));
}

#[test]
fn two_blocks_may_be_put_into_each_other_the_other_way_round_in_one_frame() {
    for first in [true, false] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        let cubes: Vec<Entity> = (0..4).map(|_| spawn_cube(&mut app, Vec3::ZERO)).collect();
        let roots = [(); 2].map(|()| spawn(&mut app, (Transform::default(), Visibility::default())));
        let (a, b) = if first {
            (roots[0], roots[1])
        } else {
            (roots[1], roots[0])
        };
        // Up to 10 m both first cubes, up to 20 m what one group shows, and beyond that one cube.
        let put = |app: &mut App, outer: Entity, inner: Entity| {
            insert(app, inner, lod(LodMetric::Distance, &[cubes[0], cubes[1]], &[10.0]));
            let levels = ProxyLod::new(LodMetric::Distance, vec![inner, cubes[2]]).then(20.0, cubes[3]);
            insert(app, outer, levels);
        };
        for (outer, inner) in [(a, b), (b, a), (a, b)] {
            put(&mut app, outer, inner);
            for (distance, expected) in [(5.0, vec![0, 2]), (15.0, vec![1, 2]), (50.0, vec![3])] {
                insert(&mut app, camera, at_distance(distance));
                app.update();
                let expected: Vec<Entity> = expected.into_iter().map(|i: usize| cubes[i]).collect();
                assert_eq!(listed(&app, camera), expected, "at {distance} m");
            }
        }
    }
}

#[test]
fn bounds_follow_through_all_that_a_group_is_in() {
    // Whichever of the groups is looked at first.
    for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2], [1, 2, 0]] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        settings(&mut app).hysteresis = 0.0;
        let mut roots = [Entity::PLACEHOLDER; 3];
        for i in order {
            roots[i] = spawn(&mut app, (Transform::default(), Visibility::default()));
        }
        let cube = spawn_cube(&mut app, Vec3::ZERO);
        let proxies: Vec<Entity> = (0..3).map(|_| spawn_cube(&mut app, Vec3::ZERO)).collect();
        for (i, inner) in [roots[1], roots[2], cube].into_iter().enumerate() {
            set_parent(&mut app, inner, roots[i]);
            set_parent(&mut app, proxies[i], roots[i]);
            insert(
                &mut app,
                roots[i],
                lod(LodMetric::Distance, &[inner, proxies[i]], &[50.0]),
            );
        }
        insert(&mut app, camera, at_distance(65.0));
        app.update();
        assert_eq!(choices(&app).level(roots[0], camera), Some(1));
        // The outermost moves away by 10 m, and the innermost of all towards the camera by 30 m.
        insert(&mut app, roots[0], Transform::from_xyz(0.0, 0.0, -10.0));
        insert(&mut app, cube, Transform::from_xyz(0.0, 0.0, 30.0));
        app.update();
        for root in roots {
            assert_eq!(choices(&app).level(root, camera), Some(0), "{order:?}");
        }
    }
}

#[test]
fn who_is_listed_by_another_block_leaves_the_one_in_which_it_hangs() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 5.0), spawn_block(&mut app, 1));
    let meshes: Vec<_> = (0..2).map(|_| add_mesh(&mut app, Cuboid::default())).collect();
    let levels = ProxyLod::new(LodMetric::Distance, meshes[0].clone()).then(10.0, meshes[1].clone());
    let lamp = spawn(&mut app, (Mesh3d(meshes[0].clone()), levels, ChildOf(block.near)));
    app.update();
    let proxy = spawn_cube(&mut app, Vec3::ZERO);
    let other = spawn(&mut app, Transform::default());
    insert(&mut app, other, lod(LodMetric::Distance, &[lamp, proxy], &[100.0]));
    let both_are_right = |app: &mut App| {
        for (distance, shows_lamp) in [(60.0, true), (150.0, false), (60.0, true)] {
            insert(app, camera, at_distance(distance));
            app.update();
            assert_eq!(
                (sees(app, camera, lamp), sees(app, camera, proxy)),
                (shows_lamp, !shows_lamp)
            );
        }
    };
    both_are_right(&mut app);
    remove::<ProxyLod>(&mut app, block.root);
    both_are_right(&mut app);
}

#[test]
fn a_group_that_something_else_stands_in_for_shows_no_level() {
    let mut app = app();
    let (camera, block) = (spawn_camera(&mut app, 5.0), spawn_block(&mut app, 2));
    for (distance, expected) in [(5.0, Some(0)), (30.0, Some(2)), (50.0, None), (5.0, Some(0))] {
        assert_eq!(look_at(&mut app, camera, distance, &block), expected);
        let statue = block.statues[0].root;
        assert_eq!(choices(&app).shown_level(statue, camera), expected);
        assert!(choices(&app).level(statue, camera).is_some());
        assert!(choices(&app).shown_level(block.root, camera).is_some());
    }
}
