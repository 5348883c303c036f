//! Line plots of functions of one variable, with axes and a legend.

use crate::plot::drawing::{Anchor, Drawing, nice_step};
use lobe_image::Picture;

/// Room for the numbers on the left, and below and around the plot.
const LEFT: f64 = 52.0;
const BELOW: f64 = 34.0;
const AROUND: f64 = 14.0;
/// Grid lines across the range of the values, at most.
const MOST_STEPS: f64 = 8.0;
/// The least width of the legend, of the line in front of a text, the gap between them, and from one text to the next.
const LEGEND: [f64; 4] = [142.0, 22.0, 8.0, 18.0];
/// An upper bound of the mean width of a letter, as a part of the font's size.
const LETTER: f64 = 0.6;
/// Points on a line from one point of a curve to the next at which the legend should not lie.
const BETWEEN: usize = 32;
const FONT: f64 = 12.0;
const CURVE_WIDTH: f64 = 2.0;
/// A dash and the gap behind it.
const DASHES: [f64; 2] = [6.0, 4.0];

const TEXT: [u8; 3] = [68, 68, 68];
const GRID: [u8; 3] = [221, 221, 221];

/// A line of a plot.
#[derive(Clone, Debug)]
pub struct Curve2d<'a> {
    /// Its name in the legend; empty for a line that is not in the legend.
    pub label: &'a str,
    /// Its color in sRGB.
    pub color: [u8; 3],
    /// Whether it is dashed.
    pub dashed: bool,
    /// Its points `(x, y)`. Where one is not finite, the line has a gap.
    pub points: Vec<[f64; 2]>,
}

/// A plot of lines over a horizontal axis with marks at equal steps; the vertical axis contains 0 and all values.
#[derive(Clone, Copy, Debug)]
pub struct LinePlot<'a> {
    /// The width of the picture in pixels.
    pub width: f64,
    /// The height of the picture.
    pub height: f64,
    /// The two ends of the horizontal axis.
    pub ends: [f64; 2],
    /// The distance of the marks on it.
    pub step: f64,
    /// The unit behind its numbers, such as `°`.
    pub unit: &'a str,
}

impl LinePlot<'_> {
    /// The plot as a complete SVG document.
    #[must_use]
    pub fn svg(&self, curves: &[Curve2d<'_>]) -> String {
        self.drawing(curves).svg()
    }

    /// The plot as a picture. Of the legend it has the lines only: [`Label`](lobe_image::Label) has few letters.
    #[must_use]
    pub fn picture(&self, curves: &[Curve2d<'_>]) -> Picture {
        self.drawing(curves).picture()
    }

    fn drawing(&self, curves: &[Curve2d<'_>]) -> Drawing {
        // Choose round ends and a round step for the vertical axis.
        let (low, high) = range(curves);
        let step = nice_step((high - low) / MOST_STEPS);
        let (bottom, top) = ((low / step).floor() * step, (high / step).ceil() * step);
        let [start, end] = self.ends;
        let x = |x: f64| LEFT + (self.width - LEFT - AROUND) * (x - start) / (end - start);
        let y = |y: f64| AROUND + (self.height - BELOW - AROUND) * (top - y) / (top - bottom);

        let mut drawing = Drawing::new(self.width, self.height);
        // Draw the vertical grid lines with their numbers.
        for k in 0..=((end - start) / self.step + 1e-9) as usize {
            let mark = start + k as f64 * self.step;
            grid_line(&mut drawing, [[x(mark), y(bottom)], [x(mark), y(top)]], mark == 0.0);
            let text = format!("{mark}{}", self.unit);
            drawing.text([x(mark), y(bottom) + 18.0], Anchor::Middle, FONT, TEXT, &text);
        }
        // Draw the horizontal ones.
        for k in 0..=((top - bottom) / step).round() as usize {
            let v = bottom + k as f64 * step;
            grid_line(&mut drawing, [[x(start), y(v)], [x(end), y(v)]], v.abs() < 1e-9 * step);
            let digits = (-step.log10().floor()).max(0.0) as usize;
            drawing.text([x(start) - 8.0, y(v) + 4.0], Anchor::End, FONT, TEXT, &format!("{v:.digits$}"));
        }
        // Draw the curves.
        for curve in curves {
            let points: Vec<[f64; 2]> = curve.points.iter().map(|p| [x(p[0]), y(p[1])]).collect();
            drawing.line(&points, curve.color, CURVE_WIDTH, curve.dashed.then_some(DASHES));
        }
        // Draw the legend where it covers least of them.
        let to_picture = |p: &[f64; 2]| [x(p[0]), y(p[1])];
        let lines: Vec<Vec<[f64; 2]>> = curves.iter().map(|c| c.points.iter().map(to_picture).collect()).collect();
        self.draw_legend(&mut drawing, curves, &lines);
        drawing
    }

    /// The legend, in the corner where least of the curves is, the upper right one if there are several.
    fn draw_legend(&self, drawing: &mut Drawing, curves: &[Curve2d<'_>], lines: &[Vec<[f64; 2]>]) {
        let [least, line, gap, step] = LEGEND;
        let named: Vec<&Curve2d<'_>> = curves.iter().filter(|curve| !curve.label.is_empty()).collect();
        let longest = named.iter().map(|curve| curve.label.chars().count()).max().unwrap_or(0);
        let width = least.max(line + gap + LETTER * FONT * longest as f64);
        let height = step * named.len() as f64;
        let [left, right] = [LEFT + gap, self.width - AROUND - gap - width];
        let [top, bottom] = [AROUND + 0.5 * step, self.height - BELOW - 0.5 * step - height];
        let crossed = |corner: &[f64; 2]| {
            let inside = |p: &[f64; 2]| (0..2).all(|k| p[k] > corner[k] - gap && p[k] < corner[k] + [width, height][k]);
            lines.iter().flat_map(|line| points_along(line)).filter(|p| inside(p)).count()
        };
        let corners = [[right, top], [right, bottom], [left, top], [left, bottom]];
        let [x, y] = corners.into_iter().min_by_key(crossed).unwrap_or([right, top]);
        for (k, curve) in named.into_iter().enumerate() {
            let y = y + step * (k as f64 + 0.5);
            drawing.line(&[[x, y], [x + line, y]], curve.color, CURVE_WIDTH, curve.dashed.then_some(DASHES));
            drawing.label([x + line + gap, y + 4.0], FONT, TEXT, curve.label);
        }
    }
}

/// Points on a line, also between those that it is given by.
fn points_along(line: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> + '_ {
    line.windows(2).flat_map(|pair| {
        let at = |k: usize, t: f64| pair[0][k] + t * (pair[1][k] - pair[0][k]);
        (0..BETWEEN).map(move |i| i as f64 / BETWEEN as f64).map(move |t| [at(0, t), at(1, t)])
    })
}

/// The smallest and the largest value, zero included; `(0, 1)` if there is nothing else.
fn range(curves: &[Curve2d<'_>]) -> (f64, f64) {
    let finite = curves.iter().flat_map(|curve| &curve.points).map(|p| p[1]).filter(|v| v.is_finite());
    let (low, high) = finite.fold((0.0_f64, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if low < high { (low, high) } else { (0.0, 1.0) }
}

fn grid_line(drawing: &mut Drawing, ends: [[f64; 2]; 2], is_axis: bool) {
    drawing.line(&ends, if is_axis { TEXT } else { GRID }, 1.0, None);
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: LinePlot<'static> = LinePlot { width: 480.0, height: 300.0, ends: [0.0, 6.0], step: 1.0, unit: "" };

    #[test]
    fn curves_pass_through_their_values() {
        let curve = Curve2d { label: "a < b", color: [255, 0, 0], dashed: true, points: vec![[0.0, 1.0], [6.0, -1.0]] };
        let svg = PLOT.svg(std::slice::from_ref(&curve));
        assert!(svg.contains("M52.00 14.00L466.00 266.00\""), "from the top left to the bottom right: {svg}");
        assert!(svg.contains("a &lt; b"), "the legend is escaped: {svg}");
        assert_eq!(svg.matches("stroke-dasharray").count(), 2, "the curve and its line in the legend: {svg}");
        let picture = PLOT.picture(&[curve]);
        let is_red = |x, y| {
            let c = picture.pixel(x, y);
            c[0] > 1.5 * c[1]
        };
        assert!((52..58).any(|x| (12..20).any(|y| is_red(x, y))), "the beginning of the line");
    }

    #[test]
    fn the_legend_lies_where_no_curve_is_and_inside_the_frame() {
        let label = "a rather long name of it";
        let places = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]].map(|[left, right]| {
            let curve = |label, end| Curve2d {
                label,
                color: [0, 0, 255],
                dashed: false,
                points: vec![[0.0, left], [3.0, end], [6.0, right]],
            };
            let svg = PLOT.svg(&[curve(label, 0.5 * (left + right)), curve("", 0.5 * (left + right))]);
            let (before, _) = svg.split_once(label).unwrap();
            let tag = &before[before.rfind("<text").unwrap()..];
            ["x=\"", "y=\""].map(|key| {
                let (_, rest) = tag.split_once(key).unwrap();
                rest.split('"').next().unwrap().parse::<f64>().unwrap()
            })
        });
        let [falling, below, rising] = places;
        assert!(falling[0] > 240.0 && falling[1] < 150.0, "upper right of a falling line: {falling:?}");
        assert!(below[1] > 150.0 || below[0] < 240.0 || below[1] < 60.0, "clear of what ends at the top: {below:?}");
        assert!(rising[1] > 150.0 || rising[0] < 240.0, "not upper right of a rising line: {rising:?}");
        let end = falling[0] + LETTER * FONT * label.len() as f64;
        assert!(end < 466.0, "it ends at {end}, the frame at 466");
    }

    #[test]
    fn nothing_to_plot_is_an_empty_frame() {
        let svg = PLOT.svg(&[]);
        assert!(svg.contains(">6<") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
