//! BC6H encoder: the four modes without sign that have one region of two colors and sixteen steps between.
//!
//! ```text
//!   mode   5 bits    first color   second color
//!    11    00011     10 bits       10 bits
//!    12    00111     11 bits       9 bits, as the difference to the first
//!    13    01011     12 bits       8 bits, likewise
//!    14    01111     16 bits       4 bits, likewise
//! ```
//!
//! A block is fitted in the numbers that the format interpolates, the bits of a `half` times 64/31, so an error counts
//! relative to the light: of a texel, that of a channel by the root of what the channel has of the brightest one. (With equal weights a channel
//! that is zero, dozens of octaves below its neighbors, spoiled those of a lamp beside it: red of 7768 for 2211.) The ends begin at the extent of the texels along their principal axis and are improved by
//! least squares. Then every mode that can hold them is tried. Blocks of two regions are not written: where an edge
//! between colors crosses a block, they would be better (test
//! `our_encoder_is_nearly_as_good_on_a_real_sky_as_the_compiled_one`).
//!
//! Khronos Data Format Specification 1.3, section 20.2 (BPTC, unsigned half floats).

use half::f16;

use crate::pixel::Pixel;
use crate::texture::bc6h::{BLOCK, BLOCK_BYTES};

/// Texels of a block.
const TEXELS: usize = BLOCK * BLOCK;

/// The largest `half`, as bits.
const MAX_HALF_BITS: u16 = 0x7bff;

/// The share of the second color at every index, of 64.
const SHARES: [i32; 16] = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];

/// Rounds of least squares.
const ROUNDS: usize = 3;

/// The least weight of a channel in the error of a texel.
const LEAST_WEIGHT: f32 = 1.0 / 1024.0;

/// What is below this part of the brightest channel of a block is taken for black, and black for this part: twice what a display shows
/// between black and white. So a step to black takes 14 octaves, not 40, of the sixteen steps.
const BLACK: f32 = 1.0 / 16384.0;

/// A color in the numbers that are interpolated, `0..=65535`.
type Color = [f32; 3];

/// A texel as it should come out, and what its channels weigh.
#[derive(Clone, Copy)]
struct Target {
    color: Color,
    weights: Color,
}

/// A mode: its five bits, the bits of the first color's channels, and of the differences; none if the second color is
/// stored as it is.
struct Mode {
    id: u128,
    bits: u32,
    difference: Option<u32>,
}

const MODES: [Mode; 4] = [
    Mode { id: 0b00011, bits: 10, difference: None },
    Mode { id: 0b00111, bits: 11, difference: Some(9) },
    Mode { id: 0b01011, bits: 12, difference: Some(8) },
    Mode { id: 0b01111, bits: 16, difference: Some(4) },
];

/// Encodes a square picture; the channels must be finite and in `[0, 65504]`. A size that is not a multiple of four is
/// padded with copies of the last column and row.
pub(crate) fn encode(size: usize, texels: &[Pixel]) -> Vec<u8> {
    let across = size.div_ceil(BLOCK);
    let mut bytes = Vec::with_capacity(across * across * BLOCK_BYTES);
    for (top, left) in (0..across * across).map(|i| (i / across * BLOCK, i % across * BLOCK)) {
        let texel = |i: usize| {
            let (x, y) = ((left + i % BLOCK).min(size - 1), (top + i / BLOCK).min(size - 1));
            texels[y * size + x]
        };
        bytes.extend(encode_block(&targets(&std::array::from_fn(texel))).to_le_bytes());
    }
    bytes
}

fn targets(texels: &[Pixel; TEXELS]) -> [Target; TEXELS] {
    let brightest = |texel: &Pixel| texel.iter().copied().fold(0.0, f32::max);
    let black = BLACK * texels.iter().map(brightest).fold(0.0, f32::max);
    texels.map(|texel| {
        let (most, texel) = (brightest(&texel), texel.map(|c| if brightest(&texel) < black { black } else { c }));
        let weight = |c: f32| if most > black { (c / most).max(0.0).sqrt().max(LEAST_WEIGHT) } else { 1.0 };
        Target { color: texel.map(to_steps), weights: texel.map(weight) }
    })
}

/// The number that comes out as this channel.
fn to_steps(channel: f32) -> f32 {
    let bits = if channel > 0.0 { f16::from_f32(channel).to_bits().min(MAX_HALF_BITS) } else { 0 };
    (f32::from(bits) + 0.5) * 64.0 / 31.0
}

fn encode_block(texels: &[Target; TEXELS]) -> u128 {
    let ends = fitted(texels);
    let mut best = (f32::INFINITY, 0);
    for mode in &MODES {
        if let Some((error, block)) = mode.encode(texels, ends)
            && error < best.0
        {
            best = (error, block);
        }
    }
    best.1
}

/// The two colors between which the texels lie best.
fn fitted(texels: &[Target; TEXELS]) -> [Color; 2] {
    let all = |c: usize| texels.iter().map(|t| t.weights[c]).sum::<f32>();
    let mean = [0, 1, 2].map(|c| texels.iter().map(|t| t.weights[c] * t.color[c]).sum::<f32>() / all(c));
    let axis = principal_axis(texels, mean);
    let along = |t: &Target| place(t, mean, axis);
    let (low, high) =
        texels.iter().map(along).fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    let at = |t: f32| [0, 1, 2].map(|c| (mean[c] + t * axis[c]).clamp(0.0, 65535.0));
    let mut ends = [at(low), at(high)];
    for _ in 0..ROUNDS {
        let shares = texels.map(|t| SHARES[nearest(&t, ends)] as f32 / 64.0);
        ends = least_squares(texels, &shares);
    }
    ends
}

/// The `t` for which `start + t d` is nearest to a texel; 0 if `d` is zero.
fn place(texel: &Target, start: Color, d: Color) -> f32 {
    let length = (0..3).map(|c| texel.weights[c] * d[c] * d[c]).sum::<f32>();
    let along = (0..3).map(|c| texel.weights[c] * (texel.color[c] - start[c]) * d[c]).sum::<f32>();
    if length > 0.0 { along / length } else { 0.0 }
}

/// The direction in which the texels differ most, by power iteration.
fn principal_axis(texels: &[Target; TEXELS], mean: Color) -> Color {
    let mut covariance = [[0.0_f32; 3]; 3];
    for texel in texels {
        let d = [0, 1, 2].map(|c| texel.weights[c].sqrt() * (texel.color[c] - mean[c]));
        for (row, a) in covariance.iter_mut().zip(d) {
            for (sum, b) in row.iter_mut().zip(d) {
                *sum += a * b;
            }
        }
    }
    // Start from the longest column: no other start is sure not to be orthogonal to the axis.
    let square = |column: &Color| column.iter().map(|c| c * c).sum::<f32>();
    let longest = covariance.into_iter().max_by(|a, b| square(a).total_cmp(&square(b))).unwrap_or_default();
    let mut axis = normalized(longest);
    for _ in 0..8 {
        axis = normalized(covariance.map(|row| (0..3).map(|c| row[c] * axis[c]).sum::<f32>()));
    }
    axis
}

/// A vector of length 1; zero if it has none.
fn normalized(v: Color) -> Color {
    let length = v.iter().map(|c| c * c).sum::<f32>().sqrt();
    if length > 0.0 { v.map(|c| c / length) } else { v }
}

/// The index whose color is nearest to a texel, by the place of the texel along the line of the ends.
fn nearest(texel: &Target, [a, b]: [Color; 2]) -> usize {
    let share = 64.0 * place(texel, a, [0, 1, 2].map(|c| b[c] - a[c]));
    let first = SHARES.partition_point(|s| (*s as f32) < share).min(15);
    if first > 0 && share - (SHARES[first - 1] as f32) < SHARES[first] as f32 - share { first - 1 } else { first }
}

/// The ends that minimize the squared error for given shares, channel by channel; the mean twice where all shares are equal.
fn least_squares(texels: &[Target; TEXELS], shares: &[f32; TEXELS]) -> [Color; 2] {
    let ends = [0, 1, 2].map(|c| {
        let (mut aa, mut ab, mut bb, mut at, mut bt) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (texel, &b) in texels.iter().zip(shares) {
            let (a, weight, t) = (1.0 - b, texel.weights[c], texel.color[c]);
            (aa, ab, bb) = (aa + weight * a * a, ab + weight * a * b, bb + weight * b * b);
            (at, bt) = (at + weight * a * t, bt + weight * b * t);
        }
        let determinant = aa * bb - ab * ab;
        // Of the square of all weights; shares that differ in one texel of sixteen, by one step, have 2e-4.
        let all = aa + 2.0 * ab + bb;
        if determinant < 1e-5 * all * all {
            return [(at + bt) / all; 2];
        }
        let solve = |p: f32, q: f32, r: f32, s: f32| ((p * q - r * s) / determinant).clamp(0.0, 65535.0);
        [solve(bb, at, ab, bt), solve(aa, bt, ab, at)]
    });
    [ends.map(|[first, _]| first), ends.map(|[_, second]| second)]
}

impl Mode {
    /// The squared error and the bits of a block; none if the mode cannot hold the ends.
    fn encode(&self, texels: &[Target; TEXELS], ends: [Color; 2]) -> Option<(f32, u128)> {
        let mut stored = ends.map(|end| end.map(|c| self.quantized(c)));
        let decoded = stored.map(|end| end.map(|q| self.unquantized(q)));
        let palette =
            SHARES.map(|s| [0, 1, 2].map(|c| ((decoded[0][c] * (64 - s) + decoded[1][c] * s + 32) >> 6) as f32));
        let distance = |a: &Target, b: &Color| (0..3).map(|c| a.weights[c] * (a.color[c] - b[c]).powi(2)).sum::<f32>();
        let line = decoded.map(|end| end.map(|c| c as f32));
        let mut indices = texels.map(|texel| nearest(&texel, line));
        let error = texels.iter().zip(&indices).map(|(texel, i)| distance(texel, &palette[*i])).sum();
        // The first index has three bits.
        if indices[0] > 7 {
            stored.reverse();
            indices = indices.map(|i| 15 - i);
        }
        Some((error, self.packed(stored, &indices)?))
    }

    fn quantized(&self, value: f32) -> i32 {
        let most = (1 << self.bits) - 1;
        let near = (value as i32 >> (16 - self.bits)).clamp(0, most);
        let error = |q: &i32| ((self.unquantized(*q) as f32 - value).abs() * 16.0) as i64;
        [near - 1, near, near + 1].into_iter().filter(|q| (0..=most).contains(q)).min_by_key(error).unwrap_or(near)
    }

    fn unquantized(&self, q: i32) -> i32 {
        match q {
            _ if self.bits >= 15 => q,
            0 => 0,
            q if q == (1 << self.bits) - 1 => 0xffff,
            q => ((q << 16) + 0x8000) >> self.bits,
        }
    }

    /// The bits of a block; none if a difference is too large.
    fn packed(&self, [first, second]: [[i32; 3]; 2], indices: &[usize; TEXELS]) -> Option<u128> {
        let mut block = Bits { bits: self.id, at: 5 };
        first.into_iter().for_each(|c| block.put(c as u128, 10));
        for (a, b) in first.into_iter().zip(second) {
            match self.difference {
                None => block.put(b as u128, 10),
                Some(bits) => {
                    let limit = 1 << (bits - 1);
                    if !(-limit..limit).contains(&(b - a)) {
                        return None;
                    }
                    block.put((b - a) as u32 as u128, bits);
                    // The bits of the first color above ten, the highest one first.
                    (10..self.bits).rev().for_each(|bit| block.put((a >> bit) as u128, 1));
                }
            }
        }
        block.put(indices[0] as u128, 3);
        indices[1..].iter().for_each(|i| block.put(*i as u128, 4));
        Some(block.bits)
    }
}

/// A block that is filled from its lowest bit.
struct Bits {
    bits: u128,
    at: u32,
}

impl Bits {
    /// Appends the lowest `count` bits of a number.
    fn put(&mut self, value: u128, count: u32) {
        self.bits |= (value & ((1 << count) - 1)) << self.at;
        self.at += count;
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::texture::bc6h::decode_blocks;

    fn decoded(block: u128) -> Vec<Pixel> {
        let mut texels = Vec::new();
        decode_blocks(&block.to_le_bytes(), 4, 4, false, &mut texels);
        texels
    }

    #[test]
    fn every_mode_decodes_to_the_colors_that_were_meant() {
        let mut random = Random::new(31);
        for mode in &MODES {
            for _ in 0..500 {
                let reach = mode.difference.map_or(1 << mode.bits, |bits| 1 << (bits - 1)) as f64;
                let first = [(); 3].map(|()| (random.unit() * f64::from((1 << mode.bits) - 1)) as i32);
                let most = (1 << mode.bits) - 1;
                let second = first.map(|a| (a + (random.signed() * reach) as i32).clamp(0, most));
                let mut indices: [usize; TEXELS] = std::array::from_fn(|i| (7 * i) % 16);
                indices[0] = 5;
                let Some(block) = mode.packed([first, second], &indices) else { continue };
                for (i, texel) in indices.into_iter().zip(decoded(block)) {
                    let expected = [0, 1, 2].map(|c| {
                        let [a, b] = [first[c], second[c]].map(|q| mode.unquantized(q));
                        let mixed = (a * (64 - SHARES[i]) + b * SHARES[i] + 32) >> 6;
                        f16::from_bits(((mixed * 31) >> 6) as u16).to_f32()
                    });
                    assert_eq!(texel, expected, "mode {:05b}, {first:?} and {second:?}, index {i}", mode.id);
                }
            }
        }
    }

    #[test]
    fn blocks_of_one_color_are_exact_to_three_digits() {
        for color in [[0.0; 3], [1.0, 0.5, 0.25], [65504.0, 1e-3, 7.0], [0.2126, 800.0, 3.0]] {
            for texel in decoded(encode_block(&targets(&[color; TEXELS]))) {
                for c in 0..3 {
                    assert!((texel[c] - color[c]).abs() <= 1e-3 * color[c] + 1e-6, "{texel:?} against {color:?}");
                }
            }
        }
    }

    /// Red against green is orthogonal to gray, where a search for the axis might begin.
    #[test]
    fn two_colors_of_one_brightness_stay_two() {
        let [a, b] = [[1.0, 0.5, 0.25], [0.5, 1.0, 0.25]];
        let pictures: [fn(usize) -> bool; 3] = [|i| (i + i / 4) % 2 == 0, |i| i % 4 < 2, |i| i == 6];
        for (k, is_first) in pictures.into_iter().enumerate() {
            let color = |i: usize| if is_first(i) { a } else { b };
            let texels = targets(&std::array::from_fn(color));
            for (i, texel) in decoded(encode_block(&texels)).into_iter().enumerate() {
                let error = (0..3).map(|c| (texel[c] / color(i)[c] - 1.0).abs()).fold(0.0, f32::max);
                assert!(error < 0.01, "picture {k}, texel {i}: {texel:?} against {:?}", color(i));
            }
        }
    }

    #[test]
    fn curved_ramps_stay_close() {
        let color = |i: usize| [1.0 + 0.1 * i as f32, 2.0 + 0.05 * i as f32, 0.5 + 0.02 * i as f32];
        let texels = targets(&std::array::from_fn(color));
        for (i, texel) in decoded(encode_block(&texels)).into_iter().enumerate() {
            let error = (0..3).map(|c| (texel[c] / color(i)[c] - 1.0).abs()).fold(0.0, f32::max);
            assert!(error < 0.06, "texel {i}: {texel:?} against {:?}", color(i));
        }
    }
    /// Around the lamp of a studio, ringing has left negative channels, which are black here.
    #[test]
    fn black_channels_and_black_texels_do_not_spoil_a_lamp_beside_them() {
        let lamp = [2211.0, 2425.0, 2604.0];
        let dark: [fn(usize) -> Pixel; 3] =
            [|_| [0.0; 3], |i| [0.0, 3.0 + i as f32, 2.0], |i| [20.0 * i as f32, 22.0 * i as f32, 0.0]];
        for (k, dark) in dark.into_iter().enumerate() {
            let color = |i: usize| if i % 4 < 2 { lamp } else { dark(i) };
            let texels = targets(&std::array::from_fn(color));
            for (i, texel) in decoded(encode_block(&texels)).into_iter().enumerate() {
                for c in 0..3 {
                    let (most, off) = (color(i).into_iter().fold(0.5, f32::max), (texel[c] - color(i)[c]).abs());
                    let bound = if i % 4 < 2 { 0.05 } else { 0.5 };
                    assert!(off < bound * most, "block {k}, texel {i}: {texel:?} against {:?}", color(i));
                }
            }
        }
    }
}
