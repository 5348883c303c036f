//! Shares of overlapping spheres in what they hide together.
//!
//! Spheres that stand for a solid overlap, and the sum of their logarithms counts what two of them hide twice: the logarithm
//! becomes deeper than that of any solid, and rings as much more. Here every line of sight that passes through the union of
//! spheres is counted once, by the sphere through whose surface it leaves the union. With `x_i(n)`, which is 1 where the
//! surface of sphere `i` is outside all others and 0 elsewhere,
//!
//! ```text
//!   w_i(s) = 1/π ∫ x_i(n) max(n·s, 0) dn         log V = Σ_i w_i(s_i) log V_i
//! ```
//!
//! is the part of the disc of sphere `i` that counts for a receiver in direction `s` from it: the convolution that makes
//! irradiance of radiance. Seen from afar, `Σ_i w_i π r_i²` is the area of the union's shadow where the union is convex, and
//! its mean over all directions is a quarter of the union's surface for any union (Cauchy), but for lines that pass through it
//! several times. Those are counted as often, as by the solid's parts one behind the other.
//!
//! `x_i` is expanded to three bands, which hold all but 1/128 of the clamped cosine.

use lobe_sh::basis::Basis;
use lobe_sh::simd::{Wide, constant};
use lobe_sh::sphere::SphereQuadrature;
use pulp::Simd;

use crate::accumulate::occluder::Occluder;

/// Monomials of the first three bands: 1, x, y, z, xy, yz, z², xz, x² - y².
pub(crate) const MONOMIALS: usize = 9;

/// Factors of the clamped cosine in bands 0 to 2, divided by π.
pub(crate) const COSINE_OVER_PI: [f64; 3] = [1.0, 2.0 / 3.0, 1.0 / 4.0];

/// Degree of the quadrature over the surface of a sphere: 128 points.
const DEGREE: usize = 15;

/// A part of a sphere that is less is none: what is left of one that is buried, by rounding.
const LEAST_SHARE: f64 = 1e-3;

/// The part of a sphere's disc that counts for a receiver, by the direction from the receiver to the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Share {
    /// All of it: no other sphere overlaps this one.
    Whole,
    /// The factors of the [`MONOMIALS`] of that direction.
    Part([f32; MONOMIALS]),
    /// Nothing: the sphere is inside others.
    Nothing,
}

impl Share {
    /// The mean over all directions.
    pub(crate) fn mean(&self) -> f32 {
        match self {
            Self::Whole => 1.0,
            // z² has the mean 1/3, all others but the first 0.
            Self::Part(factors) => factors[0] + factors[6] / 3.0,
            Self::Nothing => 0.0,
        }
    }

    /// The mean of shares by weights that add up to 1.
    pub(crate) fn mixed(parts: impl Iterator<Item = (f32, Self)>) -> Self {
        let mut factors = [0.0; MONOMIALS];
        let (mut all_whole, mut all_nothing) = (true, true);
        for (weight, share) in parts {
            all_whole &= share == Self::Whole;
            all_nothing &= share == Self::Nothing;
            match share {
                Self::Whole => factors[0] += weight,
                Self::Part(part) => factors.iter_mut().zip(part).for_each(|(sum, f)| *sum += weight * f),
                Self::Nothing => {}
            }
        }
        match (all_whole, all_nothing) {
            (true, _) => Self::Whole,
            (_, true) => Self::Nothing,
            _ => Self::Part(factors),
        }
    }

    /// The share towards sixteen receivers, that see the sphere in direction `towards`.
    #[inline(always)]
    pub(crate) fn towards<S: Simd>(&self, simd: S, towards: [Wide<S>; 3]) -> Wide<S> {
        let Self::Part(factors) = self else { return constant(simd, self.mean()) };
        let mut share = constant(simd, 0.0);
        for (monomial, factor) in monomials(simd, towards).into_iter().zip(factors) {
            share = monomial.times_plus(constant(simd, *factor), share);
        }
        // Three bands overshoot.
        share.max(constant(simd, 0.0)).min(constant(simd, 1.0))
    }
}

/// The [`MONOMIALS`] of directions.
#[inline(always)]
pub(crate) fn monomials<S: Simd>(simd: S, [x, y, z]: [Wide<S>; 3]) -> [Wide<S>; MONOMIALS] {
    [constant(simd, 1.0), x, y, z, x * y, y * z, z * z, x * z, x * x - y * y]
}

/// The factors of the monomials for an expansion of three bands.
pub(crate) fn to_monomials(b: [f64; 9]) -> [f64; MONOMIALS] {
    let k0 = (4.0 * std::f64::consts::PI).sqrt().recip();
    let [k1, k2, k6] = [3.0_f64.sqrt() * k0, 15.0_f64.sqrt() * k0, 0.5 * 5.0_f64.sqrt() * k0];
    [
        k0 * b[0] - k6 * b[6],
        -k1 * b[3],
        -k1 * b[1],
        k1 * b[2],
        k2 * b[4],
        -k2 * b[5],
        3.0 * k6 * b[6],
        -k2 * b[7],
        0.5 * k2 * b[8],
    ]
}

/// Points on a sphere, with what each adds to the expansion of a share.
pub(crate) struct Surface {
    points: Vec<([f64; 3], [f64; 9])>,
    /// The distance between neighbors, in radii.
    spacing: f64,
}

impl Surface {
    pub(crate) fn new() -> Self {
        let rule = SphereQuadrature::of_degree(DEGREE);
        let points: Vec<_> = rule
            .points()
            .map(|(n, weight)| {
                let mut y = [0.0; 9];
                Basis::<f64>::with_shared(3, |basis| basis.eval_into(n.to_array(), &mut y));
                // The direction to the sphere is opposite to that from it.
                let sign = |l: usize| if l == 1 { -1.0 } else { 1.0 };
                (n.to_array(), std::array::from_fn(|i| sign(i.isqrt()) * COSINE_OVER_PI[i.isqrt()] * weight * y[i]))
            })
            .collect();
        let spacing = (4.0 * std::f64::consts::PI / points.len() as f64).sqrt();
        Self { points, spacing }
    }

    /// The share of a sphere among others that overlap it.
    pub(crate) fn share(&self, sphere: &Occluder, others: &[Occluder]) -> Share {
        if others.is_empty() {
            return Share::Whole;
        }
        let mut b = [0.0; 9];
        for (n, row) in &self.points {
            let free = self.free(sphere, *n, others);
            b.iter_mut().zip(row).for_each(|(b, row)| *b += free * row);
        }
        let share = Share::Part(to_monomials(b).map(|factor| factor as f32));
        if f64::from(share.mean()) < LEAST_SHARE { Share::Nothing } else { share }
    }

    /// `x(n)`, from 0 to 1 over the spacing of the points, so that it has no steps where spheres move; of spheres whose
    /// surfaces coincide each gets its part.
    ///
    /// ```text
    ///   x = 1/(1 + Σ_j e^(k d_j))        d_j: how deep the point is inside sphere j
    /// ```
    fn free(&self, sphere: &Occluder, n: [f64; 3], others: &[Occluder]) -> f64 {
        let r = f64::from(sphere.radius);
        let steepness = TEN_TO_NINETY / (self.spacing * r);
        let mut sum = 1.0;
        for other in others {
            let squared: f64 = (0..3)
                .map(|axis| (f64::from(sphere.center[axis]) + r * n[axis] - f64::from(other.center[axis])).powi(2))
                .sum();
            let depth = steepness * (f64::from(other.radius) - squared.sqrt());
            if depth > COVERED {
                return 0.0;
            }
            sum += depth.exp();
        }
        1.0 / sum
    }
}

/// The logistic function `1/(1 + e^-x)` goes from 10 to 90 percent over `2 ln 9`.
const TEN_TO_NINETY: f64 = 4.394_449_154_672_439;

/// Of a point that is this deep, in units of the exponent, less than 1e-3 is left: it is covered.
const COVERED: f64 = 7.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// The shares of two spheres that overlap, if they do.
    fn shares(spheres: &[Occluder; 2]) -> [Share; 2] {
        let surface = Surface::new();
        let [a, b] = spheres;
        let apart = (0..3).map(|k| (a.center[k] - b.center[k]).powi(2)).sum::<f32>().sqrt() >= a.radius + b.radius;
        let share = |own, other: &Occluder| surface.share(own, if apart { &[] } else { std::slice::from_ref(other) });
        [share(a, b), share(b, a)]
    }

    /// `w(s)` for a receiver in direction `s` from the sphere.
    fn towards(share: &Share, s: [f32; 3]) -> f32 {
        let Share::Part(f) = share else { return share.mean() };
        let [x, y, z] = s.map(|c| -c);
        let monomials = [1.0, x, y, z, x * y, y * z, z * z, x * z, x * x - y * y];
        monomials.iter().zip(f).map(|(m, f)| m * f).sum()
    }

    #[test]
    fn two_spheres_share_what_closed_forms_say() {
        // Each covers a cap of 60 degrees of the other: a quarter of its surface, three quarters of its disc from that side.
        let two = [Occluder::new([0.0; 3], 1.0), Occluder::new([1.0, 0.0, 0.0], 1.0)];
        for (share, side) in shares(&two).iter().zip([1.0, -1.0]) {
            assert!((share.mean() - 0.75).abs() < 0.01, "mean {}", share.mean());
            let (free, covered) = (towards(share, [-side, 0.0, 0.0]), towards(share, [side, 0.0, 0.0]));
            assert!((free - 1.0).abs() < 0.04 && (covered - 0.25).abs() < 0.04, "{free} and {covered}");
        }
    }

    #[test]
    fn what_spheres_share_adds_up_to_a_quarter_of_the_surface_of_their_union() {
        // Twins: the surface is that of one. A ball in a ball: that of the outer. Apart: both.
        let unit = Occluder::new([0.3, -2.0, 1.0], 1.0);
        let quarter_surface = std::f32::consts::PI;
        for (other, expected) in
            [(unit, 1.0), (Occluder::new([0.3, -1.9, 1.0], 0.5), 1.0), (Occluder::new([0.3, -2.0, 3.5], 1.0), 2.0)]
        {
            let both = [unit, other];
            let sum: f32 = shares(&both)
                .iter()
                .zip(both)
                .map(|(share, sphere)| share.mean() * std::f32::consts::PI * sphere.radius.powi(2))
                .sum();
            assert!((sum / quarter_surface - expected).abs() < 0.01, "{other:?}: {sum}");
        }
    }
}
