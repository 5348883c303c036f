//! The lengths of basis functions.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// The length of the basis functions of a library.
///
/// With `y` real and orthonormal, the library's function is `q y`:
///
/// ```text
///   Orthonormal    ∫ Y² = 1                   q = 1
///   FourPi         ∫ Y² = 4π                  q = √(4π)
///   Schmidt        ∫ Y² = 4π/(2l+1)           q = √(4π/(2l+1))
///   Unnormalized   Y = P_l^|m| cos mφ, ..     q = √(4π/((2-δ_m0)(2l+1)) (l+|m|)!/(l-|m|)!)
///   MaxN           Schmidt times weights      W is √½, the largest value of each other function 1
/// ```
///
/// In a complex basis `2-δ_m0` is 1. Geodesy calls `FourPi` fully normalized, Ambisonics calls it N3D; Schmidt is
/// semi-normalized, or SN3D [Nachbar 2011]. Weights are those of [Malham 2003].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum BasisNormalization {
    /// The integral of the square is 1.
    Orthonormal,
    /// The integral of the square is 4π: the mean square is 1.
    FourPi,
    /// The squares of a band sum to 1 in every direction.
    Schmidt,
    /// Associated Legendre functions as they are.
    Unnormalized,
    /// The weights of `FuMa`.
    MaxN,
}

/// The most bands of unnormalized functions. `√(170!) = 8.5e153` is a factor of band 85, and its square is the last
/// factorial in `f64`. Numbers down to 1e-154 keep all their digits.
const MOST_UNNORMALIZED: usize = 86;

/// The bands that `FuMa` has letters for.
const MOST_FUMA: usize = 4;

/// A product is rooted before it leaves `f64`.
const LARGE: f64 = 1e250;

impl BasisNormalization {
    /// The most bands; none where there is no limit.
    pub(crate) const fn most_bands(self) -> Option<usize> {
        match self {
            Self::Unnormalized => Some(MOST_UNNORMALIZED),
            Self::MaxN => Some(MOST_FUMA),
            _ => None,
        }
    }

    /// `q` of band `l` and `m >= 0`, of a real or of a complex basis.
    pub(crate) fn length(self, l: usize, m: usize, is_complex: bool) -> f64 {
        let schmidt = || (4.0 * PI / (2 * l + 1) as f64).sqrt();
        match self {
            Self::Orthonormal => 1.0,
            Self::FourPi => (4.0 * PI).sqrt(),
            Self::Schmidt => schmidt(),
            Self::Unnormalized => {
                let halves = if is_complex || m == 0 { 1.0 } else { FRAC_1_SQRT_2 };
                halves * schmidt() * root_of_factorials(l, m)
            }
            Self::MaxN => schmidt() * fuma_weight(l, m),
        }
    }
}

/// `√((l+m)!/(l-m)!)`, by roots of partial products, which stay inside `f64`.
fn root_of_factorials(l: usize, m: usize) -> f64 {
    let (mut root, mut product) = (1.0, 1.0);
    for k in l - m + 1..=l + m {
        product *= k as f64;
        if product > LARGE {
            root *= f64::sqrt(product);
            product = 1.0;
        }
    }
    root * f64::sqrt(product)
}

/// What the functions of SN3D are multiplied by.
fn fuma_weight(l: usize, m: usize) -> f64 {
    match (l, m) {
        (0, _) => FRAC_1_SQRT_2,
        (2, 1 | 2) => 2.0 / 3.0_f64.sqrt(),
        (3, 1) => (45.0_f64 / 32.0).sqrt(),
        (3, 2) => 3.0 / 5.0_f64.sqrt(),
        (3, 3) => (8.0_f64 / 5.0).sqrt(),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::{coefficient_index, eval_basis, legendre};
    use crate::sphere::{Dir, SphereQuadrature};

    fn values(kind: BasisNormalization, s: Dir, order: usize) -> Vec<f64> {
        let y = eval_basis(s, order);
        (0..order)
            .flat_map(|l| (-(l as isize)..=l as isize).map(move |m| (l, m)))
            .map(|(l, m)| y[coefficient_index(l, m)] * kind.length(l, m.unsigned_abs(), false))
            .collect()
    }

    #[test]
    fn squares_have_the_integrals_of_the_definition() {
        let rule = SphereQuadrature::of_degree(14);
        for (kind, integral) in [
            (BasisNormalization::Orthonormal, (|_| 1.0) as fn(f64) -> f64),
            (BasisNormalization::FourPi, |_| 4.0 * PI),
            (BasisNormalization::Schmidt, |l| 4.0 * PI / (2.0 * l + 1.0)),
        ] {
            for i in 0..64_usize {
                let found = rule.integrate(|s| values(kind, s, 8)[i].powi(2));
                let expected = integral(i.isqrt() as f64);
                assert!((found - expected).abs() < 1e-12, "{kind:?}, {i}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn unnormalized_functions_are_those_of_legendre() {
        let (theta, phi) = (1.1_f64, 0.4_f64);
        let found = values(BasisNormalization::Unnormalized, Dir::from_angles(theta, phi), 20);
        for l in 0..20_usize {
            for m in 0..=l {
                let p = legendre(l, m, theta.cos());
                for (m, turn) in [(m as isize, (m as f64 * phi).cos()), (-(m as isize), (m as f64 * phi).sin())] {
                    let (found, expected) = (found[coefficient_index(l, m)], if m == 0 { p } else { p * turn });
                    let error = (found - expected).abs() / p.abs();
                    assert!(error < 1e-12, "l {l}, m {m}: {found}, expected {expected}");
                }
            }
        }
    }

    #[test]
    fn the_largest_values_of_fuma_are_one_and_that_of_the_first_root_of_one_half() {
        let mut largest = [0.0_f64; 16];
        for i in 0..=360 {
            for j in 0..=720 {
                let s = Dir::from_angles(0.5_f64.to_radians() * f64::from(i), 0.5_f64.to_radians() * f64::from(j));
                for (largest, value) in largest.iter_mut().zip(values(BasisNormalization::MaxN, s, 4)) {
                    *largest = largest.max(value.abs());
                }
            }
        }
        for (i, found) in largest.into_iter().enumerate() {
            let expected = if i == 0 { FRAC_1_SQRT_2 } else { 1.0 };
            assert!((found - expected).abs() < 1e-4, "{i}: {found}, expected {expected}");
        }
    }

    #[test]
    fn factorials_of_the_highest_band_are_inside_the_numbers() {
        let l = MOST_UNNORMALIZED - 1;
        let exact: f64 = (1..=2 * l).map(|k| (k as f64).ln()).sum::<f64>() * 0.5;
        let found = root_of_factorials(l, l);
        assert!((found.ln() - exact).abs() < 1e-12 * exact && found.is_finite(), "{found:e}, logarithm {exact}");
    }
}
