//! Output files: their names, and what is kept beside them until they are written.

use std::path::{Path, PathBuf};

use lobe::io::{IoError, check_writable, remove_abandoned, write_atomically};
use pyo3::prelude::*;

use crate::job::error_of;
use crate::rows::value_error;

/// Refuses an output whose ending is none of these, that could not be written, or that is one of the inputs, which would be lost; clears away
/// what killed programs have left beside it.
pub(crate) fn prepare(output: &Path, endings: &[&str], inputs: &[&Path]) -> PyResult<()> {
    let name = output.display();
    let found = output.canonicalize();
    if inputs.iter().any(|input| matches!((&found, input.canonicalize()), (Ok(out), Ok(input)) if *out == input)) {
        return Err(value_error(format!("{name}: is an input, which would be lost; give another name")));
    }
    if !endings.iter().any(|ending| has_ending(output, ending)) {
        let endings: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
        return Err(value_error(format!("{name}: expected a name that ends in {}", endings.join(" or "))));
    }
    let place = name.to_string();
    check_writable(output).map_err(|source| error_of(&IoError::Io { place, source }))?;
    remove_abandoned(output);
    Ok(())
}

/// Whether the name of a file has this ending, in letters of any case.
pub(crate) fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Writes a file; until all is written and on the disk nothing has its name. A program that is killed in the middle leaves a temporary file, which
/// [`clear_abandoned`] takes away.
#[pyfunction]
pub(crate) fn write_whole(py: Python<'_>, path: PathBuf, bytes: &[u8]) -> PyResult<()> {
    let place = path.display().to_string();
    let written = py.detach(|| write_atomically(&path, |file| file.write_all(bytes)));
    written.map_err(|source| error_of(&IoError::Io { place, source }))
}

/// Removes from the folder of a file the temporary files of programs that were killed; those that are being written stay.
#[pyfunction]
pub(crate) fn clear_abandoned(py: Python<'_>, path: PathBuf) {
    py.detach(|| remove_abandoned(&path));
}
