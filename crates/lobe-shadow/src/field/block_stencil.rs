//! The samples around sixteen points at once, and their weights.

use lobe_sh::simd::{Lanes, Wide, constant};
use pulp::Simd;

use crate::field::field_grid::FieldGrid;

/// Spheres around a point and vertices on each: weights at most.
const MOST_WEIGHTS: usize = 16;

/// Distances along an axis at most, in radii: their squares are finite.
const FARTHEST: f32 = 1e18;

/// What [`Stencil`](crate::field::field_grid::Stencil) holds, for sixteen points beyond the innermost sphere.
#[derive(Clone, Debug)]
pub(crate) struct BlockStencil {
    /// The place among the spheres: negative within the innermost, where this stencil does not hold.
    pub(crate) place: Lanes,
    /// The first of the spheres around the point, and the vertex of least u and v on it: whole numbers.
    pub(crate) sphere: Lanes,
    pub(crate) vertex: Lanes,
    /// Sphere by sphere those of the vertices `(0, 0)`, `(1, 0)`, `(0, 1)` and `(1, 1)` of the cell.
    pub(crate) weights: [Lanes; MOST_WEIGHTS],
    squares: Lanes,
    exponents: Lanes,
}

impl BlockStencil {
    pub(crate) const NONE: Self = Self {
        place: Lanes::ZERO,
        sphere: Lanes::ZERO,
        vertex: Lanes::ZERO,
        weights: [Lanes::ZERO; MOST_WEIGHTS],
        squares: Lanes::ZERO,
        exponents: Lanes::ZERO,
    };

    /// Points relative to the center of the grid, in its radii: `rows` turns `offset` to them. `SPHERES` is 2 for linear
    /// interpolation between spheres and 4 for cubic.
    #[inline(always)]
    pub(crate) fn fill<S: Simd, const SPHERES: usize>(
        &mut self,
        simd: S,
        grid: &FieldGrid,
        rows: &[[f32; 3]; 3],
        offset: &[Lanes; 3],
    ) {
        for part in 0..Wide::<S>::PARTS {
            let [x, y, z] = to_own(simd, part, rows, offset);
            x.times_plus(x, y.times_plus(y, z * z)).store(&mut self.squares, part);
        }
        let squares = self.squares;
        split_exponents(&mut self.squares, &mut self.exponents);
        for part in 0..Wide::<S>::PARTS {
            let mantissa = Wide::load(simd, &self.squares, part);
            let logarithm = logarithm(simd, mantissa, Wide::load(simd, &self.exponents, part));
            let square = Wide::load(simd, &squares, part);
            let (sphere, radial) = self.radial::<S, SPHERES>(simd, part, grid, logarithm, square);
            sphere.store(&mut self.sphere, part);
            let corners = self.corners(simd, part, grid, to_own(simd, part, rows, offset));
            for k in 0..SPHERES {
                for c in 0..4 {
                    (radial[k] * corners[c]).store(&mut self.weights[4 * k + c], part);
                }
            }
        }
    }

    /// The first sphere and the weights of the spheres, which include the division by `w(r)`.
    #[inline(always)]
    fn radial<S: Simd, const SPHERES: usize>(
        &mut self,
        simd: S,
        part: usize,
        grid: &FieldGrid,
        logarithm: Wide<S>,
        square: Wide<S>,
    ) -> (Wide<S>, [Wide<S>; SPHERES]) {
        let splat = |value| constant(simd, value);
        let last = (grid.spheres() - 1) as f32;
        let place = grid.place_in_lanes(simd, logarithm);
        place.store(&mut self.place, part);
        let place = place.max(splat(0.0)).min(splat(last));
        let k = floor(simd, place, last - 1.0);
        let t = place - k;
        let unscaled = (splat(1.0) + square).recip();
        let mut weights = [unscaled; SPHERES];
        if SPHERES == 2 {
            weights[0] = unscaled - unscaled * t;
            weights[1] = unscaled * t;
        } else {
            let [w0, w1, w2, w3] = catmull_rom(simd, t);
            // Beyond the ends: f_-1 = 2 f_0 - f_1, and f_(last+1) = f_(last-1).
            let none = splat(0.0);
            let before = k.if_less(splat(0.5), w0, none);
            let after = k.if_less(splat(last - 1.5), none, w3);
            let all = [w0 - before, w1 + before + before + after, w2 - before, w3 - after];
            for (weight, of_sphere) in weights.iter_mut().zip(all) {
                *weight = unscaled * of_sphere;
            }
        }
        (k, weights)
    }

    /// Stores the cell's vertex; the bilinear weights of its four.
    #[inline(always)]
    fn corners<S: Simd>(&mut self, simd: S, part: usize, grid: &FieldGrid, [x, y, z]: [Wide<S>; 3]) -> [Wide<S>; 4] {
        let (zero, one) = (constant(simd, 0.0), constant(simd, 1.0));
        let (ax, ay, az) = (x.max(zero - x), y.max(zero - y), z.max(zero - z));
        let scale = (ax + ay + az).recip();
        let (px, py) = (x * scale, y * scale);
        // Of the lower half the triangles are folded outwards.
        let (fx, fy) = (one - ay * scale, one - ax * scale);
        let u = z.if_less(zero, px.if_less(zero, zero - fx, fx), px);
        let v = z.if_less(zero, py.if_less(zero, zero - fy, fy), py);
        let half = constant(simd, 0.5 * grid.cells() as f32);
        let (u, v) = ((u + one) * half, (v + one) * half);
        let most = (grid.cells() - 1) as f32;
        let (i, j) = (floor(simd, u, most), floor(simd, v, most));
        j.times_plus(constant(simd, most + 2.0), i).store(&mut self.vertex, part);
        let (a, b) = ((u - i).max(zero).min(one), (v - j).max(zero).min(one));
        let (na, nb) = (one - a, one - b);
        [na * nb, a * nb, na * b, a * b]
    }
}

/// Offsets in the frame of the entity.
#[inline(always)]
fn to_own<S: Simd>(simd: S, part: usize, rows: &[[f32; 3]; 3], offset: &[Lanes; 3]) -> [Wide<S>; 3] {
    let [x, y, z] = offset;
    let d = [Wide::load(simd, x, part), Wide::load(simd, y, part), Wide::load(simd, z, part)];
    let [x, y, z] = rows;
    [row_times(simd, x, d), row_times(simd, y, d), row_times(simd, z, d)]
}

/// The product of a row and vectors, within the range whose squares are finite.
#[inline(always)]
fn row_times<S: Simd>(simd: S, row: &[f32; 3], [x, y, z]: [Wide<S>; 3]) -> Wide<S> {
    let [a, b, c] = row;
    let (a, b, c) = (constant(simd, *a), constant(simd, *b), constant(simd, *c));
    let sum = a.times_plus(x, b.times_plus(y, c * z));
    sum.max(constant(simd, -FARTHEST)).min(constant(simd, FARTHEST))
}

/// The largest whole number that is not above `x`, from 0 to `most`; that below is as good for a whole `x`.
#[inline(always)]
fn floor<S: Simd>(simd: S, x: Wide<S>, most: f32) -> Wide<S> {
    // Neighbors of this number are whole: the sum is rounded to one of them.
    const SHIFT: f32 = 12_582_912.0;
    let splat = |value| constant(simd, value);
    let below = (x - splat(0.5)) + splat(SHIFT);
    (below - splat(SHIFT)).max(splat(0.0)).min(splat(most))
}

/// Takes positive numbers apart into `m 2^e` with `m` from √½ to √2.
#[inline(always)]
fn split_exponents(numbers: &mut Lanes, exponents: &mut Lanes) {
    const ROOT_OF_HALF: u32 = std::f32::consts::FRAC_1_SQRT_2.to_bits();
    for (x, exponent) in numbers.0.iter_mut().zip(&mut exponents.0) {
        let bits = x.to_bits();
        let e = (bits.wrapping_sub(ROOT_OF_HALF) as i32) >> (f32::MANTISSA_DIGITS - 1);
        *x = f32::from_bits(bits.wrapping_sub((e as u32) << (f32::MANTISSA_DIGITS - 1)));
        *exponent = e as f32;
    }
}

/// `½ ln(m 2^e)` for `m` from √½ to √2, within 4e-7 for the distances of any grid (test
/// `sixteen_stencils_are_those_of_the_points`).
///
/// ```text
///   ½ ln m = s + s³/3 + s⁵/5 + s⁷/7 + ...        s = (m - 1)/(m + 1), |s| < 0.172
/// ```
#[inline(always)]
fn logarithm<S: Simd>(simd: S, m: Wide<S>, e: Wide<S>) -> Wide<S> {
    let splat = |value| constant(simd, value);
    let s = (m - splat(1.0)) * (m + splat(1.0)).recip();
    let square = s * s;
    let series = square.times_plus(splat(1.0 / 7.0), splat(1.0 / 5.0));
    let series = square.times_plus(square.times_plus(series, splat(1.0 / 3.0)), splat(1.0));
    e.times_plus(splat(0.5 * std::f32::consts::LN_2), s * series)
}

/// [`catmull_rom`](crate::field::field_grid::catmull_rom) in lanes.
#[inline(always)]
fn catmull_rom<S: Simd>(simd: S, t: Wide<S>) -> [Wide<S>; 4] {
    let splat = |value| constant(simd, value);
    let (t2, half) = (t * t, splat(0.5));
    let t3 = t2 * t;
    [
        half * (t2 + t2 - t - t3),
        splat(1.0) + half * (splat(3.0) * t3 - splat(5.0) * t2),
        half * (t + splat(4.0) * t2 - splat(3.0) * t3),
        half * (t3 - t2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::field_grid::RadialInterpolation;
    use lobe_sh::simd::LANES;
    use lobe_testkit::Random;
    use pulp::{Arch, WithSimd};
    use std::collections::BTreeMap;

    struct Fill<'a, const SPHERES: usize>(&'a mut BlockStencil, &'a FieldGrid, [[f32; 3]; 3], [Lanes; 3]);

    impl<const SPHERES: usize> WithSimd for Fill<'_, SPHERES> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.0.fill::<S, SPHERES>(simd, self.1, &self.2, &self.3);
        }
    }

    /// Rows and weights of one lane, those of one place together.
    fn taps(grid: &FieldGrid, stencil: &BlockStencil, spheres: usize, lane: usize) -> BTreeMap<usize, f32> {
        let side = grid.cells() + 1;
        let mut all = BTreeMap::new();
        for k in 0..4 * spheres {
            let first = stencil.sphere[lane] as usize + k / 4;
            let sphere = if spheres == 2 { first } else { first.saturating_sub(1).min(grid.spheres() - 1) };
            let row = sphere * side * side + stencil.vertex[lane] as usize + [0, 1, side, side + 1][k % 4];
            *all.entry(grid.representative(row)).or_insert(0.0) += stencil.weights[k][lane];
        }
        all
    }

    #[test]
    fn sixteen_stencils_are_those_of_the_points() {
        let (mut random, mut worst, mut stencil) = (Random::new(8), 0.0_f32, BlockStencil::NONE);
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (spheres, cells, range) in [(2, 2, [0.5, 4.0]), (5, 6, [0.25, 8.0]), (16, 16, [1e-3, 1e3])] {
            let grid = FieldGrid::new([0.0; 3], 2.0, range, spheres, cells).unwrap();
            for k in 0..400 {
                let mut points = [[0.0; 3]; LANES];
                for point in &mut points {
                    let r = range[0] * (4.0 * range[1] / range[0]).powf(random.unit());
                    *point = random.direction().map(|c| (r * c) as f32);
                    // On the folds too.
                    point[k % 5 % 3] *= if k % 5 < 3 { 0.0 } else { 1.0 };
                }
                let offset: [Lanes; 3] = [0, 1, 2].map(|c| Lanes(points.map(|point| point[c])));
                for arch in [Arch::new(), Arch::Scalar] {
                    for interpolation in [RadialInterpolation::Linear, RadialInterpolation::Cubic] {
                        let spheres = if interpolation == RadialInterpolation::Linear {
                            arch.dispatch(Fill::<2>(&mut stencil, &grid, identity, offset));
                            2
                        } else {
                            arch.dispatch(Fill::<4>(&mut stencil, &grid, identity, offset));
                            4
                        };
                        for lane in (0..LANES).filter(|lane| stencil.place[*lane] > 0.0) {
                            let mut found = taps(&grid, &stencil, spheres, lane);
                            for (row, weight) in grid.stencil(points[lane], interpolation).taps() {
                                *found.entry(grid.representative(*row as usize)).or_insert(0.0) -= weight;
                            }
                            let size = grid.scale_at(grid.radius() * f64::from(norm(points[lane]))) as f32;
                            worst = found.values().map(|off| off.abs() * size).fold(worst, f32::max);
                        }
                    }
                }
            }
        }
        assert!(worst < 3e-5, "weights differ by {worst}");
    }

    fn norm(v: [f32; 3]) -> f32 {
        v.iter().map(|c| c * c).sum::<f32>().sqrt()
    }
}
