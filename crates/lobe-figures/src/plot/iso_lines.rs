//! Iso lines (contour lines) of a function, anti-aliased by its gradient.

use lobe_sh::Rgb;

use lobe_image::{diverging, mix};

const LINE: Rgb<f32> = Rgb::new(0.0, 0.0, 0.0);
const ZERO_LINE: Rgb<f32> = Rgb::new(0.0, 0.42, 0.05);

/// A slope below this part of the step a pixel is noise of a flat function: no line is drawn.
const FLAT: f64 = 1e-9;

/// Lines at every multiple of `step`, the one at zero green and of its own width.
///
/// The distance of a pixel from the line of level `c` is estimated to first order from the value and the gradient
/// there, so a line is as wide where the function is steep as where it is flat, and its edge is smooth:
///
/// ```text
///   d = |f - c| / |∇f|        coverage = width/2 - d + 1/2, held to [0, 1]        d, width in pixels, ∇f per pixel
/// ```
///
/// Where lines of different level come closer than three times their width they fade, instead of running into one
/// dark area. Where the gradient vanishes the estimate is short: a line is up to √2 times as wide where two branches
/// cross, and twice as wide where the function only touches the level. There are no lines where the gradient is not
/// finite, and none at all if the step is not positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsoLines {
    /// The difference of the values of neighboring lines.
    pub step: f64,
    /// The width of a line in pixels.
    pub width: f64,
    /// The width of the line at zero in pixels.
    pub zero_width: f64,
}

impl IsoLines {
    /// The color of a pixel: `value / full_scale` in the colors of [`diverging`], with lines on top.
    ///
    /// `gradient` is the change of the value per pixel to the right and per pixel down (or up).
    #[must_use]
    pub fn color(&self, value: f64, gradient: [f64; 2], full_scale: f64) -> Rgb<f32> {
        let slope = gradient[0].hypot(gradient[1]);
        let fill = if full_scale > 0.0 { value / full_scale } else { 0.0 };
        let lined = mix(diverging(fill), LINE, self.line_coverage(value, slope));
        mix(lined, ZERO_LINE, self.zero_coverage(value, slope)).into()
    }

    /// The coverage of a pixel by the lines at levels other than zero.
    pub(crate) fn line_coverage(&self, value: f64, slope: f64) -> f64 {
        if self.is_flat(slope) {
            return 0.0;
        }
        let level = (value.abs() / self.step).round().max(1.0) * self.step;
        let spacing = self.step / slope;
        let fade = ((spacing - self.width) / (2.0 * self.width)).clamp(0.0, 1.0);
        fade * coverage((value.abs() - level) / slope, self.width)
    }

    /// The coverage of a pixel by the line at zero.
    pub(crate) fn zero_coverage(&self, value: f64, slope: f64) -> f64 {
        if self.is_flat(slope) { 0.0 } else { coverage(value / slope, self.zero_width) }
    }

    fn is_flat(&self, slope: f64) -> bool {
        let has_levels = self.step > 0.0 && slope.is_finite();
        !has_levels || slope <= FLAT * self.step
    }
}

fn coverage(distance: f64, width: f64) -> f64 {
    (0.5 * width - distance.abs() + 0.5).clamp(0.0, width.min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: IsoLines = IsoLines { step: 0.25, width: 1.0, zero_width: 2.0 };

    #[test]
    fn lines_lie_where_the_function_has_their_level() {
        // f(x) = x / 40: levels 10 pixels apart.
        for x in -100_i32..=100 {
            let value = f64::from(x) / 40.0;
            let (line, zero) = (LINES.line_coverage(value, 0.025), LINES.zero_coverage(value, 0.025));
            let on_level = x % 10 == 0 && x != 0;
            let expected = if on_level { 1.0 } else { 0.0 };
            assert!((line - expected).abs() < 1e-12, "line at x = {x}: {line}");
            let expected = if x == 0 {
                1.0
            } else if x.abs() == 1 {
                0.5
            } else {
                0.0
            };
            assert!((zero - expected).abs() < 1e-12, "zero line at x = {x}: {zero}");
        }
    }

    #[test]
    fn a_line_has_its_width_whatever_the_slope() {
        for pixels_per_step in [4.0, 15.0, 400.0] {
            let slope = LINES.step / pixels_per_step;
            let wide: f64 = (-2000..2000).map(|k| LINES.zero_coverage(f64::from(k) * 0.01 * slope, slope) * 0.01).sum();
            assert!((wide - LINES.zero_width).abs() < 0.02, "{pixels_per_step} pixels a step: the line is {wide} wide");
        }
    }

    #[test]
    fn flat_functions_have_no_lines() {
        for value in [0.0, 0.25, 1e-17] {
            let lines = (LINES.line_coverage(value, 1e-16), LINES.zero_coverage(value, 0.0));
            assert_eq!(lines, (0.0, 0.0), "value {value}");
        }
    }
}
