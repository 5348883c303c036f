//! Error tables of a lobe: the largest cells of the source that its integral may use, for a tolerance.

use std::f64::consts::PI;

use lobe_io::parallel;
use lobe_sh::sphere::gauss_legendre;

use crate::prefilter::brightness;
use crate::prefilter::cell_tree::{SIDE, lagrange, nodes};
use crate::reflection::specular_lobe::{Kernel, integral};

/// Angles from the axis at which errors are tabulated, clustered towards the axis: `θ = π (i/512)²`.
const BINS: usize = 512;

/// Points between the nodes at which the polynomial's error is measured.
const PROBES: usize = 2 * SIDE + 1;

/// The choice of Gauss-Legendre rules along a texel, by their number of points.
const RULES: [usize; 6] = [1, 2, 3, 4, 6, CellTolerance::MOST_POINTS];

/// Light below this fraction of the tolerance is left out.
const NEGLIGIBLE: f64 = 0.1;

/// For each angle from the axis of a kernel, the coarsest approximations of the kernel that are accurate enough there.
///
/// An approximation is accurate enough for light `brightness` times as bright as the median of the map where its error
/// is at most `tolerance (K(θ) + floor/brightness)`. Brightness comes in [steps](crate::prefilter::brightness).
pub(crate) struct CellTolerance {
    /// For each class of cell sizes.
    cells: Vec<Limits>,
    /// For each of [`RULES`] on a texel.
    rules: Vec<Limits>,
    /// The points along a texel where no smaller rule suffices.
    most: usize,
    /// For leaving light out.
    nothing: Limits,
}

impl CellTolerance {
    /// The most points along a texel.
    pub(crate) const MOST_POINTS: usize = 8;

    /// Measures a kernel for cells down to `depth`, for texels of the side `texel` and for `steps` of brightness.
    pub(crate) fn new(kernel: &impl Kernel, tolerance: f64, depth: usize, texel: f64, steps: usize) -> Self {
        let value = |theta: f64| {
            // Beyond the axis and beyond the opposite point the angle falls again.
            let theta = theta.abs();
            let theta = if theta > PI { 2.0 * PI - theta } else { theta };
            let sin = (0.5 * theta).sin();
            kernel.exact(2.0 * sin * sin)
        };
        let floor = tolerance * floor(kernel);
        // The brightness at which twice the error, along both sides of a cell, equals the tolerance.
        let limit = |found: f64, exact: f64| {
            let beyond = 2.0 * (found - exact).abs() - tolerance * exact.abs();
            if beyond > 0.0 { floor / beyond } else { f64::INFINITY }
        };
        let probes: [(f64, [f64; SIDE]); PROBES] = std::array::from_fn(|i| {
            let t = 2.0 * i as f64 / (PROBES - 1) as f64 - 1.0;
            (t, lagrange(t))
        });
        let cell_limit = |theta: f64, side: f64| {
            let at_nodes = nodes().map(|t| value(theta + 0.5 * side * t));
            let mut least = f64::INFINITY;
            for (t, factors) in &probes {
                let found = factors.iter().zip(at_nodes).map(|(factor, value)| factor * value).sum();
                least = least.min(limit(found, value(theta + 0.5 * side * t)));
                // Too inaccurate for any light.
                if least < brightness::of_step(0) {
                    break;
                }
            }
            least
        };
        let reference = gauss_legendre(24);
        let mean = |theta: f64, rule: &[(f64, f64)]| -> f64 {
            rule.iter().map(|(x, weight)| 0.5 * weight * value(theta + 0.5 * texel * x)).sum()
        };
        let most = points_at_kinks(kernel, texel);
        let of_class = |class: usize| Limits::new(steps, |theta| cell_limit(theta, class_side(class)));
        let fewer: Vec<usize> = RULES.into_iter().filter(|points| *points < most).collect();
        let of_rule = |i: usize| {
            let rule = gauss_legendre(fewer[i]);
            Limits::new(steps, |theta| limit(mean(theta, &rule), mean(theta, &reference)))
        };
        Self {
            cells: parallel::map(2 * depth + 2, &of_class),
            rules: parallel::map(fewer.len(), &of_rule),
            most,
            nothing: Limits::new(steps, |theta| NEGLIGIBLE * floor / value(theta).abs()),
        }
    }

    /// Whether a cell of a size class may be replaced by its nodes, at all angles of a range from the axis.
    pub(crate) fn cell_is_good(&self, class: usize, step: usize, angles: [f64; 2]) -> bool {
        self.cells[class.min(self.cells.len() - 1)].allow(step, angles)
    }

    /// Whether light at angles of this range may be left out.
    pub(crate) fn is_negligible(&self, step: usize, angles: [f64; 2]) -> bool {
        self.nothing.allow(step, angles)
    }

    /// The points along a texel that suffice at angles of this range; the largest number if none do.
    pub(crate) fn texel_points(&self, step: usize, angles: [f64; 2]) -> usize {
        self.rules.iter().position(|rule| rule.allow(step, angles)).map_or(self.most, |i| RULES[i])
    }

    /// The depth at which every cell is accurate enough everywhere, if not deeper than `last`.
    pub(crate) fn depth_needed(&self, steps: usize, last: usize) -> usize {
        (0..last).find(|depth| self.cell_is_good(2 * depth, steps - 1, [0.0, PI])).unwrap_or(last)
    }
}

/// The greatest brightness for which an approximation is accurate enough, at each angle.
struct Limits {
    /// For each step of brightness, prefix sums over the bins: the number of earlier bins in which it is not.
    bad: Vec<Vec<u32>>,
}

impl Limits {
    fn new(steps: usize, limit: impl Fn(f64) -> f64) -> Self {
        let bins = (0..=BINS).map(|bin| bin as f64 / BINS as f64);
        let limits: Vec<f64> = bins.map(|t| limit(PI * t * t)).collect();
        let counted = |step: usize| {
            let mut before = vec![0];
            let mut count = 0;
            for limit in &limits {
                count += u32::from(*limit < brightness::of_step(step));
                before.push(count);
            }
            before
        };
        Self { bad: (0..steps).map(counted).collect() }
    }

    /// Whether it is accurate enough in all bins of a range.
    fn allow(&self, step: usize, angles: [f64; 2]) -> bool {
        let bin = |angle: f64| (angle.clamp(0.0, PI) / PI).sqrt() * BINS as f64;
        let (first, last) = (bin(angles[0]).floor() as usize, bin(angles[1]).ceil() as usize);
        let before = &self.bad[step];
        before[last + 1] == before[first]
    }
}

/// The points along a texel at a kink of the kernel, where no number of them would reach the tolerance.
///
/// The integral misses a kink, whose slope is about the peak over the lobe's width, by up to an eighth of the kernel's
/// change from point to point: 1/512 of the peak with 64 points across the width, and half of that on average.
fn points_at_kinks(kernel: &impl Kernel, texel: f64) -> usize {
    let width = (integral(kernel).abs() / (PI * kernel.exact(0.0).abs())).sqrt();
    let points = (64.0 * texel / width).ceil() as usize;
    RULES.into_iter().find(|rule| *rule >= points).unwrap_or(CellTolerance::MOST_POINTS)
}

/// The largest class of cells at least this wide.
pub(crate) fn class_of(side: f64) -> usize {
    (2.0 * (2.0 / side).log2() + 1e-9).floor().max(0.0) as usize
}

/// The side of the cells of a class, in half octaves below the 2 rad of a flat face.
fn class_side(class: usize) -> f64 {
    2.0 * (-0.5 * class as f64).exp2()
}

/// The geometric mean of the kernel's peak and its mean over the sphere.
///
/// Relative to the peak alone, the error would be small for a single light but might show in a smooth sky under a
/// narrow lobe; relative to the mean alone, far more cells would be evaluated than anybody could see.
fn floor(kernel: &impl Kernel) -> f64 {
    let mean = integral(kernel).abs() / (4.0 * PI);
    (mean * kernel.exact(0.0).abs()).sqrt()
}
