//! Textures in a KTX2, KTX or DDS file: six square faces with mip levels, or one picture.

use std::path::Path;

use lobe_io::{parallel, write_atomically};

use crate::codec::encode::PictureWriteReport;
use crate::codec::encode::share_beyond;
use crate::codec::file_format::FileFormat;
use crate::codec::read::{PictureReadOptions, PictureReadReport, finished, guarded, inspect, picture_file_bytes};
use crate::error::ImageError;
use crate::header::decoded::unsupported;
use crate::picture::picture::Picture;
use crate::pixel::{IntoPixel, Pixel};
use crate::texture::cube_texture::CubeTexture;
use crate::texture::stored_texture::{FACES, StoredTexture};
use crate::texture::texel_format::TexelFormat;
use crate::texture::{dds, read_ktx1, read_ktx2, write_ktx1, write_ktx2};

/// Reads a cube texture from a KTX2, KTX or DDS file.
///
/// * **KTX2**: RGBA16F, RGBA32F, RGB16F, RGB32F, RGB9E5, R11G11B10F, BC6H with and without sign, and bytes of three or
///   four channels, stored as they are or with Zstandard, any number of levels. Alpha is ignored.
/// * **KTX**, version 1: the same formats, of either byte order.
/// * **DDS**: RGBA16F, RGBA32F, RGB32F, RGB9E5, R11G11B10F and BC6H, with the header of Direct3D 10 or, for RGBA16F and
///   RGBA32F, without it.
///
/// An array of six squares is taken for a cube. A texture of one picture is read by [`read_texture_picture_bytes`].
///
/// # Errors
/// [`ImageError::Io`] if the file cannot be read; [`ImageError::Invalid`] if it is damaged or cut off; [`ImageError::Refused`] if its largest level has more
/// texels than [`PictureReadOptions::max_texels`] or `max_bytes` allows, or there are non-finite texels that the options do not allow;
/// [`ImageError::Unsupported`] if it holds no cube, or one in a form that is not read.
pub fn read_cube_texture(
    path: impl AsRef<Path>,
    options: &PictureReadOptions,
) -> Result<(CubeTexture, PictureReadReport), ImageError> {
    let (name, bytes) = picture_file_bytes(path, options)?;
    read_cube_texture_bytes(&bytes, &name, options)
}

/// Reads a cube texture from the bytes of a file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_cube_texture`], except [`ImageError::Io`].
pub fn read_cube_texture_bytes(
    bytes: &[u8],
    name: &str,
    options: &PictureReadOptions,
) -> Result<(CubeTexture, PictureReadReport), ImageError> {
    let format = FileFormat::of_bytes(bytes, name)?;
    if !format.is_texture() {
        let message = format!("a cube map in KTX2, KTX, DDS or OpenEXR expected, found a {format} picture");
        return Err(unsupported(name, message));
    }
    let decoded = options.blame(guarded(format, name, || {
        let texture = Texture::header(format, bytes, name, options.most_texels())?;
        if texture.stored().is_cube() { texture.decode(bytes, usize::MAX, name).map(Some) } else { Ok(None) }
    }))?;
    let Some((stored, levels)) = decoded else {
        return Err(unsupported(
            name,
            format!("a cube map of 6 faces expected, found a {format} texture of one picture"),
        ));
    };
    let mut decoded = stored.cube(levels);
    let size = decoded.levels.first().map_or(0, |(size, _)| *size);
    let mut report = PictureReadReport::new(size, size, format, std::mem::take(&mut decoded.notes));
    report.levels = decoded.levels.len();
    report.mapping = decoded.mapping.take();
    report.notes.insert(0, format!("the texels are {}", decoded.format));
    if let Some((primaries, chromaticities)) = decoded.primaries.take() {
        let done = match chromaticities {
            Some(chromaticities) if options.to_rec_709 => {
                decoded.levels.iter_mut().for_each(|(_, texels)| chromaticities.convert(texels));
                "they are converted to those of Rec. 709"
            }
            None if options.to_rec_709 => "how they are converted is not known",
            _ => "the values are taken as they are",
        };
        report.notes.push(format!("the primaries are {primaries}, not those of Rec. 709; {done}"));
    }
    for (size, texels) in &mut decoded.levels {
        inspect(texels, *size, 0, &mut report);
    }
    report.judge(options.nonfinite, name)?;
    Ok((decoded, report))
}

/// Whether the bytes of a texture hold a cube, or an array that is taken for one, and not a single picture; `name`
/// stands for the file in messages.
///
/// # Errors
/// Those of the headers, as [`read_cube_texture`].
pub fn is_cube_texture_bytes(bytes: &[u8], name: &str, options: &PictureReadOptions) -> Result<bool, ImageError> {
    let format = FileFormat::of_bytes(bytes, name)?;
    guarded(format, name, || Ok(Texture::header(format, bytes, name, options.max_texels)?.stored().is_cube()))
}

/// Reads the largest level of a texture of one picture from the bytes of a KTX2, KTX or DDS file; `name` stands for the
/// file in messages. The texel formats are those of [`read_cube_texture`].
///
/// # Errors
/// As [`read_cube_texture`], except [`ImageError::Io`]; [`ImageError::Unsupported`] if it holds a cube.
pub fn read_texture_picture_bytes(
    bytes: &[u8],
    name: &str,
    options: &PictureReadOptions,
) -> Result<(Picture, PictureReadReport), ImageError> {
    let format = FileFormat::of_bytes(bytes, name)?;
    let decoded = guarded(format, name, || {
        let texture = Texture::header(format, bytes, name, options.most_texels())?;
        if texture.stored().is_cube() {
            return Err(unsupported(name, format!("a picture expected, found a cube map in a {format} texture")));
        }
        let (stored, mut levels) = texture.decode(bytes, 1, name)?;
        Ok(stored.picture(levels.swap_remove(0)))
    });
    finished(decoded, format, name, options)
}

/// A texture whose headers are read, and where its texels begin if its container has no index.
enum Texture {
    Ktx2(StoredTexture),
    Ktx1(StoredTexture, read_ktx1::Places),
    Dds(StoredTexture, usize),
}

impl Texture {
    fn header(format: FileFormat, bytes: &[u8], name: &str, max_texels: usize) -> Result<Self, ImageError> {
        Ok(match format {
            FileFormat::Ktx2 => Self::Ktx2(read_ktx2::header(bytes, name, max_texels)?),
            FileFormat::Ktx => {
                let (stored, places) = read_ktx1::header(bytes, name, max_texels)?;
                Self::Ktx1(stored, places)
            }
            FileFormat::Dds => {
                let (stored, data) = dds::header(bytes, name, max_texels)?;
                Self::Dds(stored, data)
            }
            other => return Err(unsupported(name, format!("a texture in KTX2, KTX or DDS expected, found {other}"))),
        })
    }

    fn stored(&self) -> &StoredTexture {
        let (Self::Ktx2(stored) | Self::Ktx1(stored, _) | Self::Dds(stored, _)) = self;
        stored
    }

    /// Decodes the largest levels, as many as there are or `most`.
    fn decode(self, bytes: &[u8], most: usize, name: &str) -> Result<(StoredTexture, Vec<Vec<Pixel>>), ImageError> {
        let count = self.stored().levels.min(most);
        let (stored, levels) = match self {
            Self::Ktx2(stored) => {
                let levels = (0..count).map(|k| read_ktx2::level(&stored, bytes, k, name)).collect();
                (stored, levels)
            }
            Self::Ktx1(stored, places) => {
                let levels = read_ktx1::levels(&stored, &places, bytes, count, name);
                (stored, levels)
            }
            Self::Dds(mut stored, data) => {
                let levels = dds::levels(&mut stored, bytes.get(data..).unwrap_or_default(), count, name);
                (stored, levels)
            }
        };
        Ok((stored, levels?))
    }
}

/// What a texture file keeps beside its texels, each where the format has room for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureNotes<'a> {
    /// Of `.ktx2`: the name of a mapping of directions, so that a reader finds it again
    /// ([`PictureReadReport::mapping`]).
    pub mapping: Option<&'a str>,
    /// Of `.ktx`: nine colors under the key `sh`, the light of diffuse surfaces as Filament reads it; [`ktx_sh`] reads
    /// them.
    pub sh: Option<[[f64; 3]; 9]>,
}

/// Writes a cube texture as `.ktx2`, `.dds` or `.ktx` (version 1, R11G11B10F only, for Filament and `PlayCanvas`),
/// depending on the extension: size and texels of each level, as in [`CubeTexture`].
///
/// No partial file ever has the final name. Channels outside the range of the texel format are clamped to it, and
/// counted over all levels. `zstd` compresses `.ktx2` without loss.
///
/// # Errors
/// [`ImageError::Options`] for another extension, Zstandard outside of `.ktx2`, or a format that is not written;
/// [`ImageError::Io`] if the file cannot be written.
pub fn write_cube_texture(
    path: impl AsRef<Path>,
    levels: &[(usize, &[impl IntoPixel])],
    format: TexelFormat,
    zstd: bool,
    notes: &TextureNotes<'_>,
) -> Result<PictureWriteReport, ImageError> {
    let path = path.as_ref();
    let (pieces, report) = pieces_of(path, levels, format, zstd, notes)?;
    let io = |source| ImageError::Io { place: path.display().to_string(), source };
    write_atomically(path, |file| pieces.iter().try_for_each(|piece| file.write_all(piece))).map_err(io)?;
    Ok(report)
}

/// The bytes that [`write_cube_texture`] writes; the extension of the path says the format.
///
/// # Errors
/// As [`write_cube_texture`], except [`ImageError::Io`].
pub fn encode_cube_texture(
    path: &Path,
    levels: &[(usize, &[impl IntoPixel])],
    format: TexelFormat,
    zstd: bool,
    notes: &TextureNotes<'_>,
) -> Result<(Vec<u8>, PictureWriteReport), ImageError> {
    let (pieces, report) = pieces_of(path, levels, format, zstd, notes)?;
    Ok((pieces.concat(), report))
}

/// The pieces of a file in order.
fn pieces_of(
    path: &Path,
    levels: &[(usize, &[impl IntoPixel])],
    format: TexelFormat,
    zstd: bool,
    notes: &TextureNotes<'_>,
) -> Result<(Vec<Vec<u8>>, PictureWriteReport), ImageError> {
    let wrong = |message: String| ImageError::Options(format!("{}: {message}", path.display()));
    let container = FileFormat::of_name(path).filter(|container| container.is_texture());
    let Some(container) = container else {
        return Err(wrong(format!("a cube map is written as {}", FileFormat::names(FileFormat::is_texture))));
    };
    if zstd && container != FileFormat::Ktx2 {
        return Err(wrong(format!("a {container} file holds no Zstandard; write .ktx2")));
    }
    if container == FileFormat::Ktx && format != TexelFormat::R11G11B10F {
        return Err(wrong(format!("a .ktx holds R11G11B10F, not {format}; write .ktx2")));
    }
    let Some((size, _)) = levels.first() else { return Err(wrong("a cube map needs at least one level".into())) };
    let mut report = PictureWriteReport::default();
    let mut encoded = Vec::with_capacity(levels.len());
    for (size, texels) in levels {
        let (faces, clamped) = encode_level(*size, texels, format).map_err(wrong)?;
        report.clamped += clamped;
        encoded.push(faces);
    }
    if report.clamped > 0 {
        report.lost = share_beyond(levels[0].1, format.largest());
    }
    let io = |source| ImageError::Io { place: path.display().to_string(), source };
    let pieces = match container {
        FileFormat::Ktx2 => write_ktx2::pieces(*size, format, encoded, zstd, notes.mapping).map_err(io)?,
        FileFormat::Ktx => write_ktx1::pieces(*size, encoded, notes.sh.as_ref()),
        _ => dds::pieces(*size, format, encoded),
    };
    Ok((pieces, report))
}

/// The nine colors under the key `sh` of a KTX file; none if it has no such key. `name` stands for the file in
/// messages.
///
/// # Errors
/// [`ImageError::Invalid`] if this is no KTX file, it is cut off, or the key holds anything but nine colors.
pub fn ktx_sh(bytes: &[u8], name: &str) -> Result<Option<[[f64; 3]; 9]>, ImageError> {
    read_ktx1::sh(bytes, name)
}

/// The six faces of a level, encoded in parallel, and the number of its texels that were clamped.
fn encode_level(
    size: usize,
    texels: &[impl IntoPixel],
    format: TexelFormat,
) -> Result<([Vec<u8>; FACES], usize), String> {
    let area = size * size;
    if texels.len() != FACES * area {
        return Err(format!("6 faces of {size} x {size} texels expected, {} texels given", texels.len()));
    }
    let faces = parallel::map(FACES, &|f| format.encode_face(size, &texels[f * area..][..area]));
    let mut encoded: [Vec<u8>; FACES] = Default::default();
    let mut clamped = 0;
    for (out, face) in encoded.iter_mut().zip(faces) {
        let (bytes, count) = face?;
        *out = bytes;
        clamped += count;
    }
    Ok((encoded, clamped))
}
