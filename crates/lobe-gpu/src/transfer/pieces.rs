//! Rows of numbers for the device: coefficient by coefficient, in pieces that fit a binding.

use std::ops::Range;

use half::f16;

use crate::renderer::renderer::Renderer;
use crate::{GpuError, Storage};

/// Rows in a piece are a multiple of this, so that what they write, 16 bytes each, starts where every device accepts it.
const ALIGNED_ROWS: usize = 16;

/// Bytes of the value of a row: four `f32`.
pub(crate) const VALUE: u64 = 16;

/// A piece of the rows: its number, and the rows in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    pub(crate) rows: Range<usize>,
    /// The names of its words, and of its shape.
    pub(crate) words: String,
    pub(crate) shape: String,
}

impl Piece {
    /// The bytes of the values of its rows among those of all.
    pub(crate) fn values(&self) -> Range<u64> {
        self.rows.start as u64 * VALUE..self.rows.end as u64 * VALUE
    }

    pub(crate) fn count(&self) -> u32 {
        self.rows.len() as u32
    }
}

/// Words in a row of numbers.
pub(crate) fn words_of(numbers: usize, storage: Storage) -> usize {
    match storage {
        Storage::F32 => numbers,
        Storage::F16 => numbers.div_ceil(2),
    }
}

/// The words of a row: each a number, or two in half precision.
pub(crate) fn pack(numbers: &[f32], storage: Storage, out: &mut Vec<u32>) {
    out.clear();
    match storage {
        Storage::F32 => out.extend(numbers.iter().map(|x| x.to_bits())),
        Storage::F16 => {
            let most = f16::MAX.to_f32();
            let half = |x: f32| u32::from(f16::from_f32(x.clamp(-most, most)).to_bits());
            out.extend(numbers.chunks(2).map(|pair| half(pair[0]) | half(pair.get(1).copied().unwrap_or(0.0)) << 16));
        }
    }
}

/// Uploads rows of `words` words each, word by word, in as many pieces as the limit of a binding demands; `row` gives the
/// words of one.
///
/// The shape of a piece is a uniform of its rows, its first row, and all rows.
pub(crate) fn upload_rows(
    renderer: &mut Renderer,
    name: &str,
    rows: usize,
    words: usize,
    mut row: impl FnMut(usize, &mut Vec<u32>),
) -> Result<Vec<Piece>, GpuError> {
    let most = renderer.context().max_storage_binding();
    let bytes = (4 * words as u64).max(VALUE);
    let fitting = (most / bytes) as usize / ALIGNED_ROWS * ALIGNED_ROWS;
    if fitting == 0 {
        let needed = bytes * ALIGNED_ROWS as u64;
        let message = format!("expected storage bindings of at least {needed} bytes, found {most}");
        return Err(GpuError::Unsupported { place: name.into(), message });
    }
    let (mut pieces, mut scratch) = (Vec::new(), Vec::with_capacity(words));
    for (k, first) in (0..rows).step_by(fitting).enumerate() {
        let piece = first..rows.min(first + fitting);
        let count = piece.len();
        let mut table = vec![0; words * count];
        for (r, at) in piece.clone().enumerate() {
            row(at, &mut scratch);
            for (w, word) in scratch.iter().enumerate() {
                table[w * count + r] = *word;
            }
        }
        let (words, shape) = (format!("{name} {k}"), format!("{name} {k} shape"));
        renderer.upload(&words, &table)?;
        renderer.uniform(&shape, &[count as u32, first as u32, rows as u32, 0])?;
        pieces.push(Piece { rows: piece, words, shape });
    }
    Ok(pieces)
}
