//! The grid finds what a loop over all boxes finds, whatever the scene, and stays whole whatever happens to it.

use std::{collections::HashMap, ops::ControlFlow};

use bevy::math::{
    Quat, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere, BoundingVolume},
    primitives::{HalfSpace, ViewFrustum},
};
use bevy_sightline::{
    geometry::{
        intersection::Intersects,
        obb::Obb,
        ray::Ray,
        sweep::{AabbSweep, SphereSweep},
    },
    spatial::{
        BruteForce, LeafId, NoSuchLeaf, SpatialQueries, SpatialUpdates, Sweep, UniformGrid, UpdateError, Visit,
        uniform_grid::{CellSize, GridSettings},
    },
};
use proptest::prelude::*;
use rand::Rng;

use crate::{
    common::rng,
    properties::{cases, direction, point, rotation},
};

fn cube(center: Vec3A, size: f32) -> Aabb3d {
    Aabb3d {
        min: center - size / 2.0,
        max: center + size / 2.0,
    }
}

/// The two structures with the same leaves.
struct Both {
    grid: UniformGrid<u32>,
    brute: BruteForce<u32>,
    ids: Vec<(LeafId, LeafId)>,
}

impl Both {
    fn new(settings: GridSettings) -> Self {
        Self {
            grid: UniformGrid::new(settings),
            brute: BruteForce::new(),
            ids: Vec::new(),
        }
    }

    /// Built at once.
    fn of(boxes: &[Aabb3d], settings: GridSettings) -> Self {
        let mut both = Self::new(settings);
        let leaves = || (0..).zip(boxes.iter().copied());
        let ours = both.grid.insert_many(leaves());
        let theirs = both.brute.insert_many(leaves());
        both.ids = ours
            .into_iter()
            .zip(theirs)
            .map(|(a, b)| (a.unwrap(), b.unwrap()))
            .collect();
        both
    }

    /// Inserted one by one.
    fn grown(boxes: &[Aabb3d], settings: GridSettings) -> Self {
        let mut both = Self::new(settings);
        for (key, &aabb) in (0..).zip(boxes) {
            both.insert(key, aabb);
        }
        both
    }

    fn insert(&mut self, key: u32, aabb: Aabb3d) {
        let ids = (
            self.grid.insert(key, aabb).unwrap(),
            self.brute.insert(key, aabb).unwrap(),
        );
        self.ids.push(ids);
    }

    fn remove(&mut self, at: usize) {
        let (ours, theirs) = self.ids.swap_remove(at);
        assert_eq!(self.grid.remove(ours), self.brute.remove(theirs));
    }

    fn update(&mut self, at: usize, aabb: Aabb3d) {
        let (ours, theirs) = self.ids[at];
        self.grid.update(ours, aabb).unwrap();
        self.brute.update(theirs, aabb).unwrap();
    }

    fn update_many(&mut self, updates: &[(usize, Aabb3d)]) {
        let ours: Vec<_> = updates.iter().map(|&(at, aabb)| (self.ids[at].0, aabb)).collect();
        assert_eq!(self.grid.update_many(&ours), []);
        for &(at, aabb) in updates {
            self.brute.update(self.ids[at].1, aabb).unwrap();
        }
    }

    fn assert_whole(&self) {
        assert_eq!(self.grid.validate(), Ok(()));
        assert_eq!(self.grid.len(), self.brute.len());
        for &(ours, theirs) in &self.ids {
            assert_eq!(self.grid.key(ours), self.brute.key(theirs));
            assert_eq!(self.grid.aabb(ours), self.brute.aabb(theirs));
        }
        let all = |structure: &dyn Fn(&mut dyn FnMut(u32, &Aabb3d))| {
            let mut all = Vec::new();
            structure(&mut |key, aabb| all.push((key, format!("{aabb:?}"))));
            all.sort();
            all
        };
        assert_eq!(
            all(&|visit| self.grid.visit_all(visit)),
            all(&|visit| self.brute.visit_all(visit))
        );
        match (self.grid.bounds(), self.brute.bounds()) {
            (None, None) => {}
            (Some(ours), Some(exact)) => assert!(ours.contains(&exact)),
            bounds => panic!("{bounds:?}"),
        }
    }

    /// Every query of the trait, around one place.
    fn assert_same_answers(&self, probe: &Probe) {
        self.assert_same_along(&probe.ray());
        for sweep_size in [0.0, probe.radius] {
            self.assert_same_swept(&SphereSweep::new(probe.ray(), sweep_size).unwrap());
            let half_size = Vec3A::new(sweep_size, 0.0, probe.radius);
            self.assert_same_swept(&AabbSweep::new(probe.ray(), half_size).unwrap());
        }
        for max_distance in [probe.radius, -probe.radius, 0.0, f32::INFINITY, f32::NAN] {
            self.assert_same_near(probe.point, max_distance);
        }
        self.assert_same_in(&cube(probe.point, probe.radius));
        self.assert_same_in(&BoundingSphere::new(probe.point, probe.radius));
        let half_size = Vec3A::new(probe.radius, probe.radius * 0.5, probe.radius * 2.0);
        if let Some(obb) = Obb::new(probe.point, half_size, probe.rotation) {
            self.assert_same_in(&obb);
        }
        self.assert_same_in(&probe.frustum());
        self.assert_same_pairs(probe.radius * 0.1);
    }

    fn assert_same_along(&self, ray: &Ray) {
        let along = |structure: &dyn Fn(&mut dyn FnMut(u32, f32) -> Visit)| {
            let mut found = Vec::new();
            structure(&mut |key, t| {
                found.push((key, t.to_bits()));
                Visit::Continue
            });
            found.sort();
            found
        };
        assert_eq!(
            along(&|visit| self.grid.visit_ray(ray, visit)),
            along(&|visit| self.brute.visit_ray(ray, visit)),
            "{ray:?}"
        );
        assert_eq!(self.grid.closest_box(ray), self.brute.closest_box(ray), "{ray:?}");
        let odd = |key: u32, _: &Ray| key % 2 == 1;
        assert_eq!(self.grid.any_hit(ray, odd), self.brute.any_hit(ray, odd));
    }

    fn assert_same_swept(&self, sweep: &impl Sweep) {
        let swept = |structure: &dyn Fn(&mut dyn FnMut(u32, f32) -> Visit)| {
            let mut found = Vec::new();
            structure(&mut |key, t| {
                found.push((key, t.to_bits()));
                Visit::Continue
            });
            found.sort();
            found
        };
        assert_eq!(
            swept(&|visit| self.grid.visit_sweep(sweep, visit)),
            swept(&|visit| self.brute.visit_sweep(sweep, visit)),
            "{:?} {:?}",
            sweep.ray(),
            sweep.reach()
        );
        assert_eq!(self.grid.first_touched(sweep), self.brute.first_touched(sweep));
    }

    fn assert_same_near(&self, point: Vec3A, max_distance: f32) {
        let near = |structure: &dyn Fn(&mut dyn FnMut(u32, f32) -> Visit)| {
            let mut found = Vec::new();
            structure(&mut |key, distance| {
                found.push((key, distance.to_bits()));
                Visit::Continue
            });
            found.sort();
            found
        };
        let expected = near(&|visit| self.brute.visit_near(point, max_distance, visit));
        let ours = near(&|visit| self.grid.visit_near(point, max_distance, visit));
        assert_eq!(ours, expected, "{point} {max_distance}");
        let unordered = near(&|visit| {
            self.grid.neighbours_within(point, max_distance, |key, distance| {
                visit(key, distance);
            });
        });
        assert_eq!(unordered, expected, "{point} {max_distance}");
        for k in [0, 1, 5] {
            let (mut ours, mut theirs) = (Vec::new(), Vec::new());
            self.grid.k_nearest(point, k, max_distance, &mut ours);
            self.brute.k_nearest(point, k, max_distance, &mut theirs);
            assert_eq!(ours, theirs, "{k} at {point}, {max_distance}");
        }
    }

    fn assert_same_in(&self, region: &impl bevy_sightline::spatial::Region) {
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        self.grid.find_in_region(region, &mut ours);
        self.brute.find_in_region(region, &mut theirs);
        ours.sort_unstable();
        theirs.sort_unstable();
        assert_eq!(ours, theirs);
    }

    fn assert_same_pairs(&self, distance: f32) {
        let order = |a: u32, b: u32| (a.min(b), a.max(b));
        let pairs = |structure: &dyn Fn(&mut dyn FnMut(u32, u32) -> ControlFlow<()>)| {
            let mut found = Vec::new();
            structure(&mut |a, b| {
                found.push(order(a, b));
                ControlFlow::Continue(())
            });
            found.sort_unstable();
            found
        };
        assert_eq!(
            pairs(&|visit| self.grid.visit_pairs(visit)),
            pairs(&|visit| self.brute.visit_pairs(visit))
        );
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        self.grid.visit_pairs_within(distance, |a, b, squared| {
            ours.push((order(a, b), squared.to_bits()));
            ControlFlow::Continue(())
        });
        let mut boxes = Vec::new();
        self.brute.visit_all(|key, &aabb| boxes.push((key, aabb)));
        for (at, (a, a_box)) in boxes.iter().enumerate() {
            for (b, b_box) in &boxes[at + 1..] {
                let apart = (a_box.min - b_box.max).max(b_box.min - a_box.max).max(Vec3A::ZERO);
                let squared = apart.x * apart.x + apart.y * apart.y + apart.z * apart.z;
                if squared <= distance * distance {
                    theirs.push((order(*a, *b), squared.to_bits()));
                }
            }
        }
        ours.sort_unstable();
        theirs.sort_unstable();
        assert_eq!(ours, theirs, "within {distance}");
    }
}

/// Where to look, and how far.
#[derive(Clone, Debug)]
struct Probe {
    point: Vec3A,
    direction: Vec3A,
    rotation: Quat,
    radius: f32,
    t_max: f32,
}

impl Probe {
    fn ray(&self) -> Ray {
        Ray::new(self.point, self.direction, self.t_max).unwrap()
    }

    /// Six half-spaces, the far one without end.
    fn frustum(&self) -> ViewFrustum {
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y].map(|side| self.rotation * (side + Vec3::Z * 0.5));
        let [a, b, c, d] = axes.map(|normal| plane(normal, self.point.into()));
        let near = plane(self.rotation * Vec3::Z, self.point.into());
        ViewFrustum {
            half_spaces: [a, b, c, d, near, HalfSpace::new(Vec3::ZERO.extend(f32::INFINITY))],
        }
    }

    fn scaled(self, scale: f32) -> Self {
        Self {
            point: self.point * scale,
            radius: self.radius * scale,
            t_max: self.t_max * scale,
            ..self
        }
    }
}

fn plane(normal: Vec3, point: Vec3) -> HalfSpace {
    HalfSpace::new(normal.extend(-normal.dot(point)))
}

fn probe() -> impl Strategy<Value = Probe> {
    let radius = prop_oneof![Just(0.0f32), 0.0f32..2.0, 0.0f32..100.0];
    let t_max = prop_oneof![Just(f32::INFINITY), 0.0f32..200.0, Just(0.0)];
    (point(), direction(), rotation(), radius, t_max).prop_map(|(point, direction, rotation, radius, t_max)| Probe {
        point,
        direction,
        rotation,
        radius,
        t_max,
    })
}

/// Boxes as scenes have them, and as nobody wants them.
fn scene() -> impl Strategy<Value = Vec<Aabb3d>> {
    let size = prop_oneof![4 => 0.0f32..2.0, 1 => Just(0.0f32), 1 => Just(1.0f32)];
    let uniform = prop::collection::vec((point(), size.clone()), 0..60);
    let clustered = (point(), prop::collection::vec((point(), size.clone()), 0..60))
        .prop_map(|(at, boxes)| boxes.into_iter().map(|(p, size)| (at + p * 0.01, size * 0.1)).collect());
    let flat = prop::collection::vec((point(), size.clone()), 0..60).prop_map(|boxes| {
        let flat = |(p, size): (Vec3A, f32)| (p * Vec3A::new(1.0, 0.0, 1.0), size);
        boxes.into_iter().map(flat).collect()
    });
    let mixed = prop::collection::vec((point(), (-10i32..24).prop_map(|log2| 2f32.powi(log2))), 0..40);
    let coincident = (point(), size.clone(), 0usize..60).prop_map(|(p, size, n)| vec![(p, size); n]);
    let collinear = (
        point(),
        direction(),
        prop::collection::vec((0.0f32..1000.0, size), 0..60),
    )
        .prop_map(|(from, direction, boxes)| {
            boxes
                .into_iter()
                .map(|(t, size)| (from + direction * t, size))
                .collect()
        });
    let touching = prop::collection::vec([-3i8..=3, -3i8..=3, -3i8..=3], 0..60).prop_map(|cells| {
        let corner = |cell: [i8; 3]| (Vec3A::from_array(cell.map(f32::from)) + 0.5, 1.0);
        cells.into_iter().map(corner).collect()
    });
    let kind: BoxedStrategy<Vec<(Vec3A, f32)>> = prop_oneof![
        3 => uniform, 2 => clustered, 2 => flat, 2 => mixed, 1 => coincident, 1 => collinear, 2 => touching
    ]
    .boxed();
    let squashed = prop_oneof![3 => Just(Vec3A::ONE), 1 => Just(Vec3A::new(1.0, 0.0, 3.0)), 1 => Just(Vec3A::Y)];
    (kind, squashed).prop_map(|(boxes, squashed)| {
        boxes
            .into_iter()
            .map(|(center, size)| Aabb3d {
                min: center - size * 0.5 * squashed,
                max: center + size * 0.5 * squashed,
            })
            .collect()
    })
}

/// Everything times this.
fn scale() -> impl Strategy<Value = f32> {
    prop_oneof![4 => Just(1.0f32), 1 => Just(1e-20f32), 1 => Just(1e-3f32), 1 => Just(1e7f32)]
}

fn settings() -> impl Strategy<Value = GridSettings> {
    let cell_size = prop_oneof![
        3 => Just(CellSize::Auto),
        1 => prop_oneof![Just(1e-3f32), Just(0.7), Just(1.0), Just(300.0), Just(1e30), Just(1e-38)].prop_map(CellSize::Fixed),
    ];
    cell_size.prop_map(|cell_size| GridSettings { cell_size })
}

fn scaled(boxes: Vec<Aabb3d>, scale: f32) -> Vec<Aabb3d> {
    let scaled = |aabb: Aabb3d| Aabb3d {
        min: aabb.min * scale,
        max: aabb.max * scale,
    };
    boxes.into_iter().map(scaled).collect()
}

#[derive(Clone, Debug)]
enum Change {
    Insert(Aabb3d),
    Remove(prop::sample::Index),
    Update(prop::sample::Index, Aabb3d),
    UpdateMany(Vec<(prop::sample::Index, Aabb3d)>),
    Nudge(prop::sample::Index, Vec3A),
    InsertMany(Vec<Aabb3d>),
    RemoveHalf,
    Clear,
}

fn change() -> impl Strategy<Value = Change> {
    let aabb = (point(), prop_oneof![8 => 0.0f32..2.0, 1 => 0.0f32..1e6])
        .prop_map(|(p, size)| cube(p, size))
        .boxed();
    let index = || any::<prop::sample::Index>();
    prop_oneof![
        8 => aabb.clone().prop_map(Change::Insert),
        6 => index().prop_map(Change::Remove),
        6 => (index(), aabb.clone()).prop_map(|(at, aabb)| Change::Update(at, aabb)),
        6 => (index(), point()).prop_map(|(at, by)| Change::Nudge(at, by * 0.01)),
        2 => prop::collection::vec((index(), aabb.clone()), 0..40).prop_map(Change::UpdateMany),
        2 => prop::collection::vec(aabb, 0..40).prop_map(Change::InsertMany),
        1 => Just(Change::RemoveHalf),
        1 => Just(Change::Clear),
    ]
}

fn apply(both: &mut Both, next_key: &mut u32, change: Change) {
    let len = both.ids.len();
    match change {
        Change::Insert(aabb) => {
            both.insert(*next_key, aabb);
            *next_key += 1;
        }
        Change::InsertMany(boxes) => {
            let leaves: Vec<_> = (*next_key..).zip(boxes).collect();
            *next_key += leaves.len() as u32;
            let ours = both.grid.insert_many(leaves.iter().copied());
            let theirs = both.brute.insert_many(leaves);
            both.ids
                .extend(ours.into_iter().zip(theirs).map(|(a, b)| (a.unwrap(), b.unwrap())));
        }
        Change::Clear => {
            both.grid.clear();
            both.brute.clear();
            both.ids.clear();
        }
        _ if len == 0 => {}
        Change::Remove(at) => both.remove(at.index(len)),
        Change::Update(at, aabb) => both.update(at.index(len), aabb),
        Change::UpdateMany(updates) => {
            let updates: Vec<_> = updates.into_iter().map(|(at, aabb)| (at.index(len), aabb)).collect();
            both.update_many(&updates);
        }
        Change::Nudge(at, by) => {
            let at = at.index(len);
            let old = both.grid.aabb(both.ids[at].0).unwrap();
            both.update(
                at,
                Aabb3d {
                    min: old.min + by,
                    max: old.max + by,
                },
            );
        }
        Change::RemoveHalf => (0..len / 2).for_each(|_| both.remove(0)),
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_built_grid_answers_as_brute_force(
        boxes in scene(), scale in scale(), probe in probe(), probe_scale in scale(), settings in settings(),
    ) {
        let both = Both::of(&scaled(boxes, scale), settings);
        both.assert_whole();
        both.assert_same_answers(&probe.clone().scaled(scale));
        both.assert_same_answers(&probe.scaled(probe_scale));
    }

    #[test]
    fn a_grown_grid_answers_as_brute_force(
        boxes in scene(), scale in scale(), probe in probe(), settings in settings(),
    ) {
        let both = Both::grown(&scaled(boxes, scale), settings);
        both.assert_whole();
        both.assert_same_answers(&probe.scaled(scale));
    }

    #[test]
    fn a_grid_answers_as_brute_force_after_any_changes(
        boxes in scene(), changes in prop::collection::vec(change(), 1..30), probe in probe(), settings in settings(),
    ) {
        let mut next_key = boxes.len() as u32;
        let mut both = Both::of(&boxes, settings);
        for change in changes {
            apply(&mut both, &mut next_key, change);
            prop_assert_eq!(both.grid.validate(), Ok(()));
        }
        both.assert_whole();
        both.assert_same_answers(&probe);
    }

    #[test]
    fn rays_through_a_dense_world_meet_what_brute_force_meets(seed: u64, probes in prop::collection::vec(probe(), 4)) {
        let mut rng = rng(seed);
        let boxes: Vec<_> = (0..300).map(|_| {
            let center = Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-20.0..20.0)));
            cube(center, rng.random_range(0.0..1.0))
        }).collect();
        let fixed = GridSettings { cell_size: CellSize::Fixed(1.0) };
        for both in [Both::of(&boxes, fixed), Both::of(&boxes, GridSettings::default())] {
            for probe in &probes {
                both.assert_same_along(&probe.ray());
                both.assert_same_swept(&SphereSweep::new(probe.ray(), probe.radius * 0.05).unwrap());
            }
        }
    }
}

fn crowd(len: usize, seed: u64) -> Vec<Aabb3d> {
    let mut rng = rng(seed);
    let half = (len as f32).cbrt() / 2.0;
    let mut at = || rng.random_range(-half..half);
    (0..len).map(|_| cube(Vec3A::new(at(), at(), at()), 1.0)).collect()
}

fn some_probe() -> Probe {
    Probe {
        point: Vec3A::new(0.3, -0.2, 0.1),
        direction: Vec3A::new(0.6, 0.0, 0.8),
        rotation: Quat::IDENTITY,
        radius: 2.0,
        t_max: f32::INFINITY,
    }
}

#[test]
fn an_empty_grid_finds_nothing() {
    let both = Both::new(GridSettings::default());
    both.assert_whole();
    both.assert_same_answers(&some_probe());
}

#[test]
fn boxes_that_are_not_sound_are_refused_and_change_nothing() {
    let mut both = Both::of(&crowd(20, 1), GridSettings::default());
    let id = both.ids[3].0;
    for bad in [
        Aabb3d {
            min: Vec3A::NAN,
            max: Vec3A::ZERO,
        },
        Aabb3d {
            min: Vec3A::ZERO,
            max: Vec3A::INFINITY,
        },
        Aabb3d {
            min: Vec3A::ONE,
            max: Vec3A::ZERO,
        },
    ] {
        assert!(both.grid.insert(99, bad).is_err());
        assert!(matches!(both.grid.update(id, bad), Err(UpdateError::UnsoundBox(_))));
        assert!(matches!(
            both.grid.update_many(&[(id, bad)])[..],
            [(_, UpdateError::UnsoundBox(_))]
        ));
        assert!(both.grid.insert_many([(99, bad)])[0].is_err());
        assert_eq!(
            both.grid
                .insert_many([(99, bad); 100])
                .iter()
                .filter(|id| id.is_ok())
                .count(),
            0
        );
    }
    both.assert_whole();
}

#[test]
fn what_was_removed_is_not_there() {
    let mut grid = UniformGrid::default();
    let id = grid.insert(7, cube(Vec3A::ZERO, 1.0)).unwrap();
    assert_eq!(grid.remove(id), Ok(7));
    let other = grid.insert(8, cube(Vec3A::ZERO, 1.0)).unwrap();
    assert_eq!(grid.remove(id), Err(NoSuchLeaf));
    assert_eq!(
        grid.update(id, cube(Vec3A::ZERO, 1.0)),
        Err(UpdateError::NoSuchLeaf(NoSuchLeaf))
    );
    assert_eq!((grid.key(id), grid.key(other)), (None, Some(8)));
    assert_eq!(grid.cell_of_leaf(id), None);
}

#[test]
fn nothing_is_near_a_nan() {
    let grid = Both::of(&crowd(100, 2), GridSettings::default()).grid;
    for point in [Vec3A::NAN, Vec3A::new(0.0, f32::NAN, 0.0)] {
        let mut found = 0;
        grid.visit_near(point, f32::INFINITY, |_, _| {
            found += 1;
            Visit::Continue
        });
        grid.neighbours_within(point, f32::INFINITY, |_, _| found += 1);
        grid.visit_region(&BoundingSphere::new(point, 10.0), |_| {
            found += 1;
            ControlFlow::Continue(())
        });
        grid.visit_region(&Aabb3d { min: point, max: point }, |_| {
            found += 1;
            ControlFlow::Continue(())
        });
        assert_eq!(found, 0);
    }
    grid.visit_pairs_within(f32::NAN, |_, _, _| panic!("a pair within NaN"));
}

#[test]
fn a_hundred_thousand_at_one_point_are_quickly_built_moved_and_removed() {
    let n = 100_000;
    let mut grid = UniformGrid::default();
    let ids = grid.insert_many((0..n).map(|key| (key, cube(Vec3A::ONE, 1.0))));
    let ids: Vec<_> = ids.into_iter().map(Result::unwrap).collect();
    assert_eq!(grid.validate(), Ok(()));
    for id in &ids[..1000] {
        grid.update(*id, cube(Vec3A::splat(50.0), 1.0)).unwrap();
    }
    let mut found = Vec::new();
    grid.find_in_region(&cube(Vec3A::splat(50.0), 1.0), &mut found);
    assert_eq!(found.len(), 1000);
    for id in &ids[..50_000] {
        grid.remove(*id).unwrap();
    }
    assert_eq!(grid.validate(), Ok(()));
    let mut pairs = 0;
    grid.visit_pairs(|_, _| {
        pairs += 1;
        if pairs < 10_000 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    });
    assert_eq!(pairs, 10_000);
}

#[test]
fn one_huge_box_fills_one_cell() {
    let mut boxes: Vec<_> = crowd(1000, 3)
        .into_iter()
        .map(|aabb| cube(aabb.min * 1e-3, 1e-3))
        .collect();
    boxes.push(cube(Vec3A::ZERO, 1e7));
    let mut both = Both::of(&boxes, GridSettings::default());
    both.assert_same_answers(&some_probe().scaled(1e-3));
    both.assert_same_answers(&some_probe().scaled(1e7));
    let huge = both.ids[1000].0;
    let cell = both.grid.cell_of_leaf(huge).unwrap();
    assert_eq!(both.grid.keys_in_cell(cell).collect::<Vec<_>>(), [1000]);
    assert!(both.grid.cell_size() < 1.0 && cell.level() > 5);
    both.update(1000, cube(Vec3A::splat(1e7), 1e7));
    both.assert_whole();
}

#[test]
fn a_ray_and_a_region_across_a_vast_empty_world_end() {
    let settings = GridSettings {
        cell_size: CellSize::Fixed(1e-3),
    };
    let places = [-1e7, -1e3, -1.0, 0.0, 1e-3, 1.0, 1e3, 1e7];
    let boxes: Vec<_> = places.map(|x| cube(Vec3A::splat(x), 1e-3)).into();
    let both = Both::of(&boxes, settings);
    both.assert_same_along(&Ray::new(Vec3A::splat(-2e7), Vec3A::ONE, f32::INFINITY).unwrap());
    both.assert_same_along(&Ray::new(Vec3A::splat(2e7), Vec3A::NEG_ONE, f32::INFINITY).unwrap());
    both.assert_same_in(&cube(Vec3A::ZERO, 4e7));
    both.assert_same_near(Vec3A::new(5e6, 0.0, 0.0), f32::INFINITY);
}

#[test]
fn points_closer_than_squares_can_tell_are_found() {
    let boxes = [cube(Vec3A::splat(-1e-23), 0.0), cube(Vec3A::splat(1e-23), 0.0)];
    let both = Both::of(
        &boxes,
        GridSettings {
            cell_size: CellSize::Fixed(1e-30),
        },
    );
    both.assert_same_near(Vec3A::ZERO, 0.0);
    both.assert_same_in(&BoundingSphere::new(Vec3A::ZERO, 0.0));
    both.assert_same_pairs(0.0);
}

#[test]
fn a_radius_whose_square_is_infinite_finds_everything() {
    let boxes = [
        cube(Vec3A::splat(1e30), 0.0),
        cube(Vec3A::splat(-3e38), 1.0),
        cube(Vec3A::ZERO, 1.0),
    ];
    let both = Both::of(&boxes, GridSettings::default());
    both.assert_same_near(Vec3A::ZERO, 2e19);
    both.assert_same_in(&BoundingSphere::new(Vec3A::ZERO, 2e19));
    both.assert_same_pairs(2e19);
}

#[test]
fn the_largest_boxes_are_found() {
    let boxes = [
        Aabb3d {
            min: Vec3A::splat(-f32::MAX),
            max: Vec3A::splat(f32::MAX),
        },
        Aabb3d {
            min: Vec3A::splat(f32::MAX),
            max: Vec3A::splat(f32::MAX),
        },
        cube(Vec3A::ZERO, 1.0),
    ];
    for settings in [
        GridSettings::default(),
        GridSettings {
            cell_size: CellSize::Fixed(1e-3),
        },
    ] {
        let both = Both::grown(&boxes, settings);
        both.assert_whole();
        both.assert_same_answers(&some_probe());
        both.assert_same_in(&Aabb3d {
            min: Vec3A::splat(f32::MAX),
            max: Vec3A::INFINITY,
        });
        both.assert_same_in(&Aabb3d {
            min: Vec3A::NEG_INFINITY,
            max: Vec3A::splat(-f32::MAX),
        });
    }
}

#[test]
fn sorted_insertions_leave_a_whole_grid() {
    let boxes: Vec<_> = (0..30_000).map(|x| cube(Vec3A::X * x as f32, 1.0)).collect();
    let both = Both::grown(&boxes, GridSettings::default());
    assert_eq!(both.grid.validate(), Ok(()));
    let mut pairs = 0;
    both.grid.visit_pairs(|_, _| {
        pairs += 1;
        ControlFlow::Continue(())
    });
    assert_eq!(pairs, 29_999);
}

#[test]
fn half_the_world_comes_and_goes() {
    let boxes = crowd(4000, 4);
    let mut both = Both::of(&boxes, GridSettings::default());
    for _ in 0..6 {
        (0..2000).for_each(|_| both.remove(0));
        (0..2000).for_each(|at| both.insert(at as u32, boxes[at]));
    }
    both.assert_whole();
}

#[test]
fn a_storm_of_updates_on_one_leaf_leaves_the_others_alone() {
    let mut both = Both::of(&crowd(500, 5), GridSettings::default());
    let mut rng = rng(6);
    for _ in 0..20_000 {
        let at = Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-100.0..100.0)));
        both.update(17, cube(at, 1.0));
    }
    both.assert_whole();
}

#[test]
fn when_most_leaves_change_their_cell_all_are_sorted_anew() {
    let mut both = Both::of(&crowd(3000, 7), GridSettings::default());
    for seed in 8..11 {
        let updates: Vec<_> = crowd(3000, seed).into_iter().enumerate().collect();
        both.update_many(&updates);
    }
    both.assert_whole();
    both.assert_same_answers(&some_probe());
}

#[test]
fn of_several_updates_of_one_leaf_the_last_counts() {
    let mut both = Both::of(&crowd(10, 12), GridSettings::default());
    let updates: Vec<_> = (0..40)
        .map(|step| (step % 10, cube(Vec3A::splat(step as f32 * 10.0), 1.0)))
        .collect();
    both.update_many(&updates);
    both.assert_whole();
}

#[test]
fn the_cell_size_follows_the_scene() {
    let mut grid = UniformGrid::default();
    let boxes = crowd(5000, 13);
    let ids = grid.insert_many((0..).zip(boxes.iter().copied()));
    let before = grid.cell_size();
    let larger: Vec<_> = ids
        .iter()
        .zip(&boxes)
        .map(|(id, aabb)| (id.unwrap(), cube(aabb.min * 100.0, 100.0)))
        .collect();
    grid.update_many(&larger);
    grid.update_many(&larger);
    assert!(grid.cell_size() > 20.0 * before, "{before} {}", grid.cell_size());
    assert_eq!(grid.validate(), Ok(()));
}

#[test]
fn the_cell_size_stays_while_the_scene_does() {
    let mut grid = UniformGrid::default();
    let ids = grid.insert_many((0..).zip(crowd(2000, 14)));
    let before = grid.cell_size();
    for seed in 15..25 {
        let updates: Vec<_> = ids
            .iter()
            .zip(crowd(2000, seed))
            .map(|(id, aabb)| (id.unwrap(), aabb))
            .collect();
        updates.iter().for_each(|&(id, aabb)| grid.update(id, aabb).unwrap());
        assert_eq!(grid.cell_size(), before);
    }
}

#[test]
fn a_given_cell_size_is_kept() {
    let mut grid = UniformGrid::new(GridSettings {
        cell_size: CellSize::Fixed(0.7),
    });
    grid.insert_many((0..).zip(crowd(1000, 26)));
    assert_eq!(grid.cell_size(), 0.7);
}

#[test]
#[should_panic(expected = "the cell size must be positive and finite")]
fn a_cell_size_of_zero_is_refused() {
    UniformGrid::<u32>::new(GridSettings {
        cell_size: CellSize::Fixed(0.0),
    });
}

#[test]
fn every_leaf_is_in_the_one_cell_that_its_centre_is_in() {
    let both = Both::of(&crowd(1000, 27), GridSettings::default());
    let mut seen = HashMap::new();
    both.grid.visit_cells(|cell, cube, len| {
        let keys: Vec<_> = both.grid.keys_in_cell(cell).collect();
        assert_eq!(keys.len(), len);
        for key in keys {
            let (ours, _) = both.ids[key as usize];
            let center: Vec3A = both.grid.aabb(ours).unwrap().center();
            assert!(cube.closest_point(center).distance(center) <= 1e-5);
            assert_eq!(both.grid.cell_of_leaf(ours), Some(cell));
            assert_eq!(seen.insert(key, cell), None);
        }
    });
    assert_eq!(seen.len(), 1000);
}

#[test]
fn cells_in_a_box_are_those_whose_cubes_touch_it() {
    let both = Both::of(&crowd(2000, 28), GridSettings::default());
    let region = cube(Vec3A::new(1.1, 0.3, -2.2), 3.3);
    let (mut expected, mut found) = (Vec::new(), Vec::new());
    both.grid.visit_cells(|cell, cube, len| {
        if cube.intersects(&region) {
            expected.push((cell.coordinates().to_array(), len));
        }
    });
    both.grid.cells_in_box(&region, |cell, _, len| {
        found.push((cell.coordinates().to_array(), len));
        ControlFlow::Continue(())
    });
    expected.sort_unstable();
    found.sort_unstable();
    assert!(!found.is_empty());
    assert_eq!(found, expected);
}

#[test]
fn a_cell_without_leaves_has_no_keys() {
    let mut grid = UniformGrid::default();
    let id = grid.insert(1, cube(Vec3A::ZERO, 1.0)).unwrap();
    let cell = grid.cell_of_leaf(id).unwrap();
    grid.remove(id).unwrap();
    assert_eq!(grid.keys_in_cell(cell).count(), 0);
}

#[test]
fn visitors_stop_when_they_say_so() {
    let both = Both::of(&crowd(500, 29), GridSettings::default());
    let mut visits = [0; 5];
    both.grid.visit_region(&cube(Vec3A::ZERO, 100.0), |_| {
        visits[0] += 1;
        ControlFlow::Break(())
    });
    both.grid.visit_near(Vec3A::ZERO, 100.0, |_, _| {
        visits[1] += 1;
        Visit::Stop
    });
    both.grid.visit_ray(&some_probe().ray(), |_, _| {
        visits[2] += 1;
        Visit::Stop
    });
    both.grid.visit_pairs(|_, _| {
        visits[3] += 1;
        ControlFlow::Break(())
    });
    both.grid.cells_in_box(&cube(Vec3A::ZERO, 100.0), |_, _, _| {
        visits[4] += 1;
        ControlFlow::Break(())
    });
    assert_eq!(visits, [1; 5]);
}

#[test]
fn a_large_crowd_takes_little_memory() {
    let mut grid = UniformGrid::default();
    grid.insert_many((0u64..).zip(crowd(50_000, 30)));
    assert!(grid.memory() < 80 * 50_000, "{}", grid.memory() / 50_000);
}

/// Contact is a fraction of the largest coordinate of either shape: of this box that is not on the axis where it ends
/// at zero, and the shapes are too small to have a slack of their own.
fn box_that_ends_at_zero() -> Both {
    let aabb = Aabb3d {
        min: Vec3A::new(0.0, -1e-3, 0.0),
        max: Vec3A::new(1e-3, 0.0, 1e-3),
    };
    Both::of(&[aabb], GridSettings::default())
}

#[test]
fn a_tiny_sweep_that_counts_as_touching_a_larger_box_finds_it() {
    let both = box_that_ends_at_zero();
    let ray = Ray::new(Vec3A::new(0.0, 2.4e-21, 0.0), Vec3A::NEG_Z, f32::INFINITY).unwrap();
    let sweep = AabbSweep::new(ray, Vec3A::ZERO).unwrap();
    assert_eq!(both.brute.first_touched(&sweep), Some((0, 0.0)));
    both.assert_same_swept(&sweep);
    both.assert_same_swept(&SphereSweep::new(ray, 0.0).unwrap());
}

#[test]
fn a_tiny_region_that_counts_as_touching_a_larger_box_finds_it() {
    let both = box_that_ends_at_zero();
    let region = Obb::new(Vec3A::new(0.0, 2.4e-21, 0.0), Vec3A::splat(1e-22), Quat::IDENTITY).unwrap();
    let mut found = Vec::new();
    both.brute.find_in_region(&region, &mut found);
    assert_eq!(found, [0]);
    both.assert_same_in(&region);
}
