//! Options of jobs: what Python gives as the library's values, and its refusals as Python's errors.

use std::ffi::CString;

use lobe::io::{JobOptions, OptionError, OptionField, OptionKind, one_line, worded};
use lobe::motion::MovingJob;
use lobe::prt::BakeJob;
use lobe::render::{CameraOptions, ToneOptions, TransferSource};
use lobe::scene::SceneSource;
use lobe::shadow::{FieldJob, SphereJob};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use serde::Serialize;
use serde_json::{Map, Value};

/// The values of a dictionary, None for what is left open.
pub(crate) fn values_of(asked: &Bound<'_, PyDict>) -> PyResult<Map<String, Value>> {
    asked.iter().map(|(name, value)| Ok((name.extract()?, value_of(&value)?))).collect()
}

/// A value of Python, or of numpy.
fn value_of(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if value.is_none() {
        return Ok(Value::Null);
    }
    if let Ok(yes) = value.cast::<PyBool>() {
        return Ok(Value::Bool(yes.is_true()));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::from(text.to_str()?));
    }
    if value.hasattr("__len__")? {
        return value.try_iter()?.map(|one| value_of(&one?)).collect::<PyResult<_>>().map(Value::Array);
    }
    // Before floats, as whole numbers have both.
    if value.hasattr("__index__")? {
        let positive = value.extract::<u64>().map(Value::from);
        return positive.or_else(|_| value.extract::<i64>().map(Value::from)).or_else(|_| text_of(value));
    }
    if value.hasattr("__float__")? {
        let number = value.extract::<f64>()?;
        // JSON has no other numbers.
        return Ok(if number.is_finite() { number.into() } else { number.to_string().to_lowercase().into() });
    }
    if value.hasattr("__fspath__")? {
        return value_of(&value.call_method0("__fspath__")?);
    }
    text_of(value)
}

/// What no option is, as it stands in messages.
fn text_of(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    Ok(Value::from(value.repr()?.to_str()?))
}

/// An option as it is called here: the limit of memory is that of the scene.
pub(crate) fn named(name: &str) -> Option<String> {
    match name {
        "max_memory" => Some("Scene.max_bytes".to_owned()),
        name => {
            let of_bakes = BakeJob::has(name) || FieldJob::has(name) || SphereJob::has(name);
            (of_bakes
                || TransferSource::has(name)
                || MovingJob::has(name)
                || CameraOptions::has(name)
                || ToneOptions::has(name))
            .then(|| name.to_owned())
        }
    }
}

/// A refusal: `TypeError` for a value of another type, else `ValueError`.
pub(crate) fn refusal(error: &OptionError) -> PyErr {
    let message = worded(&error.message, named);
    let text = one_line(&if error.option.is_empty() { message } else { format!("{}: {message}", error.option) });
    if error.is_type { PyTypeError::new_err(text) } else { PyValueError::new_err(text) }
}

/// A remark in the names of Python.
pub(crate) fn told(about: &str, text: &str) -> String {
    format!("{about}: {}", worded(text, named))
}

/// A report as a dictionary.
pub(crate) fn json_of<'py>(py: Python<'py>, report: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(report).map_err(|error| PyValueError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// A warning for each remark that work has made.
pub(crate) fn warn(py: Python<'_>, remarks: &[String]) -> PyResult<()> {
    if remarks.is_empty() {
        return Ok(());
    }
    let category = py.import("lobe._env")?.getattr("LoadNote")?;
    for text in remarks {
        PyErr::warn(py, &category, &CString::new(one_line(text)).unwrap_or_default(), 2)?;
    }
    Ok(())
}

/// An option of a job: its name, its type, its default, and what it does.
type Field = (&'static str, String, String, String);

/// The options of a bake, but for those of reading its scene.
#[pyfunction]
pub(crate) fn bake_fields() -> Vec<Field> {
    fields_of::<BakeJob>().filter(|field| !SceneSource::has(field.0)).collect()
}

/// The options of a scene that moves.
#[pyfunction]
pub(crate) fn moving_fields() -> Vec<Field> {
    fields_of::<MovingJob>().collect()
}

fn fields_of<T: JobOptions>() -> impl Iterator<Item = Field> {
    T::fields().into_iter().map(field_of::<T>)
}

fn field_of<T: JobOptions>(field: &'static OptionField) -> Field {
    let plain = |text: &str| worded(text, |name| Some(name.to_owned()));
    let own = T::default_of(field.name);
    let (kind, is_open) = (type_of(&field.kind), own.is_none());
    let default = own.map_or_else(|| "None".to_owned(), |value| in_python(&value));
    let mut doc = plain(&field.marked_doc());
    if let OptionKind::Whole { least, most, .. } = field.kind
        && most < u64::from(u32::MAX)
    {
        doc += &format!("; {least} to {most}");
    }
    if let OptionKind::Name(names) = field.kind {
        doc += &format!(": {}", names.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "));
    }
    let left_open = T::left_open_of(field);
    if is_open && !left_open.is_empty() {
        doc += &format!("; None: {}", plain(left_open));
    }
    (field.name, if is_open { format!("{kind} | None") } else { kind }, default, format!("{doc}."))
}

fn type_of(kind: &OptionKind) -> String {
    let tuple = |one: &str, count: usize| format!("tuple[{}]", vec![one; count].join(", "));
    match kind {
        OptionKind::Flag | OptionKind::Switch => "bool".to_owned(),
        OptionKind::Whole { .. } | OptionKind::OneOf(_) => "int".to_owned(),
        OptionKind::Number(_) => "float".to_owned(),
        OptionKind::Wholes { count, .. } => tuple("int", *count),
        OptionKind::Numbers(count) => tuple("float", *count),
        _ => "str".to_owned(),
    }
}

fn in_python(value: &Value) -> String {
    match value {
        Value::Bool(yes) => if *yes { "True" } else { "False" }.to_owned(),
        other => other.to_string(),
    }
}
