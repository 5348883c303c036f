//! Searches in functions on the sphere.

use std::time::Instant;

use lobe::sh::basis::coefficient_count;
use lobe::sh::extrema::certified_minimum;
use lobe::sh::light_extraction::{
    LightChoice, LightFit, LightFitOptions, LightMetric, PeakSearch, extract_light, extract_lights, fit_lights,
    local_maxima,
};
use lobe::sh::ringing::conservative_minimum;
use lobe::sh::{Coefficient, Dir, Expansion as _, Rgb, ShVec};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::forked::with_threads;
use crate::rows::{Pace, array_of, contiguous, shape_error, value_error};

/// Functions that are searched before the interpreter may stop the search, at most and at first: the least value of one of order 64 may take
/// a second.
const SEARCHED_TOGETHER: usize = 1 << 12;
const FIRST_SEARCHED: usize = 2;

/// An array of double precision.
type Doubles<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Least values of functions `(rows, n²)`, what none of their values is below, and where they are: `(rows)`, `(rows)`, `(rows, 3)`.
#[pyfunction]
pub(crate) fn minimum<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    order: usize,
    tolerance: f64,
) -> PyResult<(Doubles<'py>, Doubles<'py>, Doubles<'py>)> {
    let found = search(py, contiguous(&c)?, order, |f| {
        let least = certified_minimum(f, tolerance);
        if !least.hi.is_finite() {
            return Err("expected finite coefficients, found one that is not".to_owned());
        }
        let f = ShVec::from_vec(f.to_vec()).ok_or_else(|| "expected n² coefficients".to_owned())?;
        // The interval allows for more rounding than this one sum has.
        Ok((f.eval(least.dir).clamp(least.lo, least.hi), least))
    })?;
    let values = found.iter().map(|(value, _)| *value).collect();
    let bounds = found.iter().map(|(_, least)| least.lo).collect();
    let directions = found.iter().flat_map(|(_, least)| least.dir.to_array()).collect();
    let count = found.len();
    Ok((array_of(py, values, &[count])?, array_of(py, bounds, &[count])?, array_of(py, directions, &[count, 3])?))
}

/// The closed bound below which no value of functions `(rows, n²)` of up to three bands lies: `(rows)`.
#[pyfunction]
pub(crate) fn minimum_bound<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    order: usize,
) -> PyResult<Doubles<'py>> {
    let bounds = search(py, contiguous(&c)?, order, |f| match f.iter().all(|c| c.is_finite()) {
        true => Ok(conservative_minimum(f)),
        false => Err("expected finite coefficients, found one that is not".to_owned()),
    })?;
    let count = bounds.len();
    array_of(py, bounds, &[count])
}

/// The local maxima of one function, sought from a `grid` or as in the `paper`: directions `(k, 3)` and values `(k)`, the highest first.
#[pyfunction]
pub(crate) fn peaks<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    order: usize,
    way: &str,
) -> PyResult<(Doubles<'py>, Doubles<'py>)> {
    let way = match way {
        "grid" => PeakSearch::Grid,
        "paper" => PeakSearch::Paper,
        other => return Err(value_error(format!("search: expected grid or paper, found {other:?}"))),
    };
    let found = search(py, contiguous(&c)?, order, |f| {
        let f = ShVec::from_vec(f.to_vec()).ok_or_else(|| "expected n² coefficients".to_owned())?;
        Ok(local_maxima(&f, way))
    })?
    .concat();
    let directions = found.iter().flat_map(|peak| peak.dir.to_array()).collect();
    let values = found.iter().map(|peak| peak.value).collect();
    Ok((array_of(py, directions, &[found.len(), 3])?, array_of(py, values, &[found.len()])?))
}

/// Directions `(rows, count, 3)`, intensities `(rows, count[, 3])`, ambient light and what is left of the energy `(rows[, 3])`.
type Lights<'py> = (Doubles<'py>, Doubles<'py>, Doubles<'py>, Doubles<'py>);

/// How lights are found.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct LightSettings {
    count: usize,
    refine: bool,
    metric: String,
    choose: String,
    /// One light in closed form, whatever else is set.
    closed: bool,
    /// Those of lights that are known, `count` of them.
    directions: Option<Vec<[f64; 3]>>,
}

/// The way in which lights are found.
enum Way {
    Closed,
    Known(Vec<Dir>, LightFitOptions),
    Sought(LightFitOptions),
}

impl LightSettings {
    fn way(&self) -> PyResult<Way> {
        let metric = match &*self.metric {
            "irradiance" => LightMetric::Irradiance,
            "radiance" => LightMetric::Radiance,
            other => return Err(value_error(format!("metric: expected irradiance or radiance, found {other:?}"))),
        };
        let choice = match &*self.choose {
            "residual" => LightChoice::Residual,
            "height" => LightChoice::Height,
            other => return Err(value_error(format!("choose: expected residual or height, found {other:?}"))),
        };
        let options = LightFitOptions::default().count(self.count).refine(self.refine).metric(metric).choice(choice);
        Ok(match &self.directions {
            Some(known) => Way::Known(known.iter().map(|d| Dir::from_unit(*d)).collect(), options),
            None if self.closed => Way::Closed,
            None => Way::Sought(options),
        })
    }
}

/// Directional lights in functions `(rows, n²)` or `(rows, n², 3)`. Where there are fewer than `count`, the rest have no intensity and
/// point up.
#[pyfunction]
pub(crate) fn lights<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    order: usize,
    settings: LightSettings,
) -> PyResult<Lights<'py>> {
    let (way, count) = (settings.way()?, settings.count);
    let values = contiguous(&c)?;
    let (rows, channels, found) = match *c.shape() {
        [rows, _] => {
            let fits = search(py, values, order, |f| fit::<f64>(f, &way))?;
            (rows, None, numbers(&fits, count))
        }
        [rows, _, 3] => {
            let colors: &[Rgb<f64>] = bytemuck::cast_slice(values);
            let fits = search(py, colors, order, |f| fit::<Rgb<f64>>(f, &way))?;
            (rows, Some(3), numbers(&fits, count))
        }
        ref other => return Err(shape_error(other)),
    };
    let [directions, intensities, ambient, residual] = found;
    let shape = |leading: &[usize]| leading.iter().copied().chain(channels).collect::<Vec<_>>();
    Ok((
        array_of(py, directions, &[rows, count, 3])?,
        array_of(py, intensities, &shape(&[rows, count]))?,
        array_of(py, ambient, &shape(&[rows]))?,
        array_of(py, residual, &shape(&[rows]))?,
    ))
}

fn fit<C: Coefficient>(f: &[C], way: &Way) -> Result<LightFit<C::Wide>, String> {
    let f = ShVec::from_vec(f.to_vec()).ok_or("expected n² coefficients")?;
    let fit = match way {
        Way::Closed => extract_light(&f),
        Way::Known(directions, options) => fit_lights(&f, directions, options),
        Way::Sought(options) => extract_lights(&f, options),
    };
    fit.map_err(|error| error.to_string())
}

/// Searches functions in parallel, without the interpreter's lock.
pub(crate) fn search<C: Coefficient, F: Send>(
    py: Python<'_>,
    functions: &[C],
    order: usize,
    work: impl Fn(&[C]) -> Result<F, String> + Sync,
) -> PyResult<Vec<F>> {
    let count = coefficient_count(order).max(1);
    let mut all = Vec::with_capacity(functions.len() / count);
    let (mut pace, mut rest) = (Pace::new(FIRST_SEARCHED, SEARCHED_TOGETHER), functions);
    while !rest.is_empty() {
        py.check_signals()?;
        let (part, behind) = rest.split_at((count * pace.rows).min(rest.len()));
        let begun = Instant::now();
        let found: Vec<Result<F, String>> =
            py.detach(|| with_threads(|| part.par_chunks_exact(count).map(&work).collect()));
        pace.took(begun.elapsed());
        rest = behind;
        for found in found {
            let row = all.len();
            all.push(found.map_err(|fault| value_error(format!("function {row}: {fault}")))?);
        }
    }
    Ok(all)
}

/// Directions, intensities, ambient light and residuals of fits, `count` lights each.
fn numbers<C: Coefficient<Scalar = f64>>(fits: &[LightFit<C>], count: usize) -> [Vec<f64>; 4] {
    let channels = |c: C| (0..C::CHANNELS).map(move |k| c.channel(k));
    let [mut directions, mut intensities, mut ambient, mut residual] = [const { Vec::new() }; 4];
    for fit in fits {
        for k in 0..count {
            let light = fit.lights.get(k);
            directions.extend(light.map_or([0.0, 0.0, 1.0], |light| light.dir.to_array()));
            intensities.extend(channels(light.map_or(C::ZERO, |light| light.intensity)));
        }
        ambient.extend(channels(fit.ambient));
        residual.extend(channels(fit.residual));
    }
    [directions, intensities, ambient, residual]
}
