//! Ours against Bevy's own `MeshRayCast`, ray by ray: the same entity at the same distance, or a proof that Bevy errs.
//!
//! The proof is a test of every triangle of every entity in double precision: where the two disagree, it must side
//! with ours.

use bevy::{
    gltf::{Gltf, GltfMesh, GltfPlugin},
    math::DVec3,
    mesh::VertexAttributeValues,
    picking::mesh_picking::ray_cast::{MeshRayCast, MeshRayCastSettings, RayCastVisibility},
    platform::collections::HashMap,
    prelude::*,
    world_serialization::WorldSerializationPlugin,
};
use bevy_sightline::{index::RayCastBackfaces, prelude::*};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::{
    add_mesh, finish_meshes, headless_app, headless_app_with, random_dir, random_point, random_rotation, ray_towards,
    rng,
};

const RELATIVE_DISTANCE: f64 = 1e-4;

type Answer = Option<(Entity, f32)>;

/// What the two say to each ray.
fn ask_both(app: &mut App, rays: &[Ray3d]) -> Vec<(Answer, Answer)> {
    let ask = |In(rays): In<Vec<Ray3d>>, scene: SceneQuery, mut bevy: MeshRayCast| -> Vec<(Answer, Answer)> {
        let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::Any);
        let bevys_settings = MeshRayCastSettings::default().with_visibility(RayCastVisibility::Any);
        rays.into_iter()
            .map(|ray| {
                let ours = scene.cast_ray(ray, &settings).map(|hit| (hit.entity, hit.distance));
                let bevys = bevy.cast_ray(ray, &bevys_settings).first();
                (ours, bevys.map(|(entity, hit)| (*entity, hit.distance)))
            })
            .collect()
    };
    app.world_mut()
        .run_system_cached_with(ask, rays.to_vec())
        .expect("both are there")
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= RELATIVE_DISTANCE * a.abs().max(b.abs())
}

/// What became of all rays.
#[derive(Debug, Default)]
struct Tally {
    rays: usize,
    hits: usize,
    /// Two entities have surfaces at one distance, and each side named another.
    ties: usize,
    /// Bevy's errors, by kind.
    errors: HashMap<BevyError, usize>,
}

/// The ways in which Bevy's answer was proven wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum BevyError {
    /// It drops triangles whose determinant is below `f32::EPSILON`, whatever their scale.
    DropsTinyTriangle,
    /// It hits the right entity at a wrong distance: it takes the ray to local space in single precision.
    Rounds,
    /// Its test is not watertight: on or beside an edge it misses what is there, or hits what is not.
    SlipsAtEdge,
}

impl Tally {
    fn errors(&self) -> usize {
        self.errors.values().sum()
    }
}

/// Compares the answers to all rays.
///
/// # Panics
///
/// If ours is wrong by the reference, or if they differ and neither can be shown to be wrong.
fn judge(app: &mut App, rays: &[Ray3d]) -> Tally {
    let answers = ask_both(app, rays);
    let mut tally = Tally::default();
    for (ray, (ours, bevys)) in rays.iter().zip(answers) {
        tally.rays += 1;
        tally.hits += usize::from(ours.is_some());
        let same_entity = ours.map(|hit| hit.0) == bevys.map(|hit| hit.0);
        let same_distance = match (ours, bevys) {
            (None, None) => true,
            (Some((_, a)), Some((_, b))) => close(a.into(), b.into()),
            _ => false,
        };
        if same_entity && same_distance {
            continue;
        }
        let reference = Reference::new(app, *ray);
        let context = format!("{ray:?}: ours is {ours:?}, Bevy's {bevys:?}");
        assert!(
            reference.is_right(ours),
            "{context}; the reference has {:?}",
            reference.certain().next()
        );
        if same_distance {
            tally.ties += 1;
        } else if let Some(error) = reference.explain(ours, bevys) {
            *tally.errors.entry(error).or_default() += 1;
        } else {
            // Both are within the tolerance of the exact distance, on either side of it.
            assert!(same_entity && reference.is_right(bevys), "{context}: unexplained");
        }
    }
    tally
}

/// Everything that a ray meets, in double precision, with no box and no hierarchy in between; nearest first.
struct Reference(Vec<ReferenceHit>);

#[derive(Clone, Copy, Debug)]
struct ReferenceHit {
    entity: Entity,
    t: f64,
    /// How far inside of the nearest edge, in barycentric coordinates; outside if negative.
    inside: f64,
    /// Whether the ray nearly runs along the triangle, or starts on it.
    edge_on: bool,
    /// The determinant by which Bevy decides whether a triangle is too small: in local space, the direction of unit
    /// length.
    local_determinant: f64,
}

/// Farther inside than this, rounding the input does not decide whether a triangle is hit; farther outside neither.
const MARGIN: f64 = 1e-3;

impl Reference {
    fn new(app: &mut App, ray: Ray3d) -> Self {
        let mut hits = Vec::new();
        let world = app.world_mut();
        let mut things = world.query::<(Entity, &Mesh3d, &GlobalTransform, Has<RayCastBackfaces>)>();
        let meshes = world.resource::<Assets<Mesh>>();
        for (entity, mesh, transform, backfaces) in things.iter(world) {
            let mesh = meshes.get(mesh).expect("a loaded mesh");
            let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
                panic!("positions of three floats");
            };
            let local_from_world = transform.affine().as_daffine3().inverse();
            let origin = local_from_world.transform_point3(ray.origin.as_dvec3());
            let direction = local_from_world.transform_vector3(ray.direction.as_vec3().as_dvec3());
            let indices: Vec<usize> = match mesh.indices() {
                Some(indices) => indices.iter().collect(),
                None => (0..positions.len()).collect(),
            };
            for triangle in indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|i| Vec3::from(positions[triangle[i]]).as_dvec3());
                hits.extend(hit(entity, origin, direction, corners, backfaces));
            }
        }
        hits.sort_by(|a, b| a.t.total_cmp(&b.t));
        Self(hits)
    }

    /// The hits that no rounding can undo.
    fn certain(&self) -> impl Iterator<Item = &ReferenceHit> {
        self.0.iter().filter(|hit| hit.inside > MARGIN && !hit.edge_on)
    }

    /// The hit that an answer names, if it exists.
    fn named_by(&self, answer: (Entity, f32)) -> Option<&ReferenceHit> {
        let is_it = |hit: &&ReferenceHit| hit.entity == answer.0 && close(hit.t, answer.1.into());
        self.0.iter().find(is_it)
    }

    /// The answer names a hit that exists, and no certain hit is nearer.
    fn is_right(&self, answer: Answer) -> bool {
        let nearest_certain = self.certain().next().map_or(f64::INFINITY, |hit| hit.t);
        match answer {
            None => nearest_certain == f64::INFINITY,
            Some((entity, distance)) => {
                let in_front = f64::from(distance) <= nearest_certain * (1.0 + RELATIVE_DISTANCE);
                in_front && self.named_by((entity, distance)).is_some()
            }
        }
    }

    /// What Bevy has done wrong where ours is right, if it is one of the known errors.
    fn explain(&self, ours: Answer, bevys: Answer) -> Option<BevyError> {
        if let (Some(ours), Some(bevys)) = (ours, bevys)
            && ours.0 == bevys.0
            && (ours.1 - bevys.1).abs() < 1e-3
        {
            return (!self.is_right(Some(bevys))).then_some(BevyError::Rounds);
        }
        let our_hit = ours.and_then(|ours| self.named_by(ours));
        let passed_over = our_hit.filter(|hit| bevys.is_none_or(|bevys| f64::from(bevys.1) > hit.t));
        match passed_over {
            Some(hit) if hit.local_determinant.abs() < 1.01 * f64::from(f32::EPSILON) => {
                Some(BevyError::DropsTinyTriangle)
            }
            Some(hit) if hit.inside < MARGIN => Some(BevyError::SlipsAtEdge),
            Some(_) => None,
            // Bevy hits what ours passes by: beside an edge.
            None => {
                let bevys = bevys.and_then(|bevys| self.named_by(bevys))?;
                (bevys.inside < MARGIN || bevys.edge_on).then_some(BevyError::SlipsAtEdge)
            }
        }
    }
}

/// Möller and Trumbore's test in local space, which is all that double precision needs here.
fn hit(
    entity: Entity,
    origin: DVec3,
    direction: DVec3,
    [a, b, c]: [DVec3; 3],
    backfaces: bool,
) -> Option<ReferenceHit> {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let det = -direction.dot(normal);
    if det == 0.0 || (!backfaces && det < 0.0) {
        return None;
    }
    let to_origin = origin - a;
    let q = to_origin.cross(direction);
    let (v, w, t) = (ac.dot(q) / det, -ab.dot(q) / det, to_origin.dot(normal) / det);
    let inside = v.min(w).min(1.0 - v - w);
    (t >= 0.0 && inside >= -MARGIN).then(|| ReferenceHit {
        entity,
        t,
        inside,
        edge_on: det.abs() < 1e-3 * normal.length() * direction.length() || t < 1e-3,
        local_determinant: det / direction.length(),
    })
}

/// Shapes of all kinds, rotated, stretched, mirrored and children of each other.
fn random_scene(rng: &mut ChaCha8Rng, n: usize, size: f32) -> App {
    let mut app = headless_app();
    let meshes: Vec<Handle<Mesh>> = [
        Cuboid::default().into(),
        Sphere::default().mesh().ico(2).expect("few triangles"),
        Torus::default().into(),
        Cylinder::default().into(),
        Cone::default().into(),
        Capsule3d::default().into(),
        Tetrahedron::default().into(),
        Plane3d::default().mesh().size(2.0, 2.0).into(),
        Mesh::from(Sphere::default())
            .with_duplicated_vertices()
            .with_computed_flat_normals(),
    ]
    .map(|mesh: Mesh| add_mesh(&mut app, mesh))
    .into();
    let mut last = None;
    for i in 0..n {
        let mut sign = || if rng.random_bool(0.3) { -1.0 } else { 1.0 };
        let signs = Vec3::new(sign(), sign(), sign());
        let scale = Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.2..4.0))) * signs;
        let transform = Transform {
            translation: random_point(rng, size),
            rotation: random_rotation(rng),
            scale,
        };
        let mesh = meshes[i % meshes.len()].clone();
        let mut entity = app.world_mut().spawn((Mesh3d(mesh), transform));
        if rng.random_bool(0.3) {
            entity.insert(RayCastBackfaces);
        }
        // A child of a stretched parent is sheared.
        if let Some(parent) = last.filter(|_| i % 10 == 9) {
            entity.insert((
                ChildOf(parent),
                Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(transform.rotation),
            ));
        }
        last = Some(entity.id());
    }
    app.update();
    finish_meshes(&mut app);
    app
}

#[test]
fn agrees_with_mesh_ray_cast_on_random_scenes() {
    let mut rng = rng(20);
    for scene in 0..8 {
        let mut app = random_scene(&mut rng, 250, 12.0);
        let rays: Vec<Ray3d> = (0..1000)
            .map(|_| ray_towards(random_point(&mut rng, 30.0), random_point(&mut rng, 12.0)))
            .collect();
        let tally = judge(&mut app, &rays);
        assert_eq!(tally.rays, 1000);
        assert!(tally.hits > 100, "scene {scene} is too empty to tell: {tally:?}");
        assert!(
            tally.errors() < 5,
            "more errors than are likely to be Bevy's: {tally:?}"
        );
    }
}

#[test]
fn agrees_with_mesh_ray_cast_while_hierarchies_are_being_built() {
    let mut rng = rng(21);
    let mut app = random_scene(&mut rng, 100, 10.0);
    // All meshes change, and are asked for in the same frame.
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let ids: Vec<_> = meshes.ids().collect();
    for id in ids {
        meshes.get_mut(id).expect("a mesh").scale_by(Vec3::splat(1.5));
    }
    app.update();
    let rays: Vec<Ray3d> = (0..1000)
        .map(|_| Ray3d::new(random_point(&mut rng, 15.0), random_dir(&mut rng)))
        .collect();
    let tally = judge(&mut app, &rays);
    assert!(tally.hits > 100, "{tally:?}");
}

#[test]
fn triangles_that_bevy_drops_for_being_tiny_are_hit() {
    let mut app = headless_app();
    let mut mesh = Mesh::from(Sphere::default());
    mesh = mesh.scaled_by(Vec3::splat(1e-4));
    let mesh = add_mesh(&mut app, mesh);
    app.world_mut()
        .spawn((Mesh3d(mesh), Transform::from_scale(Vec3::splat(1e4))));
    app.update();
    let rays: Vec<Ray3d> = (0..16)
        .map(|i| ray_towards(Vec3::new(5.0, 0.1, 0.07), Vec3::new(0.0, i as f32 * 0.01, 0.01)))
        .collect();
    let tally = judge(&mut app, &rays);
    assert_eq!(tally.hits, 16);
    let dropped = tally.errors.get(&BevyError::DropsTinyTriangle);
    assert_eq!(dropped, Some(&16), "Bevy has learnt to hit them: {tally:?}");
}

/// A piece of the example city: every model in `assets`, loaded through Bevy's glTF loader, many times over.
fn city(rng: &mut ChaCha8Rng) -> App {
    let mut app = headless_app_with(|app| {
        app.add_plugins((WorldSerializationPlugin, AnimationPlugin, GltfPlugin::default()));
    });
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("the assets folder")
        .map(|entry| entry.expect("a file").file_name().into_string().expect("a plain name"))
        .filter(|name| name.ends_with(".glb"))
        .collect();
    names.sort_unstable();
    assert!(names.len() >= 20, "the city has at least 20 models: {names:?}");

    let server = app.world().resource::<AssetServer>().clone();
    let handles: Vec<Handle<Gltf>> = names.into_iter().map(|name| server.load(name)).collect();
    while !handles.iter().all(|handle| server.is_loaded_with_dependencies(handle)) {
        for handle in &handles {
            let state = server.load_state(handle);
            assert!(!state.is_failed(), "{state:?}");
        }
        app.update();
    }
    let world = app.world_mut();
    let meshes: Vec<Handle<Mesh>> = handles
        .iter()
        .map(|handle| {
            let gltf = world.resource::<Assets<Gltf>>().get(handle).expect("a loaded file");
            let mesh = world
                .resource::<Assets<GltfMesh>>()
                .get(&gltf.meshes[0])
                .expect("a loaded mesh");
            mesh.primitives[0].mesh.clone()
        })
        .collect();
    for i in 0..1500 {
        let (x, z) = (i % 39, i / 39);
        let transform = Transform {
            translation: Vec3::new(x as f32 * 12.0, rng.random_range(0.0..0.2), z as f32 * 12.0),
            rotation: Quat::from_rotation_y(rng.random_range(0.0..6.0)),
            scale: Vec3::new(1.0, rng.random_range(0.5..1.5), 1.0),
        };
        world.spawn((Mesh3d(meshes[i % meshes.len()].clone()), transform));
    }
    app.update();
    finish_meshes(&mut app);
    app
}

#[test]
fn agrees_with_mesh_ray_cast_on_the_city() {
    let mut rng = rng(22);
    let mut app = city(&mut rng);
    // As from cameras: from above the roofs, and along the streets.
    let rays: Vec<Ray3d> = (0..4000)
        .map(|i| {
            let height = if i % 2 == 0 {
                rng.random_range(60.0..120.0)
            } else {
                rng.random_range(1.0..3.0)
            };
            let eye = Vec3::new(rng.random_range(0.0..468.0), height, rng.random_range(0.0..468.0));
            let target = Vec3::new(
                rng.random_range(0.0..468.0),
                rng.random_range(0.0..30.0),
                rng.random_range(0.0..468.0),
            );
            ray_towards(eye, target)
        })
        .collect();
    let tally = judge(&mut app, &rays);
    assert!(tally.hits > 2000, "{tally:?}");
    assert!(
        tally.errors() < 100,
        "more errors than are likely to be Bevy's: {tally:?}"
    );
}
