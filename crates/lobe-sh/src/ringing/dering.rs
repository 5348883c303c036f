//! Dering: the window that makes a function non-negative.

use core::fmt;
use core::str::FromStr;

use crate::basis::basis::eval_basis_into;
use crate::basis::index::{band_range, coefficient_count, order_of_slice};
use crate::error::ShError;
use crate::expansion::Zonal;
use crate::extrema::Extremum;
use crate::extrema::branch_and_bound::minimum_of;
use crate::extrema::quadratic_form::{QuadraticForm, to_unit_size};
use crate::filter::Window;
use crate::filter::kernel::convolve_in_place;
use crate::filter::squared_laplacian::band_energies;
use crate::filter::window::scale_bands_in_place;
use crate::prelude::*;
use crate::ringing::cutting_planes::{LeastChange, excess_at, least_change};
use crate::ringing::quadratic_dering::{LeastFactors, least_change_order_3, unit_roundoff};
use crate::ringing::sloan_table::{dering_table_factors, table_place};
use crate::ringing::{DERING_ALLOWED, DeringOutcome};
use crate::scalar::{Coefficient, Real};

/// The width of the reported intervals of the minima, relative to the mean.
const REPORTED: f64 = 4e-7;

/// Bisections of the interval of a family's strength.
const HALVINGS: usize = 30;

/// A family of windows with one parameter, the strength, from no window to one that leaves only the mean.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum WindowFamily {
    /// [`Window::Hanning`] of any width.
    Hanning,
    /// [`Window::Lanczos`] of any width.
    Lanczos {
        /// The power.
        power: f64,
    },
    /// [`Window::Gauss`] of any width.
    Gauss,
    /// [`Window::SquaredLaplacian`] of any weight.
    SquaredLaplacian,
}

impl WindowFamily {
    /// The window of a given strength: 0 is none, and every function with a positive mean becomes non-negative at some
    /// strength.
    fn window(self, strength: f64) -> Window {
        match self {
            Self::Hanning => Window::Hanning { width: 1.0 / strength },
            Self::Lanczos { power } => Window::Lanczos { width: 1.0 / strength, power },
            Self::Gauss => Window::Gauss { sigma: strength },
            Self::SquaredLaplacian => Window::SquaredLaplacian { lambda: strength },
        }
    }

    /// The strength at which the search for an upper end begins, and the factor by which it grows.
    fn first(self) -> (f64, f64) {
        match self {
            // At strength 1 the window is zero from band 1 on.
            Self::Hanning | Self::Lanczos { .. } => (1.0, 2.0),
            Self::Gauss => (0.1, 2.0),
            Self::SquaredLaplacian => (1e-6, 8.0),
        }
    }
}

/// The method that makes a function non-negative.
///
/// In text: `least-change`, `table`, or the name of a family, `hanning`, `lanczos:4`, `gauss`, `squared-laplacian`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum DeringMethod {
    /// One factor for each band, such that the norm of the change is least.
    ///
    /// ```text
    ///   minimize Σ_l E_l (1 - w_l)²   subject to   Σ_l w_l f_l >= 0 everywhere,   w_0 = 1,   0 <= w_l <= 1
    /// ```
    #[default]
    LeastChange,
    /// Sloan's bound and table of windows, for functions of up to three bands such as irradiance: the published method,
    /// for comparison. It blurs more than needed, because both the bound and the table are conservative.
    Table,
    /// The weakest window of a family, found by bisection of its strength. Where the minimum does not rise
    /// monotonically with the strength, a weaker window might succeed too.
    Family(WindowFamily),
}

impl fmt::Display for DeringMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeastChange => write!(f, "least-change"),
            Self::Table => write!(f, "table"),
            Self::Family(WindowFamily::Hanning) => write!(f, "hanning"),
            Self::Family(WindowFamily::Lanczos { power }) => write!(f, "lanczos:{power}"),
            Self::Family(WindowFamily::Gauss) => write!(f, "gauss"),
            Self::Family(WindowFamily::SquaredLaplacian) => write!(f, "squared-laplacian"),
        }
    }
}

impl FromStr for DeringMethod {
    type Err = ShError;

    fn from_str(text: &str) -> Result<Self, ShError> {
        Self::parse(text).map_err(ShError::Options)
    }
}

impl DeringMethod {
    fn parse(text: &str) -> Result<Self, String> {
        let (name, power) = text.split_once(':').map_or((text, None), |(name, power)| (name, Some(power)));
        match (name, power.map(str::parse::<f64>)) {
            ("least-change", None) => Ok(Self::LeastChange),
            ("table", None) => Ok(Self::Table),
            ("hanning", None) => Ok(Self::Family(WindowFamily::Hanning)),
            ("gauss", None) => Ok(Self::Family(WindowFamily::Gauss)),
            ("squared-laplacian", None) => Ok(Self::Family(WindowFamily::SquaredLaplacian)),
            ("lanczos", None) => Ok(Self::Family(WindowFamily::Lanczos { power: 1.0 })),
            ("lanczos", Some(Ok(power))) if power > 0.0 && power.is_finite() => {
                Ok(Self::Family(WindowFamily::Lanczos { power }))
            }
            _ => Err(format!(
                "expected least-change, table, hanning, lanczos[:POWER], gauss or squared-laplacian, found '{text}'"
            )),
        }
    }
}

/// Options of [`dering_in_place`]: by default the function itself becomes non-negative, by the least change, with evidence.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct DeringOptions {
    /// The method.
    pub method: DeringMethod,
    /// `None`: the function itself becomes non-negative. Otherwise its convolution with this kernel does: with
    /// [`Zonal::clamped_cosine`], radiance may stay negative as long as its irradiance is not. The factors are applied
    /// to the function itself in both cases.
    pub kernel: Option<Zonal>,
    /// Report the certified minima before and after and the optimality gap. Without, the least change of up to three bands takes a
    /// small part of the time, and may differ by 1e-6.
    pub evidence: bool,
}

impl Default for DeringOptions {
    fn default() -> Self {
        Self { method: DeringMethod::default(), kernel: None, evidence: true }
    }
}

impl DeringOptions {
    /// Sets [`method`](Self::method).
    #[must_use]
    pub fn method(self, method: DeringMethod) -> Self {
        Self { method, ..self }
    }

    /// Sets [`evidence`](Self::evidence).
    #[must_use]
    pub fn evidence(self, evidence: bool) -> Self {
        Self { evidence, ..self }
    }

    /// Sets [`kernel`](Self::kernel).
    #[must_use]
    pub fn kernel(self, kernel: impl Into<Option<Zonal>>) -> Self {
        Self { kernel: kernel.into(), ..self }
    }
}

/// The report of [`dering_in_place`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct DeringReport {
    /// How it ended: changed, unchanged or refused.
    pub outcome: DeringOutcome,
    /// The factor `w_l` of every band, which loses `1 - w_l²` of its energy; all are 1 if nothing was changed.
    pub factors: Vec<f64>,
    /// The window, if a [`WindowFamily`] was searched and the function changed.
    pub window: Option<Window>,
    /// The fraction of the total energy that was lost, summed over the channels, mean included, after convolution with
    /// [`DeringOptions::kernel`].
    pub energy_removed: f64,
    /// The minimum of every channel before, of the function convolved with [`DeringOptions::kernel`]. Empty without
    /// [`DeringOptions::evidence`].
    pub before: Vec<Extremum>,
    /// The minimum of every channel afterwards. Empty without [`DeringOptions::evidence`].
    pub after: Vec<Extremum>,
    /// For [`DeringMethod::LeastChange`] with [`DeringOptions::evidence`], the optimality gap: the norm of the change exceeds the least possible one by
    /// at most this fraction.
    ///
    /// The bound is proven: the factors that keep the function non-negative in finitely many directions, the solution
    /// of a small quadratic program, change it no more than any factors that keep it non-negative everywhere. The gap
    /// times the change is below 1e-5 of the norm of the function, part of which is the margin for rounding the
    /// coefficients (test `random_probes_of_order_4_have_no_point_below_zero` and its neighbors).
    pub excess: Option<f64>,
}

/// Makes a function non-negative by a window that all its channels share, so that no color shifts: the channel that
/// rings most decides.
///
/// The minimum is certified ([`certified_minimum`](crate::extrema::certified_minimum)), not sampled, and a margin is kept for
/// rounding the coefficients. A function that is negative by no more than rounding is not changed. Every result is
/// therefore at least `-`[`DERING_ALLOWED`] times the mean everywhere. The mean never changes, and the result turns
/// with the light: no frame is chosen that could degenerate.
///
/// Zero stays zero. [`DeringReport::outcome`] tells why a function could not be made non-negative.
///
/// Methods of types: [`Sh::deringed`](crate::Sh::deringed), [`ShVec::deringed`](crate::ShVec::deringed) and, of many functions, `ShBatch::dering_in_place`.
///
/// Source: [Sloan 2017] for the idea and for letting the worst channel decide; [`DeringMethod`] describes the methods.
///
/// ```
/// use lobe_sh::ringing::{DeringOptions, dering_in_place};
/// use lobe_sh::{Dir, Expansion as _, ShL2, Zonal};
///
/// // The irradiance of a sun rings below zero on the far side.
/// let mut e = ShL2::<f64>::impulse(Dir::Z, 1.0).convolved(&Zonal::clamped_cosine(3));
/// assert!(e.eval(Dir::from_angles(2.1, 0.0)) < -0.03);
/// let report = dering_in_place(e.coefficients_mut(), &DeringOptions::default());
/// assert!(report.after[0].lo > -1e-9 && report.energy_removed < 0.17, "{report:?}");
/// ```
///
/// # Panics
/// If `coefficients` are not `n²`.
///
/// [Sloan 2017]: https://www.ppsloan.org/publications/shdering.pdf
pub fn dering_in_place<T: Coefficient>(coefficients: &mut [T], dering: &DeringOptions) -> DeringReport {
    let order = order_of_slice(coefficients);
    if !dering.evidence && dering.method == DeringMethod::LeastChange && dering.kernel.is_none() && order <= 3 {
        return quick(coefficients, order);
    }
    // Convolve with the kernel whose result is to be non-negative.
    let mut examined: Vec<T::Wide> = coefficients.iter().map(|c| c.widen()).collect();
    if let Some(kernel) = &dering.kernel {
        convolve_in_place(&mut examined, kernel);
    }
    // Certify the minimum of every channel.
    let before = minima(&examined);
    // Factors and energies do not depend on the unit, and are found in one in which no square leaves the range of numbers.
    let unit = to_unit_size(largest(&examined));
    let energy = |f: &[T::Wide]| band_energies(&in_unit(f, unit)).iter().sum::<f64>();
    let energy_before = energy(&examined);
    // Find the factors, unless the function needs none or has none.
    let Solution { outcome, factors, window, excess } = match refusal(&examined, &before) {
        Some(outcome) => Solution::none(outcome),
        None => solve(&in_unit(&examined, unit), &dering.method, unit_roundoff::<T::Scalar>()),
    };
    // Apply the factors, and certify the minimum again.
    let mut after = before.clone();
    if let Some(factors) = &factors {
        scale_bands_in_place(coefficients, factors);
        examined = coefficients.iter().map(|c| c.widen()).collect();
        if let Some(kernel) = &dering.kernel {
            convolve_in_place(&mut examined, kernel);
        }
        after = minima(&examined);
    }
    // Report the energy lost.
    let energy_removed = match factors {
        Some(_) => 1.0 - energy(&examined) / energy_before,
        None => 0.0,
    };
    let factors = factors.unwrap_or_else(|| vec![1.0; order]);
    if !dering.evidence {
        return DeringReport { outcome, factors, window, energy_removed, before: vec![], after: vec![], excess: None };
    }
    DeringReport { outcome, factors, window, energy_removed, before, after, excess }
}

/// The least change of up to three bands, without evidence.
fn quick<T: Coefficient>(coefficients: &mut [T], order: usize) -> DeringReport {
    let found = least_change_order_3(coefficients);
    let report = report_of(&found, order, || {
        let energies = band_energies(coefficients);
        [0, 1, 2].map(|l| energies.get(l).copied().unwrap_or(0.0))
    });
    if report.outcome == DeringOutcome::Windowed {
        scale_bands_in_place(coefficients, &report.factors);
    }
    report
}

/// The report, without evidence, of a function of up to three bands with these energies.
pub(crate) fn report_of(found: &LeastFactors, order: usize, energies: impl FnOnce() -> [f64; 3]) -> DeringReport {
    let mut report = DeringReport {
        outcome: found.outcome,
        factors: found.factors[..order].to_vec(),
        window: None,
        energy_removed: 0.0,
        before: Vec::new(),
        after: Vec::new(),
        excess: None,
    };
    if found.outcome == DeringOutcome::Windowed {
        let energies = energies();
        let removed: f64 = energies.iter().zip(found.factors).map(|(energy, w)| energy * (1.0 - w * w)).sum();
        report.energy_removed = removed / energies.iter().sum::<f64>();
    }
    report
}

/// The largest absolute value of all coefficients.
fn largest<T: Coefficient>(coefficients: &[T]) -> f64 {
    let of_channels = |f: &T| (0..T::CHANNELS).map(|c| f.channel(c).to_f64().abs()).fold(0.0, f64::max);
    coefficients.iter().map(of_channels).fold(0.0, f64::max)
}

/// A function times a factor.
fn in_unit<T: Coefficient<Scalar = f64>>(coefficients: &[T], unit: f64) -> Vec<T> {
    coefficients.iter().map(|c| c.scale(unit)).collect()
}

/// The coefficients of one channel.
fn channel<T: Coefficient>(coefficients: &[T], c: usize) -> Vec<f64> {
    coefficients.iter().map(|f| f.channel(c).to_f64()).collect()
}

/// The mean over the sphere.
fn mean(f: &[f64]) -> f64 {
    f.first().map_or(0.0, |c| c / (4.0 * core::f64::consts::PI).sqrt())
}

/// The certified minimum of every channel.
fn minima<T: Coefficient>(coefficients: &[T]) -> Vec<Extremum> {
    (0..T::CHANNELS).map(|c| minimum_to(&channel(coefficients, c), REPORTED, None)).collect()
}

/// A minimum to a width relative to the mean, or to the root mean square where the mean is not positive.
fn minimum_to(f: &[f64], width: f64, level: Option<f64>) -> Extremum {
    // In a unit in which no square leaves the range of numbers.
    let unit = to_unit_size(largest(f));
    let rms = f.iter().map(|c| (c * unit).powi(2)).sum::<f64>().sqrt() / (4.0 * core::f64::consts::PI).sqrt();
    let part = if mean(f) > 0.0 && rms.is_finite() { unit * mean(f) / rms } else { 1.0 };
    minimum_of(f, width * part, level)
}

/// The reason not to change a function, if there is one.
fn refusal<T: Coefficient>(examined: &[T], before: &[Extremum]) -> Option<DeringOutcome> {
    let mut unchanged = true;
    let mut refusal = None;
    for (c, min) in before.iter().enumerate() {
        if !min.hi.is_finite() {
            return Some(DeringOutcome::NotFinite);
        }
        let f = channel(examined, c);
        if mean(&f) <= 0.0 && f.iter().any(|c| *c != 0.0) {
            refusal = refusal.or(Some(DeringOutcome::MeanNotPositive { channel: c }));
        }
        unchanged &= min.hi >= -DERING_ALLOWED * mean(&f);
    }
    refusal.or(unchanged.then_some(DeringOutcome::Unchanged))
}

/// The result of a method.
struct Solution {
    outcome: DeringOutcome,
    factors: Option<Vec<f64>>,
    window: Option<Window>,
    excess: Option<f64>,
}

impl Solution {
    fn none(outcome: DeringOutcome) -> Self {
        Self { outcome, factors: None, window: None, excess: None }
    }

    fn factors(factors: Vec<f64>) -> Self {
        Self { outcome: DeringOutcome::Windowed, factors: Some(factors), window: None, excess: None }
    }
}

/// The factors for a function of which every channel is zero or has a positive mean.
fn solve<T: Coefficient>(examined: &[T], method: &DeringMethod, roundoff: f64) -> Solution {
    let order = order_of_slice(examined);
    let channels: Vec<Vec<f64>> = (0..T::CHANNELS).map(|c| channel(examined, c)).filter(|f| mean(f) > 0.0).collect();
    let margin = |factors: &[f64]| channels.iter().map(|f| rounding_margin(f, factors, roundoff)).fold(0.0, f64::max);
    match method {
        DeringMethod::LeastChange if order <= 3 => {
            let found = least_change_order_3(examined);
            if found.outcome != DeringOutcome::Windowed {
                return Solution::none(found.outcome);
            }
            // The margin of the report's own number type.
            let extra = 1.0 - margin(&found.factors[..order]);
            let [_, w1, w2] = found.factors;
            let factors = [1.0, extra * w1, extra * w2][..order].to_vec();
            let excess = excess_at(&channels, &factors, &lowest_directions(&channels, &factors));
            Solution { excess: Some(excess), ..Solution::factors(factors) }
        }
        DeringMethod::LeastChange => {
            let LeastChange { factors, excess } = least_change(&channels, order, margin(&vec![1.0; order]));
            Solution { excess: Some(excess), ..Solution::factors(factors) }
        }
        DeringMethod::Table => match by_table(&channels, order, margin(&vec![1.0; order])) {
            Some(factors) => Solution::factors(factors),
            None => Solution::none(DeringOutcome::BeyondTable),
        },
        DeringMethod::Family(family) => {
            let window = weakest(*family, &channels, margin(&vec![1.0; order]));
            Solution { window: Some(window), ..Solution::factors(window.factors(order)) }
        }
    }
}

/// The direction of each channel's minimum after windowing.
fn lowest_directions(channels: &[Vec<f64>], factors: &[f64]) -> Vec<[f64; 3]> {
    let lowest = |f: &Vec<f64>| {
        let mut windowed = f.clone();
        scale_bands_in_place(&mut windowed, factors);
        minimum_to(&windowed, REPORTED, None).dir.to_array()
    };
    channels.iter().map(lowest).collect()
}

/// The most by which rounding each coefficient to the caller's number type can lower a value, relative to the mean.
fn rounding_margin(f: &[f64], factors: &[f64], roundoff: f64) -> f64 {
    let bound: f64 = factors
        .iter()
        .enumerate()
        .map(|(l, w)| {
            let energy: f64 = f[band_range(l)].iter().map(|c| c * c).sum();
            w * ((2 * l + 1) as f64 * energy / (4.0 * core::f64::consts::PI)).sqrt()
        })
        .sum();
    2.0 * roundoff * bound / mean(f)
}

/// Sloan's search in the table for a bound of at least `margin` times each mean, or its last row where the bound fails and the minimum itself
/// is that high; `None` if the function has more than three bands or needs a stronger window than the last.
fn by_table(channels: &[Vec<f64>], order: usize, margin: f64) -> Option<Vec<f64>> {
    if channels.iter().any(|f| f.iter().skip(9).any(|c| *c != 0.0)) {
        return None;
    }
    let forms: Vec<QuadraticForm> =
        channels.iter().map(|f| QuadraticForm::new(&f[..f.len().min(coefficient_count(3))], 0)).collect();
    let factors_at = |place: f64| (0..order).map(|l| dering_table_factors(place)[l.min(3)]).collect::<Vec<f64>>();
    if let Some(place) = table_place(&forms, margin) {
        return Some(factors_at(place));
    }
    // The bound is loose. Under the last row the irradiance of each sun is non-negative, and so is that of all light.
    let last = factors_at(1.0);
    let is_above = |f: &Vec<f64>| {
        let (mut windowed, level) = (f.clone(), margin * mean(f));
        scale_bands_in_place(&mut windowed, &last);
        minimum_to(&windowed, REPORTED, Some(level)).lo >= level
    };
    channels.iter().all(is_above).then_some(last)
}

/// The weakest window of a family under which no channel is below `margin` times its mean.
fn weakest(family: WindowFamily, channels: &[Vec<f64>], margin: f64) -> Window {
    // Remember the directions in which a window was too weak: most others fail there too, which takes no search to see.
    let mut violated: Vec<Vec<Vec<f64>>> = vec![Vec::new(); channels.len()];
    let mut holds = |window: Window| {
        let order = order_of_slice(&channels[0]);
        let factors = window.factors(order);
        let low = |bands: &Vec<f64>| bands.iter().zip(&factors).map(|(b, w)| b * w).sum::<f64>() < 0.0;
        if violated.iter().any(|seen| seen.iter().any(low)) {
            return false;
        }
        for (f, seen) in channels.iter().zip(&mut violated) {
            let mut scaled = f.clone();
            scale_bands_in_place(&mut scaled, &factors);
            let level = margin * mean(f);
            let min = minimum_to(&scaled, REPORTED, Some(level));
            if min.lo < level {
                let mut y = vec![0.0; f.len()];
                eval_basis_into(min.dir.to_array(), &mut y);
                seen.push((0..order).map(|l| band_range(l).map(|i| y[i] * f[i]).sum()).collect());
                return false;
            }
        }
        true
    };
    let (mut high, growth) = family.first();
    let mut low = 0.0;
    // Raise the strength until the window suffices, at the latest when it is zero from band 1 on.
    while !holds(family.window(high)) && family.window(high).factor(1) > 0.0 {
        (low, high) = (high, high * growth);
    }
    // Bisect between the last strength that fails and the first that suffices.
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(family.window(middle)) { high = middle } else { low = middle }
    }
    family.window(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_read_as_they_are_written() {
        for text in ["least-change", "table", "hanning", "lanczos:4", "gauss", "squared-laplacian"] {
            let method: DeringMethod = text.parse().unwrap();
            assert_eq!(method.to_string(), text, "there and back");
        }
        for text in ["", "lanczos:", "lanczos:0", "lanczos:x", "hanning:3", "auto"] {
            let message = text.parse::<DeringMethod>().unwrap_err().to_string();
            assert!(message.contains("expected least-change") && !message.contains('\n'), "'{text}': {message}");
        }
    }
}
