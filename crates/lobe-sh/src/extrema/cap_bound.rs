//! Proven lower bounds of a function on a cap of the sphere.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::basis::index::order_of_slice;
use crate::basis::second_order::LocalQuadratic;
use crate::extrema::quartic_bound::quartic_lower_bound;
use crate::extrema::taylor::{DERIVATIVES, PoleDerivatives, Taylor};

/// Newton steps towards the best multiplier of a disc; the bound is valid after any number of them.
const MULTIPLIER_STEPS: usize = 4;

/// Bounds of the derivatives of a band-limited function, from its coefficients alone.
///
/// # Derivation
///
/// Let `γ(t)` be a great circle at unit speed and `f_l` the part of band `l`. With the reproducing kernel of the band,
/// `k_l(s, s') = (2l+1)/4π P_l(s·s')`, `f_l(γ(t)) = ⟨f_l, k_l(γ(t), ·)⟩`. Differentiate `k` times and use the
/// inequality of Cauchy and Schwarz:
///
/// ```text
///   |dᵏ/dtᵏ f_l(γ(t))| <= ‖f_l‖ ‖∂_tᵏ k_l(γ(t), ·)‖
///
///   ‖∂_tᵏ k_l(γ(t), ·)‖² = ∂_tᵏ ∂_uᵏ k_l(γ(t), γ(u)) at u = t
///                        = Σ_m (dᵏ/dtᵏ y_lm(γ(t)))²         = D_k,l, the same for every great circle and point
/// ```
///
/// by the addition theorem; [`PoleDerivatives`] has the derivatives at the pole. (`4π D_1 / (2l+1) = l(l+1)/2`, as it
/// must be.) Hence everywhere and along every great circle
///
/// ```text
///   |dᵏf/dtᵏ| <= M_k = Σ_l √D_k,l ‖f_l‖                                                                   (1)
/// ```
///
/// which is the best bound from the norms of the bands: the derivatives of the kernels of all bands attain it together.
/// (The inequality of Bernstein, `lᵏ max|f_l|` for each band, together with `max|f_l| <= √((2l+1)/4π) ‖f_l‖` is weaker,
/// as `D_k,l <= l²ᵏ (2l+1)/4π`: on the equator `D_k,l = Σ_m m²ᵏ y_lm²`.)
///
/// By Taylor's theorem along the great circle from the center `c` of a cap of radius `ρ` to any point at the tangent
/// vector `v`, `|v| <= ρ`,
///
/// ```text
///   f >= f(c) + g·v + ½ vᵀ H v - M_3 ρ³/6                                                                (2)
/// ```
///
/// The least of the quadratic over the disc is bounded from below by weak duality: for every `μ >= 0` with `H + μ >=
/// 0`, and every `v` in the disc,
///
/// ```text
///   g·v + ½ vᵀ H v  >=  g·v + ½ vᵀ (H + μ) v - ½ μ ρ²  >=  -½ gᵀ (H + μ)⁻¹ g - ½ μ ρ²                     (3)
/// ```
///
/// With the terms of third and fourth order and the remainder `M_5 ρ⁵/120`, [`quartic_lower_bound`] bounds the
/// polynomial: at a higher cost, but much more tightly in valleys.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SmoothFunction {
    /// `M_0 .. M_5`.
    bounds: [f64; DERIVATIVES],
    /// The rounding error of a value relative to `M_0`, and of a k-th derivative relative to `M_k`. Not proven: four
    /// times the largest error that the test `rounding_errors_stay_within_their_bound` finds.
    rounding: f64,
}

impl SmoothFunction {
    pub(crate) fn new(coefficients: &[f64]) -> Self {
        let order = order_of_slice(coefficients);
        let bounds = PoleDerivatives::with_shared(order, |table| table.bounds(coefficients));
        // The recurrences over `l` add about one rounding for each step, near the poles its square.
        let n = order as f64;
        Self { bounds, rounding: f64::EPSILON * (4.0 + n * n) }
    }

    /// The largest rounding error of a value.
    pub(crate) fn rounding(&self) -> f64 {
        self.rounding * self.bounds[0]
    }

    /// A lower bound of the function on the cap of `radius` about `local`; `least` bounds the quadratic part.
    #[inline]
    pub(crate) fn lower_bound(
        &self,
        local: &LocalQuadratic,
        radius: f64,
        least: impl Fn(&LocalQuadratic, f64) -> f64,
    ) -> f64 {
        let [m0, m1, m2, m3, ..] = self.bounds;
        let remainder = m3 * radius * radius * radius / 6.0;
        let rounding = self.rounding * (m0 + radius * (m1 + 0.5 * radius * m2));
        local.value + least(local, radius) - remainder - rounding
    }

    /// A lower bound of the function on the cap of `radius` about the center of `taylor`.
    pub(crate) fn lower_bound_of_fourth_order(&self, taylor: &Taylor, radius: f64) -> f64 {
        let [m0, m1, m2, m3, m4, _] = self.bounds;
        // The rotated function has the rounding of three more recurrences.
        let rounding = 4.0 * self.rounding;
        let rounding = rounding * (m0 + radius * (m1 + radius * (m2 / 2.0 + radius * (m3 / 6.0 + radius * m4 / 24.0))));
        quartic_lower_bound(taylor, radius) - self.remainder(radius) - rounding
    }

    /// A bound of the terms beyond the fourth order at that distance.
    pub(crate) fn remainder(&self, radius: f64) -> f64 {
        self.bounds[5] * radius.powi(5) / 120.0
    }
}

/// A lower bound of `g·v + ½ vᵀ H v` over the disc `|v| <= radius`, by (3) of [`SmoothFunction`].
///
/// In the principal axes the best `μ` has `|(H + μ)⁻¹ g| = ρ`. As each part alone is at most `ρ`, `μ >= |g_k|/ρ - λ_k`
/// is a start below it, from where Newton's method on `1/|(H + μ)⁻¹ g|`, which is concave, rises.
pub(crate) fn quadratic_lower_bound(local: &LocalQuadratic, radius: f64) -> f64 {
    let ([low, high], [g0, g1], _) = local.principal_curvatures();
    let (p, q) = (g0 * g0, g1 * g1);
    let mut mu = (g0.abs() / radius - low).max(g1.abs() / radius - high).max(0.0);
    let scale = low.abs().max(high.abs());
    // Keep H + μ positive in spite of rounding.
    if low + mu <= f64::EPSILON * 4.0 * scale {
        mu = -low + 8.0 * f64::EPSILON * scale + f64::MIN_POSITIVE;
    }
    for _ in 0..MULTIPLIER_STEPS {
        let (a, b) = (1.0 / (low + mu), 1.0 / (high + mu));
        let square = p * a * a + q * b * b;
        if square <= radius * radius {
            break;
        }
        // μ <- μ + (|v|/ρ - 1) |v|²/(vᵀ(H + μ)⁻¹v)
        let length = square.sqrt();
        mu += (length / radius - 1.0) * square / (p * a * a * a + q * b * b * b);
    }
    -0.5 * (p / (low + mu) + q / (high + mu)) - 0.5 * mu * radius * radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::basis::Basis;
    use crate::basis::eval_basis;
    use crate::basis::index::coefficient_index;
    use crate::basis::second_order::second_order;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::rotation::Rotation;
    use crate::sphere::Dir;
    use crate::sphere::vector::cross;
    use lobe_testkit::{Random, directions};

    #[test]
    fn derivative_bounds_hold_and_are_attained() {
        // D_k = Σ_m m²ᵏ y_lm² · 4π/(2l+1) on the equator, where a great circle is φ.
        for l in 0..10 {
            let y = eval_basis(Dir::X, l + 1);
            let mut unit = vec![0.0; (l + 1) * (l + 1)];
            unit[l * l] = 1.0;
            let bounds = SmoothFunction::new(&unit).bounds;
            for (k, bound) in bounds.into_iter().enumerate() {
                let sum: f64 = (0..=l)
                    .map(|m| {
                        let y = y[l * (l + 1) + m];
                        (m as f64).powi(2 * k as i32) * y * y
                    })
                    .sum();
                assert!((bound * bound - sum).abs() < 1e-9 * (1.0 + sum), "band {l}, k {k}: {} {sum}", bound * bound);
            }
        }
    }

    /// Value, slope and second derivative of `f` along the great circle from `s` towards its tangent `t`, by another
    /// way: in the frame where `s` is +x and `t` is +y that circle is the equator, and `f` on it a Fourier sum in `φ`.
    fn along_equator(f: &ShVec<f64>, s: [f64; 3], t: [f64; 3]) -> [f64; 3] {
        let frame = Rotation::from_matrix([s, t, cross(s, t)]).unwrap();
        let g = f.rotated(&frame);
        let y = eval_basis(Dir::X, f.order());
        let mut sums = [0.0; 3];
        for l in 0..f.order() {
            for m in 0..=l {
                let (y, mf) = (y[coefficient_index(l, m as isize)], m as f64);
                sums[0] += y * g[coefficient_index(l, m as isize)];
                sums[1] += mf * y * g[coefficient_index(l, -(m as isize))];
                sums[2] -= mf * mf * y * g[coefficient_index(l, m as isize)];
            }
        }
        sums
    }

    #[test]
    fn rounding_errors_stay_within_their_bound() {
        for order in [4, 10, 30, 64] {
            let basis = Basis::<f64>::new(order);
            let f = ShVec::from_vec(Random::new(order as u64).signed_vec(order * order)).unwrap();
            let smooth = SmoothFunction::new(f.coefficients());
            let mut worst = [0.0_f64; 3];
            for v in directions().into_iter().step_by(if order > 10 { 5 } else { 1 }) {
                let [local] = second_order(&basis, f.coefficients(), &[v]);
                worst[0] = worst[0].max((local.value - f.eval(Dir::from_unit(v))).abs());
                for k in 0..2 {
                    let [value, slope, bend] = along_equator(&f, v, local.tangents[k]);
                    let errors = [local.value - value, local.gradient[k] - slope, local.hessian[2 * k] - bend];
                    worst = [0, 1, 2].map(|d| worst[d].max(errors[d].abs()));
                }
            }
            for (k, worst) in worst.into_iter().enumerate() {
                let part = worst / (smooth.rounding * smooth.bounds[k]);
                println!("order {order}, derivative {k}: {part:.4} of the bound");
                assert!(part < 0.25, "order {order}, derivative {k}: {worst:e} is {part} of its bound");
            }
        }
    }

    #[test]
    fn caps_are_bounded_from_below_and_ever_more_tightly() {
        let mut random = Random::new(6);
        for order in [2, 4, 7, 10] {
            let f = random.signed_vec(order * order);
            let smooth = SmoothFunction::new(&f);
            Basis::<f64>::with_shared(order, |basis| {
                for _ in 0..50 {
                    let [local] = second_order(basis, &f, &[random.direction()]);
                    for radius in [0.3, 0.03, 0.003] {
                        let lower = smooth.lower_bound(&local, radius, quadratic_lower_bound);
                        let mut least = f64::INFINITY;
                        for k in 0..400 {
                            let (r, angle) = (radius * (f64::from(k) / 399.0).sqrt(), 2.4 * f64::from(k));
                            let s = local.step([r * angle.cos(), r * angle.sin()]);
                            least = least.min(second_order(basis, &f, &[s])[0].value);
                        }
                        assert!(lower <= least, "order {order}, radius {radius}: {lower} above {least}");
                        // Twice the remainder, and what 400 samples of a disc miss.
                        let slack = smooth.bounds[3] * radius.powi(3) / 3.0 + smooth.bounds[1] * radius * 0.05;
                        assert!(least - lower < slack, "radius {radius}: {lower} far below {least}");
                    }
                }
            });
        }
    }
}
