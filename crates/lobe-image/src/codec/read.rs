//! Picture reader: detects the format of a file and decodes it.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use derive_setters::Setters;
use lobe_io::parallel;

use crate::codec::file_format::{FileFormat, SHOWN_BYTES};
use crate::error::{ImageError, ReadOption};
use crate::header::decoded::{Decoded, EnvmapAttribute, PictureHead, bounded, invalid, quoted};
use crate::picture::picture::Picture;
use crate::picture::primaries::Primaries;
use crate::pixel::{BLACK, Pixel};

/// The default of [`PictureReadOptions::max_texels`]: enough for 16384 x 8192 and for 23170 x 11585, 3 GiB in memory.
const MAX_TEXELS: usize = 1 << 28;

/// The treatment of texels with a channel of NaN or infinity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Nonfinite {
    /// Refuse the file.
    #[default]
    Error,
    /// Make the whole texel black and count it.
    Zero,
}

/// Options of reading a picture.
///
/// ```
/// use lobe_image::{Nonfinite, PictureReadOptions};
///
/// let options = PictureReadOptions::default().nonfinite(Nonfinite::Zero).max_texels(1 << 20);
/// assert_eq!(options.max_texels, 1 << 20);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct PictureReadOptions {
    /// The treatment of NaN and infinity; by default the file is refused.
    pub nonfinite: Nonfinite,
    /// The largest picture, in texels, for which memory is asked for; by default 2²⁸.
    pub max_texels: usize,
    /// The most bytes of a file that has to be read whole, and of its texels, each of which takes 12 in memory; by default 4 GiB. A
    /// longer file is refused by its length, before it is read. [`PictureRows`](crate::PictureRows) hold neither.
    pub max_bytes: u64,
    /// Convert a picture whose file declares other primaries to those of Rec. 709, the white adapted by Bradford's matrix;
    /// by default the values are taken as they are. Colors outside of the gamut get negative channels.
    pub to_rec_709: bool,
}

impl Default for PictureReadOptions {
    fn default() -> Self {
        let nonfinite = Nonfinite::default();
        Self { nonfinite, max_texels: MAX_TEXELS, max_bytes: Self::MAX_BYTES, to_rec_709: false }
    }
}

impl PictureReadOptions {
    /// The default of [`max_bytes`](Self::max_bytes): 4 GiB, half of the memory of the most common machines.
    pub const MAX_BYTES: u64 = 4 << 30;

    /// The texels of a picture that is held in memory.
    pub(crate) fn most_texels(&self) -> usize {
        usize::try_from(self.max_bytes / size_of::<Pixel>() as u64).map_or(self.max_texels, |n| n.min(self.max_texels))
    }

    /// Refuses a map of more texels than are held in memory, which would be made of a picture.
    ///
    /// # Errors
    /// [`ImageError::Refused`] by `max_texels` or `max_bytes`.
    #[doc(hidden)]
    pub fn check_made(&self, [width, height]: [usize; 2], place: &str) -> Result<(), ImageError> {
        let most = self.most_texels();
        if width.checked_mul(height).is_some_and(|texels| texels <= most) {
            return Ok(());
        }
        let message = format!("the whole map is {width} x {height}, more than the limit of {most} texels");
        self.blame(Err(ImageError::Refused { place: place.into(), message, option: ReadOption::MaxTexels }))
    }

    /// Names the option that keeps out a picture of more than [`most_texels`](Self::most_texels).
    pub(crate) fn blame<T>(&self, read: Result<T, ImageError>) -> Result<T, ImageError> {
        match read {
            Err(ImageError::Refused { place, message, option: ReadOption::MaxTexels })
                if self.most_texels() < self.max_texels =>
            {
                let message = format!("{message}, which take {} bytes", self.max_bytes);
                Err(ImageError::Refused { place, message, option: ReadOption::MaxBytes })
            }
            read => read,
        }
    }
}

/// The report of reading a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PictureReadReport {
    /// Columns; of a cube texture, those of a face.
    pub width: usize,
    /// Rows; of a cube texture, those of a face.
    pub height: usize,
    /// Levels of a cube texture; 1 for a picture.
    pub levels: usize,
    /// The kind of file.
    pub format: FileFormat,
    /// The attribute `envmap` of an OpenEXR file: an environment whose outer texels lie on the edges. The picture is as it is
    /// stored.
    pub envmap: Option<EnvmapAttribute>,
    /// The name of the mapping that the file keeps, see [`PictureWriteOptions::mapping`](crate::PictureWriteOptions).
    pub mapping: Option<String>,
    /// The properties of a panorama that XMP tells of, by their names in the namespace `GPano`: `ProjectionType`,
    /// `FullPanoWidthPixels` and others, as text. The picture is as it is stored.
    pub panorama: BTreeMap<String, String>,
    /// Texels with a NaN or infinite channel; they are black in the picture.
    pub nonfinite: usize,
    /// Column and row of the first of them; in a cube texture, of the faces of its level one above another.
    pub first_nonfinite: Option<(usize, usize)>,
    /// Texels with a negative channel; they are kept.
    pub negative: usize,
    /// Remarks for the caller: channels chosen, parts of the file ignored, factors applied.
    pub notes: Vec<String>,
}

impl PictureReadReport {
    /// All that was found in the file and may not be what was meant, a line each: the notes, texels that are no numbers, and last those that are negative.
    #[must_use]
    pub fn findings(&self) -> Vec<String> {
        let texels_are =
            |count: usize| if count == 1 { "1 texel is".to_owned() } else { format!("{count} texels are") };
        let mut all = self.notes.clone();
        if let Some((x, y)) = self.first_nonfinite {
            let texels = texels_are(self.nonfinite);
            all.push(format!("{texels} NaN or infinite, first at column {x}, row {y}; read as black"));
        }
        if self.negative > 0 {
            all.push(format!("{} negative in some channel; kept", texels_are(self.negative)));
        }
        all
    }
}

/// Reads a picture from a Radiance .hdr, OpenEXR, portable float map, TIFF, PNG or JPEG file, and with the feature
/// `jxl` from a JPEG XL file. Textures are read by
/// [`read_cube_texture`](crate::read_cube_texture) and
/// [`read_texture_picture_bytes`](crate::read_texture_picture_bytes).
///
/// The format is detected from the file's contents, not from its name.
///
/// * **Radiance**: flat, old and new run-length encoding, rows or columns from any side. `EXPOSURE` and `COLORCORR` are
///   divided out, so the values are radiance. Colors in XYZ become those of Radiance's own primaries, in watts.
///   Indented lines of the header are the history of the picture and change nothing.
/// * **OpenEXR**: `half` and `float` channels; every compression but HTJ2K; scan lines and tiles, of which the largest
///   level is read; the first part, and in it the first layer, that has channels `R`, `G`, `B` or else `Y`. Alpha
///   and all other channels are ignored. The picture is the display window; outside the data window it is black.
/// * **Portable float map**: color and gray, both byte orders, the scale of the header multiplied in.
/// * **TIFF**: gray and RGB of floating-point numbers, which are light, or of 8 and 16 bits, decoded from sRGB; without compression,
///   `PackBits`, LZW or Deflate. The first picture of the file.
/// * **PNG, JPEG**: 8 and 16 bits, decoded from sRGB, or as the chunk `cICP` or else `gAMA` of a PNG says; PQ and HLG are not
///   read. White is 1 and nothing is brighter, which a note says. A JPEG with a gain map (ISO 21496-1, Ultra HDR) has the light of a display
///   bright enough for all of it.
/// * **JPEG XL**, with the feature `jxl`: linear light. By PQ and HLG the luminance of diffuse white, 203 cd/m², is 1.
///
/// Primaries that are not those of Rec. 709 (`PRIMARIES` of Radiance, `chromaticities` of OpenEXR, `cICP`, `iCCP` or `cHRM` of PNG, the color
/// profile of JPEG and TIFF) are noted, or converted with [`PictureReadOptions::to_rec_709`].
///
/// # Errors
/// [`ImageError::Io`] if the file cannot be read; [`ImageError::Invalid`] if it is damaged, cut off or no such picture;
/// [`ImageError::Refused`] if it is larger than [`PictureReadOptions::max_texels`] or `max_bytes`, or has non-finite texels that
/// the options do not allow; [`ImageError::Unsupported`] if it is a kind of picture that Lobe does not read.
pub fn read_picture(
    path: impl AsRef<Path>,
    options: &PictureReadOptions,
) -> Result<(Picture, PictureReadReport), ImageError> {
    let (name, bytes) = picture_file_bytes(path, options)?;
    read_picture_bytes(&bytes, &name, options)
}

/// Reads a picture from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_picture`], except [`ImageError::Io`].
pub fn read_picture_bytes(
    bytes: &[u8],
    name: &str,
    options: &PictureReadOptions,
) -> Result<(Picture, PictureReadReport), ImageError> {
    let format = FileFormat::of_bytes(bytes, name)?;
    let max_texels = options.most_texels();
    let decoded = guarded(format, name, || format.decode(bytes, name, max_texels));
    finished(decoded, format, name, options)
}

/// A decoded picture as the options want it, and its report.
pub(crate) fn finished(
    decoded: Result<Decoded, ImageError>,
    format: FileFormat,
    name: &str,
    options: &PictureReadOptions,
) -> Result<(Picture, PictureReadReport), ImageError> {
    let Decoded { head, mut texels } = options.blame(decoded)?;
    let (width, height) = (head.width, head.height);
    let (mut report, to_convert) = PictureReadReport::of_head(head, format, name, options)?;
    if let Some(primaries) = to_convert {
        primaries.convert(&mut texels);
    }
    inspect(&mut texels, width, 0, &mut report);
    report.judge(options.nonfinite, name)?;
    Ok((Picture::new(width, height, texels)?, report))
}

/// The name of a picture file for messages, and its bytes; other files are refused by their first bytes.
///
/// # Errors
/// [`ImageError::Io`] if the file cannot be read, [`ImageError::Refused`] if it is longer than the options allow, and the errors of
/// [`FileFormat::of_bytes`].
#[doc(hidden)]
pub fn picture_file_bytes(
    path: impl AsRef<Path>,
    options: &PictureReadOptions,
) -> Result<(String, Vec<u8>), ImageError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let io = |source| ImageError::Io { place: name.clone(), source };
    let mut file = open_file(path).map_err(io)?;
    // Refuse an endless device, or a film of many gigabytes, by its first bytes.
    let mut bytes = Vec::new();
    file.by_ref().take(SHOWN_BYTES as u64).read_to_end(&mut bytes).map_err(io)?;
    FileFormat::of_bytes(&bytes, &name)?;
    let refused = |found: &str| {
        let message = format!("the file has {found} than the limit of {}", options.max_bytes);
        Err(ImageError::Refused { place: name.clone(), message, option: ReadOption::MaxBytes })
    };
    let length = file.metadata().map_err(io)?.len();
    if length > options.max_bytes {
        return refused(&format!("{length} bytes, more"));
    }
    // What is no file, a pipe perhaps, has no length.
    let rest = options.max_bytes.saturating_add(1).saturating_sub(bytes.len() as u64);
    file.take(rest).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > options.max_bytes {
        return refused("more bytes");
    }
    Ok((name, bytes))
}

/// Opens a file; a folder is refused with a message of its own on every system.
fn open_file(path: &Path) -> std::io::Result<File> {
    if fs::metadata(path)?.is_dir() {
        return Err(std::io::Error::other("this is a folder; give the name of a picture"));
    }
    File::open(path)
}

/// Runs a decoder. None promises never to panic on damaged bytes; a panic means that the file is invalid.
pub(crate) fn guarded<T>(
    format: FileFormat,
    name: &str,
    decode: impl FnOnce() -> Result<T, ImageError>,
) -> Result<T, ImageError> {
    catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(invalid(name, format!("the {format} data is damaged and cannot be decoded"))))
}

impl PictureReadReport {
    pub(crate) fn new(width: usize, height: usize, format: FileFormat, notes: Vec<String>) -> Self {
        let (levels, nonfinite, negative, notes) = (1, 0, 0, bounded(notes));
        let (envmap, mapping, first_nonfinite, panorama) = (None, None, None, BTreeMap::new());
        Self { width, height, levels, format, envmap, mapping, panorama, nonfinite, first_nonfinite, negative, notes }
    }

    /// The report of a picture before its texels, and its primaries if the texels are to be converted from them;
    /// refuses those that cannot be understood where they are.
    pub(crate) fn of_head(
        head: PictureHead,
        format: FileFormat,
        name: &str,
        options: &PictureReadOptions,
    ) -> Result<(Self, Option<Primaries>), ImageError> {
        let PictureHead { width, height, mut notes, envmap, mapping, panorama, primaries, unclear_primaries } = head;
        let mut to_convert = None;
        if let Some(unclear) = unclear_primaries.map(|what| quoted(&what)) {
            if options.to_rec_709 {
                let message = format!("{unclear} cannot be understood, so the colors cannot be converted");
                return Err(ImageError::Refused { place: name.into(), message, option: ReadOption::ToRec709 });
            }
            notes.push(format!("{unclear} cannot be understood; the values are taken as they are"));
        }
        if let Some((which, primaries)) = primaries.filter(|(_, primaries)| !primaries.are_rec_709()) {
            notes.push(if options.to_rec_709 {
                to_convert = Some(primaries);
                format!("{which} are converted to those of Rec. 709")
            } else {
                format!("{which} are not those of Rec. 709; the values are taken as they are")
            });
        }
        Ok((Self { envmap, mapping, panorama, ..Self::new(width, height, format, notes) }, to_convert))
    }

    /// Refuses non-finite texels where the options do.
    pub(crate) fn judge(&self, nonfinite: Nonfinite, name: &str) -> Result<(), ImageError> {
        match self.first_nonfinite {
            Some((x, y)) if nonfinite == Nonfinite::Error => {
                let texels = if self.nonfinite == 1 { "1 texel is" } else { &format!("{} texels are", self.nonfinite) };
                let message = format!("{texels} NaN or infinite, first at column {x}, row {y}");
                Err(ImageError::Refused { place: name.into(), message, option: ReadOption::Nonfinite })
            }
            _ => Ok(()),
        }
    }
}

/// Counts non-finite and negative texels of rows from `first_row` on, and sets non-finite ones to black.
pub(crate) fn inspect(texels: &mut [Pixel], width: usize, first_row: usize, report: &mut PictureReadReport) {
    // Of each suspicious row the place of its first non-finite texel, and the numbers of both kinds.
    let found = Mutex::new(Vec::new());
    parallel::rows(texels, width, &|y, row| {
        if !is_suspicious(row) {
            return;
        }
        let (mut first, mut nonfinite, mut negative) = (None, 0, 0);
        for (x, texel) in row.iter_mut().enumerate() {
            if !texel.iter().all(|c| c.is_finite()) {
                first = first.or(Some((first_row + y, x)));
                nonfinite += 1;
                *texel = BLACK;
            } else if texel.iter().any(|c| *c < 0.0) {
                negative += 1;
            }
        }
        found.lock().unwrap_or_else(PoisonError::into_inner).push((first, nonfinite, negative));
    });
    let found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    let first = found.iter().filter_map(|(first, _, _)| *first).min();
    report.first_nonfinite = report.first_nonfinite.or(first.map(|(y, x)| (x, y)));
    report.nonfinite += found.iter().map(|(_, nonfinite, _)| nonfinite).sum::<usize>();
    report.negative += found.iter().map(|(_, _, negative)| negative).sum::<usize>();
}

/// Whether any channel may be negative, NaN or infinite: the quick look at rows of which nearly none is.
fn is_suspicious(row: &[Pixel]) -> bool {
    let marks = |c: &f32| c.to_bits() | c.to_bits().wrapping_add(SMALLEST_EXPONENT);
    let bits = row.as_flattened().iter().fold(0, |bits, c| bits | marks(c));
    bits & SIGN != 0
}

/// The sign of an `f32`, and the smallest exponent: added to the largest, that of NaN and infinity, it makes the sign.
const SIGN: u32 = 1 << 31;
const SMALLEST_EXPONENT: u32 = 1 << 23;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_with_any_number_that_is_negative_or_none_are_looked_at_closely() {
        let plain = [0.0, f32::from_bits(1), f32::MIN_POSITIVE, 1.0, f32::MAX];
        for c in plain {
            assert!(!is_suspicious(&[[c; 3]; 5]), "{c:e}");
        }
        for c in [-f32::from_bits(1), -1.0, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, -f32::NAN] {
            for at in 0..15 {
                let mut row = [[1.0; 3]; 5];
                row[at / 3][at % 3] = c;
                assert!(is_suspicious(&row), "{c:e} at {at}");
            }
        }
    }

    #[test]
    fn a_decoder_that_panics_is_an_error_of_its_own_words() {
        let error = guarded::<()>(FileFormat::OpenExr, "a.exr", || panic!("of a test")).unwrap_err();
        // The tests of damaged files know panics by this ending.
        assert_eq!(error.to_string(), "a.exr: the OpenEXR data is damaged and cannot be decoded");
    }
}
