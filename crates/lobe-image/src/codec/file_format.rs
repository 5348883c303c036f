//! Formats of picture files: one table, which readers, writers, messages, help and the fronts go by.

use std::fmt;
use std::path::Path;

use lobe_io::{either, named_endings};

use crate::codec::{read_exr, read_hdr, read_jpeg, read_ldr, read_pfm, read_tiff};
use crate::error::ImageError;
use crate::header::decoded::{Decoded, invalid, unsupported};
use crate::header::png_color::to_linear_light;

/// Bytes of an unknown file that a message shows; enough to identify any format.
pub(crate) const SHOWN_BYTES: usize = 24;

/// A file format, detected from the contents whatever the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub enum FileFormat {
    /// OpenEXR, `.exr`.
    OpenExr,
    /// Radiance picture, usually `.hdr`.
    Radiance,
    /// Portable float map, `.pfm`.
    Pfm,
    /// TIFF picture.
    Tiff,
    /// PNG picture, 8 or 16 bits.
    Png,
    /// JPEG picture, with or without a gain map.
    Jpeg,
    /// JPEG XL picture, with the feature `jxl`.
    JpegXl,
    /// KTX2 texture.
    Ktx2,
    /// KTX texture of version 1.
    Ktx,
    /// DDS texture.
    Dds,
}

/// Decodes the bytes of a file, which has this name, into at most so many texels.
type Decode = fn(&[u8], &str, usize) -> Result<Decoded, ImageError>;

/// A row of the table.
struct Row {
    name: &'static str,
    /// Endings of names, the most common first.
    endings: &'static [&'static str],
    /// First bytes, of which a file has one.
    begins: &'static [&'static [u8]],
    /// None for textures, which are read level by level.
    decode: Option<Decode>,
    /// Whether pictures in linear light are written in it.
    is_written: bool,
}

impl FileFormat {
    /// All formats, in the order of messages.
    pub const ALL: [Self; 10] = [
        Self::OpenExr,
        Self::Radiance,
        Self::Pfm,
        Self::Tiff,
        Self::Png,
        Self::Jpeg,
        Self::JpegXl,
        Self::Ktx2,
        Self::Ktx,
        Self::Dds,
    ];

    fn row(self) -> Row {
        match self {
            Self::OpenExr => Row {
                name: "OpenEXR",
                endings: &["exr"],
                begins: &[b"\x76\x2f\x31\x01"],
                decode: Some(read_exr::decode),
                is_written: true,
            },
            Self::Radiance => Row {
                name: "Radiance .hdr",
                endings: &["hdr"],
                begins: &[b"#?"],
                decode: Some(read_hdr::decode),
                is_written: true,
            },
            Self::Pfm => Row {
                name: "portable float map",
                endings: &["pfm"],
                begins: &[b"PF", b"Pf"],
                decode: Some(read_pfm::decode),
                is_written: true,
            },
            // Of both byte orders, with offsets of 32 and of 64 bits.
            Self::Tiff => Row {
                name: "TIFF",
                endings: &["tif", "tiff"],
                begins: &[b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"],
                decode: Some(read_tiff::decode),
                is_written: false,
            },
            Self::Png => Row {
                name: "PNG",
                endings: &["png"],
                begins: &[b"\x89PNG\r\n\x1a\n"],
                decode: Some(read_ldr::decode_png),
                is_written: false,
            },
            Self::Jpeg => Row {
                name: "JPEG",
                endings: &["jpg", "jpeg"],
                begins: &[b"\xff\xd8\xff"],
                decode: Some(read_jpeg::decode),
                is_written: false,
            },
            Self::JpegXl => Row {
                name: "JPEG XL",
                endings: if cfg!(feature = "jxl") { &["jxl"] } else { &[] },
                begins: &[b"\xff\x0a", b"\0\0\0\x0cJXL \r\n\x87\n"],
                decode: Some(decode_jpeg_xl),
                is_written: false,
            },
            // Shorter than their marks: a file may be truncated within these; then the decoder reports it.
            Self::Ktx2 => {
                Row { name: "KTX2", endings: &["ktx2"], begins: &[b"\xabKTX 2"], decode: None, is_written: false }
            }
            Self::Ktx => {
                Row { name: "KTX", endings: &["ktx"], begins: &[b"\xabKTX 1"], decode: None, is_written: false }
            }
            Self::Dds => Row { name: "DDS", endings: &["dds"], begins: &[b"DDS "], decode: None, is_written: false },
        }
    }

    /// Endings of the names of its files, in lower case, the most common first; none if this program was built without
    /// its reader.
    #[must_use]
    pub fn endings(self) -> &'static [&'static str] {
        self.row().endings
    }

    /// The format that the ending of a name stands for.
    #[must_use]
    pub fn of_name(path: impl AsRef<Path>) -> Option<Self> {
        let ending = path.as_ref().extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.endings().contains(&&*ending))
    }

    /// Whether files of this format hold textures: cubes ([`read_cube_texture_bytes`](crate::read_cube_texture_bytes)),
    /// or pictures.
    #[must_use]
    pub fn is_texture(self) -> bool {
        self.row().decode.is_none()
    }

    /// Whether pictures in linear light are written in this format ([`write_picture`](crate::write_picture)).
    #[must_use]
    pub fn is_written(self) -> bool {
        self.row().is_written
    }

    /// The most common ending of each of some formats, as a sentence has them: `.exr, .hdr or .pfm`.
    #[must_use]
    pub fn names(of: impl Fn(Self) -> bool) -> String {
        named_endings(
            Self::ALL.into_iter().filter(|format| of(*format)).filter_map(|format| format.endings().first().copied()),
        )
    }

    /// Detects the format from the first bytes; `name` stands for the file in messages.
    ///
    /// # Errors
    /// [`ImageError::Unsupported`] if it is a picture in another format, [`ImageError::Invalid`] if it is none.
    pub fn of_bytes(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        let word_ends = |begin: &[u8]| !begin.starts_with(b"P") || bytes.get(2).is_none_or(u8::is_ascii_whitespace);
        let is_of = |begin: &&[u8]| bytes.starts_with(begin) && word_ends(begin);
        if let Some(format) = Self::ALL.into_iter().find(|format| format.row().begins.iter().any(is_of)) {
            return Ok(format);
        }
        let expected = either(&Self::ALL.map(|format| format.row().name));
        if bytes.is_empty() {
            return Err(invalid(name, format!("the file is empty; {expected} expected")));
        }
        if let Some((other, what_to_do)) = other_picture(bytes) {
            return Err(unsupported(name, format!("{expected} expected, found {other}; {what_to_do}")));
        }
        Err(invalid(name, format!("{expected} expected, found {}", describe(bytes))))
    }

    /// Decodes a picture of this format.
    pub(crate) fn decode(self, bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
        match self.row().decode {
            Some(decode) => decode(bytes, name, max_texels),
            None => {
                let message = format!("a picture expected, found a texture ({self}), which may hold a cube map");
                Err(unsupported(name, message))
            }
        }
    }
}

impl fmt::Display for FileFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row().name)
    }
}

#[cfg(feature = "jxl")]
use crate::codec::read_jxl::decode as decode_jpeg_xl;

#[cfg(not(feature = "jxl"))]
fn decode_jpeg_xl(_: &[u8], name: &str, _: usize) -> Result<Decoded, ImageError> {
    let message = "a JPEG XL picture, which this program was built without (feature `jxl`); convert it with `djxl IN.jxl OUT.pfm`";
    Err(unsupported(name, message.into()))
}

/// Another picture format that is easily mistaken for a supported one: its name, and what to do.
fn other_picture(bytes: &[u8]) -> Option<(&'static str, String)> {
    const CONVERT: &str = "convert it to .hdr or .exr";
    const KINDS: [(&[u8], &str, &str); 2] = [
        (b"GIF8", "a GIF picture", CONVERT),
        (b"RIFF", "a RIFF file (WebP?)", "convert it: `dwebp IN.webp -o OUT.png`"),
    ];
    if let Some([b'f', b't', b'y', b'p', brand @ ..]) = bytes.get(4..12) {
        let kind = match brand {
            b"avif" | b"avis" => "an AVIF picture",
            b"heic" | b"heix" | b"heim" | b"heis" | b"mif1" | b"msf1" => "a HEIF picture (HEIC or AVIF)",
            _ => "a film or a picture in a container of ISO 14496-12",
        };
        return Some((kind, format!("convert it: {}", to_linear_light("IN"))));
    }
    KINDS
        .iter()
        .find(|(magic, ..)| bytes.starts_with(magic))
        .map(|&(_, kind, what_to_do)| (kind, what_to_do.to_owned()))
}

/// The first bytes of an unknown file, in one line.
fn describe(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(SHOWN_BYTES)];
    let printable = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    if start.iter().all(printable) {
        format!("text beginning with {:?}", String::from_utf8_lossy(start))
    } else {
        format!("unknown data beginning with the bytes {:02x?}", &start[..start.len().min(8)])
    }
}
