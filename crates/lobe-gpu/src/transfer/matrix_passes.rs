//! The passes of glossy receivers: their incident light, blurred by the lobe of the reflection.

use std::f64::consts::PI;

use lobe_prt::TransferMatrices;
use lobe_sh::basis::band_and_m;
use lobe_sh::{Rgb, Zonal};

use crate::error::GpuError;
use crate::lookup::basis::check_order;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::{VALUE, pack, upload_rows, words_of};
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::storage::Storage;
use crate::transfer::vector_passes::{Rows, add_light, light_vectors};

/// The light's coefficients, each with the factor `α_l = √(4π/(2l+1)) G_l` of its band.
pub(crate) fn lobe_light(light: &[Rgb<f64>], lobe: &Zonal, order: usize) -> Vec<[f32; 4]> {
    let mut vectors = light_vectors(light, order);
    for (i, vector) in vectors.iter_mut().enumerate() {
        let (l, _) = band_and_m(i);
        let zonal = lobe.coefficients().get(l).copied().unwrap_or(0.0);
        vector[3] = ((4.0 * PI / (2 * l + 1) as f64).sqrt() * zonal) as f32;
    }
    vectors
}

/// Bytes of the incident light of a point.
pub(crate) fn incident_bytes(matrices: &TransferMatrices) -> u64 {
    VALUE * matrices.order().pow(2) as u64
}

/// The passes that make the blurred incident light of points, rows of the buffer `incident` under `light`; both names,
/// and those of the matrices, end in `of`, which tells several sets of points apart.
pub(crate) fn add_incident(
    renderer: &mut Renderer,
    matrices: &TransferMatrices,
    storage: Storage,
    (rows, point): Rows<'_>,
    of: &str,
) -> Result<(), GpuError> {
    let (order, vector) = (matrices.order(), incident_bytes(matrices));
    check_order(order)?;
    let [light, incident, name] = ["light", "incident", "matrices"].map(|name| format!("{name}{of}"));
    add_light(renderer, &light)?;
    let (coefficients, numbers) = (order * order, order.pow(4) * matrices.channels().count());
    renderer.allocate(&incident, vector * rows as u64)?;
    let row = |r: usize, out: &mut Vec<u32>| {
        pack(&matrices.coefficients()[point(r) * numbers..][..numbers], storage, out);
    };
    let pieces = upload_rows(renderer, &name, rows, (words_of(numbers, storage), vector), row)?;
    let shader = Shader::new(&["glossy"])
        .constant("COEFFICIENTS", coefficients)
        .constant("CHANNELS", matrices.channels().count())
        .constant("HALF", usize::from(storage == Storage::F16));
    let slots = [Slot::Uniform, Slot::Uniform, Slot::Read, Slot::Write];
    let kernel = Kernel::new(renderer.context(), "glossy", &shader, &slots)?;
    for piece in &pieces {
        let (words, shape) = (piece.of(&name), piece.of(&format!("{name} shape")));
        let pass = Pass::compute(&words, &kernel, piece.count() * coefficients as u32);
        renderer.add(pass.read(&shape).read(&light).read(&words).write_part(&incident, piece.part(vector)))?;
    }
    Ok(())
}
