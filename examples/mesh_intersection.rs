//! Two meshes, and the curve in which they meet, live.
//!
//! ```sh
//! cargo run --release --example mesh_intersection                # a window where there is a display
//! cargo run --release --example mesh_intersection -- --headless  # figures of a move through, and a picture
//! ```
//!
//! **In the window** drag the ring through the statue, or the statue through the ring; the wheel moves what is dragged
//! nearer and farther, Space holds the ring still. The text tells how many pairs of triangles touch, how long the curve
//! is, and how many microseconds it took to find out.

#[path = "shared/panel.rs"]
mod panel;
#[path = "shared/picture.rs"]
mod picture;
mod shared;

use std::{
    path::Path,
    time::{Duration, Instant},
};

use bevy::{
    color::palettes::tailwind::{SKY_700, STONE_300, YELLOW_300},
    gizmos::config::{DefaultGizmoConfigGroup, GizmoConfigStore},
    input::mouse::AccumulatedMouseScroll,
    math::DVec3,
    prelude::*,
};
use bevy_sightline::{geometry::triangle_triangle::TriangleContact, index::MeshBvhs, mesh::TriangleMesh, prelude::*};

use panel::panel;
use picture::{Daylight, Painter, Picture};

const SKY: Srgba = Srgba::rgb(0.66, 0.79, 0.90);
const TO_SUN: Vec3 = Vec3::new(0.4, 0.9, 0.6);

/// Meets the statue.
#[derive(Component)]
struct Ring;

/// Is met.
#[derive(Component)]
struct Statue;

/// Where the two meet, as of this frame.
#[derive(Resource, Default)]
struct Meeting {
    contacts: Vec<MeshContact>,
    took: Duration,
}

fn main() -> AppExit {
    let headless = !shared::has_display() || std::env::args().any(|argument| argument == "--headless");
    let mut app = App::new();
    app.add_plugins((
        shared::plugins("bevy_sightline: mesh intersection", headless),
        SightlinePlugins,
    ))
    .init_resource::<Meeting>()
    .insert_resource(ClearColor(SKY.into()))
    .insert_resource(GlobalAmbientLight {
        brightness: 700.0,
        ..default()
    })
    .add_systems(Startup, set_up)
    .add_systems(PostUpdate, meet.after(SpatialIndexSystems::Sync));
    if !headless {
        return app
            .add_systems(Startup, set_up_window)
            .add_systems(Update, (spin, reach, tell))
            .add_systems(PostUpdate, draw_curve.after(meet))
            .add_observer(grab)
            .add_observer(drag)
            .run();
    }
    match report(&mut app) {
        Ok(()) => AppExit::Success,
        Err(error) => {
            eprintln!("{error}");
            AppExit::error()
        }
    }
}

fn set_up(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(-3.2, 4.2, 8.4).looking_at(Vec3::new(0.0, 2.75, 0.0), Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::IDENTITY.looking_to(-TO_SUN, Vec3::Y),
    ));
    let matte = |color: Srgba| StandardMaterial {
        perceptual_roughness: 0.8,
        ..Color::from(color).into()
    };
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(4000.0, 4000.0))),
        MeshMaterial3d(materials.add(matte(STONE_300))),
        Pickable::IGNORE,
    ));
    commands.spawn((
        Statue,
        Mesh3d(assets.load("statue.glb#Mesh0/Primitive0")),
        MeshMaterial3d(materials.add(matte(Srgba::WHITE))),
        Transform::IDENTITY,
    ));
    let ring = Torus::new(0.9, 1.6).mesh().major_resolution(128).minor_resolution(48);
    commands.spawn((
        Ring,
        Mesh3d(meshes.add(ring)),
        MeshMaterial3d(materials.add(matte(SKY_700))),
        ring_at(0.5),
    ));
}

/// The ring on its way through the statue, from 0 to 1.
fn ring_at(progress: f32) -> Transform {
    Transform::from_xyz(4.0 * (progress - 0.5), 2.0 + progress, 0.4).with_rotation(Quat::from_euler(
        EulerRot::XYZ,
        0.4,
        3.0 * progress,
        0.5,
    ))
}

/// Finds out where the two meet.
fn meet(
    scene: SceneQuery,
    ring: Single<Entity, With<Ring>>,
    statue: Single<Entity, With<Statue>>,
    mut meeting: ResMut<Meeting>,
) {
    let start = Instant::now();
    scene.mesh_contacts(*ring, *statue, &mut meeting.contacts);
    meeting.took = start.elapsed();
}

impl Meeting {
    /// The pieces of the curve.
    fn curve(&self) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        self.contacts.iter().filter_map(|contact| match contact.contact {
            TriangleContact::Segment(ends) => Some(ends.map(DVec3::as_vec3)),
            _ => None,
        })
    }

    fn length(&self) -> f32 {
        self.curve().map(|[from, to]| from.distance(to)).sum()
    }
}

#[derive(Component)]
struct Figures;

fn set_up_window(mut commands: Commands, mut gizmos: ResMut<GizmoConfigStore>) {
    let (config, _) = gizmos.config_mut::<DefaultGizmoConfigGroup>();
    config.line.width = 4.0;
    config.depth_bias = -0.001;
    commands.spawn(panel(Figures, ""));
}

fn spin(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut still: Local<bool>,
    mut ring: Single<&mut Transform, With<Ring>>,
) {
    *still ^= keys.just_pressed(KeyCode::Space);
    if !*still {
        ring.rotate_y(0.3 * time.delta_secs());
    }
}

fn tell(meeting: Res<Meeting>, mut text: Single<&mut Text, With<Figures>>) {
    text.0 = format!(
        "{} pairs of triangles touch, along {:.2} m\nfound in {:.0} microseconds\n\
         drag the ring or the statue; wheel: nearer, farther; space: hold still",
        meeting.contacts.len(),
        meeting.length(),
        meeting.took.as_secs_f64() * 1e6,
    );
}

fn draw_curve(meeting: Res<Meeting>, mut gizmos: Gizmos) {
    for [from, to] in meeting.curve() {
        gizmos.line(from, to, YELLOW_300);
    }
}

/// Held by the pointer: the point that was grabbed, from its origin.
#[derive(Component)]
struct Held {
    offset: Vec3,
    distance: f32,
}

fn grab(press: On<Pointer<Press>>, mut commands: Commands, things: Query<&Transform, Or<(With<Ring>, With<Statue>)>>) {
    if let (Ok(transform), Some(hit)) = (things.get(press.entity), press.hit.extra_as::<RayHit>()) {
        commands.entity(press.entity).insert(Held {
            offset: transform.translation - hit.position,
            distance: hit.distance,
        });
    }
}

/// Keeps the point that was grabbed under the pointer.
fn drag(
    drag: On<Pointer<Drag>>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut held: Query<(&Held, &mut Transform)>,
) {
    let (camera, camera_transform) = *camera;
    let ray = camera.viewport_to_world(camera_transform, drag.pointer_location.position);
    if let (Ok((held, mut transform)), Ok(ray)) = (held.get_mut(drag.entity), ray) {
        transform.translation = ray.get_point(held.distance) + held.offset;
    }
}

/// Moves what is dragged along the view.
fn reach(
    scroll: Res<AccumulatedMouseScroll>,
    buttons: Res<ButtonInput<MouseButton>>,
    camera: Single<&GlobalTransform, With<Camera>>,
    mut commands: Commands,
    mut held: Query<(Entity, &mut Held, &mut Transform)>,
) {
    for (entity, mut held, mut transform) in &mut held {
        if !buttons.pressed(MouseButton::Left) {
            commands.entity(entity).remove::<Held>();
            continue;
        }
        let step = 0.2 * scroll.delta.y;
        held.distance += step;
        transform.translation += camera.forward() * step;
    }
}

/// Moves the ring through the statue, tells what it met, and draws the middle of the way.
fn report(app: &mut App) -> Result<(), String> {
    const STEPS: u16 = 100;
    let file = Path::new("out/mesh_intersection.png");
    shared::load(app)?;
    let (mut times, mut most, mut longest) = (Vec::new(), 0, 0.0f32);
    for step in (0..=STEPS).chain([STEPS / 2]) {
        let world = app.world_mut();
        let mut rings = world.query_filtered::<&mut Transform, With<Ring>>();
        *rings.single_mut(world).map_err(|error| error.to_string())? = ring_at(f32::from(step) / f32::from(STEPS));
        app.update();
        let meeting = app.world().resource::<Meeting>();
        times.push(meeting.took);
        most = most.max(meeting.contacts.len());
        longest = longest.max(meeting.length());
    }
    times.sort_unstable();

    let world = app.world_mut();
    let meshes: Vec<AssetId<Mesh>> = world
        .query_filtered::<&Mesh3d, Or<(With<Ring>, With<Statue>)>>()
        .iter(world)
        .map(|mesh| mesh.id())
        .collect();
    let bvhs = world.resource::<MeshBvhs>();
    let triangles: Vec<usize> = (meshes.iter())
        .filter_map(|mesh| bvhs.triangles(*mesh))
        .map(TriangleMesh::len)
        .collect();
    println!("triangles               {triangles:?}");
    println!("steps                   {}", times.len());
    println!("most pairs that touch   {most}");
    println!("longest curve           {longest:.2} m");
    println!(
        "median time             {:.0} us",
        times[times.len() / 2].as_secs_f64() * 1e6
    );
    println!(
        "longest time            {:.0} us",
        times[times.len() - 1].as_secs_f64() * 1e6
    );
    let drawn = app.world_mut().run_system_cached_with(draw_picture, file);
    drawn
        .map_err(|error| error.to_string())?
        .map_err(|error| error.to_string())?;
    println!("picture: {}", file.display());
    Ok(())
}

fn draw_picture(
    In(file): In<&'static Path>,
    painter: Painter,
    camera: Single<(&Camera, &GlobalTransform)>,
    meeting: Res<Meeting>,
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let daylight = Daylight {
        sky: SKY,
        to_sun: TO_SUN,
        haze: 300.0,
    };
    let mut picture = Picture::ray_cast(UVec2::new(2560, 1440), *camera, |ray| painter.shade(ray, &daylight));
    for line in meeting.curve() {
        picture.line(line, YELLOW_300);
    }
    picture.save(file)
}
