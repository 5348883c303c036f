//! Projection of a lat-long map whose rows come one after the other.

use lobe_io::parallel;
use lobe_sh::{Coefficient, ShVec};

use crate::projection::project::{add_pair, column_factors, sum_of_pairs};
use crate::projection::row_dft::RowDft;
use crate::projection::row_legendre::RowLegendre;

/// Rows that share one pass over the tables of cosines.
const ROWS_TOGETHER: usize = 16;

/// The projection of a lat-long map whose rows come some at a time, in any order, and need not be kept: of each row what remains is
/// `2 n` sums, in `48 h n` bytes.
///
/// The result is that of [`project_lat_long`](crate::project_lat_long) of the whole map, with the same bits (test
/// `rows_in_any_order_have_the_projection_of_the_map`).
///
/// ```
/// use lobe_env::{LatLongProjector, project_lat_long};
///
/// let texels: Vec<f32> = (0..64 * 32).map(|k| (k % 7) as f32).collect();
/// let mut projector = LatLongProjector::new(64, 32, 3);
/// for (y, row) in texels.chunks(64).enumerate().rev() {
///     projector.add_rows(y, row);
/// }
/// assert_eq!(projector.expansion(), project_lat_long(&texels, 64, 3));
/// ```
pub struct LatLongProjector<W> {
    width: usize,
    height: usize,
    azimuth: RowDft,
    columns: Vec<f64>,
    /// `[cos, sin]` for every `m < order`, row after row.
    sums: Vec<[W; 2]>,
}

impl<W: Coefficient<Scalar = f64, Wide = W>> LatLongProjector<W> {
    /// A projector of maps of `width x height` texels, all of them 0 so far.
    ///
    /// # Panics
    /// If the width is 0.
    #[must_use]
    pub fn new(width: usize, height: usize, order: usize) -> Self {
        assert!(width > 0, "rows of no texels");
        let sums = vec![[W::ZERO; 2]; height * order];
        Self { width, height, azimuth: RowDft::new(width, order), columns: column_factors(width, order), sums }
    }

    /// Adds the texels of the rows from `first` on to those that are there.
    ///
    /// # Panics
    /// If the texels are not whole rows, or more than there are from `first` on.
    pub fn add_rows<C: Coefficient<Wide = W>>(&mut self, first: usize, texels: &[C]) {
        let (width, order) = (self.width, self.columns.len());
        let count = texels.len() / width;
        assert!(
            texels.len().is_multiple_of(width) && first + count <= self.height,
            "{} texels are no rows of {width}, of {} from {first} on",
            texels.len(),
            self.height
        );
        if order == 0 {
            return;
        }
        let sums = &mut self.sums[first * order..][..count * order];
        parallel::rows(sums, ROWS_TOGETHER * order, &|k, sums| {
            let texels = &texels[k * ROWS_TOGETHER * width..];
            let rows: Vec<&[C]> = texels.chunks_exact(width).take(ROWS_TOGETHER).collect();
            self.azimuth.add_sums(&rows, sums);
        });
    }

    /// The coefficients of the map of all rows so far.
    #[must_use]
    pub fn expansion(&self) -> ShVec<W> {
        let order = self.columns.len();
        if order == 0 || self.height == 0 {
            return ShVec::zero(order);
        }
        let polar = RowLegendre::integrals(order, self.height);
        let row = |y: usize| &self.sums[y * order..][..order];
        sum_of_pairs(self.height, order, |pairs, part| {
            for y in pairs {
                add_pair(y, self.height, [row(y), row(self.height - 1 - y)], &polar, &self.columns, part);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Rgb;
    use lobe_testkit::Random;

    use super::*;
    use crate::projection::project::project_lat_long;

    #[test]
    fn rows_in_any_order_have_the_projection_of_the_map() {
        for (order, w, h) in [(0, 4, 2), (1, 1, 1), (3, 64, 32), (4, 17, 5), (8, 30, 301), (16, 128, 64), (20, 33, 18)]
        {
            let mut random = Random::new(order as u64);
            let texels: Vec<Rgb<f32>> =
                (0..w * h).map(|_| Rgb::from([(); 3].map(|()| random.signed() as f32))).collect();
            let expected = project_lat_long(&texels, w, order);
            for together in [1, 3, h] {
                let mut projector = LatLongProjector::new(w, h, order);
                let bands: Vec<_> = texels.chunks(together * w).enumerate().collect();
                for (k, band) in bands.iter().rev() {
                    projector.add_rows(k * together, band);
                }
                let found = projector.expansion();
                assert_eq!(found, expected, "order {order}, {w} x {h}, {together} rows at a time");
            }
        }
    }

    #[test]
    fn rows_that_never_come_are_black_and_rows_that_come_twice_count_twice() {
        let row = [1.0_f64; 8];
        let mut projector = LatLongProjector::new(8, 4, 3);
        projector.add_rows(1, &row);
        let mut texels = [0.0; 32];
        texels[8..16].fill(1.0);
        assert_eq!(projector.expansion(), project_lat_long(&texels, 8, 3), "one of four rows");
        projector.add_rows(1, &row);
        texels[8..16].fill(2.0);
        assert_eq!(projector.expansion(), project_lat_long(&texels, 8, 3), "twice");
    }
}
