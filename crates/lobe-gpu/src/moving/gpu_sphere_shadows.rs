//! The shadows of spheres on the device.

use bytemuck::{Pod, Zeroable};
use lobe_sh::{ExpMethod, Rgb, eval_basis};
use lobe_shadow::{LogTable, ShadowReceivers, SkyLight, SphereShadows};

use crate::lookup::basis::check_order;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::{Context, GpuError};

/// Functions of bands 0, 1, 2, 4, 6 and 8, of which the clamped cosine consists: 1 + 3 + 5 + 9 + 13 + 17.
const MOST_ROWS: usize = 48;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Sizes {
    receivers: u32,
    spheres: u32,
    intervals: u32,
    fit_end: f32,
}

/// Receivers under a sky that spheres hide, on a device: [`SphereShadows`] with every receiver and every sphere by itself, the
/// exponential on the grid.
///
/// ```text
///   V = exp(Σ_spheres log V_sphere)        E(n) = ∫ V L max(n·s, 0) ds
/// ```
///
/// Passes `accumulate` and `sky light`. Spheres may move between two calls, as many as there is room for.
#[derive(Debug)]
pub struct GpuSphereShadows {
    renderer: Renderer,
    sizes: Sizes,
    order: usize,
    most_spheres: usize,
}

impl GpuSphereShadows {
    /// Uploads receivers and the table, with room for `most_spheres` spheres.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if they do not fit the device; [`GpuError::Device`] if the device fails.
    pub fn new(
        context: &Context,
        table: &LogTable,
        receivers: &ShadowReceivers<'_>,
        most_spheres: usize,
    ) -> Result<Self, GpuError> {
        let (order, count) = (table.order(), receivers.len());
        check_order(order)?;
        let n = order * order;
        let (polynomials, fit_end) = table.polynomials();
        let sizes = Sizes { receivers: count as u32, spheres: 0, intervals: (table.row_count() - 1) as u32, fit_end };
        let mut renderer = Renderer::new(context);
        renderer.uniform("sizes", &sizes)?;
        renderer.upload("receivers", &receiver_shapes(receivers))?;
        renderer.upload("spheres", &vec![[0.0_f32; 16]; most_spheres.max(1)])?;
        renderer.upload("log table", &[polynomials.as_flattened(), table.rows()].concat())?;
        renderer.upload("grid", &grid(order))?;
        renderer.allocate("visibility", 4 * (n * count) as u64)?;
        let shader = Shader::new(&[]).order(order).module("accumulate");
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Read, Slot::Read, Slot::Write];
        let kernel = Kernel::new(context, "accumulate", &shader, &slots)?;
        let pass = Pass::compute("accumulate", &kernel, count as u32).read("sizes").read("receivers");
        renderer.add(pass.read("spheres").read("log table").read("grid").write("visibility"))?;
        renderer.upload("sky light", &vec![[0.0_f32; 4]; MOST_ROWS * n])?;
        renderer.allocate("irradiance", 16 * count as u64)?;
        let shader = Shader::new(&[]).order(order).module("sky_light");
        let slots = [Slot::Read, Slot::Read, Slot::Read, Slot::Write];
        let kernel = Kernel::new(context, "sky light", &shader, &slots)?;
        let pass = Pass::compute("sky light", &kernel, count as u32).read("sky light").read("receivers");
        renderer.add(pass.read("visibility").write("irradiance"))?;
        Ok(Self { renderer, sizes, order, most_spheres: most_spheres.max(1) })
    }

    /// The passes, and the buffers `visibility` and `irradiance` that they write.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Sets the spheres: those of `shadows`, with what each shares with those that overlap it.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there is no room for as many.
    pub fn set_spheres(&mut self, shadows: &SphereShadows<'_>) -> Result<(), GpuError> {
        let spheres: Vec<[f32; 16]> = shadows
            .shares()
            .map(|(sphere, share)| {
                let mut shape = [0.0; 16];
                shape[..3].copy_from_slice(&sphere.center);
                shape[3] = sphere.radius;
                shape[4..13].copy_from_slice(&share);
                shape
            })
            .collect();
        if spheres.len() > self.most_spheres {
            let message = format!("expected at most {} spheres, found {}", self.most_spheres, spheres.len());
            return Err(GpuError::Options(message));
        }
        self.sizes.spheres = spheres.len() as u32;
        self.renderer.update("spheres", &spheres)?;
        self.renderer.update("sizes", &[self.sizes])
    }

    /// The irradiance of every receiver from a sky that the spheres hide.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the light is prepared for another order; [`GpuError::Device`] if the device fails.
    pub fn irradiance(&self, sky: &SkyLight) -> Result<Vec<Rgb<f32>>, GpuError> {
        if sky.order() != self.order {
            let message = format!("expected light for order {}, found {}", self.order, sky.order());
            return Err(GpuError::Options(message));
        }
        let mut rows: Vec<[f32; 4]> = Vec::new();
        for (j, row) in sky.operator() {
            rows.extend(row.iter().map(|[r, g, b, _]| [*r, *g, *b, j as f32]));
        }
        // Of bands that this light does not have.
        rows.resize(MOST_ROWS * self.order * self.order, [0.0; 4]);
        self.renderer.update("sky light", &rows)?;
        self.renderer.run()?;
        let values: Vec<[f32; 4]> = self.renderer.read("irradiance", self.sizes.receivers as usize)?;
        Ok(values.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect())
    }

    /// What each receiver sees of the sky, `order²` coefficients one after the other.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn visibility(&self) -> Result<Vec<f32>, GpuError> {
        let (n, count) = (self.order * self.order, self.sizes.receivers as usize);
        self.renderer.run()?;
        let values: Vec<f32> = self.renderer.read("visibility", n * count)?;
        Ok((0..count).flat_map(|r| (0..n).map(move |i| i * count + r)).map(|k| values[k]).collect())
    }
}

/// Positions and normals for shaders.
pub(crate) fn receiver_shapes(receivers: &ShadowReceivers<'_>) -> Vec<[f32; 8]> {
    let all = receivers.positions().iter().zip(receivers.normals());
    all.map(|(p, n)| [p[0], p[1], p[2], 1.0, n[0], n[1], n[2], 0.0]).collect()
}

/// For each point of the grid of [`ExpMethod::Grid`] the basis, then the weight.
fn grid(order: usize) -> Vec<f32> {
    let rule = ExpMethod::grid(order);
    let point = |(s, weight)| eval_basis(s, order).into_iter().chain([weight]).map(|x| x as f32);
    rule.points().flat_map(point).collect()
}
