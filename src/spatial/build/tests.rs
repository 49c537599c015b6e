use bevy::math::{Vec3A, bounding::Aabb3d};
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{morton::MortonGrid, *};
use crate::{
    geometry::aabb::{EMPTY, union},
    spatial::{
        simd::{self, Portable, Simd, Task},
        wide::Child,
    },
};

const STRATEGIES: [BuildStrategy; 5] = [
    BuildStrategy::MiddleSplit,
    BuildStrategy::MedianSplit,
    BuildStrategy::BinnedSah,
    BuildStrategy::Ploc,
    BuildStrategy::Reinsertion,
];

/// No hierarchy is deeper than this, whatever is in it.
const DEPTH_LIMIT: usize = 300;

/// Two threads.
pub(super) struct Two;

impl Workers for Two {
    fn count(&self) -> usize {
        2
    }

    fn run(&self, errands: Vec<Errand<'_>>) {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for (turn, errand) in errands.into_iter().enumerate() {
            [&mut first, &mut second][turn % 2].push(errand);
        }
        std::thread::scope(|scope| {
            scope.spawn(|| Alone.run(first));
            Alone.run(second);
        });
    }
}

/// What a build gave.
struct Built {
    workers: &'static dyn Workers,
    builder: Builder,
    items: Vec<BuildItem>,
    nodes: Vec<WideNode>,
    leaves: Vec<(Range<usize>, NodeIndex, usize)>,
    holders: Vec<(Option<(NodeIndex, usize)>, Range<usize>)>,
}

impl Default for Built {
    fn default() -> Self {
        Self {
            workers: &Alone,
            builder: Builder::default(),
            items: Vec::new(),
            nodes: Vec::new(),
            leaves: Vec::new(),
            holders: Vec::new(),
        }
    }
}

impl Built {
    fn of(strategy: BuildStrategy, leaf_size: usize, boxes: &[Aabb3d]) -> Self {
        let mut built = Self::default();
        built.build(strategy, leaf_size, boxes);
        built
    }

    fn build(&mut self, strategy: BuildStrategy, leaf_size: usize, boxes: &[Aabb3d]) {
        self.leaves.clear();
        self.holders.clear();
        self.items.clear();
        self.items.extend(
            (0..)
                .zip(boxes)
                .map(|(index, aabb)| BuildItem::new(aabb, mask_of(index), index)),
        );
        let result = self.builder.build(
            &Order {
                workers: self.workers,
                ..Order::new(strategy, leaves(leaf_size))
            },
            &mut self.items,
            &mut self.nodes,
            |items, first, node, lane| {
                self.leaves.push((first..first + items.len(), node, lane));
                self.leaves.len() as u32 - 1
            },
            |node, holder, range| {
                assert_eq!(node as usize, self.holders.len(), "nodes come by index");
                self.holders.push((holder, range));
            },
        );
        assert_eq!(result, Ok(()));
    }

    /// Asserts everything that [`Builder::build`] promises, and returns the number of levels.
    fn validate(&self, leaf_size: usize, boxes: &[Aabb3d]) -> usize {
        let mut indices: Vec<_> = self.items.iter().map(BuildItem::index).collect();
        indices.sort_unstable();
        assert!(
            indices.into_iter().eq(0..boxes.len() as u32),
            "every item is there once"
        );
        for item in &self.items {
            assert_eq!(item.aabb(), boxes[item.index() as usize]);
            assert_eq!(item.mask(), mask_of(item.index()));
        }
        assert_eq!(self.holders.len(), self.nodes.len());
        if boxes.is_empty() {
            assert!(self.nodes.is_empty() && self.leaves.is_empty());
            return 0;
        }
        assert_eq!(self.holders[0], (None, 0..boxes.len()));
        let mut leaves = 0..;
        let mut reached = 1;
        let levels = self.validate_node(0, leaf_size, &mut leaves, &mut reached);
        assert_eq!(reached, self.nodes.len(), "every node is below the root");
        assert_eq!(leaves.start as usize, self.leaves.len(), "every leaf is below the root");
        levels
    }

    fn validate_node(
        &self,
        node: NodeIndex,
        leaf_size: usize,
        leaves: &mut std::ops::RangeFrom<u32>,
        reached: &mut usize,
    ) -> usize {
        let wide = &self.nodes[node as usize];
        let range = &self.holders[node as usize].1;
        assert!(
            wide.len() > 1 || range.len() <= leaf_size,
            "only a root has one child, and that is a leaf"
        );
        let mut first = range.start;
        let mut levels = 1;
        let mut sibling = None;
        for (lane, (aabb, child)) in wide.lanes().enumerate() {
            let below = match child {
                Child::Leaf(leaf) => {
                    assert_eq!(Some(leaf), leaves.next(), "leaves come in order");
                    let (below, leaf_node, leaf_lane) = &self.leaves[leaf as usize];
                    assert_eq!((*leaf_node, *leaf_lane), (node, lane));
                    assert!((1..=leaf_size).contains(&below.len()));
                    below
                }
                Child::Node(child) => {
                    let (holder, below) = &self.holders[child as usize];
                    assert_eq!(*holder, Some((node, lane)));
                    assert!(child > node, "parents come first");
                    assert!(
                        sibling.is_none_or(|sibling| child == sibling + 1),
                        "siblings stand side by side"
                    );
                    sibling = Some(child);
                    *reached += 1;
                    levels = levels.max(1 + self.validate_node(child, leaf_size, leaves, reached));
                    below
                }
            };
            assert_eq!(below.start, first, "lanes are slices side by side");
            first = below.end;
            let items = &self.items[below.clone()];
            assert_eq!(
                aabb,
                items.iter().fold(EMPTY, |bounds, item| union(&bounds, &item.aabb()))
            );
            assert_eq!(wide.masks[lane], items.iter().fold(0, |mask, item| mask | item.mask()));
        }
        assert_eq!(first, range.end, "the lanes are all of the node");
        levels
    }
}

fn leaves(size: usize) -> Leaves {
    if size == 1 {
        Leaves::SINGLE
    } else {
        Leaves {
            most: size as u32,
            packet: 4,
            packet_cost: 1.0,
        }
    }
}

fn mask_of(index: u32) -> u32 {
    1 << (index % 32)
}

fn aabb(min: Vec3A, size: Vec3A) -> Aabb3d {
    Aabb3d { min, max: min + size }
}

fn uniform(count: usize) -> Vec<Aabb3d> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let side = (count as f32).cbrt() * 2.0;
    let mut point = || Vec3A::new(rng.random(), rng.random(), rng.random());
    (0..count).map(|_| aabb(point() * side, point())).collect()
}

/// Builds and validates with every strategy and for leaves of one and of six items, and returns the most levels.
fn validate_all(boxes: &[Aabb3d]) -> usize {
    let mut levels = 0;
    for strategy in STRATEGIES {
        for leaf_size in [1, 6] {
            let built = Built::of(strategy, leaf_size, boxes);
            levels = levels.max(built.validate(leaf_size, boxes));
        }
    }
    assert!(levels <= DEPTH_LIMIT, "{levels} levels");
    levels
}

#[test]
fn few_boxes_make_sound_hierarchies() {
    for count in 0..40 {
        validate_all(&uniform(count));
    }
}

#[test]
fn blocks_and_windows_and_one_more_make_sound_hierarchies() {
    for count in [255, 256, 257, 4095, 4096, 4097] {
        validate_all(&uniform(count));
    }
}

#[test]
fn coincident_boxes_make_a_balanced_hierarchy_of_full_nodes() {
    let boxes = vec![aabb(Vec3A::ONE, Vec3A::ONE); 20_000];
    assert!(validate_all(&boxes) <= 8);
    let points = vec![aabb(Vec3A::ONE, Vec3A::ZERO); 20_000];
    assert!(validate_all(&points) <= 8);
}

#[test]
fn concentric_boxes_do_not_merge_one_by_one() {
    let boxes: Vec<_> = (0..10_000)
        .map(|i| aabb(Vec3A::splat(-i as f32), Vec3A::splat(2.0 * i as f32)))
        .collect();
    assert!(validate_all(&boxes) <= 20);
}

#[test]
fn boxes_at_growing_distances_do_not_make_a_chain() {
    let boxes: Vec<_> = (0..250)
        .map(|i| aabb(Vec3A::X * 2_f32.powi(i / 2 - 60), Vec3A::ZERO))
        .collect();
    assert!(validate_all(&boxes) <= 70);
}

#[test]
fn what_overflows_or_vanishes_still_makes_a_hierarchy() {
    for scale in [1e-44, 1e-30, 1e-20, 1e7, 1e20, 1e36] {
        let boxes: Vec<_> = uniform(2000)
            .iter()
            .map(|aabb| Aabb3d {
                min: aabb.min * scale,
                max: aabb.max * scale,
            })
            .collect();
        // Where all areas are zero, the binned heuristic cuts off small parts, as often as it is allowed to.
        let levels = validate_all(&boxes);
        assert!(
            levels <= if scale < 1e-25 { 40 } else { 20 },
            "{levels} levels at scale {scale}"
        );
    }
    let everywhere = Aabb3d {
        min: Vec3A::splat(-f32::MAX),
        max: Vec3A::splat(f32::MAX),
    };
    let far = aabb(Vec3A::splat(f32::MAX), Vec3A::ZERO);
    let near = aabb(Vec3A::splat(-f32::MAX), Vec3A::ZERO);
    let boxes: Vec<_> = [everywhere, far, near].into_iter().cycle().take(1000).collect();
    assert!(validate_all(&boxes) <= 20);
}

#[test]
fn a_stray_box_does_not_put_all_others_into_one_cell() {
    let boxes = uniform(10_000);
    let cost = |boxes: &[Aabb3d]| {
        let built = Built::of(BuildStrategy::Ploc, 1, boxes);
        built.validate(1, boxes);
        (sah_cost(&built.nodes, 0), built.nodes[0].bounds())
    };
    let (alone, bounds) = cost(&boxes);
    let mut with_stray = boxes;
    with_stray.push(aabb(Vec3A::splat(1e7), Vec3A::ONE));
    let (cost, all_bounds) = cost(&with_stray);
    let area = |aabb: &Aabb3d| {
        let size = (aabb.max - aabb.min).as_dvec3();
        size.x * size.y + size.y * size.z + size.z * size.x
    };
    let (cost, alone) = (cost * area(&all_bounds), alone * area(&bounds));
    // The box around all is in neither sum, but one around all others may be.
    assert!(cost < 1.1 * alone, "{cost} {alone}");
}

#[test]
fn bottom_up_is_as_good_as_the_binned_heuristic_and_both_better_than_halves() {
    let boxes = uniform(5000);
    let cost = |strategy| sah_cost(&Built::of(strategy, 1, &boxes).nodes, 0);
    assert!(cost(BuildStrategy::Ploc) < 1.1 * cost(BuildStrategy::BinnedSah));
    assert!(cost(BuildStrategy::BinnedSah) < cost(BuildStrategy::MedianSplit));
    assert!(cost(BuildStrategy::BinnedSah) < cost(BuildStrategy::MiddleSplit));
}

#[test]
fn nodes_have_more_than_five_children_on_average() {
    for count in [1000, 10_000] {
        let boxes = uniform(count);
        for strategy in STRATEGIES {
            let nodes = Built::of(strategy, 1, &boxes).nodes;
            let children: usize = nodes.iter().map(WideNode::len).sum();
            assert!(children as f32 / nodes.len() as f32 > 5.0, "{strategy:?}");
        }
    }
}

#[test]
fn a_second_build_of_the_same_size_takes_no_more_memory() {
    let boxes = uniform(5000);
    for strategy in STRATEGIES {
        let mut built = Built::of(strategy, 1, &boxes);
        // The items and their copy may have changed places.
        let memory = |built: &Built| built.builder.memory() + built.items.capacity() * size_of::<BuildItem>();
        let before = memory(&built);
        built.build(strategy, 1, &boxes);
        built.validate(1, &boxes);
        assert_eq!(memory(&built), before, "{strategy:?}");
    }
}

#[test]
fn one_builder_serves_one_strategy_and_size_after_another() {
    let mut built = Built::default();
    for (turn, count) in [300, 20, 0, 1000, 1, 5000].into_iter().enumerate() {
        let boxes = uniform(count);
        let leaf_size = 1 + turn % 3;
        for strategy in STRATEGIES {
            built.build(strategy, leaf_size, &boxes);
            built.validate(leaf_size, &boxes);
        }
    }
}

#[test]
fn the_cost_counts_every_box_by_its_share_of_the_area() {
    let cube = |x: f32| aabb(Vec3A::X * x, Vec3A::ONE);
    let built = Built::of(BuildStrategy::Ploc, 1, &[cube(0.0), cube(2.0)]);
    // Two faces of 1 and four of 3 around two cubes of six faces.
    assert!((sah_cost(&built.nodes, 0) - 12.0 / 14.0).abs() < 1e-9);
    assert_eq!(sah_cost(&[], 0), 0.0);
    let points = vec![aabb(Vec3A::ONE, Vec3A::ZERO); 3];
    assert_eq!(sah_cost(&Built::of(BuildStrategy::Ploc, 1, &points).nodes, 0), 3.0);
}

#[test]
fn morton_codes_halve_the_longest_side_first_whatever_the_shape() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for size in [
        [1.0, 1.0, 1.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.1, 0.01, 1.0],
        [1e-9, 1.0, 0.6],
    ] {
        let size = Vec3A::from_array(size) * 1000.0;
        let grid_bounds = Aabb3d {
            min: Vec3A::ZERO,
            max: size,
        };
        let items: [BuildItem; 8 * LANES] = std::array::from_fn(|_| {
            let point = size * Vec3A::new(rng.random(), rng.random(), rng.random());
            BuildItem::new(&aabb(point * 0.5, Vec3A::ZERO), 0, 0)
        });
        for code_bits in [22, 31] {
            let grid = MortonGrid::new(&grid_bounds, code_bits).expect("the points do not coincide");
            let codes = |items: &[BuildItem]| grid.codes(items.try_into().expect("eight items"));
            let codes: Vec<_> = items.chunks(LANES).flat_map(codes).collect();
            assert!(codes.iter().all(|code| code >> code_bits == 0));
            let axis = size.max_position();
            let mut along: Vec<_> = items
                .iter()
                .map(|item| item.doubled_center()[axis])
                .zip(codes)
                .collect();
            along.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (low, high): (Vec<_>, Vec<_>) = along.into_iter().partition(|(x, _)| *x < 500.0);
            let most = low.iter().map(|(_, code)| code).max();
            assert!(most < high.iter().map(|(_, code)| code).min(), "{size} {code_bits}");
        }
    }
}

/// Everything that clustering alone asks of [`Simd`].
struct TagsAndColumns<'a>([&'a [f32; 4]; LANES]);

impl Task for TagsAndColumns<'_> {
    type Output = [[u32; LANES]; 8];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let columns = simd.transpose(self.0);
        let tagged = columns.map(|column| simd.tag(column, 7, &[0, 1, 2, 3, 4, 5, 6, 7]));
        let bits = |values: S::F32s| simd.store(values).map(f32::to_bits);
        let ([a, b, c, d], [e, f, g, h]) = (columns, tagged);
        [bits(a), bits(b), bits(c), bits(d), bits(e), bits(f), bits(g), bits(h)]
    }
}

#[test]
fn wide_and_portable_instructions_transpose_and_tag_alike() {
    let rows: [[f32; 4]; LANES] = std::array::from_fn(|row| {
        std::array::from_fn(|column| f32::from_bits((row * 4 + column) as u32 * 0x07f1_2345))
    });
    let portable = TagsAndColumns(rows.each_ref()).run(Portable);
    assert_eq!(simd::dispatch(TagsAndColumns(rows.each_ref())), portable);
    for (row, values) in rows.iter().enumerate() {
        for (column, value) in values.iter().enumerate() {
            assert_eq!(portable[column][row], value.to_bits());
            assert_eq!(portable[4 + column][row], value.to_bits() & !7 | row as u32);
        }
    }
}

/// Boxes that are sorted, coincide, touch, are flat, far away, or of wildly different sizes, as the numbers come.
fn boxes() -> impl Strategy<Value = Vec<Aabb3d>> {
    let coordinate = prop_oneof![
        4 => -10.0..10.0_f32,
        2 => (-3..3_i8).prop_map(f32::from),
        1 => Just(0.0),
        1 => -1e7..1e7_f32,
        1 => -1e-20..1e-20_f32,
    ];
    let size = prop_oneof![4 => 0.0..1.0_f32, 2 => Just(0.0), 1 => Just(1.0), 1 => 0.0..1e7_f32, 1 => 0.0..1e-3_f32];
    let one = (prop::array::uniform3(coordinate), prop::array::uniform3(size))
        .prop_map(|(min, size)| aabb(min.into(), size.into()));
    (prop::collection::vec(one, 1..300), any::<bool>()).prop_map(|(mut boxes, sorted)| {
        if sorted {
            boxes.sort_by(|a, b| a.min.x.total_cmp(&b.min.x));
        }
        boxes
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: std::env::var("PROPERTY_CASES").map_or(200, |cases| cases.parse().expect("a number")),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_boxes_make_sound_hierarchies(boxes in boxes(), strategy in 0..5_usize, leaf_size in 1..8_usize) {
        let built = Built::of(STRATEGIES[strategy], leaf_size, &boxes);
        prop_assert!(built.validate(leaf_size, &boxes) <= 60);
    }
}

#[test]
fn many_workers_build_what_one_builds() {
    for boxes in [uniform(70_000), vec![aabb(Vec3A::ONE, Vec3A::ONE); 70_000]] {
        for strategy in STRATEGIES {
            let alone = Built::of(strategy, 6, &boxes);
            let mut together = Built {
                workers: &Two,
                ..Built::default()
            };
            together.build(strategy, 6, &boxes);
            assert_eq!(together.leaves, alone.leaves, "{strategy:?}");
            let order = |built: &Built| built.items.iter().map(BuildItem::index).collect::<Vec<_>>();
            assert!(order(&together) == order(&alone), "{strategy:?}");
            for (node, same) in together.nodes.iter().zip(&alone.nodes) {
                assert_eq!((node.min, node.max, node.children), (same.min, same.max, same.children));
            }
        }
    }
}

#[test]
fn moving_nodes_makes_hierarchies_better() {
    let boxes = uniform(5000);
    for leaf_size in [1, 6] {
        let cost = |strategy| sah_cost(&Built::of(strategy, leaf_size, &boxes).nodes, 0);
        assert!(cost(BuildStrategy::Reinsertion) < 0.97 * cost(BuildStrategy::BinnedSah));
        assert!(cost(BuildStrategy::Reinsertion) < 0.97 * cost(BuildStrategy::Ploc));
    }
}

/// Calls a build off after some of its errands.
struct Impatient {
    left: std::sync::atomic::AtomicUsize,
    progress: BuildProgress,
}

impl Workers for &Impatient {
    fn count(&self) -> usize {
        2
    }

    fn run(&self, errands: Vec<Errand<'_>>) {
        use std::sync::atomic::Ordering;
        for errand in errands {
            if self.left.fetch_sub(1, Ordering::Relaxed) == 1 {
                self.progress.cancel();
            }
            errand();
        }
    }
}

#[test]
fn a_build_that_is_called_off_ends_with_an_error_and_the_next_one_is_sound() {
    let boxes = uniform(70_000);
    for strategy in STRATEGIES {
        for errands in 1..4 {
            let impatient = Impatient {
                left: errands.into(),
                progress: BuildProgress::default(),
            };
            let order = Order {
                workers: &&impatient,
                progress: Some(&impatient.progress),
                ..Order::new(strategy, leaves(6))
            };
            let mut items: Vec<_> = (0..)
                .zip(&boxes)
                .map(|(index, aabb)| BuildItem::new(aabb, 1, index))
                .collect();
            let mut built = Built::default();
            let result = built
                .builder
                .build(&order, &mut items, &mut built.nodes, |_, _, _, _| 0, |_, _, _| {});
            if impatient.progress.is_cancelled() {
                assert_eq!(result, Err(Cancelled), "{strategy:?}");
                assert!(impatient.progress.fraction() < 1.0);
            } else {
                assert!(strategy == BuildStrategy::Ploc, "{strategy:?} has few errands");
            }
            let few = uniform(300);
            built.build(strategy, 6, &few);
            built.validate(6, &few);
        }
    }
}
