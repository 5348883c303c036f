//! One tree over the triangles of all instances, beside two levels of trees; see the README beside this file.

use std::hint::black_box;
use std::time::Instant;

use lobe_scene::{Bvh, Ray};
use lobe_testkit::Random;

#[path = "rays/workload.rs"]
mod workload;

use workload::{RAYS_PER_POINT, Workload};

/// Turns of the clock for each measurement; the quickest counts, because nothing else is in it.
const TURNS: usize = 3;

/// Instances along x and along y, vertices around each ball, and the distance of neighbors: apart, or one through another.
const CASES: [(usize, usize, f32); 3] = [(8, 128, 2.5), (32, 32, 2.5), (32, 32, 1.2)];

/// A mesh at a place: `x ↦ R x + center`.
struct Instance {
    /// The rows of `R`, a rotation.
    rotation: [[f32; 3]; 3],
    center: [f32; 3],
}

/// A box, and the two nodes or the one instance in it.
struct Node {
    min: [f32; 3],
    max: [f32; 3],
    inside: Inside,
}

#[derive(Clone, Copy)]
enum Inside {
    Nodes(usize, usize),
    Instance(usize),
}

/// The tree of one mesh, and a binary tree over the boxes of its instances.
struct TwoLevels {
    mesh: Bvh,
    instances: Vec<Instance>,
    nodes: Vec<Node>,
    root: usize,
}

impl TwoLevels {
    fn new(mesh: &[[[f32; 3]; 3]], instances: Vec<Instance>) -> Self {
        let boxes: Vec<_> = instances.iter().map(|instance| bounds(mesh, instance)).collect();
        let mut levels = Self { mesh: Bvh::from_corners(mesh), instances, nodes: Vec::new(), root: 0 };
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        levels.root = levels.build(&boxes, &mut order);
        levels
    }

    /// Halves the instances in the middle of the longest axis of their centers.
    fn build(&mut self, boxes: &[([f32; 3], [f32; 3])], order: &mut [usize]) -> usize {
        let node = |min, max, inside| Node { min, max, inside };
        let whole = order.iter().map(|&i| boxes[i]).reduce(|a, b| {
            let least = |k: usize| a.0[k].min(b.0[k]);
            let most = |k: usize| a.1[k].max(b.1[k]);
            ([0, 1, 2].map(least), [0, 1, 2].map(most))
        });
        let (min, max) = whole.expect("an instance");
        let new = if let [one] = order {
            node(min, max, Inside::Instance(*one))
        } else {
            let axis = (0..3).max_by(|&a, &b| (max[a] - min[a]).total_cmp(&(max[b] - min[b]))).unwrap_or(0);
            let middle = |i: usize| boxes[i].0[axis] + boxes[i].1[axis];
            order.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)));
            let (left, right) = order.split_at_mut(order.len() / 2);
            let children = Inside::Nodes(self.build(boxes, left), self.build(boxes, right));
            node(min, max, children)
        };
        self.nodes.push(new);
        self.nodes.len() - 1
    }

    /// Whether the half lines from a point are occluded. Those that meet a box go on together, as bundles do in one tree.
    fn occluded(&self, origin: [f32; 3], directions: &[[f32; 3]], occluded: &mut [bool]) {
        occluded.fill(false);
        let mut stack = vec![(self.root, (0..directions.len()).collect::<Vec<_>>())];
        while let Some((node, rays)) = stack.pop() {
            let Node { min, max, inside } = &self.nodes[node];
            let meets = |r: &usize| !occluded[*r] && meets_box(origin, directions[*r], *min, *max, f32::INFINITY);
            let rays: Vec<usize> = rays.into_iter().filter(meets).collect();
            if rays.is_empty() {
                continue;
            }
            match *inside {
                Inside::Nodes(left, right) => stack.extend([(left, rays.clone()), (right, rays)]),
                Inside::Instance(i) => {
                    let instance = &self.instances[i];
                    let own: Vec<_> = rays.iter().map(|&r| instance.direction_to_own(directions[r])).collect();
                    let mut found = vec![false; own.len()];
                    self.mesh.occluded_from_into(instance.point_to_own(origin), &own, &mut found);
                    rays.iter().zip(found).for_each(|(&r, found)| occluded[r] |= found);
                }
            }
        }
    }

    /// The distance of the closest hit; infinite without one.
    fn closest(&self, origin: [f32; 3], direction: [f32; 3]) -> f32 {
        let (mut nearest, mut stack) = (f32::INFINITY, vec![self.root]);
        while let Some(node) = stack.pop() {
            let Node { min, max, inside } = &self.nodes[node];
            if !meets_box(origin, direction, *min, *max, nearest) {
                continue;
            }
            match *inside {
                // The nearer one is looked at first.
                Inside::Nodes(left, right) => {
                    let along = |n: usize| {
                        let Node { min, max, .. } = &self.nodes[n];
                        (0..3).map(|k| direction[k] * (min[k] + max[k])).sum::<f32>()
                    };
                    let is_left_first = along(left) < along(right);
                    stack.extend(if is_left_first { [right, left] } else { [left, right] });
                }
                Inside::Instance(i) => {
                    let instance = &self.instances[i];
                    let ray = Ray::new(instance.point_to_own(origin), instance.direction_to_own(direction));
                    if let Some(hit) = self.mesh.closest(&Ray { t_max: nearest, ..ray }) {
                        nearest = hit.t;
                    }
                }
            }
        }
        nearest
    }
}

impl Instance {
    fn place(&self, p: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|k| (0..3).map(|j| self.rotation[k][j] * p[j]).sum::<f32>() + self.center[k])
    }

    fn direction_to_own(&self, d: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|k| (0..3).map(|j| self.rotation[j][k] * d[j]).sum())
    }

    fn point_to_own(&self, p: [f32; 3]) -> [f32; 3] {
        self.direction_to_own(std::array::from_fn(|k| p[k] - self.center[k]))
    }
}

fn bounds(mesh: &[[[f32; 3]; 3]], instance: &Instance) -> ([f32; 3], [f32; 3]) {
    let mut found = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in mesh.as_flattened().iter().map(|p| instance.place(*p)) {
        for k in 0..3 {
            (found.0[k], found.1[k]) = (found.0[k].min(p[k]), found.1[k].max(p[k]));
        }
    }
    found
}

fn meets_box(origin: [f32; 3], direction: [f32; 3], min: [f32; 3], max: [f32; 3], t_max: f32) -> bool {
    let (mut enters, mut leaves) = (0.0_f32, t_max);
    for k in 0..3 {
        let [a, b] = [min[k], max[k]].map(|side| (side - origin[k]) / direction[k]);
        (enters, leaves) = (enters.max(a.min(b)), leaves.min(a.max(b)));
    }
    enters <= leaves
}

/// Balls in a square, each turned by chance.
fn crowd(side: usize, distance: f32) -> Vec<Instance> {
    let mut random = Random::new(5);
    let instance = |i: usize| {
        let [w, x, y, z] = random.quaternion().map(|c| c as f32);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Instance { rotation, center: [(i % side) as f32 * distance, (i / side) as f32 * distance, 0.0] }
    };
    (0..side * side).map(instance).collect()
}

/// The least seconds that work takes in some turns.
fn seconds<T>(mut work: impl FnMut() -> T) -> f64 {
    let turn = |_| {
        let start = Instant::now();
        black_box(work());
        start.elapsed().as_secs_f64()
    };
    (0..TURNS).map(turn).fold(f64::INFINITY, f64::min)
}

fn main() {
    println!(
        "instances  triangles  build s/M  build two s  bytes of both  occluded  rays: one, two, ratio  closest: ratio"
    );
    for (side, around, distance) in CASES {
        let (mesh, instances) = (workload::dented_ball(around), crowd(side, distance));
        let corners: Vec<_> = instances.iter().flat_map(|i| mesh.iter().map(|t| t.map(|p| i.place(p)))).collect();
        let work = Workload::among(corners);
        let (one, two) = (Bvh::from_corners(&work.corners), TwoLevels::new(&mesh, instances));
        let millions = work.corners.len() as f64 / 1e6;
        let build = seconds(|| Bvh::from_corners(&work.corners)) / millions;
        let build_two = seconds(|| TwoLevels::new(&mesh, crowd(side, distance)));
        let bytes = [one.bytes(), two.mesh.bytes() + two.nodes.len() * size_of::<Node>()];
        let rays = (work.points.len() * RAYS_PER_POINT) as f64;
        let mut occluded = vec![false; RAYS_PER_POINT];
        let count = |occluded: &[bool]| occluded.iter().filter(|&&o| o).count();
        let mut by_one = |from, to: &[[f32; 3]]| {
            one.occluded_from_into(from, to, &mut occluded);
            count(&occluded)
        };
        let found = work.count(&mut by_one);
        let rate_one = rays / seconds(|| work.count(&mut by_one)) / 1e6;
        let mut by_two = |from, to: &[[f32; 3]]| {
            two.occluded(from, to, &mut occluded);
            count(&occluded)
        };
        let found_two = work.count(&mut by_two);
        let rate_two = rays / seconds(|| work.count(&mut by_two)) / 1e6;
        let hits = |t: f32| usize::from(t.is_finite());
        let closest_one = seconds(|| {
            work.count(|from, to| to.iter().filter(|&&d| one.closest(&Ray::new(from, d)).is_some()).count())
        });
        let closest_two = seconds(|| work.count(|from, to| to.iter().map(|&d| hits(two.closest(from, d))).sum()));
        println!(
            "{:9}  {:9}  {build:9.3}  {build_two:11.4}  {:?}  {:.4} {:.4}  {rate_one:.2} {rate_two:.2} M/s, {:.2}  {:.2}",
            side * side,
            work.corners.len(),
            bytes,
            found as f64 / rays,
            found_two as f64 / rays,
            rate_one / rate_two,
            closest_two / closest_one,
        );
    }
}
