//! Every primitive as a surface, against an implicit function of its solid in double precision.

use std::f64::consts::{PI, TAU};

use bevy::math::{DVec2, DVec3, Vec2, Vec3, primitives::*};
use bevy_sightline::geometry::{
    ray::{Ray, triangle::Backfaces},
    surface::Surface,
};
use proptest::prelude::*;

use crate::properties::cases;

/// A surface, and what it bounds: negative inside, zero on the surface, and nowhere steeper than 1.
pub struct Solid {
    pub name: &'static str,
    pub surface: Box<dyn Surface>,
    pub implicit: Box<dyn Fn(DVec3) -> f64>,
    /// How far it reaches from the origin.
    pub size: f64,
}

const SOLIDS: usize = 26;

/// The solid with a number below [`SOLIDS`], with sizes from the list times the scale.
fn solid(number: usize, sizes: [f32; 4], scale: f32) -> Solid {
    let sizes = sizes.map(|size| size * scale);
    let [a, b, c, d] = sizes;
    let [fa, fb, fc, fd] = sizes.map(f64::from);
    let size = 3.0 * (fa + fb + fc + fd);
    let make = |name, surface: Box<dyn Surface>, implicit: Box<dyn Fn(DVec3) -> f64>| Solid {
        name,
        surface,
        implicit,
        size,
    };
    let flat = |p: DVec3| DVec2::new(p.x, p.z).length();
    match number {
        0 => make("sphere", Box::new(Sphere::new(a)), Box::new(move |p| p.length() - fa)),
        1 => make(
            "cuboid",
            Box::new(Cuboid::from_size(2.0 * Vec3::new(a, b, c))),
            Box::new(move |p| (p.abs() - DVec3::new(fa, fb, fc)).max_element()),
        ),
        2 => make(
            "cylinder",
            Box::new(Cylinder {
                radius: a,
                half_height: b,
            }),
            Box::new(move |p| (flat(p) - fa).max(p.y.abs() - fb)),
        ),
        3 => make(
            "capsule",
            Box::new(Capsule3d {
                radius: a,
                half_length: b,
            }),
            Box::new(move |p| (p - DVec3::Y * p.y.clamp(-fb, fb)).length() - fa),
        ),
        4 => make("cone", Box::new(Cone { radius: a, height: b }), frustum(fa, 0.0, fb)),
        5..=8 => {
            let (bottom, top) = [(a, c), (c, a), (a, a), (0.0, a)][number - 5];
            make(
                "frustum",
                Box::new(ConicalFrustum {
                    radius_bottom: bottom,
                    radius_top: top,
                    height: b,
                }),
                frustum(bottom.into(), top.into(), fb),
            )
        }
        9 | 10 => {
            let (major_radius, minor_radius) = if number == 9 { (a + b, b) } else { (a, a * 0.01) };
            let (major, minor) = (f64::from(major_radius), f64::from(minor_radius));
            make(
                "torus",
                Box::new(Torus {
                    major_radius,
                    minor_radius,
                }),
                Box::new(move |p| DVec2::new(flat(p) - major, p.y).length() - minor),
            )
        }
        11 => {
            let vertices = [
                Vec3::new(a, -b, c),
                Vec3::new(-b, -c, d),
                Vec3::new(d, -a, -b),
                Vec3::new(0.0, c, 0.0),
            ];
            make(
                "tetrahedron",
                Box::new(Tetrahedron { vertices }),
                tetrahedron(vertices.map(Vec3::as_dvec3)),
            )
        }
        12 => make(
            "turned tetrahedron",
            Box::new(Tetrahedron {
                vertices: [Vec3::X * a, Vec3::Y * b, Vec3::Z * c, Vec3::splat(d)],
            }),
            tetrahedron([DVec3::X * fa, DVec3::Y * fb, DVec3::Z * fc, DVec3::splat(fd)]),
        ),
        13 => extrusion("circle", Circle::new(a), d, size, move |p| p.length() - fa),
        14 => extrusion("ellipse", Ellipse::new(a, b), d, size, move |p| {
            ((p / DVec2::new(fa, fb)).length() - 1.0) * fa.min(fb)
        }),
        15 => {
            let annulus = Annulus {
                inner_circle: Circle::new(a),
                outer_circle: Circle::new(a + b),
            };
            let outer = f64::from(a + b);
            extrusion("annulus", annulus, d, size, move |p| {
                (p.length() - outer).max(fa - p.length())
            })
        }
        16 => extrusion("rectangle", Rectangle::new(2.0 * a, 2.0 * b), d, size, move |p| {
            (p.abs() - DVec2::new(fa, fb)).max_element()
        }),
        17 => extrusion("rhombus", Rhombus::new(2.0 * a, 2.0 * b), d, size, move |p| {
            (p.x.abs() / fa + p.y.abs() / fb - 1.0) / (fa.recip().hypot(fb.recip()))
        }),
        18 => {
            let triangle = Triangle2d::new(Vec2::new(a, b), Vec2::new(-c, a), Vec2::new(b, -c));
            let vertices = triangle.vertices.map(Vec2::as_dvec2);
            extrusion("triangle", triangle, d, size, move |p| polygon(&vertices, p))
        }
        19 => {
            let triangle = Triangle2d::new(Vec2::new(b, -c), Vec2::new(-c, a), Vec2::new(a, b));
            let [x, y, z] = triangle.vertices.map(Vec2::as_dvec2);
            extrusion("turned triangle", triangle, d, size, move |p| polygon(&[z, y, x], p))
        }
        20 => {
            let sides = 3 + (b / scale * 10.0) as u32;
            let vertices: Vec<DVec2> = (0..sides)
                .map(|side| DVec2::from_angle(TAU * (0.25 + f64::from(side) / f64::from(sides))) * fa)
                .collect();
            extrusion("regular polygon", RegularPolygon::new(a, sides), d, size, move |p| {
                polygon(&vertices, p)
            })
        }
        21 => extrusion(
            "capsule",
            Capsule2d {
                radius: a,
                half_length: b,
            },
            d,
            size,
            move |p| (p - DVec2::Y * p.y.clamp(-fb, fb)).length() - fa,
        ),
        22 | 23 => {
            let half_angle = (b / scale / 2.0 * std::f32::consts::PI).min(3.1);
            let (sin, cos) = f64::from(half_angle).sin_cos();
            let (left, right) = (DVec2::new(-cos, -sin), DVec2::new(cos, -sin));
            if number == 22 {
                extrusion("sector", CircularSector::new(a, half_angle), d, size, move |p| {
                    let (left, right) = (left.dot(p), right.dot(p));
                    let wedge = if f64::from(half_angle) > PI / 2.0 {
                        left.min(right)
                    } else {
                        left.max(right)
                    };
                    (p.length() - fa).max(wedge)
                })
            } else {
                extrusion("segment", CircularSegment::new(a, half_angle), d, size, move |p| {
                    (p.length() - fa).max(fa * cos - p.y)
                })
            }
        }
        24 => {
            let [a, b, c, _] = sizes.map(|size| size / scale);
            let vertices = [
                Vec2::new(a, 0.0),
                Vec2::new(b * 0.5, c),
                Vec2::new(-a, b),
                Vec2::new(-c, -a),
                Vec2::new(b * 0.1, -c - a),
            ];
            // Bevy takes tiny polygons for concave ones.
            if ConvexPolygon::new(vertices).is_err() {
                return solid(16, [a, b, c, d / scale], scale);
            }
            let vertices = vertices.map(|vertex| vertex * scale);
            let hull = vertices.map(Vec2::as_dvec2);
            let convex = ConvexPolygon::new_unchecked(vertices);
            extrusion("convex polygon", convex, d, size, move |p| polygon(&hull, p))
        }
        _ => {
            let ring = Ring::new(
                Rectangle::new(2.0 * (a + c), 2.0 * (b + c)),
                Rectangle::new(2.0 * a, 2.0 * b),
            );
            let outer = ring.outer_shape.half_size.as_dvec2();
            extrusion("ring", ring, d, size, move |p| {
                (p.abs() - outer)
                    .max_element()
                    .max(-(p.abs() - DVec2::new(fa, fb)).max_element())
            })
        }
    }
}

fn frustum(bottom: f64, top: f64, height: f64) -> Box<dyn Fn(DVec3) -> f64> {
    let slope = (top - bottom) / height;
    Box::new(move |p| {
        let radius = 0.5 * (bottom + top) + slope * p.y;
        let side = (DVec2::new(p.x, p.z).length() - radius) / slope.hypot(1.0);
        side.max(p.y.abs() - 0.5 * height)
    })
}

fn tetrahedron(vertices: [DVec3; 4]) -> Box<dyn Fn(DVec3) -> f64> {
    Box::new(move |p| {
        (0..4).fold(f64::NEG_INFINITY, |far, apex| {
            let face: Vec<DVec3> = (0..4).filter(|&i| i != apex).map(|i| vertices[i]).collect();
            let normal = (face[1] - face[0]).cross(face[2] - face[0]).normalize();
            let inward = normal.dot(vertices[apex] - face[0]).signum();
            far.max(-inward * normal.dot(p - face[0]))
        })
    })
}

fn polygon(vertices: &[DVec2], p: DVec2) -> f64 {
    (0..vertices.len()).fold(f64::NEG_INFINITY, |far, i| {
        let (from, to) = (vertices[i], vertices[(i + 1) % vertices.len()]);
        let side = (to - from).normalize();
        far.max((p - from).perp_dot(side))
    })
}

fn extrusion<P: Primitive2d + Send + Sync + 'static>(
    name: &'static str,
    base_shape: P,
    half_depth: f32,
    size: f64,
    outline: impl Fn(DVec2) -> f64 + 'static,
) -> Solid
where
    Extrusion<P>: Surface,
{
    let depth = f64::from(half_depth);
    Solid {
        name,
        surface: Box::new(Extrusion { base_shape, half_depth }),
        implicit: Box::new(move |p| outline(p.truncate()).max(p.z.abs() - depth)),
        size,
    }
}

fn solids() -> impl Strategy<Value = Solid> {
    let size = prop_oneof![4 => 0.1f32..2.0, 1 => Just(1.0f32), 1 => Just(0.5f32)];
    let scale = prop_oneof![4 => Just(1.0f32), 1 => Just(1e-6f32), 1 => Just(1e-20f32), 1 => Just(1e7f32)];
    (0..SOLIDS, [size.clone(), size.clone(), size.clone(), size], scale)
        .prop_map(|(number, sizes, scale)| solid(number, sizes, scale))
}

impl std::fmt::Debug for Solid {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} of size {}", self.name, self.size)
    }
}

/// Directions, at times with zeros.
fn direction() -> impl Strategy<Value = Vec3> {
    prop_oneof![
        3 => [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(Vec3::from_array),
        1 => [-1i8..=1, -1i8..=1, -1i8..=1].prop_map(|v| Vec3::from_array(v.map(f32::from))),
    ]
    .prop_filter("not zero", |v| v.length() > 0.1)
}

/// A solid, and a ray that passes close to it or through it, from inside, from close by, and from far away.
fn solid_and_ray() -> impl Strategy<Value = (Solid, Ray)> {
    let distance = prop_oneof![2 => 0.0f32..0.2, 4 => 0.2f32..3.0, 1 => Just(100.0f32), 1 => Just(1e5f32)];
    let target = prop_oneof![
        4 => [-0.2f32..0.2, -0.2f32..0.2, -0.2f32..0.2].prop_map(Vec3::from_array),
        1 => Just(Vec3::ZERO),
    ];
    let speed = prop_oneof![2 => Just(1.0f32), 1 => 1e-3f32..1e3];
    (solids(), direction(), distance, target, speed).prop_map(|(solid, direction, distance, target, speed)| {
        let size = solid.size as f32;
        let origin = (target - direction.normalize() * distance) * size;
        let ray = Ray::new(origin, direction * (speed * size), f32::INFINITY).expect("a sound ray");
        (solid, ray)
    })
}

struct Oracle<'a> {
    solid: &'a Solid,
    origin: DVec3,
    direction: DVec3,
}

impl Oracle<'_> {
    fn value(&self, t: f64) -> f64 {
        (self.solid.implicit)(self.origin + self.direction * t)
    }

    /// Points along the ray where it is close to the solid, which are clearly inside or clearly outside: the parameter,
    /// and whether inside.
    fn samples(&self) -> impl Iterator<Item = (f64, bool)> {
        let nearest = -self.origin.dot(self.direction) / self.direction.length_squared();
        let reach = 2.0 * self.solid.size / self.direction.length();
        let (from, to) = ((nearest - reach).max(0.0), nearest + reach);
        let clear = 1e-9 * self.solid.size + 1e-13 * self.origin.length();
        // The value is nowhere steeper than 1: nothing happens within that distance.
        let next = move |t: &f64| {
            let step = self.value(*t).abs().max(SHORTEST * self.solid.size) / self.direction.length();
            Some(t + step).filter(|&t| t <= to)
        };
        std::iter::successors((from <= to).then_some(from), next).filter_map(move |t| {
            let value = self.value(t);
            (value.abs() > clear).then_some((t, value < 0.0))
        })
    }
}

/// The shortest step along a ray, in sizes of the solid: what is thinner may be missed.
const SHORTEST: f64 = 5e-4;

fn oracle<'a>(solid: &'a Solid, ray: &Ray) -> Oracle<'a> {
    Oracle {
        solid,
        origin: Vec3::from(ray.origin()).as_dvec3(),
        direction: Vec3::from(ray.direction()).as_dvec3(),
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_hit_is_on_the_surface_to_one_unit_in_the_last_place((solid, ray) in solid_and_ray(), include: bool) {
        let backfaces = if include { Backfaces::Include } else { Backfaces::Cull };
        if let Some(hit) = solid.surface.closest_hit(&ray, backfaces) {
            let oracle = oracle(&solid, &ray);
            let (t, speed) = (f64::from(hit.t), oracle.direction.length());
            let rounding = t * speed * f64::from(f32::EPSILON) / 2.0 + 1e-13 * oracle.origin.length();
            let off = oracle.value(t).abs();
            prop_assert!(off <= rounding + 1e-11 * solid.size, "{off} off, {hit:?}");
        }
    }

    #[test]
    fn the_first_change_of_sides_is_the_hit((solid, ray) in solid_and_ray(), include: bool) {
        let backfaces = if include { Backfaces::Include } else { Backfaces::Cull };
        let oracle = oracle(&solid, &ray);
        let mut before: Option<(f64, bool)> = None;
        let mut change = None;
        for (t, inside) in oracle.samples() {
            if let Some((_, was_inside)) = before
                && was_inside != inside
                && (inside || include)
            {
                change = Some(t);
                break;
            }
            before = Some((t, inside));
        }
        let hit = solid.surface.closest_hit(&ray, backfaces);
        if let Some(until) = change {
            let hit = hit.ok_or_else(|| TestCaseError::fail("missed"))?;
            prop_assert!(f64::from(hit.t) <= until * (1.0 + 1e-6), "{} after {until}", hit.t);
        } else if let Some(hit) = hit {
            // Too short a stretch for the samples: then the middle of it is next to the hit.
            let step = SHORTEST * solid.size / oracle.direction.length();
            let close = (0..=4000).any(|i| {
                let t = f64::from(hit.t) + step * (f64::from(i) / 2000.0 - 1.0);
                oracle.value(t) <= f64::from(hit.t) * oracle.direction.length() * 1.2e-7 + 1e-9 * solid.size
            });
            prop_assert!(close, "{hit:?} where there is nothing");
        }
    }

    #[test]
    fn the_normal_is_the_unit_gradient_and_the_uv_in_the_texture((solid, ray) in solid_and_ray(), include: bool) {
        let backfaces = if include { Backfaces::Include } else { Backfaces::Cull };
        if let Some(hit) = solid.surface.closest_hit(&ray, backfaces) {
            prop_assert!((hit.normal.length() - 1.0).abs() < 4e-7, "{hit:?}");
            let uv = hit.uv();
            prop_assert!(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all(), "{uv}");
            let facing = hit.normal.as_dvec3().dot(Vec3::from(ray.direction()).as_dvec3());
            let oracle = oracle(&solid, &ray);
            if !include {
                prop_assert!(facing <= 1e-6 * oracle.direction.length());
            }
            if oracle.origin.length() < 4.0 * solid.size {
                let point = oracle.origin + oracle.direction * f64::from(hit.t);
                let step = 1e-5 * solid.size;
                let gradient = |step: f64| {
                    DVec3::from_array([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
                        ((solid.implicit)(point + axis * step) - (solid.implicit)(point - axis * step)) / (2.0 * step)
                    }))
                };
                let (near, far) = (gradient(step), gradient(3.0 * step));
                // Where the gradient jumps or turns fast, at an edge or a tip, there is more than one normal, and it is not of unit
                // length.
                if near.distance(far) < 1e-3 && near.length() > 0.1 && (solid.name == "ellipse" && near.z.abs() < 1e-6 || (0.999_999..1.000_001).contains(&near.length())) {
                    let off = near.normalize().distance(hit.normal.as_dvec3());
                    prop_assert!(off < 2e-3, "{off} off: {hit:?}, {near}");
                }
            }
        }
    }

    #[test]
    fn there_is_any_hit_exactly_if_there_is_a_closest((solid, ray) in solid_and_ray(), include: bool, t_max in 0.0f32..4.0) {
        let backfaces = if include { Backfaces::Include } else { Backfaces::Cull };
        for ray in [ray, ray.with_t_max(t_max)] {
            prop_assert_eq!(
                solid.surface.any_hit(&ray, backfaces),
                solid.surface.closest_hit(&ray, backfaces).is_some()
            );
        }
    }

    #[test]
    fn a_ray_that_ends_at_its_hit_still_hits_there((solid, ray) in solid_and_ray(), include: bool) {
        let backfaces = if include { Backfaces::Include } else { Backfaces::Cull };
        if let Some(hit) = solid.surface.closest_hit(&ray, backfaces) {
            prop_assert_eq!(solid.surface.closest_hit(&ray.with_t_max(hit.t), backfaces), Some(hit));
            prop_assert_eq!(solid.surface.closest_hit(&ray.with_interval(hit.t, f32::INFINITY), backfaces), Some(hit));
        }
    }

    #[test]
    fn the_box_contains_every_hit_and_is_met_by_every_ray_with_one((solid, ray) in solid_and_ray()) {
        let aabb = solid.surface.aabb().expect("a solid has an end");
        if let Some(hit) = solid.surface.closest_hit(&ray, Backfaces::Include) {
            prop_assert!(ray.aabb_intersection_at(&aabb).is_some_and(|enter| enter <= hit.t));
            let oracle = oracle(&solid, &ray);
            let point = oracle.origin + oracle.direction * f64::from(hit.t);
            let slack = f64::from(hit.t) * oracle.direction.length() * 1e-7 + 1e-11 * solid.size;
            let (min, max) = (Vec3::from(aabb.min).as_dvec3(), Vec3::from(aabb.max).as_dvec3());
            prop_assert!((min - point).max_element() <= slack && (point - max).max_element() <= slack);
        }
    }

    #[test]
    fn shapes_and_rays_scaled_by_a_power_of_two_have_the_same_parameter(
        number in 0..SOLIDS,
        sizes in [0.1f32..2.0, 0.1f32..2.0, 0.1f32..2.0, 0.1f32..2.0],
        direction in direction(),
        target in [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(Vec3::from_array),
        power in -60i32..60,
    ) {
        // Whose other sizes are not lengths.
        prop_assume!(![20, 22, 23].contains(&number));
        let scale = 2.0f32.powi(power);
        let hit = |scale: f32| {
            let ray = Ray::new((target - direction * 5.0) * scale, direction * scale, f32::INFINITY).expect("sound");
            solid(number, sizes, scale).surface.closest_hit(&ray, Backfaces::Include)
        };
        match (hit(1.0), hit(scale)) {
            (Some(one), Some(other)) => {
                prop_assert_eq!(one.t.to_bits(), other.t.to_bits());
                prop_assert_eq!(one.normal, other.normal);
            }
            (one, other) => prop_assert_eq!(one.is_some(), other.is_some()),
        }
    }
}
