//! Exact integration of polynomials on an interval and on the sphere.

use core::f64::consts::PI;

use crate::prelude::*;
use crate::sphere::Dir;

/// Newton steps after which a Gauss-Legendre node has converged: the start is good to `O(n⁻²)` and every step
/// doubles the digits, so four suffice; the rest is margin.
const NEWTON_STEPS: usize = 8;

/// The `n` nodes (ascending, in `(-1, 1)`) and weights that integrate polynomials of degree `2n - 1` exactly
/// over `[-1, 1]`.
///
/// ```text
///   P_n(x_k) = 0        w_k = 2 / ((1 - x_k²) P_n'(x_k)²)
/// ```
///
/// Newton's method from `cos(π (k + 3/4) / (n + 1/2))`. The nodes are good to 1e-15; beyond some thousand nodes the
/// recurrence of `P_n` begins to lose digits.
#[must_use]
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let mut rule: Vec<(f64, f64)> = (0..n)
        .map(|k| {
            let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut derivative = 1.0;
            for _ in 0..NEWTON_STEPS {
                let p;
                (p, derivative) = legendre_and_derivative(n, x);
                x -= p / derivative;
            }
            (x, 2.0 / ((1.0 - x * x) * derivative * derivative))
        })
        .collect();
    rule.reverse();
    rule
}

/// `P_n(x)` and `P_n'(x) = n (x P_n - P_{n-1}) / (x² - 1)` inside `(-1, 1)`.
fn legendre_and_derivative(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut p) = (0.0, 1.0);
    for l in 1..=n {
        let l = l as f64;
        (before, p) = (p, ((2.0 * l - 1.0) * x * p - (l - 1.0) * before) / l);
    }
    (p, n as f64 * (x * p - before) / (x * x - 1.0))
}

/// A rule that integrates spherical polynomials up to a given degree exactly: Gauss-Legendre in `z`, uniform in
/// `φ`.
///
/// ```text
///   ∫ f ds = Σ_j Σ_k w_j (2π/K) f(z_j, φ_k)        φ_k = 2π k/K        J = ⌊degree/2⌋ + 1,  K = degree + 1
/// ```
///
/// The product of two functions of order `n` has degree `2(n - 1)`, of three `3(n - 1)`.
#[derive(Clone, Debug)]
pub struct SphereQuadrature {
    rows: Vec<(f64, f64)>,
    azimuths: usize,
}

impl SphereQuadrature {
    /// The rule that is exact for spherical polynomials up to `degree`.
    #[must_use]
    pub fn of_degree(degree: usize) -> Self {
        Self { rows: gauss_legendre(degree / 2 + 1), azimuths: degree + 1 }
    }

    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len() * self.azimuths
    }

    /// False: every rule has points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The rows `(z, weight in z)`, from the lowest `z` up.
    #[must_use]
    pub fn rows(&self) -> &[(f64, f64)] {
        &self.rows
    }

    /// The number of points in each row, at `φ = 2π k / azimuths`.
    #[must_use]
    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// All points with their weights, which sum to `4π`.
    pub fn points(&self) -> impl Iterator<Item = (Dir, f64)> + '_ {
        let step = 2.0 * PI / self.azimuths as f64;
        self.rows.iter().flat_map(move |&(z, weight)| {
            let r = ((1.0 - z) * (1.0 + z)).sqrt();
            (0..self.azimuths).map(move |k| {
                let (sin, cos) = (step * k as f64).sin_cos();
                (Dir::from_unit([r * cos, r * sin, z]), weight * step)
            })
        })
    }

    /// `∫ f ds`.
    pub fn integrate(&self, mut f: impl FnMut(Dir) -> f64) -> f64 {
        self.points().map(|(s, weight)| weight * f(s)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_integrates_powers_exactly() {
        for n in [1, 2, 3, 8, 33, 64, 200] {
            let rule = gauss_legendre(n);
            for power in [0, n / 2, n, 2 * n - 2, 2 * n - 1] {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = if power % 2 == 0 { 2.0 / (power as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-14, "n {n}, x^{power}: {sum} against {exact}");
            }
        }
    }

    #[test]
    fn gauss_legendre_nodes_are_symmetric_and_ascending() {
        let rule = gauss_legendre(31);
        assert!(rule.windows(2).all(|w| w[0].0 < w[1].0), "ascending");
        for k in 0..31 {
            let (a, b) = (rule[k], rule[30 - k]);
            assert!((a.0 + b.0).abs() < 1e-15 && (a.1 - b.1).abs() < 1e-15, "node {k}: {a:?} and {b:?}");
        }
    }

    #[test]
    fn the_weights_on_the_sphere_sum_to_its_area() {
        for degree in [0, 1, 2, 10, 189] {
            let area = SphereQuadrature::of_degree(degree).integrate(|_| 1.0);
            assert!((area - 4.0 * PI).abs() < 1e-12, "degree {degree}: {area}");
        }
    }

    #[test]
    fn monomials_on_the_sphere_have_their_closed_form() {
        let rule = SphereQuadrature::of_degree(6);
        let x2y4 = rule.integrate(|s| s.x().powi(2) * s.y().powi(4));
        // ∫ x² y⁴ ds = 4π (1!! 3!!) / 7!!
        assert!((x2y4 - 4.0 * PI * 3.0 / 105.0).abs() < 1e-14, "{x2y4}");
    }
}
