//! Polar plots of cross-sections of functions on the sphere.

use std::f64::consts::TAU;

use lobe_sh::Dir;

use crate::plot::drawing::{Anchor, Drawing, Srgb, nice_step};
use lobe_image::Picture;

const POSITIVE: Srgb = [200, 30, 30];
const NEGATIVE: Srgb = [30, 60, 200];
const BESIDE: Srgb = [90, 90, 90];
const GRID: Srgb = [221, 221, 221];
const AXIS: Srgb = [150, 150, 150];
const TEXT: Srgb = [68, 68, 68];

/// Points around the circle: one for every half degree, so that no lobe of order 64 has a corner.
const POINTS: usize = 720;
/// The part of half the figure that the extent fills; the rest is for the names of the axes.
const FILL: f64 = 0.88;
/// Rings between the middle and the extent, at most.
const MOST_RINGS: f64 = 5.0;
/// The font size as a part of the figure's.
const FONT: f64 = 0.032;
/// A dash and the gap behind it, as parts of the figure's size.
const DASHES: [f64; 2] = [0.016, 0.012];

/// The plane of a cross-section, by the two axes of the figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossSection {
    /// The direction to the right.
    pub right: Dir,
    /// The direction upwards, perpendicular to `right`.
    pub up: Dir,
}

impl CrossSection {
    /// +x to the right, +z upwards: the plane in which a function of the zenith angle shows.
    pub const XZ: Self = Self { right: Dir::X, up: Dir::Z };
    /// +y to the right, +z upwards.
    pub const YZ: Self = Self { right: Dir::Y, up: Dir::Z };
    /// +x to the right, +y upwards: as seen from above.
    pub const XY: Self = Self { right: Dir::X, up: Dir::Y };

    /// `cos t right + sin t up`.
    #[must_use]
    pub fn dir(&self, t: f64) -> Dir {
        let (sin, cos) = t.sin_cos();
        let (r, u) = (self.right.to_array(), self.up.to_array());
        Dir::new([0, 1, 2].map(|k| cos * r[k] + sin * u[k])).unwrap_or(self.right)
    }
}

/// A polar plot of a cross-section: the distance from the middle is `|f|`, red where `f` is positive and blue where it
/// is negative; beside it, dashed, other functions, such as the truth that `f` stands for.
///
/// ```
/// use lobe_figures::{CrossSection, PolarPlot};
/// use lobe_sh::Zonal;
///
/// // The cosine at order 3 beside the cosine itself.
/// let kernel = Zonal::clamped_cosine(3);
/// let approximation = |s: lobe_sh::Dir| kernel.eval(s.z());
/// let svg = PolarPlot::new(400.0, CrossSection::XZ).svg(&approximation, &[&|s: lobe_sh::Dir| s.z().max(0.0)]);
/// assert!(svg.contains("stroke-dasharray"));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PolarPlot {
    /// The width and the height in pixels.
    pub size: f64,
    /// The plane.
    pub section: CrossSection,
    /// The value on the outermost ring; `None`: the largest magnitude that occurs.
    pub extent: Option<f64>,
}

impl PolarPlot {
    /// A plot that shows the largest magnitude.
    #[must_use]
    pub fn new(size: f64, section: CrossSection) -> Self {
        Self { size, section, extent: None }
    }

    /// The plot as a complete SVG document. Values that are not finite leave a gap; where all are zero, there are only
    /// the axes.
    #[must_use]
    pub fn svg(&self, f: &dyn Fn(Dir) -> f64, beside: &[&dyn Fn(Dir) -> f64]) -> String {
        self.drawing(f, beside).svg()
    }

    /// The plot as a picture.
    #[must_use]
    pub fn picture(&self, f: &dyn Fn(Dir) -> f64, beside: &[&dyn Fn(Dir) -> f64]) -> Picture {
        self.drawing(f, beside).picture()
    }

    fn drawing(&self, f: &dyn Fn(Dir) -> f64, beside: &[&dyn Fn(Dir) -> f64]) -> Drawing {
        // Sample all functions along the great circle.
        let values = self.values(f);
        let others: Vec<Vec<f64>> = beside.iter().map(|f| self.values(*f)).collect();
        // Choose the value of the outermost ring.
        let all = others.iter().chain([&values]).flatten().filter(|v| v.is_finite());
        let largest = all.fold(0.0, |m: f64, v| m.max(v.abs()));
        let extent = self.extent.unwrap_or(if largest > 0.0 { largest } else { 1.0 });
        // Draw the rings, the axes and their numbers.
        let mut drawing = Drawing::new(self.size, self.size);
        let all: Vec<&[f64]> = others.iter().chain([&values]).map(Vec::as_slice).collect();
        self.draw_grid(&mut drawing, extent, &all);
        // Draw the other functions, dashed.
        let width = 0.006 * self.size;
        for values in &others {
            let dashes = DASHES.map(|d| d * self.size);
            drawing.line(&self.curve(values, extent, |_| true), BESIDE, 0.7 * width, Some(dashes));
        }
        // Draw the negative parts, then the positive ones: where both touch the middle, red lies on top.
        drawing.line(&self.curve(&values, extent, |v| v <= 0.0), NEGATIVE, width, None);
        drawing.line(&self.curve(&values, extent, |v| v >= 0.0), POSITIVE, width, None);
        drawing
    }

    fn values(&self, f: &dyn Fn(Dir) -> f64) -> Vec<f64> {
        (0..POINTS).map(|i| f(self.section.dir(angle(i)))).collect()
    }

    /// The closed curve of the magnitudes of the values that satisfy `is_wanted`; between two of different sign it
    /// passes through the middle.
    fn curve(&self, values: &[f64], extent: f64, is_wanted: impl Fn(f64) -> bool) -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        for i in 0..=POINTS {
            let (v, before) = (values[i % POINTS], values[(i + POINTS - 1) % POINTS]);
            if i > 0 && is_wanted(v) != is_wanted(before) {
                let zero = angle(i) - TAU / POINTS as f64 * v / (v - before);
                points.push(self.place(0.0, zero));
            }
            points.push(if is_wanted(v) { self.place(v.abs() / extent, angle(i)) } else { [f64::NAN; 2] });
        }
        points
    }

    /// The point at the distance `r`, in extents, in the direction of angle `t`.
    fn place(&self, r: f64, t: f64) -> [f64; 2] {
        let middle = 0.5 * self.size;
        let (sin, cos) = t.sin_cos();
        [middle + FILL * middle * r * cos, middle - FILL * middle * r * sin]
    }

    /// The angle at which the numbers of the rings stand in the way of the fewest points of all curves: on no axis, and
    /// of several the one next to the right, where functions of a direction along an axis are seldom largest.
    fn angle_of_numbers(&self, extent: f64, step: f64, all: &[&[f64]]) -> f64 {
        let near = 0.9 * FONT * self.size;
        let crossed = |sixteenth: &usize| {
            let t = *sixteenth as f64 * TAU / 16.0;
            let rings = 1..=(extent / step + 1e-9).floor() as usize;
            let numbers: Vec<[f64; 2]> = rings.map(|k| self.place(k as f64 * step / extent, t)).collect();
            let points = all.iter().flat_map(|values| values.iter().enumerate()).filter(|(_, v)| v.is_finite());
            points
                .map(|(i, v)| self.place(v.abs() / extent, angle(i)))
                .filter(|p| numbers.iter().any(|n| (p[0] - n[0]).hypot(p[1] - n[1]) < near))
                .count()
        };
        // The eight between the axes, from the right up and down to the left.
        let sixteenth = [1, 15, 7, 9, 3, 13, 5, 11].into_iter().min_by_key(crossed).unwrap_or(1);
        sixteenth as f64 * TAU / 16.0
    }

    fn draw_grid(&self, drawing: &mut Drawing, extent: f64, all: &[&[f64]]) {
        let step = nice_step(extent / MOST_RINGS);
        let font = FONT * self.size;
        let digits = (-step.log10().floor()).max(0.0) as usize;
        // Draw the rings with their numbers.
        let turn = self.angle_of_numbers(extent, step, all);
        for k in 1..=(extent / step + 1e-9).floor() as usize {
            let r = k as f64 * step / extent;
            let ring: Vec<[f64; 2]> = (0..=POINTS / 4).map(|i| self.place(r, angle(4 * i))).collect();
            drawing.line(&ring, GRID, 1.0, None);
            let [x, y] = self.place(r, turn);
            let value = k as f64 * step;
            let text = if step >= 1e5 { format!("{value:e}") } else { format!("{value:.digits$}") };
            drawing.text([x, y], Anchor::Middle, 0.8 * font, TEXT, &text);
        }
        // Draw the axes with their names.
        let CrossSection { right, up } = self.section;
        for (axis, turn) in [(right, 0.0), (up, 0.25), (-right, 0.5), (-up, 0.75)] {
            drawing.line(&[self.place(0.0, 0.0), self.place(1.0, turn * TAU)], AXIS, 1.0, None);
            let [x, y] = self.place(1.06, turn * TAU);
            drawing.text([x, y + 0.36 * font], Anchor::Middle, font, TEXT, &name(axis));
        }
    }
}

/// The angle of point `i`.
fn angle(i: usize) -> f64 {
    i as f64 * TAU / POINTS as f64
}

/// The name of a coordinate axis; nothing for another direction.
fn name(axis: Dir) -> String {
    let named = axis.to_array().into_iter().zip(["x", "y", "z"]).find(|(c, _)| c.abs() > 1.0 - 1e-12);
    named.map_or(String::new(), |(c, letter)| format!("{}{letter}", if c > 0.0 { '+' } else { '-' }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: PolarPlot = PolarPlot { size: 200.0, section: CrossSection::XZ, extent: Some(1.0) };

    fn is_red(picture: &Picture, x: f64, y: f64) -> bool {
        near(picture, x, y, |c| c[0] > 1.5 * c[2])
    }

    fn is_blue(picture: &Picture, x: f64, y: f64) -> bool {
        near(picture, x, y, |c| c[2] > 1.5 * c[0])
    }

    /// Whether a pixel within one and a half of a place satisfies a condition.
    fn near(picture: &Picture, x: f64, y: f64, is: impl Fn([f32; 3]) -> bool) -> bool {
        let around = |c: f64| (c - 1.5).round() as usize..=(c + 0.5).round() as usize;
        around(x).any(|x| around(y).any(|y| is(picture.pixel(x, y))))
    }

    #[test]
    fn a_cosine_is_a_red_circle_above_and_a_blue_one_below() {
        let picture = PLOT.picture(&|s| s.z(), &[]);
        let reach = FILL * 100.0;
        assert!(is_red(&picture, 100.0, 100.0 - reach), "the top is red");
        assert!(is_blue(&picture, 100.0, 100.0 + reach), "the bottom is blue");
        // |cos| in polar coordinates is a circle through the middle, half as high as the extent.
        let (x, y) = (100.0 + 0.5 * reach, 100.0 - 0.5 * reach);
        assert!(is_red(&picture, x, y) && !is_red(&picture, 100.0 + 0.8 * reach, y), "the side of the upper circle");
    }

    #[test]
    fn the_plane_decides_which_way_the_figure_lies() {
        let seen = |section| PolarPlot { section, ..PLOT }.picture(&|s| s.y(), &[]);
        let reach = FILL * 100.0;
        assert!(is_red(&seen(CrossSection::YZ), 100.0 + reach, 100.0), "+y to the right");
        assert!(is_red(&seen(CrossSection::XY), 100.0, 100.0 - reach), "+y upwards");
        let nothing = seen(CrossSection::XZ);
        assert!(!is_red(&nothing, 100.0 + reach, 100.0) && !is_blue(&nothing, 100.0 - reach, 100.0), "y = 0");
    }

    #[test]
    fn the_function_beside_is_dashed() {
        let svg = PLOT.svg(&|s| s.z(), &[&|s: Dir| s.z().max(0.0)]);
        assert_eq!(svg.matches("stroke-dasharray").count(), 1, "{svg}");
        for text in ["+x", "-x", "+z", "-z", "0.2"] {
            assert!(svg.contains(&format!(">{text}<")), "{text} is missing");
        }
    }

    #[test]
    fn the_numbers_of_the_rings_stand_clear_of_the_curve() {
        let place = |f: &dyn Fn(Dir) -> f64| {
            let svg = PLOT.svg(f, &[]);
            let (before, _) = svg.split_once(">0.6<").unwrap();
            let tag = &before[before.rfind("<text").unwrap()..];
            ["x=\"", "y=\""].map(|key| {
                let (_, rest) = tag.split_once(key).unwrap();
                rest.split('"').next().unwrap().parse::<f64>().unwrap()
            })
        };
        let [x, y] = place(&|s| s.z().powi(8));
        assert!(x > 140.0 && y < 90.0, "right of a function that looks up: {x} {y}");
        let right = Dir::from_angles(3.0 * TAU / 16.0, 0.0);
        let [x, y] = place(&|s| if s.dot(right) > 0.9 { 0.6 } else { 0.0 });
        assert!(x < 100.0 || y > 100.0, "elsewhere if the function is there: {x} {y}");
    }

    #[test]
    fn zero_and_values_that_are_not_finite_leave_gaps() {
        let zero = PolarPlot::new(100.0, CrossSection::XY).svg(&|_| 0.0, &[]);
        assert!(!zero.contains("NaN") && zero.contains("+y"), "{zero}");
        let holes = PLOT.svg(&|s| if s.z() > 0.5 { f64::NAN } else { 1.0 }, &[]);
        assert!(!holes.contains("NaN") && !holes.contains("inf"), "{holes}");
    }
}
