//! The passes that sum up the logarithms of spheres, and their exponential on a grid.

use bytemuck::{Pod, Zeroable};
use lobe_sh::eval_basis;
use lobe_sh::exponential::ExpMethod;
use lobe_shadow::{LogTable, SphereShadows};

use crate::error::GpuError;
use crate::moving::straight_line::{self, LANES, point_vectors};
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::Piece;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Sizes {
    receivers: u32,
    spheres: u32,
    intervals: u32,
    fit_end: f32,
    points: u32,
    unused: [u32; 3],
}

/// Spheres on a device, with room for some, and the program that says what they leave of the sky.
#[derive(Debug)]
pub(crate) struct SpherePasses {
    kernel: Kernel,
    /// Of each piece, but for its receivers.
    sizes: Sizes,
    most: usize,
}

impl SpherePasses {
    /// Uploads the table, with room for `most` spheres.
    pub(crate) fn upload(renderer: &mut Renderer, table: &LogTable, most: usize) -> Result<Self, GpuError> {
        let (order, most) = (table.order(), most.max(1));
        let (polynomials, fit_end) = table.polynomials();
        let (grid, fit) = (grid(order), polynomials.as_flattened());
        let points = (grid.len() / point_vectors(order)) as u32;
        let intervals = (table.row_count() - 1) as u32;
        renderer.upload("spheres", &vec![[0.0_f32; 16]; most])?;
        renderer.uniform_list("polynomials", fit)?;
        renderer.upload("log table", table.rows())?;
        renderer.upload("grid", &grid)?;
        let shader = Shader::new(&[]).order(order).constant("POLYNOMIALS", fit.len() / LANES).module("accumulate");
        let shader = shader.with(&straight_line::accumulate(order, fit.len() / order));
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Uniform, Slot::Read, Slot::Read, Slot::Write];
        let kernel = Kernel::new(renderer.context(), "accumulate", &shader, &slots)?;
        let sizes = Sizes { receivers: 0, spheres: 0, intervals, fit_end, points, unused: [0; 3] };
        Ok(Self { kernel, sizes, most })
    }

    /// Adds the pass of a piece of the `receivers`, which writes its part of a buffer, `seen` bytes each.
    pub(crate) fn add(
        &self,
        renderer: &mut Renderer,
        piece: &Piece,
        (output, seen): (&str, u64),
    ) -> Result<(), GpuError> {
        let own = piece.of("sphere sizes");
        renderer.uniform(&own, &Sizes { receivers: piece.count(), ..self.sizes })?;
        let pass = Pass::compute(piece.of("accumulate"), &self.kernel, piece.count()).read(&own);
        let pass = pass.read(&piece.of("receivers")).read("spheres").read("polynomials").read("log table").read("grid");
        renderer.add(pass.write_part(output, piece.part(seen)))
    }

    /// Sets the spheres: those of `shadows`, with what each shares with those that overlap it.
    pub(crate) fn set(
        &mut self,
        renderer: &Renderer,
        pieces: &[Piece],
        shadows: Option<&SphereShadows<'_>>,
    ) -> Result<(), GpuError> {
        let shape = |(sphere, share): (lobe_shadow::Occluder, [f32; 10])| {
            let mut shape = [0.0; 16];
            shape[..3].copy_from_slice(&sphere.center);
            shape[3] = sphere.radius;
            shape[4..14].copy_from_slice(&share);
            shape
        };
        let spheres: Vec<[f32; 16]> = shadows.into_iter().flat_map(SphereShadows::shares).map(shape).collect();
        if spheres.len() > self.most {
            let message = format!("expected at most {} spheres, found {}", self.most, spheres.len());
            return Err(GpuError::Options(message));
        }
        self.sizes.spheres = spheres.len() as u32;
        renderer.update("spheres", &spheres)?;
        pieces.iter().try_for_each(|piece| {
            renderer.update(&piece.of("sphere sizes"), &[Sizes { receivers: piece.count(), ..self.sizes }])
        })
    }
}

/// For each point of the grid of [`ExpMethod::Grid`] the basis, then the weight, as whole vectors.
fn grid(order: usize) -> Vec<[f32; LANES]> {
    let rule = ExpMethod::grid(order);
    let point = |(s, weight)| {
        let mut numbers: Vec<f32> = eval_basis(s, order).into_iter().chain([weight]).map(|x| x as f32).collect();
        numbers.resize(LANES * point_vectors(order), 0.0);
        numbers
    };
    let numbers: Vec<f32> = rule.points().flat_map(point).collect();
    bytemuck::cast_slice(&numbers).to_vec()
}
