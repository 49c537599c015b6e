//! The way of a ray through the structures.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};
use bevy_sightline::{
    geometry::ray::Ray,
    spatial::{
        AabbTree, BruteForce, KdTree, Octree, PointKdTree, SpatialQueries, SpatialUpdates, TestedBox, Trace, TraceStep,
        TracedNode, UniformGrid, Visit,
        kd_tree::SplitMethod,
        uniform_grid::{CellSize, GridSettings},
    },
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::differential::scenes::{Scene, unsound};
use crate::common::{random_dir, random_point, rng};

type Boxes = Vec<(u32, Aabb3d)>;

fn filled<T: SpatialUpdates<u32>>(mut structure: T, boxes: &Boxes) -> T {
    structure.insert_many(boxes.iter().copied());
    structure
}

fn kd_tree(boxes: &Boxes) -> KdTree<u32> {
    KdTree::new(boxes.iter().copied(), SplitMethod::Sah).expect("sound boxes")
}

/// A ray that may meet such a scene: through one of its boxes, mostly.
fn random_ray(boxes: &Boxes, rng: &mut ChaCha8Rng) -> Ray {
    let target = match boxes.len() {
        0 => Vec3A::ZERO,
        len => {
            let (_, aabb) = boxes[rng.random_range(0..len)];
            aabb.min * 0.5 + aabb.max * 0.5
        }
    };
    let direction = if rng.random_bool(0.2) {
        Vec3::AXES[rng.random_range(0..3)]
    } else {
        *random_dir(rng)
    };
    let origin = target - Vec3A::from(direction) * rng.random_range(0.0..100.0);
    let origin = if rng.random_bool(0.2) {
        origin + Vec3A::from(random_point(rng, 1.0))
    } else {
        origin
    };
    let t_max = if rng.random_bool(0.3) { 60.0 } else { f32::INFINITY };
    Ray::new(origin, direction, t_max).expect("a ray")
}

/// What a visitor that wants the nearest is given, in order.
fn visits(visit_all: impl FnOnce(&mut dyn FnMut(u32, f32) -> Visit)) -> Vec<(u32, f32)> {
    let mut visits = Vec::new();
    let mut nearest = f32::INFINITY;
    visit_all(&mut |key, at| {
        visits.push((key, at));
        if at < nearest {
            nearest = at;
            Visit::Shorten(at)
        } else {
            Visit::Continue
        }
    });
    visits
}

fn node(trace: &Trace<u32>, step: usize) -> &TracedNode<u32> {
    match &trace.steps[step] {
        TraceStep::Node(node) => node,
        TraceStep::Leaf(leaf) => panic!("step {step} is the leaf {}", leaf.key),
    }
}

/// The way is that of the query, and every box that is visited was tested in a node that was entered before.
fn assert_true(structure: &impl SpatialQueries<u32>, ray: &Ray, boxes: &Boxes, context: &str) -> Trace<u32> {
    let mut trace = Trace::default();
    let traced = visits(|visit| trace = structure.trace_ray(ray, visit));
    let queried = visits(|visit| structure.visit_ray(ray, visit));
    assert_eq!(traced, queried, "{context}");

    let leaves: Vec<(u32, f32)> = trace.leaves().map(|leaf| (leaf.key, leaf.at)).collect();
    assert_eq!(leaves, queried, "{context}");
    for (step, leaf) in (0..).zip(&trace.steps) {
        let TraceStep::Leaf(leaf) = leaf else { continue };
        assert!(leaf.parent < step, "{context}");
        let tested = &node(&trace, leaf.parent).boxes;
        let is_it = |tested: &&TestedBox<u32>| {
            tested.key == Some(leaf.key) && tested.aabb == leaf.aabb && tested.at == Some(leaf.at)
        };
        assert_eq!(tested.iter().filter(is_it).count(), 1, "{context}");
        assert_eq!(leaf.aabb, boxes[leaf.key as usize].1, "{context}");
    }
    trace
}

/// A node is entered through its box in the node around it, which is one level above and was entered before.
fn assert_nested(trace: &Trace<u32>, context: &str) {
    for (number, step) in (0..).zip(&trace.steps) {
        let TraceStep::Node(inner) = step else { continue };
        let Some(parent) = inner.parent else {
            assert_eq!((number, inner.depth), (0, 0), "{context}: the root");
            continue;
        };
        assert!(parent < number, "{context}");
        let outer = node(trace, parent);
        assert_eq!(outer.depth + 1, inner.depth, "{context}");
        let is_it =
            |tested: &&TestedBox<u32>| tested.key.is_none() && tested.aabb == inner.bounds && tested.at.is_some();
        assert!(outer.boxes.iter().any(|tested| is_it(&tested)), "{context}");
    }
}

/// What is in one node is visited from near to far.
fn assert_front_to_back(trace: &Trace<u32>, ray: &Ray, context: &str) {
    let mut last = vec![0.0; trace.steps.len()];
    for step in &trace.steps {
        let (parent, at) = match step {
            TraceStep::Leaf(leaf) => (Some(leaf.parent), Some(leaf.at)),
            TraceStep::Node(node) => (node.parent, ray.aabb_intersection_at(&node.bounds)),
        };
        let (Some(parent), Some(at)) = (parent, at) else {
            continue;
        };
        assert!(last[parent] <= at, "{context}");
        last[parent] = at;
    }
}

/// Asks `check` about scenes of every kind, with from none to some hundred boxes, and rays in them.
fn for_scenes(mut check: impl FnMut(&Boxes, &Ray, &str)) {
    for scene in Scene::ALL {
        for size in [0, 1, 2, 9, 300] {
            let mut rng = rng(size);
            let boxes: Boxes = (0..size as u32).map(|key| (key, scene.aabb(&mut rng))).collect();
            for _ in 0..20 {
                let ray = random_ray(&boxes, &mut rng);
                check(&boxes, &ray, &format!("{scene:?}, {size} boxes, {ray:?}"));
            }
        }
    }
}

#[test]
fn a_trace_of_a_tree_is_what_its_query_does() {
    for_scenes(|boxes, ray, context| {
        let tree = filled(AabbTree::new(), boxes);
        let trace = assert_true(&tree, ray, boxes, context);
        assert_nested(&trace, context);
        assert_front_to_back(&trace, ray, context);
    });
}

#[test]
fn a_trace_of_an_octree_is_what_its_query_does() {
    for_scenes(|boxes, ray, context| {
        let tree = filled(Octree::new(), boxes);
        let trace = assert_true(&tree, ray, boxes, context);
        assert_nested(&trace, context);
        assert_front_to_back(&trace, ray, context);
    });
}

#[test]
fn a_trace_of_a_k_d_tree_is_what_its_query_does() {
    for_scenes(|boxes, ray, context| {
        let trace = assert_true(&kd_tree(boxes), ray, boxes, context);
        assert_nested(&trace, context);
        assert_front_to_back(&trace, ray, context);
    });
}

#[test]
fn a_trace_of_a_k_d_tree_of_points_is_what_its_query_does() {
    for size in [0, 1, 9, 300] {
        let mut rng = rng(size);
        let boxes: Boxes = (0..size as u32)
            .map(|key| (key, Scene::Points.aabb(&mut rng)))
            .collect();
        let points = boxes.iter().map(|&(key, aabb)| (key, aabb.min));
        let tree = PointKdTree::from_points(points, SplitMethod::Median).expect("finite points");
        for _ in 0..50 {
            let ray = random_ray(&boxes, &mut rng);
            let context = format!("{size} points, {ray:?}");
            assert_nested(&assert_true(&tree, &ray, &boxes, &context), &context);
        }
    }
}

#[test]
fn a_trace_of_a_grid_is_what_its_query_does() {
    for_scenes(|boxes, ray, context| {
        let grid = filled(UniformGrid::default(), boxes);
        let trace = assert_true(&grid, ray, boxes, context);
        for node in trace.nodes() {
            let is_brick = node.boxes.iter().all(|tested| tested.key.is_none());
            let is_cell = node.boxes.iter().all(|tested| tested.key.is_some());
            assert!(if node.depth == 0 { is_brick } else { is_cell }, "{context}");
        }
    });
}

#[test]
fn a_trace_of_a_grid_goes_from_layer_to_layer_away_from_the_origin() {
    let mut rng = rng(4);
    let boxes: Boxes = (0..8000)
        .map(|key| (key, Aabb3d::new(random_point(&mut rng, 100.0), Vec3::ONE)))
        .collect();
    let cell_size = CellSize::Fixed(4.0);
    let grid = filled(UniformGrid::new(GridSettings { cell_size }), &boxes);
    for _ in 0..100 {
        let origin = *random_dir(&mut rng) * 150.0;
        let ray = Ray::new(origin, -origin, f32::INFINITY).expect("a ray");
        let trace = grid.trace_ray(&ray, |_, _| Visit::Continue);
        let along = |node: &TracedNode<u32>| {
            let axis = ray.direction().abs().max_position();
            (node.bounds.min + node.bounds.max)[axis] * ray.direction()[axis].signum()
        };
        for depth in 0..2 {
            let places = trace.nodes().filter(|node| node.depth == depth).map(along);
            assert!(places.is_sorted());
        }
        assert!(trace.nodes().filter(|node| node.depth == 0).count() > 5);
    }
}

#[test]
fn a_trace_of_brute_force_tests_every_box() {
    for_scenes(|boxes, ray, context| {
        let trace = assert_true(&filled(BruteForce::new(), boxes), ray, boxes, context);
        assert_eq!(trace.boxes_tested(), boxes.len(), "{context}");
        assert_eq!(trace.nodes().count(), usize::from(!boxes.is_empty()), "{context}");
    });
}

#[test]
fn all_traces_lead_to_the_closest_box() {
    for_scenes(|boxes, ray, context| {
        let expected = filled(BruteForce::new(), boxes).closest_box(ray);
        let found = [
            filled(BruteForce::new(), boxes).trace_closest_box(ray),
            filled(AabbTree::new(), boxes).trace_closest_box(ray),
            filled(UniformGrid::default(), boxes).trace_closest_box(ray),
            filled(Octree::new(), boxes).trace_closest_box(ray),
            kd_tree(boxes).trace_closest_box(ray),
        ];
        for (closest, trace) in found {
            assert_eq!(closest, expected, "{context}");
            let last = trace.leaves().last().map(|leaf| leaf.limit);
            assert_eq!(last, expected.map(|(_, at)| at), "{context}");
        }
    });
}

#[test]
fn a_hierarchy_tests_a_fraction_of_many_boxes() {
    let mut rng = rng(8);
    let boxes: Boxes = (0..5000)
        .map(|key| (key, Aabb3d::new(random_point(&mut rng, 100.0), Vec3::ONE)))
        .collect();
    let (tree, octree, kd_tree) = (
        filled(AabbTree::new(), &boxes),
        filled(Octree::new(), &boxes),
        kd_tree(&boxes),
    );
    let ray = Ray::new(Vec3::X * 200.0, Vec3::NEG_X, f32::INFINITY).expect("a ray");
    for (_, trace) in [
        tree.trace_closest_box(&ray),
        octree.trace_closest_box(&ray),
        kd_tree.trace_closest_box(&ray),
    ] {
        assert!(trace.boxes_tested() < 1000);
        assert!(trace.nodes().all(|node| node.boxes.len() <= 8));
    }
}

#[test]
fn a_trace_ends_where_the_visitor_stops() {
    let mut rng = rng(3);
    let boxes: Boxes = (0..300).map(|key| (key, Scene::Coincident.aabb(&mut rng))).collect();
    let ray = Ray::new(Vec3::new(3.0, -4.0, 50.0), Vec3::NEG_Z, f32::INFINITY).expect("a ray");
    let stop = |_, _| Visit::Stop;
    for trace in [
        filled(AabbTree::new(), &boxes).trace_ray(&ray, stop),
        filled(UniformGrid::default(), &boxes).trace_ray(&ray, stop),
        filled(Octree::new(), &boxes).trace_ray(&ray, stop),
        kd_tree(&boxes).trace_ray(&ray, stop),
        filled(BruteForce::new(), &boxes).trace_ray(&ray, stop),
    ] {
        assert_eq!(trace.leaves().count(), 1);
        assert!(matches!(trace.steps.last(), Some(TraceStep::Leaf(_))));
    }
}

#[test]
fn boxes_that_are_refused_are_on_no_way() {
    let mut rng = rng(6);
    let sound = (0, Aabb3d::new(Vec3::ZERO, Vec3::ONE));
    let boxes: Boxes = [sound]
        .into_iter()
        .chain((1..50).map(|key| (key, unsound(&mut rng))))
        .collect();
    let ray = Ray::new(Vec3::Z * 10.0, Vec3::NEG_Z, f32::INFINITY).expect("a ray");
    for (closest, trace) in [
        filled(AabbTree::new(), &boxes).trace_closest_box(&ray),
        filled(UniformGrid::default(), &boxes).trace_closest_box(&ray),
        filled(Octree::new(), &boxes).trace_closest_box(&ray),
        filled(BruteForce::new(), &boxes).trace_closest_box(&ray),
    ] {
        assert_eq!(closest.map(|(key, _)| key), Some(0));
        let tested = trace.nodes().flat_map(|node| &node.boxes);
        assert!(tested.filter_map(|tested| tested.key).eq([0]));
    }
}

#[test]
fn what_a_mask_hides_is_on_no_way() {
    let mut rng = rng(7);
    let boxes: Boxes = (0..500).map(|key| (key, Scene::Uniform.aabb(&mut rng))).collect();
    let mut tree = AabbTree::new();
    for &(key, aabb) in &boxes {
        tree.insert_masked(key, aabb, 1 << (key % 2)).expect("a sound box");
    }
    for _ in 0..100 {
        let ray = random_ray(&boxes, &mut rng);
        let trace = assert_true(&tree.masked(2), &ray, &boxes, "odd keys");
        let tested = trace.nodes().flat_map(|node| &node.boxes);
        assert!(tested.filter_map(|tested| tested.key).all(|key| key % 2 == 1));
    }
}
