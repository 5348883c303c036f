//! Expansions as `.sh.json` files.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use serde::Deserialize;
use serde_json::Value;

use crate::basis::index::{MAX_ORDER, coefficient_count};
use crate::error::ShError;
use crate::expansion::quantity::Quantity;
use crate::expansion::{Expansion as _, ShVec};
use crate::scalar::{Coefficient, Rgb};
use lobe_io::write_atomically;

/// The value of the field `format`.
const FORMAT: &str = "lobe-sh";

/// The version this code reads and writes.
const VERSION: u64 = 1;

/// The convention of the coefficients, which files say for other readers. One that says another is refused.
const CONVENTION: &str = "real, orthonormal, Condon-Shortley phase, z up";

/// No expansion needs more bytes: 256² rows of three numbers take 4 MiB as Lobe writes them, below 16 MiB if each
/// number has an indented line of its own. A longer file is not read to its end.
const MAX_BYTES: u64 = 32 << 20;

/// The most commas: one for each number and each row of the highest order. A file of more would take forty times its bytes before the number of
/// its rows is known.
const MOST_COMMAS: usize = 4 * MAX_ORDER * MAX_ORDER;

/// The largest coefficient: the sun's radiance has eight digits, and sums and squares of such numbers stay far inside
/// `f64`, pictures of their functions inside `f32`.
const LARGEST: f64 = 1e30;

/// The content of a `.sh.json` file.
///
/// ```text
///   {"format":"lobe-sh","version":1,"order":2,"quantity":"radiance",
///   "convention":"real, orthonormal, Condon-Shortley phase, z up","coefficients":[
///   [3.5,3.5,3.5],
///   [0.0,0.0,0.0],
///   [1.0,0.5,0.25],
///   [0.0,0.0,0.0]
///   ]}
/// ```
///
/// `n²` rows in index order, each of three numbers (a color) or each of one (a scalar). `convention` may
/// be left out. Fields that are not listed here are ignored, so that other tools may add notes.
///
/// ```
/// use lobe_sh::ShVec;
/// use lobe_sh::expansion::Quantity;
/// use lobe_sh::sh_json::{ShFile, read_sh_json_bytes, write_sh_json_to};
///
/// let sky = ShFile::new(Quantity::Radiance, ShVec::constant(3, 1.0));
/// let mut text = Vec::new();
/// write_sh_json_to(&mut text, &sky, "sky.sh.json")?;
/// assert_eq!(read_sh_json_bytes(&text, "sky.sh.json")?, sky);
/// # Ok::<(), lobe_sh::ShError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ShFile {
    /// The physical quantity that the function describes.
    pub quantity: Quantity,
    /// The function.
    pub coefficients: FileCoefficients,
}

/// The expansion in a file: of colors or of numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum FileCoefficients {
    /// Rows of one number.
    Scalar(ShVec<f64>),
    /// Rows of three numbers.
    Rgb(ShVec<Rgb<f64>>),
}

impl FileCoefficients {
    /// The order `n`: the number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        match self {
            Self::Scalar(f) => f.order(),
            Self::Rgb(f) => f.order(),
        }
    }

    /// The expansion as colors; a scalar one is gray.
    #[must_use]
    pub fn to_rgb(&self) -> ShVec<Rgb<f64>> {
        match self {
            Self::Scalar(f) => f.map(Rgb::splat),
            Self::Rgb(f) => f.clone(),
        }
    }
}

impl From<ShVec<f64>> for FileCoefficients {
    fn from(f: ShVec<f64>) -> Self {
        Self::Scalar(f)
    }
}

impl From<ShVec<Rgb<f64>>> for FileCoefficients {
    fn from(f: ShVec<Rgb<f64>>) -> Self {
        Self::Rgb(f)
    }
}

/// Reads the file at `path`. Numbers are read to the nearest `f64`.
///
/// # Errors
/// If the file cannot be read, or its text is cut off, no JSON, of another format or version, of an order outside
/// `1..=256`, of an unknown quantity, or has not exactly `n²` rows that all hold one or all hold three numbers of at
/// most 1e30.
pub fn read_sh_json(path: impl AsRef<Path>) -> Result<ShFile, ShError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    match File::open(path) {
        Ok(file) => read_sh_json_from(file, &name),
        Err(source) => Err(ShError::Io { place: name, source }),
    }
}

/// Reads the bytes of a file; `name` is its name in messages.
///
/// # Errors
/// Those of [`read_sh_json`].
pub fn read_sh_json_bytes(bytes: &[u8], name: &str) -> Result<ShFile, ShError> {
    parse(bytes).map_err(|fault| fault.of(name))
}

/// Reads a stream, and no more of it than the longest file has; `name` is its name in messages.
///
/// # Errors
/// Those of [`read_sh_json`].
pub fn read_sh_json_from(reader: impl Read, name: &str) -> Result<ShFile, ShError> {
    let mut bytes = Vec::new();
    reader
        .take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| ShError::Io { place: name.to_owned(), source })?;
    read_sh_json_bytes(&bytes, name)
}

/// Writes the file at `path`, all or nothing ([`lobe_io::write_atomically`]): the head on the first line, then one
/// coefficient on each; the same bytes for the same numbers, each the shortest that reads back as the same `f64`.
///
/// # Errors
/// If the file cannot be written, a coefficient is not finite or larger than 1e30, or the order is outside `1..=256`.
pub fn write_sh_json(path: impl AsRef<Path>, file: &ShFile) -> Result<(), ShError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let text = text_of(file).map_err(|message| ShError::Options(format!("{name}: {message}")))?;
    write_atomically(path, |w| w.write_all(text.as_bytes())).map_err(|source| ShError::Io { place: name, source })
}

/// Writes to a stream what [`write_sh_json`] writes to a file; `name` is its name in messages.
///
/// # Errors
/// Those of [`write_sh_json`].
pub fn write_sh_json_to(mut writer: impl Write, file: &ShFile, name: &str) -> Result<(), ShError> {
    let text = text_of(file).map_err(|message| ShError::Options(format!("{name}: {message}")))?;
    writer
        .write_all(text.as_bytes())
        .and_then(|()| writer.flush())
        .map_err(|source| ShError::Io { place: name.to_owned(), source })
}

/// The whole text of a file, or why it cannot be one.
fn text_of(file: &ShFile) -> Result<String, String> {
    let order = file.coefficients.order();
    if !(1..=MAX_ORDER).contains(&order) {
        return Err(format!("an expansion in a file has order 1 to {MAX_ORDER}; this one has order {order}"));
    }
    let quantity = file.quantity;
    let mut text = format!(
        r#"{{"format":"{FORMAT}","version":{VERSION},"order":{order},"quantity":"{quantity}","convention":"{CONVENTION}","#
    );
    text.push_str(r#""coefficients":["#);
    match &file.coefficients {
        FileCoefficients::Scalar(f) => push_rows(&mut text, f.coefficients())?,
        FileCoefficients::Rgb(f) => push_rows(&mut text, f.coefficients())?,
    }
    text.push_str("\n]}\n");
    Ok(text)
}

fn push_rows<T: Coefficient<Scalar = f64>>(text: &mut String, rows: &[T]) -> Result<(), String> {
    for (i, row) in rows.iter().enumerate() {
        text.push_str(if i == 0 { "\n[" } else { ",\n[" });
        for c in 0..T::CHANNELS {
            let value = row.channel(c);
            if !value.is_finite() {
                return Err(format!("coefficient {i} is {value}; a file holds finite numbers only"));
            }
            if value.abs() > LARGEST {
                return Err(format!("coefficient {i} is {value:e}; a file holds numbers up to {LARGEST:e}"));
            }
            if c > 0 {
                text.push(',');
            }
            text.push_str(&Value::from(value).to_string());
        }
        text.push(']');
    }
    Ok(())
}

/// The head of a file before any check.
#[derive(Deserialize)]
struct Raw {
    format: Option<Value>,
    version: Option<Value>,
    order: Option<Value>,
    quantity: Option<Value>,
    convention: Option<Value>,
    coefficients: Option<Value>,
}

/// An error that does not know the file's name yet.
enum Fault {
    Invalid(String),
    Unsupported(String),
}

impl Fault {
    fn of(self, name: &str) -> ShError {
        let place = name.to_owned();
        match self {
            Self::Invalid(message) => ShError::Invalid { place, message },
            Self::Unsupported(message) => ShError::Unsupported { place, message },
        }
    }
}

/// A fault of the file, as an `Err`.
fn invalid<T>(message: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Invalid(message.into()))
}

fn parse(bytes: &[u8]) -> Result<ShFile, Fault> {
    if let Some(kind) = foreign_kind(bytes) {
        return invalid(format!("expected a .sh.json file, found {kind}"));
    }
    if bytes.len() as u64 > MAX_BYTES {
        return invalid(format!("expected a .sh.json file of at most {MAX_BYTES} bytes, found a longer one"));
    }
    if bytes.iter().filter(|byte| **byte == b',').count() > MOST_COMMAS {
        return invalid(format!("expected at most {MAX_ORDER}² rows of up to three numbers, found more"));
    }
    // Some editors put a byte order mark in front.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if let Some(first) = bytes.iter().find(|b| !b.is_ascii_whitespace())
        && *first != b'{'
    {
        return invalid("expected a .sh.json file, which begins with {; this is something else");
    }
    let raw: Raw = serde_json::from_slice(bytes).or_else(|e| invalid(json_message(bytes, &e)))?;
    check_head(&raw)?;
    if raw.convention.as_ref().is_some_and(|said| said.as_str() != Some(CONVENTION)) {
        let found = found(raw.convention.as_ref());
        let message =
            format!("\"convention\": expected {CONVENTION:?}, {found}; lobe sh convert --from NAME reads others");
        return Err(Fault::Unsupported(message));
    }
    let order = order_in(raw.order.as_ref())?;
    let quantity = raw.quantity.as_ref().and_then(Value::as_str).unwrap_or_default();
    let quantity =
        quantity.parse().or_else(|e| invalid(format!("\"quantity\": {e}, {}", found(raw.quantity.as_ref()))))?;
    let Some(Value::Array(rows)) = &raw.coefficients else {
        return invalid(format!("\"coefficients\": expected an array of rows, {}", found(raw.coefficients.as_ref())));
    };
    if rows.len() != coefficient_count(order) {
        let (expected, count) = (coefficient_count(order), rows.len());
        return invalid(format!("\"coefficients\": order {order} has {expected} rows, found {count}"));
    }
    let coefficients = match rows[0].as_array().map(Vec::len) {
        Some(1) => ShVec::of(read_rows(rows, |[x]: [f64; 1]| x)?).into(),
        _ => ShVec::of(read_rows(rows, |c: [f64; 3]| Rgb::from(c))?).into(),
    };
    Ok(ShFile { quantity, coefficients })
}

/// Checks `format` and `version`; the other fields mean nothing before that.
fn check_head(raw: &Raw) -> Result<(), Fault> {
    if raw.format.as_ref().and_then(Value::as_str) != Some(FORMAT) {
        return invalid(format!(
            "\"format\": expected \"{FORMAT}\", {}; is this an expansion?",
            found(raw.format.as_ref())
        ));
    }
    match &raw.version {
        Some(version) if version.as_u64() == Some(VERSION) => Ok(()),
        Some(Value::Number(version)) => Err(Fault::Unsupported(format!(
            "\"version\": this Lobe reads version {VERSION}, found {version}; a newer Lobe may read it"
        ))),
        other => invalid(format!("\"version\": expected {VERSION}, {}", found(other.as_ref()))),
    }
}

fn order_in(value: Option<&Value>) -> Result<usize, Fault> {
    match value.and_then(Value::as_u64) {
        Some(order) if (1..=MAX_ORDER as u64).contains(&order) => Ok(order as usize),
        _ => invalid(format!("\"order\": expected a whole number from 1 to {MAX_ORDER}, {}", found(value))),
    }
}

/// All rows, each of `N` numbers, in index order.
fn read_rows<const N: usize, T>(rows: &[Value], make: impl Fn([f64; N]) -> T) -> Result<Vec<T>, Fault> {
    let numbers = |row: &Value| row.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<_>>>();
    let read = |(i, row): (usize, &Value)| {
        let row_of_n = numbers(row).and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
        let row_of_n = row_of_n.ok_or_else(|| row_fault(i, row, N))?;
        match row_of_n.iter().find(|x| x.abs() > LARGEST) {
            Some(x) => invalid(format!("\"coefficients\": row {i} holds {x:e}; numbers up to {LARGEST:e} are read")),
            None => Ok(make(row_of_n)),
        }
    };
    rows.iter().enumerate().map(read).collect()
}

/// The fault of row `i`, which should have `n` numbers.
fn row_fault(i: usize, row: &Value, n: usize) -> Fault {
    let wanted = match (i, n) {
        (0, _) => "1 or 3 numbers",
        (_, 1) => "1 number as in row 0",
        _ => "3 numbers as in row 0",
    };
    let found = match row {
        Value::Array(items) => match items.iter().find(|item| !item.is_number()) {
            Some(item) => found(Some(item)),
            None => format!("found {}", items.len()),
        },
        other => found(Some(other)),
    };
    Fault::Invalid(format!("\"coefficients\": expected an array of {wanted} in row {i}, {found}"))
}

/// A value as it stands in the file, cut to a length that fits on a line.
fn found(value: Option<&Value>) -> String {
    const MAX_CHARS: usize = 40;
    let text = match value {
        None => return "found nothing".to_owned(),
        Some(Value::Array(items)) => return format!("found an array of {}", items.len()),
        Some(Value::Object(_)) => return "found an object".to_owned(),
        Some(other) => other.to_string(),
    };
    match text.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("found {}...", &text[..end]),
        None => format!("found {text}"),
    }
}

/// The message for text that is no JSON or not of the right shape; it ends in line and column.
fn json_message(bytes: &[u8], error: &serde_json::Error) -> String {
    let hint = bytes.split(|&b| b == b'\n').nth(error.line().saturating_sub(1)).map_or("", |line| {
        let has = |word: &[u8]| line.windows(word.len()).any(|w| w == word);
        if has(b"NaN") || has(b"Infinity") { "; JSON has no NaN and no infinity" } else { "" }
    });
    match error.classify() {
        serde_json::error::Category::Eof if bytes.is_empty() => {
            "expected a .sh.json file, found an empty one".to_owned()
        }
        serde_json::error::Category::Eof => format!("the file is cut off: {error}"),
        serde_json::error::Category::Data => format!("not an expansion: {error}"),
        _ => format!("not valid JSON: {error}{hint}"),
    }
}

/// The name of a well-known kind of file, by its first bytes.
fn foreign_kind(bytes: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 8] = [
        (b"\x76\x2F\x31\x01", "an OpenEXR picture; project it first"),
        (b"#?", "a Radiance picture; project it first"),
        (b"\x89PNG", "a PNG picture; project it first"),
        (b"\xFF\xD8\xFF", "a JPEG picture; project it first"),
        (b"PF\n", "a PFM picture; project it first"),
        (b"\xABKTX", "a KTX texture"),
        (b"DDS ", "a DDS texture"),
        (b"\xFF\xFE", "text in UTF-16; save it as UTF-8"),
    ];
    KINDS.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|&(_, kind)| kind)
}

impl ShFile {
    /// An expansion with its meaning.
    #[must_use]
    pub fn new(quantity: Quantity, coefficients: impl Into<FileCoefficients>) -> Self {
        Self { quantity, coefficients: coefficients.into() }
    }
}
