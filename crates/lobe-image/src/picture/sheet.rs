//! Contact sheets: several pictures in a grid.

use crate::picture::picture::Picture;
use crate::pixel::Pixel;

/// A contact sheet: pictures in rows of equal cells.
///
/// Every cell is as large as the largest picture; smaller ones are centered.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    /// Pictures in a row.
    pub columns: usize,
    /// Pixels between cells and around them.
    pub margin: usize,
    /// The color between the pictures.
    pub background: Pixel,
}

impl Sheet {
    /// The sheet of `pictures`, row by row.
    ///
    /// # Panics
    /// If `columns` is 0.
    #[must_use]
    pub fn compose(&self, pictures: &[Picture]) -> Picture {
        assert!(self.columns > 0, "a sheet needs at least one column");
        let width = pictures.iter().map(Picture::width).max().unwrap_or(0);
        let height = pictures.iter().map(Picture::height).max().unwrap_or(0);
        let columns = self.columns.min(pictures.len());
        let rows = pictures.len().div_ceil(self.columns);
        let length = |cells: usize, cell: usize| self.margin + cells * (cell + self.margin);
        let mut sheet = Picture::filled(length(columns, width), length(rows, height), self.background);
        for (i, picture) in pictures.iter().enumerate() {
            let left = length(i % self.columns, width) + (width - picture.width()) / 2;
            let top = length(i / self.columns, height) + (height - picture.height()) / 2;
            sheet.paste(picture, left as isize, top as isize);
        }
        sheet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_in_rows_with_margins_around_them() {
        let sheet = Sheet { columns: 2, margin: 3, background: [0.0; 3] };
        let pictures: Vec<_> = [(4, 2), (4, 2), (2, 2)]
            .iter()
            .enumerate()
            .map(|(i, &(w, h))| Picture::filled(w, h, [i as f32 + 1.0; 3]))
            .collect();
        let composed = sheet.compose(&pictures);
        assert_eq!((composed.width(), composed.height()), (3 + 2 * 7, 3 + 2 * 5), "two columns, two rows");
        let expected = |x: usize, y: usize| match (x, y) {
            (3..7, 3..5) => 1.0,
            (10..14, 3..5) => 2.0,
            (4..6, 8..10) => 3.0,
            _ => 0.0,
        };
        for y in 0..composed.height() {
            for x in 0..composed.width() {
                assert_eq!(composed.pixel(x, y)[0], expected(x, y), "pixel ({x}, {y})");
            }
        }
    }

    #[test]
    fn a_sheet_of_nothing_is_its_margin() {
        let composed = Sheet { columns: 4, margin: 5, background: [0.0; 3] }.compose(&[]);
        assert_eq!((composed.width(), composed.height()), (5, 5), "no cells");
    }
}
