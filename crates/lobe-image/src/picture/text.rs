//! Text labels in pictures.

use crate::picture::picture::Picture;
use crate::pixel::{IntoPixel, Pixel};

/// The height of the grid of the glyphs: two rows below the base line, six above.
const GRID_HEIGHT: f64 = 8.0;
/// The distance from one glyph to the next on the grid: four columns and a space of two.
const ADVANCE: f64 = 6.0;
/// The width of a stroke on the grid.
const STROKE: f64 = 0.95;

/// A line of text drawn with strokes, smooth at any size: digits, signs and small letters.
///
/// Longer texts belong beside a picture, not into it.
#[derive(Clone, Copy, Debug)]
pub struct Label {
    /// The column of the left end.
    pub left: f64,
    /// The row of the top end.
    pub top: f64,
    /// The height from the lowest to the highest stroke, in pixels.
    pub height: f64,
    /// The color.
    pub color: Pixel,
}

impl Label {
    /// The width of `text` in pixels.
    #[must_use]
    pub fn width(&self, text: &str) -> f64 {
        self.unit() * (ADVANCE * text.chars().count() as f64 - (ADVANCE - 4.0 - STROKE)).max(0.0)
    }

    /// Draws `text`. A character without a glyph is drawn as a box; a space stays empty.
    pub fn draw(&self, picture: &mut Picture, text: &str) {
        let unit = self.unit();
        let mut left = self.left;
        for character in text.chars() {
            self.draw_glyph(picture, glyph(character), left);
            left += ADVANCE * unit;
        }
    }

    fn unit(&self) -> f64 {
        self.height / (GRID_HEIGHT + STROKE)
    }

    fn draw_glyph(&self, picture: &mut Picture, strokes: &str, left: f64) {
        let unit = self.unit();
        let at = |x: u8, y: u8| {
            let (x, y) = (f64::from(x - b'0'), f64::from(y - b'0'));
            [left + (x + 0.5 * STROKE) * unit, self.top + (GRID_HEIGHT + 0.5 * STROKE - y) * unit]
        };
        let lines: Vec<[[f64; 2]; 2]> = strokes
            .split_whitespace()
            .flat_map(|stroke| {
                let points: Vec<_> = stroke.as_bytes().chunks_exact(2).map(|p| at(p[0], p[1])).collect();
                points.windows(2).map(|p| [p[0], p[1]]).collect::<Vec<_>>()
            })
            .collect();
        draw_lines(picture, &lines, STROKE * unit, self.color);
    }
}

/// Draws straight lines with round ends, `width` pixels wide, as one shape: crossings are covered once.
pub fn draw_lines(picture: &mut Picture, lines: &[[[f64; 2]; 2]], width: f64, color: impl IntoPixel) {
    let reach = 0.5 * width + 1.0;
    let ends = || lines.iter().flatten();
    let range = |k: usize| {
        let (low, high) =
            ends().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[k]), high.max(p[k])));
        (low - reach).floor() as isize..(high + reach).ceil() as isize
    };
    for y in range(1) {
        for x in range(0) {
            let center = [x as f64 + 0.5, y as f64 + 0.5];
            let distance = lines.iter().map(|&line| distance_to_segment(center, line)).fold(f64::INFINITY, f64::min);
            let coverage = (0.5 * width - distance + 0.5).clamp(0.0, width.min(1.0));
            if coverage > 0.0 {
                picture.blend(x, y, color, coverage);
            }
        }
    }
}

/// The distance of a point from a line segment.
#[must_use]
pub fn distance_to_segment(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared_length = along[0] * along[0] + along[1] * along[1];
    let t = if squared_length > 0.0 { (along[0] * to[0] + along[1] * to[1]) / squared_length } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    (to[0] - t * along[0]).hypot(to[1] - t * along[1])
}

/// The strokes of a character: polylines of points `xy` on a grid with the base line at `y = 2`.
fn glyph(character: char) -> &'static str {
    match character {
        ' ' => "",
        '0' => "123243473818070312",
        '1' => "072822 0242",
        '2' => "07183847460242",
        '3' => "07183847463515 354443321203",
        '4' => "32380444",
        '5' => "480805354443321203",
        '6' => "473818070312324344351504",
        '7' => "084812",
        '8' => "15060718384746351504031232434435",
        '9' => "031232434738180706153546",
        '+' => "2327 0545",
        '-' => "0545",
        '=' => "0444 0646",
        '.' => "2222",
        'a' => "4536160503123243 4642",
        'b' => "0802 0516364543321203",
        'c' => "4536160503123243",
        'd' => "4842 4536160503123243",
        'e' => "04444536160503123243",
        'f' => "38281712 0636",
        'g' => "4536160503123243 4641301001",
        'h' => "0802 0516364542",
        'i' => "2622 2828",
        'j' => "262110 2828",
        'k' => "0802 0446 2542",
        'l' => "1828233242",
        'm' => "0206 05162522 25364542",
        'n' => "0206 0516364542",
        'o' => "163645433212030516",
        'p' => "0600 0516364543321203",
        'q' => "4640 4536160503123243",
        'r' => "0602 05163645",
        's' => "45361605143443321203",
        't' => "1813223243 0636",
        'u' => "0603123243 4642",
        'v' => "062246",
        'w' => "0612243246",
        'x' => "0642 0246",
        'y' => "0622 4610",
        'z' => "06460242",
        ',' => "2211",
        ':' => "2323 2626",
        '/' => "0248",
        '%' => "0248 0818170708 3343423233",
        '(' => "38272332",
        ')' => "18272312",
        _ => "0242480802",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHARACTERS: &str = "0123456789+-=.,:/%()abcdefghijklmnopqrstuvwxyz ";

    fn drawn(text: &str, height: f64) -> Picture {
        let mut picture = Picture::filled(60, 40, [0.0; 3]);
        Label { left: 10.0, top: 5.0, height, color: [1.0; 3] }.draw(&mut picture, text);
        picture
    }

    #[test]
    fn characters_look_different_from_each_other_and_from_the_box() {
        let pictures: Vec<_> = CHARACTERS.chars().chain(['?']).map(|c| drawn(&c.to_string(), 20.0)).collect();
        for i in 0..pictures.len() {
            for k in 0..i {
                assert!(pictures[i] != pictures[k], "characters {i} and {k} of {CHARACTERS}? look alike");
            }
        }
    }

    #[test]
    fn labels_stay_inside_their_rectangle() {
        let label = Label { left: 10.0, top: 5.0, height: 17.0, color: [1.0; 3] };
        let right = label.left + label.width("y8");
        let picture = drawn("y8", 17.0);
        for y in 0..40 {
            for x in 0..60 {
                let inside = (9.0..right + 1.0).contains(&(x as f64)) && (4.0..23.0).contains(&(y as f64));
                assert!(inside || picture.pixel(x, y) == [0.0; 3], "pixel ({x}, {y}) outside the label is painted");
            }
        }
        assert!(picture.mean()[1] > 0.01, "something is drawn: {:?}", picture.mean());
    }
}
