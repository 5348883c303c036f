//! How finely a source must be looked at to be averaged with a lobe.

use std::f64::consts::PI;

use lobe_sh::gauss_legendre;

use crate::filter_tree::{SIDE, lagrange, nodes};
use crate::specular_lobe::{Kernel, integral};

/// Angles from the axis at which the errors are tabulated; they crowd towards the axis, `θ = π (i/512)²`.
const BINS: usize = 512;

/// Points between the nodes at which the error of the polynomial is measured.
const PROBES: usize = 2 * SIDE + 1;

/// Gauss-Legendre points along a texel, from which one is chosen.
const RULES: [usize; 6] = [1, 2, 3, 4, 6, FilterCut::MOST_POINTS];

/// Light this part of the tolerated error is left out.
const NEGLIGIBLE: f64 = 0.1;

/// For each angle from the axis of a kernel, what approximations of the kernel are good enough there.
///
/// An approximation is good enough where its error is at most `tolerance (K(θ) + floor)` everywhere.
pub(crate) struct FilterCut {
    /// For each class of sides, and each bin, how many bins before it are not good enough.
    bad_cells: Vec<Vec<u32>>,
    /// The same for each of [`RULES`] on a texel.
    bad_rules: Vec<Vec<u32>>,
    /// The points along a texel where fewer do not suffice.
    most: usize,
    /// The same for leaving out what is there.
    needed: Vec<u32>,
}

impl FilterCut {
    /// The most points along a texel.
    pub(crate) const MOST_POINTS: usize = 8;

    /// Measures a kernel for cells down to the given depth and for texels of the given side.
    pub(crate) fn new(kernel: &impl Kernel, tolerance: f64, depth: usize, texel: f64) -> Self {
        let value = |theta: f64| {
            // Beyond the axis and beyond the opposite point the angle falls again.
            let theta = theta.abs();
            let theta = if theta > PI { 2.0 * PI - theta } else { theta };
            let sin = (0.5 * theta).sin();
            kernel.exact(2.0 * sin * sin)
        };
        let floor = floor(kernel);
        let allowed = |value: f64| tolerance * (value.abs() + floor);
        let probes: [(f64, [f64; SIDE]); PROBES] = std::array::from_fn(|i| {
            let t = 2.0 * i as f64 / (PROBES - 1) as f64 - 1.0;
            (t, lagrange(t))
        });
        let cell_is_good = |theta: f64, side: f64| {
            let at_nodes = nodes().map(|t| value(theta + 0.5 * side * t));
            probes.iter().all(|(t, factors)| {
                let exact = value(theta + 0.5 * side * t);
                let found: f64 = factors.iter().zip(at_nodes).map(|(factor, value)| factor * value).sum();
                // Twice: along both sides of the cell.
                2.0 * (found - exact).abs() <= allowed(exact)
            })
        };
        let reference = gauss_legendre(24);
        let mean = |theta: f64, rule: &[(f64, f64)]| -> f64 {
            rule.iter().map(|(x, weight)| 0.5 * weight * value(theta + 0.5 * texel * x)).sum()
        };
        let most = points_at_kinks(kernel, texel);
        let bad_rule = |points: usize| {
            let rule = gauss_legendre(points);
            counted(|theta| {
                let exact = mean(theta, &reference);
                2.0 * (mean(theta, &rule) - exact).abs() > allowed(exact)
            })
        };
        Self {
            bad_cells: (0..=2 * depth + 1)
                .map(|class| counted(|theta| !cell_is_good(theta, class_side(class))))
                .collect(),
            bad_rules: RULES.iter().filter(|points| **points < most).map(|points| bad_rule(*points)).collect(),
            most,
            needed: counted(|theta| value(theta).abs() > NEGLIGIBLE * tolerance * floor),
        }
    }

    /// Whether a cell of some side may be replaced by its nodes, at all angles of a range from the axis.
    pub(crate) fn cell_is_good(&self, class: usize, angles: [f64; 2]) -> bool {
        none(&self.bad_cells[class.min(self.bad_cells.len() - 1)], angles)
    }

    /// Whether nothing needed lies at angles of this range.
    pub(crate) fn is_negligible(&self, angles: [f64; 2]) -> bool {
        none(&self.needed, angles)
    }

    /// The points along a texel that suffice at angles of this range; the most there are if none do.
    pub(crate) fn texel_points(&self, angles: [f64; 2]) -> usize {
        self.bad_rules.iter().position(|bad| none(bad, angles)).map_or(self.most, |i| RULES[i])
    }

    /// The depth at which every cell is good everywhere, if not deeper than `last`.
    pub(crate) fn depth_needed(&self, last: usize) -> usize {
        (0..last).find(|depth| self.cell_is_good(2 * depth, [0.0, PI])).unwrap_or(last)
    }
}

/// The points along a texel that are enough at a kink, where no number of them would reach the tolerance.
///
/// Between points a kink, whose slope is about the peak over the lobe's width, is missed by up to an eighth of what the
/// kernel changes from point to point: 1/512 of the peak with 64 points across the width, and half of that on average.
fn points_at_kinks(kernel: &impl Kernel, texel: f64) -> usize {
    let width = (integral(kernel).abs() / (PI * kernel.exact(0.0).abs())).sqrt();
    let points = (64.0 * texel / width).ceil() as usize;
    RULES.into_iter().find(|rule| *rule >= points).unwrap_or(FilterCut::MOST_POINTS)
}

/// The largest class whose cells are at least this wide.
pub(crate) fn class_of(side: f64) -> usize {
    (2.0 * (2.0 / side).log2() + 1e-9).floor().max(0.0) as usize
}

/// Classes are half octaves below the 2 rad of a face that was flat.
fn class_side(class: usize) -> f64 {
    2.0 * (-0.5 * class as f64).exp2()
}

/// The geometric mean of the kernel's peak and its mean over the sphere.
///
/// Compared with the peak alone the error would be small for a single light, but might show in a smooth sky under a
/// narrow lobe; compared with the mean alone, far more cells would be looked at than anybody could see.
fn floor(kernel: &impl Kernel) -> f64 {
    let mean = integral(kernel).abs() / (4.0 * PI);
    (mean * kernel.exact(0.0).abs()).sqrt()
}

/// For every bin, how many before it are bad.
fn counted(is_bad: impl Fn(f64) -> bool) -> Vec<u32> {
    let mut count = 0;
    let mut before = vec![0];
    for bin in 0..=BINS {
        let t = bin as f64 / BINS as f64;
        count += u32::from(is_bad(PI * t * t));
        before.push(count);
    }
    before
}

/// Whether no bin of a range is bad.
fn none(before: &[u32], angles: [f64; 2]) -> bool {
    let bin = |angle: f64| (angle.clamp(0.0, PI) / PI).sqrt() * BINS as f64;
    let (first, last) = (bin(angles[0]).floor() as usize, bin(angles[1]).ceil() as usize);
    before[last + 1] == before[first]
}
