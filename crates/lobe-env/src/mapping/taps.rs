//! Taps of bilinear interpolation: the texels and weights that make up a picture's value at a point.

use std::f64::consts::PI;
use std::ops::Range;

use lobe_sh::Dir;

use crate::Mapping;
use crate::mapping::cube;
use crate::mapping::lat_long::sin_cos_pi;

// Plain bilinear interpolation in θ gives the rows of a lat-long picture wrong solid angles: 8 % too much for the first
// row, since between its center and the next one the sphere widens. Between the centers of two rows, at
// θ = m + (t - 1/2) δ with m the edge between them and δ = π/h, the weight 1 - t of the upper row is therefore bent to
//
//     g(t) = 1 - t - β t (1 - t)      with β such that   ∫_0^1 g(t) sin θ dt = ∫_0^{1/2} sin θ dt
//
// so that either row has its own half of the strip, and each row, with the strip at the pole, its solid angle. With
// x = θ - m, sin θ = sin m cos x + cos m sin x and 1 - t = 1/2 - x/δ, all integrals are elementary:
//
//     β = cot m · ((1 - cos δ/2) - I₁)/(δ K)              I₁ = ∫ x sin x dt = (2/δ)(sin δ/2 - δ/2 cos δ/2)
//     K = ∫ t(1-t) cos x dt = sin(δ/2)/(2δ) - J/δ²        J = ∫ x² cos x dt = (2/δ)(δ²/4 sin δ/2 + δ cos δ/2 - 2 sin δ/2)
//
// which is cot(m) δ/4 + O(δ³): 1/4 at the first edge, a hundredth of it 100 rows on. In place of g, the fraction t is
// bent: t + β t (1 - t).

/// Up to this height of a row, in radians, β is approximated by its first term: the error is below `SMALL_STRIP²`, and
/// the closed form loses as much to cancellation.
const SMALL_STRIP: f64 = 1e-3;

/// The most taps: four texels on each side of a rim.
const MAX_TAPS: usize = 8;

/// A tap: the index of a texel in the picture, and its weight.
pub(crate) type Share = (u32, f32);

/// Taps whose weights sum to 1.
///
/// A texel may occur twice. Pictures have fewer than 2³² texels: those would be 48 GiB.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taps {
    list: [Share; MAX_TAPS],
    len: usize,
}

impl Taps {
    const NONE: Self = Self { list: [(0, 0.0); MAX_TAPS], len: 0 };

    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.list[..self.len].iter().map(|&(index, weight)| (index as usize, weight))
    }

    #[inline(always)]
    fn push(&mut self, index: usize, weight: f32) {
        if weight > 0.0 {
            self.list[self.len] = (index as u32, weight);
            self.len += 1;
        }
    }
}

/// The grid of texels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    pub(crate) mapping: Mapping,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Grid {
    pub(crate) fn new(mapping: Mapping, width: usize, height: usize) -> Self {
        Self { mapping, width, height }
    }

    pub(crate) fn len(&self) -> usize {
        self.width * self.height
    }

    /// The point of the picture in the direction `s`, in texels from the upper left corner.
    #[inline]
    pub(crate) fn point(&self, s: Dir) -> [f64; 2] {
        let (u, v) = self.mapping.uv_from_dir(s);
        let p = [u * self.width as f64, v * self.height as f64];
        if self.mapping != Mapping::Cube {
            return p;
        }
        // The product may round to the next face.
        let limit = ((6.0 * v) as usize).min(cube::FACES - 1) + 1;
        [p[0], if limit < cube::FACES { p[1].min(((limit * self.width) as f64).next_down()) } else { p[1] }]
    }

    /// The point whose [`taps`](Self::taps) are the value in the direction `s`.
    #[inline]
    pub(crate) fn tap_point(&self, s: Dir) -> [f64; 2] {
        let [x, y] = self.point(s);
        if self.mapping != Mapping::LatLong {
            return [x, y];
        }
        let row = (y - 0.5).floor();
        [x, self.fair_row(y, self.cotangent_factor() * self.cotangent(row))]
    }

    /// The row `y` between two centers, bent so that each row has its solid angle in the interpolation.
    #[inline]
    pub(crate) fn fair_row(&self, y: f64, bend: f64) -> f64 {
        let t = (y - 0.5) - (y - 0.5).floor();
        y + bend * t * (1.0 - t)
    }

    /// `cot θ` at the lower edge of a row of a lat-long picture, 0 beyond its first and its last row.
    pub(crate) fn cotangent(&self, row: f64) -> f64 {
        if row < 0.0 || row + 1.0 >= self.height as f64 {
            return 0.0;
        }
        let (sin, cos) = sin_cos_pi((row + 1.0) / self.height as f64);
        cos / sin
    }

    /// The bend of a strip over its [`cotangent`](Self::cotangent).
    pub(crate) fn cotangent_factor(&self) -> f64 {
        let d = PI / self.height as f64;
        let (sin, cos) = (0.5 * d).sin_cos();
        if d < SMALL_STRIP {
            return 0.25 * d;
        }
        let i1 = 2.0 / d * (sin - 0.5 * d * cos);
        let x2 = 2.0 / d * (0.25 * d * d * sin + d * cos - 2.0 * sin);
        let k = 0.5 * sin / d - x2 / (d * d);
        ((1.0 - cos) - i1) / (d * k)
    }

    /// The index of the texel that contains the point.
    #[inline]
    pub(crate) fn texel(&self, [x, y]: [f64; 2]) -> usize {
        (x as usize).min(self.width - 1) + self.width * (y as usize).min(self.height - 1)
    }

    /// The range of columns and rows around the point `p` in which the four texels around each point are neighbors in
    /// the picture; `None` in a picture with rims.
    pub(crate) fn inner_part(&self, p: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let (top, height) = match self.mapping {
            Mapping::LatLong | Mapping::Octahedral | Mapping::EqualArea => (0, self.height),
            Mapping::Cube => (((p[1] / self.width as f64) as usize).min(cube::FACES - 1) * self.width, self.width),
            _ => return None,
        };
        let between_centers = |start: usize, length: usize| [start as f64 + 0.5, (start + length) as f64 - 0.5];
        Some([between_centers(0, self.width), between_centers(top, height)])
    }

    /// The taps of the value at the point `p`.
    ///
    /// Beyond an edge the picture continues with the texels that are neighbors on the sphere.
    #[inline]
    pub(crate) fn taps(&self, p: [f64; 2]) -> Taps {
        match self.mapping {
            Mapping::LatLong => self.lat_long(p),
            Mapping::Cube => self.cube(p),
            Mapping::Octahedral | Mapping::EqualArea => self.folded_square(p),
            Mapping::DualParaboloid => self.paraboloids(p),
            Mapping::Sphere | Mapping::MirrorBall | Mapping::Angular => self.ball(p),
        }
    }

    /// Columns wrap around; beyond the first and the last row comes the same row, half a turn further.
    #[inline]
    fn lat_long(&self, [x, y]: [f64; 2]) -> Taps {
        let (column, row) = (x - 0.5, y - 0.5);
        let (left, above) = (column.floor(), row.floor());
        let (s, t) = ((column - left) as f32, (row - above) as f32);
        let mut taps = Taps::NONE;
        if left >= 0.0 && above >= 0.0 && left + 1.0 < self.width as f64 && above + 1.0 < self.height as f64 {
            let first = above as usize * self.width + left as usize;
            let last = first + self.width;
            taps.list[..4].copy_from_slice(&[
                (first as u32, (1.0 - s) * (1.0 - t)),
                (first as u32 + 1, s * (1.0 - t)),
                (last as u32, (1.0 - s) * t),
                (last as u32 + 1, s * t),
            ]);
            taps.len = 4;
            return taps;
        }
        let last = self.height as f64 - 1.0;
        for (y, weight) in [(above, 1.0 - t), (above + 1.0, t)] {
            let across = if y < 0.0 || y > last { 0.5 * self.width as f64 } else { 0.0 };
            let start = y.clamp(0.0, last) as usize * self.width;
            let column = column + across;
            let left = column.floor();
            let s = (column - left) as f32;
            let left = left.rem_euclid(self.width as f64) as usize % self.width;
            let right = if left + 1 == self.width { 0 } else { left + 1 };
            taps.push(start + left, (1.0 - s) * weight);
            taps.push(start + right, s * weight);
        }
        taps
    }

    /// Beyond an edge of a face comes its neighbor, beyond a corner the mean of the three texels that meet there.
    #[inline]
    fn cube(&self, [x, y]: [f64; 2]) -> Taps {
        let size = self.width as isize;
        let face = ((y / self.width as f64) as usize).min(cube::FACES - 1);
        let inside = |i: isize| (0..size).contains(&i);
        let number = |x: isize, y: isize| {
            if inside(x) && inside(y) {
                return (face * self.width + y as usize) * self.width + x as usize;
            }
            let (face, x, y) = cube::neighbor(self.width, face, x, y);
            (face * self.width + y) * self.width + x
        };
        let mut taps = Taps::NONE;
        for_each_corner([x, y - (face * self.width) as f64], |x, y, weight| {
            if inside(x) || inside(y) {
                taps.push(number(x, y), weight);
            } else {
                let (cx, cy) = (x.clamp(0, size - 1), y.clamp(0, size - 1));
                for (x, y) in [(cx, cy), (x, cy), (cx, y)] {
                    taps.push(number(x, y), weight / 3.0);
                }
            }
        });
        taps
    }

    /// Beyond a side comes the same side, rotated about its middle.
    fn folded_square(&self, p: [f64; 2]) -> Taps {
        let (w, h) = (self.width as isize, self.height as isize);
        let mut taps = Taps::NONE;
        for_each_corner(p, |x, y, weight| {
            let beyond = (x < 0 || x >= w, y < 0 || y >= h);
            let (cx, cy) = (x.clamp(0, w - 1), y.clamp(0, h - 1));
            let (x, y) = (if beyond.1 { w - 1 - cx } else { cx }, if beyond.0 { h - 1 - cy } else { cy });
            taps.push(y as usize * self.width + x as usize, weight);
        });
        taps
    }

    /// A disc whose rim is one direction: across the rim lies the opposite point of the rim.
    fn ball(&self, [x, y]: [f64; 2]) -> Taps {
        let p = [2.0 * x / self.width as f64 - 1.0, 2.0 * y / self.height as f64 - 1.0];
        let disc = Disc { start: 0.0, width: self.width as f64, columns: 0..self.width };
        self.across_rim(p, &disc, &disc, [-p[0], -p[1]])
    }

    /// Across the rim of one disc lies the mirror image of the point in the other.
    fn paraboloids(&self, [x, y]: [f64; 2]) -> Taps {
        let width = 0.5 * self.width as f64;
        let back = usize::from(x >= width);
        let disc = |back: usize| Disc {
            start: back as f64 * width,
            width,
            columns: if back == 1 { self.width / 2..self.width } else { 0..self.width.div_ceil(2) },
        };
        let p = [2.0 * (x - back as f64 * width) / width - 1.0, 2.0 * y / self.height as f64 - 1.0];
        self.across_rim(p, &disc(back), &disc(1 - back), [-p[0], p[1]])
    }

    /// Blends over the last half texel before the rim: at the rim both sides have the same weight.
    fn across_rim(&self, p: [f64; 2], disc: &Disc, other: &Disc, beyond: [f64; 2]) -> Taps {
        let mut taps = Taps::NONE;
        let inner = (1.0 - 1.0 / disc.width.min(self.height as f64)).max(0.0);
        let r = p[0].hypot(p[1]);
        if r <= inner {
            self.on_disc(p, disc, 1.0, &mut taps);
            return taps;
        }
        let scale = inner / r;
        let t = 0.5 * ((r - inner) / (1.0 - inner)).min(1.0);
        self.on_disc(p.map(|c| scale * c), disc, 1.0 - t, &mut taps);
        self.on_disc(beyond.map(|c| scale * c), other, t, &mut taps);
        taps
    }

    /// The taps of point `p` of a disc, among those of the four texels around it that touch the disc.
    fn on_disc(&self, p: [f64; 2], disc: &Disc, share: f64, taps: &mut Taps) {
        let height = self.height as f64;
        let corner = [disc.start + 0.5 * (p[0] + 1.0) * disc.width, 0.5 * (p[1] + 1.0) * height];
        let nearest = |i: f64, start: f64, n: f64| {
            let edge = |i: f64| 2.0 * (i - start) / n - 1.0;
            0.0_f64.clamp(edge(i), edge(i + 1.0))
        };
        let (first, mut sum) = (taps.len, 0.0);
        for_each_corner(corner, |x, y, weight| {
            let exists = x >= disc.columns.start as isize
                && x < disc.columns.end as isize
                && (0..self.height as isize).contains(&y);
            let shown = nearest(x as f64, disc.start, disc.width).hypot(nearest(y as f64, 0.0, height)) < 1.0;
            if exists && shown && weight > 0.0 {
                taps.push(y as usize * self.width + x as usize, weight);
                sum += weight;
            }
        });
        for (_, weight) in &mut taps.list[first..taps.len] {
            *weight *= share as f32 / sum;
        }
    }
}

/// The square around a disc: its first column, its width, and the columns that touch the disc.
struct Disc {
    start: f64,
    width: f64,
    columns: Range<usize>,
}

/// Calls `corner(column, row, weight)` for the four texels whose centers surround a point.
#[inline(always)]
fn for_each_corner([x, y]: [f64; 2], mut corner: impl FnMut(isize, isize, f32)) {
    let (column, row) = (x - 0.5, y - 0.5);
    let (left, above) = (column.floor(), row.floor());
    let (s, t) = ((column - left) as f32, (row - above) as f32);
    let (x, y) = (left as isize, above as isize);
    corner(x, y, (1.0 - s) * (1.0 - t));
    corner(x + 1, y, s * (1.0 - t));
    corner(x, y + 1, (1.0 - s) * t);
    corner(x + 1, y + 1, s * t);
}
