//! The shadows of spheres on the device.

use lobe_sh::Rgb;
use lobe_shadow::{LogTable, ShadowReceivers, SkyLight, SphereShadows};

use crate::context::context::Context;
use crate::error::GpuError;
use crate::lookup::basis::check_order;
use crate::moving::receiver_shapes::{ReceiverShape, white_receiver_shapes};
use crate::moving::sky_light_passes::SkyLightPasses;
use crate::moving::sphere_passes::SpherePasses;
use crate::renderer::pieces::{Piece, VALUE, cut};
use crate::renderer::renderer::Renderer;

/// Receivers under a sky that spheres hide, on a device: [`SphereShadows`] with every receiver and every sphere by itself, the
/// exponential on the grid.
///
/// ```text
///   V = exp(Σ_spheres log V_sphere)        E(n) = ∫ V L max(n·s, 0) ds
/// ```
///
/// Lengths are those of the world, in single precision: distances from 1e-15 to 1e18, where the processor counts in a unit of its own.
///
/// Passes `accumulate` and `sky light`, for as many pieces of the receivers as the bindings of the device demand. Spheres may move
/// between two calls, as many as there is room for. Every receiver looks at all of them, which so have to fit one binding: two
/// million in the 128 MiB of WebGPU.
#[derive(Debug)]
pub struct GpuSphereShadows {
    renderer: Renderer,
    spheres: SpherePasses,
    light: SkyLightPasses,
    pieces: Vec<Piece>,
    receivers: usize,
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
        let seen = 4 * (order * order) as u64;
        let mut renderer = Renderer::new(context);
        let spheres = SpherePasses::upload(&mut renderer, table, most_spheres)?;
        let light = SkyLightPasses::upload(&mut renderer, order)?;
        renderer.allocate("visibility", seen * count as u64)?;
        renderer.allocate("irradiance", VALUE * count as u64)?;
        let pieces = cut(context, "receivers", count, size_of::<ReceiverShape>() as u64, &[seen, VALUE])?;
        for piece in &pieces {
            renderer.upload(&piece.of("receivers"), &white_receiver_shapes(receivers, piece.items.clone()))?;
            spheres.add(&mut renderer, piece, ("visibility", seen))?;
            light.add(&mut renderer, piece, ("visibility", seen), "irradiance")?;
        }
        Ok(Self { renderer, spheres, light, pieces, receivers: count })
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
        self.spheres.set(&self.renderer, &self.pieces, Some(shadows))
    }

    /// The irradiance of every receiver from a sky that the spheres hide.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the light is prepared for another order; [`GpuError::Device`] if the device fails.
    pub fn irradiance(&self, sky: &SkyLight) -> Result<Vec<Rgb<f32>>, GpuError> {
        self.light.set(&self.renderer, sky, 1.0)?;
        self.renderer.run()?;
        let values: Vec<[f32; 4]> = self.renderer.read("irradiance", self.receivers)?;
        Ok(values.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect())
    }
}
