//! Color bar: the legend of an error map.

use crate::picture::colormap::sequential;
use crate::picture::picture::Picture;
use crate::picture::text::Label;
use crate::pixel::IntoPixel;

/// The distance of the numbers from the sides, relative to the height.
const MARGIN: f64 = 0.15;

/// A bar of the colors of [`sequential`] from 0 on the left to `full_scale` on the right, with both numbers below, on
/// the given background.
#[must_use]
pub fn color_bar(
    width: usize,
    height: usize,
    full_scale: f64,
    ink: impl IntoPixel,
    background: impl IntoPixel,
) -> Picture {
    let (bar, ink, background) = (height / 2, ink.into(), background.into());
    let mut picture =
        Picture::from_fn(
            width,
            height,
            |x, y| {
                if y < bar { sequential((x as f64 + 0.5) / width as f64) } else { background }
            },
        );
    let text_height = 0.4 * height as f64;
    let margin = MARGIN * height as f64;
    let label = Label { left: margin, top: height as f64 - text_height, height: text_height, color: ink };
    label.draw(&mut picture, "0");
    let text = three_digits(full_scale);
    Label { left: width as f64 - label.width(&text) - margin, ..label }.draw(&mut picture, &text);
    picture
}

/// A number in three digits, with an exponent where it would be long without.
fn three_digits(number: f64) -> String {
    if !(1e-3..1e3).contains(&number) {
        return format!("{number:.2e}");
    }
    let decimals = (2.0 - number.log10().floor()) as usize;
    format!("{number:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (number, text) in
            [(6.6399, "6.64"), (123.4, "123"), (0.01234, "0.0123"), (0.0, "0.00e0"), (4.2e-5, "4.20e-5")]
        {
            assert_eq!(three_digits(number), text, "{number}");
        }
    }

    #[test]
    fn the_bar_runs_from_black_to_white() {
        let picture = color_bar(200, 40, 0.0123, [1.0; 3], [0.0; 3]);
        assert!(picture.pixel(0, 5)[1] < 0.01 && picture.pixel(199, 5)[1] > 0.97, "the ends of the bar");
        let ink =
            |range: std::ops::Range<usize>| range.filter(|&x| (24..40).any(|y| picture.pixel(x, y)[1] > 0.5)).count();
        assert!(
            ink(0..5) == 0 && ink(5..25) > 5 && ink(25..90) == 0 && ink(115..195) > 40 && ink(195..200) == 0,
            "a 0 on the left, 0.0123 on the right"
        );
    }
}
