//! Glossy receivers on the device.

use std::f64::consts::PI;

use lobe_prt::TransferMatrices;
use lobe_sh::{Rgb, Zonal, band_and_m};

use crate::lookup::basis::check_order;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::{VALUE, cut, pack, upload_rows, words_of};
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::transfer::gpu_transfer::{Rows, add_light, light_vectors};
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
        add_incident(&mut renderer, matrices, storage, (points, &|r| r), "")?;
        renderer.uniform("eye", &[0.0_f32; 4])?;
        renderer.allocate("radiance", VALUE * points as u64)?;
        let shader = Shader::new(&[]).order(order).module("glossy_exit");
        let slots = [Slot::Uniform, Slot::Uniform, Slot::Read, Slot::Read, Slot::Write];
        let kernel = Kernel::new(context, "glossy exit", &shader, &slots)?;
        let incident = incident_bytes(matrices);
        for piece in cut(context, "receivers", points, size_of::<Receiver>() as u64, &[incident, VALUE])? {
            let (shape, receivers) = (piece.of("receivers shape"), piece.of("receivers"));
            renderer.uniform(&shape, &piece.shape())?;
            let shapes = positions[piece.items.clone()].iter().zip(&normals[piece.items.clone()]);
            renderer.upload(&receivers, &shapes.map(receiver).collect::<Vec<_>>())?;
            let pass = Pass::compute(piece.of("glossy exit"), &kernel, piece.count());
            let pass = pass.read("eye").read(&shape).read(&receivers).read_part("incident", piece.part(incident));
            renderer.add(pass.write_part("radiance", piece.values()))?;
        }
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

/// A position and a unit normal, each with a fourth number.
type Receiver = [f32; 8];

fn receiver((p, n): (&[f32; 3], &[f32; 3])) -> Receiver {
    [p[0], p[1], p[2], 1.0, n[0], n[1], n[2], 0.0]
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

/// Bytes of the incident light of a point.
pub(crate) fn incident_bytes(matrices: &TransferMatrices) -> u64 {
    VALUE * matrices.order().pow(2) as u64
}

/// The passes that make the blurred incident light of points, rows of the buffer `incident` under `light`; both names, and those of the
/// matrices, end in `of`, which tells several sets of points apart.
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
