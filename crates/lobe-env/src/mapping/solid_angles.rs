//! Table of the solid angles of all texels of a picture.

use lobe_io::parallel;

use crate::mapping::grid::Grid;
use crate::mapping::mapping::Mapping;

/// [`Mapping::solid_angle`] of every texel; a quarter of them is stored, as every mapping is mirror-symmetric.
pub(crate) struct SolidAngles {
    /// Columns of the picture.
    width: usize,
    /// Columns of the table.
    columns: usize,
    /// The first entry of each row of the picture in the table.
    rows: Vec<usize>,
    table: Vec<f64>,
}

impl SolidAngles {
    pub(crate) fn new(grid: Grid) -> Self {
        let Grid { mapping, width, height } = grid;
        let face = height / mapping.faces();
        let columns = if mapping.form().has_rows_of_latitude() { 1 } else { width.div_ceil(2) };
        let mut table = vec![0.0; columns * face.div_ceil(2)];
        parallel::fill(&mut table, width.div_ceil(2), &|i| {
            mapping.solid_angle(width, height, i % columns, i / columns)
        });
        let rows = (0..height).map(|y| y % face).map(|y| y.min(face - 1 - y) * columns).collect();
        Self { width, columns, rows, table }
    }

    /// For a picture of `width` x `height` texels.
    pub(crate) fn of(mapping: Mapping, width: usize, height: usize) -> Self {
        Self::new(Grid::new(mapping, width, height))
    }

    /// The solid angle of texel `(x, y)`.
    #[inline]
    pub(crate) fn get(&self, x: usize, y: usize) -> f64 {
        let column = if self.columns == 1 { 0 } else { x.min(self.width - 1 - x) };
        self.table[self.rows[y] + column]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_solid_angle_of_every_texel() {
        for mapping in Mapping::ALL {
            for (w, h) in [(1, 1), (2, 3), (7, 4), (8, 8), (13, 9)] {
                let h = if mapping == Mapping::Cube { 6 * w } else { h };
                let table = SolidAngles::of(mapping, w, h);
                for i in 0..w * h {
                    let (found, exact) = (table.get(i % w, i / w), mapping.solid_angle(w, h, i % w, i / w));
                    assert!((found - exact).abs() < 1e-13, "{mapping} {w} x {h}, texel {i}: {found} against {exact}");
                }
            }
        }
    }
}
