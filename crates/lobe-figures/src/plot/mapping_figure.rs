//! Figures of mappings: the unfolded sphere with its graticule and axes.

use lobe_env::Mapping;
use lobe_sh::{Coefficient, Dir, Rgb};

use lobe_image::{Label, Picture, srgb_decode};

/// The angle between neighboring parallels and meridians, in degrees.
const GRID: f64 = 15.0;
/// Samples along each side of a pixel.
const SAMPLES: usize = 3;
/// The faces of a cube that lie beside each other.
const FACES_ABREAST: usize = 3;
/// The gray where a mapping shows nothing, as sRGB.
const NOTHING: f64 = 0.62;
/// The part of a pixel's color that a line of the grid leaves.
const LINE: f32 = 0.35;

/// The figure of a mapping, `width` pixels wide: where every direction lies in its picture. Show it with
/// [`Tone::PLAIN`](lobe_image::Tone::PLAIN).
///
/// Fields of 15° between parallels and meridians have the color of the direction in their middle; where the mapping
/// shows nothing it is gray; names stand where the six axes are. The cube, six times as high as wide, is laid in two
/// rows of three faces, in its order from the upper left.
///
/// ```text
///   sRGB = 0.62 + 0.36 s        +x red, -x cyan, +y green, -y magenta, +z blue, -z yellow
/// ```
#[must_use]
pub fn mapping_figure(mapping: Mapping, width: usize) -> Picture {
    let layout = Layout { mapping, width, height: layout_height(mapping, width) };
    let mut picture = Picture::from_fn(width, layout.height, |x, y| layout.pixel(x, y));
    let height = (0.05 * width as f64).clamp(9.0, 16.0);
    for (name, place) in layout.axes() {
        // The whole name stays inside the picture.
        let label = Label { left: 0.0, top: 0.0, height, color: [0.0; 3] };
        let inside = |at: f64, length: f64, end: usize| (at - 0.5 * length).clamp(2.0, end as f64 - length - 2.0);
        let (left, top) = (inside(place[0], label.width(name), width), inside(place[1], height, layout.height));
        Label { left, top, ..label }.draw(&mut picture, name);
    }
    picture
}

fn layout_height(mapping: Mapping, width: usize) -> usize {
    if mapping.faces() == 1 {
        return mapping.height_for(width);
    }
    let [columns, rows] = faces_of(mapping);
    (rows * width).div_ceil(columns)
}

/// Columns and rows of faces on the paper.
fn faces_of(mapping: Mapping) -> [usize; 2] {
    let columns = mapping.faces().min(FACES_ABREAST);
    [columns, mapping.faces().div_ceil(columns)]
}

/// A mapping on the paper.
struct Layout {
    mapping: Mapping,
    width: usize,
    height: usize,
}

impl Layout {
    /// The direction at a point of the paper.
    fn dir(&self, x: f64, y: f64) -> Option<Dir> {
        let (u, v) = (x / self.width as f64, y / self.height as f64);
        if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
            return None;
        }
        let [columns, rows] = faces_of(self.mapping).map(|count| count as f64);
        let (column, row) = ((columns * u).floor(), (rows * v).floor());
        let (s, t, face) = (columns * u - column, rows * v - row, columns * row + column);
        self.mapping.dir_from_uv(s, (face + t) / self.mapping.faces() as f64)
    }

    /// The point of the paper in a direction.
    fn place(&self, s: Dir) -> [f64; 2] {
        let (u, v) = self.mapping.uv_from_dir(s);
        let [columns, rows] = faces_of(self.mapping).map(|count| count as f64);
        let down = self.mapping.faces() as f64 * v;
        let face = down.floor().min((self.mapping.faces() - 1) as f64);
        let (column, row) = (face % columns, (face / columns).floor());
        [(column + u) / columns * self.width as f64, (row + down - face) / rows * self.height as f64]
    }

    /// The mean of the samples of a pixel; those on a line are darker.
    fn pixel(&self, x: usize, y: usize) -> Rgb<f32> {
        let mut sum = Rgb::<f32>::ZERO;
        for k in 0..SAMPLES * SAMPLES {
            let offset = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
            sum += self.sample(x as f64 + offset(k % SAMPLES), y as f64 + offset(k / SAMPLES));
        }
        sum.scale(1.0 / (SAMPLES * SAMPLES) as f32)
    }

    /// A point lies on a line if the field half a pixel further right or down, or left or up, is another.
    fn sample(&self, x: f64, y: f64) -> Rgb<f32> {
        let at = |dx: f64, dy: f64| self.dir(x + dx, y + dy).map(Field::of);
        let Some(field) = at(0.0, 0.0) else { return Rgb::splat(srgb_decode(NOTHING) as f32) };
        let near = [(0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5)];
        let on_line = near.iter().any(|&(dx, dy)| at(dx, dy).is_some_and(|other| other != field));
        if on_line { field.color().scale(LINE) } else { field.color() }
    }

    /// The names of the axes and where they stand: once each, and again where an axis is at both ends of the picture.
    fn axes(&self) -> Vec<(&'static str, [f64; 2])> {
        let (w, h) = (self.width as f64, self.height as f64);
        let axes = [("+x", Dir::X), ("-x", -Dir::X), ("+y", Dir::Y), ("-y", -Dir::Y), ("+z", Dir::Z), ("-z", -Dir::Z)];
        let mut all: Vec<_> = axes.map(|(name, s)| (name, self.place(s))).into();
        let again = self.mapping.axes_again().iter();
        all.extend(again.map(|&(name, [u, v])| (name, [u * w, v * h])));
        all
    }
}

/// A field between two parallels and two meridians, in units of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Field {
    parallel: f64,
    meridian: f64,
}

impl Field {
    fn of(s: Dir) -> Self {
        let grid = GRID.to_radians();
        let last = (std::f64::consts::PI / grid).round() - 1.0;
        let meridian = (s.phi() / grid).floor().rem_euclid(2.0 * (last + 1.0));
        Self { parallel: (s.theta() / grid).floor().min(last), meridian }
    }

    /// The light color of the direction in the middle of the field.
    fn color(self) -> Rgb<f32> {
        let grid = GRID.to_radians();
        let middle = Dir::from_angles((self.parallel + 0.5) * grid, (self.meridian + 0.5) * grid);
        Rgb::from(middle.to_array().map(|c| srgb_decode(0.62 + 0.36 * c) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colors_of_a_figure_are_those_of_the_directions() {
        for mapping in Mapping::ALL {
            let layout = Layout { mapping, width: 120, height: layout_height(mapping, 120) };
            let mut shown = 0;
            for y in 0..layout.height {
                for x in 0..120 {
                    let Some(s) = layout.dir(x as f64 + 0.5, y as f64 + 0.5) else { continue };
                    let [u, v] = layout.place(s);
                    let off = (u - x as f64 - 0.5).hypot(v - y as f64 - 0.5);
                    // On a seam a direction has two places; pixel centers do not lie on one.
                    assert!(off < 1e-6, "{mapping}: pixel ({x}, {y}) shows {s:?}, which lies at ({u}, {v})");
                    shown += 1;
                }
            }
            assert!(shown > 5000, "{mapping} shows the sphere in {shown} pixels");
        }
    }

    #[test]
    fn the_axes_have_their_colors() {
        // Beside the name of the axis, in the same field or one of its neighbors.
        for (s, channel, bright) in [
            (Dir::X, 0, true),
            (-Dir::X, 0, false),
            (Dir::Y, 1, true),
            (-Dir::Y, 1, false),
            (Dir::Z, 2, true),
            (-Dir::Z, 2, false),
        ] {
            let color = Field::of(s).color();
            let others = (0..3).filter(|c| *c != channel).map(|c| color.channel(c));
            let (own, other) = (color.channel(channel), others.fold(0.0, f32::max));
            assert_eq!(own > other, bright, "{s:?}: {color:?}");
        }
    }
}
