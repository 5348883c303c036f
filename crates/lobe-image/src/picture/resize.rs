//! Resizing by area averaging.

use lobe_io::parallel;

use crate::picture::picture::Picture;
use crate::pixel::{add, narrowed, scaled, widened};

impl Picture {
    /// The picture in another size; every new pixel is the mean over the area it covers.
    ///
    /// ```text
    ///   new(i) = Σ_k |[i s, (i+1) s] ∩ [k, k+1]| old(k) / s        s = old size / new size
    /// ```
    ///
    /// along rows, then along columns. The mean of the picture is kept, to rounding. Enlarging repeats pixels.
    ///
    /// # Panics
    /// If this picture is empty and the new one is not.
    #[must_use]
    pub fn resized(&self, width: usize, height: usize) -> Self {
        let columns = overlaps(self.width(), width);
        let rows = overlaps(self.height(), height);
        let mut in_columns = vec![[0.0; 3]; self.height() * width];
        // Without columns there is nothing to visit, but a row needs a width.
        parallel::rows(&mut in_columns, width.max(1), &|y, out| {
            let row = &self.pixels()[y * self.width()..][..self.width()];
            for (out, parts) in out.iter_mut().zip(&columns) {
                *out = weighted_sum(parts, |x| widened(row[x]));
            }
        });
        Self::from_fn(width, height, |x, y| narrowed(weighted_sum(&rows[y], |k| in_columns[k * width + x])))
    }
}

/// For every new pixel the old ones it overlaps, with the fraction of the new pixel that each covers.
fn overlaps(old: usize, new: usize) -> Vec<Vec<(usize, f64)>> {
    assert!(old > 0 || new == 0, "an empty picture cannot be enlarged");
    let s = old as f64 / new as f64;
    (0..new)
        .map(|i| {
            // The ends in units of 1/new are integers, so neighbors share them exactly.
            let (first, end) = (i * old / new, ((i + 1) * old).div_ceil(new));
            let (start, stop) = (i as f64 * s, (i + 1) as f64 * s);
            (first..end).map(|k| (k, (stop.min((k + 1) as f64) - start.max(k as f64)).max(0.0) / s)).collect()
        })
        .collect()
}

fn weighted_sum(parts: &[(usize, f64)], value: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
    parts.iter().fold([0.0; 3], |sum, &(k, weight)| add(sum, scaled(value(k), weight)))
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn resizing_preserves_the_mean() {
        let mut random = Random::new(3);
        let pixels: Vec<[f32; 3]> = (0..37 * 23).map(|_| [0; 3].map(|_| random.unit() as f32)).collect();
        let picture = Picture::new(37, 23, pixels).unwrap();
        for (width, height) in [(1, 1), (7, 5), (12, 23), (36, 22), (37, 23), (64, 91)] {
            let (before, after) = (picture.mean(), picture.resized(width, height).mean());
            for c in 0..3 {
                let (a, b) = (before[c], after[c]);
                // Every new pixel is rounded to f32 once.
                assert!((a - b).abs() < 1e-7, "{width} x {height}, channel {c}: mean {a} became {b}");
            }
        }
    }

    #[test]
    fn whole_factors_average_blocks_and_repeat_pixels() {
        let picture = Picture::from_fn(4, 2, |x, y| [(x + 10 * y) as f32; 3]);
        let half = picture.resized(2, 1);
        assert_eq!(half.pixels(), [[5.5; 3], [7.5; 3]], "blocks of 2 x 2");
        let double = picture.resized(8, 4);
        for y in 0..4 {
            for x in 0..8 {
                assert_eq!(double.pixel(x, y), picture.pixel(x / 2, y / 2), "pixel ({x}, {y})");
            }
        }
    }
}
