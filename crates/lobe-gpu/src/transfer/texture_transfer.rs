//! Transfer of matte vertices in a texture, for devices whose shaders read no buffers.

use std::ops::Range;

use half::f16;
use lobe_prt::{Channels, Receivers, Transfer};
use lobe_scene::Scene;
use lobe_sh::{Dir, Zonal, eval_basis};

use crate::context::context::Context;
use crate::error::GpuError;
use crate::lookup::basis::check_order;
use crate::renderer::renderer::Renderer;
use crate::storage::Storage;
use crate::transfer::reflecting_transfer::ReflectingTransfer;
use crate::transfer::vector_passes::add_light;

/// The largest number of half precision.
const MOST: f32 = 65504.0;

/// Vertices at most in a texture of the device, for transfer of so many coefficients.
pub(crate) fn vertices_in_texture(context: &Context, coefficients: usize) -> usize {
    let most = context.max_texture_side() as usize;
    most / coefficients.max(1) * most
}

/// Uploads a texture of the transfer of vertices: one texel for each coefficient of a vertex, side by side, with the colors in its
/// channels; as many vertices in a row as fit. The shader `draw_transfer` sums them. `vertices` are places and the vertex in each.
///
/// # Errors
/// [`GpuError::Unsupported`] if they do not fit a texture of the device.
pub(crate) fn add_transfer_texture(
    renderer: &mut Renderer,
    transfer: &ReflectingTransfer<'_>,
    storage: Storage,
    (places, vertex): (Range<usize>, &dyn Fn(usize) -> usize),
    name: &str,
) -> Result<(), GpuError> {
    add_light(renderer, "light")?;
    let most = renderer.context().max_texture_side() as usize;
    let (count, vertices) = (transfer.coefficients(), places.len().max(1));
    let columns = (most / count).clamp(1, vertices);
    let rows = vertices.div_ceil(columns);
    let mut texels = Vec::with_capacity(columns * rows * count);
    let mut channels: [Vec<f32>; 3] = Default::default();
    for place in places {
        for (channel, numbers) in channels.iter_mut().enumerate() {
            numbers.clear();
            transfer.append(vertex(place), channel, numbers);
        }
        texels.extend((0..count).map(|i| [channels[0][i], channels[1][i], channels[2][i], 0.0]));
    }
    texels.resize(columns * rows * count, [0.0; 4]);
    let size = [(columns * count) as u32, rows as u32];
    match storage {
        Storage::F32 => renderer.upload_texture(name, size, wgpu::TextureFormat::Rgba32Float, &texels),
        Storage::F16 => {
            let halves: Vec<[u16; 4]> =
                texels.iter().map(|texel| texel.map(|c| f16::from_f32(c.clamp(-MOST, MOST)).to_bits())).collect();
            renderer.upload_texture(name, size, wgpu::TextureFormat::Rgba16Float, &halves)
        }
    }
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
