use bevy::prelude::*;
use bevy_sightline::prelude::*;

fn spawn_ring(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn(Camera2d);
    commands.spawn(Sprite::from_image(assets.load("ring.png"))).observe(|click: On<Pointer<Click>>| {
        let hit = click.hit.extra_as::<RayHit>();
        println!("clicked on the ring, and not through its hole, at {:?}", hit.and_then(|hit| hit.uv));
    });
    // The whole rectangle counts.
    commands.spawn((Sprite::from_image(assets.load("button.png")), AlphaTest::Off));
}
