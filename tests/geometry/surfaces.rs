//! What surfaces have in common, and what each has of its own.

use std::sync::Arc;

use bevy::math::{DVec3, Dir3, Vec2, Vec3, Vec3A, bounding::Aabb3d, primitives::*};
use bevy_sightline::geometry::{
    ray::{
        Ray,
        triangle::{Backfaces, TriangleRay},
    },
    surface::{BoundedSurface, Surface, SurfaceGroup, SurfaceHit},
};
use proptest::prelude::*;

use crate::properties::{cases, coordinate, point};

fn ray(origin: impl Into<Vec3A>, direction: impl Into<Vec3A>) -> Ray {
    Ray::new(origin, direction, f32::INFINITY).expect("a sound ray")
}

fn hit(surface: &dyn Surface, origin: Vec3, direction: Vec3) -> SurfaceHit {
    surface
        .closest_hit(&ray(origin, direction), Backfaces::Cull)
        .expect("a hit")
}

fn closed_solids() -> Vec<(&'static str, Box<dyn Surface>)> {
    vec![
        ("sphere", Box::new(Sphere::new(1.0))),
        ("cuboid", Box::new(Cuboid::from_length(2.0))),
        ("cylinder", Box::new(Cylinder::new(1.0, 2.0))),
        ("capsule", Box::new(Capsule3d::new(1.0, 1.0))),
        ("cone", Box::new(Cone::new(1.0, 2.0))),
        ("frustum", Box::new(frustum(0.5, 1.0, 2.0))),
        ("upright frustum", Box::new(frustum(1.0, 0.0, 2.0))),
        ("tetrahedron", Box::new(Tetrahedron::default())),
        ("torus", Box::new(Torus::new(0.5, 1.5))),
        ("extrusion", Box::new(Extrusion::new(Circle::new(1.0), 2.0))),
    ]
}

fn frustum(radius_top: f32, radius_bottom: f32, height: f32) -> ConicalFrustum {
    ConicalFrustum {
        radius_top,
        radius_bottom,
        height,
    }
}

#[test]
fn the_direction_may_have_any_length() {
    for speed in [1e-3, 1.0, 64.0] {
        let hit = hit(&Sphere::new(1.0), Vec3::Z * 3.0, Vec3::NEG_Z * speed);
        assert_eq!(hit.t, 2.0 / speed);
        assert_eq!(hit.normal, Vec3::Z);
    }
}

#[test]
fn only_what_is_within_the_interval_of_the_ray_is_hit() {
    let sphere = Sphere::new(1.0);
    let along = ray(Vec3::Z * 3.0, Vec3::NEG_Z);
    let t = |ray: Ray| sphere.closest_hit(&ray, Backfaces::Include).map(|hit| hit.t);
    assert_eq!(t(along.with_t_max(1.9)), None);
    assert_eq!(t(along.with_t_max(2.0)), Some(2.0));
    assert_eq!(t(along.with_interval(2.1, 9.0)), Some(4.0));
    assert_eq!(t(along.with_interval(4.1, 9.0)), None);
    assert_eq!(t(along.with_interval(3.0, 2.0)), None);
}

#[test]
fn a_closed_surface_seen_from_inside_is_left_unhindered_unless_backfaces_count() {
    for (name, solid) in closed_solids() {
        let inside = if name == "torus" {
            Vec3::X
        } else {
            Vec3::new(0.01, 0.02, 0.03)
        };
        for direction in [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.3, 0.4, -0.5)] {
            let ray = ray(inside, direction);
            let hit = solid.closest_hit(&ray, Backfaces::Include).expect(name);
            assert!(hit.normal.dot(direction) > 0.0, "{name}: {hit:?}");
            let beyond = solid.closest_hit(&ray, Backfaces::Cull);
            assert!(beyond.is_none_or(|beyond| beyond.t > hit.t), "{name}: {beyond:?}");
        }
    }
}

#[test]
fn a_ray_that_starts_on_a_surface_hits_it_there_if_it_comes_from_the_front() {
    let starts = [
        ("sphere", Vec3::X),
        ("cuboid", Vec3::new(0.25, 1.0, -0.5)),
        ("cylinder", Vec3::new(0.0, 0.25, 1.0)),
        ("capsule", Vec3::new(0.0, 1.5, 0.0)),
        ("cone", Vec3::new(0.5, 0.0, 0.0)),
        ("frustum", Vec3::new(0.75, 0.0, 0.0)),
        ("torus", Vec3::new(0.0, 0.5, 1.0)),
        ("torus", Vec3::new(0.0, 0.0, 1.5)),
        ("torus", Vec3::new(0.5, 0.0, 0.0)),
        ("extrusion", Vec3::new(0.0, 1.0, 0.5)),
    ];
    for (name, start) in starts {
        let (_, solid) = closed_solids()
            .into_iter()
            .find(|(other, _)| *other == name)
            .expect(name);
        let middle = if name == "torus" {
            start.with_y(0.0).normalize()
        } else {
            Vec3::ZERO
        };
        let inward = ray(start, middle - start + Vec3::new(0.01, 0.02, 0.03));
        for backfaces in [Backfaces::Cull, Backfaces::Include] {
            let hit = solid.closest_hit(&inward, backfaces).expect(name);
            assert_eq!(hit.t, 0.0, "{name} {backfaces:?}");
        }
        let outward = ray(start, start - middle + Vec3::new(0.01, 0.02, 0.03));
        let hit = solid.closest_hit(&outward, Backfaces::Cull);
        assert!(hit.is_none_or(|hit| hit.t > 0.1), "{name} {hit:?}");
        let hit = solid.closest_hit(&outward, Backfaces::Include).expect(name);
        assert_eq!(hit.t, 0.0, "{name}");
    }
}

#[test]
fn sizes_that_are_zero_nan_or_infinite_do_no_harm() {
    let sizes = [
        0.0,
        -1.0,
        f32::NAN,
        f32::INFINITY,
        f32::MIN_POSITIVE,
        1e-45,
        f32::MAX,
        1.0,
    ];
    let rays = [
        ray(Vec3::new(3.0, 0.0, 0.0), Vec3::NEG_X),
        ray(Vec3::new(0.0, 3.0, 0.0), Vec3::NEG_Y),
        ray(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)),
        ray(Vec3::splat(3.0), Vec3::splat(-1.0)),
        ray(Vec3::splat(1e30), Vec3::splat(-1e38)),
        ray(Vec3::splat(1e-40), Vec3::splat(1e-37)),
    ];
    for a in sizes {
        for b in sizes {
            let surfaces: [Box<dyn Surface>; 19] = [
                Box::new(Sphere { radius: a }),
                Box::new(Cuboid {
                    half_size: Vec3::new(a, b, a),
                }),
                Box::new(Cylinder {
                    radius: a,
                    half_height: b,
                }),
                Box::new(Capsule3d {
                    radius: a,
                    half_length: b,
                }),
                Box::new(Cone { radius: a, height: b }),
                Box::new(frustum(a, b, 1.0)),
                Box::new(frustum(1.0, a, b)),
                Box::new(Torus {
                    minor_radius: a,
                    major_radius: b,
                }),
                Box::new(Plane3d {
                    normal: Dir3::Y,
                    half_size: Vec2::new(a, b),
                }),
                Box::new(Triangle3d::new(Vec3::X * a, Vec3::Y * b, Vec3::Z)),
                Box::new(Tetrahedron::new(Vec3::X * a, Vec3::Y * b, Vec3::Z, Vec3::ZERO)),
                extrusion(Ellipse {
                    half_size: Vec2::new(a, b),
                }),
                extrusion(Annulus {
                    inner_circle: Circle { radius: a },
                    outer_circle: Circle { radius: b },
                }),
                extrusion(Capsule2d {
                    radius: a,
                    half_length: b,
                }),
                extrusion(CircularSector {
                    arc: Arc2d {
                        radius: a,
                        half_angle: b,
                    },
                }),
                extrusion(CircularSegment {
                    arc: Arc2d {
                        radius: a,
                        half_angle: b,
                    },
                }),
                extrusion(RegularPolygon {
                    circumcircle: Circle { radius: a },
                    sides: if b == 0.0 { 0 } else { 2 },
                }),
                extrusion(Triangle2d::new(Vec2::new(a, b), Vec2::new(b, a), Vec2::ZERO)),
                extrusion(ConvexPolygon::new_unchecked([])),
            ];
            for (number, surface) in surfaces.iter().enumerate() {
                for ray in &rays {
                    for backfaces in [Backfaces::Cull, Backfaces::Include] {
                        let hit = surface.closest_hit(ray, backfaces);
                        assert_eq!(
                            surface.any_hit(ray, backfaces),
                            hit.is_some(),
                            "{number} {a} {b} {ray:?}"
                        );
                        if let Some(hit) = hit {
                            let sound = hit.t.is_finite() && hit.normal.is_finite() && hit.uv().is_finite();
                            assert!(sound, "{number} {a} {b} {ray:?} {hit:?} {}", hit.uv());
                        }
                    }
                }
                let aabb = surface.aabb();
                assert!(
                    aabb.is_none_or(|aabb| aabb.min.cmple(aabb.max).all()),
                    "{number} {a} {b} {aabb:?}"
                );
            }
        }
    }
}

fn extrusion<P: Primitive2d + Send + Sync + 'static>(base_shape: P) -> Box<dyn Surface>
where
    Extrusion<P>: Surface,
{
    Box::new(Extrusion {
        base_shape,
        half_depth: 1.0,
    })
}

#[test]
fn boxes_are_as_tight_as_they_can_be() {
    let boxes: [(Box<dyn Surface>, Vec3, Vec3); 9] = [
        (Box::new(Sphere::new(0.1)), Vec3::splat(-0.1), Vec3::splat(0.1)),
        (
            Box::new(Cone::new(1.0, 3.0)),
            Vec3::new(-1.0, -1.5, -1.0),
            Vec3::new(1.0, 1.5, 1.0),
        ),
        (
            Box::new(Capsule3d::new(1.0, 3.0)),
            Vec3::new(-1.0, -2.5, -1.0),
            Vec3::new(1.0, 2.5, 1.0),
        ),
        (
            Box::new(Torus::new(0.5, 1.5)),
            Vec3::new(-1.5, -0.5, -1.5),
            Vec3::new(1.5, 0.5, 1.5),
        ),
        (
            Box::new(Plane3d::default()),
            Vec3::new(-0.5, 0.0, -0.5),
            Vec3::new(0.5, 0.0, 0.5),
        ),
        (Box::new(Tetrahedron::default()), Vec3::splat(-0.5), Vec3::splat(0.5)),
        (
            Box::new(Triangle3d::default()),
            Vec3::new(-0.5, -0.5, 0.0),
            Vec3::new(0.5, 0.5, 0.0),
        ),
        (
            extrusion(CircularSector::from_degrees(2.0, 60.0)),
            Vec3::new(-1.0, 0.0, -1.0),
            Vec3::new(1.0, 2.0, 1.0),
        ),
        (
            extrusion(CircularSegment::from_degrees(2.0, 240.0)),
            Vec3::new(-2.0, -1.0, -1.0),
            Vec3::new(2.0, 2.0, 1.0),
        ),
    ];
    for (surface, min, max) in boxes {
        let aabb = surface.aabb().expect("a box");
        let off = (Vec3::from(aabb.min) - min)
            .abs()
            .max((Vec3::from(aabb.max) - max).abs());
        assert!(off.max_element() < 3e-7, "{aabb:?}");
    }
}

#[test]
fn negative_sizes_count_as_their_absolute_values() {
    let ray = ray(Vec3::new(3.0, 2.0, 1.0), Vec3::new(-3.0, -2.1, -0.9));
    let pairs: [(Box<dyn Surface>, Box<dyn Surface>); 3] = [
        (Box::new(Sphere { radius: -1.0 }), Box::new(Sphere { radius: 1.0 })),
        (
            Box::new(Capsule3d {
                radius: -1.0,
                half_length: -0.5,
            }),
            Box::new(Capsule3d::new(1.0, 1.0)),
        ),
        (Box::new(Cone::new(-1.0, -2.0)), Box::new(Cone::new(1.0, 2.0))),
    ];
    for (negative, positive) in pairs {
        let hit = positive.closest_hit(&ray, Backfaces::Cull);
        assert!(hit.is_some());
        assert_eq!(negative.closest_hit(&ray, Backfaces::Cull), hit);
    }
}

#[test]
fn a_flat_cuboid_and_a_flat_cylinder_have_two_faces() {
    let solids: [&dyn Surface; 3] = [
        &Cuboid::new(2.0, 0.0, 2.0),
        &Cylinder::new(1.0, 0.0),
        &Cone::new(1.0, 0.0),
    ];
    for solid in solids {
        for side in [1.0, -1.0] {
            let hit = hit(solid, Vec3::new(0.25, side, 0.25), Vec3::NEG_Y * side);
            assert_eq!((hit.t, hit.normal), (1.0, Vec3::Y * side));
        }
    }
}

#[test]
fn a_plane_is_seen_from_its_front_only_unless_backfaces_count() {
    let planes: [&dyn Surface; 2] = [&Plane3d::default(), &InfinitePlane3d::default()];
    for plane in planes {
        assert_eq!(hit(plane, Vec3::Y, Vec3::NEG_Y).normal, Vec3::Y);
        let from_behind = ray(Vec3::NEG_Y, Vec3::Y);
        assert_eq!(plane.closest_hit(&from_behind, Backfaces::Cull), None);
        let hit = plane.closest_hit(&from_behind, Backfaces::Include).expect("a hit");
        assert_eq!((hit.t, hit.normal), (1.0, Vec3::Y));
        assert_eq!(plane.closest_hit(&ray(Vec3::NEG_X, Vec3::X), Backfaces::Include), None);
    }
}

#[test]
fn an_infinite_plane_has_no_box_and_makes_a_group_endless() {
    assert_eq!(InfinitePlane3d::default().aabb(), None);
    let mut group = SurfaceGroup::new();
    group.push(Sphere::new(1.0));
    assert!(group.aabb().is_some());
    group.push(InfinitePlane3d::default());
    assert_eq!(group.aabb(), None);
    group.push(Sphere::new(1.0));
    assert_eq!(group.aabb(), None);
    assert_eq!(hit(&group, Vec3::new(1e6, 2.0, 0.0), Vec3::NEG_Y).t, 2.0);
}

#[test]
fn an_empty_group_has_no_box_and_is_hit_by_nothing() {
    let group = SurfaceGroup::new();
    assert_eq!(group.aabb(), None);
    assert_eq!(group.closest_hit(&ray(Vec3::ZERO, Vec3::X), Backfaces::Include), None);
    assert!(!group.any_hit(&ray(Vec3::ZERO, Vec3::X), Backfaces::Include));
}

#[test]
fn of_hits_at_the_same_parameter_the_first_member_counts() {
    struct Marked(Sphere, f32);
    impl Surface for Marked {
        fn aabb(&self) -> Option<Aabb3d> {
            self.0.aabb()
        }

        fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
            let hit = self.0.closest_hit(ray, backfaces)?;
            Some(SurfaceHit::new(hit.t, hit.normal, Vec2::splat(self.1)))
        }
    }
    let group: SurfaceGroup = [0.25, 0.5, 0.75]
        .map(|mark| Marked(Sphere::new(1.0), mark))
        .into_iter()
        .collect();
    assert_eq!(hit(&group, Vec3::Z * 2.0, Vec3::NEG_Z).uv(), Vec2::splat(0.25));
}

#[test]
fn a_surface_without_an_end_is_not_put_into_its_own_box() {
    assert!(BoundedSurface::in_aabb(InfinitePlane3d::default()).is_none());
    assert!(BoundedSurface::in_aabb(Sphere::new(1.0)).is_some());
}

#[test]
fn pointers_to_surfaces_are_surfaces() {
    fn t(surface: impl Surface) -> f32 {
        hit(&surface, Vec3::Z * 3.0, Vec3::NEG_Z).t
    }
    let shared: Arc<dyn Surface> = Arc::new(Sphere::new(1.0));
    let sphere: &dyn Surface = &Sphere::new(1.0);
    assert_eq!(t(sphere), 2.0);
    assert_eq!(t(shared.clone()), 2.0);
    assert_eq!(t(Box::new(Sphere::new(1.0)) as Box<dyn Surface>), 2.0);
    assert_eq!(t(&*shared), 2.0);
}

#[test]
fn textures_lie_as_on_the_meshes() {
    let d = 0.5;
    let at = |surface: &dyn Surface, from: [f32; 3], direction: [f32; 3]| {
        let hit = hit(surface, from.into(), direction.into());
        hit.uv()
    };
    let same = |uv: Vec2, expected: [f32; 2]| assert!(uv.distance(expected.into()) < 1e-6, "{uv}, not {expected:?}");

    // SphereMeshBuilder::ico: 0.5 - azimuth / 2π, inclination / π.
    same(at(&Sphere::new(1.0), [3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), [0.5, 0.5]);
    same(at(&Sphere::new(1.0), [0.0, 0.0, 3.0], [0.0, 0.0, -1.0]), [0.25, 0.5]);
    same(
        at(&Sphere::new(1.0), [0.5, 3.0, 0.0], [0.0, -1.0, 0.0]),
        [0.5, 1.0 / 6.0],
    );
    // CuboidMeshBuilder's table: a point off the middle of each face.
    let cube = Cuboid::from_length(2.0);
    same(at(&cube, [d, 0.2, 3.0], [0.0, 0.0, -1.0]), [0.75, 0.6]);
    same(at(&cube, [d, 0.2, -3.0], [0.0, 0.0, 1.0]), [0.25, 0.4]);
    same(at(&cube, [3.0, d, 0.2], [-1.0, 0.0, 0.0]), [0.75, 0.6]);
    same(at(&cube, [-3.0, d, 0.2], [1.0, 0.0, 0.0]), [0.25, 0.4]);
    same(at(&cube, [d, 3.0, 0.2], [0.0, -1.0, 0.0]), [0.75, 0.6]);
    same(at(&cube, [d, -3.0, 0.2], [0.0, 1.0, 0.0]), [0.25, 0.4]);
    // CylinderMeshBuilder: [cos, sin] of the angle are x and z; v up. The caps are alike.
    let cylinder = Cylinder::new(1.0, 2.0);
    same(at(&cylinder, [0.0, d, 3.0], [0.0, 0.0, -1.0]), [0.25, 0.75]);
    same(at(&cylinder, [0.0, d, -3.0], [0.0, 0.0, 1.0]), [0.75, 0.75]);
    same(at(&cylinder, [d, 3.0, 0.2], [0.0, -1.0, 0.0]), [0.75, 0.4]);
    same(at(&cylinder, [d, -3.0, 0.2], [0.0, 1.0, 0.0]), [0.75, 0.4]);
    // ConeMeshBuilder: the side from above, the base mirrored.
    let cone = Cone::new(1.0, 2.0);
    same(at(&cone, [d, 3.0, 0.2], [0.0, -1.0, 0.0]), [0.75, 0.6]);
    same(at(&cone, [d, -3.0, 0.2], [0.0, 1.0, 0.0]), [0.75, 0.4]);
    // Capsule3dMeshBuilder: position (cos, y, -sin), u = 1 - angle; the hemispheres have a quarter of the height each.
    let capsule = Capsule3d::new(1.0, 2.0);
    same(at(&capsule, [0.0, d, 3.0], [0.0, 0.0, -1.0]), [0.25, 0.625]);
    let slant = std::f32::consts::FRAC_1_SQRT_2;
    same(at(&capsule, [0.0, 3.0, slant], [0.0, -1.0, 0.0]), [0.25, 0.875]);
    same(at(&capsule, [0.0, -3.0, slant], [0.0, 1.0, 0.0]), [0.25, 0.125]);
    // TorusMeshBuilder.
    let torus = Torus::new(0.5, 1.5);
    same(at(&torus, [0.0, 3.0, 1.0], [0.0, -1.0, 0.0]), [0.25, 0.25]);
    same(
        at(&torus, [0.0, 0.0, -3.0], [0.0, 1e-3, 1.0]),
        [0.75, 0.0005 * 3.0 / std::f32::consts::PI],
    );
    // PlaneMeshBuilder: width along x, height along z.
    same(at(&Plane3d::default(), [0.25, 1.0, 0.1], [0.0, -1.0, 0.0]), [0.75, 0.6]);
    // Extrusions: the front, the back, and the mantle.
    let slab = Extrusion::new(Rectangle::new(2.0, 2.0), 2.0);
    same(at(&slab, [d, 0.2, 3.0], [0.0, 0.0, -1.0]), [0.375, 0.2]);
    same(at(&slab, [d, 0.2, -3.0], [0.0, 0.0, 1.0]), [0.875, 0.2]);
    same(at(&slab, [d, 3.0, d], [0.0, -1.0, 0.0]), [0.0625, 0.625]);
    let disc = Extrusion::new(Circle::new(1.0), 2.0);
    same(at(&disc, [-3.0, 0.0, d], [1.0, 0.0, 0.0]), [0.25, 0.625]);
    let ring = Extrusion::new(Annulus::new(0.5, 1.0), 2.0);
    same(at(&ring, [-0.75, 0.0, 3.0], [0.0, 0.0, -1.0]), [0.25, 0.125]);
    same(at(&ring, [-3.0, 0.0, d], [1.0, 0.0, 0.0]), [0.625, 0.625]);
    same(at(&ring, [0.0, 0.0, d], [-1.0, 0.0, 0.0]), [0.375, 0.625]);
    let stadium = Extrusion::new(Capsule2d::new(1.0, 2.0), 2.0);
    same(at(&stadium, [0.0, 3.0, 0.0], [0.0, -1.0, 0.0]), [0.125, 0.75]);
    same(at(&stadium, [-3.0, d, 0.0], [1.0, 0.0, 0.0]), [0.3125, 0.75]);
    same(at(&stadium, [0.0, -3.0, 0.0], [0.0, 1.0, 0.0]), [0.625, 0.75]);
    same(at(&stadium, [3.0, d, 0.0], [-1.0, 0.0, 0.0]), [0.9375, 0.75]);
    let pie = Extrusion::new(CircularSector::from_radians(1.0, std::f32::consts::PI), 2.0);
    same(at(&pie, [0.0, 3.0, 0.0], [0.0, -1.0, 0.0]), [0.75, 0.75]);
    same(at(&pie, [-0.5, -3.0, 0.0], [0.0, 1.0, 0.0]), [0.125, 0.75]);
    same(at(&pie, [0.5, -3.0, 0.0], [0.0, 1.0, 0.0]), [0.375, 0.75]);
}

#[test]
fn a_plane_lies_as_its_mesh_does_whichever_way_it_looks() {
    use bevy::math::Quat;
    let normals = [
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::X,
        Vec3::NEG_Z,
        Vec3::new(1.0, -2.0, 3.0),
        Vec3::new(1e-2, -1.0, 0.0),
        Vec3::new(1e-5, -1.0, 1e-5),
    ];
    for normal in normals.map(|normal| Dir3::new(normal).expect("not zero")) {
        let plane = Plane3d {
            normal,
            half_size: Vec2::new(2.0, 1.0),
        };
        // PlaneMeshBuilder::build.
        let rotation = Quat::from_rotation_arc(Vec3::Y, *normal);
        for expected in [Vec2::new(0.1, 0.2), Vec2::new(0.9, 0.5), Vec2::new(0.01, 0.99)] {
            let point = rotation * Vec3::new((expected.x - 0.5) * 4.0, 0.0, (expected.y - 0.5) * 2.0);
            let uv = hit(&plane, point + *normal, -*normal).uv();
            assert!(uv.distance(expected) < 1e-4, "{normal:?}: {uv}, not {expected}");
        }
    }
}

#[test]
fn the_cavity_of_a_spindle_torus_is_left_through_the_front_of_the_lemon() {
    let spindle = Torus {
        minor_radius: 2.0,
        major_radius: 1.0,
    };
    // Along the x axis: the apple at ±3, the lemon at ±1.
    let across = ray(Vec3::X * 5.0, Vec3::NEG_X);
    let hits = |t_min: f32, backfaces| {
        spindle
            .closest_hit(&across.with_interval(t_min, f32::INFINITY), backfaces)
            .map(|hit| (hit.t, hit.normal))
    };
    assert_eq!(hits(0.0, Backfaces::Cull), Some((2.0, Vec3::X)));
    assert_eq!(hits(2.5, Backfaces::Include), Some((4.0, Vec3::NEG_X)));
    assert_eq!(hits(2.5, Backfaces::Cull), Some((6.0, Vec3::X)));
    assert_eq!(hits(6.5, Backfaces::Include), Some((8.0, Vec3::NEG_X)));
    assert_eq!(hits(6.5, Backfaces::Cull), None);
}

#[test]
fn a_horn_torus_is_hit_through_its_closed_hole() {
    let horn = Torus {
        minor_radius: 1.0,
        major_radius: 1.0,
    };
    let down = ray(Vec3::new(0.25, 3.0, 0.0), Vec3::NEG_Y);
    let hit = horn.closest_hit(&down, Backfaces::Cull).expect("a hit");
    let height = (1.0f32 - 0.75 * 0.75).sqrt();
    assert!((hit.t - (3.0 - height)).abs() < 1e-6);
}

#[test]
fn a_ray_through_the_hole_of_a_torus_misses_it() {
    let torus = Torus::new(0.5, 1.5);
    for offset in [0.0, 0.25, 0.49] {
        assert!(!torus.any_hit(&ray(Vec3::new(offset, 3.0, 0.0), Vec3::NEG_Y), Backfaces::Include));
    }
}

#[test]
fn a_flat_tetrahedron_is_missed() {
    let flat = Tetrahedron::new(Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.0, 1.0));
    assert!(!flat.any_hit(&ray(Vec3::new(0.3, 1.0, 0.3), Vec3::NEG_Y), Backfaces::Include));
}

/// What a ray aims at from outside, and a point well inside on the other side.
fn aimed(edge: DVec3, inside: DVec3, distance: f64) -> Ray {
    let origin = (edge + (edge - inside) * distance).as_vec3();
    ray(origin, edge.as_vec3() - origin)
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn no_ray_slips_through_the_edges_and_vertices_of_a_tetrahedron(
        vertices in [point(), point(), point(), point()],
        weights in [0.0f64..1.0, 0.0f64..1.0],
        corner in 0usize..4,
        distance in 0.1f64..10.0,
    ) {
        let [a, b, c, d] = vertices.map(|vertex| Vec3::from(vertex).as_dvec3());
        let size = [a, b, c, d].iter().fold(0.0f64, |size, vertex| size.max(vertex.length()));
        prop_assume!((b - a).cross(c - a).dot(d - a).abs() > 1e-3 * size.powi(3));
        let tetrahedron = Tetrahedron { vertices: vertices.map(Vec3::from) };
        let inside = (a + b + c + d) / 4.0;
        let [from, to] = [corner, (corner + 1) % 4].map(|i| [a, b, c, d][i]);
        let edge = from.lerp(to, if weights[1] < 0.3 { 0.0 } else { weights[0] });
        prop_assert!(tetrahedron.any_hit(&aimed(edge, inside, distance), Backfaces::Cull));
    }

    #[test]
    fn no_ray_slips_through_the_rims_and_the_apex_of_a_solid_of_revolution(
        sizes in [0.01f32..10.0, 0.01f32..10.0, 0.1f32..10.0],
        angle in 0.0f64..6.3,
        top: bool,
        pointed: bool,
        distance in 0.1f64..1e4,
    ) {
        let [radius_bottom, radius_top, height] = sizes;
        let solid = frustum(if pointed { 0.0 } else { radius_top }, radius_bottom, height);
        let (radius, y) = if top { (solid.radius_top, 0.5) } else { (radius_bottom, -0.5) };
        let (sin, cos) = angle.sin_cos();
        let rim = DVec3::new(f64::from(radius) * cos, y * f64::from(height), f64::from(radius) * sin);
        prop_assert!(solid.any_hit(&aimed(rim, DVec3::new(0.0, -0.25 * f64::from(height), 0.0), distance), Backfaces::Cull));
        let cylinder = Cylinder::new(radius_bottom, height);
        let radius = f64::from(radius_bottom);
        let rim = DVec3::new(radius * cos, y * f64::from(height), radius * sin);
        prop_assert!(cylinder.any_hit(&aimed(rim, DVec3::ZERO, distance), Backfaces::Cull));
        let capsule = Capsule3d::new(radius_bottom, height);
        prop_assert!(capsule.any_hit(&aimed(rim, DVec3::ZERO, distance), Backfaces::Cull));
    }

    #[test]
    fn a_triangle_is_hit_as_those_of_meshes_are_unless_rounding_decides(
        vertices in [point(), point(), point()],
        origin in point(),
        weights in [-0.5f32..1.5, -0.5f32..1.5],
        include: bool,
    ) {
        let backfaces = if include { Backfaces::Include } else { Backfaces::Cull };
        let target = vertices[0].lerp(vertices[1], weights[0]).lerp(vertices[2], weights[1]);
        prop_assume!(target != origin);
        let ray = ray(origin, target - origin);
        let triangle = Triangle3d { vertices: vertices.map(Vec3::from) };
        let hit = triangle.closest_hit(&ray, backfaces);
        prop_assert_eq!(triangle.any_hit(&ray, backfaces), hit.is_some());

        let [a, b, c] = triangle.vertices.map(Vec3::as_dvec3);
        let (from, along) = (Vec3::from(origin).as_dvec3(), Vec3::from(ray.direction()).as_dvec3());
        let normal = (b - a).cross(c - a);
        let facing = -normal.dot(along) / (normal.length() * along.length());
        prop_assume!(facing.abs() > 1e-2);
        let t = normal.dot(a - from) / normal.dot(along);
        let point = from + along * t;
        let weight = |p: DVec3, q: DVec3| (p - point).cross(q - point).dot(normal) / normal.length_squared();
        let weights = DVec3::new(weight(b, c), weight(c, a), weight(a, b));
        if weights.abs().min_element() > 1e-2 && t.abs() > 1e-3 {
            let expected = weights.min_element() > 0.0 && t > 0.0 && (include || facing > 0.0);
            prop_assert_eq!(hit.is_some(), expected);
            let mesh = TriangleRay::new(&ray).triangle_intersection(vertices, f32::INFINITY, backfaces);
            prop_assert_eq!(mesh.is_some(), expected);
        }
        if let Some(hit) = hit {
            prop_assert!((f64::from(hit.t) - t).abs() <= t * 1.0001 * f64::from(f32::EPSILON) / 2.0);
            prop_assert!(hit.normal.as_dvec3().distance(normal.normalize()) < 1e-6);
        }
    }

    #[test]
    fn no_ray_slips_between_two_triangles(
        vertices in [point(), point(), point(), point()],
        weight in 0.0f32..1.0,
        origin in point(),
        distance in prop_oneof![Just(1.0f32), Just(10.0f32)],
    ) {
        let [a, b, c, d] = vertices.map(|vertex| Vec3::from(vertex).as_dvec3());
        let target = vertices[0].lerp(vertices[1], weight);
        let origin = target + (origin - target) * distance;
        prop_assume!(target != origin);
        // On the side of the plane through the edge and the ray where one triangle is, the other is not.
        let along = Vec3::from(target - origin).as_dvec3();
        let across = (b - a).cross(along);
        // Along the edge, the rounding of the ray decides which end it passes, and on which side.
        prop_assume!(across.length() > 1e-2 * (b - a).length() * along.length());
        let across = across.normalize();
        let size = (b - a).length() + (c - a).length() + (d - a).length();
        let sides = [across.dot(c - a), across.dot(d - a)];
        prop_assume!(sides[0] * sides[1] < 0.0 && sides[0].abs().min(sides[1].abs()) > 1e-2 * size);
        // Away from the ends of the edge: there the ray may pass beside both.
        prop_assume!(a.distance(b) > 1e-2 * size && (0.05..0.95).contains(&weight));
        let ray = ray(origin, target - origin);
        let [a, b, c, d] = vertices.map(Vec3::from);
        let hit = |vertices| Triangle3d { vertices }.any_hit(&ray, Backfaces::Include);
        prop_assert!(hit([a, b, c]) || hit([b, a, d]));
    }

    #[test]
    fn a_bounded_surface_and_a_nested_group_are_hit_as_the_surfaces_one_by_one(
        centers in prop::collection::vec((point(), 0.1f32..30.0), 1..12),
        origin in point(),
        target in point(),
        include: bool,
        split in 0usize..12,
        t_max in prop_oneof![Just(f32::INFINITY), 0.0f32..2.0],
    ) {
        prop_assume!(origin != target);
        let backfaces = if include { Backfaces::Include } else { Backfaces::Cull };
        let ray = ray(origin, target - origin).with_t_max(t_max);
        let one_by_one = centers
            .iter()
            .filter_map(|&(center, size)| shard(center, size).closest_hit(&ray, backfaces))
            .fold(None, |best: Option<SurfaceHit>, hit| Some(best.filter(|best| best.t <= hit.t).unwrap_or(hit)));

        let shards = || centers.iter().map(|&(center, size)| shard(center, size));
        let flat: SurfaceGroup = shards().collect();
        let bounded: SurfaceGroup = shards().map(|shard| BoundedSurface::in_aabb(shard).expect("a box")).collect();
        let split = split.min(centers.len());
        let mut nested = SurfaceGroup::new();
        nested.push(shards().take(split).collect::<SurfaceGroup>());
        nested.push(Arc::new(BoundedSurface::in_aabb(shards().skip(split).collect::<SurfaceGroup>()).map_or_else(
            || Box::new(SurfaceGroup::new()) as Box<dyn Surface>,
            |group| Box::new(group) as Box<dyn Surface>,
        )));
        for group in [flat, bounded, nested] {
            prop_assert_eq!(group.closest_hit(&ray, backfaces), one_by_one);
            prop_assert_eq!(group.any_hit(&ray, backfaces), one_by_one.is_some());
        }
    }

    #[test]
    fn a_plane_is_hit_on_its_rectangle(
        normal in crate::properties::direction(),
        half_size in [0.01f32..10.0, 0.01f32..10.0],
        origin in point(),
        target in [coordinate(), coordinate()],
    ) {
        let normal = Dir3::new(normal.into()).expect("a unit vector");
        let plane = Plane3d { normal, half_size: half_size.into() };
        let [x, z] = target;
        let aim = normal.any_orthonormal_pair();
        let target = (aim.0 * x + aim.1 * z) * 0.2;
        prop_assume!(Vec3::from(origin).distance(target) > 1e-3);
        let ray = ray(origin, Vec3A::from(target) - origin);
        if let Some(hit) = plane.closest_hit(&ray, Backfaces::Include) {
            let point = Vec3::from(ray.origin()).as_dvec3() + Vec3::from(ray.direction()).as_dvec3() * f64::from(hit.t);
            let rounding = f64::from(hit.t) * f64::from(ray.direction().length()) * 6e-8 + 1e-9;
            prop_assert!(point.dot(normal.as_dvec3()).abs() <= rounding);
            prop_assert!(point.length() <= f64::from(plane.half_size.length()) * (1.0 + 1e-6) + 2.0 * rounding);
            let aabb = plane.aabb().expect("a box");
            prop_assert!(ray.aabb_intersection_at(&aabb).is_some_and(|enter| enter <= hit.t));
            let front = normal.as_dvec3().dot(Vec3::from(ray.direction()).as_dvec3()) < 0.0;
            prop_assert_eq!(plane.any_hit(&ray, Backfaces::Cull), front);
        }
    }
}

/// A surface away from the origin.
fn shard(center: Vec3A, size: f32) -> Tetrahedron {
    let center = Vec3::from(center);
    Tetrahedron {
        vertices: Tetrahedron::default().vertices.map(|vertex| center + vertex * size),
    }
}

#[test]
fn an_annulus_is_not_left_where_the_ray_grazes_its_hole() {
    let ring = Extrusion::new(Annulus::new(1.0, 2.0), 2.0);
    let hit = ring.closest_hit(&ray([1.0, -0.5, 0.0], [0.0, 1.0, 0.0]), Backfaces::Include);
    assert!(hit.is_some_and(|hit| (hit.t - 2.232_051).abs() < 1e-6), "{hit:?}");
}

#[test]
fn a_ray_that_starts_on_a_sphere_hits_it_there_whichever_way_it_enters() {
    let steps = || (-5..=5).map(|step| step as f32);
    for (x, y, z) in steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| (x, y, z)))) {
        let direction = Vec3A::new(0.1 * x, 0.3 * y, 0.7 * z);
        for start in [[3.0, 4.0, 0.0], [0.0, -3.0, 4.0], [-4.0, 0.0, 3.0]].map(Vec3A::from_array) {
            if direction.dot(start) < 0.0 {
                let hit = Sphere::new(5.0).closest_hit(&ray(start, direction), Backfaces::Cull);
                assert_eq!(hit.map(|hit| hit.t), Some(0.0), "{start:?} {direction:?}");
            }
        }
    }
}

#[test]
fn the_normal_of_a_sphere_that_is_hit_from_very_far_is_a_unit_vector() {
    for step in 1..20 {
        let direction = Vec3A::new(-1024.0, step as f32, 3.0);
        // In steps of a power of two, so that the ray passes the centre as closely as its digits allow.
        let origin = direction * -(2f32.powi(34));
        let hit = Sphere::new(1.0)
            .closest_hit(&ray(origin, direction), Backfaces::Cull)
            .expect("a hit");
        assert!((hit.normal.as_dvec3().length() - 1.0).abs() < 1e-6, "{hit:?}");
    }
}

#[test]
fn a_long_capsule_is_hit_from_very_far_away_from_its_middle() {
    let direction = Vec3A::new(1.0, -0.5, 0.0);
    let origin = Vec3A::new(0.0, 900.0, 0.0) - direction * 8_388_608.0;
    let capsule = Capsule3d::new(1.0, 2000.0);
    assert!(capsule.any_hit(&ray(origin, direction), Backfaces::Cull));
}
