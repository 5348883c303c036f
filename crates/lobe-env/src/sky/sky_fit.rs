//! Polynomial fit of a clear sky's coefficients, over the sun's height and the turbidity.

use std::f64::consts::{FRAC_PI_2, PI};

use derive_setters::Setters;
use lobe_io::parallel;
use lobe_sh::basis::{coefficient_index, order_of};
use lobe_sh::{Coefficient, Dir, Rgb, ShVec};

use crate::error::EnvError;
use crate::sky::preetham::PreethamSky;
use crate::sky::preetham::luminance_scale;
use crate::sky::sky::turn_to_azimuth;
use crate::sky::sky::{Ground, sky_sh};

/// The turbidities of the fit.
const TURBIDITY: [f64; 2] = [2.0, 10.0];

/// The size of a [`PreethamFit`].
///
/// The default is that of Habel, Mustata and Wimmer: degree 13 in the sun's height, 7 in the turbidity, 112 terms,
/// bands 0 to 6.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct SkyFitOptions {
    /// The order of the expansions.
    pub order: usize,
    /// The degree in the sun's angle from the zenith.
    pub sun_degree: usize,
    /// The degree in the turbidity.
    pub turbidity_degree: usize,
}

impl Default for SkyFitOptions {
    fn default() -> Self {
        Self { order: 7, sun_degree: 13, turbidity_degree: 7 }
    }
}

/// A fit of [`PreethamSky`]: its coefficients by polynomials instead of quadrature.
///
/// ```text
///   f_lm(θ_sun, T) = Y_z/F_Y(0, θ_sun) Σ_ij c_lmij T_i(x) T_j(y)        x = 4θ_sun/π - 1,  y = (T - 6)/4
/// ```
///
/// with Chebyshev polynomials `T_i`. The factor in front is that of the luminance in [`PreethamSky`]; it has most of
/// the model's dependence on turbidity, and a pole just below `T = 2` that no polynomial follows. With the sun at
/// azimuth 0 the sine coefficients vanish, so only `n(n+1)/2` coefficients of each channel are fitted; the result is
/// then rotated to the sun's azimuth, which is exact. The fit is the discrete Chebyshev expansion over twice as many
/// nodes as terms: within a small factor of the best uniform approximation.
///
/// Error: root mean square over the sphere relative to that of the sky, order 7, suns from the zenith to the horizon,
/// turbidities from 2 to 10 (bounded by test `the_fit_has_the_errors_of_its_table`); multiply-adds per evaluation:
///
/// | degrees in sun, turbidity | terms | mean | largest | multiply-adds |
/// |---|---|---|---|---|
/// | 13, 7 | 112 | 0.040 % | 0.20 % | 9408 |
/// | 10, 5 | 66 | 0.29 % | 1.2 % | 5544 |
/// | 8, 4 | 45 | 0.79 % | 3.3 % | 3780 |
/// | 6, 3 | 28 | 2.2 % | 8.8 % | 2352 |
///
/// The polynomial fit is due to [Habel, Mustata and Wimmer 2008], who damp the ringing at the horizon with
/// [`damp_zonal_in_place`]. The example `sky_fit` prints this table and the times.
///
/// [Habel, Mustata and Wimmer 2008]: https://doi.org/10.2312/egs.20081036
#[derive(Clone, Debug)]
pub struct PreethamFit {
    options: SkyFitOptions,
    /// For each term `i (turbidity_degree + 1) + j`: red, green, blue of every `(l, m >= 0)`.
    terms: Vec<f64>,
}

impl PreethamFit {
    /// Computes the fit, in parallel; the same bits for any number of threads.
    ///
    /// # Errors
    /// [`EnvError::Options`] if the order is 0.
    pub fn new(options: SkyFitOptions) -> Result<Self, EnvError> {
        let SkyFitOptions { order, sun_degree, turbidity_degree } = options;
        if order == 0 {
            return Err(EnvError::Options("a fit of order 1 at least expected, found 0".into()));
        }
        let (suns, turbidities) = (2 * (sun_degree + 1), 2 * (turbidity_degree + 1));
        let at_node = |k: usize| -> Result<Vec<f64>, EnvError> {
            let (x, y) = (node(k / turbidities, suns), node(k % turbidities, turbidities));
            let turbidity = (0.5 * (TURBIDITY[0] + TURBIDITY[1] + y * (TURBIDITY[1] - TURBIDITY[0])))
                .clamp(TURBIDITY[0], TURBIDITY[1]);
            let sun = Dir::from_angles(0.5 * FRAC_PI_2 * (1.0 + x), 0.0);
            let sky = PreethamSky::new(turbidity, sun)?;
            let f = sky_sh(&sky, &Ground::default(), order);
            Ok(cosines(&(&f * luminance_scale(turbidity, sun.theta()).recip())))
        };
        let skies = parallel::map(suns * turbidities, &at_node);
        let skies: Vec<Vec<f64>> = skies.into_iter().collect::<Result<_, EnvError>>()?;
        let lanes = 3 * order * (order + 1) / 2;
        let mut terms = vec![0.0; (sun_degree + 1) * (turbidity_degree + 1) * lanes];
        for (t, term) in terms.chunks_exact_mut(lanes).enumerate() {
            let (i, j) = (t / (turbidity_degree + 1), t % (turbidity_degree + 1));
            for (k, sky) in skies.iter().enumerate() {
                let weight = weight(i, k / turbidities, suns) * weight(j, k % turbidities, turbidities);
                for (sum, value) in term.iter_mut().zip(sky) {
                    *sum += weight * value;
                }
            }
        }
        Ok(Self { options, terms })
    }

    /// The options of the fit.
    #[must_use]
    pub fn options(&self) -> SkyFitOptions {
        self.options
    }

    /// The expansion of the sky alone, black below the horizon; [`Ground::add_to`] adds the ground.
    ///
    /// Turbidities and suns outside the range of the fit, `[2, 10]` and above the horizon, are clamped to it.
    #[must_use]
    pub fn eval(&self, turbidity: f64, sun: Dir) -> ShVec<Rgb<f64>> {
        let SkyFitOptions { order, sun_degree, turbidity_degree } = self.options;
        let turbidity = turbidity.clamp(TURBIDITY[0], TURBIDITY[1]);
        let x = (sun.theta() / FRAC_PI_2).min(1.0) * 2.0 - 1.0;
        let middle = 0.5 * (TURBIDITY[0] + TURBIDITY[1]);
        let y = (turbidity - middle) / (TURBIDITY[1] - middle);
        let across = chebyshev(turbidity_degree, y);
        let lanes = 3 * order * (order + 1) / 2;
        let mut sums = vec![0.0; lanes];
        let factors = chebyshev(sun_degree, x).into_iter().flat_map(|t| across.iter().map(move |u| t * u));
        for (factor, term) in factors.zip(self.terms.chunks_exact(lanes)) {
            for (sum, c) in sums.iter_mut().zip(term) {
                *sum += factor * c;
            }
        }
        let scale = luminance_scale(turbidity, sun.theta().min(FRAC_PI_2));
        let mut f = ShVec::zero(order);
        for ((l, m), c) in pairs(order).zip(sums.as_chunks::<3>().0) {
            f[coefficient_index(l, m as isize)] = Rgb::from(*c).scale(scale);
        }
        turn_to_azimuth(&mut f, sun.phi());
        f
    }
}

/// Damps the ringing of an expansion at the horizon by Lanczos factors on the zonal coefficients alone, which hold that
/// discontinuity.
///
/// ```text
///   f_l0 ← f_l0 sin(πl/n)/(πl/n)        f_lm unchanged for m ≠ 0
/// ```
///
/// As published by Habel, Mustata and Wimmer. Not rotation invariant: for skies with the horizon at `z = 0` only. A sun loses a few
/// percent of its peak, near the zenith up to half (test `damping_the_zonal_part_lowers_a_sun_by_half_at_the_zenith_and_little_below`).
///
/// # Panics
/// If `coefficients` are not `n²`.
pub fn damp_zonal_in_place<T: Coefficient>(coefficients: &mut [T]) {
    let found = coefficients.len();
    let Some(order) = order_of(found) else { panic!("n² coefficients expected, found {found}") };
    for l in 1..order {
        let x = PI * l as f64 / order as f64;
        let c = &mut coefficients[coefficient_index(l, 0)];
        *c = T::narrow(c.widen().scale(x.sin() / x));
    }
}

/// The pairs `(l, m)` with `m >= 0`.
fn pairs(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..order).flat_map(|l| (0..=l).map(move |m| (l, m)))
}

/// The coefficients with `m >= 0`, channel by channel.
fn cosines(f: &ShVec<Rgb<f64>>) -> Vec<f64> {
    let order = lobe_sh::Expansion::order(f);
    pairs(order).flat_map(|(l, m)| f[coefficient_index(l, m as isize)].to_array()).collect()
}

/// Chebyshev node `k` of `count`: `cos(π (k + ½)/count)`.
fn node(k: usize, count: usize) -> f64 {
    (PI * (k as f64 + 0.5) / count as f64).cos()
}

/// The weight of the value at node `k` in the coefficient of `T_i`: `(2 - δ_i0)/count · T_i(node k)`.
fn weight(i: usize, k: usize, count: usize) -> f64 {
    let both = if i == 0 { 1.0 } else { 2.0 };
    both / count as f64 * (PI * i as f64 * (k as f64 + 0.5) / count as f64).cos()
}

/// `T_0(x) .. T_degree(x)` by `T_{i+1} = 2x T_i - T_{i-1}`.
fn chebyshev(degree: usize, x: f64) -> Vec<f64> {
    let mut values = vec![1.0, x];
    for i in 2..=degree {
        values.push(2.0 * x * values[i - 1] - values[i - 2]);
    }
    values.truncate(degree + 1);
    values
}
