//! The least that it takes: three glTF models grow under the mouse, and tell where they were clicked.
//!
//! ```sh
//! cargo run --example mouse_picking
//! ```
//!
//! One line, `SightlinePlugins`, makes everything with a mesh pickable; the rest is Bevy's own observers. Without a
//! display a synthetic pointer clicks in the middle of the view.

#[path = "shared/pointer.rs"]
mod pointer;
mod shared;

use bevy::{gltf::GltfAssetLabel, prelude::*};
use bevy_sightline::prelude::*;

fn main() -> AppExit {
    let headless = !shared::has_display();
    let mut app = App::new();
    app.add_plugins((shared::plugins("mouse picking", headless), SightlinePlugins)) // or (DefaultPlugins, SightlinePlugins)
        .add_systems(Startup, setup);
    if !headless {
        return app.run();
    }
    shared::load(&mut app).expect("the models are in the folder assets");
    pointer::play(&mut app, pointer::click(Vec2::splat(0.5)));
    let world = app.world_mut();
    let mut transforms = world.query::<&Transform>();
    assert!(
        transforms.iter(world).any(|transform| transform.scale != Vec3::ONE),
        "a model grows"
    );
    AppExit::Success
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(-3.0, 5.0, 13.0).looking_at(Vec3::Y * 2.2, Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::IDENTITY.looking_to(Vec3::new(1.0, -2.0, -1.5), Vec3::Y),
    ));
    for (x, name) in [(-5.0, "tree_oak"), (0.0, "statue"), (4.5, "car_sedan")] {
        let scene = assets.load(GltfAssetLabel::Scene(0).from_asset(format!("{name}.glb")));
        commands
            .spawn((Name::new(name), WorldAssetRoot(scene), Transform::from_xyz(x, 0.0, 0.0)))
            .observe(grow)
            .observe(shrink)
            .observe(tell);
    }
}

fn grow(over: On<Pointer<Over>>, mut transforms: Query<&mut Transform>) -> Result {
    transforms.get_mut(over.entity)?.scale = Vec3::splat(1.1);
    Ok(())
}

fn shrink(out: On<Pointer<Out>>, mut transforms: Query<&mut Transform>) -> Result {
    transforms.get_mut(out.entity)?.scale = Vec3::ONE;
    Ok(())
}

fn tell(click: On<Pointer<Click>>, names: Query<&Name>) -> Result {
    let hit = click.hit.extra_as::<RayHit>().ok_or("a click by another backend")?;
    println!(
        "{} was clicked at {:.2}, {:.2} m away",
        names.get(click.entity)?,
        hit.position,
        hit.distance
    );
    Ok(())
}
