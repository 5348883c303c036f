//! Pictures of scene files: PNG, JPEG, WebP, and KTX2 with Basis Universal textures.

use std::fmt::Display;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use image::{ImageError, ImageReader, Limits};

use crate::files::source::Source;
use crate::{SceneError, Texture, Wrap};

const KTX2: &[u8] = &[0xAB, b'K', b'T', b'X', b' ', b'2', b'0'];

/// The number that a KTX2 has for the compression of its levels by Zstandard.
const ZSTANDARD: u32 = 2;

/// Decodes a texture; `name` stands in messages.
pub(crate) fn decode(
    bytes: &[u8],
    name: &str,
    wrap: [Wrap; 2],
    source: &mut Source<'_>,
) -> Result<Texture, SceneError> {
    let (width, height, texels) =
        if bytes.starts_with(KTX2) { decode_ktx2(bytes, name, source)? } else { decode_picture(bytes, name, source)? };
    if texels.is_empty() {
        return Err(source.invalid(format!("{name}: a picture without texels")));
    }
    Ok(Texture::new(width as usize, height as usize, texels, wrap))
}

type Texels = (u32, u32, Vec<[u8; 4]>);

fn decode_picture(bytes: &[u8], name: &str, source: &mut Source<'_>) -> Result<Texels, SceneError> {
    let file = || ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let invalid = |error: &dyn Display, source: &Source<'_>| {
        source.invalid(format!("{name}: expected a PNG, JPEG, WebP or KTX2, found {error}"))
    };
    let size = file().map_err(ImageError::from).and_then(ImageReader::into_dimensions);
    let (width, height) = size.map_err(|error| invalid(&error, source))?;
    source.count_texels(width, height)?;
    let texels = u64::from(width) * u64::from(height);
    // A texel that is kept takes four bytes; decoding takes up to eight for its four numbers, and four for its bytes.
    source.check_bytes(texels.saturating_mul(8 + 4))?;
    let mut limits = Limits::default();
    // The limit of texels is ours; what a decoder takes beside them stays below the limit of the library.
    limits.max_alloc = limits.max_alloc.map(|bytes| bytes.saturating_add(texels.saturating_mul(16)));
    let picture = file().map_err(ImageError::from).and_then(|mut reader| {
        reader.limits(limits);
        reader.decode()
    });
    let picture = picture.map_err(|error| invalid(&error, source))?.into_rgba8();
    Ok((picture.width(), picture.height(), picture.pixels().map(|pixel| pixel.0).collect()))
}

/// The first level of a Basis Universal texture, the only kind that glTF allows in KTX2.
fn decode_ktx2(bytes: &[u8], name: &str, source: &mut Source<'_>) -> Result<Texels, SceneError> {
    let size = |at: usize| bytes.get(at..at + 4).and_then(|word| word.try_into().ok()).map_or(0, u32::from_le_bytes);
    // The header has the identifier, the format, the size of its type at 16, width, height, depth, layers, faces, levels
    // and at 44 the compression; at 80 where the first level is, its length, and at 96 its length when decompressed.
    let (width, height) = (size(20), size(24));
    source.count_texels(width, height)?;
    if size(32) > 1 || size(36) > 1 {
        return Err(source.invalid(format!("{name}: expected a plain picture in the KTX2, found layers or faces")));
    }
    // The library allocates what a level compressed by Zstandard claims: sixteen bytes for each block of 4 x 4.
    let most = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4)) * 16;
    let claimed = u64::from(size(100)) << 32 | u64::from(size(96));
    if size(44) == ZSTANDARD && claimed > most {
        let message = format!("{name}: expected at most {most} bytes in the first level of the KTX2, found {claimed}");
        return Err(source.invalid(message));
    }
    source.check_bytes(most)?;
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let texture = Transcoder::new(bytes).ok()?;
        texture.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).ok()
    }));
    match decoded {
        Ok(Some(texels)) if texels.len() as u64 == 4 * u64::from(width) * u64::from(height) => {
            Ok((width, height, texels.as_chunks().0.to_vec()))
        }
        _ => Err(source.unsupported(format!(
            "{name}: expected a Basis Universal texture in the KTX2: convert it with `ktx extract --level 0 IN OUT.png`"
        ))),
    }
}
