//! Files of log tables.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use lobe_io::{IoError, Numbers, Tensor, TensorFile, TensorFormat, read_file, write_tensors};
use serde::{Deserialize, Serialize};

use crate::accumulate::log_table::{FIT, FIT_END, LEAST_FIT_END, LogTable, LogTableOptions};
use crate::error::ShadowError;

const FORMAT: TensorFormat =
    TensorFormat { name: "lobe-sphere-logarithms", version: 1, if_older: "make the table anew" };
const ROWS: &str = "rows";
const POLYNOMIALS: &str = "polynomials";

#[derive(Serialize, Deserialize)]
struct Header {
    options: LogTableOptions,
    /// The end of the polynomials.
    fit_end: f32,
}

/// Writes a table as safetensors: `rows`, `[rows, n]`, and `polynomials`, `[n, 8]`, of floats. The metadata's entry `lobe` is
/// JSON: format `lobe-sphere-logarithms`, version 1, the options, and `fit_end`, where the polynomials end. Until all is
/// written, nothing has the file's name.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses.
pub fn write_log_table(path: impl AsRef<Path>, table: &LogTable) -> Result<(), ShadowError> {
    let header = Header { options: table.options, fit_end: table.fit_end };
    let tensors = [
        Tensor::new(ROWS, [table.row_count(), table.order()], Numbers::F32(&table.rows)),
        Tensor::new(POLYNOMIALS, [table.order(), FIT], Numbers::F32(table.fit.as_flattened())),
    ];
    Ok(write_tensors(path.as_ref(), FORMAT, &header, &tensors)?)
}

/// Reads what [`write_log_table`] wrote.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours, of another version, or
/// contradicts itself.
pub fn read_log_table(path: impl AsRef<Path>) -> Result<LogTable, ShadowError> {
    let path = path.as_ref();
    read_log_table_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_log_table`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_log_table`].
pub fn read_log_table_bytes(bytes: &[u8], name: &str) -> Result<LogTable, ShadowError> {
    Ok(table_of(&TensorFile::parse(bytes, name, &[FORMAT])?)?)
}

fn table_of(file: &TensorFile<'_>) -> Result<LogTable, IoError> {
    let Header { options, fit_end } = file.header()?;
    options.check().map_err(|message| file.invalid(message))?;
    if !(LEAST_FIT_END..=FIT_END).contains(&fit_end) {
        let expected = format!("expected polynomials that end between {LEAST_FIT_END} and {FIT_END}");
        return Err(file.invalid(format!("{expected}, found {fit_end}")));
    }
    let n = options.order;
    let rows = numbers(file, ROWS, [None, Some(n)])?;
    if rows.len() < 2 * n {
        return Err(file.invalid(format!("expected two rows or more, found {}", rows.len() / n)));
    }
    let fit = numbers(file, POLYNOMIALS, [Some(n), Some(FIT)])?.as_chunks().0.to_vec();
    Ok(LogTable { options, rows, fit, fit_end })
}

/// The largest number that a table may hold: far beyond those of any clamp, and far from where sums overflow.
const LARGEST: f32 = 1e6;

/// The numbers of a tensor of logarithms.
fn numbers(file: &TensorFile<'_>, name: &str, shape: [Option<usize>; 2]) -> Result<Vec<f32>, IoError> {
    let values = file.f32(name, &shape)?;
    match values.iter().position(|x| x.is_nan() || x.abs() > LARGEST) {
        Some(k) => Err(file.invalid(format!("expected logarithms in {name}, found {} as number {k}", values[k]))),
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
        Err(source) => return Err(IoError::io(path, source).into()),
    };
    let read = bytes.map(|bytes| TensorFile::parse(&bytes, &place, &[FORMAT]).and_then(|file| table_of(&file)));
    let table = match read {
        None | Some(Err(IoError::Unsupported { .. })) => {
            let table = LogTable::new(options)?;
            write_log_table(path, &table)?;
            return Ok(table);
        }
        Some(read) => read?,
    };
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
