//! Reading environment maps from files.

use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::codec::dds;
use crate::codec::read_exr;
use crate::codec::read_hdr;
use crate::codec::read_ldr;
use crate::codec::read_pfm;
use crate::files::exr_envmap;
use crate::{EnvError, EnvMap, ReadOption};

/// The default of [`ReadOptions::max_texels`]: enough for 16384 x 8192 and for 23170 x 11585, 3 GiB in memory. While a
/// Radiance picture is decoded it is there twice.
const MAX_TEXELS: usize = 1 << 28;

/// What a file can be, for messages.
const EXPECTED: &str = "Radiance .hdr (beginning with \"#?RADIANCE\"), OpenEXR, .pfm, PNG, JPEG, KTX2 or DDS";

/// Bytes of an unknown file that a message shows; enough to tell what any file is.
const SHOWN_BYTES: usize = 24;

/// Characters of a message; more are the file's own, repeated.
const MAX_MESSAGE: usize = 320;

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
    /// Portable float map, `.pfm`.
    Pfm,
    /// PNG picture, 8 or 16 bits.
    Png,
    /// JPEG picture.
    Jpeg,
    /// KTX2 texture.
    Ktx2,
    /// DDS texture.
    Dds,
}

impl fmt::Display for FileFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Radiance => "Radiance .hdr",
            Self::OpenExr => "OpenEXR",
            Self::Pfm => "portable float map",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Ktx2 => "KTX2",
            Self::Dds => "DDS",
        })
    }
}

/// What was found while reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadReport {
    /// Columns; of a cube map, those of a face.
    pub width: usize,
    /// Rows; of a cube map, those of a face.
    pub height: usize,
    /// Levels of a cube map; 1 for a picture.
    pub levels: usize,
    /// The kind of file.
    pub format: FileFormat,
    /// Texels with a NaN or infinite channel; they are black in the map.
    pub nonfinite: usize,
    /// Column and row of the first of them; in a cube map, of the faces of its level one above another.
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
    /// Whether the centers of the outer texels lie on the edges of the picture, or of the faces of a cube.
    pub(crate) edge_centered: bool,
}

/// What a picture must be to be decoded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) max_texels: usize,
    pub(crate) shape: Shape,
}

/// The form of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Twice as wide as high.
    LatLong,
    /// Six squares, one above another, said to be a cube map.
    Cube,
    /// A cube map if the file says so, or else a lat-long map.
    Said,
    /// Anything.
    Any,
}

/// Reads a lat-long environment map from a Radiance .hdr, OpenEXR, .pfm, PNG or JPEG file.
///
/// What the file is follows from its contents, not from its name.
///
/// * **Radiance**: flat, old and new run-length encoding. `EXPOSURE` and `COLORCORR` are divided out, so the values
///   are radiance; `PRIMARIES` is noted and not converted. Rows from the top and columns from the left
///   (`-Y h +X w`) only.
/// * **OpenEXR**: `half` and `float` channels; every compression but HTJ2K; scan lines and tiles, of which the largest
///   level is read; the first part, and in it the first layer, that has channels `R`, `G`, `B` or else `Y`. Alpha
///   and all other channels are ignored. The map is the display window; outside the data window it is black. With the
///   attribute `envmap` the outer texels lie on the edges, as the format defines it: the map is moved to Lobe's
///   centers by interpolation, and the picture's center is the map's +x as for every picture.
/// * **Portable float map**: color and gray, both byte orders, the scale of the header multiplied in.
/// * **PNG, JPEG**: 8 and 16 bits, decoded from sRGB. White is 1 and nothing is brighter, which a note says.
///
/// Cube maps are read by [`read_cube`](crate::read_cube()).
///
/// # Errors
/// [`EnvError::Io`] if the file cannot be read; [`EnvError::Invalid`] if it is damaged, cut off, no such picture or not
/// twice as wide as high; [`EnvError::Refused`] if it is larger than [`ReadOptions::max_texels`], or has non-finite
/// texels that the options do not allow; [`EnvError::Unsupported`] if it is a kind of picture that Lobe does not read.
pub fn read_env(path: impl AsRef<Path>, options: &ReadOptions) -> Result<(EnvMap, ReadReport), EnvError> {
    let path = path.as_ref();
    let (name, bytes) = read_named(path)?;
    read_env_bytes(&bytes, &name, options)
}

/// The name of a file for messages, and its contents.
pub(crate) fn read_named(path: &Path) -> Result<(String, Vec<u8>), EnvError> {
    let name = path.display().to_string();
    let io = |source| EnvError::Io { file: name.clone(), source };
    let mut file = open_file(path).map_err(io)?;
    // A device without end, or a film of many gigabytes, is refused by its beginning.
    let mut bytes = Vec::new();
    file.by_ref().take(SHOWN_BYTES as u64).read_to_end(&mut bytes).map_err(io)?;
    format_of(&bytes, &name)?;
    file.read_to_end(&mut bytes).map_err(io)?;
    Ok((name, bytes))
}

/// Opens a file; a folder is refused with a message of its own on every system.
fn open_file(path: &Path) -> std::io::Result<File> {
    if fs::metadata(path)?.is_dir() {
        return Err(std::io::Error::other("this is a folder; give the name of a picture"));
    }
    File::open(path)
}

/// Reads an environment map from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_env`], except [`EnvError::Io`].
pub fn read_env_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<(EnvMap, ReadReport), EnvError> {
    let (decoded, report) = decode_picture(bytes, name, options, Shape::LatLong)?;
    Ok((lat_long(decoded), report))
}

/// A lat-long map from a picture of that shape.
pub(crate) fn lat_long(decoded: Decoded) -> EnvMap {
    let map = EnvMap::from_rows(decoded.width, decoded.height, decoded.texels);
    if decoded.edge_centered { exr_envmap::lat_long_from_edges(&map) } else { map }
}

/// Decodes a picture and looks through its texels.
pub(crate) fn decode_picture(
    bytes: &[u8],
    name: &str,
    options: &ReadOptions,
    shape: Shape,
) -> Result<(Decoded, ReadReport), EnvError> {
    let format = format_of(bytes, name)?;
    let limits = Limits { max_texels: options.max_texels, shape };
    let mut decoded = guarded(format, name, || match format {
        FileFormat::Radiance => read_hdr::decode(bytes, name, limits),
        FileFormat::OpenExr => read_exr::decode(bytes, name, limits),
        FileFormat::Pfm => read_pfm::decode(bytes, name, limits),
        FileFormat::Png => read_ldr::decode_png(bytes, name, limits),
        FileFormat::Jpeg => read_ldr::decode_jpeg(bytes, name, limits),
        FileFormat::Ktx2 | FileFormat::Dds => Err(unsupported(
            name,
            format!("a lat-long picture expected, found a texture ({format}), which holds a cube map"),
        )),
    })?;
    let notes = std::mem::take(&mut decoded.notes);
    let mut report = ReadReport::new(decoded.width, decoded.height, format, notes);
    inspect(&mut decoded.texels, decoded.width, &mut report);
    report.judge(options.nonfinite, name)?;
    if decoded.edge_centered {
        report.notes.push("by the attribute envmap the outer texels lie on the edges; the map is interpolated".into());
    }
    Ok((decoded, report))
}

/// Runs a decoder. None promises never to panic on damaged bytes; a panic is one more way to find the file invalid.
pub(crate) fn guarded<T>(
    format: FileFormat,
    name: &str,
    decode: impl FnOnce() -> Result<T, EnvError>,
) -> Result<T, EnvError> {
    catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(invalid(name, format!("the {format} data is damaged and cannot be decoded"))))
}

/// The kind of file, from its first bytes.
pub(crate) fn format_of(bytes: &[u8], name: &str) -> Result<FileFormat, EnvError> {
    const KINDS: [(&[u8], FileFormat); 9] = [
        (&[0x76, 0x2f, 0x31, 0x01], FileFormat::OpenExr),
        (b"#?", FileFormat::Radiance),
        (b"PF", FileFormat::Pfm),
        (b"Pf", FileFormat::Pfm),
        (b"\x89PNG\r\n\x1a\n", FileFormat::Png),
        (b"\xff\xd8\xff", FileFormat::Jpeg),
        (&ktx2::MAGIC, FileFormat::Ktx2),
        (&dds::MAGIC, FileFormat::Dds),
        // A DDS file and a KTX2 file may be cut within these; then the decoder says so.
        (b"\xabKTX 2", FileFormat::Ktx2),
    ];
    let word_ends = |magic: &[u8]| !magic.starts_with(b"P") || bytes.get(2).is_none_or(u8::is_ascii_whitespace);
    if let Some((_, format)) = KINDS.iter().find(|(magic, _)| bytes.starts_with(magic) && word_ends(magic)) {
        return Ok(*format);
    }
    if bytes.is_empty() {
        return Err(invalid(name, format!("the file is empty; {EXPECTED} expected")));
    }
    if let Some(other) = other_picture(bytes) {
        let message = format!("{EXPECTED} expected, found {other}; convert it to .hdr or .exr");
        return Err(unsupported(name, message));
    }
    Err(invalid(name, format!("{EXPECTED} expected, found {}", describe(bytes))))
}

/// The name of another kind of picture that is easily mistaken for an environment map.
fn other_picture(bytes: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 5] = [
        (b"II*\0", "a TIFF picture"),
        (b"MM\0*", "a TIFF picture"),
        (b"GIF8", "a GIF picture"),
        (b"\xabKTX 1", "a KTX texture of version 1"),
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

impl ReadReport {
    pub(crate) fn new(width: usize, height: usize, format: FileFormat, notes: Vec<String>) -> Self {
        Self { width, height, levels: 1, format, nonfinite: 0, first_nonfinite: None, negative: 0, notes }
    }

    /// Refuses non-finite texels where the options do.
    pub(crate) fn judge(&self, nonfinite: Nonfinite, name: &str) -> Result<(), EnvError> {
        match self.first_nonfinite {
            Some((x, y)) if nonfinite == Nonfinite::Error => {
                let texels = if self.nonfinite == 1 { "1 texel is" } else { &format!("{} texels are", self.nonfinite) };
                let message = format!("{texels} NaN or infinite, first at column {x}, row {y}");
                Err(EnvError::Refused { file: name.into(), message, option: ReadOption::Nonfinite })
            }
            _ => Ok(()),
        }
    }
}

/// Counts, and makes black, what does not belong into a picture of radiance.
pub(crate) fn inspect(texels: &mut [Rgb<f32>], width: usize, report: &mut ReadReport) {
    let of_row = |(y, row): (usize, &mut [Rgb<f32>])| {
        let (mut first_nonfinite, mut nonfinite, mut negative) = (None, 0, 0);
        for (x, texel) in row.iter_mut().enumerate() {
            let channels = texel.to_array();
            if !channels.iter().all(|c| c.is_finite()) {
                first_nonfinite.get_or_insert((x, y));
                nonfinite += 1;
                *texel = Rgb::ZERO;
            } else if channels.iter().any(|c| *c < 0.0) {
                negative += 1;
            }
        }
        (first_nonfinite, nonfinite, negative)
    };
    let rows: Vec<_> = texels.par_chunks_mut(width).enumerate().map(of_row).collect();
    for (first_nonfinite, nonfinite, negative) in rows {
        report.first_nonfinite = report.first_nonfinite.or(first_nonfinite);
        report.nonfinite += nonfinite;
        report.negative += negative;
    }
}

/// Refuses a picture of another shape or larger than the caller allows, before memory is asked for.
pub(crate) fn check_size(width: u64, height: u64, limits: Limits, name: &str) -> Result<(usize, usize), EnvError> {
    if width == 0 || height == 0 {
        return Err(invalid(name, format!("the picture has no texels: it is {width} x {height}")));
    }
    if width.checked_mul(height).is_none_or(|texels| texels > limits.max_texels as u64) {
        let limit = limits.max_texels;
        let message = format!("the picture is {width} x {height}, more than the limit of {limit} texels");
        return Err(EnvError::Refused { file: name.into(), message, option: ReadOption::MaxTexels });
    }
    if limits.shape == Shape::Cube && height != 6 * width {
        let message = format!("a cube map is six times as high as wide, but this picture is {width} x {height}");
        return Err(invalid(name, message));
    }
    if matches!(limits.shape, Shape::LatLong | Shape::Said) && width != 2 * height {
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
    EnvError::Invalid { file: name.into(), message: one_line(message) }
}

pub(crate) fn unsupported(name: &str, message: String) -> EnvError {
    EnvError::Unsupported { file: name.into(), message: one_line(message) }
}

/// A message in one line of bounded length: decoders repeat what they find in a file.
fn one_line(message: String) -> String {
    if message.len() <= MAX_MESSAGE && !message.contains(char::is_control) {
        return message;
    }
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    let mut line: String = message.trim_end().chars().take(MAX_MESSAGE).map(printable).collect();
    if message.chars().nth(MAX_MESSAGE).is_some() {
        line.push_str("...");
    }
    line
}
