//! Taking Bevy's own culling out of the schedule, so that it can take turns with ours.

use bevy::{
    app::{App, Plugin, PostUpdate},
    camera::visibility::{
        NoCpuCulling, ViewVisibility, VisibilityPlugin, VisibilitySystems, check_visibility_cpu_culling,
    },
    ecs::{
        change_detection::DetectChangesMut,
        query::Without,
        schedule::{
            InternedSystemSet, IntoScheduleConfigs, IntoSystemSet, ScheduleCleanupPolicy, Schedules, SystemSet,
        },
        system::{Query, System},
        world::World,
    },
    light::{SimulationLightSystems, check_dir_light_mesh_visibility, check_point_light_mesh_visibility},
};

use super::{is_left_to_bevy, marks::was_visible};

/// Lets Bevy's culling of views run only while it is asked to. False if it is not there.
pub(super) fn replace_view_culling(app: &mut App) -> bool {
    let Some(private) = systems_of_marks() else {
        return false;
    };
    if !remove(app, check_visibility_cpu_culling.into_system_set().intern()) {
        return false;
    }
    for set in private {
        remove(app, set);
    }
    app.add_systems(
        PostUpdate,
        (
            reset_view_visibility.in_set(VisibilitySystems::VisibilityPropagate),
            check_visibility_cpu_culling.in_set(VisibilitySystems::CheckVisibility),
            mark_newly_hidden_entities_invisible.in_set(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
        )
            .run_if(is_left_to_bevy),
    );
    true
}

/// Lets Bevy's culling for lights run only while it is asked to. False if it is not there.
pub(super) fn replace_light_culling(app: &mut App) -> bool {
    let cascades = check_dir_light_mesh_visibility.into_system_set().intern();
    let local = check_point_light_mesh_visibility.into_system_set().intern();
    if !(remove(app, cascades) && remove(app, local)) {
        return false;
    }
    app.add_systems(
        PostUpdate,
        (check_dir_light_mesh_visibility, check_point_light_mesh_visibility)
            .run_if(is_left_to_bevy)
            .in_set(SimulationLightSystems::CheckLightVisibility)
            .after(SimulationLightSystems::UpdateLightFrusta)
            .after(VisibilitySystems::CheckVisibility)
            .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
    );
    true
}

/// Removes the systems of a set. False if there are none.
fn remove(app: &mut App, set: InternedSystemSet) -> bool {
    let removed = app.remove_systems_in_set(PostUpdate, set, ScheduleCleanupPolicy::RemoveSystemsOnly);
    removed.is_ok_and(|removed| removed > 0)
}

/// The sets of Bevy's two systems that set marks back and hide what is left. They are private: they are known by what
/// they do, which is to write `ViewVisibility` and to look at nothing else.
fn systems_of_marks() -> Option<[InternedSystemSet; 2]> {
    let mut app = App::empty();
    app.init_resource::<Schedules>();
    VisibilityPlugin.build(&mut app);
    let mut world = World::new();
    let written = world.register_component::<ViewVisibility>();
    let mut schedule = app.world_mut().resource_mut::<Schedules>().remove(PostUpdate)?;
    let systems = &mut schedule.graph_mut().systems;
    let keys: Vec<_> = systems.iter().map(|(key, ..)| key).collect();
    let sets: Vec<_> = keys
        .into_iter()
        .filter_map(|key| {
            let system = systems.get_mut(key)?;
            let access = system.initialize(&mut world);
            let access = access.combined_access();
            let reads = access.try_iter_access().ok()?;
            let looks_at_nothing_else = reads.count() == 1;
            (access.has_write(written) && looks_at_nothing_else)
                .then(|| system.default_system_sets().into_iter().next())
                .flatten()
        })
        .collect();
    sets.try_into().ok()
}

/// What Bevy's system of this name does.
fn reset_view_visibility(mut visibilities: Query<&mut ViewVisibility, Without<NoCpuCulling>>) {
    let was_visible = was_visible();
    visibilities.par_iter_mut().for_each(|mut visibility| {
        let reset = if visibility.get() {
            was_visible
        } else {
            ViewVisibility::HIDDEN
        };
        *visibility.bypass_change_detection() = reset;
    });
}

/// What Bevy's system of this name does.
fn mark_newly_hidden_entities_invisible(mut visibilities: Query<&mut ViewVisibility, Without<NoCpuCulling>>) {
    let was_visible = was_visible();
    visibilities.par_iter_mut().for_each(|mut visibility| {
        if *visibility == was_visible {
            *visibility = ViewVisibility::HIDDEN;
        }
    });
}
