//! The squared Laplacian of a function, and the window that leaves a fraction of it.

use crate::basis::index::{band_range, order_of_slice};
use crate::prelude::*;
use crate::scalar::{Coefficient, Real};

/// `(l (l+1))²`: the factor of the energy of band `l` in the squared Laplacian.
pub(crate) fn squared_eigenvalue(l: usize) -> f64 {
    let eigenvalue = (l * (l + 1)) as f64;
    eigenvalue * eigenvalue
}

/// The energy of every band, summed over channels, in `f64`.
pub(crate) fn band_energies<T: Coefficient>(coefficients: &[T]) -> Vec<f64> {
    (0..order_of_slice(coefficients))
        .map(|l| coefficients[band_range(l)].iter().map(|c| square_of_channels(*c)).sum())
        .collect()
}

fn square_of_channels<T: Coefficient>(c: T) -> f64 {
    (0..T::CHANNELS).map(|k| c.channel(k).to_f64().powi(2)).sum()
}

/// The squared Laplacian of a function, `∫ (Δf)² ds = Σ_l l² (l+1)² Σ_m f_lm²`, summed over its channels.
///
/// # Panics
/// If `coefficients` are not `n²`.
#[must_use]
pub fn squared_laplacian<T: Coefficient>(coefficients: &[T]) -> f64 {
    band_energies(coefficients).iter().enumerate().map(|(l, e)| squared_eigenvalue(l) * e).sum()
}

/// The `λ` with which [`Window::SquaredLaplacian`](crate::Window::SquaredLaplacian) leaves `fraction` of the squared
/// Laplacian of a function whose bands have the energies `B_l`.
///
/// ```text
///   g(λ) = T - Σ_l L_l B_l / (1 + λ L_l)² = 0        L_l = l² (l+1)²        T = fraction · Σ_l L_l B_l
///   λ <- λ - g/g'                                   g' = 2 Σ_l L_l² B_l / (1 + λ L_l)³
/// ```
///
/// Newton's method from 0. `g` rises and is concave, so that every tangent lies above it and the steps approach the
/// root from below, never passing it (test `lambda_rises_from_zero_in_few_steps`). 0 for a fraction of 1 or more and
/// for a function without curvature; infinite for a fraction of 0 or less; NaN if the fraction is, or an energy is not
/// finite. The energies are never negative: a negative one counts as 0.
///
/// Source: [Sloan 2008] A6, where the target is printed as the original amount and the sum over `m` begins at -1 in
/// code that follows it; it begins at `-l`. Test `lambdas_of_the_impulse_are_golden`: 1e-12 relative for orders 2 to
/// 10.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
#[must_use]
pub fn squared_laplacian_lambda(band_energies: &[f64], fraction: f64) -> f64 {
    /// The most steps: even a fraction of 1e-12 takes fewer than 50.
    const STEPS: usize = 200;

    // In a unit in which no sum leaves the range of numbers: the answer does not depend on it.
    let largest = band_energies.iter().fold(0.0, |largest: f64, e| largest.max(*e));
    let energies: Vec<f64> = band_energies.iter().map(|e| if largest > 0.0 { e / largest } else { *e }).collect();
    let total: f64 = curvatures(&energies).map(|(eigenvalue, e)| eigenvalue * e).sum();
    if !total.is_finite() || fraction.is_nan() {
        return f64::NAN;
    }
    if total == 0.0 || fraction >= 1.0 {
        return 0.0;
    }
    if fraction <= 0.0 {
        return f64::INFINITY;
    }
    let mut lambda = 0.0;
    for _ in 0..STEPS {
        let next = newton_step(&energies, fraction * total, lambda);
        // The steps approach from below: one that does not rise is rounding.
        if next <= lambda || next.is_nan() {
            break;
        }
        lambda = next;
    }
    lambda
}

/// `L_l` and `B_l` of every band, no energy below 0; NaN stays.
fn curvatures(band_energies: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let energy = |e: f64| if e < 0.0 { 0.0 } else { e };
    band_energies.iter().enumerate().map(move |(l, e)| (squared_eigenvalue(l), energy(*e)))
}

/// `λ - g/g'` of [`squared_laplacian_lambda`].
fn newton_step(band_energies: &[f64], target: f64, lambda: f64) -> f64 {
    let (mut g, mut slope) = (target, 0.0);
    for (eigenvalue, e) in curvatures(band_energies) {
        let d = 1.0 + lambda * eigenvalue;
        g -= eigenvalue * e / (d * d);
        slope += 2.0 * eigenvalue * eigenvalue * e / (d * d * d);
    }
    lambda - g / slope
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::filter::Window;
    use crate::filter::window::scale_bands_in_place;
    use crate::scalar::Rgb;
    use crate::sphere::Dir;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{Random, golden_f64s};

    #[test]
    fn lambdas_of_the_impulse_are_golden() {
        for order in 2..=10 {
            let f = ShVec::<f64>::impulse(order, Dir::Z, 1.0);
            for fraction in ["0.5", "0.1"] {
                let golden = golden_f64s(&format!("/laplacian_lambda_delta/{order}/{fraction}"))[0];
                let energies = f.band_energies();
                let found = squared_laplacian_lambda(&energies, fraction.parse().unwrap());
                assert!((found / golden - 1.0).abs() < 1e-12, "order {order}, {fraction}: {found} against {golden}");
            }
        }
        let energies = ShVec::<f64>::impulse(6, Dir::X, 1.0).band_energies();
        for (fraction, published) in [(0.1, 0.00420855331055888), (0.5, 0.000631543536668657)] {
            let found = squared_laplacian_lambda(&energies, fraction);
            assert!((found / published - 1.0).abs() < 1e-12, "{fraction} of order 6: {found} against {published}");
        }
    }

    #[test]
    fn the_window_of_a_function_leaves_the_fraction_of_its_own_laplacian() {
        let f = ShVec::from_vec(
            Random::new(7).signed_vec(3 * 49).chunks(3).map(|c| Rgb::new(c[0], c[1], 9.0 * c[2])).collect(),
        )
        .unwrap();
        let before = squared_laplacian(f.coefficients());
        for fraction in [0.9, 0.5, 0.1, 1e-3, 1e-9] {
            let window = Window::squared_laplacian_of(f.coefficients(), fraction);
            let left = squared_laplacian(f.windowed(&window).coefficients()) / before;
            assert!((left / fraction - 1.0).abs() < 1e-10, "{left} left of the wanted {fraction}");
        }
    }

    #[test]
    fn the_squared_laplacian_is_its_integral() {
        let f = ShVec::from_vec(Random::new(8).signed_vec(25)).unwrap();
        // Δy_l = -l(l+1) y_l
        let mut laplacian = f.clone();
        scale_bands_in_place(laplacian.coefficients_mut(), &[0.0, -2.0, -6.0, -12.0, -20.0]);
        let integral = SphereQuadrature::of_degree(8).integrate(|s| laplacian.eval(s).powi(2));
        let sum = squared_laplacian(f.coefficients());
        assert!((sum / integral - 1.0).abs() < 1e-12, "{sum} against {integral}");
    }

    #[test]
    fn degenerate_lambdas_are_defined() {
        assert_eq!(squared_laplacian_lambda(&[3.0, 0.0, 0.0], 0.1), 0.0, "a constant");
        assert_eq!(squared_laplacian_lambda(&[], 0.1), 0.0, "nothing");
        assert_eq!(squared_laplacian_lambda(&[1.0, 1.0], 1.0), 0.0, "all of it");
        let flat = Window::SquaredLaplacian { lambda: squared_laplacian_lambda(&[1.0, 1.0], 0.0) };
        assert_eq!(flat.factors(3), [1.0, 0.0, 0.0], "none of it");
        assert_eq!(squared_laplacian_lambda(&[1.0, -1.0], 0.5), 0.0, "a negative energy is none");
        for (energies, fraction) in [([1.0, f64::NAN], 0.5), ([1.0, f64::INFINITY], 0.5), ([1.0, 1.0], f64::NAN)] {
            let lambda = squared_laplacian_lambda(&energies, fraction);
            assert!(lambda.is_nan(), "{energies:?} to {fraction}: {lambda}");
        }
    }

    #[test]
    fn lambda_rises_from_zero_in_few_steps() {
        let mut random = Random::new(11);
        let energies: Vec<Vec<f64>> = (2..=10).map(|order| (0..order).map(|_| random.unit()).collect()).collect();
        let suns = (2..=10).map(|order| ShVec::<f64>::impulse(order, Dir::Z, 1.0).band_energies());
        for energies in energies.into_iter().chain(suns) {
            let total: f64 = curvatures(&energies).map(|(eigenvalue, e)| eigenvalue * e).sum();
            for fraction in [0.9, 0.75, 0.5, 0.1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12] {
                let root = squared_laplacian_lambda(&energies, fraction);
                let (mut lambda, mut steps) = (0.0, 0);
                while lambda < root * (1.0 - 1e-14) {
                    let next = newton_step(&energies, fraction * total, lambda);
                    assert!(
                        lambda < next && next <= root * (1.0 + 1e-14),
                        "{fraction}: {next} after {lambda} to {root}"
                    );
                    (lambda, steps) = (next, steps + 1);
                    assert!(steps < 50, "{fraction} of {energies:?}: still at {lambda} of {root}");
                }
            }
        }
    }
}
