//! Files of log tables.

use std::collections::HashMap;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use lobe_io::write_atomically;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors, serialize};
use serde::{Deserialize, Serialize};

use crate::ShadowError;
use crate::accumulate::log_table::{FIT, FIT_END, LEAST_FIT_END, LogTable, LogTableOptions};

/// The one entry of the metadata.
const ENTRY: &str = "lobe";
const FORMAT: &str = "lobe-sphere-logarithms";
const VERSION: u32 = 1;
const ROWS: &str = "rows";
const POLYNOMIALS: &str = "polynomials";

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    options: LogTableOptions,
    /// The end of the polynomials.
    fit_end: f32,
}

/// Only what every version has.
#[derive(Deserialize)]
struct Kind {
    format: String,
    version: u32,
}

/// Writes a table as safetensors: `rows`, `[rows, n]`, and `polynomials`, `[n, 8]`, of floats. The metadata's entry `lobe` is
/// JSON: format `lobe-sphere-logarithms`, version 1, the options, and `fit_end`, where the polynomials end. Until all is
/// written, nothing has the file's name.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses.
pub fn write_log_table(path: impl AsRef<Path>, table: &LogTable) -> Result<(), ShadowError> {
    let place = path.as_ref().display().to_string();
    let invalid = |message: String| ShadowError::Invalid { place: place.clone(), message };
    let header = Header { format: FORMAT.to_owned(), version: VERSION, options: table.options, fit_end: table.fit_end };
    let header = serde_json::to_string(&header).map_err(|e| invalid(e.to_string()))?;
    let bytes_of = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let (rows, fit) = (bytes_of(&table.rows), bytes_of(table.fit.as_flattened()));
    let view = |shape: [usize; 2], bytes| {
        TensorView::new(Dtype::F32, shape.to_vec(), bytes).map_err(|e| invalid(e.to_string()))
    };
    let rows = view([table.row_count(), table.order()], &rows)?;
    let fit = view([table.order(), FIT], &fit)?;
    let metadata = HashMap::from([(ENTRY.to_owned(), header)]);
    let bytes = serialize([(ROWS, rows), (POLYNOMIALS, fit)], Some(metadata)).map_err(|e| invalid(e.to_string()))?;
    write_atomically(path.as_ref(), |out| out.write_all(&bytes)).map_err(|source| ShadowError::Io { place, source })
}

/// Reads what [`write_log_table`] wrote.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours, of another version, or
/// contradicts itself.
pub fn read_log_table(path: impl AsRef<Path>) -> Result<LogTable, ShadowError> {
    let place = path.as_ref().display().to_string();
    let bytes = fs::read(path.as_ref()).map_err(|source| ShadowError::Io { place: place.clone(), source })?;
    read_log_table_bytes(&bytes, &place)
}

/// [`read_log_table`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_log_table`].
pub fn read_log_table_bytes(bytes: &[u8], name: &str) -> Result<LogTable, ShadowError> {
    read(bytes).map_err(|message| {
        // Messages may quote the file.
        ShadowError::Invalid { place: name.to_owned(), message: message.replace(['\n', '\r'], " ") }
    })
}

fn broken(error: &safetensors::SafeTensorError) -> String {
    format!("expected safetensors, found {error}")
}

fn bad_entry(error: &serde_json::Error) -> String {
    format!("the entry {ENTRY} of its metadata is wrong: {error}")
}

/// The version of a file of tables, and its header.
fn header_of(bytes: &[u8]) -> Result<(u32, String), String> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| broken(&e))?;
    let Some(entry) = metadata.metadata().as_ref().and_then(|m| m.get(ENTRY)) else {
        return Err(format!("expected {FORMAT}, found tensors that are none of Lobe's"));
    };
    let kind: Kind = serde_json::from_str(entry).map_err(|e| bad_entry(&e))?;
    if kind.format != FORMAT {
        return Err(format!("expected {FORMAT}, found {}", kind.format));
    }
    Ok((kind.version, entry.clone()))
}

fn read(bytes: &[u8]) -> Result<LogTable, String> {
    let (version, entry) = header_of(bytes)?;
    if version != VERSION {
        return Err(format!("expected version {VERSION} of {FORMAT}, found {version}; make the table anew"));
    }
    let header: Header = serde_json::from_str(&entry).map_err(|e| bad_entry(&e))?;
    header.options.check()?;
    if !(LEAST_FIT_END..=FIT_END).contains(&f64::from(header.fit_end)) {
        return Err(format!(
            "expected polynomials that end between {LEAST_FIT_END} and {FIT_END}, found {}",
            header.fit_end
        ));
    }
    let tensors = SafeTensors::deserialize(bytes).map_err(|e| broken(&e))?;
    let n = header.options.order;
    let rows = numbers(&tensors, ROWS, |shape| shape.len() == 2 && shape[0] >= 2 && shape[1] == n)?;
    let fit = numbers(&tensors, POLYNOMIALS, |shape| shape == [n, FIT])?;
    let fit = fit.as_chunks().0.to_vec();
    Ok(LogTable { options: header.options, rows, fit, fit_end: header.fit_end })
}

/// The largest number that a table may hold: far beyond those of any clamp, and far from where sums overflow.
const LARGEST: f32 = 1e6;

/// A tensor of floats whose shape fits.
fn numbers(tensors: &SafeTensors<'_>, name: &str, fits: impl Fn(&[usize]) -> bool) -> Result<Vec<f32>, String> {
    let view = tensors.tensor(name).map_err(|_| format!("expected a tensor {name}, found none"))?;
    if view.dtype() != Dtype::F32 || !fits(view.shape()) {
        return Err(format!("the tensor {name} of {:?} {:?} does not fit the order", view.dtype(), view.shape()));
    }
    let values: Vec<f32> = view.data().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    match values.iter().position(|x| x.is_nan() || x.abs() > LARGEST) {
        Some(k) => Err(format!("expected logarithms in {name}, found {} as number {k}", values[k])),
        None => Ok(values),
    }
}

/// The table of these options from a file or, where there is none or one of another version, made and written to it.
///
/// # Errors
/// [`ShadowError::Invalid`] if the file holds a table of other options, or no table at all; else as [`read_log_table`],
/// [`LogTable::new`] and [`write_log_table`].
pub fn cached_log_table(path: impl AsRef<Path>, options: &LogTableOptions) -> Result<LogTable, ShadowError> {
    let path = path.as_ref();
    let place = path.display().to_string();
    let bytes = match fs::read(path) {
        Ok(bytes) => Some(bytes),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(source) => return Err(ShadowError::Io { place, source }),
    };
    let is_old = |bytes: &[u8]| header_of(bytes).is_ok_and(|(version, _)| version != VERSION);
    let Some(bytes) = bytes.filter(|bytes| !is_old(bytes)) else {
        let table = LogTable::new(options)?;
        write_log_table(path, &table)?;
        return Ok(table);
    };
    let table = read_log_table_bytes(&bytes, &place)?;
    check_options(&table.options, options).map_err(|message| ShadowError::Invalid { place, message })?;
    Ok(table)
}

/// What a table is made for against what is asked for: the first difference, in words.
fn check_options(found: &LogTableOptions, expected: &LogTableOptions) -> Result<(), String> {
    let window = |window: Option<f64>| window.map_or("no window".to_owned(), |h| format!("a window of {h}"));
    let (kind, expected, found) = if found.order != expected.order {
        ("order", format!("order {}", expected.order), format!("order {}", found.order))
    } else if found.window != expected.window {
        ("window", window(expected.window), window(found.window))
    } else if found.clamp != expected.clamp {
        ("clamp", format!("clamp {}", expected.clamp), format!("clamp {}", found.clamp))
    } else if found.tolerance > expected.tolerance {
        ("tolerance", format!("tolerance {}", expected.tolerance), format!("{}", found.tolerance))
    } else {
        return Ok(());
    };
    Err(format!("a table of another {kind}: expected {expected}, found {found}; name another file, or remove this one"))
}
