//! Radiance between the texel centres of any mapping, across its seams.

use lobe_sh::{Coefficient, Dir, Rgb};

use crate::disc::{Frame, Profile};
use crate::{Mapping, cube, dual_paraboloid, lat_long, mirror_ball};

/// A picture of a mapping, borrowed.
#[derive(Clone, Copy)]
pub(crate) struct Texels<'a> {
    pub(crate) mapping: Mapping,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) texels: &'a [Rgb<f32>],
}

impl Texels<'_> {
    /// The texel that contains the direction `s`.
    #[inline]
    pub(crate) fn nearest(&self, s: Dir) -> usize {
        let (u, v) = self.mapping.uv_from_dir(s);
        let column = ((u * self.width as f64) as usize).min(self.width - 1);
        column + self.width * ((v * self.height as f64) as usize).min(self.height - 1)
    }

    /// The radiance from direction `s`, interpolated bilinearly between texel centres.
    pub(crate) fn radiance(&self, s: Dir) -> Rgb<f32> {
        match self.mapping {
            Mapping::LatLong => self.lat_long(s),
            Mapping::Cube => self.cube(s),
            Mapping::Octahedral | Mapping::EqualArea => self.folded_square(s),
            Mapping::DualParaboloid => self.paraboloids(s),
            Mapping::Sphere => self.ball(Profile::Ball, &mirror_ball::SPHERE, s),
            Mapping::MirrorBall => self.ball(Profile::Ball, &mirror_ball::MIRROR_BALL, s),
            Mapping::Angular => self.ball(Profile::Angular, &crate::angular::FRAME, s),
        }
    }

    fn texel(&self, x: usize, y: usize) -> Rgb<f32> {
        self.texels[y * self.width + x]
    }

    /// Columns wrap around; beyond the first and the last row follows the same row, half a turn further.
    fn lat_long(&self, s: Dir) -> Rgb<f32> {
        let (u, v) = lat_long::uv_from_dir(s);
        let column = u * self.width as f64 - 0.5;
        let row = v * self.height as f64 - 0.5;
        let (above, last) = (row.floor(), self.height as f64 - 1.0);
        let at = |y: f64| {
            let across = if y < 0.0 || y > last { 0.5 * self.width as f64 } else { 0.0 };
            self.lerp_row(y.clamp(0.0, last) as usize, column + across)
        };
        lerp(at(above), at(above + 1.0), (row - above) as f32)
    }

    /// Row `y` at a fractional column, in texels from the first centre, wrapped around.
    fn lerp_row(&self, y: usize, column: f64) -> Rgb<f32> {
        let left = column.floor();
        let t = (column - left) as f32;
        let left = left.rem_euclid(self.width as f64) as usize % self.width;
        let right = if left + 1 == self.width { 0 } else { left + 1 };
        lerp(self.texel(left, y), self.texel(right, y), t)
    }

    /// Beyond an edge of a face follows its neighbour, beyond a corner the mean of the three texels that meet there.
    fn cube(&self, s: Dir) -> Rgb<f32> {
        let (face, u, v) = cube::face_from_dir(s);
        let size = self.width as isize;
        let inside = |i: isize| (0..size).contains(&i);
        let get = |x: isize, y: isize| {
            if inside(x) && inside(y) {
                return self.texel(x as usize, face * self.width + y as usize);
            }
            let (face, x, y) = cube::neighbour(self.width, face, x, y);
            self.texel(x, face * self.width + y)
        };
        let clamped = |i: isize| i.clamp(0, size - 1);
        self.bilinear(u, v, self.width, |x, y| {
            if inside(x) || inside(y) {
                get(x, y)
            } else {
                let sum = get(clamped(x), clamped(y)) + get(x, clamped(y)) + get(clamped(x), y);
                sum.scale(1.0 / 3.0)
            }
        })
    }

    /// Beyond a side follows the same side, turned about its middle.
    fn folded_square(&self, s: Dir) -> Rgb<f32> {
        let (u, v) = self.mapping.uv_from_dir(s);
        let (w, h) = (self.width as isize, self.height as isize);
        self.bilinear(u, v, self.height, |x, y| {
            let beyond = (x < 0 || x >= w, y < 0 || y >= h);
            let (cx, cy) = (x.clamp(0, w - 1), y.clamp(0, h - 1));
            let (x, y) = (if beyond.1 { w - 1 - cx } else { cx }, if beyond.0 { h - 1 - cy } else { cy });
            self.texel(x as usize, y as usize)
        })
    }

    /// The four texels around `(u, v)` of a picture, or a face, of `width` x `height` texels.
    fn bilinear(&self, u: f64, v: f64, height: usize, get: impl Fn(isize, isize) -> Rgb<f32>) -> Rgb<f32> {
        let (column, row) = (u * self.width as f64 - 0.5, v * height as f64 - 0.5);
        let (left, above) = (column.floor(), row.floor());
        let (s, t) = ((column - left) as f32, (row - above) as f32);
        let (x, y) = (left as isize, above as isize);
        lerp(lerp(get(x, y), get(x + 1, y), s), lerp(get(x, y + 1), get(x + 1, y + 1), s), t)
    }

    /// A disc whose rim is one direction: across the rim lies the opposite point of the rim.
    fn ball(&self, profile: Profile, frame: &Frame, s: Dir) -> Rgb<f32> {
        let p = frame.point(profile, s);
        self.across_rim(p, 0..self.width, self.width as f64, 0.0, |scale| {
            self.on_disc([-scale * p[0], -scale * p[1]], 0..self.width, self.width as f64, 0.0)
        })
    }

    /// Across the rim of one disc lies the mirror image of the point in the other.
    fn paraboloids(&self, s: Dir) -> Rgb<f32> {
        let half = usize::from(s.x() < 0.0);
        let p = dual_paraboloid::FRAMES[half].point(Profile::Paraboloid, s);
        let width = 0.5 * self.width as f64;
        let columns = [0..self.width.div_ceil(2), self.width / 2..self.width];
        let start = [0.0, width];
        self.across_rim(p, columns[half].clone(), width, start[half], |scale| {
            self.on_disc([-scale * p[0], scale * p[1]], columns[1 - half].clone(), width, start[1 - half])
        })
    }

    /// Blends over the last half texel before the rim: at the rim both sides count the same.
    fn across_rim(
        &self,
        p: [f64; 2],
        columns: std::ops::Range<usize>,
        width: f64,
        start: f64,
        beyond: impl Fn(f64) -> Rgb<f32>,
    ) -> Rgb<f32> {
        let inner = (1.0 - 1.0 / width.min(self.height as f64)).max(0.0);
        let r = p[0].hypot(p[1]);
        if r <= inner {
            return self.on_disc(p, columns, width, start);
        }
        let scale = inner / r;
        let t = 0.5 * ((r - inner) / (1.0 - inner)).min(1.0);
        lerp(self.on_disc(p.map(|c| scale * c), columns, width, start), beyond(scale), t as f32)
    }

    /// The disc at point `p`, bilinear between those of the four texels around it that show a part of the disc.
    ///
    /// The square around the disc begins at column `start` and is `width` texels wide.
    fn on_disc(&self, p: [f64; 2], columns: std::ops::Range<usize>, width: f64, start: f64) -> Rgb<f32> {
        let column = start + 0.5 * (p[0] + 1.0) * width - 0.5;
        let row = 0.5 * (p[1] + 1.0) * self.height as f64 - 0.5;
        let (left, above) = (column.floor(), row.floor());
        let nearest = |i: f64, start: f64, n: f64| {
            let edge = |i: f64| 2.0 * (i - start) / n - 1.0;
            0.0_f64.clamp(edge(i), edge(i + 1.0))
        };
        let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
        for (y, wy) in [(above, above + 1.0 - row), (above + 1.0, row - above)] {
            for (x, wx) in [(left, left + 1.0 - column), (left + 1.0, column - left)] {
                let shown = nearest(x, start, width).hypot(nearest(y, 0.0, self.height as f64)) < 1.0;
                let weight = (wx * wy) as f32;
                let exists = x >= columns.start as f64 && x < columns.end as f64 && y >= 0.0 && y < self.height as f64;
                if exists && shown && weight > 0.0 {
                    sum += self.texel(x as usize, y as usize).scale(weight);
                    weights += weight;
                }
            }
        }
        sum.scale(1.0 / weights)
    }
}

/// `(1 - t) a + t b`, exact at both ends.
fn lerp(a: Rgb<f32>, b: Rgb<f32>, t: f32) -> Rgb<f32> {
    a.scale(1.0 - t) + b.scale(t)
}
