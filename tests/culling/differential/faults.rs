//! The comparison itself is compared: Bevy against Bevy with something put wrong must be noticed, and only then.

use bevy::{
    camera::visibility::{CascadesVisibleEntities, CubemapVisibleEntities, VisibleEntities, VisibleMeshEntities},
    ecs::component::Mutable,
    prelude::*,
};

use super::{Fault, LIGHTS, Plan, Run, VIEWS, apps::bevys};

/// Runs Bevy against Bevy, puts something wrong in the second app after a frame, and expects to be told of it.
fn assert_noticed(plan: Plan, act: fn(&mut World) -> bool, expected: &str) {
    let fault = Fault { frame: 30, act };
    let result = Run::new(plan, 0, [bevys(), bevys()]).frames(60, Some(fault));
    let message = result.expect_err("something is wrong in one of the apps");
    assert!(message.contains(expected), "{message}");
}

/// One entity that a camera sees.
fn seen_by_a_camera(world: &mut World) -> Option<Entity> {
    let mut things = world.query_filtered::<(Entity, &ViewVisibility), With<Mesh3d>>();
    let mut seen = things.iter(world).filter(|(_, visibility)| visibility.get());
    seen.next().map(|(thing, _)| thing)
}

/// Takes an entity out of the first of these lists that has any.
fn drop_one<'a>(lists: impl IntoIterator<Item = &'a mut VisibleMeshEntities>) -> bool {
    let mut lists = lists.into_iter();
    let list = lists.find(|list| !list.entities.is_empty());
    list.map(|list| list.entities.remove(0)).is_some()
}

/// Says that all components of a kind have changed.
fn touch<C: Component<Mutability = Mutable>>(world: &mut World) {
    let mut all = world.query::<&mut C>();
    all.iter_mut(world).for_each(|mut one| one.set_changed());
}

#[test]
fn nothing_is_noticed_where_nothing_is_wrong() {
    let tally = Run::new(LIGHTS, 0, [bevys(), bevys()]).frames(60, None);
    let tally = tally.expect("both apps are the same");
    let seen_by_each_kind = [tally.seen, tally.in_cascades, tally.on_faces, tally.in_cones];
    let is_enough = seen_by_each_kind.iter().all(|&count| count > 500) && tally.appeared_or_left > 150;
    assert!(is_enough, "too little happens to tell: {tally:?}");
}

#[test]
fn an_entity_that_is_hidden_in_one_app_is_noticed() {
    let hide = |world: &mut World| {
        let seen = seen_by_a_camera(world);
        seen.map(|seen| _ = world.entity_mut(seen).insert(Visibility::Hidden))
            .is_some()
    };
    assert_noticed(VIEWS, hide, "");
}

#[test]
fn an_entity_that_moves_in_one_app_is_noticed() {
    let put_away = |world: &mut World| {
        let seen = seen_by_a_camera(world);
        let away = GlobalTransform::from_xyz(0.0, 1e9, 0.0);
        seen.map(|seen| _ = world.entity_mut(seen).remove::<Transform>().insert(away))
            .is_some()
    };
    assert_noticed(VIEWS, put_away, "");
}

#[test]
fn an_entity_that_is_lacking_in_a_list_is_noticed() {
    let drop_one = |world: &mut World| {
        let mut cameras = world.query::<&mut VisibleEntities>();
        let mut lists = cameras
            .iter_mut(world)
            .flat_map(|lists| lists.into_inner().entities.values_mut());
        lists.find_map(Vec::pop).is_some()
    };
    assert_noticed(VIEWS, drop_one, "lacking [");
}

#[test]
fn two_entities_out_of_order_are_noticed() {
    let swap = |world: &mut World| {
        let mut cameras = world.query::<&mut VisibleEntities>();
        let mut lists = cameras
            .iter_mut(world)
            .flat_map(|lists| lists.into_inner().entities.values_mut());
        let list = lists.find(|list| list.first() != list.last());
        list.map(|list| list.reverse()).is_some()
    };
    assert_noticed(VIEWS, swap, "lacking [], too many []");
}

#[test]
fn a_needless_change_of_a_view_visibility_is_noticed() {
    let change = |world: &mut World| {
        let seen = seen_by_a_camera(world);
        let visibility = seen.and_then(|seen| world.get_mut::<ViewVisibility>(seen));
        visibility.map(|mut visibility| visibility.set_changed()).is_some()
    };
    assert_noticed(VIEWS, change, "ChangedInUpdate");
}

#[test]
fn a_view_visibility_that_forgets_the_last_frame_is_noticed() {
    let forget = |world: &mut World| {
        let mut things = world.query::<&mut ViewVisibility>();
        let fresh = things.iter_mut(world).find(|visibility| {
            // Visible since this frame, which `get` cannot tell from visible for longer.
            visibility.get() && **visibility != ViewVisibility::VISIBLE
        });
        let forget = |mut visibility: Mut<ViewVisibility>| {
            *visibility.bypass_change_detection() = ViewVisibility::VISIBLE;
        };
        fresh.map(forget).is_some()
    };
    assert_noticed(VIEWS, forget, "ViewVisibility");
}

#[test]
fn needless_writing_to_lists_is_noticed() {
    let touch_all = |world: &mut World| {
        touch::<VisibleEntities>(world);
        touch::<CubemapVisibleEntities>(world);
        touch::<VisibleMeshEntities>(world);
        true
    };
    assert_noticed(LIGHTS, touch_all, "ListsChanged");
}

#[test]
fn a_caster_of_shadows_that_is_lacking_in_a_cascade_is_noticed() {
    let drop_one = |world: &mut World| {
        let mut suns = world.query::<&mut CascadesVisibleEntities>();
        drop_one(
            suns.iter_mut(world)
                .flat_map(|views| views.into_inner().entities.values_mut().flatten()),
        )
    };
    assert_noticed(LIGHTS, drop_one, "Cascade(");
}

#[test]
fn a_caster_of_shadows_that_is_lacking_on_a_face_is_noticed() {
    let drop_one = |world: &mut World| {
        let mut lamps = world.query::<&mut CubemapVisibleEntities>();
        drop_one(lamps.iter_mut(world).flat_map(|faces| faces.into_inner().iter_mut()))
    };
    assert_noticed(LIGHTS, drop_one, "Face(");
}

#[test]
fn a_caster_of_shadows_that_is_lacking_in_a_cone_is_noticed() {
    let drop_one = |world: &mut World| {
        let mut spots = world.query::<&mut VisibleMeshEntities>();
        drop_one(spots.iter_mut(world).map(Mut::into_inner))
    };
    assert_noticed(LIGHTS, drop_one, "Cone");
}

#[test]
#[should_panic(expected = "the apps count entities alike")]
fn an_entity_that_only_one_app_spawns_is_noticed() {
    let spawn = |world: &mut World| {
        world.spawn_empty();
        true
    };
    assert_noticed(VIEWS, spawn, "");
}
