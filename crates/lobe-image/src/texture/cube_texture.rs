//! Cube textures as files hold them: six faces of each level, and the sizes of levels.

use crate::error::{ImageError, ReadOption};
use crate::header::decoded::invalid;
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;
use crate::texture::texel_format::TexelFormat;

/// A cube texture as stored in a file: size and texels of each level, face after face (+X, -X, +Y, -Y, +Z, -Z), row
/// after row, the largest level first.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeTexture {
    /// The texel format.
    pub format: TexelFormat,
    /// The size of a face of each level, and its texels.
    pub levels: Vec<(usize, Vec<Pixel>)>,
    /// Remarks for the caller.
    pub(crate) notes: Vec<String>,
    /// The mapping that the file names.
    pub(crate) mapping: Option<String>,
    /// Primaries other than those of Rec. 709, by their name.
    pub(crate) primaries: Option<(String, Option<Primaries>)>,
}

/// Refuses a cube larger than the caller allows, before memory is allocated.
pub(crate) fn check_cube_size(size: u64, max_texels: usize, name: &str) -> Result<(), ImageError> {
    if size == 0 {
        return Err(invalid(name, "the cube map has no texels: its faces are 0 x 0".into()));
    }
    if size.checked_mul(size).and_then(|n| n.checked_mul(6)).is_none_or(|texels| texels > max_texels as u64) {
        let message = format!("the faces are {size} x {size}, all six more than the limit of {max_texels} texels");
        return Err(ImageError::Refused { place: name.into(), message, option: ReadOption::MaxTexels });
    }
    Ok(())
}

/// The size of mip level `k` of a texture: halved `k` times, rounded down, at least 1.
#[must_use]
pub fn mip_level_size(size: usize, k: usize) -> usize {
    size.checked_shr(k as u32).unwrap_or(0).max(1)
}

/// The number of levels from `size` down to 1.
#[must_use]
pub fn mip_level_count(size: usize) -> usize {
    size.max(1).ilog2() as usize + 1
}
