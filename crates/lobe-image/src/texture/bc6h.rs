//! BC6H decoding and encoding: blocks of 4 x 4 texels in 16 bytes, `half` without alpha.

use crate::pixel::{BLACK, Pixel};

/// Columns and rows of a block.
pub(crate) const BLOCK: usize = 4;

/// Bytes of a block.
pub(crate) const BLOCK_BYTES: usize = 16;

/// Channels of a decoded block.
const CHANNELS: usize = 3;

/// Decodes one row of blocks and appends the first `rows` of its four rows, of `size` columns each, to `texels`.
pub(crate) fn decode_blocks(blocks: &[u8], size: usize, rows: usize, signed: bool, texels: &mut Vec<Pixel>) {
    let start = texels.len();
    texels.resize(start + size * rows, BLACK);
    let out = &mut texels[start..];
    let mut decoded = [0f32; BLOCK * BLOCK * CHANNELS];
    for (b, block) in blocks.as_chunks::<BLOCK_BYTES>().0.iter().enumerate() {
        bcdec_rs::bc6h_float(block, &mut decoded, BLOCK * CHANNELS, signed);
        let left = b * BLOCK;
        for (i, rgb) in decoded.as_chunks::<CHANNELS>().0.iter().enumerate() {
            let (x, y) = (left + i % BLOCK, i / BLOCK);
            if x < size && y < rows {
                out[y * size + x] = *rgb;
            }
        }
    }
}

/// Encodes a square picture as unsigned BC6H; the channels must be finite and in `[0, 65504]`.
///
/// A size that is not a multiple of four is padded with copies of the last column and row. The encoder's setting
/// "fast" is a third of the time of "basic", and its error on a real sky is 6 % larger.
#[cfg(feature = "bc6h")]
pub(crate) fn encode(size: usize, texels: &[Pixel]) -> Vec<u8> {
    use exr::prelude::f16;

    /// Bytes of a texel for the encoder: four `half`.
    const TEXEL_BYTES: usize = 8;

    let padded = size.next_multiple_of(BLOCK);
    let mut data = Vec::with_capacity(padded * padded * TEXEL_BYTES);
    for y in 0..padded {
        for x in 0..padded {
            let [r, g, b] = texels[y.min(size - 1) * size + x.min(size - 1)];
            data.extend([r, g, b, 1.0].iter().flat_map(|c| f16::from_f32(*c).to_ne_bytes()));
        }
    }
    let side = padded as u32;
    let surface =
        intel_tex_2::RgbaSurface { data: &data, width: side, height: side, stride: side * TEXEL_BYTES as u32 };
    intel_tex_2::bc6h::compress_blocks(&intel_tex_2::bc6h::fast_settings(), &surface)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mode 11: five bits of mode, then two endpoints of ten bits for each channel, then an index of four bits for each
    /// texel, three for the first.
    fn one_region(ends: [[u32; 3]; 2], indices: [u32; 16]) -> [u8; BLOCK_BYTES] {
        let mut bits: u128 = 0b00011;
        let mut position = 5;
        let mut put = |value: u32, count: u32| {
            bits |= u128::from(value) << position;
            position += count;
        };
        ends.iter().flatten().for_each(|end| put(*end, 10));
        put(indices[0], 3);
        indices[1..].iter().for_each(|i| put(*i, 4));
        bits.to_le_bytes()
    }

    #[test]
    fn a_block_written_by_hand_has_the_values_of_the_format() {
        let block = one_region([[495, 240, 0], [1023, 240, 0]], [0, 15, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        let mut texels = Vec::new();
        decode_blocks(&block, 4, 4, false, &mut texels);
        // Ten bits e become sixteen, e 64 + 32, of which 31/64 are the bits of a half: 495 stands for nearly 1.
        let half = |e: u16| exr::prelude::f16::from_bits(((u32::from(e) * 64 + 32) * 31 / 64) as u16).to_f32();
        let near_one = half(495);
        assert!((near_one - 1.0).abs() < 0.01, "495 is {near_one}");
        assert_eq!(texels[0], [near_one, half(240), 0.0], "index 0 is the first end");
        assert_eq!(texels[1], [65504.0, half(240), 0.0], "the highest index is the second end");
    }

    #[test]
    fn blocks_at_the_edge_are_cut() {
        let block = one_region([[480, 0, 0], [480, 0, 0]], [0; 16]);
        let mut texels = Vec::new();
        decode_blocks(&[block, block].concat(), 5, 3, false, &mut texels);
        assert_eq!(texels.len(), 15, "5 columns and 3 rows");
        assert!(texels.iter().all(|t| *t == texels[0] && t[0] > 0.5), "{texels:?}");
    }

    #[test]
    fn no_bits_make_the_decoder_panic() {
        let mut random = lobe_testkit::Random::new(6);
        for i in 0..100_000 {
            let mut bytes = [random.next_u64(), random.next_u64()].map(u64::to_le_bytes).concat();
            bytes[0] = i as u8;
            let mut texels = Vec::new();
            decode_blocks(&bytes, 4, 4, i % 2 == 0, &mut texels);
            assert_eq!(texels.len(), 16, "{bytes:?}");
        }
    }

    /// The mean over a picture of how many times brighter or darker a channel has become, as a logarithm to base 2.
    #[cfg(feature = "bc6h")]
    fn mean_error(encode: impl Fn(usize, &[Pixel]) -> Vec<u8>, size: usize, texels: &[Pixel]) -> f64 {
        let mut decoded = Vec::new();
        for row in encode(size, texels).chunks_exact(size / BLOCK * BLOCK_BYTES) {
            decode_blocks(row, size, BLOCK, false, &mut decoded);
        }
        // Below this a channel is dark beside the others of its texel, and its ratio says nothing.
        let log = |c: f32| f64::from(c.max(1e-3)).log2();
        let pairs = texels.as_flattened().iter().zip(decoded.as_flattened());
        pairs.map(|(a, b)| (log(*a) - log(*b)).abs()).sum::<f64>() / (3 * texels.len()) as f64
    }

    /// Measured: 1.188. Both encoders give the same bytes in every run, so what is above that is room for other versions of
    /// the compiled one only. The fifth more is the edges that cross a block, for which it has modes of two regions.
    #[cfg(feature = "bc6h")]
    const MOST_TIMES_THE_COMPILED_ERROR: f64 = 1.2;

    #[cfg(feature = "bc6h")]
    #[test]
    fn our_encoder_is_nearly_as_good_on_a_real_sky_as_the_compiled_one() {
        let bytes = include_bytes!("../../../lobe-env/assets/sunset.exr");
        let (sky, _) = crate::read_picture_bytes(bytes, "sunset", &crate::PictureReadOptions::default()).unwrap();
        let size = sky.height();
        // The square in the middle of the panorama.
        let left = (sky.width() - size) / 2;
        let square: Vec<Pixel> =
            (0..size * size).map(|i| sky.pixel(left + i % size, i / size).map(|c| c.clamp(0.0, 65504.0))).collect();
        let ours = mean_error(crate::texture::bc6h_encode::encode, size, &square);
        let compiled = mean_error(encode, size, &square);
        let ratio = ours / compiled;
        assert!(ratio < MOST_TIMES_THE_COMPILED_ERROR, "mean error: ours {ours}, compiled {compiled}: ratio {ratio}");
    }

    #[cfg(feature = "bc6h")]
    #[test]
    fn what_is_encoded_comes_back_nearly() {
        for size in [1, 2, 4, 5, 7, 32] {
            let texels: Vec<Pixel> = (0..size * size)
                .map(|i| [1.0 + (i % size) as f32, 8.0 + (i / size) as f32, 0.25 * (1.0 + i as f32)])
                .collect();
            let blocks = encode(size, &texels);
            let across = size.div_ceil(BLOCK);
            assert_eq!(blocks.len(), across * across * BLOCK_BYTES, "bytes of {size} x {size}");
            let mut decoded = Vec::new();
            for (k, row) in blocks.chunks_exact(across * BLOCK_BYTES).enumerate() {
                decode_blocks(row, size, BLOCK.min(size - k * BLOCK), false, &mut decoded);
            }
            for (a, b) in texels.iter().zip(&decoded) {
                let error = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
                assert!(error < 0.25 * a[0].max(a[1]).max(a[2]), "{size}: {a:?} became {b:?}");
            }
        }
    }
}
