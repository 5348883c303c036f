//! KTX1 cube map writer, for Filament and `PlayCanvas`, which read no floats from KTX2.
//!
//! ```text
//!   identifier                  12 bytes
//!   thirteen numbers            little-endian
//!   keys and values             sh, nine colors of a light, where they are given
//!   levels                      the largest first; in each the bytes of one face, then the faces +X, -X, +Y, -Y, +Z, -Z
//! ```
//!
//! KTX File Format Specification 1.0. The texels are R11G11B10F. As type it has the number of the internal format, not
//! that of the packed type: Filament's own tool writes it so, and its reader takes nothing else.

use crate::texture::read_ktx1::KTX;
use crate::texture::read_ktx1::{ENDIANNESS, R11F_G11F_B10F, RGB, SH_KEY};

/// Bytes of a texel.
const TEXEL: u32 = 4;

/// The pieces of the file in order, from the encoded faces of all levels, the largest first, and the colors of its key
/// `sh`.
pub(crate) fn pieces(size: usize, levels: Vec<[Vec<u8>; 6]>, sh: Option<&[[f64; 3]; 9]>) -> Vec<Vec<u8>> {
    let (side, count) = (size as u32, levels.len() as u32);
    let entries = sh.map(entry).unwrap_or_default();
    let (depth, elements, faces, keys) = (0, 0, 6, entries.len() as u32);
    let numbers =
        [ENDIANNESS, R11F_G11F_B10F, TEXEL, RGB, R11F_G11F_B10F, RGB, side, side, depth, elements, faces, count, keys];
    let mut pieces = vec![KTX.to_vec(), numbers.map(u32::to_le_bytes).concat(), entries];
    for faces in levels {
        pieces.push((faces[0].len() as u32).to_le_bytes().to_vec());
        pieces.extend(faces);
    }
    pieces
}

/// The entry of nine colors, preceded by its length and padded to four bytes.
fn entry(sh: &[[f64; 3]; 9]) -> Vec<u8> {
    let lines: String = sh.iter().map(|[r, g, b]| format!("{r:?} {g:?} {b:?}\n")).collect();
    let text = format!("{SH_KEY}\0{lines}\0");
    let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
    bytes.extend(text.into_bytes());
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}
