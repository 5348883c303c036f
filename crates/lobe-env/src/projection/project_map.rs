//! Projection of a map in any mapping onto spherical harmonics, without resampling.

use lobe_io::parallel;
use lobe_sh::basis::{Basis, coefficient_count};
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec};

use crate::map::mapped_map::MappedMap;
use crate::mapping::form::Obstacle;
use crate::mapping::mapping::Mapping;
use crate::mapping::texel_quadrature;
use crate::projection::lat_long_rows::LatLongRows;
use crate::projection::patch_moments::Patches;
use crate::projection::project::project_rows;

/// The target error of a texel's integral of one basis function, relative to its solid angle.
const NODE_ERROR: f64 = 1e-10;
/// The most Gauss-Legendre nodes in one direction across a texel: enough for maps of two by two texels and order 256.
const MAX_NODES: usize = 512;
/// How many times as long in θ as the side of its count of nodes a texel of a ball may be. The first term of the series
/// by which nodes are counted is above the error of the rule by 4^q, so that a texel may be twice as long; but θ does
/// not run evenly over a texel at the rim.
const BALL_STRETCH: f64 = 1.5;
/// The longest side by which [`nodes_across`] describes the texel that is a whole face of a cube.
const FLAT_SIDE: f64 = 2.9;
/// Rows are summed in at most this many chunks, whatever the number of threads.
const MAX_CHUNKS: usize = 64;

/// Projects a map in any mapping, piecewise constant over texels, onto spherical harmonics.
///
/// ```text
///   f_lm = Σ_texels L ∫_texel y_lm(s) ds
/// ```
///
/// No resampled copy comes in between. The integrals are Gauss-Legendre sums over each smooth piece of a texel, with
/// enough nodes for an error of coefficients below 1e-9 of their norm (tests
/// `expansions_of_small_maps_are_right_to_the_stated_error`, `the_long_texels_at_the_rim_of_a_ball_have_enough_nodes`,
/// `texels_near_the_poles_of_an_equal_area_picture_have_enough_nodes`), and weights that sum to its exact solid angle:
/// `f_0` is `√(4π)` times the exact [`mean`](MappedMap::mean). A lat-long map is projected by the exact separable sums of
/// [`project_env`](crate::project_env). The sums over cubes and octahedral pictures separate too, on cells of each face,
/// up to an error of 1e-12 (test `sums_over_cells_are_the_sums_over_texels`): where a picture has many texels, their
/// number hardly counts. In parallel over fixed chunks of rows; the same bits for any number of threads.
///
/// ```
/// use lobe_env::{MappedMap, Mapping, project_map};
/// use lobe_sh::{Expansion, Rgb};
///
/// let sky = MappedMap::from_fn(Mapping::Angular, 33, 33, |_| Rgb::new(1.0, 2.0, 4.0));
/// let light = project_map(&sky, 3);
/// assert!((light.mean().b - 4.0).abs() < 1e-12 && light[6].b.abs() < 1e-6);
/// ```
#[must_use]
pub fn project_map(map: &MappedMap, order: usize) -> ShVec<Rgb<f64>> {
    if order == 0 {
        return ShVec::zero(0);
    }
    if map.mapping().form().has_rows_of_latitude() {
        return project_rows(LatLongRows::from(map), order);
    }
    let nodes = node_count(map, order);
    let by_texels = map.texels().len() * nodes * nodes;
    let parts = match Patches::new(map, order).filter(|patches| patches.evaluations() < by_texels) {
        Some(patches) => {
            let cut = |x, y| !Patches::hold(map, x, y);
            let mut parts = patches.project(map, order);
            parts.extend(of_texels(map, order, nodes, cut));
            parts
        }
        None => of_texels(map, order, nodes, |_, _| true),
    };
    let mut sum = ShVec::zero(order);
    for part in parts {
        for (f, p) in sum.coefficients_mut().iter_mut().zip(part) {
            *f += p;
        }
    }
    sum
}

/// The sums over the texels that are `wanted`, each by itself, in fixed chunks of rows.
fn of_texels(
    map: &MappedMap,
    order: usize,
    nodes: usize,
    wanted: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<Vec<Rgb<f64>>> {
    let rules = Rules::new(map, order, nodes);
    let basis = Basis::<f64>::new(order);
    let chunk = map.height().div_ceil(MAX_CHUNKS);
    parallel::map(map.height().div_ceil(chunk), &|c| {
        let values = vec![0.0; coefficient_count(order)];
        let mut rows = Rows { map, rules: &rules, basis: &basis, nodes: Vec::new(), values };
        let mut part = vec![Rgb::ZERO; coefficient_count(order)];
        for y in c * chunk..map.height().min((c + 1) * chunk) {
            rows.add(y, |x| wanted(x, y), &mut part);
        }
        part
    })
}

/// The scratch space of one thread.
struct Rows<'a> {
    map: &'a MappedMap,
    rules: &'a Rules,
    basis: &'a Basis<f64>,
    nodes: Vec<(Dir, f64)>,
    values: Vec<f64>,
}

impl Rows<'_> {
    fn add(&mut self, y: usize, wanted: impl Fn(usize) -> bool, part: &mut [Rgb<f64>]) {
        let size = [self.map.width(), self.map.height()];
        let mut integrals = vec![0.0; part.len()];
        for (x, texel) in self.map.row(y).iter().enumerate().filter(|(x, _)| wanted(*x)) {
            let rule = self.rules.across(self.map, x, y);
            texel_quadrature::nodes_into(self.map.mapping(), size, [x, y], rule, &mut self.nodes);
            if self.nodes.is_empty() {
                continue;
            }
            integrals.fill(0.0);
            for (s, weight) in &self.nodes {
                self.basis.eval_into(s.to_array(), &mut self.values);
                for (integral, value) in integrals.iter_mut().zip(&self.values) {
                    *integral += weight * value;
                }
            }
            let texel = texel.widen();
            for (f, integral) in part.iter_mut().zip(&integrals) {
                *f += texel.scale(*integral);
            }
        }
    }
}

/// The rules across the texels of a map: one for all of them, but of a ball one for each length of texels, and of an
/// equal-area picture one for each distance from a pole.
struct Rules {
    order: usize,
    /// Of the least number of nodes, of one more, and so on.
    rules: Vec<Vec<(f64, f64)>>,
}

impl Rules {
    /// With at least `nodes` across a texel.
    fn new(map: &MappedMap, order: usize, nodes: usize) -> Self {
        let worst = map.mapping().form().worst_obstacle([map.width(), map.height()]);
        let most = worst.map_or(nodes, |worst| nodes_against(map, order, &worst));
        Self { order, rules: (nodes..=most.max(nodes)).map(gauss_legendre).collect() }
    }

    /// The rule across texel `(x, y)`.
    fn across(&self, map: &MappedMap, x: usize, y: usize) -> &[(f64, f64)] {
        let least = self.rules[0].len();
        let obstacle = map.mapping().form().obstacle([map.width(), map.height()], [x, y]);
        let nodes = obstacle.map_or(least, |obstacle| nodes_against(map, self.order, &obstacle));
        &self.rules[nodes.saturating_sub(least).min(self.rules.len() - 1)]
    }
}

// A function of band l over an interval of the angle h behaves like cos(l t), |t| <= h/2, at worst. The q-point rule
// has an error of about the first term of the series that it does not integrate, (l h/2)^2q / (2q)!, times a factor
// below 1.
//
// The directions of a flat picture have complex singularities about as far from it as it is wide: where the square root
// of the distance from the center of the cube vanishes. The q-point rule on a texel of half that width η has the error
// ρ^-2q, ρ = (1 + √(1 + η²))/η.
//
// Texels are not squares: their longest side is at most about twice the root of their mean solid angle for pictures of
// natural proportions, and longer by the root of the stretch for others. Those of a ball have equal solid angles and are
// the longer in θ the nearer they are to the rim, where θ = 2 asin r: up to 4.8/√w in a picture of w columns.
//
// Where a mapping is singular n halves of a texel away from its middle, the q-point rule has the error ρ^-2q,
// ρ = n + √(n² - 1).

/// The number of nodes across a texel; on a ball, of one away from the rim.
fn node_count(map: &MappedMap, order: usize) -> usize {
    let natural = map.mapping().height_for(map.width()) as f64 / map.height() as f64;
    let stretch = natural.max(1.0 / natural);
    let texels = map.width() as f64 * map.height() as f64;
    nodes_across(map.mapping(), order, 2.0 * (4.0 * std::f64::consts::PI * stretch / texels).sqrt())
}

/// The number of nodes across a texel, for what stands against few of them alone.
fn nodes_against(map: &MappedMap, order: usize, obstacle: &Obstacle) -> usize {
    match *obstacle {
        Obstacle::Length(angle) => nodes_across(map.mapping(), order, angle / BALL_STRETCH),
        Obstacle::Singularity(n) => count_for(n + ((n - 1.0) * (n + 1.0)).sqrt()),
    }
}

/// The number of nodes across a texel with this longest side.
fn nodes_across(mapping: Mapping, order: usize, side: f64) -> usize {
    let half = 0.5 * (order - 1) as f64 * side.min(std::f64::consts::PI);
    let mut error = 1.0;
    let mut q = 0;
    while error > NODE_ERROR && q < MAX_NODES {
        q += 1;
        error *= half * half / ((2 * q - 1) * 2 * q) as f64;
    }
    let part = side / FLAT_SIDE;
    let q = q.max(count_for((1.0 + 1.0_f64.hypot(part)) / part));
    // In a disc the azimuth runs over a quarter turn in the texels around the center, however small they are.
    q.max(2) + if mapping.form().discs() > 0 { 4 } else { 0 }
}

/// The number of nodes of a rule whose error is `ρ^-2q`.
fn count_for(rho: f64) -> usize {
    ((-0.5 * NODE_ERROR.ln() / rho.ln()).ceil() as usize).min(MAX_NODES)
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    /// Enough nodes for all digits of a texel that is a whole face.
    const NODES: usize = 32;

    #[test]
    #[ignore = "long: of the nightly group"]
    fn sums_over_cells_are_the_sums_over_texels() {
        let sizes = [(Mapping::Cube, 1, 6), (Mapping::Cube, 7, 42)];
        let octahedra = [(1, 1), (2, 2), (5, 5), (12, 12), (7, 16), (13, 4)];
        for (mapping, w, h) in sizes.into_iter().chain(octahedra.map(|(w, h)| (Mapping::Octahedral, w, h))) {
            let mut random = Random::new(21);
            let texels = (0..w * h).map(|_| Rgb::from([(); 3].map(|()| random.unit().powi(4) as f32))).collect();
            let map = MappedMap::new(mapping, w, h, texels).unwrap();
            for order in [1, 8, 16, 20] {
                let sum = |parts: Vec<Vec<Rgb<f64>>>| {
                    parts.into_iter().fold(vec![Rgb::ZERO; coefficient_count(order)], |sum, part| {
                        sum.into_iter().zip(part).map(|(a, b): (Rgb<f64>, _)| a + b).collect()
                    })
                };
                let mut parts = Patches::new(&map, order).unwrap().project(&map, order);
                parts.extend(of_texels(&map, order, NODES, |x, y| !Patches::hold(&map, x, y)));
                let (found, expected) = (sum(parts), sum(of_texels(&map, order, NODES, |_, _| true)));
                let error = found.iter().zip(&expected).flat_map(|(a, b)| (*a - *b).to_array());
                let error = error.fold(0.0, |worst: f64, e| worst.max(e.abs())) / expected[0].g;
                println!("{mapping} {w} x {h}, order {order}: {error:.1e}");
                assert!(error < 1e-12, "{mapping} {w} x {h}, order {order}: {error}");
            }
        }
    }

    /// The expansion of the texels that are `wanted`, each by `nodes` across it at least.
    fn sum_of_texels(
        map: &MappedMap,
        order: usize,
        nodes: usize,
        wanted: &(dyn Fn(usize, usize) -> bool + Sync),
    ) -> Vec<f64> {
        let parts = of_texels(map, order, nodes, wanted);
        parts.into_iter().fold(vec![0.0_f64; coefficient_count(order)], |sum, part| {
            sum.into_iter().zip(part).map(|(a, b)| a + b.g).collect()
        })
    }

    /// The largest difference, relative to the norm of `expected`.
    fn error_of_norm(found: &[f64], expected: &[f64]) -> f64 {
        let norm = expected.iter().map(|c| c * c).sum::<f64>().sqrt();
        found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / norm
    }

    #[test]
    fn texels_near_the_poles_of_an_equal_area_picture_have_enough_nodes() {
        let order = 3;
        for (w, h) in [(64, 64), (65, 65), (256, 256), (40, 20)] {
            let map = MappedMap::new(Mapping::EqualArea, w, h, vec![Rgb::splat(1.0); w * h]).unwrap();
            // Texels from the pole outwards, around +z in the middle and around -z in a corner.
            for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (4, 0), (0, 4), (12, 0)] {
                for lit in [(w / 2 + i, h / 2 + j), (i, h - 1 - j)] {
                    let sum = |nodes: usize| sum_of_texels(&map, order, nodes, &|x, y| (x, y) == lit);
                    let error = error_of_norm(&sum(node_count(&map, order)), &sum(NODES));
                    assert!(error < 1e-10, "{w} x {h}, texel {lit:?}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn the_long_texels_at_the_rim_of_a_ball_have_enough_nodes() {
        // Only one texel, at the left end of the ball, is summed: the integrals over all others would take seconds.
        for (size, order) in [(32, 60), (64, 60)] {
            let lit = |x: usize, y: usize| (x, y) == (0, size / 2 - 1);
            let mut random = Random::new(5);
            let texels = (0..size * size).map(|_| Rgb::splat(1.0 + random.unit() as f32)).collect();
            let map = MappedMap::new(Mapping::MirrorBall, size, size, texels).unwrap();
            // The same function on a map whose texels are parts of this one's.
            let fine = 4 * size;
            let texels = (0..fine * fine).map(|i| map.texel(i % fine / 4, i / fine / 4)).collect();
            let fine = MappedMap::new(Mapping::MirrorBall, fine, fine, texels).unwrap();
            let found = sum_of_texels(&map, order, node_count(&map, order), &lit);
            let expected = sum_of_texels(&fine, order, node_count(&fine, order), &|x, y| lit(x / 4, y / 4));
            let error = error_of_norm(&found, &expected);
            println!("{size} x {size}, order {order}: {error:.1e}");
            assert!(error < 1e-11, "{size} x {size}, order {order}: {error:e}");
        }
    }
}
