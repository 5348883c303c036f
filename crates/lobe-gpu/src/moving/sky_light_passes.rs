//! The passes from visibility to what receivers send back of one sky.

use lobe_shadow::SkyLight;

use crate::error::GpuError;
use crate::moving::straight_line;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::Piece;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;

/// Functions of bands 0, 1, 2, 4, 6 and 8, of which the clamped cosine consists: 1 + 3 + 5 + 9 + 13 + 17.
const MOST_ROWS: usize = 48;

/// The operator of a sky on a device, and the program that applies it.
#[derive(Debug)]
pub(crate) struct SkyLightPasses {
    kernel: Kernel,
    order: usize,
}

impl SkyLightPasses {
    /// Makes room for the operator.
    pub(crate) fn upload(renderer: &mut Renderer, order: usize) -> Result<Self, GpuError> {
        renderer.upload("sky light", &vec![[0.0_f32; 4]; MOST_ROWS * order * order])?;
        let shader = Shader::new(&[]).order(order).module("sky_light").with(&straight_line::sky_light(order));
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Read, Slot::Write];
        Ok(Self { kernel: Kernel::new(renderer.context(), "sky light", &shader, &slots)?, order })
    }

    /// Adds the pass of a piece of the `receivers`, from its part of one buffer, `seen` bytes each, to its values in another.
    pub(crate) fn add(
        &self,
        renderer: &mut Renderer,
        piece: &Piece,
        (input, seen): (&str, u64),
        output: &str,
    ) -> Result<(), GpuError> {
        let own = piece.of("sky light sizes");
        renderer.uniform(&own, &piece.shape())?;
        let pass = Pass::compute(piece.of("sky light"), &self.kernel, piece.count()).read(&own).read("sky light");
        let pass = pass.read(&piece.of("receivers")).read_part(input, piece.part(seen));
        renderer.add(pass.write_part(output, piece.values()))
    }

    /// Sets the light, times a factor.
    pub(crate) fn set(&self, renderer: &Renderer, sky: &SkyLight, factor: f32) -> Result<(), GpuError> {
        if sky.order() != self.order {
            let message = format!("expected light for order {}, found {}", self.order, sky.order());
            return Err(GpuError::Options(message));
        }
        let mut rows: Vec<[f32; 4]> = Vec::new();
        for (j, row) in sky.operator() {
            rows.extend(row.iter().map(|[r, g, b, _]| [factor * r, factor * g, factor * b, j as f32]));
        }
        // Of bands that this light does not have.
        rows.resize(MOST_ROWS * self.order * self.order, [0.0; 4]);
        renderer.update("sky light", &rows)
    }
}
