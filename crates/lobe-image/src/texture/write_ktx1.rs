//! KTX1 cube map writer, for Filament and `PlayCanvas`, which read no floats from KTX2.
//!
//! ```text
//!   identifier                  12 bytes
//!   thirteen numbers            little-endian
//!   keys and values             none
//!   levels                      the largest first; in each the bytes of one face, then the faces +X, -X, +Y, -Y, +Z, -Z
//! ```
//!
//! KTX File Format Specification 1.0. The texels are R11G11B10F. As type it has the number of the internal format, not
//! that of the packed type: Filament's own tool writes it so, and its reader takes nothing else.

use crate::texture::read_ktx1::KTX;
use crate::texture::read_ktx1::{ENDIANNESS, R11F_G11F_B10F, RGB};

/// Bytes of a texel.
const TEXEL: u32 = 4;

/// The pieces of the file in order, from the encoded faces of all levels, the largest first.
pub(crate) fn pieces(size: usize, levels: Vec<[Vec<u8>; 6]>) -> Vec<Vec<u8>> {
    let (side, count) = (size as u32, levels.len() as u32);
    let (depth, elements, faces, keys) = (0, 0, 6, 0);
    let numbers =
        [ENDIANNESS, R11F_G11F_B10F, TEXEL, RGB, R11F_G11F_B10F, RGB, side, side, depth, elements, faces, count, keys];
    let mut pieces = vec![KTX.to_vec(), numbers.map(u32::to_le_bytes).concat()];
    for faces in levels {
        pieces.push((faces[0].len() as u32).to_le_bytes().to_vec());
        pieces.extend(faces);
    }
    pieces
}
