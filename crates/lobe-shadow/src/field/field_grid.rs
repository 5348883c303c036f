//! The sample points of a field: concentric spheres around an entity, and the weights of those around a point.

use std::ops::RangeInclusive;

use lobe_sh::simd::{Wide, constant};
use pulp::Simd;

use crate::error::ShadowError;
use crate::field::octahedron::Octahedron;

/// Sample points in all at most: their numbers are exact in `f32`.
const MOST_POINTS: usize = 1 << 24;

/// Bytes of the table of a field at most: 1 GiB. The default sampling has 370 kB at order 4.
const MOST_BYTES: usize = 1 << 30;

/// The part of the bounding radius below which a point is the center itself: no direction is left of the differences of
/// coordinates in `f32`.
const AT_CENTER: f32 = 1e-6;

/// Bounding radii: they and their reciprocals are normal in `f32`.
const RADII: RangeInclusive<f64> = 1e-30..=1e30;

/// Radii of spheres in those of the entity: squares of their ratios are normal in `f32`.
const RANGE: RangeInclusive<f64> = 1e-6..=1e6;

/// Concentric spheres around the center of an entity, in its own frame.
///
/// ```text
///   k = k_R + c_± m(r)        m(r) = ±√|ln(r/R)|, the sign that of ln;     k = 0 at r = R·inner, k = spheres - 1 at R·outer
/// ```
///
/// `R` is the radius of the bounding sphere, and a sphere `k_R` lies there, where `c_-` within goes over to `c_+` beyond: of the
/// number that is nearest to even steps of `m`. (Of two spheres, or where `R` is not between `inner` and `outer`, all steps are
/// even.) The occlusion by a ball rises from its surface on as a square root; in `m` that is a straight line. With even steps of
/// `ln r` sixteen spheres were 13 % off between R and 2 R around a ball, with these they are 1 % off, and beyond 2 R no more than
/// 0.6 %. On each sphere lie the `(cells + 1)²` vertices of an octahedral grid, and
/// one point more is the center. What a field stores is scaled by
///
/// ```text
///   w(r) = 1 + (r/R)²
/// ```
///
/// An occluder covers a solid angle that falls as `1/r²`: scaled it tends to a constant, so that spheres may be a fixed
/// ratio apart, and beyond the last one the scaled value is kept, which is the extrapolation by `1/r²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldGrid {
    center: [f64; 3],
    radius: f64,
    inner: f64,
    outer: f64,
    pub(crate) spheres: usize,
    pub(crate) directions: Octahedron,
    /// `k_R`, `c_-` and `c_+`.
    at_radius: f64,
    per_step: [f64; 2],
}

/// How values are interpolated between spheres; between directions it is always bilinear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RadialInterpolation {
    /// Linearly in [`FieldGrid`]'s `m(r)`: continuous, with kinks at the spheres that a moving shadow shows.
    #[default]
    Linear,
    /// By the cubic spline of Catmull and Rom through four spheres: its slope in [`FieldGrid`]'s `m(r)` is continuous too, but for that at the
    /// innermost sphere; in `r` it is but for that at the surface of the bounding sphere too, where occlusion rises as a root. Twice the reads.
    Cubic,
}

/// The most samples around a point: four spheres with four vertices.
const MOST_TAPS: usize = 16;

/// The samples around a point and their weights, which include the division by `w(r)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stencil {
    taps: [(u32, f32); MOST_TAPS],
    len: usize,
}

impl Stencil {
    fn push(&mut self, row: usize, weight: f32) {
        self.taps[self.len] = (row as u32, weight);
        self.len += 1;
    }

    /// Rows and weights.
    #[inline]
    pub(crate) fn taps(&self) -> &[(u32, f32)] {
        &self.taps[..self.len]
    }

    /// Gives the weights of samples that are not kept to the others; nothing is left where none is kept.
    pub(crate) fn keep(&mut self, is_kept: impl Fn(usize) -> bool) {
        let all: f32 = self.taps().iter().map(|(_, weight)| weight).sum();
        let mut len = 0;
        for tap in 0..self.len {
            if is_kept(self.taps[tap].0 as usize) {
                self.taps[len] = self.taps[tap];
                len += 1;
            }
        }
        if len == self.len {
            return;
        }
        self.len = len;
        let kept: f32 = self.taps().iter().map(|(_, weight)| weight).sum();
        let scale = if kept > 0.0 { all / kept } else { 0.0 };
        self.taps[..len].iter_mut().for_each(|(_, weight)| *weight *= scale);
    }

    /// The weighted sum of rows of a table that are `out.len()` wide.
    #[inline]
    pub(crate) fn sum_into(&self, table: &[f32], out: &mut [f32]) {
        // With a width that is known the sums stay in registers: those of orders 3 to 6.
        match out.len() {
            12 => self.sum_of_width::<12>(table, out),
            20 => self.sum_of_width::<20>(table, out),
            30 => self.sum_of_width::<30>(table, out),
            42 => self.sum_of_width::<42>(table, out),
            width => {
                out.fill(0.0);
                for &(row, weight) in self.taps() {
                    let row = &table[row as usize * width..][..width];
                    out.iter_mut().zip(row).for_each(|(out, x)| *out += weight * x);
                }
            }
        }
    }

    #[inline(always)]
    fn sum_of_width<const W: usize>(&self, table: &[f32], out: &mut [f32]) {
        let (rows, _) = table.as_chunks::<W>();
        let mut sum = [0.0; W];
        for &(row, weight) in self.taps() {
            let row = &rows[row as usize];
            (0..W).for_each(|i| sum[i] += weight * row[i]);
        }
        out.copy_from_slice(&sum);
    }
}

impl FieldGrid {
    /// A grid around `center` for an entity of bounding radius `radius`. `inner` and `outer` are in radii of the entity.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the center is not finite, the radius not from 10⁻³⁰ to 10³⁰, `inner` and `outer` do not rise
    /// within 10⁻⁶ to 10⁶, there are fewer than two spheres or cells, an odd number of cells, or 2²⁴ points or more.
    pub fn new(
        center: [f64; 3],
        radius: f64,
        [inner, outer]: [f64; 2],
        spheres: usize,
        cells: usize,
    ) -> Result<Self, ShadowError> {
        let refuse = |message: String| Err(ShadowError::Options(message));
        if !(center.iter().all(|c| c.is_finite()) && RADII.contains(&radius)) {
            return refuse(format!(
                "expected a finite center and a bounding radius from {:e} to {:e}, found {center:?} and {radius}",
                RADII.start(),
                RADII.end()
            ));
        }
        if !(RANGE.contains(&inner) && RANGE.contains(&outer) && inner < outer) {
            return refuse(format!(
                "expected spheres that rise from {:e} radii or more to {:e} at most, found from {inner} to {outer}",
                RANGE.start(),
                RANGE.end()
            ));
        }
        if spheres < 2 || cells < 2 || !cells.is_multiple_of(2) {
            return refuse(format!(
                "expected 2 spheres or more and an even number of cells, found {spheres} and {cells}"
            ));
        }
        let points = cells.saturating_add(1).saturating_mul(cells.saturating_add(1)).saturating_mul(spheres);
        if points >= MOST_POINTS {
            return refuse(format!(
                "expected at most {MOST_POINTS} sample points, found {points}: take fewer spheres or cells"
            ));
        }
        let (at_radius, per_step) = steps(inner, outer, spheres);
        Ok(Self { center, radius, inner, outer, spheres, directions: Octahedron { cells }, at_radius, per_step })
    }

    /// Whether a table of `width` numbers for each point may be made: it has at most 1 GiB.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if it has more.
    pub(crate) fn check_bytes(&self, width: usize) -> Result<(), ShadowError> {
        let bytes = self.points().saturating_mul(width).saturating_mul(size_of::<f32>());
        if bytes <= MOST_BYTES {
            return Ok(());
        }
        Err(ShadowError::Options(format!(
            "expected a table of at most {MOST_BYTES} bytes, found {bytes}, {width} numbers for each of {} sample points: take \
             fewer spheres or cells, or a lower order",
            self.points()
        )))
    }

    /// The middle of the spheres in the entity's own frame.
    #[must_use]
    pub fn center(&self) -> [f64; 3] {
        self.center
    }

    /// The radius of the entity around that.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The innermost and the outermost sphere, in radii of the entity.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.inner, self.outer]
    }

    /// `k_R`, and `c_-` and `c_+`; for shaders.
    #[must_use]
    pub fn radial_steps(&self) -> (f64, [f64; 2]) {
        (self.at_radius, self.per_step)
    }

    /// Number of spheres.
    #[must_use]
    pub fn spheres(&self) -> usize {
        self.spheres
    }

    /// Cells along each side of the octahedral grid of a sphere.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.directions.cells
    }

    /// Number of sample points: sphere after sphere from the innermost, then the center.
    #[must_use]
    pub fn points(&self) -> usize {
        self.spheres * self.directions.len() + 1
    }

    /// Number of sample points on a sphere.
    pub(crate) fn points_of_sphere(&self) -> usize {
        self.directions.len()
    }

    /// The radius of a sphere.
    #[must_use]
    pub fn sphere_radius(&self, sphere: usize) -> f64 {
        let k = sphere as f64 - self.at_radius;
        let m = k / self.per_step[usize::from(k >= 0.0)];
        self.radius * (m * m.abs()).exp()
    }

    /// A sample point relative to the center.
    #[must_use]
    pub fn offset(&self, point: usize) -> [f64; 3] {
        let per_sphere = self.directions.len();
        if point >= self.spheres * per_sphere {
            return [0.0; 3];
        }
        let r = self.sphere_radius(point / per_sphere);
        self.directions.direction(point % per_sphere).map(|c| r * c)
    }

    /// `w(r)` at a distance from the center.
    #[must_use]
    pub fn scale_at(&self, r: f64) -> f64 {
        1.0 + (r / self.radius).powi(2)
    }

    /// The first of the sample points that coincide with one: where the border of the octahedral grid is folded.
    pub(crate) fn representative(&self, point: usize) -> usize {
        let per_sphere = self.directions.len();
        if point >= self.spheres * per_sphere {
            return point;
        }
        point - point % per_sphere + self.directions.representative(point % per_sphere)
    }

    /// The sample points that are the first of those that coincide, ascending.
    pub(crate) fn representatives(&self) -> Vec<usize> {
        (0..self.points()).filter(|point| self.representative(*point) == *point).collect()
    }

    /// The place of `ln(r/R)` among the spheres: 0 at the innermost.
    #[inline]
    fn place(&self, logarithm: f32) -> f32 {
        let per_step = self.per_step[usize::from(logarithm >= 0.0)] as f32;
        self.at_radius as f32 + (per_step * logarithm.abs().sqrt()).copysign(logarithm)
    }

    /// [`FieldGrid::place`] of several.
    #[inline(always)]
    pub(crate) fn place_in_lanes<S: Simd>(&self, simd: S, logarithm: Wide<S>) -> Wide<S> {
        let splat = |value: f64| constant(simd, value as f32);
        let root = logarithm.max(splat(0.0) - logarithm).sqrt();
        let per_step = logarithm.if_less(splat(0.0), splat(-self.per_step[0]), splat(self.per_step[1]));
        per_step.times_plus(root, splat(self.at_radius))
    }

    /// The samples around a point given relative to the center, in radii, and their weights.
    #[inline]
    pub(crate) fn stencil(&self, offset: [f32; 3], interpolation: RadialInterpolation) -> Stencil {
        let [x, y, z] = offset;
        let relative = (x * x + y * y + z * z).sqrt();
        let mut stencil = Stencil { taps: [(0, 0.0); MOST_TAPS], len: 0 };
        let center = self.spheres * self.directions.len();
        let unscaled = 1.0 / (1.0 + relative * relative);
        if relative <= AT_CENTER {
            stencil.push(center, 1.0);
            return stencil;
        }
        let corners = self.directions.corners(self.directions.cell(offset));
        let mut sphere = |k: usize, weight: f32| {
            for (vertex, w) in corners {
                stencil.push(k * self.directions.len() + vertex, weight * w);
            }
        };
        let t = self.place(relative.ln());
        let last = self.spheres - 1;
        if t <= 0.0 {
            // From the center to the innermost sphere, linearly in r.
            let part = relative / self.inner as f32;
            sphere(0, unscaled * part);
            stencil.push(center, unscaled * (1.0 - part));
        } else if t >= last as f32 {
            sphere(last, unscaled);
        } else {
            let k = (t as usize).min(last - 1);
            let t = t - k as f32;
            match interpolation {
                RadialInterpolation::Linear => {
                    sphere(k, unscaled * (1.0 - t));
                    sphere(k + 1, unscaled * t);
                }
                RadialInterpolation::Cubic => {
                    let mut weights = catmull_rom(t);
                    // Beyond the ends: f_-1 = 2 f_0 - f_1, and f_(last+1) = f_(last-1).
                    if k == 0 {
                        let w = std::mem::take(&mut weights[0]);
                        weights[1] += 2.0 * w;
                        weights[2] -= w;
                    }
                    if k + 1 == last {
                        weights[1] += std::mem::take(&mut weights[3]);
                    }
                    let at = [k.saturating_sub(1), k, k + 1, (k + 2).min(last)];
                    at.into_iter().zip(weights).for_each(|(k, w)| sphere(k, unscaled * w));
                }
            }
        }
        stencil
    }
}

/// `k_R`, `c_-` and `c_+` of a [`FieldGrid`].
fn steps(inner: f64, outer: f64, spheres: usize) -> (f64, [f64; 2]) {
    let m = |r: f64| r.ln().abs().sqrt().copysign(r.ln());
    let (first, last) = (m(inner), m(outer));
    let even = (spheres - 1) as f64 / (last - first);
    if spheres == 2 || first >= 0.0 || last <= 0.0 {
        return (-first * even, [even; 2]);
    }
    let at_radius = (-first * even).round().clamp(1.0, (spheres - 2) as f64);
    (at_radius, [at_radius / -first, ((spheres - 1) as f64 - at_radius) / last])
}

/// The weights of four values at -1, 0, 1 and 2 in the cubic between the inner two whose slopes there are the central
/// differences.
pub(crate) fn catmull_rom(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t - t3), 1.0 + 0.5 * (3.0 * t3 - 5.0 * t2), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn weights_add_up_to_the_falling_scale_and_are_one_at_a_sample() {
        let grid = FieldGrid::new([0.0; 3], 2.0, [0.25, 8.0], 9, 6).unwrap();
        let mut random = Random::new(4);
        for interpolation in [RadialInterpolation::Linear, RadialInterpolation::Cubic] {
            for _ in 0..500 {
                let r = 40.0 * random.unit().powi(3);
                let p = random.direction().map(|c| (r / grid.radius() * c) as f32);
                let sum: f32 = grid.stencil(p, interpolation).taps().iter().map(|(_, w)| w).sum();
                let expected = 1.0 / grid.scale_at(r);
                assert!((f64::from(sum) / expected - 1.0).abs() < 1e-5, "{r}: {sum}, expected {expected}");
            }
            for point in 0..grid.points() {
                let (p, r) = (grid.offset(point), grid.sphere_radius(point.min(grid.points() - 2) / 49));
                let r = if point + 1 == grid.points() { 0.0 } else { r };
                let stencil = grid.stencil(p.map(|c| (c / grid.radius()) as f32), interpolation);
                let here = stencil.taps().iter().filter(|(row, _)| grid.offset(*row as usize) == p);
                let weight = here.map(|(_, w)| f64::from(*w)).sum::<f64>() * grid.scale_at(r);
                // At the radius a place among the spheres is a square root of the rounding of r.
                let allowed = if r == grid.radius() { 2e-3 } else { 2e-5 };
                assert!((weight - 1.0).abs() < allowed, "sample {point}: weight {weight}");
            }
        }
    }

    #[test]
    fn spheres_rise_from_the_innermost_to_the_outermost_and_one_lies_at_the_radius() {
        for (range, spheres) in [([0.25, 8.0], 16), ([0.5, 4.0], 3), ([0.9, 100.0], 5), ([0.01, 1.001], 7)] {
            let grid = FieldGrid::new([0.0; 3], 2.0, range, spheres, 2).unwrap();
            let radii: Vec<f64> = (0..spheres).map(|k| grid.sphere_radius(k) / 2.0).collect();
            assert!(radii.is_sorted_by(|a, b| a < b), "{radii:?}");
            let [first, last] = [radii[0] / range[0], radii[spheres - 1] / range[1]];
            assert!((first - 1.0).abs() < 1e-12 && (last - 1.0).abs() < 1e-12, "{range:?}: {radii:?}");
            assert_eq!(radii.iter().filter(|r| **r == 1.0).count(), 1, "{radii:?}");
        }
        for (range, spheres) in [([1.5, 8.0], 4), ([0.1, 0.9], 4), ([0.5, 4.0], 2)] {
            let grid = FieldGrid::new([0.0; 3], 2.0, range, spheres, 2).unwrap();
            let [first, last] = [0, spheres - 1].map(|k| grid.sphere_radius(k) / 2.0);
            let off = (first / range[0] - 1.0).abs() + (last / range[1] - 1.0).abs();
            assert!(off < 1e-12, "{range:?}: from {first} to {last}");
        }
    }

    #[test]
    fn a_cubic_between_spheres_keeps_quadratics() {
        for t in [0.0_f32, 0.3, 0.9] {
            let at = |x: f32| 2.0 - x + 0.5 * x * x;
            let found: f32 = catmull_rom(t).iter().zip([-1.0, 0.0, 1.0, 2.0]).map(|(w, x)| w * at(x)).sum();
            assert!((found - at(t)).abs() < 1e-6, "{t}: {found}, expected {}", at(t));
        }
    }

    #[test]
    fn the_slope_of_a_cubic_is_continuous_from_the_second_sphere_to_beyond_the_last() {
        let grid = FieldGrid::new([0.0; 3], 1.0, [0.25, 8.0], 7, 2).unwrap();
        let values = [1.0, 3.0, 2.0, -1.0, 0.5, 2.5, 4.0_f64];
        let at = |k: f64, interpolation| {
            let m = (k - grid.at_radius) / grid.per_step[usize::from(k >= grid.at_radius)];
            let r = (m * m.abs()).exp();
            let stencil = grid.stencil([0.0, 0.0, r as f32], interpolation);
            let sum = |(row, w): &(u32, f32)| f64::from(*w) * values[*row as usize / 9];
            stencil.taps().iter().map(sum).sum::<f64>() * grid.scale_at(r)
        };
        let kink = |k: usize, interpolation| {
            // One-sided differences, exact for quadratics.
            let slope = |h: f64| {
                let f = |n: f64| at(k as f64 + n * h, interpolation);
                (4.0 * f(1.0) - f(2.0) - 3.0 * f(0.0)) / (2.0 * h)
            };
            (slope(0.02) - slope(-0.02)).abs()
        };
        for k in 1..7 {
            let [linear, cubic] = [RadialInterpolation::Linear, RadialInterpolation::Cubic].map(|i| kink(k, i));
            assert!(cubic < 0.05, "sphere {k}: the slope changes by {cubic}, linearly by {linear}");
            assert!(linear > 0.4, "sphere {k}: the linear slope changes by {linear}");
        }
    }

    #[test]
    fn impossible_grids_are_refused_in_one_line() {
        let grid = |radius, range, spheres, cells| FieldGrid::new([0.0; 3], radius, range, spheres, cells);
        for (found, expected) in [
            (grid(0.0, [0.5, 4.0], 3, 2), "bounding radius from 1e-30 to 1e30"),
            (grid(f64::NAN, [0.5, 4.0], 3, 2), "bounding radius from 1e-30 to 1e30"),
            (grid(1e-300, [0.5, 4.0], 3, 2), "bounding radius from 1e-30 to 1e30"),
            (grid(1e300, [0.5, 4.0], 3, 2), "bounding radius from 1e-30 to 1e30"),
            (grid(1.0, [1e-300, 4.0], 3, 2), "rise from 1e-6 radii or more to 1e6 at most"),
            (grid(1.0, [1e-6, 1e300], 3, 2), "rise from 1e-6 radii or more to 1e6 at most"),
            (grid(1.0, [4.0, 4.0], 3, 2), "from 4 to 4"),
            (grid(1.0, [0.5, 4.0], 1, 2), "2 spheres or more"),
            (grid(1.0, [0.5, 4.0], 3, 3), "an even number of cells"),
            (grid(1.0, [0.5, 4.0], usize::MAX, 1 << 40), "at most 16777216 sample points"),
        ] {
            let message = found.unwrap_err().to_string();
            assert!(message.contains(expected) && !message.contains('\n'), "{message}");
        }
    }
}
