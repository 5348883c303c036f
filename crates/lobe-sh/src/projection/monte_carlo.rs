//! Projection of a function by Monte Carlo integration.

use core::f64::consts::PI;

use crate::basis::basis::Basis;
use crate::basis::index::coefficient_count;
use crate::expansion::ShVec;
use crate::prelude::*;
use crate::scalar::Coefficient;
use crate::setters::setters;
use crate::sphere::Dir;

/// The choice of the directions of a Monte Carlo projection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Sampling {
    /// Independent uniform directions; the error falls with `N^(-1/2)`.
    Random,
    /// One uniform direction in each of `k × k` cells of equal solid angle ([Green 2003]); for smooth functions
    /// the error falls with `N^-1`, for functions with jumps with `N^(-3/4)`.
    ///
    /// [Green 2003]: https://3dvar.com/Green2003Spherical.pdf
    #[default]
    Jittered,
    /// A Fibonacci spiral: deterministic, the same for every seed.
    Fibonacci,
}

/// Options of [`project_monte_carlo`]: by default 10000 jittered samples of seed 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct MonteCarloOptions {
    /// The number of samples; [`Sampling::Jittered`] rounds it down to a square.
    pub samples: usize,
    /// The seed: different seeds give independent results, equal seeds equal bytes.
    pub seed: u64,
    /// The choice of the directions.
    pub sampling: Sampling,
}

setters! { MonteCarloOptions { samples: usize, seed: u64, sampling: Sampling } }

impl Default for MonteCarloOptions {
    fn default() -> Self {
        Self { samples: 10_000, seed: 0, sampling: Sampling::default() }
    }
}

/// An expansion with its statistical error.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MonteCarloEstimate<T> {
    /// The estimated expansion.
    pub sh: ShVec<T>,
    /// The standard error of every coefficient; see [`project_monte_carlo`] for what it means.
    pub standard_error: ShVec<T>,
    /// The number of evaluations of the function.
    pub evaluations: usize,
}

/// The expansion of any function by sampling it in `options.samples` directions.
///
/// ```text
///   f_i ≈ (4π/N) Σ_k f(s_k) y_i(s_k)        cos θ = 1 - 2u,  φ = 2π v,  (u, v) uniform in the unit square
/// ```
///
/// The standard error is, for random samples, `√(variance / N)` of the summands `4π f y_i`; for jittered samples
/// the same within pairs of neighboring cells, which slightly overstates it (the means of a pair's cells differ
/// too); for the Fibonacci spiral, which is deterministic, the difference from a spiral of half as many points, which
/// takes `N/2` further evaluations. With fewer than two samples it is infinite.
///
/// # Panics
/// If `options.samples` is 0.
#[must_use]
pub fn project_monte_carlo<T: Coefficient>(
    order: usize,
    options: &MonteCarloOptions,
    f: impl FnMut(Dir) -> T,
) -> MonteCarloEstimate<T> {
    assert!(options.samples > 0, "a Monte Carlo projection needs one sample at least");
    let estimator = Estimator { order, seed: options.seed, f };
    match options.sampling {
        Sampling::Random => estimator.random(options.samples),
        Sampling::Jittered => estimator.jittered(options.samples.isqrt()),
        Sampling::Fibonacci => estimator.fibonacci(options.samples),
    }
}

struct Estimator<F> {
    order: usize,
    seed: u64,
    f: F,
}

impl<F: FnMut(Dir) -> T, T: Coefficient> Estimator<F> {
    /// The summands `4π f(s) y_i(s)` of one direction.
    fn summands_into(&mut self, s: Dir, out: &mut [T::Wide]) {
        let value = (self.f)(s).widen().scale(4.0 * PI);
        Basis::<f64>::with_shared(self.order, |basis| {
            basis.for_each(s.to_array(), self.order, |i, y| out[i] = value.scale(y));
        });
    }

    /// Random samples: mean and variance by Welford's updates.
    fn random(mut self, samples: usize) -> MonteCarloEstimate<T> {
        let n = coefficient_count(self.order);
        let mut summands = vec![T::Wide::ZERO; n];
        let mut mean = vec![T::Wide::ZERO; n];
        let mut squares = vec![T::Wide::ZERO; n];
        for k in 0..samples {
            let s = direction(uniform(self.seed, 2 * k as u64), uniform(self.seed, 2 * k as u64 + 1));
            self.summands_into(s, &mut summands);
            for i in 0..n {
                let before = summands[i] - mean[i];
                mean[i] += before.scale(1.0 / (k + 1) as f64);
                squares[i] += before * (summands[i] - mean[i]);
            }
        }
        let degrees_of_freedom = samples as f64 * (samples as f64 - 1.0);
        let error = squares.iter().map(|q| square_root(q.scale(1.0 / degrees_of_freedom))).collect();
        estimate(mean, error, samples)
    }

    /// `cells × cells` jittered samples. Neighboring cells along `φ` form the pairs of the error estimate:
    /// the variance of a pair's sum is at most the mean square of its difference. An odd last cell counts as a
    /// pair with the one before it, at half weight.
    fn jittered(mut self, cells: usize) -> MonteCarloEstimate<T> {
        let n = coefficient_count(self.order);
        let mut summands = vec![T::Wide::ZERO; n];
        let mut before = vec![T::Wide::ZERO; n];
        let mut sum = vec![T::Wide::ZERO; n];
        let mut squares = vec![T::Wide::ZERO; n];
        for row in 0..cells {
            for column in 0..cells {
                let k = (row * cells + column) as u64;
                let u = (row as f64 + uniform(self.seed, 2 * k)) / cells as f64;
                let v = (column as f64 + uniform(self.seed, 2 * k + 1)) / cells as f64;
                self.summands_into(direction(u, v), &mut summands);
                let lone = column + 1 == cells && column % 2 == 0;
                let weight = if column % 2 == 1 { 1.0 } else { f64::from(u8::from(lone)) * 0.5 };
                for i in 0..n {
                    sum[i] += summands[i];
                    let difference = summands[i] - before[i];
                    squares[i] += (difference * difference).scale(weight);
                }
                before.copy_from_slice(&summands);
            }
        }
        let samples = cells * cells;
        let scale = 1.0 / samples as f64;
        let mean = sum.iter().map(|s| s.scale(scale)).collect();
        estimate(mean, squares.iter().map(|q| square_root(*q).scale(scale)).collect(), samples)
    }

    fn fibonacci(mut self, samples: usize) -> MonteCarloEstimate<T> {
        let full = self.spiral(samples);
        let half = self.spiral(samples / 2);
        let error = full.iter().zip(half).map(|(a, b)| absolute(*a - b)).collect();
        estimate(full, error, samples + samples / 2)
    }

    /// `cos θ_k = 1 - (2k + 1)/N`, `φ_k = 2π k / golden ratio`.
    fn spiral(&mut self, samples: usize) -> Vec<T::Wide> {
        let golden_ratio = 0.5 * (1.0 + 5.0_f64.sqrt());
        let mut summands = vec![T::Wide::ZERO; coefficient_count(self.order)];
        let mut sum = summands.clone();
        for k in 0..samples {
            let s = direction((k as f64 + 0.5) / samples as f64, (k as f64 / golden_ratio).fract());
            self.summands_into(s, &mut summands);
            for (sum, summand) in sum.iter_mut().zip(&summands) {
                *sum += *summand;
            }
        }
        sum.iter().map(|s| s.scale(1.0 / samples as f64)).collect()
    }
}

fn estimate<T: Coefficient>(
    mean: Vec<T::Wide>,
    mut standard_error: Vec<T::Wide>,
    evaluations: usize,
) -> MonteCarloEstimate<T> {
    if evaluations < 2 {
        standard_error.fill(T::Wide::splat(f64::INFINITY));
    }
    MonteCarloEstimate {
        sh: ShVec::of(mean.into_iter().map(T::narrow).collect()),
        standard_error: ShVec::of(standard_error.into_iter().map(T::narrow).collect()),
        evaluations,
    }
}

fn square_root<W: Coefficient<Scalar = f64>>(c: W) -> W {
    W::from_channels(|k| c.channel(k).sqrt())
}

fn absolute<W: Coefficient<Scalar = f64>>(c: W) -> W {
    W::from_channels(|k| c.channel(k).abs())
}

/// The direction of a point of the unit square, uniform on the sphere when the point is uniform.
///
/// Green's map `θ = 2 acos √(1 - u)` without the arc cosine: `cos θ = 1 - 2u`, `sin θ = 2 √(u (1 - u))`.
fn direction(u: f64, v: f64) -> Dir {
    let (sin_phi, cos_phi) = (2.0 * PI * v).sin_cos();
    let sin_theta = 2.0 * (u * (1.0 - u)).sqrt();
    Dir::from_unit([sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - 2.0 * u])
}

/// Number `index` of the sequence `seed`, uniform in `[0, 1)`: the finalizer of `SplitMix64` (Steele, Lea and Flood
/// 2014) over a counter, so that any sample can be made without the ones before it.
fn uniform(seed: u64, index: u64) -> f64 {
    const GAMMA: u64 = 0x9E37_79B9_7F4A_7C15; // 2⁶⁴ / golden ratio, odd
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let stream = mix(seed.wrapping_add(GAMMA));
    let bits = mix(stream.wrapping_add(index.wrapping_add(1).wrapping_mul(GAMMA)));
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, Zonal};
    use crate::scalar::Rgb;

    const SEEDS: u64 = 24;

    /// The two lobes of Green's example light.
    fn greens_light(s: Dir) -> f64 {
        let axis = Dir::from_angles(PI / 2.0, 2.5);
        (5.0 * s.z() - 4.0).max(0.0) + (4.0 * s.dot(axis) - 3.0).max(0.0)
    }

    fn exact() -> ShVec<f64> {
        ShVec::from_vec(lobe_testkit::golden_f64s("/green_light16")).unwrap()
    }

    /// The root mean square over seeds of the distance from the exact expansion.
    fn rms_error(sampling: Sampling, samples: usize) -> f64 {
        let sum: f64 = (0..SEEDS)
            .map(|seed| {
                let found = project_monte_carlo(4, &MonteCarloOptions { samples, seed, sampling }, greens_light);
                let error = &found.sh - &exact();
                error.dot(&error)
            })
            .sum();
        (sum / SEEDS as f64).sqrt()
    }

    #[test]
    fn random_samples_converge_with_the_root_of_their_number() {
        let ratio = rms_error(Sampling::Random, 400) / rms_error(Sampling::Random, 400 * 16);
        assert!((3.0..5.3).contains(&ratio), "16 times the samples: error ratio {ratio}, expected 4");
    }

    #[test]
    fn jittered_samples_converge_with_their_number() {
        let ratio = rms_error(Sampling::Jittered, 400) / rms_error(Sampling::Jittered, 400 * 16);
        assert!((12.0..21.0).contains(&ratio), "16 times the samples: error ratio {ratio}, expected 16");
    }

    #[test]
    fn sampling_methods_rank_as_in_the_literature() {
        let [random, jittered, fibonacci] =
            [Sampling::Random, Sampling::Jittered, Sampling::Fibonacci].map(|s| rms_error(s, 10_000));
        assert!(random > 5.0 * jittered, "random {random}, jittered {jittered}");
        assert!(jittered > 5.0 * fibonacci, "jittered {jittered}, Fibonacci {fibonacci}");
    }

    /// Over many seeds the error divided by its reported standard error has a mean square of `expected`.
    fn mean_square_of_z(sampling: Sampling) -> f64 {
        let mut sum = 0.0;
        for seed in 0..SEEDS {
            let found = project_monte_carlo(4, &MonteCarloOptions { samples: 2500, seed, sampling }, greens_light);
            for i in 0..16 {
                sum += ((found.sh[i] - exact()[i]) / found.standard_error[i]).powi(2);
            }
        }
        sum / (16 * SEEDS) as f64
    }

    #[test]
    fn the_standard_error_is_honest() {
        let random = mean_square_of_z(Sampling::Random);
        assert!((0.8..1.25).contains(&random), "random: {random}, expected 1");
        let jittered = mean_square_of_z(Sampling::Jittered);
        assert!((0.3..1.1).contains(&jittered), "jittered: {jittered}, expected at most 1");
    }

    #[test]
    fn the_fibonacci_error_estimate_covers_the_error() {
        let options = MonteCarloOptions { samples: 4000, seed: 0, sampling: Sampling::Fibonacci };
        let found = project_monte_carlo(4, &options, greens_light);
        let error = &found.sh - &exact();
        let (error, bound) = (error.dot(&error).sqrt(), found.standard_error.dot(&found.standard_error).sqrt());
        assert!(error < bound && bound < 1e-2, "error {error}, reported {bound}");
        assert_eq!(found.evaluations, 6000, "half as many again");
    }

    #[test]
    fn equal_seeds_repeat_and_other_seeds_do_not() {
        let run =
            |seed| project_monte_carlo(3, &MonteCarloOptions { samples: 64, seed, ..Default::default() }, greens_light);
        assert_eq!(run(7).sh, run(7).sh, "equal seeds");
        assert_ne!(run(7).sh, run(8).sh, "other seeds");
    }

    #[test]
    fn jittered_samples_are_rounded_down_to_a_square() {
        let options = MonteCarloOptions { samples: 120, seed: 1, sampling: Sampling::Jittered };
        assert_eq!(project_monte_carlo(2, &options, greens_light).evaluations, 100, "120 samples");
    }

    #[test]
    fn one_sample_has_no_known_error() {
        for sampling in [Sampling::Random, Sampling::Jittered, Sampling::Fibonacci] {
            let found = project_monte_carlo(2, &MonteCarloOptions { samples: 1, seed: 3, sampling }, |_| 1.0);
            assert_eq!(found.standard_error[0], f64::INFINITY, "{sampling:?}");
        }
    }

    #[test]
    fn colors_are_estimated_channel_by_channel() {
        let options = MonteCarloOptions { samples: 400, seed: 1, sampling: Sampling::Random };
        let gray = project_monte_carlo(3, &options, greens_light);
        let color = project_monte_carlo(3, &options, |s| Rgb::new(greens_light(s), 0.0, -greens_light(s)));
        for i in 0..9 {
            let c = color.sh[i];
            assert_eq!((c.r, c.g, c.b), (gray.sh[i], 0.0, -gray.sh[i]), "i {i}");
            assert_eq!(color.standard_error[i].b, gray.standard_error[i], "error of i {i}");
        }
    }

    #[test]
    fn a_half_degree_sun_is_missed_by_points_and_kept_by_its_closed_form() {
        let cos_radius = 0.25_f64.to_radians().cos();
        let axis = Dir::from_angles(0.7, 1.1);
        let sun = |s: Dir| f64::from(u8::from(s.dot(axis) > cos_radius));
        let exact = Zonal::project(1, &[cos_radius], 2, |t| f64::from(u8::from(t > cos_radius))).coefficients()[0];
        let found = project_monte_carlo(1, &MonteCarloOptions { samples: 10_000, ..Default::default() }, sun);
        assert!((found.sh[0] - exact).abs() > 0.5 * exact, "10000 points against {exact}: {}", found.sh[0]);
    }
}
