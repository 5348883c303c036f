//! Operations on functions on the sphere, one row of coefficients after the other.

use lobe::env::damp_zonal_in_place;
use lobe::sh::basis::coefficient_count;
use lobe::sh::exponential::Exponential;
use lobe::sh::filter::window_in_place;
use lobe::sh::product::{MAX_GAUNT_ORDER, product_into};
use lobe::sh::ringing::{ContentWindow, DeringOptions, DeringOutcome, dering_in_place};
use lobe::sh::rotation::{Axis, RotationMatrices, mirror_in_place};
use lobe::sh::{Coefficient, Expansion as _, Real, Rgb, Rotation, ShVec, Window, Zonal};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::batches;
use crate::rows::{
    Number, Numbers, QUICK_ROWS_TOGETHER, ROWS_TOGETHER, RowWork, array_of, contiguous, do_rows, map_rows, map_typed,
    shape_error, value_error,
};

struct Rotate<T>(RotationMatrices<T>);

impl<T: Real> RowWork<T> for Rotate<T> {
    const TOGETHER: usize = QUICK_ROWS_TOGETHER;

    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        self.0.apply_into(row, out);
        Ok(())
    }
}

/// The same without matrices, whose making takes the time of many rotations.
struct RotateFew(Rotation);

impl<T: Real> RowWork<T> for RotateFew {
    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        self.0.apply_into(row, out);
        Ok(())
    }
}

/// Functions for which neither matrices nor batches are worth making: at order 10 and 32 matrices take as long as some 10 rotations without.
const FEW: usize = 8;

/// Functions turned by a rotation, a matrix whose columns are where the axes go.
#[pyfunction]
pub(crate) fn rotate<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    order: usize,
    matrix: [[f64; 3]; 3],
) -> PyResult<Bound<'py, PyAny>> {
    let rotation = Rotation::from_matrix(matrix).map_err(value_error)?;
    let width = coefficient_count(order);
    match &c {
        _ if c.rows() <= FEW => map_rows(py, &c, width, (&RotateFew(rotation), &RotateFew(rotation))),
        Numbers::Single(array) => batches::rotate(py, array, order, &rotation),
        Numbers::Double(array) => {
            Ok(map_typed(py, array, width, &Rotate(RotationMatrices::new(&rotation, order)))?.into_any())
        }
    }
}

/// Products of functions, `(rows, a²[, 3])` and `(rows, b²[, 3])`, projected onto `order` bands.
#[pyfunction]
pub(crate) fn product<'py>(
    py: Python<'py>,
    a: Numbers<'py>,
    b: Numbers<'py>,
    order: usize,
) -> PyResult<Bound<'py, PyAny>> {
    match (&a, &b) {
        (Numbers::Single(a), Numbers::Single(b)) if are_batches(a.shape(), b.shape(), order) => {
            batches::product(py, a, b, order)
        }
        (Numbers::Single(a), Numbers::Single(b)) => Ok(product_typed(py, a, b, order)?.into_any()),
        (Numbers::Double(a), Numbers::Double(b)) => Ok(product_typed(py, a, b, order)?.into_any()),
        _ => Err(value_error("expected factors of one precision")),
    }
}

/// Whether these are many functions of one order, which are multiplied side by side.
fn are_batches(a: &[usize], b: &[usize], order: usize) -> bool {
    a == b && a.len() > 1 && a[0] > FEW && a[1] == coefficient_count(order) && order <= MAX_GAUNT_ORDER
}

fn product_typed<'py, T: Number>(
    py: Python<'py>,
    a: &PyReadonlyArrayDyn<'py, T>,
    b: &PyReadonlyArrayDyn<'py, T>,
    order: usize,
) -> PyResult<Bound<'py, PyArrayDyn<T>>>
where
    Rgb<T>: Coefficient<Scalar = T> + bytemuck::Pod,
{
    let (width, factors) = (coefficient_count(order), (contiguous(a)?, contiguous(b)?));
    match (a.shape(), b.shape()) {
        (&[rows, _], &[others, _]) if rows == others => {
            array_of(py, products(py, rows, width, factors)?, &[rows, width])
        }
        (&[rows, _, 3], &[others, _, 3]) if rows == others => {
            let factors = (bytemuck::cast_slice(factors.0), bytemuck::cast_slice(factors.1));
            let out: Vec<Rgb<T>> = products(py, rows, width, factors)?;
            array_of(py, bytemuck::cast_vec(out), &[rows, width, 3])
        }
        (other, _) => Err(shape_error(other)),
    }
}

fn products<C: Coefficient>(py: Python<'_>, rows: usize, width: usize, (a, b): (&[C], &[C])) -> PyResult<Vec<C>> {
    let (n, m) = (a.len() / rows.max(1), b.len() / rows.max(1));
    // Higher orders go by values on a grid, which takes longer than their coefficients tell.
    let is_quick = n.max(m).max(width) <= coefficient_count(MAX_GAUNT_ORDER);
    let together = if is_quick { QUICK_ROWS_TOGETHER } else { ROWS_TOGETHER };
    do_rows(py, rows, width, together, |k, out| {
        product_into(&a[k * n..][..n], &b[k * m..][..m], out);
        Ok(())
    })
}

/// A factor for each coefficient.
struct Scale(Vec<f64>);

impl<T: Real> RowWork<T> for Scale {
    const TOGETHER: usize = QUICK_ROWS_TOGETHER;

    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        assert_eq!(row.len(), self.0.len(), "coefficients against factors");
        // In one pass, not by a copy that is scaled in place: this takes as long as memory does.
        for ((out, c), factor) in out.iter_mut().zip(row).zip(&self.0) {
            *out = C::narrow(c.widen().scale(*factor));
        }
        Ok(())
    }
}

/// Functions whose bands are multiplied by factors.
#[pyfunction]
pub(crate) fn scale_bands<'py>(py: Python<'py>, c: Numbers<'py>, factors: Vec<f64>) -> PyResult<Bound<'py, PyAny>> {
    let of_band = |(l, factor): (usize, &f64)| std::iter::repeat_n(*factor, 2 * l + 1);
    let work = Scale(factors.iter().enumerate().flat_map(of_band).collect());
    map_rows(py, &c, work.0.len(), (&work, &work))
}

/// The factors by which a convolution multiplies bands: `cosine`, `phong` (its exponent) or `ggx` (its α).
#[pyfunction]
pub(crate) fn kernel_factors(name: &str, parameter: f64, order: usize) -> PyResult<Vec<f64>> {
    let kernel = match name {
        "cosine" => Zonal::clamped_cosine(order),
        "phong" => Zonal::phong(order, parameter),
        "ggx" => Zonal::ggx(order, parameter),
        _ => return Err(value_error(format!("expected the kernel cosine, phong or ggx, found {name:?}"))),
    };
    Ok(kernel.convolution_factors())
}

/// The factors of a window, named as in the command: `hanning:4`.
#[pyfunction]
pub(crate) fn window_factors(name: &str, order: usize) -> PyResult<Vec<f64>> {
    Ok(name.parse::<Window>().map_err(value_error)?.factors(order))
}

/// The width at which a Hanning window, or a Lanczos window of a power, lowers the peak of a unit impulse to `peak`; none if no
/// width does.
#[pyfunction]
pub(crate) fn width_of_peak(power: Option<f64>, order: usize, peak: f64) -> Option<f64> {
    lobe::sh::filter::width_of_peak(order, peak, |width| match power {
        None => Window::Hanning { width },
        Some(power) => Window::Lanczos { width, power },
    })
}

struct DampZonal;

impl<T: Real> RowWork<T> for DampZonal {
    const TOGETHER: usize = QUICK_ROWS_TOGETHER;

    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        out.copy_from_slice(row);
        damp_zonal_in_place(out);
        Ok(())
    }
}

/// Functions whose coefficients of m = 0 are damped, which hold the step of a sky at its horizon.
#[pyfunction]
pub(crate) fn damp_zonal<'py>(py: Python<'py>, c: Numbers<'py>, order: usize) -> PyResult<Bound<'py, PyAny>> {
    map_rows(py, &c, coefficient_count(order), (&DampZonal, &DampZonal))
}

struct Keep(f64);

impl<T: Real> RowWork<T> for Keep {
    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        let window = Window::squared_laplacian_of(row, self.0);
        out.copy_from_slice(row);
        window_in_place(out, &window);
        Ok(())
    }
}

/// Functions under the window that leaves a part of the squared Laplacian of each, summed over channels.
#[pyfunction]
pub(crate) fn window_keep<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    order: usize,
    keep: f64,
) -> PyResult<Bound<'py, PyAny>> {
    map_rows(py, &c, coefficient_count(order), (&Keep(keep), &Keep(keep)))
}

struct Content {
    window: Window,
    order: usize,
}

impl<T: Real> RowWork<T> for Content {
    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        let f = ShVec::from_vec(row.to_vec()).ok_or("expected n² coefficients")?;
        out.copy_from_slice(ContentWindow::of(&f, self.window).project(&f, self.order).coefficients());
        Ok(())
    }
}

/// Functions as they are towards their light, and under a window away from it, on `order` bands.
#[pyfunction]
pub(crate) fn content_window<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    window: &str,
    order: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let work = Content { window: window.parse().map_err(value_error)?, order };
    map_rows(py, &c, coefficient_count(order), (&work, &work))
}

struct Dering(DeringOptions);

impl<T: Real> RowWork<T> for Dering {
    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        out.copy_from_slice(row);
        match dering_in_place(out, &self.0).outcome {
            DeringOutcome::Unchanged | DeringOutcome::Windowed => Ok(()),
            DeringOutcome::MeanNotPositive { channel } => {
                Err(format!("expected a positive mean, found one of channel {channel} that is not: no window helps"))
            }
            DeringOutcome::NotFinite => Err("expected finite coefficients, found one that is not".to_owned()),
            outcome => Err(format!("the method cannot: {outcome:?}")),
        }
    }
}

/// Functions made non-negative by a method named as in the command; or their irradiance alone.
#[pyfunction]
pub(crate) fn dering<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    order: usize,
    method: &str,
    of_irradiance: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let kernel = of_irradiance.then(|| Zonal::clamped_cosine(order));
    let options = DeringOptions::default().method(method.parse().map_err(value_error)?).kernel(kernel);
    let work = Dering(options);
    map_rows(py, &c, coefficient_count(order), (&work, &work))
}

/// A function of the values of each channel, which is computed in double precision.
fn each_channel<C: Coefficient>(row: &[C], out: &mut [C], f: impl Fn(&ShVec<f64>) -> ShVec<f64>) -> Result<(), String> {
    if !row.iter().all(|c| (0..C::CHANNELS).all(|k| c.channel(k).to_f64().is_finite())) {
        return Err("expected finite coefficients, found one that is not".to_owned());
    }
    let channels: Vec<ShVec<f64>> = (0..C::CHANNELS)
        .filter_map(|k| ShVec::from_vec(row.iter().map(|c| c.channel(k).to_f64()).collect()))
        .map(|channel| f(&channel))
        .collect();
    for (i, out) in out.iter_mut().enumerate() {
        *out = C::from_channels(|k| C::Scalar::from_f64(channels[k].coefficients()[i]));
    }
    Ok(())
}

struct Exp(Exponential);

impl<T: Real> RowWork<T> for Exp {
    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        each_channel(row, out, |f| self.0.of(f))
    }
}

/// `exp f` of functions, by a method named as in the command.
#[pyfunction]
pub(crate) fn exp<'py>(py: Python<'py>, c: Numbers<'py>, order: usize, method: &str) -> PyResult<Bound<'py, PyAny>> {
    let work = Exp(Exponential::new(order, method.parse().map_err(value_error)?));
    map_rows(py, &c, coefficient_count(order), (&work, &work))
}

struct Log {
    clamp: f64,
}

impl<T: Real> RowWork<T> for Log {
    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String> {
        each_channel(row, out, |f| lobe::sh::exponential::logarithm(f, self.clamp))
    }
}

/// `log f` of functions that are clamped from below.
#[pyfunction]
pub(crate) fn log<'py>(py: Python<'py>, c: Numbers<'py>, order: usize, clamp: f64) -> PyResult<Bound<'py, PyAny>> {
    let work = Log { clamp };
    map_rows(py, &c, coefficient_count(order), (&work, &work))
}

/// What a mirror that reverses an axis, x, y or z, multiplies each of n² coefficients by.
#[pyfunction]
pub(crate) fn mirror_signs(order: usize, axis: &str) -> PyResult<Vec<f64>> {
    let axis = match axis {
        "x" => Axis::X,
        "y" => Axis::Y,
        "z" => Axis::Z,
        other => return Err(value_error(format!("axis: expected x, y or z, found {other:?}"))),
    };
    let mut signs = vec![1.0; order * order];
    mirror_in_place(&mut signs, axis);
    Ok(signs)
}
