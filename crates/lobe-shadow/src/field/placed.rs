//! An occlusion field where its entity is, looked up for sixteen receivers at once.

use lobe_sh::Rotation;
use lobe_sh::rotation::RotationMatrices;
use lobe_sh::simd::{LANES, Lanes, Wide, constant};
use pulp::Simd;

use crate::field::block_stencil::BlockStencil;
use crate::field::field_grid::RadialInterpolation;
use crate::field::occlusion_field::OcclusionField;
use crate::lane_basis::LaneBasis;
use crate::placement::Placement;

/// The longest row of a field, order 8, filled up to whole registers.
const MAX_ROW: usize = 80;

/// The square of a distance below which there is no direction: the center, where nothing is zonal.
const NO_DISTANCE: f32 = 1e-37;

/// An occlusion field with its place, prepared for lookups whose results are in the directions of the world.
#[derive(Debug)]
pub(crate) struct Placed<'a> {
    field: &'a OcclusionField,
    /// Of rows the first numbers are used: all of `z`, and `g` to the order in use.
    order: usize,
    interpolation: RadialInterpolation,
    /// The matrices of the rotation, band after band and row after row; none for an entity that is not turned.
    turn: Vec<f32>,
    center: [f64; 3],
    radius: f64,
    /// `Rᵀ/(s R)`, from differences in the world to those in the entity's frame, in its radii.
    to_own: [[f32; 3]; 3],
}

/// Coefficients of the highest order.
const MAX_LEN: usize = 64;

/// An expansion for each of sixteen receivers, of which the first `order²` blocks are in use.
pub(crate) type Expansions = [Lanes; MAX_LEN];

/// Those that are 0.
pub(crate) const ZERO: Expansions = [Lanes::ZERO; MAX_LEN];

/// Sixteen points of the world.
pub(crate) type Positions = [[f64; LANES]; 3];

/// The buffers of lookups.
#[derive(Debug)]
pub(crate) struct LookUp {
    stencil: BlockStencil,
    /// `-towards`.
    offset: [Lanes; 3],
    row: [f32; MAX_ROW],
    zonal: [Lanes; 8],
    rest: Expansions,
}

impl Default for LookUp {
    fn default() -> Self {
        let (stencil, offset, zonal) = (BlockStencil::NONE, [Lanes::ZERO; 3], [Lanes::ZERO; 8]);
        Self { stencil, offset, row: [0.0; MAX_ROW], zonal, rest: ZERO }
    }
}

impl<'a> Placed<'a> {
    pub(crate) fn new(
        field: &'a OcclusionField,
        placement: &Placement,
        order: usize,
        interpolation: RadialInterpolation,
    ) -> Self {
        let rotation = placement.rotation();
        let m = rotation.matrix();
        let radius = placement.scale() * field.grid().radius();
        Self {
            field,
            order,
            interpolation,
            turn: if *rotation == Rotation::IDENTITY { Vec::new() } else { matrices(rotation, order) },
            center: placement.to_world(field.grid().center()),
            radius,
            to_own: std::array::from_fn(|k| std::array::from_fn(|c| (m[c][k] / radius) as f32)),
        }
    }

    /// From points of the world to the middle of the entity.
    #[inline(always)]
    pub(crate) fn towards(&self, positions: &Positions) -> [Lanes; 3] {
        let mut towards = [Lanes::ZERO; 3];
        for (towards, (center, positions)) in towards.iter_mut().zip(self.center.iter().zip(positions)) {
            for (towards, position) in towards.0.iter_mut().zip(positions) {
                *towards = (center - position) as f32;
            }
        }
        towards
    }

    /// The radius of the bounding sphere in the world.
    #[inline]
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// The occlusion at those points whose bit is set in `wanted`, in the directions of the world, and 0 at the others:
    /// `order²` blocks.
    #[inline(always)]
    pub(crate) fn occlusion_into<S: Simd>(
        &self,
        simd: S,
        positions: &Positions,
        wanted: u16,
        basis: &LaneBasis,
        scratch: &mut LookUp,
        out: &mut [Lanes],
    ) {
        let towards = self.towards(positions);
        scratch.offset = towards.map(|c| Lanes(c.0.map(|x| -x)));
        match self.interpolation {
            RadialInterpolation::Linear => self.rows_into::<S, 2, 8>(simd, wanted, scratch),
            RadialInterpolation::Cubic => self.rows_into::<S, 4, 16>(simd, wanted, scratch),
        }
        for part in 0..Wide::<S>::PARTS {
            self.turn_into(simd, part, &scratch.rest, out);
            let [x, y, z] = &towards;
            let (x, y, z) = (Wide::load(simd, x, part), Wide::load(simd, y, part), Wide::load(simd, z, part));
            let square = x.times_plus(x, y.times_plus(y, z * z));
            let scale = square.max(constant(simd, NO_DISTANCE)).inverse_sqrt();
            basis.for_each(simd, [x * scale, y * scale, z * scale], |l, i, y| {
                let zonal = Wide::load(simd, &scratch.zonal[l], part);
                y.times_plus(zonal, Wide::load(simd, &out[i], part)).store(&mut out[i], part);
            });
        }
    }

    /// Interpolated rows: `zonal` and `rest` in the entity's frame, lane by lane.
    #[inline(always)]
    fn rows_into<S: Simd, const SPHERES: usize, const TAPS: usize>(&self, simd: S, wanted: u16, scratch: &mut LookUp) {
        let grid = self.field.grid();
        let LookUp { stencil, offset, row, zonal, rest } = scratch;
        stencil.fill::<S, SPHERES>(simd, grid, &self.to_own, offset);
        let n = self.order * self.order;
        zonal[..self.order].fill(Lanes::ZERO);
        rest[..n].fill(Lanes::ZERO);
        for lane in (0..LANES).filter(|lane| wanted >> lane & 1 == 1) {
            if stencil.place[lane] > 0.0 {
                self.row_beyond::<S, SPHERES, TAPS>(simd, stencil, lane, row);
            } else {
                let d = offset.map(|c| c[lane]);
                let own = self.to_own.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
                let width = self.field.width();
                grid.stencil(own, self.interpolation).sum_into(self.field.rows(), &mut row[..width]);
            }
            zonal[..self.order].iter_mut().zip(&*row).for_each(|(z, x)| z[lane] = *x);
            let row = &row[self.field.order()..];
            rest[..n].iter_mut().zip(row).for_each(|(g, x)| g[lane] = *x);
        }
    }

    /// The interpolated row of a point beyond the innermost sphere.
    #[inline(always)]
    fn row_beyond<S: Simd, const SPHERES: usize, const TAPS: usize>(
        &self,
        simd: S,
        stencil: &BlockStencil,
        lane: usize,
        out: &mut [f32; MAX_ROW],
    ) {
        let grid = self.field.grid();
        let (side, width) = (grid.cells() + 1, self.field.width());
        let (first, vertex) = (stencil.sphere[lane] as usize, stencil.vertex[lane] as usize);
        let chunks = (self.field.order() + self.order * self.order).div_ceil(S::F32_LANES);
        let table = self.field.padded_rows();
        let mut rows: [&[S::f32s]; TAPS] = [&[]; TAPS];
        let mut weights = [simd.splat_f32s(0.0); TAPS];
        for tap in 0..TAPS {
            // Of two spheres the first is never the last one; of four those beyond the ends have no weight.
            let sphere = if SPHERES == 2 {
                first + tap / 4
            } else {
                (first + tap / 4).saturating_sub(1).min(grid.spheres() - 1)
            };
            let corner = [0, 1, side, side + 1][tap % 4];
            let row = &table[(sphere * side * side + vertex + corner) * width..][..chunks * S::F32_LANES];
            rows[tap] = S::as_simd_f32s(row).0;
            weights[tap] = simd.splat_f32s(stencil.weights[tap][lane]);
        }
        for (chunk, out) in S::as_mut_simd_f32s(out).0.iter_mut().take(chunks).enumerate() {
            let mut sum = simd.mul_f32s(weights[0], rows[0][chunk]);
            for tap in 1..TAPS {
                sum = simd.mul_add_e_f32s(weights[tap], rows[tap][chunk], sum);
            }
            *out = sum;
        }
    }

    /// Turns the rest into the world.
    #[inline(always)]
    fn turn_into<S: Simd>(&self, simd: S, part: usize, rest: &Expansions, out: &mut [Lanes]) {
        if self.turn.is_empty() {
            for (out, g) in out.iter_mut().zip(&rest[..self.order * self.order]) {
                Wide::load(simd, g, part).store(out, part);
            }
            return;
        }
        let mut rows = &*self.turn;
        for l in 0..self.order {
            let (band, side) = (l * l..(l + 1) * (l + 1), 2 * l + 1);
            let rest = &rest[band.clone()];
            for out in &mut out[band] {
                let (row, others) = rows.split_at(side);
                rows = others;
                let mut sum = constant(simd, row[0]) * Wide::load(simd, &rest[0], part);
                for (entry, g) in row.iter().zip(rest).skip(1) {
                    sum = constant(simd, *entry).times_plus(Wide::load(simd, g, part), sum);
                }
                sum.store(out, part);
            }
        }
    }
}

/// The entries of a rotation, band after band and row after row.
fn matrices(rotation: &Rotation, order: usize) -> Vec<f32> {
    let matrices = RotationMatrices::<f32>::new(rotation, order);
    let rows = |l: isize| (-l..=l).flat_map(move |m| (-l..=l).map(move |n| (l, m, n)));
    (0..order as isize).flat_map(rows).map(|(l, m, n)| matrices.entry(l as usize, m, n)).collect()
}
