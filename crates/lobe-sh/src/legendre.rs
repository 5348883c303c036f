//! Legendre polynomials and associated Legendre functions.

use crate::{Basis, Real};

/// The associated Legendre function `P_l^m(z)` with the Condon-Shortley phase, for `0 <= m <= l` and `|z| <= 1`.
///
/// ```text
///   P_l^m(z) = (-1)^m (1 - z²)^{m/2} d^m/dz^m P_l(z)
///
///   P_m^m = (1 - 2m) √(1 - z²) P_{m-1}^{m-1}        P_{m+1}^m = (2m + 1) z P_m^m
///   P_l^m = ((2l - 1) z P_{l-1}^m - (l + m - 1) P_{l-2}^m) / (l - m)
/// ```
///
/// Zero for `m > l`. Not normalised: beyond `l + m` of about 150 it overflows; the basis uses
/// [`legendre_normalised`] instead. Source: [Sloan 2008] A1; DLMF 14.10.3.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
#[must_use]
pub fn legendre(l: usize, m: usize, z: f64) -> f64 {
    if m > l {
        return 0.0;
    }
    let sin_theta = ((1.0 - z) * (1.0 + z)).sqrt();
    let mut p = (1..=m).fold(1.0, |p, m| p * (1.0 - 2.0 * m as f64) * sin_theta);
    let mut before = 0.0;
    for k in m + 1..=l {
        let (kf, mf) = (k as f64, m as f64);
        (before, p) = (p, ((2.0 * kf - 1.0) * z * p - (kf + mf - 1.0) * before) / (kf - mf));
    }
    p
}

/// The associated Legendre function normalised for the complex basis, Condon-Shortley phase included.
///
/// ```text
///   N_l^m P_l^m(cos θ)        N_l^m = √((2l+1)/(4π) (l-m)!/(l+m)!)        Y_l^m = N_l^m P_l^m(cos θ) e^{imφ}
/// ```
///
/// For `0 <= m <= l`; zero for `m > l`. Stable to orders far beyond [`MAX_ORDER`](crate::MAX_ORDER): no factorial
/// is formed.
#[must_use]
pub fn legendre_normalised(l: usize, m: usize, z: f64) -> f64 {
    if m > l {
        return 0.0;
    }
    let sin_theta = ((1.0 - z) * (1.0 + z)).sqrt();
    // Towards φ = 0 the real basis function of m > 0 is √2 N P, that of m = 0 is N P.
    let scale = if m == 0 { 1.0 } else { 0.5_f64.sqrt() };
    let mut value = 0.0;
    f64::with_shared_basis(l + 1, |basis: &Basis<f64>| {
        basis.for_each([sin_theta, 0.0, z], l + 1, |i, y| {
            if i == crate::index(l, m as isize) {
                value = scale * y;
            }
        });
    });
    value
}

/// The Legendre polynomials `P_0(t) .. P_{count-1}(t)`.
pub(crate) fn legendre_all(count: usize, t: f64) -> impl Iterator<Item = f64> {
    let (mut before, mut p) = (0.0, 1.0);
    (0..count).map(move |l| {
        let value = p;
        let lf = l as f64;
        (before, p) = (p, ((2.0 * lf + 1.0) * t * p - lf * before) / (lf + 1.0));
        value
    })
}
