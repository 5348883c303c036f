//! Visibility of the sky beside the still parts, on a grid.

use bytemuck::{Pod, Zeroable};
use lobe_sh::Rotation;
use lobe_shadow::Placement;

use crate::error::GpuError;
use crate::moving::field_passes::{entries, turn_entries};
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::Piece;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;

/// Visibility of the sky at the points of a grid in the world, linear in between along each axis; beyond it that of the nearest point.
#[derive(Clone, Copy, Debug)]
pub struct StillGrid<'a> {
    /// Number of bands of a point, at least as many as are used.
    pub order: usize,
    /// The first point.
    pub min: [f64; 3],
    /// The distance of neighbors along each axis.
    pub step: [f64; 3],
    /// Points along each axis, at least two.
    pub counts: [usize; 3],
    /// `order²` numbers of each point, x rising first.
    pub rows: &'a [f32],
}

impl StillGrid<'_> {
    fn check(&self, order: usize) -> Result<(), GpuError> {
        let refuse = |message: String| Err(GpuError::Options(message));
        if self.order < order {
            return refuse(format!("expected a grid of {order} bands at least, found {}", self.order));
        }
        let expected = self.order.pow(2) * self.counts.iter().product::<usize>();
        if self.counts.iter().any(|count| *count < 2) || self.rows.len() != expected {
            let found = self.rows.len();
            return refuse(format!(
                "expected a grid of two points along each axis at least and {expected} numbers, found {found}"
            ));
        }
        Ok(())
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct GridShape {
    to_place: [[f32; 4]; 3],
    counts: [u32; 4],
    receivers: [u32; 4],
}

/// One grid on a device, and the program that looks it up.
#[derive(Debug)]
pub(crate) struct GridPasses {
    kernel: Kernel,
    number: usize,
    order: usize,
    min: [f64; 3],
    step: [f64; 3],
    shape: GridShape,
}

impl GridPasses {
    /// Uploads a grid, the `number`th.
    pub(crate) fn upload(
        renderer: &mut Renderer,
        order: usize,
        number: usize,
        grid: &StillGrid<'_>,
    ) -> Result<Self, GpuError> {
        grid.check(order)?;
        renderer.upload(&format!("visibility grid {number}"), grid.rows)?;
        renderer.upload(&format!("turn of grid {number}"), &vec![0.0_f32; entries(order)])?;
        if !renderer.has("no visibility") {
            renderer.upload("no visibility", &[0.0_f32; 4])?;
        }
        let shader = Shader::new(&[]).order(order).product(order).module("still_visibility");
        let slots = [[Slot::Uniform].as_slice(), &[Slot::Read; 4], &[Slot::Write]].concat();
        let kernel = Kernel::new(renderer.context(), "still visibility", &shader, &slots)?;
        let [x, y, z] = grid.counts.map(|count| count as u32);
        let counts = [x, y, z, (grid.order * grid.order) as u32];
        let shape = GridShape { counts, ..GridShape::zeroed() };
        Ok(Self { kernel, number, order, min: grid.min, step: grid.step, shape })
    }

    /// Adds the pass of a piece of the `receivers`, from what they see already to that and the grid: parts of buffers, `seen` bytes each.
    pub(crate) fn add(
        &mut self,
        renderer: &mut Renderer,
        piece: &Piece,
        (before, after, seen): (Option<&str>, &str, u64),
    ) -> Result<(), GpuError> {
        self.shape.receivers[2] = u32::from(before.is_some());
        let own = self.shape_name(piece);
        renderer.uniform(&own, &self.shape)?;
        let name = piece.of(&format!("still visibility {} of", self.number));
        let pass = Pass::compute(name, &self.kernel, piece.count()).read(&own).read(&piece.of("receivers"));
        let pass =
            pass.read(&format!("visibility grid {}", self.number)).read(&format!("turn of grid {}", self.number));
        let pass = match before {
            Some(before) => pass.read_part(before, piece.part(seen)),
            None => pass.read("no visibility"),
        };
        renderer.add(pass.write_part(after, piece.part(seen)))
    }

    /// Says where the frame of the receivers is in the world.
    pub(crate) fn place(&self, renderer: &Renderer, pieces: &[Piece], frame: &Placement) -> Result<(), GpuError> {
        let to_own = frame.rotation().inverse();
        let is_turned = to_own != Rotation::IDENTITY;
        if is_turned {
            renderer.update(&format!("turn of grid {}", self.number), &turn_entries(&to_own, self.order))?;
        }
        // The place of the world's point M p + t is (M p + t - min)/step.
        let (m, t) = (frame.rotation().matrix(), frame.translation());
        let row = |k: usize| {
            let [a, b, c] = [0, 1, 2].map(|c| (m[k][c] * frame.scale() / self.step[k]) as f32);
            [a, b, c, ((t[k] - self.min[k]) / self.step[k]) as f32]
        };
        let to_place = [0, 1, 2].map(row);
        pieces.iter().try_for_each(|piece| {
            let receivers = [piece.count(), u32::from(is_turned), self.shape.receivers[2], 0];
            renderer.update(&self.shape_name(piece), &[GridShape { to_place, receivers, ..self.shape }])
        })
    }

    fn shape_name(&self, piece: &Piece) -> String {
        piece.of(&format!("shape of grid {} for", self.number))
    }
}
