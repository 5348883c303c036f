//! Items of a pass in pieces that fit a binding, and rows of numbers for them, coefficient by coefficient.

use std::ops::Range;

use half::f16;

use crate::context::context::Context;
use crate::error::GpuError;
use crate::renderer::renderer::Renderer;
use crate::storage::Storage;

/// Where every device accepts that a part of a buffer begins, in bytes: the largest value that a device may ask for.
const PART_ALIGNMENT: u64 = 256;

/// Bytes of the value of a row: four `f32`.
pub(crate) const VALUE: u64 = 16;

/// A piece of the items: its number, and the items in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    pub(crate) number: usize,
    pub(crate) items: Range<usize>,
}

impl Piece {
    /// The name of what belongs to this piece alone.
    pub(crate) fn of(&self, name: &str) -> String {
        format!("{name} {}", self.number)
    }

    /// The bytes of its items in a buffer of all, `bytes` for each item.
    pub(crate) fn part(&self, bytes: u64) -> Range<u64> {
        self.items.start as u64 * bytes..self.items.end as u64 * bytes
    }

    /// The bytes of the values of its items among those of all.
    pub(crate) fn values(&self) -> Range<u64> {
        self.part(VALUE)
    }

    pub(crate) fn count(&self) -> u32 {
        self.items.len() as u32
    }

    /// What shaders know of a piece: its items.
    pub(crate) fn shape(&self) -> [u32; 4] {
        [self.count(), 0, 0, 0]
    }
}

/// Cuts items into as many pieces as the limit of a binding demands. An item has at most `own` bytes in a buffer that belongs to one
/// piece, and these bytes in buffers of all items, of which a piece binds its part: every piece but the last ends where the
/// part of the next may begin.
///
/// # Errors
/// [`GpuError::Unsupported`] if not even the shortest piece fits.
pub(crate) fn cut(
    context: &Context,
    name: &str,
    items: usize,
    own: u64,
    parts: &[u64],
) -> Result<Vec<Piece>, GpuError> {
    let most = context.max_storage_binding();
    let largest = parts.iter().copied().fold(own, u64::max).max(1);
    let step = aligned_items(parts);
    let fitting = (most / largest) as usize / step * step;
    if fitting == 0 {
        let needed = largest * step as u64;
        let message =
            format!("expected storage bindings of at least {needed} bytes, found {most}; take another device");
        return Err(GpuError::Unsupported { place: name.into(), message });
    }
    let firsts = (0..items).step_by(fitting).enumerate();
    Ok(firsts.map(|(number, first)| Piece { number, items: first..items.min(first + fitting) }).collect())
}

/// The least number of items that ends where a part of each of some buffers may begin.
pub(crate) fn aligned_items(bytes: &[u64]) -> usize {
    // A power of two over the powers of two in its divisors, so that the largest is a multiple of all.
    let items = |bytes: &u64| PART_ALIGNMENT >> bytes.trailing_zeros().min(PART_ALIGNMENT.trailing_zeros());
    bytes.iter().map(items).max().unwrap_or(1) as usize
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

/// Uploads rows of `words` words each, word by word, cut where also what they write fits, `value` bytes a row; `row` gives the
/// words of one. A piece has its words under `name` and its [shape](Piece::shape) under `name shape`.
pub(crate) fn upload_rows(
    renderer: &mut Renderer,
    name: &str,
    rows: usize,
    (words, value): (usize, u64),
    mut row: impl FnMut(usize, &mut Vec<u32>),
) -> Result<Vec<Piece>, GpuError> {
    let pieces = cut(renderer.context(), name, rows, 4 * words as u64, &[value])?;
    let mut scratch = Vec::with_capacity(words);
    for piece in &pieces {
        let count = piece.items.len();
        let mut table = vec![0; words * count];
        for (r, at) in piece.items.clone().enumerate() {
            row(at, &mut scratch);
            for (w, word) in scratch.iter().enumerate() {
                table[w * count + r] = *word;
            }
        }
        renderer.upload(&piece.of(name), &table)?;
        renderer.uniform(&piece.of(&format!("{name} shape")), &piece.shape())?;
    }
    Ok(pieces)
}
