//! What a packet is told of leaves, against what each of its rays is told alone.

use bevy::math::{Vec3A, bounding::Aabb3d};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::spatial::{
    Visit,
    lanes::Entering,
    simd::Portable,
    traverse::{visit_in_order, visit_in_order_with},
    wide::EVERY_MASK,
};

/// A ray, a leaf, and the bits of where it is met.
type Meeting = (usize, u32, u32);

/// Writes down every meeting.
struct Recorder<'a> {
    nodes: &'a [WideNode],
    rays: &'a [Ray],
    meetings: &'a mut Vec<Meeting>,
}

impl VisitRays for Recorder<'_> {
    fn visit<S: Simd>(&mut self, _simd: S, leaf: u32, rays: u32, at: &PerRay<f32>, _limits: &mut PerRay<f32>) {
        let met = (0..RAYS).filter(|ray| rays >> ray & 1 != 0);
        let meeting = |ray: usize| (ray, leaf, at[ray / LANES][ray % LANES].to_bits());
        self.meetings.extend(met.map(meeting));
    }

    fn visit_below<S: Simd>(&mut self, simd: S, node: NodeIndex, ray: usize, limit: &mut f32) {
        let approach = Entering::new(&self.rays[ray]);
        visit_in_order_with(simd, self.nodes, node, *limit, approach, |leaf, at: f32| {
            self.meetings.push((ray, leaf, at.to_bits()));
            Visit::Continue
        });
    }

    fn prefetch(&self, _leaf: u32) {}
}

fn meetings(nodes: &[WideNode], rays: &[Ray]) -> Vec<Meeting> {
    let mut meetings = Vec::new();
    let visit = Recorder {
        nodes,
        rays,
        meetings: &mut meetings,
    };
    visit_together(nodes, rays, visit);
    // A ray that goes on alone when others have may come to a leaf twice.
    meetings.sort_unstable();
    meetings.dedup();
    meetings
}

fn meetings_one_by_one(nodes: &[WideNode], rays: &[Ray]) -> Vec<Meeting> {
    let mut meetings = Vec::new();
    for (index, ray) in rays.iter().enumerate() {
        visit_in_order(
            nodes,
            0,
            EVERY_MASK,
            ray.t_max(),
            Entering::new(ray),
            |leaf, at: f32| {
                meetings.push((index, leaf, at.to_bits()));
                Visit::Continue
            },
        );
    }
    meetings.sort_unstable();
    meetings
}

/// A root with up to eight nodes of up to eight boxes on a lattice, many of them flat.
fn random_hierarchy(rng: &mut ChaCha8Rng, scale: f32) -> Vec<WideNode> {
    let mut nodes = vec![WideNode::EMPTY];
    let corner = |rng: &mut ChaCha8Rng| {
        Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-4.0_f32..=4.0).round())) * scale
    };
    for child in 1..=rng.random_range(1..=LANES as u32) {
        let mut node = WideNode::EMPTY;
        for leaf in 0..rng.random_range(1..=LANES as u32) {
            let (a, b) = (corner(rng), corner(rng));
            let aabb = Aabb3d {
                min: a.min(b),
                max: a.max(b),
            };
            node.push(&aabb, EVERY_MASK, Child::Leaf(child * 8 + leaf));
        }
        nodes[0].push(&node.bounds(), EVERY_MASK, Child::Node(child));
        nodes.push(node);
    }
    nodes
}

/// Rays that go together, some alongside the axes, from a common origin or from all over, in the planes of faces.
fn random_rays(rng: &mut ChaCha8Rng, scale: f32) -> Vec<Ray> {
    let signs: [f32; 3] = std::array::from_fn(|_| if rng.random() { 1.0 } else { -1.0 });
    let (spread, wide) = (rng.random_range(0.0..=1.0_f32), rng.random_range(0.0..=6.0_f32));
    let vanishes: [f32; 3] = std::array::from_fn(|_| rng.random_range(0.0..=1.5_f32).powi(4));
    let from = Vec3A::from_array(signs) * -6.0;
    let mut ray = || {
        let direction = Vec3A::from_array(std::array::from_fn(|axis| {
            let vanishes = signs[axis] > 0.0 && rng.random_range(0.0..=1.0) > vanishes[axis];
            signs[axis]
                * if vanishes {
                    0.0
                } else {
                    0.5 + spread * rng.random_range(-0.499..=0.5_f32)
                }
        }));
        let offset = Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-wide..=wide)));
        let offset = if rng.random() { offset.round() } else { offset };
        let t_max = if rng.random() {
            f32::INFINITY
        } else {
            rng.random_range(0.0..=12.0)
        };
        let ray = Ray::new((from + offset) * scale, direction * scale, t_max)?;
        Some(ray.with_interval(if rng.random() { 0.0 } else { rng.random_range(0.0..=4.0) }, t_max))
    };
    (0..RAYS).filter_map(|_| ray()).collect()
}

fn for_random_packets(mut check: impl FnMut(&[WideNode], &[Ray])) {
    let mut rng = ChaCha8Rng::seed_from_u64(90);
    let mut together = 0;
    for scale in [1.0, 0.1, 1e-6, 1e6, 1e-18, 1e18, 1e-38] {
        for _ in 0..400 {
            let nodes = random_hierarchy(&mut rng, scale);
            let rays = random_rays(&mut rng, scale);
            let count = rng.random_range(0..=rays.len());
            if go_together(&rays[..count]) {
                check(&nodes, &rays[..count]);
                together += 1;
            }
        }
    }
    assert!(together > 1_000, "only {together}");
}

#[test]
fn each_ray_of_a_packet_is_told_what_it_would_be_told_alone() {
    let mut count = 0;
    for_random_packets(|nodes, rays| {
        let expected = meetings_one_by_one(nodes, rays);
        count += expected.len();
        assert_eq!(meetings(nodes, rays), expected, "{rays:?}");
    });
    assert!(count > 10_000, "only {count}");
}

#[test]
fn wide_and_portable_instructions_take_packets_the_same_way() {
    for_random_packets(|nodes, rays| {
        let (mut wide, mut portable) = (Vec::new(), Vec::new());
        let task = |meetings| Together {
            nodes,
            rays,
            visit: Recorder { nodes, rays, meetings },
        };
        dispatch(task(&mut wide));
        task(&mut portable).run(Portable);
        assert_eq!(wide, portable);
    });
}

#[test]
fn only_rays_that_do_not_run_against_each_other_go_together() {
    let ray = |direction: [f32; 3]| Ray::new(Vec3A::ZERO, Vec3A::from_array(direction), 1.0).expect("a ray");
    assert!(go_together(&[ray([1.0, 2.0, -3.0]), ray([3.0, 0.0, -1.0])]));
    assert!(!go_together(&[ray([1.0, 2.0, -3.0]), ray([1.0, 2.0, 3.0])]));
    assert!(!go_together(&[ray([0.0, 1.0, 0.0]), ray([-0.1, 1.0, 0.0])]));
}
