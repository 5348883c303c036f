//! Glossy receivers on the device.

use std::f64::consts::PI;

use lobe_prt::TransferMatrices;
use lobe_sh::{Rgb, Zonal, band_and_m};

use crate::lookup::basis::check_order;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::transfer::gpu_transfer::{add_light, light_vectors};
use crate::transfer::pieces::{VALUE, pack, upload_rows, words_of};
use crate::{Context, GpuError, Storage};

/// Transfer matrices of glossy receivers on a device.
///
/// ```text
///   incident:  α_l (M L)_lm          towards the eye:  B(v) = Σ_lm α_l (M L)_lm y_lm(r),  r = 2 (n·v) n - v
/// ```
///
/// As [`TransferMatrices::exit_radiance`]. The first pass needs doing once for each light, the second for each eye.
#[derive(Debug)]
pub struct GpuMatrices {
    renderer: Renderer,
    order: usize,
    points: usize,
}

impl GpuMatrices {
    /// Uploads matrices, with the position and the unit normal of each point.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are not as many positions and normals as points; [`GpuError::Unsupported`] if they do not
    /// fit the device; [`GpuError::Device`] if the device fails.
    pub fn new(
        context: &Context,
        matrices: &TransferMatrices,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        storage: Storage,
    ) -> Result<Self, GpuError> {
        let (order, points) = (matrices.order(), matrices.points());
        if positions.len() != points || normals.len() != points {
            let (p, n) = (positions.len(), normals.len());
            return Err(GpuError::Options(format!("expected {points} positions and normals, found {p} and {n}")));
        }
        let mut renderer = Renderer::new(context);
        add_incident(&mut renderer, matrices, storage, "")?;
        let receivers = positions.iter().zip(normals);
        let receivers: Vec<[f32; 8]> = receivers.map(|(p, n)| [p[0], p[1], p[2], 1.0, n[0], n[1], n[2], 0.0]).collect();
        renderer.upload("receivers", &receivers)?;
        renderer.uniform("eye", &[0.0_f32; 4])?;
        renderer.allocate("radiance", VALUE * points as u64)?;
        let shader = Shader::new(&[]).order(order).module("glossy_exit");
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Write];
        let kernel = Kernel::new(context, "glossy exit", &shader, &slots)?;
        let pass = Pass::compute("glossy exit", &kernel, points as u32);
        renderer.add(pass.read("eye").read("incident").read("receivers").write("radiance"))?;
        Ok(Self { renderer, order, points })
    }

    /// The passes, and the buffers `incident` and `radiance` that they write.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The radiance of every point towards an eye, under a light and with a lobe.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device was lost or refused work.
    pub fn exit_radiance(&self, light: &[Rgb<f64>], lobe: &Zonal, eye: [f32; 3]) -> Result<Vec<Rgb<f32>>, GpuError> {
        if self.points == 0 {
            return Ok(Vec::new());
        }
        self.renderer.update("light", &lobe_light(light, lobe, self.order))?;
        self.renderer.update("eye", &eye)?;
        self.renderer.run()?;
        let values: Vec<[f32; 4]> = self.renderer.read("radiance", self.points)?;
        Ok(values.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect())
    }
}

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

/// The passes that make the blurred incident light of every point, buffer `incident` under `light`; both names, and those of the
/// matrices, end in `of`, which tells several sets of points apart.
pub(crate) fn add_incident(
    renderer: &mut Renderer,
    matrices: &TransferMatrices,
    storage: Storage,
    of: &str,
) -> Result<(), GpuError> {
    let (order, points) = (matrices.order(), matrices.points());
    check_order(order)?;
    let [light, incident, name] = ["light", "incident", "matrices"].map(|name| format!("{name}{of}"));
    add_light(renderer, &light)?;
    let (coefficients, numbers) = (order * order, order.pow(4) * matrices.channels().count());
    renderer.allocate(&incident, VALUE * (points * coefficients) as u64)?;
    let row = |r: usize, out: &mut Vec<u32>| pack(&matrices.coefficients()[r * numbers..][..numbers], storage, out);
    let pieces = upload_rows(renderer, &name, points, words_of(numbers, storage), row)?;
    let shader = Shader::new(&["glossy"])
        .constant("COEFFICIENTS", coefficients)
        .constant("CHANNELS", matrices.channels().count())
        .constant("HALF", usize::from(storage == Storage::F16));
    let slots = [Slot::Uniform, Slot::Uniform, Slot::Read, Slot::Write];
    let kernel = Kernel::new(renderer.context(), "glossy", &shader, &slots)?;
    for piece in &pieces {
        let pass = Pass::compute(&piece.words, &kernel, piece.count() * coefficients as u32);
        renderer.add(pass.read(&piece.shape).read(&light).read(&piece.words).write(&incident))?;
    }
    Ok(())
}
