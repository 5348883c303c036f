//! Reading environment maps from files.

use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use lobe_sh::{Coefficient, Rgb};

use crate::{EnvError, EnvMap, read_exr, read_hdr};

/// The default of [`ReadOptions::max_texels`]: enough for 16384 x 8192 and for 23170 x 11585, 3 GiB in memory. While a
/// Radiance picture is decoded it is there twice.
const MAX_TEXELS: usize = 1 << 28;

/// Bytes of an unknown file that a message shows; enough to tell what any file is.
const SHOWN_BYTES: usize = 24;

/// What to do with a texel that has a channel of NaN or infinity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Nonfinite {
    /// Refuse the file.
    #[default]
    Error,
    /// Make the whole texel black and count it.
    Zero,
}

/// How to read an environment map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// What to do with NaN and infinity.
    pub nonfinite: Nonfinite,
    /// The largest picture, in texels, for which memory is asked for.
    pub max_texels: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { nonfinite: Nonfinite::default(), max_texels: MAX_TEXELS }
    }
}

/// The kind of file that a map was read from, as its contents say, whatever its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileFormat {
    /// Radiance picture, usually `.hdr`.
    Radiance,
    /// OpenEXR, `.exr`.
    OpenExr,
}

impl fmt::Display for FileFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Radiance => "Radiance .hdr",
            Self::OpenExr => "OpenEXR",
        })
    }
}

/// What was found while reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadReport {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The kind of file.
    pub format: FileFormat,
    /// Texels with a NaN or infinite channel; they are black in the map.
    pub nonfinite: usize,
    /// Column and row of the first of them.
    pub first_nonfinite: Option<(usize, usize)>,
    /// Texels with a negative channel; they are kept.
    pub negative: usize,
    /// What a careful user should know: channels chosen, parts of the file ignored, factors applied.
    pub notes: Vec<String>,
}

/// A picture as it comes out of a decoder.
pub(crate) struct Decoded {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) texels: Vec<Rgb<f32>>,
    pub(crate) notes: Vec<String>,
}

/// Reads a lat-long environment map from a Radiance .hdr or an OpenEXR file.
///
/// What the file is follows from its contents, not from its name.
///
/// * **Radiance**: flat, old and new run-length encoding. `EXPOSURE` and `COLORCORR` are divided out, so the values
///   are radiance; `PRIMARIES` is noted and not converted. Rows from the top and columns from the left
///   (`-Y h +X w`) only.
/// * **OpenEXR**: `half` and `float` channels; every compression but HTJ2K; scan lines and tiles, of which the largest
///   level is read; the first part, and in it the first layer, that has channels `R`, `G`, `B` or else `Y`. Alpha
///   and all other channels are ignored. The map is the display window; outside the data window it is black.
///
/// # Errors
/// [`EnvError::Io`] if the file cannot be read; [`EnvError::Invalid`] if it is damaged, cut off, no such picture, not
/// twice as wide as high, larger than [`ReadOptions::max_texels`], or has non-finite texels that the options do not
/// allow; [`EnvError::Unsupported`] if it is a kind of picture that Lobe does not read.
pub fn read_env(path: impl AsRef<Path>, options: &ReadOptions) -> Result<(EnvMap, ReadReport), EnvError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let io = |source| EnvError::Io { file: name.clone(), source };
    let mut file = open_file(path).map_err(io)?;
    // A device without end, or a film of many gigabytes, is refused by its beginning.
    let mut bytes = Vec::new();
    file.by_ref().take(SHOWN_BYTES as u64).read_to_end(&mut bytes).map_err(io)?;
    format_of(&bytes, &name)?;
    file.read_to_end(&mut bytes).map_err(io)?;
    read_env_bytes(&bytes, &name, options)
}

/// Opens a file; a folder is refused with a message of its own on every system.
fn open_file(path: &Path) -> std::io::Result<File> {
    if fs::metadata(path)?.is_dir() {
        return Err(std::io::Error::other("this is a folder; give a .hdr or .exr file"));
    }
    File::open(path)
}

/// Reads an environment map from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_env`], except [`EnvError::Io`].
pub fn read_env_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<(EnvMap, ReadReport), EnvError> {
    let format = format_of(bytes, name)?;
    // Neither decoder promises never to panic on damaged bytes; a panic is one more way to find the file invalid.
    let decode = || match format {
        FileFormat::Radiance => read_hdr::decode(bytes, name, options.max_texels),
        FileFormat::OpenExr => read_exr::decode(bytes, name, options.max_texels),
    };
    let mut decoded = catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(invalid(name, format!("the {format} data is damaged and cannot be decoded"))))?;
    let report = inspect(&mut decoded, format, name, options.nonfinite)?;
    Ok((EnvMap::from_rows(decoded.width, decoded.height, decoded.texels), report))
}

/// The kind of file, from its first bytes.
fn format_of(bytes: &[u8], name: &str) -> Result<FileFormat, EnvError> {
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return Ok(FileFormat::OpenExr);
    }
    if bytes.starts_with(b"#?") {
        return Ok(FileFormat::Radiance);
    }
    if bytes.is_empty() {
        return Err(invalid(name, "the file is empty; expected Radiance .hdr or OpenEXR".into()));
    }
    let expected = "expected Radiance .hdr (beginning with \"#?RADIANCE\") or OpenEXR";
    if let Some(other) = other_picture(bytes) {
        return Err(EnvError::Unsupported {
            file: name.into(),
            message: format!("{expected}, found {other}; convert it to .hdr or .exr"),
        });
    }
    Err(invalid(name, format!("{expected}, found {}", describe(bytes))))
}

/// The name of another kind of picture that is easily mistaken for an environment map.
fn other_picture(bytes: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 10] = [
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
        (b"II*\0", "a TIFF picture"),
        (b"MM\0*", "a TIFF picture"),
        (b"PF\n", "a PFM picture"),
        (b"Pf\n", "a PFM picture"),
        (b"GIF8", "a GIF picture"),
        (b"\xabKTX", "a KTX texture"),
        (b"DDS ", "a DDS texture"),
        (b"RIFF", "a RIFF file (WebP?)"),
    ];
    KINDS.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, kind)| *kind)
}

/// The beginning of an unknown file, in one line.
fn describe(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(SHOWN_BYTES)];
    let printable = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    if start.iter().all(printable) {
        format!("text beginning with {:?}", String::from_utf8_lossy(start))
    } else {
        format!("unknown data beginning with the bytes {:02x?}", &start[..start.len().min(8)])
    }
}

/// Counts, and where asked removes, what does not belong into a picture of radiance.
fn inspect(
    decoded: &mut Decoded,
    format: FileFormat,
    name: &str,
    nonfinite: Nonfinite,
) -> Result<ReadReport, EnvError> {
    let mut report = ReadReport {
        width: decoded.width,
        height: decoded.height,
        format,
        nonfinite: 0,
        first_nonfinite: None,
        negative: 0,
        notes: std::mem::take(&mut decoded.notes),
    };
    for (i, texel) in decoded.texels.iter_mut().enumerate() {
        let channels = texel.to_array();
        if !channels.iter().all(|c| c.is_finite()) {
            report.first_nonfinite.get_or_insert((i % decoded.width, i / decoded.width));
            report.nonfinite += 1;
            *texel = Rgb::ZERO;
        } else if channels.iter().any(|c| *c < 0.0) {
            report.negative += 1;
        }
    }
    match report.first_nonfinite {
        Some((x, y)) if nonfinite == Nonfinite::Error => {
            let texels = if report.nonfinite == 1 { "1 texel is" } else { &format!("{} texels are", report.nonfinite) };
            let message =
                format!("{texels} NaN or infinite, first at column {x}, row {y}; --nonfinite zero reads them as black");
            Err(invalid(name, message))
        }
        _ => Ok(report),
    }
}

/// Refuses a picture that cannot be a lat-long map or is larger than the caller allows, before memory is asked for.
pub(crate) fn check_size(width: u64, height: u64, max_texels: usize, name: &str) -> Result<(usize, usize), EnvError> {
    if width == 0 || height == 0 {
        return Err(invalid(name, format!("the picture has no texels: it is {width} x {height}")));
    }
    if width.checked_mul(height).is_none_or(|texels| texels > max_texels as u64) {
        let message =
            format!("the picture is {width} x {height}, more than the limit of {max_texels} texels; scale it down");
        return Err(invalid(name, message));
    }
    if width != 2 * height {
        let message = format!(
            "a lat-long map is twice as wide as high, but this picture is {width} x {height}; give a full panorama"
        );
        return Err(invalid(name, message));
    }
    Ok((width as usize, height as usize))
}

/// An empty vector with room for `count` items, or an error where the system has no memory for them.
pub(crate) fn reserve<T>(count: usize, name: &str) -> Result<Vec<T>, EnvError> {
    let mut items = Vec::new();
    items.try_reserve_exact(count).map_err(|_| {
        let mib = (count.saturating_mul(size_of::<T>())) >> 20;
        EnvError::Io {
            file: name.into(),
            source: std::io::Error::new(std::io::ErrorKind::OutOfMemory, format!("no memory for {mib} MiB of texels")),
        }
    })?;
    Ok(items)
}

pub(crate) fn invalid(name: &str, message: String) -> EnvError {
    EnvError::Invalid { file: name.into(), message }
}

pub(crate) fn unsupported(name: &str, message: String) -> EnvError {
    EnvError::Unsupported { file: name.into(), message }
}
