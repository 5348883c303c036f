//! Quadratic patches: biquadratic interpolants of the sample positions of a block of target texels.

use crate::mapping::grid::Grid;
use crate::resample::footprint::{Footprint, Footprints, Quad, Tile};

/// The constant part of the rounding error by which samples leave the range of their patch, in texels.
const MARGIN: f64 = 0.01;
/// The part in proportion to the range R of the control points. In single precision t is off by half a unit in its last
/// place, which moves a parabola by up to 4R units; its coefficients, of up to R, 2R and 2R, add 5R, and four
/// operations 7R: 16R/2²⁴.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// The most texels of a window: one of this size stays in a cache of 256 KiB.
const MOST_IN_WINDOW: usize = 1 << 14;
/// Samples computed together, in vectors of any length.
const LANES: usize = 16;

/// A sample in the source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// In texels of the source from the upper left corner, always inside the picture and on the right face or disc.
    x: f32,
    y: f32,
    /// The solid angle it represents.
    weight: f32,
}

impl Sample {
    #[inline(always)]
    pub(crate) fn new([x, y, weight]: [f64; 3], limits: &Limits) -> Self {
        let held = |c: f64, [least, most]: [f32; 2]| (c as f32).max(least).min(most);
        Self { x: held(x, limits.x), y: held(y, limits.y), weight: weight as f32 }
    }

    pub(crate) fn point(&self) -> [f64; 2] {
        [f64::from(self.x), f64::from(self.y)]
    }

    /// Adds the footprint of the sample.
    pub(crate) fn look(&self, source: Grid, views: &mut Footprints) {
        let taps = source.taps(self.point());
        views.shares.extend(taps.iter().map(|(index, weight)| (index as u32, self.weight * weight)));
    }
}

/// The part of the source's picture that a sample may lie in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) x: [f32; 2],
    pub(crate) y: [f32; 2],
}

/// Position in the source and weight of every sample of a tile:
///
/// ```text
///   f(t, v) = Σ_ij q_ij v^i t^j        i, j = 0 .. 2;  t and v from 0 to 1, from the first sample to the last
/// ```
///
/// It takes a hundredth of the memory of the samples.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    tile: Tile,
    /// Columns and rows of samples in each texel.
    cells: [usize; 2],
    /// `q_ij` for x, y and the weight.
    coefficients: [[[f64; 3]; 3]; 3],
    limits: Limits,
    /// The source texels in the footprints, if all lie within the picture or the face.
    window: Option<Tile>,
}

impl Patch {
    /// Interpolates the values at t, v = 0, 1/2 and 1, those of the same v in a row.
    pub(crate) fn through(
        tile: Tile,
        cells: [usize; 2],
        values: [[[f64; 3]; 3]; 3],
        source: Grid,
        limits: Limits,
    ) -> Self {
        let [a, b, c] = values.map(parabola);
        let column = |j: usize| parabola([a[j], b[j], c[j]]);
        let [p, q, r] = [column(0), column(1), column(2)];
        let coefficients = [0, 1, 2].map(|i| [p[i], q[i], r[i]]);
        Self { tile, cells, coefficients, limits, window: window(&values, source) }
    }

    /// x, y and the weight at a point of the tile.
    pub(crate) fn at(&self, t: f64, v: f64) -> [f64; 3] {
        evaluate(&self.row(v), t)
    }

    /// The parabolas of a row: x, y and the weight with each power of t.
    fn row(&self, v: f64) -> [[f64; 3]; 3] {
        let [p, q, r] = &self.coefficients;
        [0, 1, 2].map(|j| evaluate(&[p[j], q[j], r[j]], v))
    }

    pub(crate) fn tile(&self) -> Tile {
        self.tile
    }

    /// The source texels in the footprints, if a window onto them pays.
    pub(crate) fn window(&self) -> Option<Tile> {
        let samples = self.tile.len() * self.cells[0] * self.cells[1];
        self.window.filter(|window| window.len() <= (2 * samples).min(MOST_IN_WINDOW))
    }

    /// Calls `texel(place, quads)` for every texel of the tile; quads are those of the window.
    #[inline(always)]
    pub(crate) fn for_each_texel_in(
        &self,
        window: Tile,
        quads: &mut Vec<Quad>,
        mut texel: impl FnMut([usize; 2], &[Quad]),
    ) {
        for row in 0..self.tile.height {
            self.find_quads(row, [window.x, window.y], 0, window.width, quads);
            for (x, quads) in (self.tile.x..).zip(quads.chunks_exact(self.cells[0] * self.cells[1])) {
                texel([x, self.tile.y + row], quads);
            }
        }
    }

    /// Calls `texel(place, view)` for every texel of the rows of the tile that are wanted.
    #[inline(always)]
    pub(crate) fn for_each_texel(
        &self,
        source: Grid,
        wants: impl Fn(Tile) -> bool,
        mut texel: impl FnMut([usize; 2], Footprint<'_>),
    ) {
        let (mut quads, mut views) = (Vec::new(), Footprints::default());
        for row in 0..self.tile.height {
            let y = self.tile.y + row;
            if !wants(Tile { y, height: 1, ..self.tile }) {
                continue;
            }
            if let Some(window) = self.window {
                let first = window.y * source.width + window.x;
                self.find_quads(row, [window.x, window.y], first, source.width, &mut quads);
                for (x, quads) in (self.tile.x..).zip(quads.chunks_exact(self.cells[0] * self.cells[1])) {
                    texel([x, y], Footprint { quads, shares: &[] });
                }
            } else {
                for column in 0..self.tile.width {
                    views.clear();
                    self.for_each_sample([column, row], |sample| sample.look(source, &mut views));
                    texel([self.tile.x + column, y], views.all());
                }
            }
        }
    }

    /// The samples of a texel of the tile, row after row.
    pub(crate) fn for_each_sample(&self, [x, y]: [usize; 2], mut each: impl FnMut(Sample)) {
        let ([nx, ny], [step_t, step_v]) = (self.cells, self.steps());
        for j in y * ny..(y + 1) * ny {
            let row = self.row(j as f64 * step_v);
            for k in x * nx..(x + 1) * nx {
                each(Sample::new(evaluate(&row, k as f64 * step_t), &self.limits));
            }
        }
    }

    /// The step from one sample to the next, in t and in v.
    fn steps(&self) -> [f64; 2] {
        [self.tile.width * self.cells[0], self.tile.height * self.cells[1]].map(|n| 1.0 / (n - 1) as f64)
    }

    /// The bilinear footprints of the samples in a row of texels, texel after texel: quads of rows of `columns`
    /// columns, in which the source texel `corner` has the index `first`.
    #[inline(always)]
    fn find_quads(&self, y: usize, corner: [usize; 2], first: usize, columns: usize, quads: &mut Vec<Quad>) {
        let ([nx, ny], [step_t, step_v]) = (self.cells, self.steps());
        quads.resize(self.tile.width * nx * ny, Quad { first: 0, weights: [0.0; 4] });
        for j in 0..ny {
            let mut row = self.row((y * ny + j) as f64 * step_v);
            // Measure from the center of the corner.
            row[0][0] -= corner[0] as f64 + 0.5;
            row[0][1] -= corner[1] as f64 + 0.5;
            let row = row.map(|values| values.map(|value| value as f32));
            let (mut at, mut rest) = (j * nx, nx);
            for start in (0..self.tile.width * nx).step_by(LANES) {
                let lanes = Lanes::of(&row, start, step_t as f32, first as u32, columns as u32);
                for k in 0..LANES.min(self.tile.width * nx - start) {
                    quads[at] = lanes.quad(k);
                    (at, rest) = if rest > 1 { (at + 1, rest - 1) } else { (at + 1 + nx * (ny - 1), nx) };
                }
            }
        }
    }
}

/// Bilinear footprints of consecutive samples of a row, computed together.
struct Lanes {
    firsts: [u32; LANES],
    weights: [[f32; LANES]; 4],
}

impl Lanes {
    /// From sample `start` on; positions are relative to the center of texel `first`.
    #[inline(always)]
    fn of([a, b, c]: &[[f32; 3]; 3], start: usize, step: f32, first: u32, width: u32) -> Self {
        let mut lanes = Self { firsts: [0; LANES], weights: [[0.0; LANES]; 4] };
        for k in 0..LANES {
            let t = (start as i32 + k as i32) as f32 * step;
            let x = a[0] + t * (b[0] + t * c[0]);
            let y = a[1] + t * (b[1] + t * c[1]);
            let weight = a[2] + t * (b[2] + t * c[2]);
            let ((left, s), (above, t)) = (whole(x), whole(y));
            lanes.firsts[k] = first.wrapping_add(above.wrapping_mul(width)).wrapping_add(left);
            let (upper, lower) = (weight * (1.0 - t), weight * t);
            lanes.weights[0][k] = upper * (1.0 - s);
            lanes.weights[1][k] = upper * s;
            lanes.weights[2][k] = lower * (1.0 - s);
            lanes.weights[3][k] = lower * s;
        }
        lanes
    }

    #[inline(always)]
    fn quad(&self, k: usize) -> Quad {
        let [a, b, c, d] = &self.weights;
        Quad { first: self.firsts[k], weights: [a[k], b[k], c[k], d[k]] }
    }
}

/// Splits a number from 0 to 2^22 into its integer part and a fraction from 0 to 1; an integer may be split either way.
#[inline(always)]
fn whole(x: f32) -> (u32, f32) {
    // Floats of this size are integers, whose value is in their last bits.
    const SHIFT: f32 = 12_582_912.0;
    let shifted = (x - 0.5) + SHIFT;
    (shifted.to_bits().wrapping_sub(SHIFT.to_bits()), x - (shifted - SHIFT))
}

/// The source texels that samples of the patch through `values` may touch, if all are within one picture or face.
fn window(values: &[[[f64; 3]; 3]; 3], source: Grid) -> Option<Tile> {
    let [x, y, _] = values[1][1];
    let part = source.inner_part([x, y])?;
    // A quadratic patch lies within the hull of its control points.
    let controls = values.map(controls);
    let column = |j: usize| self::controls([controls[0][j], controls[1][j], controls[2][j]]);
    let controls = [column(0), column(1), column(2)];
    // The first texel, and the number of texels.
    let texels = |k: usize| {
        let range = controls
            .iter()
            .flatten()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| [low.min(point[k]), high.max(point[k])]);
        let beyond = MARGIN + ROUNDING * (range[1] - range[0]);
        let [low, high] = [range[0] - beyond, range[1] + beyond];
        let [first, last] = [low - 0.5, high + 0.5].map(|c| c as usize);
        (low >= part[k][0] && high < part[k][1]).then_some((first, last + 1 - first))
    };
    let ((x, width), (y, height)) = (texels(0)?, texels(1)?);
    Some(Tile { x, y, width, height })
}

/// Bézier's control points of a parabola from its values at 0, 1/2 and 1.
fn controls([start, middle, end]: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [start, [0, 1, 2].map(|k| 2.0 * middle[k] - 0.5 * (start[k] + end[k])), end]
}

/// The coefficients of a parabola from its values at 0, 1/2 and 1.
fn parabola([start, middle, end]: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let b = [0, 1, 2].map(|k| 4.0 * middle[k] - 3.0 * start[k] - end[k]);
    let c = [0, 1, 2].map(|k| 2.0 * (start[k] - 2.0 * middle[k] + end[k]));
    [start, b, c]
}

#[inline(always)]
fn evaluate([a, b, c]: &[[f64; 3]; 3], t: f64) -> [f64; 3] {
    let at = |k: usize| a[k] + t * (b[k] + t * c[k]);
    [at(0), at(1), at(2)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::mapping::Mapping;

    #[test]
    fn numbers_come_apart_into_a_whole_one_and_a_rest() {
        for x in [0.0_f32, 1e-6, 0.3, 0.5, 1.0, 1.5, 2.0, 6.999, 4095.25, 30_000.5] {
            let (whole, rest) = whole(x);
            assert!(whole as f32 + rest == x && (0.0..=1.0).contains(&rest), "{x}: {whole} and {rest}");
        }
    }

    #[test]
    fn quads_found_together_are_those_of_each_sample() {
        let source = Grid::new(Mapping::LatLong, 64, 32);
        let tile = Tile { x: 3, y: 5, width: 7, height: 4 };
        // The least value between the nodes.
        let value =
            |t: f64, v: f64| [20.0 + 9.0 * t - 2.0 * v * v + t * v, 14.0 - 16.0 * t * (1.5 - t) + v, 1.0 + 0.1 * t];
        let values = [0.0, 0.5, 1.0].map(|v| [0.0, 0.5, 1.0].map(|t| value(t, v)));
        let limits = Limits { x: [0.0, 64.0], y: [0.0, 32.0] };
        let patch = Patch::through(tile, [3, 2], values, source, limits);
        assert!(patch.window.is_some(), "the patch lies inside");
        patch.for_each_texel(
            source,
            |_| true,
            |[x, y], view| {
                let [x, y] = [x - tile.x, y - tile.y];
                let mut each = Footprints::default();
                patch.for_each_sample([x, y], |sample| sample.look(source, &mut each));
                let mut sums = [vec![0.0; 64 * 32], vec![0.0; 64 * 32]];
                view.for_each(64, |s, weight| sums[0][s] += weight);
                each.all().for_each(64, |s, weight| sums[1][s] += weight);
                for (s, (found, expected)) in sums[0].iter().zip(&sums[1]).enumerate() {
                    assert!((found - expected).abs() < 1e-5, "texel ({x}, {y}), source {s}: {found}, not {expected}");
                }
            },
        );
    }
}
