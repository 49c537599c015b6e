//! Four turntables with one subject, and its volumes around it.

use bevy::{
    color::palettes::tailwind::{AMBER_400, EMERALD_400, ROSE_400, SKY_400},
    math::Vec3A,
    mesh::VertexAttributeValues,
    prelude::*,
};
use bevy_sightline::geometry::volume::BoundingKind;

use crate::{
    measure::{KINDS, Measured},
    panel::panel,
};

pub const SKY: Srgba = Srgba::rgb(0.13, 0.16, 0.21);
pub const TO_SUN: Vec3 = Vec3::new(0.4, 0.9, 0.6);

const RADIUS: f32 = 1.6;

/// What there is to look at: names and meshes.
#[derive(Resource)]
pub struct Subjects(Vec<(&'static str, Handle<Mesh>)>);

impl Subjects {
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

/// The number of what is looked at.
#[derive(Resource, Default)]
pub struct Subject(pub usize);

/// Shows one kind of volume.
#[derive(Component)]
pub struct Turntable {
    pub kind: BoundingKind,
    place: Vec3,
}

impl Turntable {
    pub fn color(&self) -> Srgba {
        match self.kind {
            BoundingKind::Sphere => SKY_400,
            BoundingKind::Aabb => ROSE_400,
            BoundingKind::Obb => AMBER_400,
            BoundingKind::Hull => EMERALD_400,
        }
    }
}

/// How far the tables have turned, in radians.
#[derive(Resource)]
struct Angle(f32);

pub fn plugin(app: &mut App) {
    app.init_resource::<Subject>()
        .insert_resource(Angle(0.5))
        .insert_resource(ClearColor(SKY.into()))
        .insert_resource(GlobalAmbientLight {
            brightness: 700.0,
            ..default()
        })
        .add_systems(Startup, (gather, set_up).chain())
        .add_systems(Update, (show, measure, turn).chain());
}

/// What only a window can show.
pub fn window_plugin(app: &mut App) {
    app.add_systems(Startup, spawn_text)
        .add_systems(Update, (choose.before(show), advance.before(turn), tell.after(turn)))
        .add_systems(PostUpdate, draw.after(TransformSystems::Propagate));
}

fn gather(mut commands: Commands, assets: Res<AssetServer>, mut meshes: ResMut<Assets<Mesh>>) {
    let model = |name: &'static str| (name, assets.load(format!("{name}.glb#Mesh0/Primitive0")));
    let models = [
        "statue",
        "car_van",
        "tree_oak",
        "lamp_street",
        "arch_gate",
        "church",
        "person",
    ]
    .map(model);
    let tilted = Mesh::from(Cuboid::new(3.0, 1.0, 0.5)).rotated_by(Quat::from_euler(EulerRot::XYZ, 0.4, 0.6, 0.8));
    let primitives: [(&str, Mesh); 6] = [
        ("tilted cuboid", tilted),
        ("torus", Torus::new(0.4, 1.2).into()),
        ("cone", Cone::new(1.0, 2.5).into()),
        ("capsule", Capsule3d::new(0.5, 2.0).into()),
        ("tetrahedron", Tetrahedron::default().into()),
        (
            "plane",
            Plane3d::new(Vec3::new(1.0, 2.0, 1.0), Vec2::new(2.0, 1.0)).into(),
        ),
    ];
    let primitives = primitives.map(|(name, mesh)| (name, meshes.add(mesh)));
    commands.insert_resource(Subjects(models.into_iter().chain(primitives).collect()));
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    subjects: Res<Subjects>,
) {
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 3.8, 11.6).looking_at(Vec3::new(0.0, 1.9, 0.0), Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::IDENTITY.looking_to(-TO_SUN, Vec3::Y),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(400.0, 400.0))),
        MeshMaterial3d(materials.add(StandardMaterial::from(Color::srgb(0.20, 0.24, 0.30)))),
    ));
    let white = materials.add(StandardMaterial {
        perceptual_roughness: 0.8,
        ..Color::WHITE.into()
    });
    for (column, (kind, _)) in (0u8..).zip(KINDS) {
        let place = Vec3::new((f32::from(column) - 1.5) * 4.2, 2.0, 0.0);
        commands.spawn((
            Turntable { kind, place },
            Mesh3d(subjects.0[0].1.clone()),
            MeshMaterial3d(white.clone()),
            Transform::from_translation(place),
        ));
    }
}

/// Puts another subject on the tables.
fn show(
    mut commands: Commands,
    subject: Res<Subject>,
    subjects: Res<Subjects>,
    mut tables: Query<&mut Mesh3d, With<Turntable>>,
) {
    if subject.is_changed() {
        commands.remove_resource::<Measured>();
        for mut mesh in &mut tables {
            mesh.0 = subjects.0[subject.0].1.clone();
        }
    }
}

/// Measures the subject as soon as it is loaded.
fn measure(
    mut commands: Commands,
    measured: Option<Res<Measured>>,
    subject: Res<Subject>,
    subjects: Res<Subjects>,
    meshes: Res<Assets<Mesh>>,
) -> Result {
    let (name, mesh) = &subjects.0[subject.0];
    let positions = meshes
        .get(mesh)
        .and_then(|mesh| mesh.attribute(Mesh::ATTRIBUTE_POSITION));
    if let (None, Some(VertexAttributeValues::Float32x3(positions))) = (measured, positions) {
        let points: Vec<Vec3A> = positions.iter().map(|position| Vec3A::from_array(*position)).collect();
        commands.insert_resource(Measured::new(name, &points)?);
    }
    Ok(())
}

/// Turns the subjects about their middle, at one size for all.
fn turn(measured: Option<Res<Measured>>, angle: Res<Angle>, mut tables: Query<(&Turntable, &mut Transform)>) {
    let Some(sphere) = measured.map(|measured| measured.sphere) else {
        return;
    };
    let scale = RADIUS / sphere.radius();
    let rotation = Quat::from_rotation_y(angle.0) * Quat::from_rotation_x(0.35) * Quat::from_rotation_z(0.2);
    for (table, mut transform) in &mut tables {
        *transform = Transform {
            translation: table.place - rotation * Vec3::from(sphere.center) * scale,
            rotation,
            scale: Vec3::splat(scale),
        };
    }
}

fn choose(keys: Res<ButtonInput<KeyCode>>, subjects: Res<Subjects>, mut subject: ResMut<Subject>) {
    let count = subjects.len();
    if keys.just_pressed(KeyCode::ArrowRight) {
        subject.0 = (subject.0 + 1) % count;
    }
    if keys.just_pressed(KeyCode::ArrowLeft) {
        subject.0 = (subject.0 + count - 1) % count;
    }
}

fn advance(keys: Res<ButtonInput<KeyCode>>, time: Res<Time>, mut still: Local<bool>, mut angle: ResMut<Angle>) {
    *still ^= keys.just_pressed(KeyCode::Space);
    if !*still {
        angle.0 += 0.4 * time.delta_secs();
    }
}

fn draw(measured: Option<Res<Measured>>, tables: Query<(&Turntable, &GlobalTransform)>, mut gizmos: Gizmos) {
    let Some(measured) = measured else {
        return;
    };
    for (table, transform) in &tables {
        for [from, to] in measured.wireframe(table.kind, transform) {
            gizmos.line(from, to, table.color());
        }
    }
}

#[derive(Component)]
struct Table;

fn spawn_text(mut commands: Commands) {
    commands.spawn(panel(Table, "loading"));
}

fn tell(measured: Option<Res<Measured>>, mut text: Single<&mut Text, With<Table>>) {
    if let Some(measured) = measured.filter(DetectChanges::is_changed) {
        text.0 = format!("{}\n\nleft, right: another subject    space: hold still", *measured);
    }
}
