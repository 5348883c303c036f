//! Cube-cross plots: a function on the unfolded cube, in colors with iso lines.

use lobe_io::parallel;
use lobe_sh::{Dir, Rgb};

use crate::plot::cube::{FACES, Face};
use crate::plot::iso_lines::IsoLines;
use lobe_image::draw_lines;
use lobe_image::{Label, Picture};

const BLACK: Rgb<f32> = Rgb::new(0.0, 0.0, 0.0);

/// The coverage of an edge between two faces: enough to see the cube, less than a line of the function.
const EDGE_COVERAGE: f64 = 0.3;
/// The height of the name of a face, as a part of its width.
const LABEL_HEIGHT: f64 = 0.13;

/// A picture of a function on the unfolded cube, four faces wide and three high.
///
/// ```text
///            +----+
///            | +z |                   The cube is seen from inside: +z upwards,
///       +----+----+----+----+         to the right of +x comes -y, as in a
///       | +y | +x | -y | -x |         lat-long picture.
///       +----+----+----+----+
///            | -z |
///            +----+
/// ```
///
/// Positive values are red, negative ones blue; lines join equal values, the green one is zero.
#[derive(Clone, Copy, Debug)]
pub struct CubeCross {
    /// Pixels along the edge of a face.
    pub face: usize,
    /// The value that is painted in full red, its negative in full blue; `None`: the largest magnitude that occurs.
    pub full_scale: Option<f64>,
    /// The number of lines between zero and full scale. The last lies half a step below, so that it does not only
    /// touch the top of the function.
    pub levels: usize,
    /// Whether the faces carry the names of their axes.
    pub labels: bool,
    /// The color around the cross.
    pub background: Rgb<f32>,
}

impl CubeCross {
    /// A cross on white, with labels, ten lines from zero to the largest magnitude.
    #[must_use]
    pub fn new(face: usize) -> Self {
        Self { face, full_scale: None, levels: 10, labels: true, background: Rgb::new(1.0, 1.0, 1.0) }
    }

    /// Paints `f`. Where it is not finite it is black (NaN) or of the end colors, without lines. Faces without pixels
    /// give an empty picture; a full scale that is not positive, no colors and no lines.
    #[must_use]
    pub fn picture(&self, f: impl Fn(Dir) -> f64 + Sync) -> Picture {
        self.painted(&f)
    }

    fn painted(&self, f: &(dyn Fn(Dir) -> f64 + Sync)) -> Picture {
        if self.face == 0 {
            return Picture::filled(0, 0, self.background);
        }
        // Sample the function at the pixel centers of every face.
        let values = FACES.map(|face| self.values(&face, f));
        let largest = values.iter().flatten().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
        // Choose the scale of the colors and the step of the lines.
        let full_scale = self.full_scale.unwrap_or(largest);
        let lines = IsoLines { step: full_scale / (self.levels as f64 + 0.5), width: 1.0, zero_width: 2.2 };
        // Paint the faces and put them in their places.
        let mut picture = Picture::filled(4 * self.face, 3 * self.face, self.background);
        for (face, values) in FACES.iter().zip(&values) {
            let tile = self.tile(values, &lines, full_scale);
            picture.paste(&tile, (face.column * self.face) as isize, (face.row * self.face) as isize);
        }
        // Draw the edges of the cube and the names of the axes.
        self.draw_edges(&mut picture);
        if self.labels {
            self.draw_labels(&mut picture);
        }
        picture
    }

    /// The values at the pixel centers of a face and of a border of one pixel around it, `face + 2` a row.
    fn values(&self, face: &Face, f: &(dyn Fn(Dir) -> f64 + Sync)) -> Vec<f64> {
        let at = |k: usize| (2.0 * k as f64 - 1.0) / self.face as f64 - 1.0;
        let stride = self.face + 2;
        let mut values = vec![0.0; stride * stride];
        parallel::fill(&mut values, stride, &|i| f(face.dir(at(i % stride), -at(i / stride))));
        values
    }

    fn tile(&self, values: &[f64], lines: &IsoLines, full_scale: f64) -> Picture {
        let stride = self.face + 2;
        Picture::from_fn(self.face, self.face, |x, y| {
            let i = (y + 1) * stride + x + 1;
            let gradient = [0.5 * (values[i + 1] - values[i - 1]), 0.5 * (values[i + stride] - values[i - stride])];
            lines.color(values[i], gradient, full_scale)
        })
    }

    /// Darkens the first column and the first row of every face that continues another.
    fn draw_edges(&self, picture: &mut Picture) {
        let n = self.face;
        for face in FACES {
            let (left, top) = (face.column * n, face.row * n);
            let occupied = |column: usize, row: usize| FACES.iter().any(|f| (f.column, f.row) == (column, row));
            for k in 0..n {
                if left > 0 && occupied(face.column - 1, face.row) {
                    picture.blend(left as isize, (top + k) as isize, BLACK, EDGE_COVERAGE);
                }
                if top > 0 && occupied(face.column, face.row - 1) {
                    picture.blend((left + k) as isize, top as isize, BLACK, EDGE_COVERAGE);
                }
            }
        }
    }

    /// Puts the name of its axis into the corner of every face.
    fn draw_labels(&self, picture: &mut Picture) {
        let n = self.face as f64;
        let height = (LABEL_HEIGHT * n).max(9.0);
        for face in FACES {
            let (left, top) = (face.column as f64 * n + 0.05 * n, face.row as f64 * n + 0.04 * n);
            let label = Label { left, top, height, color: BLACK.into() };
            shade_box(picture, left - 0.02 * n, top - 0.02 * n, label.width(face.name) + 0.04 * n, height + 0.04 * n);
            label.draw(picture, face.name);
        }
    }

    /// An empty cross with the names of the axes in the middle of the faces: the key to crosses without labels.
    #[must_use]
    pub fn key(&self) -> Picture {
        let n = self.face as f64;
        let mut picture = Picture::filled(4 * self.face, 3 * self.face, self.background);
        let height = (2.0 * LABEL_HEIGHT * n).max(9.0);
        for face in FACES {
            let (left, top) = (face.column as f64 * n, face.row as f64 * n);
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[a, b]| {
                // On pixel centers and inside the picture, so that every line is one sharp pixel wide.
                [(left + a * n + 0.5).min(4.0 * n - 0.5), (top + b * n + 0.5).min(3.0 * n - 0.5)]
            });
            let sides = [0, 1, 2, 3].map(|k| [corners[k], corners[(k + 1) % 4]]);
            draw_lines(&mut picture, &sides, 1.0, BLACK);
            let label = Label { left: 0.0, top: top + 0.5 * (n - height), height, color: BLACK.into() };
            Label { left: left + 0.5 * (n - label.width(face.name)), ..label }.draw(&mut picture, face.name);
        }
        picture
    }
}

/// Lightens a rectangle, so that text on it can be read.
fn shade_box(picture: &mut Picture, left: f64, top: f64, width: f64, height: f64) {
    for y in top.round() as isize..(top + height).round() as isize {
        for x in left.round() as isize..(left + width).round() as isize {
            picture.blend(x, y, Rgb::new(1.0, 1.0, 1.0), 0.6);
        }
    }
}

/// The direction at `(u, v)` on the unfolded cube, in faces from the top left, `u` in `[0, 4]`, `v` in `[0, 3]`;
/// `None` beside the cross.
#[must_use]
pub fn dir_on_cross(u: f64, v: f64) -> Option<Dir> {
    FACES.iter().find_map(|face| {
        let (a, b) = (2.0 * (u - face.column as f64) - 1.0, 1.0 - 2.0 * (v - face.row as f64));
        (a.abs() <= 1.0 && b.abs() <= 1.0).then(|| face.dir(a, b))
    })
}

#[cfg(test)]
mod tests {

    use super::*;

    fn plain(face: usize) -> CubeCross {
        CubeCross { labels: false, ..CubeCross::new(face) }
    }

    #[test]
    fn the_axes_lie_in_the_middle_of_their_faces() {
        let expected = [
            ((1.5, 0.5), Dir::Z),
            ((0.5, 1.5), Dir::Y),
            ((1.5, 1.5), Dir::X),
            ((2.5, 1.5), -Dir::Y),
            ((3.5, 1.5), -Dir::X),
            ((1.5, 2.5), -Dir::Z),
        ];
        for ((u, v), axis) in expected {
            assert_eq!(dir_on_cross(u, v), Some(axis), "at ({u}, {v})");
        }
        for (u, v) in [(0.5, 0.5), (2.5, 0.5), (3.5, 2.5), (0.2, 2.9)] {
            assert_eq!(dir_on_cross(u, v), None, "beside the cross, at ({u}, {v})");
        }
    }

    #[test]
    fn positive_is_red_negative_is_blue_and_zero_is_green() {
        let n = 40;
        let picture = plain(n).picture(Dir::z);
        let (top, bottom) = (picture.pixel(n + 20, 20), picture.pixel(n + 20, 2 * n + 20));
        assert!(top[0] > 3.0 * top[2] && bottom[2] > 3.0 * bottom[0], "+z {top:?}, -z {bottom:?}");
        for column in 0..4 {
            let middle = picture.pixel(column * n + 11, n + 20);
            assert!(
                middle[1] > 2.0 * middle[0] && middle[1] > 2.0 * middle[2],
                "the horizon, face {column}: {middle:?}"
            );
        }
    }

    #[test]
    fn the_picture_continues_across_the_folds() {
        let n = 64;
        // No function of the basis is special; this one is smooth and has no symmetry.
        let f = |s: Dir| (1.3 * s.x() - 0.4 * s.y() + 0.2).sin() + 0.7 * s.y() * s.z() + 0.3 * s.z();
        let cross = plain(n);
        let values = FACES.map(|face| cross.values(&face, &f));
        let value = |face: usize, x: usize, y: usize| values[face][(y + 1) * (n + 2) + x + 1];
        let largest_step = 3.0 * 2.0 / n as f64;
        for k in 0..n {
            let pairs = [
                (value(1, n - 1, k), value(2, 0, k)),
                (value(2, n - 1, k), value(3, 0, k)),
                (value(3, n - 1, k), value(4, 0, k)),
                (value(0, k, n - 1), value(2, k, 0)),
                (value(2, k, n - 1), value(5, k, 0)),
            ];
            for (fold, (a, b)) in pairs.into_iter().enumerate() {
                assert!((a - b).abs() < largest_step, "fold {fold}, pixel {k}: {a} beside {b}");
            }
        }
    }

    #[test]
    fn what_cannot_be_scaled_is_painted_all_the_same() {
        assert!(plain(0).picture(Dir::z).pixels().is_empty(), "no pixels");
        assert!(CubeCross::new(0).key().pixels().is_empty(), "no pixels in the key");
        for scale in [0.0, -1.0, f64::NAN] {
            let picture = CubeCross { full_scale: Some(scale), ..plain(8) }.picture(Dir::z);
            for (x, y) in [(12, 4), (4, 12), (12, 12), (12, 15), (28, 12), (12, 20)] {
                assert_eq!(picture.pixel(x, y), [1.0; 3], "full scale {scale} at ({x}, {y})");
            }
        }
        let holes = plain(32).picture(|s| if s.x() > 0.9 { f64::INFINITY } else { s.z() });
        assert!(holes.pixels().iter().all(|c| c[1].is_finite()), "every color is a number");
        let (inside, outside) = (holes.pixel(48, 48), holes.pixel(48, 2));
        assert_eq!(inside, lobe_image::diverging(1.0), "infinity is full red");
        assert!(outside[0] > outside[2], "the rest keeps its scale: {outside:?}");
    }

    #[test]
    fn a_zero_function_is_white() {
        let picture = plain(8).picture(|_| 0.0);
        assert_eq!(picture.pixel(12, 12), [1.0, 1.0, 1.0], "no line, no color");
    }
}
