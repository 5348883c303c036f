//! The passes of matte receivers: transfer vectors, and transfer in clusters.
//!
//! ```text
//!   B = Σᵢ Lᵢ Tᵢ          clustered:  B = M_k·L + Σ_j w_j (B_kj·L)
//! ```
//!
//! As [`exit_radiance`](lobe_prt::Transfer::exit_radiance) and [`CompressedTransfer::exit_radiance`]. A light costs
//! the upload of `n²` colors. What is larger than a storage binding of the device is split over several dispatches;
//! but for the products of the light with the clusters, which every receiver reads: 16 bytes for each mean and
//! direction.

use lobe_prt::{CompressedTransfer, TableWeights};
use lobe_sh::Rgb;

use crate::context::context::Context;
use crate::error::GpuError;
use crate::lookup::basis::{MAX_SHADER_ORDER, check_order};
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::{Piece, VALUE, pack, upload_rows, words_of};
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::storage::Storage;
use crate::transfer::reflecting_transfer::ReflectingTransfer;

/// Bindings of the programs `transfer` and `clustered`.
const TRANSFER_SLOTS: [Slot; 4] = [Slot::Uniform, Slot::Uniform, Slot::Read, Slot::Write];
const CLUSTERED_SLOTS: [Slot; 4] = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Write];

/// The light's coefficients of `order`, missing ones zero.
pub(crate) fn light_vectors(light: &[Rgb<f64>], order: usize) -> Vec<[f32; 4]> {
    let mut vectors: Vec<[f32; 4]> =
        light.iter().take(order * order).map(|c| [c.r as f32, c.g as f32, c.b as f32, 0.0]).collect();
    vectors.resize(order * order, [0.0; 4]);
    vectors
}

/// Makes a uniform for a light of any order, and another behind it, if there is none of this name.
pub(crate) fn add_light(renderer: &mut Renderer, name: &str) -> Result<(), GpuError> {
    if renderer.has(name) {
        Ok(())
    } else {
        renderer.uniform(name, &[[0.0_f32; 4]; 2 * MAX_SHADER_ORDER * MAX_SHADER_ORDER])
    }
}

/// So many rows, and the receiver that each of them is.
pub(crate) type Rows<'a> = (usize, &'a dyn Fn(usize) -> usize);

/// Passes that shade receivers of transfer vectors: by each of these lights, into the rows of the buffer beside it.
pub(crate) fn add_transfer(
    renderer: &mut Renderer,
    transfer: &ReflectingTransfer<'_>,
    storage: Storage,
    (rows, receiver): Rows<'_>,
    lit: &[(&str, &str)],
) -> Result<(), GpuError> {
    let (coefficients, channels) = (transfer.coefficients(), transfer.channels());
    for (light, radiance) in lit {
        add_light(renderer, light)?;
        renderer.allocate(radiance, VALUE * rows as u64)?;
    }
    let mut numbers = Vec::with_capacity(channels * coefficients);
    let row = |r: usize, out: &mut Vec<u32>| {
        numbers.clear();
        (0..channels).for_each(|channel| transfer.append(receiver(r), channel, &mut numbers));
        pack(&numbers, storage, out);
    };
    let words = words_of(channels * coefficients, storage);
    let pieces = upload_rows(renderer, "transfer", rows, (words, VALUE), row)?;
    let kernel = transfer_kernel(renderer.context(), coefficients, channels, storage)?;
    for (number, (light, radiance)) in lit.iter().enumerate() {
        let title = if number == 0 { "transfer" } else { radiance };
        add_passes(renderer, &kernel, (title, light), ("transfer", &pieces), radiance)?;
    }
    Ok(())
}

fn transfer_kernel(
    context: &Context,
    coefficients: usize,
    channels: usize,
    storage: Storage,
) -> Result<Kernel, GpuError> {
    let shader = Shader::new(&["transfer"])
        .constant("COEFFICIENTS", coefficients)
        .constant("CHANNELS", channels)
        .constant("HALF", usize::from(storage == Storage::F16));
    Kernel::new(context, "transfer", &shader, &TRANSFER_SLOTS)
}

/// One pass for each piece, of this title.
fn add_passes(
    renderer: &mut Renderer,
    kernel: &Kernel,
    (title, input): (&str, &str),
    (name, pieces): (&str, &[Piece]),
    radiance: &str,
) -> Result<(), GpuError> {
    for piece in pieces {
        let (words, shape) = (piece.of(name), piece.of(&format!("{name} shape")));
        let pass = Pass::compute(piece.of(title), kernel, piece.count()).read(&shape).read(input);
        renderer.add(pass.read(&words).write_part(radiance, piece.values()))?;
    }
    Ok(())
}

/// Passes that shade receivers in clusters into the rows of the buffer `radiance`.
pub(crate) fn add_clustered(
    renderer: &mut Renderer,
    transfer: &CompressedTransfer,
    (rows, receiver): Rows<'_>,
    radiance: &str,
) -> Result<(), GpuError> {
    check_order(transfer.order())?;
    let table = transfer.table();
    add_light(renderer, "light")?;
    renderer.allocate(radiance, VALUE * rows as u64)?;
    // The products of means and directions with the light are those of receivers, one for each vector.
    let vectors = table.bases().len() / table.width();
    renderer.allocate("cluster colors", VALUE * vectors as u64)?;
    let basis = |v: usize, out: &mut Vec<u32>| {
        pack(&table.bases()[v * table.width()..][..table.width()], Storage::F32, out);
    };
    let bases = upload_rows(renderer, "clusters", vectors, (table.width(), VALUE), basis)?;
    let (coefficients, channels) = (transfer.order().pow(2), transfer.channels().count());
    let kernel = transfer_kernel(renderer.context(), coefficients, channels, Storage::F32)?;
    add_passes(renderer, &kernel, ("clusters", "light"), ("clusters", &bases), "cluster colors")?;
    // The receivers.
    let in_word = match table.weights() {
        TableWeights::U8(_) => 4,
        TableWeights::U16(_) => 2,
        TableWeights::F32(_) => 1,
    };
    let components = table.components();
    let row = |r: usize, out: &mut Vec<u32>| {
        out.clear();
        let r = receiver(r);
        out.push(u32::from(table.clusters()[r]));
        let places = r * components..(r + 1) * components;
        match table.weights() {
            TableWeights::U8(w) => out.extend(w[places].chunks(4).map(|q| word(q.iter().map(|q| u32::from(*q)), 8))),
            TableWeights::U16(w) => out.extend(w[places].chunks(2).map(|q| word(q.iter().map(|q| u32::from(*q)), 16))),
            TableWeights::F32(w) => out.extend(w[places].iter().map(|w| w.to_bits())),
        }
    };
    let pieces = upload_rows(renderer, "weights", rows, (1 + components.div_ceil(in_word), VALUE), row)?;
    let shader = Shader::new(&["clustered"]).constant("COMPONENTS", components).constant("WEIGHTS_IN_WORD", in_word);
    let kernel = Kernel::new(renderer.context(), "clustered", &shader, &CLUSTERED_SLOTS)?;
    add_passes(renderer, &kernel, ("weights", "cluster colors"), ("weights", &pieces), radiance)
}

/// Integers of `bits` bits in a word, the first in the lowest.
fn word(numbers: impl Iterator<Item = u32>, bits: usize) -> u32 {
    numbers.enumerate().fold(0, |word, (k, q)| word | q << (k * bits))
}
