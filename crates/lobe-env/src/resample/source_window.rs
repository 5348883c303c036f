//! Source windows: the source texels under a patch of the target, copied to contiguous memory.
//!
//! Rows of a large picture are far apart in memory: the footprints of a patch touch as many pages as rows. So light is
//! gathered from a copy, and energies are summed into a window before they are added to the picture.

use lobe_sh::Rgb;

use crate::resample::footprint::{Quad, Tile};
use crate::resample::sparse_sum::SparseSum;

/// Red, green and blue, and 1: what is summed with weights then holds their sum too.
type Light = [f32; 4];

/// The light of a window.
#[derive(Default)]
pub(crate) struct WindowLight {
    width: usize,
    texels: Vec<Light>,
}

impl WindowLight {
    /// Copies the window from a picture of `columns` columns.
    pub(crate) fn fill(&mut self, window: Tile, light: &[Rgb<f32>], columns: usize) {
        self.width = window.width;
        self.texels.clear();
        for start in window.rows(columns) {
            let row = &light[start..start + window.width];
            self.texels.extend(row.iter().map(|texel| [texel.r, texel.g, texel.b, 1.0]));
        }
    }

    /// The weighted sum of the light in some quads of the window, and the sum of the weights.
    #[inline(always)]
    pub(crate) fn total(&self, quads: &[Quad]) -> (Rgb<f64>, f64) {
        let mut total = [0.0; 4];
        for &Quad { first, weights: [a, b, c, d] } in quads {
            let first = first as usize;
            let ([p, q], [r, s]) = (self.pair(first), self.pair(first + self.width));
            for k in 0..4 {
                total[k] += f64::from((a * p[k] + b * q[k]) + (c * r[k] + d * s[k]));
            }
        }
        let [r, g, b, weight] = total;
        (Rgb::new(r, g, b), weight)
    }

    /// Two horizontal neighbors.
    #[inline(always)]
    fn pair(&self, first: usize) -> &[Light; 2] {
        let Some(pair) = self.texels[first..].first_chunk() else { unreachable!("a quad lies inside the window") };
        pair
    }
}

/// Energies of the texels of a window.
///
/// Where a picture is enlarged, up to 1024 samples of a patch are added in single precision; the relative error of a
/// sum is 1e-6 or 2e-6 at random, 2e-5 where all terms are equal.
#[derive(Default)]
pub(crate) struct WindowSums {
    /// For each texel the sums of the four weights of the quads that begin there: each addition is of one aligned
    /// vector.
    quads: Vec<[f32; 4]>,
    width: usize,
    row: Vec<f64>,
}

impl WindowSums {
    /// Clears the sums.
    pub(crate) fn clear(&mut self, window: Tile) {
        self.width = window.width;
        self.quads.clear();
        self.quads.resize(window.len(), [0.0; 4]);
    }

    /// Adds the weights of some quads of the window, times `scale`.
    #[inline(always)]
    pub(crate) fn add(&mut self, quads: &[Quad], scale: f32) {
        for &Quad { first, weights } in quads {
            debug_assert!(!(first as usize + 1).is_multiple_of(self.width), "a quad begins left of the last column");
            let sums = &mut self.quads[first as usize];
            for k in 0..4 {
                sums[k] += scale * weights[k];
            }
        }
    }

    /// Adds the sums to those of a picture of `columns` columns.
    pub(crate) fn add_to(&mut self, sums: &mut SparseSum, window: Tile, columns: usize) {
        let row = |j: usize| &self.quads[j * window.width..][..window.width];
        for (j, start) in window.rows(columns).enumerate() {
            self.row.clear();
            self.row.resize(window.width, 0.0);
            add_halves(&mut self.row, row(j), 0);
            if j > 0 {
                add_halves(&mut self.row, row(j - 1), 2);
            }
            sums.add_row(start, &self.row);
        }
    }
}

/// Adds the upper (k = 0) or lower (k = 2) halves of quads to a row.
fn add_halves(row: &mut [f64], quads: &[[f32; 4]], k: usize) {
    for (x, quad) in quads.iter().enumerate() {
        row[x] += f64::from(quad[k]);
        // The quads of the last column are empty.
        if let Some(right) = row.get_mut(x + 1) {
            *right += f64::from(quad[k + 1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::resample::footprint::Footprint;
    use crate::resample::sparse_sum::BLOCK;

    const COLUMNS: usize = 300;
    const ROWS: usize = 9;
    const WINDOW: Tile = Tile { x: 250, y: 2, width: 13, height: 6 };

    /// Random quads of the window, and the same quads in the picture.
    fn random_quads(random: &mut Random) -> (Vec<Quad>, Vec<Quad>) {
        let mut below = |n: usize| (random.unit() * n as f64) as usize;
        let places: Vec<[usize; 2]> = (0..200).map(|_| [below(WINDOW.width - 1), below(WINDOW.height - 1)]).collect();
        let weights: Vec<[f32; 4]> = places.iter().map(|_| [(); 4].map(|()| random.unit() as f32)).collect();
        let quads = |first: &dyn Fn([usize; 2]) -> usize| {
            places.iter().zip(&weights).map(|(p, w)| Quad { first: first(*p) as u32, weights: *w }).collect()
        };
        let in_picture = |[x, y]: [usize; 2]| (WINDOW.y + y) * COLUMNS + WINDOW.x + x;
        (quads(&|[x, y]| y * WINDOW.width + x), quads(&in_picture))
    }

    #[test]
    fn light_seen_through_a_window_is_that_of_the_picture() {
        let mut random = Random::new(1);
        let light: Vec<Rgb<f32>> = (0..COLUMNS * ROWS).map(|_| [(); 3].map(|()| random.unit() as f32).into()).collect();
        let (quads, quads_of_picture) = random_quads(&mut random);
        let mut window_light = WindowLight::default();
        for _ in 0..2 {
            window_light.fill(WINDOW, &light, COLUMNS);
        }
        let (found, weight) = window_light.total(&quads);
        let (expected, expected_weight) = Footprint { quads: &quads_of_picture, shares: &[] }.total(&light, COLUMNS);
        assert!((found - expected).to_array().iter().all(|e| e.abs() < 1e-9), "{found:?}, not {expected:?}");
        assert!((weight - expected_weight).abs() < 1e-6 * expected_weight, "{weight}, not {expected_weight}");
    }

    #[test]
    fn sums_in_a_window_become_those_of_the_picture() {
        let (quads, quads_of_picture) = random_quads(&mut Random::new(2));
        let (mut window_sums, mut sums) = (WindowSums::default(), SparseSum::new(COLUMNS * ROWS));
        window_sums.clear(WINDOW);
        window_sums.add(&quads, 0.5);
        window_sums.add_to(&mut sums, WINDOW, COLUMNS);
        let mut found = vec![0.0; (COLUMNS * ROWS).next_multiple_of(BLOCK)];
        for (block, found) in found.chunks_mut(BLOCK).enumerate() {
            sums.add_block(block, found);
        }
        let mut expected = vec![0.0; found.len()];
        Footprint { quads: &quads_of_picture, shares: &[] }.for_each(COLUMNS, |s, weight| expected[s] += 0.5 * weight);
        assert!(expected.iter().filter(|sum| **sum > 0.0).count() > WINDOW.len() / 2, "most texels are seen");
        for (s, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!((found - expected).abs() < 1e-6, "texel {s}: {found}, not {expected}");
        }
    }
}
