//! Any structure and any ray can be drawn.

use bevy::{
    gizmos::{config::DefaultGizmoConfigGroup, gizmos::GizmoBuffer},
    math::{Affine3A, Vec3A, primitives::ViewFrustum},
};
use bevy_sightline::{
    geometry::volume::AnyVolume,
    spatial::{
        AabbTree, Descend, KdTree, Octree, PointKdTree, SpatialUpdates, UniformGrid, kd_tree::SplitMethod,
        uniform_grid::GridSettings,
    },
};

use super::*;

type Buffer = GizmoBuffer<DefaultGizmoConfigGroup, ()>;

fn drawn(buffer: &Buffer) -> Vec<[Vec3; 2]> {
    buffer.list_positions.as_chunks::<2>().0.to_vec()
}

/// A hundred unit cubes along x.
fn cubes() -> impl Iterator<Item = (u32, Aabb3d)> {
    (0..100).map(|key| (key, Aabb3d::new(Vec3::X * key as f32 * 3.0, Vec3::splat(0.5))))
}

#[test]
fn all_nodes_of_a_tree_are_drawn() {
    let mut tree = AabbTree::new();
    tree.insert_many(cubes());
    let mut buffer = Buffer::default();
    let counted = buffer.aabb_tree(&tree, &StructureStyle::default());
    let mut nodes = Vec::new();
    tree.visit_nodes(|_, aabb| nodes.push(corners(aabb)));
    assert_eq!(boxes_of(&drawn(&buffer)), sorted(nodes.clone()));
    assert_eq!(counted, count(nodes.len(), 0));
}

#[test]
fn all_cells_of_a_grid_are_drawn() {
    let mut grid = UniformGrid::new(GridSettings::default());
    grid.insert_many(cubes());
    let mut buffer = Buffer::default();
    buffer.uniform_grid(&grid, &StructureStyle::default());
    let mut cells = Vec::new();
    grid.visit_cells(|_, cube, _| cells.push(corners(cube)));
    assert_eq!(boxes_of(&drawn(&buffer)), sorted(cells));
}

#[test]
fn all_cells_of_a_k_d_tree_are_drawn() {
    let tree = KdTree::new(cubes(), SplitMethod::Sah).expect("sound boxes");
    let mut buffer = Buffer::default();
    buffer.kd_tree(&tree, &StructureStyle::default());
    let mut cells = Vec::new();
    tree.visit_cells(|_, aabb, _| cells.push(corners(aabb)));
    assert_eq!(boxes_of(&drawn(&buffer)), sorted(cells));
}

#[test]
fn all_cells_of_a_k_d_tree_of_points_are_drawn() {
    let points = cubes().map(|(key, aabb)| (key, aabb.min));
    let tree = PointKdTree::from_points(points, SplitMethod::Median).expect("finite points");
    let mut buffer = Buffer::default();
    let counted = buffer.point_kd_tree(&tree, &StructureStyle::default());
    let mut cells = 0;
    tree.visit_cells(|_, _, _| cells += 1);
    assert_eq!(counted, count(cells, 0));
}

#[test]
fn all_cells_of_an_octree_are_drawn() {
    let mut octree = Octree::new();
    octree.insert_many(cubes());
    let mut buffer = Buffer::default();
    buffer.octree(&octree, &StructureStyle::default());
    let mut cells = Vec::new();
    octree.visit_nodes(|node| {
        cells.push(corners(&node.cell));
        Descend::Into
    });
    assert!(cells.len() > 1);
    assert_eq!(boxes_of(&drawn(&buffer)), sorted(cells));
}

#[test]
fn of_an_octree_depths_are_levels_below_the_whole() {
    let mut octree = Octree::new();
    octree.insert_many(cubes());
    let mut root = None;
    let mut expected = 0;
    octree.visit_nodes(|node| {
        expected += usize::from(*root.get_or_insert(node.level) - node.level == 2);
        Descend::Into
    });
    let style = StructureStyle {
        depths: 2..=2,
        ..default()
    };
    assert!(expected > 0);
    assert_eq!(Buffer::default().octree(&octree, &style), count(expected, 0));
}

#[test]
fn what_is_nearer_comes_first() {
    let tree = KdTree::new(cubes(), SplitMethod::Sah).expect("sound boxes");
    let style = StructureStyle {
        limit: 12,
        depths: tree.depth()..=tree.depth(),
        nearest_to: Some(Vec3::X * 30.0),
        ..default()
    };
    let mut buffer = Buffer::default();
    let counted = buffer.kd_tree(&tree, &style);
    assert_eq!(counted.drawn, 1);
    assert!(counted.left_out > 0);
    let mut cells = Vec::new();
    tree.visit_cells(|depth, aabb, _| cells.extend((depth == tree.depth()).then_some(*aabb)));
    let nearest = cells.iter().min_by(|a, b| {
        let distance = |aabb: &Aabb3d| aabb.closest_point(Vec3::X * 30.0).distance(Vec3A::X * 30.0);
        distance(a).total_cmp(&distance(b))
    });
    assert_eq!(boxes_of(&drawn(&buffer)), [corners(nearest.expect("a cell"))]);
}

#[test]
fn from_nowhere_the_whole_comes_first() {
    let mut tree = AabbTree::new();
    tree.insert_many(cubes());
    let style = StructureStyle { limit: 12, ..default() };
    let mut buffer = Buffer::default();
    buffer.aabb_tree(&tree, &style);
    let mut root = None;
    tree.visit_nodes(|_, aabb| _ = root.get_or_insert(corners(aabb)));
    assert_eq!(boxes_of(&drawn(&buffer)), [root.expect("a root")]);
}

#[test]
fn only_what_is_within_a_frustum_is_drawn() {
    let mut grid = UniformGrid::new(GridSettings::default());
    grid.insert_many(cubes());
    let from_view = Transform::from_xyz(30.0, 0.0, 10.0);
    let clip_from_view = Mat4::perspective_infinite_reverse_rh(0.5, 1.0, 0.1);
    let within = ViewFrustum::from_clip_from_world(&(clip_from_view * from_view.to_matrix().inverse()));
    let style = StructureStyle {
        within: Some(within),
        ..default()
    };
    let mut buffer = Buffer::default();
    let counted = buffer.uniform_grid(&grid, &style);
    assert_eq!(counted.left_out, 0);
    assert!((1..10).contains(&counted.drawn), "{counted:?}");
}

#[test]
fn nothing_is_drawn_of_what_is_empty() {
    let mut buffer = Buffer::default();
    let style = StructureStyle::default();
    assert_eq!(buffer.aabb_tree(&AabbTree::<u32>::new(), &style), count(0, 0));
    assert_eq!(buffer.octree(&Octree::<u32>::new(), &style), count(0, 0));
    assert_eq!(buffer.uniform_grid(&UniformGrid::<u32>::default(), &style), count(0, 0));
    assert!(buffer.list_positions.is_empty());
}

#[test]
fn without_a_palette_all_is_white() {
    let mut tree = AabbTree::new();
    tree.insert_many(cubes());
    let style = StructureStyle {
        palette: Vec::new(),
        ..default()
    };
    let mut buffer = Buffer::default();
    buffer.aabb_tree(&tree, &style);
    assert!(buffer.list_colors.iter().all(|&color| color == LinearRgba::WHITE));
}

#[test]
fn a_ray_is_drawn_with_its_hit_the_normal_and_the_triangle() {
    let mut app = headless_app();
    spawn_cube(&mut app, Vec3::NEG_Z * 10.0);
    settle(&mut app);
    let ray = Ray3d::new(Vec3::ZERO, Dir3::NEG_Z);
    let hit = cast(&mut app, ray).expect("a cube ahead");
    let mut buffer = Buffer::default();
    buffer.ray_hit(ray, Some(&hit));
    let drawn = drawn(&buffer);
    assert_eq!(drawn[0], [Vec3::ZERO, hit.position]);
    let along_normal = drawn
        .iter()
        .filter(|[from, to]| *from == hit.position && (to - from).normalize() == Vec3::Z);
    assert_eq!(along_normal.count(), 1);
    let [a, b, c] = hit.triangle.expect("a mesh").vertices;
    for edge in [[a, b], [b, c], [c, a]] {
        assert!(drawn.contains(&edge));
    }
}

#[test]
fn a_ray_that_hits_nothing_is_one_line() {
    let mut buffer = Buffer::default();
    buffer.ray_hit(Ray3d::new(Vec3::ONE, Dir3::X), None);
    let drawn = drawn(&buffer);
    assert_eq!(drawn.len(), 1);
    assert_eq!(drawn[0][0], Vec3::ONE);
    assert_eq!((drawn[0][1] - Vec3::ONE).normalize(), Vec3::X);
}

#[test]
fn a_volume_is_drawn_where_it_is_put() {
    let volume = AnyVolume::Aabb(Aabb3d::new(Vec3::ZERO, Vec3::ONE));
    let mut buffer = Buffer::default();
    buffer.bounding_volume(&volume, &Affine3A::from_translation(Vec3::X * 5.0), Color::WHITE);
    let expected = Aabb3d::new(Vec3::X * 5.0, Vec3::ONE);
    assert_eq!(boxes_of(&drawn(&buffer)), [corners(&expected)]);
}
