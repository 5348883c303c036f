//! Techniques of environment mapping beside each other, as pictures and as one sheet of them.

use std::path::PathBuf;
use std::sync::Arc;

use lobe::figures::{
    EnvironmentPanel, EnvironmentSheetOptions, EnvironmentSheetSource, environment_mapping_sheet, environment_panels,
};
use lobe::image::Tone;
use pyo3::prelude::*;

use crate::forked::with_threads;
use crate::job::{error_of, watched};
use crate::maps::Map;
use crate::outputs::prepare;
use crate::pictures::{Pixels, pixels};

/// A map in the forms that the techniques take.
fn source(py: Python<'_>, map: &Map, progress: Option<&Py<PyAny>>) -> PyResult<EnvironmentSheetSource> {
    watched(py, progress, None, |job| EnvironmentSheetSource::new((*Arc::clone(&map.0)).clone(), job))
}

/// A solid, the technique, the picture `(size, size, 3)`, its error, and whether it mirrors.
type Panel<'py> = (&'static str, &'static str, Pixels<'py>, Option<f64>, bool);

/// Every technique under a map, in linear light.
#[pyfunction]
pub(crate) fn techniques<'py>(
    py: Python<'py>,
    map: &Map,
    size: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Panel<'py>>> {
    let source = source(py, map, progress.as_ref())?;
    let options = EnvironmentSheetOptions::default().size(size).prefiltered(&source.chain);
    let panels = watched(py, progress.as_ref(), None, |job| environment_panels(&source.sky, &options, job))?;
    let panel = |panel: &EnvironmentPanel| {
        Ok((panel.solid, panel.technique, pixels(py, &panel.picture)?, panel.error, panel.mirrors))
    };
    panels.iter().map(panel).collect()
}

/// Writes the sheet of them, a .png.
#[pyfunction]
pub(crate) fn show(
    py: Python<'_>,
    map: &Map,
    output: PathBuf,
    size: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    prepare(&output, &["png"], &[])?;
    let source = source(py, map, progress.as_ref())?;
    let options = EnvironmentSheetOptions::default().size(size).prefiltered(&source.chain);
    let sheet = watched(py, progress.as_ref(), None, |job| environment_mapping_sheet(&source.sky, &options, job))?;
    py.detach(|| with_threads(|| sheet.write_png(&output, &Tone::PLAIN))).map_err(|error| error_of(&error))
}
