//! Transfer of matte vertices in a texture, for devices whose shaders read no buffers.

use half::f16;
use lobe_prt::{Channels, Receivers, Transfer};
use lobe_scene::Scene;
use lobe_sh::{Dir, Zonal, eval_basis};

use crate::lookup::basis::check_order;
use crate::renderer::renderer::Renderer;
use crate::transfer::gpu_transfer::add_light;
use crate::{GpuError, Storage};

/// The largest number of half precision.
const MOST: f32 = 65504.0;

/// Uploads the texture `transfer`: one texel for each coefficient of a vertex, side by side, with the colors in its channels; as many
/// vertices in a row as fit. The shader `draw_transfer` sums them.
///
/// # Errors
/// [`GpuError::Unsupported`] if they do not fit a texture of the device.
pub(crate) fn add_transfer_texture(
    renderer: &mut Renderer,
    transfer: &Transfer,
    storage: Storage,
) -> Result<(), GpuError> {
    check_order(transfer.order())?;
    add_light(renderer, "light")?;
    let most = renderer.context().device().limits().max_texture_dimension_2d as usize;
    let (count, receivers) = (transfer.order().pow(2), transfer.receivers().max(1));
    let columns = (most / count).min(receivers);
    let rows = receivers.div_ceil(columns);
    if rows > most {
        let message = format!("expected at most {} vertices of this order, found {receivers}", columns * most);
        return Err(GpuError::Unsupported { place: "transfer in a texture".into(), message });
    }
    let texels = texels(transfer, columns * rows);
    let size = [(columns * count) as u32, rows as u32];
    match storage {
        Storage::F32 => renderer.upload_texture("transfer", size, wgpu::TextureFormat::Rgba32Float, &texels),
        Storage::F16 => {
            let halves: Vec<[u16; 4]> =
                texels.iter().map(|texel| texel.map(|c| f16::from_f32(c.clamp(-MOST, MOST)).to_bits())).collect();
            renderer.upload_texture("transfer", size, wgpu::TextureFormat::Rgba16Float, &halves)
        }
    }
}

/// The texels of all vertices, and zeros to this many vertices.
fn texels(transfer: &Transfer, vertices: usize) -> Vec<[f32; 4]> {
    let count = transfer.order().pow(2);
    let channels = transfer.channels().count();
    let mut texels = Vec::with_capacity(vertices * count);
    for vector in transfer.coefficients().chunks_exact(channels * count) {
        texels.extend((0..count).map(|i| {
            let of = |channel: usize| vector[channel.min(channels - 1) * count + i];
            [of(0), of(1), of(2), 0.0]
        }));
    }
    texels.resize(vertices * count, [0.0; 4]);
    texels
}

/// What a scene does to light without shadows, at its vertices.
///
/// ```text
///   T_lm = albedo/π A_l y_lm(n)        B = Σ_lm L_lm T_lm = albedo/π E(n)
/// ```
///
/// # Errors
/// [`GpuError::Options`] if the order is out of range or the scene has no vertices.
pub(crate) fn unshadowed(scene: &Scene, order: usize) -> Result<Transfer, GpuError> {
    check_order(order)?;
    let refused = |error: lobe_prt::PrtError| GpuError::Options(error.to_string());
    let receivers = Receivers::at_vertices(scene).map_err(refused)?;
    let cosine = Zonal::clamped_cosine(order).convolution_factors();
    let mut coefficients = Vec::with_capacity(receivers.len() * 3 * order * order);
    for (normal, albedo) in receivers.normals().iter().zip(receivers.albedos()) {
        // Receivers have no normals of length zero.
        let Some(normal) = Dir::new(normal.map(f64::from)) else { unreachable!("a normal of a receiver") };
        let basis = eval_basis(normal, order);
        for channel in albedo {
            let scale = f64::from(*channel) / std::f64::consts::PI;
            coefficients.extend(basis.iter().enumerate().map(|(i, y)| (scale * cosine[i.isqrt()] * y) as f32));
        }
    }
    Transfer::new(order, Channels::Rgb, coefficients).map_err(refused)
}
