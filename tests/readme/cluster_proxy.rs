use bevy::prelude::*;
use bevy_sightline::prelude::*;

fn main() {
    // Proxies have the materials of what they stand for.
    let proxies = AutoProxyPlugin::default().with_material::<MeshMaterial3d<StandardMaterial>>();
    App::new().add_plugins((DefaultPlugins, SightlinePlugins.set(proxies))).add_systems(Startup, spawn_street).run();
}

fn spawn_street(mut commands: Commands, assets: Res<AssetServer>) {
    let house = assets.load("house.glb#Scene0");
    let street = commands.spawn((Transform::default(), Visibility::default(), ClusterProxy::default())).id();
    for number in 0..20 {
        let place = Transform::from_xyz(12.0 * number as f32, 0.0, 0.0);
        commands.spawn((WorldAssetRoot(house.clone()), place, ChildOf(street)));
    }
    commands.add_observer(|ready: On<ProxyReady>| println!("{} has a proxy", ready.entity));
}
