//! The shadows of spheres on the device.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use lobe_sh::{ExpMethod, Rgb, eval_basis};
use lobe_shadow::{LogTable, ShadowReceivers, SkyLight, SphereShadows};

use crate::lookup::basis::check_order;
use crate::moving::straight_line::{self, LANES, point_vectors};
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::{Piece, VALUE, cut};
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
    points: u32,
    unused: [u32; 3],
}

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
    /// Of each piece, but for its receivers.
    sizes: Sizes,
    pieces: Vec<Piece>,
    receivers: usize,
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
        let (grid, fit) = (grid(order), polynomials.as_flattened());
        let points = (grid.len() / point_vectors(order)) as u32;
        let intervals = (table.row_count() - 1) as u32;
        let sizes = Sizes { receivers: 0, spheres: 0, intervals, fit_end, points, unused: [0; 3] };
        let mut renderer = Renderer::new(context);
        renderer.upload("spheres", &vec![[0.0_f32; 16]; most_spheres.max(1)])?;
        renderer.uniform_list("polynomials", fit)?;
        renderer.upload("log table", table.rows())?;
        renderer.upload("grid", &grid)?;
        renderer.upload("sky light", &vec![[0.0_f32; 4]; MOST_ROWS * n])?;
        renderer.allocate("visibility", 4 * (n * count) as u64)?;
        renderer.allocate("irradiance", VALUE * count as u64)?;
        let shader = Shader::new(&[]).order(order).constant("POLYNOMIALS", fit.len() / LANES).module("accumulate");
        let shader = shader.with(&straight_line::accumulate(order, fit.len() / order));
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Uniform, Slot::Read, Slot::Read, Slot::Write];
        let accumulate = Kernel::new(context, "accumulate", &shader, &slots)?;
        let shader = Shader::new(&[]).order(order).module("sky_light").with(&straight_line::sky_light(order));
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Read, Slot::Write];
        let sky_light = Kernel::new(context, "sky light", &shader, &slots)?;
        let seen = 4 * n as u64;
        let pieces = cut(context, "receivers", count, size_of::<ReceiverShape>() as u64, &[seen, VALUE])?;
        for piece in &pieces {
            let (own, at) = (piece.of("sizes"), piece.of("receivers"));
            renderer.uniform(&own, &Sizes { receivers: piece.count(), ..sizes })?;
            renderer.upload(&at, &receiver_shapes(receivers, piece.items.clone()))?;
            let pass = Pass::compute(piece.of("accumulate"), &accumulate, piece.count()).read(&own).read(&at);
            let pass = pass.read("spheres").read("polynomials").read("log table").read("grid");
            renderer.add(pass.write_part("visibility", piece.part(seen)))?;
            let pass = Pass::compute(piece.of("sky light"), &sky_light, piece.count()).read(&own).read("sky light");
            let pass = pass.read(&at).read_part("visibility", piece.part(seen));
            renderer.add(pass.write_part("irradiance", piece.values()))?;
        }
        Ok(Self { renderer, sizes, pieces, receivers: count, order, most_spheres: most_spheres.max(1) })
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
        self.pieces.iter().try_for_each(|piece| {
            self.renderer.update(&piece.of("sizes"), &[Sizes { receivers: piece.count(), ..self.sizes }])
        })
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
        let values: Vec<[f32; 4]> = self.renderer.read("irradiance", self.receivers)?;
        Ok(values.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect())
    }

    /// What each receiver sees of the sky, `order²` coefficients one after the other.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn visibility(&self) -> Result<Vec<f32>, GpuError> {
        let n = self.order * self.order;
        self.renderer.run()?;
        let values: Vec<f32> = self.renderer.read("visibility", n * self.receivers)?;
        // Coefficient by coefficient in each piece.
        let of_piece = |piece: &Piece| {
            let (first, count) = (n * piece.items.start, piece.items.len());
            (0..count).flat_map(move |r| (0..n).map(move |i| first + i * count + r))
        };
        Ok(self.pieces.iter().flat_map(of_piece).map(|k| values[k]).collect())
    }
}

/// A position and a unit normal for shaders, each with a fourth number.
type ReceiverShape = [f32; 8];

fn receiver_shapes(receivers: &ShadowReceivers<'_>, of: Range<usize>) -> Vec<ReceiverShape> {
    let some = receivers.positions()[of.clone()].iter().zip(&receivers.normals()[of]);
    some.map(|(p, n)| [p[0], p[1], p[2], 1.0, n[0], n[1], n[2], 0.0]).collect()
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
