//! Irradiance in a few numbers, and their errors.

use std::f64::consts::FRAC_1_PI;

use lobe::sh::encoding::{
    EncodedIrradiance, EncodingError, EngineForm, IrradianceEncoding, IrradianceMatrix, IrradiancePolynomial,
    PackedIrradiance, PackedIrradiance5, encoding_error,
};
use lobe::sh::rotation::{AxisPermutation, tangent_frame};
use lobe::sh::sphere::even_directions;
use lobe::sh::{Coefficient, Dir, Expansion as _, Rgb, ShError, ShL2, ShVec};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::job::answered;
use crate::rows::{array_of, contiguous, do_rows, shape_error, value_error};
use crate::search::search;

/// Irradiances of one encoding, numbers or colors.
#[pyclass(frozen)]
pub(crate) struct Encoded(Kind);

enum Kind {
    Numbers(Vec<EncodedIrradiance<f64>>),
    Colors(Vec<EncodedIrradiance<Rgb<f64>>>),
    /// Constants of a shader for three channels, and whether the functions have as many.
    Constants(Vec<Constants>, bool),
}

/// What a shader evaluates irradiance by.
enum Constants {
    Packed(PackedIrradiance),
    Packed5(PackedIrradiance5),
    Matrix(IrradianceMatrix),
    Polynomial(IrradiancePolynomial),
    /// Nine colors of an engine, and the irradiance that they are of.
    Engine(EngineForm, [Rgb<f64>; 9], ShL2<Rgb<f64>>),
}

/// Numbers with their name.
type Row = (&'static str, Vec<f64>);

/// The vectors of three channels, twice.
fn vectors(names: [&'static str; 6], values: [[[f64; 4]; 3]; 2]) -> impl Iterator<Item = Row> {
    names.into_iter().zip(values.concat()).map(|(name, v)| (name, v.to_vec()))
}

impl Constants {
    /// None of an encoding of another name.
    fn of<C: Coefficient<Scalar = f64>>(name: &str, irradiance: &ShVec<C>) -> Option<Self> {
        let colors = || irradiance.map(|e| Rgb::from_channels(|c| e.channel(c % C::CHANNELS)));
        match name {
            "packed" => Some(Self::Packed(PackedIrradiance::from_irradiance_sh(&colors()))),
            "packed-5" => Some(Self::Packed5(PackedIrradiance5::from_irradiance_sh(&colors()))),
            "matrix" => Some(Self::Matrix(IrradianceMatrix::from_irradiance_sh(&colors()))),
            "r-h" => Some(Self::Polynomial(IrradiancePolynomial::from_irradiance_sh(&colors()))),
            _ => name.parse().ok().map(|form: EngineForm| {
                let colors = colors();
                Self::Engine(form, form.encode_irradiance(&colors), colors.to_fixed())
            }),
        }
    }

    fn numbers(&self) -> Vec<Row> {
        const ORDER_3: [&str; 6] = ["cAr", "cAg", "cAb", "cBr", "cBg", "cBb"];
        match self {
            Self::Packed(PackedIrradiance { a, b, c }) => {
                vectors(ORDER_3, [*a, *b]).chain([("cC", c.to_vec())]).collect()
            }
            Self::Packed5(PackedIrradiance5 { a, b, c, d, f, g }) => {
                let order_3 = vectors(ORDER_3, [*a, *b]).chain([("cC", c.to_vec())]);
                let band_4 = vectors(["cDr", "cDg", "cDb", "cFr", "cFg", "cFb"], [*d, *f]);
                order_3.chain(band_4).chain([("cG", g.to_vec())]).collect()
            }
            Self::Polynomial(IrradiancePolynomial { l }) => {
                IrradiancePolynomial::NAMES.into_iter().zip(l).map(|(name, l)| (name, l.to_array().to_vec())).collect()
            }
            Self::Matrix(IrradianceMatrix { m }) => {
                ["Mr", "Mg", "Mb"].into_iter().zip(m).map(|(name, m)| (name, m.concat())).collect()
            }
            Self::Engine(form, colors, _) if form.is_planar() => {
                let flat = form.flat(colors);
                ["r", "g", "b"].into_iter().zip(flat.chunks(9)).map(|(name, c)| (name, c.to_vec())).collect()
            }
            Self::Engine(form, colors, _) => {
                form.places().into_iter().zip(colors).map(|(place, c)| (place, c.to_array().to_vec())).collect()
            }
        }
    }

    fn eval(&self, n: Dir) -> Rgb<f64> {
        match self {
            Self::Packed(packed) => packed.eval(n),
            Self::Packed5(packed) => packed.eval(n),
            Self::Matrix(matrix) => matrix.eval(n),
            Self::Polynomial(polynomial) => polynomial.eval(n),
            Self::Engine(.., irradiance) => irradiance.eval(n),
        }
    }
}

/// An array with its name.
type Named<'py> = (String, Bound<'py, PyArrayDyn<f64>>);

#[pymethods]
impl Encoded {
    /// What is kept, by name: arrays of shape (rows, channels), of a direction (rows, 3).
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<Vec<Named<'py>>> {
        match &self.0 {
            Kind::Numbers(all) => columns(py, all.iter().map(EncodedIrradiance::numbers).collect()),
            Kind::Colors(all) => columns(py, all.iter().map(EncodedIrradiance::numbers).collect()),
            Kind::Constants(all, _) => columns(py, all.iter().map(Constants::numbers).collect()),
        }
    }

    /// Irradiance for unit normals (m, 3): (rows, m), of colors (rows, m, 3).
    fn eval<'py>(
        &self,
        py: Python<'py>,
        normals: PyReadonlyArrayDyn<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let normals: Vec<Dir> = contiguous(&normals)?.as_chunks().0.iter().map(|n| Dir::from_unit(*n)).collect();
        match &self.0 {
            Kind::Numbers(all) => {
                array_of(py, values(py, all, &normals, EncodedIrradiance::eval)?, &[all.len(), normals.len()])
            }
            Kind::Colors(all) => {
                let values = values(py, all, &normals, EncodedIrradiance::eval)?;
                array_of(py, bytemuck::cast_vec(values), &[all.len(), normals.len(), 3])
            }
            Kind::Constants(all, true) => {
                let values = values(py, all, &normals, Constants::eval)?;
                array_of(py, bytemuck::cast_vec(values), &[all.len(), normals.len(), 3])
            }
            Kind::Constants(all, false) => {
                let values = values(py, all, &normals, |e, n| e.eval(n).channel(0))?;
                array_of(py, values, &[all.len(), normals.len()])
            }
        }
    }
}

/// The numbers of each row, by their names, which all have.
fn columns<N: Into<String> + Clone>(py: Python<'_>, rows: Vec<Vec<(N, Vec<f64>)>>) -> PyResult<Vec<Named<'_>>> {
    let Some(first) = rows.first() else { return Ok(Vec::new()) };
    let column = |(k, (name, values)): (usize, &(N, Vec<f64>))| {
        let column = rows.iter().flat_map(|row| row[k].1.iter().copied()).collect();
        Ok((name.clone().into(), array_of(py, column, &[rows.len(), values.len()])?))
    };
    first.iter().enumerate().map(column).collect()
}

fn values<E: Sync, C: Coefficient>(
    py: Python<'_>,
    all: &[E],
    normals: &[Dir],
    eval: impl Fn(&E, Dir) -> C + Sync,
) -> PyResult<Vec<C>> {
    do_rows(py, all.len(), normals.len(), 1 << 12, |k, out| {
        for (out, n) in out.iter_mut().zip(normals) {
            *out = eval(&all[k], *n);
        }
        Ok(())
    })
}

/// What irradiance is encoded in.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct EncodeSettings {
    name: String,
    /// The geometric one of encodings of a hemisphere.
    normal: [f64; 3],
    over_pi: bool,
    /// Whether the numbers are used where y points up.
    up_is_y: bool,
}

/// Irradiances `(rows, n²)` or `(rows, n², 3)` in an encoding.
#[pyfunction]
pub(crate) fn encode<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    order: usize,
    settings: EncodeSettings,
) -> PyResult<Encoded> {
    let values = contiguous(&c)?;
    match c.shape() {
        [_, _] => encoded::<f64>(py, values, order, &settings, Kind::Numbers, false),
        [_, _, 3] => encoded::<Rgb<f64>>(py, bytemuck::cast_slice(values), order, &settings, Kind::Colors, true),
        other => Err(shape_error(other)),
    }
}

fn encoded<C: Coefficient<Scalar = f64>>(
    py: Python<'_>,
    functions: &[C],
    order: usize,
    settings: &EncodeSettings,
    kind: fn(Vec<EncodedIrradiance<C>>) -> Kind,
    are_colors: bool,
) -> PyResult<Encoded> {
    let used = |f: &[C]| {
        let irradiance = expansion(f)?;
        let scaled = if settings.over_pi { irradiance.map(|e| e.scale(FRAC_1_PI)) } else { irradiance };
        Ok::<_, String>(if settings.up_is_y { scaled.permuted(&AxisPermutation::Y_UP_FROM_Z_UP) } else { scaled })
    };
    let form = settings.name.parse::<EngineForm>();
    if form.is_ok() && (settings.over_pi || settings.up_is_y) {
        let option = if settings.over_pi { "over_pi" } else { "up" };
        return Err(value_error(format!("{option}: the form of {} says it by itself; leave it out", settings.name)));
    }
    if form.is_ok() || matches!(&*settings.name, "packed" | "packed-5" | "matrix" | "r-h") {
        let constants = |f: &[C]| Constants::of(&settings.name, &used(f)?).ok_or_else(String::new);
        return Ok(Encoded(Kind::Constants(search(py, functions, order, constants)?, are_colors)));
    }
    let engines = EngineForm::ALL.map(EngineForm::name).join(", ");
    let all = format!("packed, packed-5, matrix, r-h, {engines} or one of");
    let unknown = |error: ShError| value_error(error.to_string().replacen("one of", &all, 1));
    let encoding: IrradianceEncoding = settings.name.parse().map_err(unknown)?;
    let frame = tangent_frame(Dir::from_unit(settings.normal));
    Ok(Encoded(kind(search(py, functions, order, |f| Ok(encoding.encode(&used(f)?, frame)))?)))
}

/// Name, floats, whether it is of a hemisphere, then mean, RMS and largest error, and the lowest value.
type Measured = (&'static str, usize, bool, f64, f64, f64, f64);

/// The errors of all encodings of one irradiance, `(1, n²)` or `(1, n², 3)`, against its own values for as many normals.
#[pyfunction]
pub(crate) fn encoding_errors<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    normals: usize,
) -> PyResult<Vec<Measured>> {
    let values = contiguous(&c)?.to_vec();
    match c.shape() {
        [1, _] => answered(py, normals, move || errors::<f64>(&values, normals))?,
        [1, _, 3] => answered(py, normals, move || errors::<Rgb<f64>>(bytemuck::cast_slice(&values), normals))?,
        other => return Err(shape_error(other)),
    }
    .map_err(value_error)
}

fn errors<C: Coefficient<Scalar = f64>>(f: &[C], normals: usize) -> Result<Vec<Measured>, String> {
    let irradiance = expansion(f)?;
    let truth: Vec<(Dir, C)> = even_directions(normals).map(|n| (n, irradiance.eval(n))).collect();
    let row = |encoding: IrradianceEncoding| {
        let EncodingError { mean, rms, max, lowest } = encoding_error(encoding, &irradiance, &truth);
        (encoding.name(), encoding.floats(C::CHANNELS), encoding.is_hemispherical(), mean, rms, max, lowest)
    };
    Ok(IrradianceEncoding::ALL.into_iter().map(row).collect())
}

fn expansion<C: Coefficient>(f: &[C]) -> Result<ShVec<C>, String> {
    ShVec::from_vec(f.to_vec()).ok_or_else(|| "expected n² coefficients".to_owned())
}
