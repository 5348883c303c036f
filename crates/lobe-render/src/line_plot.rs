//! Functions of one number as a plot.

use crate::Picture;
use crate::drawing::{Anchor, Drawing, nice_step};

/// Room for the numbers on the left, and below and around the plot.
const LEFT: f64 = 52.0;
const BELOW: f64 = 34.0;
const AROUND: f64 = 14.0;
/// Grid lines across the range of the values, at most.
const MOST_STEPS: f64 = 8.0;
/// The room for a text of the legend, its line in front of it, and from one text to the next.
const LEGEND: [f64; 3] = [150.0, 22.0, 18.0];
const FONT: f64 = 12.0;
const CURVE_WIDTH: f64 = 2.0;
/// A dash and the gap behind it.
const DASHES: [f64; 2] = [6.0, 4.0];

const TEXT: [u8; 3] = [68, 68, 68];
const GRID: [u8; 3] = [221, 221, 221];

/// A line of a plot.
#[derive(Clone, Debug)]
pub struct Curve2d<'a> {
    /// What the legend calls it; nothing for a line that is not in the legend.
    pub label: &'a str,
    /// Its colour in sRGB.
    pub colour: [u8; 3],
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
    /// What stands behind its numbers, such as `°`.
    pub unit: &'a str,
}

impl LinePlot<'_> {
    /// The plot as a complete SVG document.
    #[must_use]
    pub fn svg(&self, curves: &[Curve2d<'_>]) -> String {
        self.drawing(curves).svg()
    }

    /// The plot as a picture. Of the legend it has the lines only: [`Label`](crate::Label) has few letters.
    #[must_use]
    pub fn picture(&self, curves: &[Curve2d<'_>]) -> Picture {
        self.drawing(curves).picture()
    }

    fn drawing(&self, curves: &[Curve2d<'_>]) -> Drawing {
        let (low, high) = range(curves);
        let step = nice_step((high - low) / MOST_STEPS);
        let (bottom, top) = ((low / step).floor() * step, (high / step).ceil() * step);
        let [start, end] = self.ends;
        let x = |x: f64| LEFT + (self.width - LEFT - AROUND) * (x - start) / (end - start);
        let y = |y: f64| AROUND + (self.height - BELOW - AROUND) * (top - y) / (top - bottom);

        let mut drawing = Drawing::new(self.width, self.height);
        for k in 0..=((end - start) / self.step + 1e-9) as usize {
            let mark = start + k as f64 * self.step;
            grid_line(&mut drawing, [[x(mark), y(bottom)], [x(mark), y(top)]], mark == 0.0);
            let text = format!("{mark}{}", self.unit);
            drawing.text([x(mark), y(bottom) + 18.0], Anchor::Middle, FONT, TEXT, &text);
        }
        for k in 0..=((top - bottom) / step).round() as usize {
            let v = bottom + k as f64 * step;
            grid_line(&mut drawing, [[x(start), y(v)], [x(end), y(v)]], v.abs() < 1e-9 * step);
            let digits = (-step.log10().floor()).max(0.0) as usize;
            drawing.text([x(start) - 8.0, y(v) + 4.0], Anchor::End, FONT, TEXT, &format!("{v:.digits$}"));
        }
        for curve in curves {
            let points: Vec<[f64; 2]> = curve.points.iter().map(|p| [x(p[0]), y(p[1])]).collect();
            drawing.line(&points, curve.colour, CURVE_WIDTH, curve.dashed.then_some(DASHES));
        }
        self.draw_legend(&mut drawing, curves);
        drawing
    }

    fn draw_legend(&self, drawing: &mut Drawing, curves: &[Curve2d<'_>]) {
        let [room, line, step] = LEGEND;
        for (k, curve) in curves.iter().filter(|curve| !curve.label.is_empty()).enumerate() {
            let (x, y) = (self.width - AROUND - room, AROUND + step * (k + 1) as f64);
            drawing.line(&[[x, y], [x + line, y]], curve.colour, CURVE_WIDTH, curve.dashed.then_some(DASHES));
            drawing.label([x + line + 8.0, y + 4.0], FONT, TEXT, curve.label);
        }
    }
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
        let curve =
            Curve2d { label: "a < b", colour: [255, 0, 0], dashed: true, points: vec![[0.0, 1.0], [6.0, -1.0]] };
        let svg = PLOT.svg(std::slice::from_ref(&curve));
        assert!(svg.contains("M52.00 14.00L466.00 266.00\""), "from the top left to the bottom right: {svg}");
        assert!(svg.contains("a &lt; b"), "the legend is escaped: {svg}");
        assert_eq!(svg.matches("stroke-dasharray").count(), 2, "the curve and its line in the legend: {svg}");
        let picture = PLOT.picture(&[curve]);
        let is_red = |x, y| {
            let c = picture.pixel(x, y);
            c.r > 1.5 * c.g
        };
        assert!((52..58).any(|x| (12..20).any(|y| is_red(x, y))), "the beginning of the line");
    }

    #[test]
    fn nothing_to_plot_is_an_empty_frame() {
        let svg = PLOT.svg(&[]);
        assert!(svg.contains(">6<") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
