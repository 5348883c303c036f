//! Directional lights extracted from an expansion: one in closed form, several by least squares.

use alloc::vec::Vec;

use crate::error::ShError;
use crate::expansion::expansion::optimal_linear_direction;
use crate::expansion::{Expansion, ShVec};
use crate::light_extraction::light_fit::{DirectionalLight, LightFit, LightMetric};
use crate::light_extraction::light_fit::{LightProblem, total};
use crate::light_extraction::peaks::{PeakSearch, local_maxima};
use crate::light_extraction::refine::refine;
use crate::scalar::Coefficient;
use crate::scalar::luminance;
use crate::setters::setters;
use crate::sphere::Dir;

/// The residual, as a fraction of the energy, that is nothing but rounding.
const ROUNDING: f64 = 1e-28;

/// The least fraction of the residual that a further light must remove.
const LEAST_GAIN: f64 = 1e-9;

/// One directional light and ambient light that approximate `f`, in closed form; the channels share the direction of
/// the luminance.
///
/// The intensities `c` and `a` are those whose irradiance is nearest to that of `f`, in the mean square over all
/// normals ([Sloan 2008] A5), for a light in the [`optimal_linear_direction`] `d`:
///
/// ```text
///   c = Σ_{l>=1} w_l² Σ_m f_lm N y_lm(d) / Σ_{l>=1} w_l² N² (2l+1)/4π        w_l = A_l/π
///   a = (f_00 - c N/(2√π)) / (2√π)
/// ```
///
/// `N` is [`directional_normalization`](crate::light::directional_normalization). The first denominator is `16π/27, 316π/867,
/// 316π/867` for orders 2, 3, 4, `N/(2√π)` is `2√π/3, 8√π/17, 8√π/17`. (One print of the paper has `√π/2` in place of
/// `1/(2√π)`.)
///
/// Either may be negative; [`extract_lights`] prevents that. An expansion without a linear band has no light, only
/// ambient light.
///
/// # Errors
/// [`ShError::Options`] below order 2 and for coefficients that are not finite.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
///
/// ```
/// use lobe_sh::light::Normalization;
/// use lobe_sh::light_extraction::extract_light;
/// use lobe_sh::{Dir, Light, Rgb};
///
/// let color = Rgb::new(3.0, 2.0, 1.0);
/// let sun = Light::Directional { dir: Dir::Y, color }.project(3, Normalization::Projected)?;
/// let found = extract_light(&sun)?;
/// assert!(found.lights[0].dir.angle_to(Dir::Y) < 1e-12 && (found.lights[0].intensity.r - 3.0).abs() < 1e-12);
/// # Ok::<(), lobe_sh::ShError>(())
/// ```
pub fn extract_light<T: Coefficient>(f: &impl Expansion<T>) -> Result<LightFit<T::Wide>, ShError> {
    let problem = LightProblem::<T>::new(f, LightMetric::Irradiance, false)?;
    let dir = optimal_linear_direction(&problem.f);
    let mut fit = problem.solve(dir.as_slice());
    LightProblem::<T>::tidy(&mut fit);
    Ok(fit)
}

/// [`extract_light`] for each channel, with a direction of its own.
///
/// # Errors
/// As for [`extract_light`].
pub fn extract_light_per_channel<T: Coefficient>(f: &impl Expansion<T>) -> Result<Vec<LightFit<f64>>, ShError> {
    let channel = |c: usize| {
        let values = f.coefficients().iter().map(|f| f.widen().channel(c));
        extract_light(&ShVec::of(values.collect()))
    };
    (0..T::CHANNELS).map(channel).collect()
}

/// The choice of [`extract_lights`] among the maxima.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum LightChoice {
    /// Greedily, as in orthogonal matching pursuit: each time the maximum whose light, together with those chosen
    /// before, leaves the smallest residual. Side lobes of a bright light are not taken for lights.
    #[default]
    Residual,
    /// The highest maxima, as in [Sloan 2008].
    ///
    /// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
    Height,
}

/// Options of [`extract_lights`] and [`fit_lights`]: by default one light whose irradiance fits best, nothing negative
/// and nothing refined.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct LightFitOptions {
    /// The greatest number of lights.
    pub count: usize,
    /// Refine the directions together with the intensities to a minimum of the residual.
    pub refine: bool,
    /// The metric of the least squares.
    pub metric: LightMetric,
    /// The choice among the maxima.
    pub choice: LightChoice,
    /// The search for the maxima.
    pub search: PeakSearch,
    /// Constrain intensities and ambient light not to be negative (NNLS).
    pub non_negative: bool,
}

setters! {
    LightFitOptions {
        count: usize,
        refine: bool,
        metric: LightMetric,
        choice: LightChoice,
        search: PeakSearch,
        non_negative: bool,
    }
}

impl Default for LightFitOptions {
    fn default() -> Self {
        Self {
            count: 1,
            refine: false,
            metric: LightMetric::default(),
            choice: LightChoice::default(),
            search: PeakSearch::default(),
            non_negative: true,
        }
    }
}

/// Several directional lights and ambient light that approximate `f` ([Sloan 2008], "Extracting multiple lights").
///
/// The directions are local maxima of the luminance, shared by the channels; the intensities and the ambient light
/// solve a least-squares problem for each channel, non-negative (NNLS) unless the options allow otherwise. With
/// `refine` the directions then move by the method of Levenberg and Marquardt, and further lights are sought among the
/// maxima of the residual, so that one broad peak may give two lights.
///
/// The result has fewer lights than asked for if there are fewer maxima, or if no further light lowers the residual. A
/// constant expansion has only ambient light.
///
/// # Errors
/// [`ShError::Options`] below order 2 and for coefficients that are not finite.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
pub fn extract_lights<T: Coefficient>(
    f: &impl Expansion<T>,
    options: &LightFitOptions,
) -> Result<LightFit<T::Wide>, ShError> {
    let problem = LightProblem::<T>::new(f, options.metric, options.non_negative)?;
    let peaks: Vec<Dir> =
        local_maxima(&problem.f.map(luminance), options.search).into_iter().map(|peak| peak.dir).collect();
    let mut fit = match options.choice {
        LightChoice::Height => problem.solve(&peaks[..options.count.min(peaks.len())]),
        LightChoice::Residual => chosen_by_residual(&problem, &peaks, options.count),
    };
    if options.refine {
        let together = refine(&problem, fit);
        let one_by_one = refined_one_by_one(&problem, options);
        fit = if total(one_by_one.residual) < total(together.residual) { one_by_one } else { together };
    }
    LightProblem::<T>::tidy(&mut fit);
    Ok(fit)
}

/// The least-squares intensities of lights in given directions, and the ambient light.
///
/// Lights of zero intensity are kept, and so is the order. Lights in equal directions share their intensity.
///
/// # Errors
/// As for [`extract_lights`].
pub fn fit_lights<T: Coefficient>(
    f: &impl Expansion<T>,
    dirs: &[Dir],
    options: &LightFitOptions,
) -> Result<LightFit<T::Wide>, ShError> {
    Ok(LightProblem::<T>::new(f, options.metric, options.non_negative)?.solve(dirs))
}

/// The fit with the further light, one of `candidates`, that leaves the smallest residual; `None` if none lowers it
/// enough.
fn with_best<T: Coefficient>(
    problem: &LightProblem<T>,
    before: &LightFit<T::Wide>,
    candidates: &[Dir],
) -> Option<LightFit<T::Wide>> {
    let fits = candidates.iter().map(|candidate| problem.solve(&dirs_and(before, *candidate)));
    let best = fits.min_by(|a, b| total(a.residual).total_cmp(&total(b.residual)))?;
    let (after, left) = (total(best.residual), total(before.residual));
    (after < (1.0 - LEAST_GAIN) * left && left > ROUNDING * total(before.energy)).then_some(best)
}

fn dirs_and<T>(fit: &LightFit<T>, further: Dir) -> Vec<Dir> {
    let known = fit.lights.iter().map(|light: &DirectionalLight<T>| light.dir);
    known.chain([further]).collect()
}

fn chosen_by_residual<T: Coefficient>(problem: &LightProblem<T>, peaks: &[Dir], count: usize) -> LightFit<T::Wide> {
    let mut left = peaks.to_vec();
    let mut fit = problem.solve(&[]);
    while fit.lights.len() < count {
        let Some(better) = with_best(problem, &fit, &left) else { break };
        fit = better;
        let taken = fit.lights.last().map(|light| light.dir);
        left.retain(|dir| Some(*dir) != taken);
    }
    fit
}

/// Adds lights one by one from the maxima of the residual, and refines all of them after each.
fn refined_one_by_one<T: Coefficient>(problem: &LightProblem<T>, options: &LightFitOptions) -> LightFit<T::Wide> {
    let mut fit = problem.solve(&[]);
    while fit.lights.len() < options.count {
        let left = problem.residual_of(&fit).map(luminance);
        let peaks: Vec<Dir> = local_maxima(&left, options.search).into_iter().map(|peak| peak.dir).collect();
        let Some(better) = with_best(problem, &fit, &peaks) else { break };
        fit = refine(problem, better);
    }
    fit
}
