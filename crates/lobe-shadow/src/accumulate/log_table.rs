//! The table of the logarithms of spheres.

use std::f64::consts::PI;

use derive_setters::Setters;
use lobe_sh::Zonal;
use lobe_sh::exponential::{LOG_CLAMP, ZonalLogarithm};

use crate::error::ShadowError;

/// The highest order of a table.
pub(crate) const MAX_TABLE_ORDER: usize = 8;

/// Coefficients of that order.
pub(crate) const MAX_LEN: usize = MAX_TABLE_ORDER * MAX_TABLE_ORDER;

/// What a [`LogTable`] is made for; files keep it, and a table of other options is refused.
#[derive(Clone, Copy, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct LogTableOptions {
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// The width `h > 0` of a window on the visibility before its logarithm, `α_l = cos(πl/2h)`, 0 from `l = h` on; none
    /// unless it is given. The window of a public re-implementation of [Ren et al. 2006] has `h = 2n`.
    ///
    /// Against what 16 random spheres really leave, 30 % of the sky hidden, the mean error without and with that window is 0.075
    /// and 0.084 at order 3, 0.077 and 0.085 at order 4, 0.077 and 0.086 at order 6 (example `exponential_errors`). It pays at high orders where much is hidden
    /// by large spheres: at order 6 and 50 % hidden 0.22 without, 0.13 with (example `exponential_errors`).
    ///
    /// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
    #[setters(strip_option)]
    pub window: Option<f64>,
    /// The least eigenvalue that the logarithm keeps, as a part of the largest; see [`lobe_sh::exponential::logarithm`].
    pub clamp: f64,
    /// The most that interpolation and rounding may move a logarithm, as the norm of the difference; a norm of 0.01 changes visibility by
    /// 0.3 % in the root mean square.
    pub tolerance: f64,
}

impl Default for LogTableOptions {
    /// Order 4, no window, the clamp of [`LOG_CLAMP`], and a tolerance of 0.01, a fifth of what the clamp costs at best.
    fn default() -> Self {
        Self { order: 4, window: None, clamp: LOG_CLAMP, tolerance: 0.01 }
    }
}

impl LogTableOptions {
    /// # Errors
    /// The reason for which no table can be made.
    pub(crate) fn check(&self) -> Result<(), String> {
        if !(1..=MAX_TABLE_ORDER).contains(&self.order) {
            return Err(format!(
                "expected an order of the log table from 1 to {MAX_TABLE_ORDER}, found {}",
                self.order
            ));
        }
        if let Some(h) = self.window.filter(|h| !(h.is_finite() && *h > 0.0)) {
            return Err(format!("expected a width of the window above 0, found {h}"));
        }
        if !(self.clamp > 0.0 && self.clamp <= 1.0) {
            return Err(format!("expected a clamp above 0 and up to 1, found {}", self.clamp));
        }
        if !(self.tolerance > 0.0 && self.tolerance.is_finite()) {
            return Err(format!("expected a tolerance above 0, found {}", self.tolerance));
        }
        Ok(())
    }
}

/// Coefficients of the polynomial for small spheres, of degree one less in each band.
pub(crate) const FIT: usize = 8;

/// Intervals of the first table that is tried, and the most.
const INTERVALS: [usize; 2] = [64, 1 << 16];

/// Places in an interval where its error is measured. The logarithm has kinks where an eigenvalue reaches the clamp, and the
/// error near one peaks anywhere in the interval.
const PLACES: [f64; 3] = [0.25, 0.5, 0.75];

/// The part of the tolerance that errors at those places may have: a kink between two of them has at most a third more.
const AT_PLACES: f64 = 0.75;

/// Places along the polynomial where its error is measured.
const FIT_PLACES: usize = 128;

/// The end of the polynomials that is tried first: 60 degrees. Beyond, `u` is no good variable.
pub(crate) const FIT_END: f32 = 0.75;

/// The least end of the polynomials: 2 degrees.
pub(crate) const LEAST_FIT_END: f32 = 1e-3;

/// The logarithms of what spheres leave visible, over their size as seen from the receiver.
///
/// ```text
///   log V(s) = Σ_l F_l(w) y_lm(dir) ...        w = 1 - cos θ        sin θ = r/d        θ <= 90°
/// ```
///
/// `w` is the solid angle divided by `2π`. The coefficients of a cone are polynomials in it, which makes the logarithm smooth
/// from 0, where it vanishes, to 90°, but for kinks where an eigenvalue of the product matrix reaches the clamp; over the half
/// angle or `r/d` it would be steep at one end. Rows at equal steps of `w` are interpolated linearly, with as many steps as
/// the tolerance of the options needs, powers of two apart. For small spheres, by far the most, a polynomial in each band takes
/// the place of the rows, so that receivers in lanes need no lookups:
///
/// ```text
///   F_l = u Σ_k c_lk (2u/u_1 - 1)^k        u = sin² θ <= u_1
/// ```
///
/// The factors `√(4π/(2l+1))` of the rotation are in `F_l`: it multiplies `y_lm` of the direction to the sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct LogTable {
    pub(crate) options: LogTableOptions,
    /// `F_l` at `w = k/intervals`, row after row.
    pub(crate) rows: Vec<f32>,
    /// `c_lk`, band after band, ascending `k`.
    pub(crate) fit: Vec<[f32; FIT]>,
    /// `u_1`.
    pub(crate) fit_end: f32,
}

impl LogTable {
    /// Makes the table, in a second or two at most.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if an option is out of its range, or the tolerance would need more than 65536 rows or polynomials
    /// for spheres of less than two degrees.
    pub fn new(options: &LogTableOptions) -> Result<Self, ShadowError> {
        options.check().map_err(ShadowError::Options)?;
        let exact = Exact::new(options);
        let (fit, fit_end) = fit(&exact, options)?;
        let mut intervals = INTERVALS[0];
        let mut rows = exact.rows(intervals, &[0.0]);
        rows.push(exact.at(1.0));
        loop {
            let between = exact.rows(intervals, &PLACES);
            if is_near(&rows, &between, AT_PLACES * options.tolerance) {
                break;
            }
            if intervals == INTERVALS[1] {
                let message = format!(
                    "a tolerance of {} needs a log table of more than {} rows; take a larger one",
                    options.tolerance, INTERVALS[1]
                );
                return Err(ShadowError::Options(message));
            }
            // The middle ones are the rows of half the step.
            let middles = between.chunks_exact(PLACES.len()).map(|places| places[1].clone());
            let last = rows.pop();
            rows = rows.into_iter().zip(middles).flat_map(|(row, middle)| [row, middle]).chain(last).collect();
            intervals *= 2;
        }
        let rows = rows.iter().flatten().map(|f| *f as f32).collect();
        Ok(Self { options: *options, rows, fit, fit_end })
    }

    /// What the table is made for.
    #[must_use]
    pub fn options(&self) -> &LogTableOptions {
        &self.options
    }

    /// The number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.options.order
    }

    /// The number of rows.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.rows.len() / self.options.order
    }

    /// `c_lk`, band after band, ascending `k`, and the `u_1` up to which they hold; for shaders.
    #[must_use]
    pub fn polynomials(&self) -> (&[[f32; FIT]], f32) {
        (&self.fit, self.fit_end)
    }

    /// `F_l` at equal steps of `w` from 0 to 1, row after row; for shaders.
    #[must_use]
    pub fn rows(&self) -> &[f32] {
        &self.rows
    }

    /// The logarithm of a sphere of angular radius `half_angle`, in radians, as receivers accumulate it; beyond 90° that
    /// of 90°.
    #[must_use]
    pub fn at(&self, half_angle: f64) -> Zonal {
        let half_angle = half_angle.clamp(0.0, 0.5 * PI);
        let (u, w) = (half_angle.sin().powi(2) as f32, (1.0 - half_angle.cos()) as f32);
        let mut factors = [0.0; MAX_TABLE_ORDER];
        let factors = &mut factors[..self.options.order];
        if u <= self.fit_end {
            self.fitted(u, factors);
        } else {
            self.interpolated(w, factors);
        }
        Zonal::new(factors.iter().enumerate().map(|(l, f)| f64::from(*f) / rotation_factor(l)).collect())
    }

    /// `F_l` by the polynomials, for `u <= u_1`.
    pub(crate) fn fitted(&self, u: f32, out: &mut [f32]) {
        for (out, c) in out.iter_mut().zip(&self.fit) {
            *out = fitted(c, self.fit_end, u);
        }
    }

    /// `F_l(w)` between two rows, for `w` in `[0, 1]`.
    pub(crate) fn interpolated(&self, w: f32, out: &mut [f32]) {
        let n = out.len();
        let intervals = self.rows.len() / n - 1;
        let place = w * intervals as f32;
        let row = (place as usize).min(intervals - 1);
        let t = place - row as f32;
        let (low, high) = self.rows[row * n..(row + 2) * n].split_at(n);
        for ((out, low), high) in out.iter_mut().zip(low).zip(high) {
            *out = low + t * (high - low);
        }
    }
}

/// `u Σ_k c_k (2u/end - 1)^k`.
fn fitted(polynomial: &[f32; FIT], end: f32, u: f32) -> f32 {
    let x = u * (2.0 / end) - 1.0;
    u * polynomial.iter().rev().fold(0.0, |p, c| p * x + c)
}

/// `√(4π/(2l+1))`, from a zonal coefficient to the factor of `y_lm(axis)`.
pub(crate) fn rotation_factor(l: usize) -> f64 {
    (4.0 * PI / (2 * l + 1) as f64).sqrt()
}

/// The function that is tabulated.
struct Exact {
    logarithm: ZonalLogarithm,
    window: Vec<f64>,
}

impl Exact {
    fn new(options: &LogTableOptions) -> Self {
        let factor = |l: usize| match options.window {
            Some(h) if l as f64 >= h => 0.0,
            Some(h) => (PI * l as f64 / (2.0 * h)).cos(),
            None => 1.0,
        };
        let window = (0..options.order).map(factor).collect();
        Self { logarithm: ZonalLogarithm::new(options.order, options.clamp), window }
    }

    /// `F_l(w)`.
    fn at(&self, w: f64) -> Vec<f64> {
        let half_angle = 2.0 * (0.5 * w).sqrt().min(1.0).asin();
        let mut visible: Vec<f64> =
            Zonal::cone(self.window.len(), half_angle).coefficients().iter().map(|c| -c).collect();
        visible[0] += (4.0 * PI).sqrt();
        visible.iter_mut().zip(&self.window).for_each(|(c, factor)| *c *= factor);
        let logarithm = self.logarithm.of(&Zonal::new(visible));
        logarithm.coefficients().iter().enumerate().map(|(l, z)| z * rotation_factor(l)).collect()
    }

    /// At these places of each of `intervals` intervals of `[0, 1]`.
    fn rows(&self, intervals: usize, places: &[f64]) -> Vec<Vec<f64>> {
        let at = |k: usize| places.iter().map(move |place| (k as f64 + place) / intervals as f64);
        (0..intervals).flat_map(at).map(|w| self.at(w)).collect()
    }
}

/// The norm of the difference of two logarithms that are given by `F_l`.
fn difference<'a>(a: impl IntoIterator<Item = &'a f64>, b: impl IntoIterator<Item = f64>) -> f64 {
    let terms = a.into_iter().zip(b).enumerate();
    terms.map(|(l, (a, b))| ((a - b) / rotation_factor(l)).powi(2)).sum::<f64>().sqrt()
}

/// Whether no error of rows, rounded as they are kept, is beyond a tolerance at the places between them.
fn is_near(rows: &[Vec<f64>], between: &[Vec<f64>], tolerance: f64) -> bool {
    rows.windows(2).zip(between.chunks_exact(PLACES.len())).all(|(pair, exact)| {
        exact.iter().zip(PLACES).all(|(exact, t)| {
            let rounded = pair[0].iter().zip(&pair[1]).map(|(low, high)| (*low as f32, *high as f32));
            difference(exact, rounded.map(|(low, high)| f64::from(low + t as f32 * (high - low)))) <= tolerance
        })
    })
}

/// The polynomials and where they end: as far as they keep the tolerance.
fn fit(exact: &Exact, options: &LogTableOptions) -> Result<(Vec<[f32; FIT]>, f32), ShadowError> {
    let mut end = FIT_END;
    loop {
        let polynomials = fit_to(exact, options.order, f64::from(end));
        // At numbers of `f32`, where the polynomial is evaluated.
        let is_near = |k: usize| {
            let u = end * k as f32 / FIT_PLACES as f32;
            let values = polynomials.iter().map(|c| f64::from(fitted(c, end, u)));
            difference(&exact.at(one_minus_cos(f64::from(u))), values) <= AT_PLACES * options.tolerance
        };
        if (1..=FIT_PLACES).all(is_near) {
            return Ok((polynomials, end));
        }
        end *= 0.9;
        if end < LEAST_FIT_END {
            let message = format!("no polynomials keep a tolerance of {}; take a larger one", options.tolerance);
            return Err(ShadowError::Options(message));
        }
    }
}

/// `w` of `u`, without the loss of digits for small angles.
fn one_minus_cos(u: f64) -> f64 {
    u / (1.0 + (1.0 - u).sqrt())
}

/// The polynomials through `F_l/u` at the Chebyshev nodes of `[0, end]`.
fn fit_to(exact: &Exact, order: usize, end: f64) -> Vec<[f32; FIT]> {
    let nodes: [f64; FIT] = std::array::from_fn(|k| (PI * (k as f64 + 0.5) / FIT as f64).cos());
    let values: Vec<Vec<f64>> = nodes
        .iter()
        .map(|x| 0.5 * end * (x + 1.0))
        .map(|u| exact.at(one_minus_cos(u)).into_iter().map(|f| f / u).collect())
        .collect();
    let polynomial = |l: usize| monomials(&nodes, std::array::from_fn(|k| values[k][l]));
    (0..order).map(|l| polynomial(l).map(|c| c as f32)).collect()
}

/// The coefficients of the polynomial through values at nodes, by Newton's divided differences.
fn monomials(nodes: &[f64; FIT], mut values: [f64; FIT]) -> [f64; FIT] {
    let n = FIT;
    for step in 1..n {
        for k in (step..n).rev() {
            values[k] = (values[k] - values[k - 1]) / (nodes[k] - nodes[k - step]);
        }
    }
    let mut polynomial = [0.0; FIT];
    for k in (0..n).rev() {
        // Multiply by x - node and add the difference.
        for j in (1..n).rev() {
            polynomial[j] = polynomial[j - 1] - nodes[k] * polynomial[j];
        }
        polynomial[0] = values[k] - nodes[k] * polynomial[0];
    }
    polynomial
}
