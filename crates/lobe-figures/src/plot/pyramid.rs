//! Pyramids of the basis functions: a row for each band `l`, a column for each `m`.

use std::f64::consts::PI;

use lobe_sh::basis::coefficient_index;
use lobe_sh::{Dir, Expansion, Rgb, ShVec};

use crate::plot::balloon::Balloon;
use crate::plot::cube_cross::CubeCross;
use lobe_image::{Label, Picture, draw_lines};
use lobe_render::View;

const WHITE: Rgb<f32> = Rgb::new(1.0, 1.0, 1.0);
const INK: Rgb<f32> = Rgb::new(0.05, 0.05, 0.05);

/// A sheet with one row for each band `l`, from 0 at the top, and one column for each `m`, from the lowest on the left.
#[derive(Clone, Copy, Debug)]
pub struct Pyramid {
    /// The number of bands.
    pub order: usize,
    /// The columns of a cell.
    pub cell_width: usize,
    /// The rows of a cell.
    pub cell_height: usize,
    /// Pixels between cells and around them.
    pub margin: usize,
}

impl Pyramid {
    /// Puts the picture `cell(l, m)` of every function in its place, with the numbers `l` and `m` at the border.
    #[must_use]
    pub fn compose(&self, mut cell: impl FnMut(usize, isize) -> Picture) -> Picture {
        let (left, columns) = (self.gutter(), (2 * self.order).saturating_sub(1));
        let width = left + self.margin + columns * (self.cell_width + self.margin);
        let height = 2 * self.margin + self.text_height() + self.order * (self.cell_height + self.margin);
        let mut sheet = Picture::filled(width, height, WHITE);
        for l in 0..self.order {
            for m in -(l as isize)..=l as isize {
                let (x, y) = self.place(l, m);
                sheet.paste(&cell(l, m), x as isize, y as isize);
            }
        }
        self.draw_numbers(&mut sheet);
        sheet
    }

    /// The column and row of the top left pixel of a cell.
    fn place(&self, l: usize, m: isize) -> (usize, usize) {
        let column = (self.order - 1).strict_add_signed(m);
        let x = self.gutter() + self.margin + column * (self.cell_width + self.margin);
        (x, self.margin + l * (self.cell_height + self.margin))
    }

    fn text_height(&self) -> usize {
        (self.cell_height / 10).clamp(10, 24)
    }

    /// The room for the numbers `l` on the left.
    fn gutter(&self) -> usize {
        self.margin + 2 * self.text_height() + self.text_height() / 2
    }

    fn draw_numbers(&self, sheet: &mut Picture) {
        let height = self.text_height() as f64;
        let at = |left: f64, top: f64| Label { left, top, height, color: INK.into() };
        for l in 0..self.order {
            let (x, y) = self.place(l, -(l as isize));
            let text = format!("l={l}");
            let width = at(0.0, 0.0).width(&text);
            let middle = y as f64 + 0.5 * (self.cell_height as f64 - height);
            at(x as f64 - width - 0.6 * height, middle).draw(sheet, &text);
        }
        let Some(last) = self.order.checked_sub(1) else { return };
        for m in -(last as isize)..=last as isize {
            let (x, y) = self.place(last, m);
            let text = format!("m={m}");
            let width = at(0.0, 0.0).width(&text);
            let center = x as f64 + 0.5 * (self.cell_width as f64 - width);
            at(center, (y + self.cell_height + self.margin) as f64).draw(sheet, &text);
        }
    }
}

/// The basis functions of bands `0..order` as balloons, all on one scale, `size` pixels each, in the three-quarter
/// view.
#[must_use]
pub fn basis_balloons(order: usize, size: usize) -> Picture {
    let pyramid = Pyramid { order, cell_width: size, cell_height: size, margin: size / 20 };
    let balloon = Balloon { extent: Some(largest_value(order)), ..Balloon::new(size) };
    let mut sheet = pyramid.compose(|l, m| balloon.picture(basis_function(l, m)));
    if order > 1 {
        let (length, margin) = (0.3 * size as f64, pyramid.margin as f64);
        draw_axes(&mut sheet, &View::three_quarter(), 2.0 * length + margin, 2.0 * length + margin, length, INK);
    }
    sheet
}

/// The basis functions of bands `0..order` on unfolded cubes with `face` pixels along an edge, each on its own
/// scale, with a key to the faces.
#[must_use]
pub fn basis_crosses(order: usize, face: usize) -> Picture {
    let pyramid = Pyramid { order, cell_width: 4 * face, cell_height: 3 * face, margin: face / 4 };
    let cross = CubeCross { levels: 5, labels: false, ..CubeCross::new(face) };
    let mut sheet = pyramid.compose(|l, m| cross.picture(basis_function(l, m)));
    if order > 1 {
        let (x, y) = (pyramid.gutter() + pyramid.margin, pyramid.margin);
        sheet.paste(&cross.key(), x as isize, y as isize);
    }
    sheet
}

/// The largest value of any basis function of bands `0..order`: that of the last `y_l^0` at the pole,
/// `√((2l+1)/4π)`.
///
/// No other function of the band exceeds it, since `Σ_m y_lm² = (2l+1)/4π` everywhere.
fn largest_value(order: usize) -> f64 {
    ((2 * order).saturating_sub(1) as f64 / (4.0 * PI)).sqrt()
}

fn basis_function(l: usize, m: isize) -> impl Fn(Dir) -> f64 + Sync {
    let mut f = ShVec::<f64>::zero(l + 1);
    f[coefficient_index(l, m)] = 1.0;
    move |s| f.eval(s)
}

/// Draws the axes from the point `(x, y)`, each `length` pixels long when seen from the side, with their names.
fn draw_axes(picture: &mut Picture, view: &View, x: f64, y: f64, length: f64, color: Rgb<f32>) {
    let axes = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];
    let ends = axes.map(|(name, axis)| {
        let [right, up, _] = view.project(axis);
        (name, [right, -up])
    });
    let lines = ends.map(|(_, [dx, dy])| [[x, y], [x + length * dx, y + length * dy]]);
    draw_lines(picture, &lines, (0.03 * length).max(1.2), color);
    for (name, [dx, dy]) in ends {
        let height = (0.3 * length).max(9.0);
        let label = Label { left: 0.0, top: 0.0, height, color: color.into() };
        let away = length + 0.75 * height;
        // An axis that points at the eye has no direction in the picture.
        let scale = if dx.hypot(dy) > 0.1 { (length * dx.hypot(dy) + 0.75 * height) / dx.hypot(dy) } else { away };
        let (left, top) = (x + scale * dx - 0.5 * label.width(name), y + scale * dy - 0.5 * height);
        Label { left, top, ..label }.draw(picture, name);
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::eval_basis;

    use super::*;

    #[test]
    fn cells_stand_in_rows_by_band_and_columns_by_m() {
        let pyramid = Pyramid { order: 3, cell_width: 12, cell_height: 8, margin: 2 };
        let sheet = pyramid.compose(|l, m| Picture::filled(12, 8, Rgb::new(l as f32, m as f32, 9.0)));
        let first = pyramid.gutter() + 2;
        assert_eq!(sheet.width(), first + 5 * 14, "five columns");
        assert_eq!(sheet.height(), 2 + 3 * 10 + 10 + 2, "three rows and the numbers below");
        for (l, m, x, y) in [(0, 0, first + 28, 2), (1, -1, first + 14, 12), (2, 2, first + 56, 22)] {
            let expected = [l as f32, m as f32, 9.0];
            assert_eq!(sheet.pixel(x, y), expected, "the top left pixel of l = {l}, m = {m}");
            assert_eq!(sheet.pixel(x + 11, y + 7), expected, "the bottom right pixel of l = {l}, m = {m}");
        }
    }

    #[test]
    fn order_zero_is_an_empty_sheet() {
        assert!(basis_balloons(0, 20).pixels().iter().all(|&c| c == [1.0; 3]), "white");
    }

    #[test]
    fn no_function_exceeds_the_common_scale() {
        for order in 1..5 {
            for s in lobe_testkit::directions() {
                let values = eval_basis(Dir::new(s).unwrap(), order);
                let largest = values.into_iter().fold(0.0, |m: f64, y| m.max(y.abs()));
                assert!(largest <= largest_value(order) + 1e-12, "order {order} at {s:?}: {largest}");
            }
        }
    }
}
