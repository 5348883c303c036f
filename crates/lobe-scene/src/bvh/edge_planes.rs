//! Edge-plane test of eight triangles against many rays from one point.

use crate::bvh::lanes::{Lanes, WIDTH};
use crate::bvh::ray_frame::{BundledRay, ROUNDING, numbers};

/// Planes through a point and the edges of eight triangles.
///
/// ```text
///   A = a - o,   N_A = ± B × C, likewise N_B, N_C,   the sign that of V = A · (B × C)
///   U_A = d · N_A, likewise U_B, U_C
///   the half line from o along d hits the triangle if U_A, U_B, U_C ≥ 0
/// ```
///
/// because `d = Σ U_i i / |V|` is then within the cone of A, B and C, and is not otherwise. The planes are computed
/// once for all rays from the point; each ray costs nine fused operations a triangle. They decide only where rounding
/// leaves no doubt about the result of [`ShearedRay::hit`](crate::bvh::watertight::ShearedRay::hit):
///
/// ```text
///   least U > τ                  certain hit
///   least U < -τ                 certain miss
///   else, or |V| ≤ τ m           uncertain
///   τ = 32 ε m²,   m = max(|A|, |B|, |C|)
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgePlanes<L: Lanes> {
    /// `N_A`, `N_B`, `N_C`.
    normals: [[L::Vector; 3]; 3],
    /// `τ`.
    room: L::Vector,
    /// Lanes whose `V` has a certain sign.
    certain: u32,
}

// Derivation of these bounds, with ε = 2⁻²⁴, |d_x|, |d_y|, |d_z| ≤ 1 and one of them 1, and A, B, C the rounded
// differences from which both tests start. Each line is for the worst order of operations, none fused.
//
// Error of `hit`. A'_x = A_x - S A_z rounds the product and the difference, by ε (|A_x| + 2 |A_z|) ≤ √5 ε |A| in all;
// A'_y likewise. Its edge functions and V' of those corners are in `f64`: the signs of the former are right, the latter
// is off by some 2⁻⁵⁰ m³. So it tests a triangle whose corners are moved by at most √10 ε m < 3.3 ε m:
//     |U' - U| ≤ |d| (|B| 3.3 ε m + |C| 3.3 ε m) ≤ √3 · 6.6 ε m² < 11.5 ε m²
//     |V' - V| ≤ 3 · 3.3 ε m · m² < 10 ε m³
// Error of the planes. Each component of B × C is off by ε (|B_i C_j| + |B_j C_i|) + ε |N_k| ≤ 2 ε m²; d · N adds up
// three of them and rounds three times, A · N likewise:
//     U is off by 3 · 2 ε m² + 3 ε Σ |d_k N_k| ≤ (6 + 3 √3) ε m² < 11.3 ε m²
//     V is off by √3 · 2 ε m³ + 3 ε m³ < 6.5 ε m³
// Together 23 ε m² and 17 ε m³; with 32, the roundings of τ itself do not matter. Where numbers are so small that
// products lose digits, or vanish, the bounds of TINY exceed the loss.
//
// A certain hit is a hit for `hit`: U'_A, U'_B, U'_C have the sign of V', so they do not differ nor sum to 0, and
// t = V' / (U'_A + U'_B + U'_C) / d_z is positive. It does not round to 0 either: V' > 15 ε m³ and the sum is at most
// 3 √3 m², so the depth is above 2 ε m; V > TINY[1] needs m > 10⁻¹¹; and directions are no longer than LONGEST.

/// `τ / m²`.
const ROOM: f32 = 32.0 * ROUNDING;

/// The least tolerance of edge functions and of volumes.
const TINY: [f32; 2] = [1e-36, 1e-30];

const ALL: u32 = (1 << WIDTH) - 1;

impl<L: Lanes> EdgePlanes<L> {
    /// The planes through `origin` and triangles, corner by corner, axis and lane.
    #[inline(always)]
    pub(crate) fn new(lanes: L, corners: &[[[f32; WIDTH]; 3]; 3], origin: [f32; 3]) -> Self {
        let origin = origin.map(|o| lanes.splat(o));
        let relative = |c: usize| std::array::from_fn(|k| lanes.sub(lanes.load(&corners[c][k]), origin[k]));
        let [a, b, c] = std::array::from_fn(relative);
        let normals = [cross(lanes, &b, &c), cross(lanes, &c, &a), cross(lanes, &a, &b)];
        let square = |v| dot(lanes, v, v);
        let most = lanes.max(lanes.max(square(&a), square(&b)), square(&c));
        let [tiny, tiny_volume] = TINY.map(|t| lanes.splat(t));
        let factor = lanes.splat(ROOM);
        let room = lanes.mul_add(most, factor, tiny);
        let volume_room = lanes.mul_add(lanes.mul(most, lanes.sqrt(most)), factor, tiny_volume);
        let volume = dot(lanes, &a, &normals[0]);
        let size = lanes.copy_sign(volume, lanes.splat(1.0));
        // An infinite one may have lost its sign.
        let certain = lanes.less(volume_room, size) & lanes.less(size, lanes.splat(f32::INFINITY));
        let sign = lanes.copy_sign(lanes.splat(1.0), volume);
        Self { normals: normals.map(|n| n.map(|c| lanes.mul(c, sign))), room, certain }
    }

    /// The rays of a set that certainly hit a triangle, and for each triangle the rays that may hit it.
    #[inline(always)]
    pub(crate) fn hits(&self, lanes: L, rays: &[BundledRay], set: u64) -> (u64, [u64; WIDTH]) {
        let below = lanes.sub(lanes.splat(0.0), self.room);
        let [mut sure, mut possible, mut reversed] = [lanes.empty_sets(); 3];
        for number in numbers(set) {
            let d = rays[number].direction.map(|d| lanes.splat(d));
            let [u, v, w] = [0, 1, 2].map(|k| dot(lanes, &d, &self.normals[k]));
            let least = lanes.min(lanes.min(u, v), w);
            possible = lanes.insert_where(possible, below, least, number);
            sure = lanes.insert_where(sure, self.room, least, number);
            if self.certain != ALL {
                let most = lanes.max(lanes.max(u, v), w);
                reversed = lanes.insert_where(reversed, most, self.room, number);
            }
        }
        let [sure, mut possible, reversed] = [sure, possible, reversed].map(|sets| lanes.store_sets(sets));
        let mut hit = 0;
        for k in 0..WIDTH {
            if self.certain >> k & 1 != 0 {
                hit |= sure[k];
            } else {
                possible[k] |= reversed[k];
            }
        }
        (hit, possible.map(|rays| rays & !hit))
    }
}

impl<L: Lanes> EdgePlanes<L> {
    /// For each triangle the rays of a set that may hit it: all but certain misses.
    #[inline(always)]
    pub(crate) fn may_hit(&self, lanes: L, rays: &[BundledRay], set: u64) -> [u64; WIDTH] {
        let below = lanes.sub(lanes.splat(0.0), self.room);
        let [mut possible, mut reversed] = [lanes.empty_sets(); 2];
        for number in numbers(set) {
            let d = rays[number].direction.map(|d| lanes.splat(d));
            let [u, v, w] = [0, 1, 2].map(|k| dot(lanes, &d, &self.normals[k]));
            possible = lanes.insert_where(possible, below, lanes.min(lanes.min(u, v), w), number);
            if self.certain != ALL {
                reversed = lanes.insert_where(reversed, lanes.max(lanes.max(u, v), w), self.room, number);
            }
        }
        let [mut possible, reversed] = [possible, reversed].map(|sets| lanes.store_sets(sets));
        for k in 0..WIDTH {
            if self.certain >> k & 1 == 0 {
                possible[k] |= reversed[k];
            }
        }
        possible
    }
}

#[inline(always)]
fn cross<L: Lanes>(lanes: L, a: &[L::Vector; 3], b: &[L::Vector; 3]) -> [L::Vector; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        lanes.mul_sub(a[i], b[j], lanes.mul(a[j], b[i]))
    })
}

#[inline(always)]
fn dot<L: Lanes>(lanes: L, a: &[L::Vector; 3], b: &[L::Vector; 3]) -> L::Vector {
    lanes.mul_add(a[0], b[0], lanes.mul_add(a[1], b[1], lanes.mul(a[2], b[2])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::lanes::Simd;
    use crate::bvh::lanes::{Machine, Work};
    use crate::bvh::ray_frame::RayOrigin;
    use crate::bvh::watertight::ShearedRay;
    use crate::bvh::wide_node::Block;
    use crate::scene::ray::Ray;
    use crate::scene::scene::Bounds;
    use lobe_testkit::Random;

    struct Hits<'a>(&'a Block, [f32; 3], &'a [BundledRay]);

    impl Work for Hits<'_> {
        type Output = (u64, [u64; WIDTH]);

        #[inline(always)]
        fn work<L: Lanes>(self, lanes: L) -> Self::Output {
            let set = !0 >> (64 - self.2.len());
            EdgePlanes::new(lanes, self.0.corners(), self.1).hits(lanes, self.2, set)
        }
    }

    fn point(random: &mut Random, scale: f64) -> [f32; 3] {
        [0; 3].map(|_| (scale * random.signed()) as f32)
    }

    /// Directions from `origin` to corners, edges and interiors of the triangles, to points near them, and anywhere.
    fn directions(random: &mut Random, triangles: &[[[f32; 3]; 3]], origin: [f32; 3], scale: f64) -> Vec<[f32; 3]> {
        (0..64)
            .map(|i| {
                let [a, b, c] = triangles[i % WIDTH];
                let [u, v] = [[0.0, 0.0], [0.5, 0.5], [0.25, 0.75], [0.25, 0.5], [0.5, 1e-7], [1.1, 0.1]][i / 8 % 6];
                let aim: [f32; 3] = std::array::from_fn(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
                let forward = if i % 3 == 0 { -1.0 } else { 1.0 };
                let aim = if i < 48 { aim } else { point(random, scale) };
                std::array::from_fn(|k| forward * (aim[k] - origin[k]))
            })
            .collect()
    }

    /// Calls `check` with blocks, origins of rays, and 64 directions from each.
    fn for_each_case(mut check: impl FnMut(&str, &Block, [f32; 3], &[[f32; 3]])) {
        let mut random = Random::new(21);
        for case in 0..4000 {
            let scale = [1.0, 1e-15, 1e-9, 1e5, 1e12, 1e15][case % 6];
            let size = [1.0, 1e-2, 1e-5][case / 6 % 3];
            let triangles: [[[f32; 3]; 3]; WIDTH] = std::array::from_fn(|_| {
                let center = point(&mut random, scale);
                [(); 3].map(|()| {
                    let corner = point(&mut random, scale * size);
                    std::array::from_fn(|k| center[k] + corner[k])
                })
            });
            let [a, b, c] = triangles[0];
            // At a corner, within a triangle, in its plane, far away, and anywhere.
            let origin = match case / 18 % 5 {
                0 => a,
                1 => std::array::from_fn(|k| a[k] / 2.0 + (b[k] + c[k]) / 4.0),
                2 => std::array::from_fn(|k| b[k] + c[k] - a[k]),
                3 => point(&mut random, 100.0 * scale),
                _ => point(&mut random, scale),
            };
            let block = Block::new((0..).zip(triangles));
            let name = format!("case {case}, scale {scale}, size {size}");
            check(&name, &block, origin, &directions(&mut random, &triangles, origin, scale));
        }
    }

    #[test]
    fn planes_are_sure_of_nothing_that_single_rays_deny_and_miss_nothing_they_hit() {
        let bounds = Bounds { min: [-2e15; 3], max: [2e15; 3] };
        let (mut hits, mut unsure_hits) = (0, 0);
        let machines: Vec<Machine> = Simd::ALL.into_iter().filter_map(Machine::new).collect();
        println!("{} of {} kinds of vector instructions: this machine has no others", machines.len(), Simd::ALL.len());
        for_each_case(|name, block, origin, directions| {
            let start = RayOrigin::new(origin, &bounds);
            let frames: Vec<_> = directions.iter().map(|&d| start.frame(d)).collect();
            let rays: Vec<_> = frames
                .iter()
                .map(|f| BundledRay { reciprocal: f.reciprocal, direction: f.direction, ..BundledRay::default() })
                .collect();
            for &machine in &machines {
                let (sure, unsure) = machine.run(Hits(block, origin, &rays));
                for (k, frame) in frames.iter().enumerate().filter(|(_, frame)| frame.longest > 0.0) {
                    let ray = ShearedRay::new(origin, frame, f32::INFINITY);
                    let lanes: Vec<usize> = (0..WIDTH).filter(|&lane| block.hit(&ray, lane).is_some()).collect();
                    let is_sure = sure >> k & 1 != 0;
                    let found = |lane: usize| is_sure || unsure[lane] >> k & 1 != 0;
                    let ray = Ray::new(origin, directions[k]);
                    assert!(!is_sure || !lanes.is_empty(), "{name}: {ray:?} hits nothing, the planes are sure it does");
                    assert!(lanes.iter().all(|&lane| found(lane)), "{name}: {ray:?} hits {lanes:?}, the planes miss");
                    hits += usize::from(!lanes.is_empty());
                    unsure_hits += usize::from(!lanes.is_empty() && !is_sure);
                }
            }
        });
        println!("{hits} hits, planes unsure of {unsure_hits}");
        assert!(hits > 50_000, "{hits} hits: enough to tell");
    }

    #[test]
    fn planes_are_sure_of_nearly_all_rays_at_triangles_of_some_size() {
        let mut random = Random::new(22);
        let bounds = Bounds { min: [-1.0; 3], max: [1.0; 3] };
        let (mut sure_hits, mut unsure_rays) = (0, 0);
        for _ in 0..1000 {
            let triangles: [[[f32; 3]; 3]; WIDTH] = std::array::from_fn(|_| [(); 3].map(|()| point(&mut random, 1.0)));
            let origin = point(&mut random, 1.0);
            let start = RayOrigin::new(origin, &bounds);
            let rays: Vec<_> = (0..64)
                .map(|_| start.frame(point(&mut random, 1.0)))
                .map(|f| BundledRay { reciprocal: f.reciprocal, direction: f.direction, ..BundledRay::default() })
                .collect();
            let (sure, unsure) = Machine::detect().run(Hits(&Block::new((0..).zip(triangles)), origin, &rays));
            sure_hits += sure.count_ones();
            unsure_rays += unsure.iter().fold(0, |all, set| all | set).count_ones();
        }
        assert!(sure_hits > 10_000 && unsure_rays < 64, "of 64000 rays {sure_hits} hit, {unsure_rays} are unsure");
    }
}
