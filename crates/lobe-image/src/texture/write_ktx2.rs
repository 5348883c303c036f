//! KTX2 cube map writer.
//!
//! ```text
//!   header                      80 bytes
//!   index of the levels         24 bytes each, the largest level first
//!   data format descriptor
//!   keys and values             KTXorientation = rd, KTXwriter, and lobe-mapping where one is given
//!   levels                      the smallest first; in each the faces +X, -X, +Y, -Y, +Z, -Z
//! ```
//!
//! KTX File Format Specification 2.0, sections 3 and 5. Uncompressed levels begin at multiples of their texel block.

use std::io;

use ktx2::dfd::{Basic, Block};
use ktx2::{Header, Index, LevelIndex, SupercompressionScheme};

use crate::picture::png::MAPPING_KEY;
use crate::texture::texel_format::TexelFormat;

/// The level of Zstandard. On a real sky in RGBA16F, 67 MB: level 1 gives 41 MB in 0.7 s, 3 gives 35 MB in 3.3 s, 9
/// gives 34 MB in 8 s.
const ZSTD_LEVEL: i32 = 3;

/// The pieces of the file in order, from the encoded faces of all levels, the largest first.
pub(crate) fn pieces(
    size: usize,
    format: TexelFormat,
    levels: Vec<[Vec<u8>; 6]>,
    zstd: bool,
    mapping: Option<&str>,
) -> io::Result<Vec<Vec<u8>>> {
    let (descriptor, type_size) = Basic::from_format(format.vulkan()).map_err(io::Error::other)?;
    let descriptor = Block::Basic(descriptor).to_vec();
    let keys = keys_and_values(mapping);
    let dfd = Header::LENGTH + levels.len() * LevelIndex::LENGTH;
    // The descriptor is preceded by its total length, which counts itself.
    let kvd = dfd + 4 + descriptor.len();
    let header = Header {
        format: Some(format.vulkan()),
        type_size,
        pixel_width: size as u32,
        pixel_height: size as u32,
        pixel_depth: 0,
        layer_count: 0,
        face_count: 6,
        level_count: levels.len() as u32,
        supercompression_scheme: zstd.then_some(SupercompressionScheme::Zstandard),
        index: Index {
            dfd_byte_offset: dfd as u32,
            dfd_byte_length: (kvd - dfd) as u32,
            kvd_byte_offset: kvd as u32,
            kvd_byte_length: keys.len() as u32,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(dfd, 0);
    bytes.extend(((kvd - dfd) as u32).to_le_bytes());
    bytes.extend(descriptor);
    bytes.extend(keys);
    let alignment = if zstd { 1 } else { format.block_bytes() };
    let (mut length, mut data) = (bytes.len(), Vec::new());
    for (k, faces) in levels.into_iter().enumerate().rev() {
        let uncompressed_byte_length = bytes_of(&faces);
        let stored = if zstd { vec![zstd::bulk::compress(&faces.concat(), ZSTD_LEVEL)?] } else { Vec::from(faces) };
        let padding = length.next_multiple_of(alignment) - length;
        let entry = LevelIndex {
            byte_offset: (length + padding) as u64,
            byte_length: bytes_of(&stored),
            uncompressed_byte_length,
        };
        bytes[Header::LENGTH + k * LevelIndex::LENGTH..][..LevelIndex::LENGTH].copy_from_slice(&entry.as_bytes());
        length += padding + entry.byte_length as usize;
        data.push(vec![0; padding]);
        data.extend(stored);
    }
    data.insert(0, bytes);
    Ok(data)
}

fn bytes_of(pieces: &[Vec<u8>]) -> u64 {
    pieces.iter().map(|piece| piece.len() as u64).sum()
}

/// The entries in the order of their keys, each preceded by its length and padded to four bytes.
fn keys_and_values(mapping: Option<&str>) -> Vec<u8> {
    let writer = concat!("lobe ", env!("CARGO_PKG_VERSION"));
    let mut bytes = Vec::new();
    let mapping = mapping.map(|mapping| (MAPPING_KEY, mapping));
    for (key, value) in [("KTXorientation", "rd"), ("KTXwriter", writer)].into_iter().chain(mapping) {
        let entry = format!("{key}\0{value}\0");
        bytes.extend((entry.len() as u32).to_le_bytes());
        bytes.extend(entry.into_bytes());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}
