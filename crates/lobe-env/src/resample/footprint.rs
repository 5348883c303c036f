//! Footprints: the texels of the source whose weighted mean is a texel of the target.

use lobe_sh::{Coefficient, Rgb};

use crate::mapping::taps::Share;

/// A block of texels of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Tile {
    /// The block of one texel.
    pub(crate) fn of_texel([x, y]: [usize; 2]) -> Self {
        Self { x, y, width: 1, height: 1 }
    }

    /// The number of texels.
    pub(crate) fn len(&self) -> usize {
        self.width * self.height
    }

    /// The index of the first texel of each row, in a picture of `columns` columns.
    pub(crate) fn rows(&self, columns: usize) -> impl Iterator<Item = usize> {
        let Self { x, y, height, .. } = *self;
        (y..y + height).map(move |y| y * columns + x)
    }

    /// The middle texel and the four in the corners.
    pub(crate) fn landmarks(&self) -> [[usize; 2]; 5] {
        let Self { x, y, width, height } = *self;
        let (right, below) = (x + width - 1, y + height - 1);
        [[x + width / 2, y + height / 2], [x, y], [right, y], [x, below], [right, below]]
    }

    /// The four quarters; the two halves of a single row or column.
    pub(crate) fn quarters(&self) -> impl Iterator<Item = Self> {
        let halves = |start: usize, length: usize| {
            let half = length.div_ceil(2);
            [(start, half), (start + half, length - half)]
        };
        let (across, down) = (halves(self.x, self.width), halves(self.y, self.height));
        let parts = down
            .into_iter()
            .flat_map(move |(y, height)| across.into_iter().map(move |(x, width)| Self { x, y, width, height }));
        parts.filter(|part| part.width > 0 && part.height > 0)
    }
}

/// A bilinear footprint: texel `first`, the one to its right and the two below, with weights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quad {
    pub(crate) first: u32,
    pub(crate) weights: [f32; 4],
}

impl Quad {
    /// The indices of the texels in a picture of `width` columns.
    #[inline(always)]
    pub(crate) fn texels(&self, width: usize) -> [usize; 4] {
        let first = self.first as usize;
        [first, first + 1, first + width, first + width + 1]
    }

    /// Each weight times the factor of its texel.
    #[inline(always)]
    pub(crate) fn scaled(&self, factors: &[f32], width: usize) -> Self {
        let ([i, j, k, l], [a, b, c, d]) = (self.texels(width), self.weights);
        Self { first: self.first, weights: [a * factors[i], b * factors[j], c * factors[k], d * factors[l]] }
    }
}

/// The footprint of a target texel; a source texel may occur several times.
#[derive(Clone, Copy)]
pub(crate) struct Footprint<'a> {
    pub(crate) quads: &'a [Quad],
    pub(crate) shares: &'a [Share],
}

impl Footprint<'_> {
    /// The sum of all weights.
    #[inline(always)]
    pub(crate) fn sum(&self) -> f64 {
        // By the operations of `total`: light of 1 everywhere stays 1.
        let quads: f64 =
            self.quads.iter().map(|&Quad { weights: [a, b, c, d], .. }| f64::from((a + b) + (c + d))).sum();
        quads + self.shares.iter().map(|(_, weight)| f64::from(*weight)).sum::<f64>()
    }

    /// The weighted sum of the light in the footprint, and the sum of the weights; `width` is that of the source.
    #[inline(always)]
    pub(crate) fn total(&self, light: &[Rgb<f32>], width: usize) -> (Rgb<f64>, f64) {
        let mut total: Rgb<f64> = Rgb::ZERO;
        for &Quad { first, weights: [a, b, c, d] } in self.quads {
            let first = first as usize;
            let ([p, q], [r, s]) = (pair(light, first), pair(light, first + width));
            total += ((p.scale(a) + q.scale(b)) + (r.scale(c) + s.scale(d))).widen();
        }
        for &(source, weight) in self.shares {
            total += light[source as usize].scale(weight).widen();
        }
        (total, self.sum())
    }

    /// Calls `each(source texel, weight)`; `width` is that of the source.
    #[cfg(test)]
    pub(crate) fn for_each(&self, width: usize, mut each: impl FnMut(usize, f64)) {
        for quad in self.quads {
            quad.texels(width).into_iter().zip(quad.weights).for_each(|(s, weight)| each(s, f64::from(weight)));
        }
        self.shares.iter().for_each(|&(s, weight)| each(s as usize, f64::from(weight)));
    }
}

/// Two horizontal neighbors.
#[inline(always)]
fn pair(light: &[Rgb<f32>], first: usize) -> &[Rgb<f32>; 2] {
    let Some(pair) = light[first..].first_chunk() else { unreachable!("a quad lies inside the picture") };
    pair
}

/// The footprints of several target texels.
#[derive(Default)]
pub(crate) struct Footprints {
    /// Column and row of each texel, and where its quads and its shares end.
    texels: Vec<[u32; 4]>,
    pub(crate) quads: Vec<Quad>,
    pub(crate) shares: Vec<Share>,
}

impl Footprints {
    /// Closes the footprint of texel `(x, y)`: the `quads` and `shares` added since the last one.
    pub(crate) fn end_texel(&mut self, [x, y]: [usize; 2]) {
        self.texels.push([x, y, self.quads.len(), self.shares.len()].map(|n| n as u32));
    }

    pub(crate) fn clear(&mut self) {
        self.texels.clear();
        self.quads.clear();
        self.shares.clear();
    }

    /// All footprints, as that of one texel.
    #[inline(always)]
    pub(crate) fn all(&self) -> Footprint<'_> {
        Footprint { quads: &self.quads, shares: &self.shares }
    }

    /// Calls `texel(place, view)` for every texel that is wanted.
    #[inline(always)]
    pub(crate) fn for_each(&self, wants: impl Fn(Tile) -> bool, mut texel: impl FnMut([usize; 2], Footprint<'_>)) {
        let (mut first_quad, mut first_share) = (0, 0);
        for texel_and_ends in &self.texels {
            let [x, y, quads, shares] = texel_and_ends.map(|n| n as usize);
            if wants(Tile::of_texel([x, y])) {
                let view =
                    Footprint { quads: &self.quads[first_quad..quads], shares: &self.shares[first_share..shares] };
                texel([x, y], view);
            }
            (first_quad, first_share) = (quads, shares);
        }
    }
}
