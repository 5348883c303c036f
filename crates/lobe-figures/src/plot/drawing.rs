//! Vector drawings of lines and short texts, written as SVG or rasterized.

use std::fmt::{Arguments, Write};

use lobe_sh::Rgb;

use lobe_image::distance_to_segment;
use lobe_image::srgb_decode;
use lobe_image::{Label, Picture};

/// The height of the digits of a text as a part of its font size, as common fonts have it.
const CAP_HEIGHT: f64 = 0.72;
/// The depth of a label below its digits, as a part of its height: two of the eight rows of its glyphs.
const DESCENDER: f64 = 0.25;

/// A color as files name it: sRGB, 0 to 255.
pub(crate) type Srgb = [u8; 3];

/// A figure of lines and texts on white, in units of one pixel from the top left.
pub(crate) struct Drawing {
    width: f64,
    height: f64,
    strokes: Vec<Stroke>,
    texts: Vec<Text>,
}

/// A line through points.
struct Stroke {
    points: Vec<[f64; 2]>,
    color: Srgb,
    width: f64,
    /// The lengths of a dash and of the gap behind it.
    dashes: Option<[f64; 2]>,
}

/// A text on a base line.
struct Text {
    at: [f64; 2],
    anchor: Anchor,
    size: f64,
    color: Srgb,
    text: String,
    /// Whether it needs letters that [`Label`] does not have.
    in_words: bool,
}

/// The anchor of a text: its start, middle or end.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Drawing {
    pub(crate) fn new(width: f64, height: f64) -> Self {
        Self { width, height, strokes: Vec::new(), texts: Vec::new() }
    }

    /// Adds a line. Points that are not finite leave a gap.
    pub(crate) fn line(&mut self, points: &[[f64; 2]], color: Srgb, width: f64, dashes: Option<[f64; 2]>) {
        for run in points.split(|p| !p.iter().all(|c| c.is_finite())).filter(|run| run.len() > 1) {
            self.strokes.push(Stroke { points: run.to_vec(), color, width, dashes });
        }
    }

    pub(crate) fn text(&mut self, at: [f64; 2], anchor: Anchor, size: f64, color: Srgb, text: &str) {
        self.texts.push(Text { at, anchor, size, color, text: text.to_owned(), in_words: false });
    }

    /// Adds a text in words, which only SVG can show.
    pub(crate) fn label(&mut self, at: [f64; 2], size: f64, color: Srgb, text: &str) {
        self.texts.push(Text { at, anchor: Anchor::Start, size, color, text: text.to_owned(), in_words: true });
    }

    /// The figure as a complete SVG document.
    pub(crate) fn svg(&self) -> String {
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            self.width, self.height
        );
        for stroke in &self.strokes {
            let mut path = String::new();
            for (i, [x, y]) in stroke.points.iter().enumerate() {
                put(&mut path, format_args!("{}{x:.2} {y:.2}", if i == 0 { 'M' } else { 'L' }));
            }
            let dashes = stroke.dashes.map_or(String::new(), |[on, off]| format!(" stroke-dasharray=\"{on} {off}\""));
            let (color, width) = (hex(stroke.color), stroke.width);
            put(
                &mut svg,
                format_args!(
                    "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" \
                     stroke-linejoin=\"round\"{dashes}/>\n"
                ),
            );
        }
        for Text { at: [x, y], anchor, size, color, text, .. } in &self.texts {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let (color, text) = (hex(*color), escaped(text));
            put(
                &mut svg,
                format_args!(
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" \
                     fill=\"{color}\">{text}</text>\n"
                ),
            );
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// The figure as a picture, with the strokes of [`Label`] for letters.
    pub(crate) fn picture(&self) -> Picture {
        let white = Rgb::new(1.0, 1.0, 1.0);
        let mut picture = Picture::filled(self.width.ceil() as usize, self.height.ceil() as usize, white);
        for stroke in &self.strokes {
            stroke.draw(&mut picture);
        }
        for Text { at, anchor, size, color, text, .. } in self.texts.iter().filter(|text| !text.in_words) {
            let height = CAP_HEIGHT * size / (1.0 - DESCENDER);
            let top = at[1] - (1.0 - DESCENDER) * height;
            let label = Label { left: at[0], top, height, color: linear(*color).into() };
            let width = label.width(text);
            let shift = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5 * width,
                Anchor::End => width,
            };
            Label { left: label.left - shift, ..label }.draw(&mut picture, text);
        }
        picture
    }
}

impl Stroke {
    /// Draws the line as one shape: where it meets itself nothing is covered twice.
    fn draw(&self, picture: &mut Picture) {
        let (width, height) = (picture.width(), picture.height());
        let mut coverage = vec![0.0_f64; width * height];
        let reach = 0.5 * self.width + 1.0;
        for [a, b] in self.pieces() {
            let range = |k: usize, end: usize| {
                let (low, high) = ((a[k].min(b[k]) - reach).max(0.0), (a[k].max(b[k]) + reach).max(0.0));
                (low as usize).min(end)..(high.ceil() as usize).min(end)
            };
            for y in range(1, height) {
                for x in range(0, width) {
                    let distance = distance_to_segment([x as f64 + 0.5, y as f64 + 0.5], [a, b]);
                    let covered = (0.5 * self.width - distance + 0.5).clamp(0.0, self.width.min(1.0));
                    let cell = &mut coverage[y * width + x];
                    *cell = cell.max(covered);
                }
            }
        }
        let color = linear(self.color);
        for (i, covered) in coverage.into_iter().enumerate().filter(|(_, covered)| *covered > 0.0) {
            picture.blend((i % width) as isize, (i / width) as isize, color, covered);
        }
    }

    /// The straight pieces that are drawn, without the gaps between dashes.
    fn pieces(&self) -> Vec<[[f64; 2]; 2]> {
        let sides = self.points.windows(2).map(|p| [p[0], p[1]]);
        let Some([on, off]) = self.dashes else { return sides.collect() };
        let mut pieces = Vec::new();
        let mut along = 0.0_f64;
        for [a, b] in sides {
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let at = |t: f64| [a[0] + (b[0] - a[0]) * t / length, a[1] + (b[1] - a[1]) * t / length];
            let mut done = 0.0;
            while done < length {
                let phase = (along + done).rem_euclid(on + off);
                let rest = if phase < on { on - phase } else { on + off - phase };
                let end = (done + rest.max(1e-9 * (on + off))).min(length);
                if phase < on {
                    pieces.push([at(done), at(end)]);
                }
                done = end;
            }
            along += length;
        }
        pieces
    }
}

fn hex([r, g, b]: Srgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn linear(color: Srgb) -> Rgb<f32> {
    Rgb::from(color.map(|c| srgb_decode(f64::from(c) / 255.0) as f32))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn put(text: &mut String, arguments: Arguments<'_>) {
    text.write_fmt(arguments).unwrap_or_else(|_| unreachable!("a string takes any text"));
}

/// The smallest of 1, 2, 5, 10, 20, .. and their decimal parts that is not below `least`.
pub(crate) fn nice_step(least: f64) -> f64 {
    let decade = 10.0_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * decade).find(|step| *step >= least).unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Srgb = [0, 0, 0];

    #[test]
    fn a_line_covers_its_length_times_its_width() {
        let mut drawing = Drawing::new(60.0, 40.0);
        drawing.line(&[[10.0, 20.0], [25.0, 20.0], [50.0, 20.0]], BLACK, 4.0, None);
        let picture = drawing.picture();
        let covered: f64 = picture.pixels().iter().map(|c| 1.0 - f64::from(c[1])).sum();
        // 40 x 4, and two ends that are round.
        let expected = 160.0 + std::f64::consts::PI * 4.0;
        assert!((covered / expected - 1.0).abs() < 0.02, "{covered} against {expected}");
    }

    #[test]
    fn half_of_an_evenly_dashed_line_is_drawn() {
        let length = |dashes| {
            let points: Vec<[f64; 2]> = (0..=97).map(|i| [f64::from(i), 0.3 * f64::from(i)]).collect();
            let stroke = Stroke { points, color: BLACK, width: 1.0, dashes };
            stroke.pieces().iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum::<f64>()
        };
        let (dashed, whole) = (length(Some([3.0, 3.0])), length(None));
        assert!((dashed - 0.5 * whole).abs() <= 3.0, "{dashed} of {whole}");
    }

    #[test]
    fn points_that_are_not_finite_lift_the_pen() {
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.line(&[[0.0, 0.0], [1.0, 1.0], [f64::NAN, 2.0], [3.0, 3.0], [4.0, 4.0]], BLACK, 1.0, None);
        let svg = drawing.svg();
        assert_eq!(svg.matches("<path").count(), 2, "{svg}");
        assert!(!svg.contains("NaN"), "{svg}");
    }

    #[test]
    fn texts_are_escaped_and_stand_where_they_are_put() {
        let mut drawing = Drawing::new(40.0, 20.0);
        drawing.text([20.0, 15.0], Anchor::End, 10.0, BLACK, "8");
        let picture = drawing.picture();
        let dark = |x: usize| (0..20).any(|y| picture.pixel(x, y)[1] < 0.5);
        assert!((14..20).any(dark) && !(20..40).any(dark), "the text ends where it is put");
        drawing.text([0.0, 0.0], Anchor::Start, 10.0, BLACK, "a < b");
        assert!(drawing.svg().contains("a &lt; b"), "escaped");
    }

    #[test]
    fn steps_are_one_two_or_five() {
        for (least, step) in [(0.13, 0.2), (0.2, 0.2), (0.9, 1.0), (3.0, 5.0), (70.0, 100.0)] {
            assert!((nice_step(least) / step - 1.0).abs() < 1e-12, "{least}: {}", nice_step(least));
        }
    }
}
