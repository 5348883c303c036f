//! RGBE texels of Radiance pictures, and their rows as they are stored.
//!
//! ```text
//!   value = m 2^(e - 136)           m a mantissa of eight bits for each color, e the exponent that they share
//!
//!   flat       m_r m_g m_b e, texel after texel
//!   old runs   the same; 1 1 1 n repeats the texel before it n times, n 256^k times after k counts in a row
//!   new runs   2 2 and the width in two bytes, then all m_r, all m_g, all m_b and all e:
//!              128 + n and a byte repeat that byte n times, n up to 128 is followed by n bytes
//! ```
//!
//! Ward, "Real Pixels", Graphics Gems II (1991), and `color.c` of Radiance.

use crate::pixel::{BLACK, Pixel};

/// Rows of these widths may be in the new run-length encoding.
const RUN_WIDTHS: std::ops::RangeInclusive<usize> = 8..=MAX_WIDTH;

/// The widest picture whose width fits the mark of a row; its highest bit is clear.
pub(crate) const MAX_WIDTH: usize = 0x7fff;

/// The first two bytes of a row in the new encoding.
const MARK: u8 = 2;

/// The longest run, and the most bytes behind one count.
const LONGEST_RUN: usize = 127;
const MOST_LITERALS: usize = 128;

/// A run of fewer bytes is shorter without a count of its own.
const SHORTEST_RUN: usize = 3;

/// The exponent is stored with this added; the mantissa is in units of 2⁻⁸.
const BIAS: i32 = 128;

/// A row that cannot be decoded.
#[derive(Debug, PartialEq)]
pub(crate) enum RowError {
    /// There are fewer bytes than the row needs.
    Ends,
    /// The row contradicts itself.
    Damaged(String),
}

/// The value of each exponent's mantissa of 1, exact down to the subnormal numbers.
pub(crate) fn steps() -> [f32; 256] {
    std::array::from_fn(|e| if e == 0 { 0.0 } else { (e as f64 - f64::from(BIAS) - 8.0).exp2() as f32 })
}

/// The nearest RGBE of a texel, whose channels must be finite and not negative; black where the exponent is too small.
///
/// Truncation, as in the oldest encoders, makes every channel darker by half a step on average, 0.2 to 0.4 % of the
/// largest channel, and so the sum over a map. Rounding to nearest has no such bias, if ties go to even: an eighth of
/// the values of a `half` picture are ties (test `a_real_map_has_the_same_harmonics_through_every_format`).
pub(crate) fn encode(texel: Pixel) -> [u8; 4] {
    let channels = texel.map(f64::from);
    let largest = channels[0].max(channels[1]).max(channels[2]);
    if largest <= 0.0 {
        return [0; 4];
    }
    // 2^(k - 8) is the step of a largest channel below 2^k; if that rounds up to 256 steps, the step doubles.
    let mut k = largest.log2().floor() as i32 + 1;
    if (largest / f64::from(k - 8).exp2()).round_ties_even() >= 256.0 {
        k += 1;
    }
    let Ok(exponent @ 1..) = u8::try_from(k + BIAS) else { return [0; 4] };
    let [r, g, b] = channels.map(|c| (c / f64::from(k - 8).exp2()).round_ties_even() as u8);
    [r, g, b, exponent]
}

/// Reads a row from the start of `bytes`, and removes it from them.
pub(crate) fn read_row(bytes: &mut &[u8], row: &mut [[u8; 4]]) -> Result<(), RowError> {
    match **bytes {
        [MARK, MARK, high, low, ..] if high < 128 && RUN_WIDTHS.contains(&row.len()) => {
            let marked = usize::from(high) << 8 | usize::from(low);
            if marked != row.len() {
                return Err(RowError::Damaged(format!("a row of {} columns is marked with {marked}", row.len())));
            }
            take(bytes, 4)?;
            (0..4).try_for_each(|channel| read_plane(bytes, row, channel))
        }
        _ => read_texels(bytes, row),
    }
}

/// Removes `count` bytes from the start.
fn take<'a>(bytes: &mut &'a [u8], count: usize) -> Result<&'a [u8], RowError> {
    bytes.split_off(..count).ok_or(RowError::Ends)
}

/// Refuses a run that reaches beyond the row.
fn check_end(end: usize, width: usize) -> Result<(), RowError> {
    if end <= width {
        return Ok(());
    }
    Err(RowError::Damaged(format!("a run reaches column {end} of {width}")))
}

/// One channel of a row in the new encoding.
fn read_plane(bytes: &mut &[u8], row: &mut [[u8; 4]], channel: usize) -> Result<(), RowError> {
    let (mut x, width) = (0, row.len());
    while x < width {
        let count = usize::from(take(bytes, 1)?[0]);
        let length = if count > MOST_LITERALS { count - MOST_LITERALS } else { count };
        if length == 0 {
            return Err(RowError::Damaged("a run of no columns".to_owned()));
        }
        check_end(x + length, width)?;
        let run = &mut row[x..x + length];
        if count > MOST_LITERALS {
            let value = take(bytes, 1)?[0];
            run.iter_mut().for_each(|texel| texel[channel] = value);
        } else {
            run.iter_mut().zip(take(bytes, length)?).for_each(|(texel, value)| texel[channel] = *value);
        }
        x += length;
    }
    Ok(())
}

/// A row in the old encoding, of which flat rows are a case.
fn read_texels(bytes: &mut &[u8], row: &mut [[u8; 4]]) -> Result<(), RowError> {
    let (mut x, mut unit) = (0, 1_usize);
    while x < row.len() {
        let texel = take(bytes, 4)?;
        let [1, 1, 1, count] = *texel else {
            row[x].copy_from_slice(texel);
            (x, unit) = (x + 1, 1);
            continue;
        };
        if x == 0 {
            return Err(RowError::Damaged("a row begins with a repeat count".to_owned()));
        }
        if unit > row.len() {
            return Err(RowError::Damaged("more repeat counts in a row than its columns have digits".to_owned()));
        }
        let end = x.saturating_add(unit.saturating_mul(usize::from(count)));
        check_end(end, row.len())?;
        let before = row[x - 1];
        row[x..end].fill(before);
        (x, unit) = (end, unit.saturating_mul(256));
    }
    Ok(())
}

/// Adds the bytes of a row: in new runs where its width allows them, otherwise flat.
pub(crate) fn write_row(row: &[[u8; 4]], bytes: &mut Vec<u8>) {
    if !RUN_WIDTHS.contains(&row.len()) {
        bytes.extend(row.as_flattened());
        return;
    }
    let [high, low] = (row.len() as u16).to_be_bytes();
    bytes.extend([MARK, MARK, high, low]);
    for channel in 0..4 {
        let plane: Vec<u8> = row.iter().map(|texel| texel[channel]).collect();
        write_plane(&plane, bytes);
    }
}

fn write_plane(plane: &[u8], bytes: &mut Vec<u8>) {
    let literals = |values: &[u8], bytes: &mut Vec<u8>| {
        for values in values.chunks(MOST_LITERALS) {
            bytes.push(values.len() as u8);
            bytes.extend(values);
        }
    };
    let (mut written, mut x) = (0, 0);
    while x < plane.len() {
        let length = plane[x..].iter().take(LONGEST_RUN).take_while(|value| **value == plane[x]).count();
        if length >= SHORTEST_RUN {
            literals(&plane[written..x], bytes);
            bytes.extend([(MOST_LITERALS + length) as u8, plane[x]]);
            written = x + length;
        }
        x += length;
    }
    literals(&plane[written..], bytes);
}

/// The color of an RGBE, by the [`steps`].
pub(crate) fn decode([r, g, b, e]: [u8; 4], steps: &[f32; 256]) -> Pixel {
    if e == 0 {
        return BLACK;
    }
    [r, g, b].map(|m| f32::from(m) * steps[usize::from(e)])
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn a_texel_is_stored_as_the_nearest_one() {
        let mut random = Random::new(8);
        let steps = steps();
        let (mut worst, mut sum) = (0f64, 0f64);
        for _ in 0..100_000 {
            let scale = (40.0 * random.signed()).exp2();
            let texel = [random.unit(), random.unit(), random.unit()].map(|c| (c * scale) as f32);
            let largest = texel.into_iter().fold(0.0, f32::max);
            let stored = decode(encode(texel), &steps);
            for (c, s) in texel.into_iter().zip(stored) {
                let error = f64::from(s - c) / f64::from(largest);
                worst = worst.max(error.abs());
                sum += error;
            }
        }
        // Half a step of a largest channel that rounds up to 128 steps; the mean of 300000 errors with both signs.
        assert!(worst <= 0.5 / 127.5, "largest error {worst}");
        assert!((sum / 300_000.0).abs() < 2e-5, "mean error {}", sum / 300_000.0);
    }

    #[test]
    fn the_ends_of_the_range_are_black_and_the_largest_exponent() {
        assert_eq!(encode(BLACK), [0; 4], "black");
        assert_eq!(encode([f32::from_bits(1); 3]), [0; 4], "the smallest number");
        let largest = 255.0 / 256.0 * 127_f32.exp2();
        assert_eq!(encode([largest; 3]), [255, 255, 255, 255], "the largest value");
        let steps = steps();
        for e in 1..=255 {
            let texel = [255, 128, 1, e];
            assert_eq!(encode(decode(texel, &steps)), texel, "exponent {e}");
        }
    }

    #[test]
    fn rows_of_every_width_come_back() {
        let mut random = Random::new(9);
        for width in [1, 2, 7, 8, 9, 127, 128, 129, 255, 256, 257, 1000] {
            for runs in [false, true] {
                let mut texel = [3, 2, 1, 128];
                let row: Vec<[u8; 4]> = (0..width)
                    .map(|_| {
                        if !runs || random.unit() < 0.1 {
                            // No byte of 1 or 2: a flat row has no repeat counts and does not begin with a mark.
                            texel = std::array::from_fn(|_| 3 + (random.next_u64() % 250) as u8);
                        }
                        texel
                    })
                    .collect();
                let mut bytes = Vec::new();
                write_row(&row, &mut bytes);
                let (mut rest, mut back) = (bytes.as_slice(), vec![[0; 4]; width]);
                assert_eq!(read_row(&mut rest, &mut back), Ok(()), "width {width}");
                assert!(rest.is_empty() && back == row, "width {width}, runs {runs}");
                let mut cut = &bytes[..bytes.len() - 1];
                assert_eq!(read_row(&mut cut, &mut back), Err(RowError::Ends), "width {width}, cut");
            }
        }
    }
}
