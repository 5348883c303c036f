//! Functions of the angle to an axis as a plot in SVG.

use std::fmt::Write;

/// One line of a plot.
pub struct Profile<'a> {
    /// What the legend calls it.
    pub label: &'a str,
    /// Its colour, as SVG writes it.
    pub colour: &'a str,
    /// The function of the angle `θ` in radians.
    pub f: &'a dyn Fn(f64) -> f64,
}

/// A plot of functions of the angle `θ` from an axis, 0° to 180°, with a legend.
#[derive(Clone, Copy, Debug)]
pub struct ProfilePlot {
    /// The width of the picture in pixels of the page.
    pub width: f64,
    /// The height of the picture.
    pub height: f64,
}

/// Room for the numbers on the left, and below and around the plot.
const LEFT: f64 = 52.0;
const BELOW: f64 = 34.0;
const AROUND: f64 = 14.0;
/// Grid lines across the range of the values, at most.
const MOST_STEPS: f64 = 8.0;
/// Points on each line: one for every half degree.
const POINTS: usize = 361;

impl ProfilePlot {
    /// The plot as a complete SVG document. Values that are not finite leave a gap.
    #[must_use]
    pub fn svg(&self, profiles: &[Profile<'_>]) -> String {
        let values: Vec<Vec<f64>> = profiles.iter().map(sampled).collect();
        let (low, high) = range(&values);
        let step = nice_step((high - low) / MOST_STEPS);
        let (bottom, top) = ((low / step).floor() * step, (high / step).ceil() * step);
        let x = |degrees: f64| LEFT + (self.width - LEFT - AROUND) * degrees / 180.0;
        let y = |v: f64| AROUND + (self.height - BELOW - AROUND) * (top - v) / (top - bottom);

        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" \
             font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            self.width, self.height
        );
        for degrees in (0..=180).step_by(30).map(f64::from) {
            grid_line(&mut svg, [x(degrees), y(bottom), x(degrees), y(top)], degrees == 0.0);
            number(&mut svg, x(degrees), y(bottom) + 18.0, "middle", &format!("{degrees}°"));
        }
        for k in 0..=((top - bottom) / step).round() as usize {
            let v = bottom + k as f64 * step;
            grid_line(&mut svg, [x(0.0), y(v), x(180.0), y(v)], v.abs() < 1e-9 * step);
            let digits = (-step.log10().floor()).max(0.0) as usize;
            number(&mut svg, x(0.0) - 8.0, y(v) + 4.0, "end", &format!("{v:.digits$}"));
        }
        for (profile, values) in profiles.iter().zip(&values) {
            let points = values.iter().enumerate().map(|(i, &v)| (x(degrees(i)), y(v)));
            curve(&mut svg, profile.colour, points);
        }
        self.legend(&mut svg, profiles);
        svg.push_str("</svg>\n");
        svg
    }

    fn legend(&self, svg: &mut String, profiles: &[Profile<'_>]) {
        for (k, profile) in profiles.iter().enumerate() {
            let (x, y) = (self.width - AROUND - 150.0, AROUND + 18.0 + 18.0 * k as f64);
            let (line_end, text, baseline) = (x + 22.0, x + 30.0, y + 4.0);
            let (colour, label) = (profile.colour, escaped(profile.label));
            put(
                svg,
                format_args!(
                    "<line x1=\"{x}\" y1=\"{y}\" x2=\"{line_end}\" y2=\"{y}\" stroke=\"{colour}\" stroke-width=\"2\"/>\
                 <text x=\"{text}\" y=\"{baseline}\">{label}</text>\n"
                ),
            );
        }
    }
}

/// The angle of point `i` in degrees.
fn degrees(i: usize) -> f64 {
    180.0 * i as f64 / (POINTS - 1) as f64
}

fn sampled(profile: &Profile<'_>) -> Vec<f64> {
    (0..POINTS).map(|i| (profile.f)(degrees(i).to_radians())).collect()
}

/// The smallest and the largest value, zero included; `(0, 1)` if there is nothing else.
fn range(values: &[Vec<f64>]) -> (f64, f64) {
    let finite = values.iter().flatten().filter(|v| v.is_finite());
    let (low, high) = finite.fold((0.0_f64, 0.0_f64), |(low, high), &v| (low.min(v), high.max(v)));
    if low < high { (low, high) } else { (0.0, 1.0) }
}

/// The smallest of 1, 2, 5, 10, 20, .. and their decimal parts that is not below `least`.
fn nice_step(least: f64) -> f64 {
    let decade = 10.0_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * decade).find(|step| *step >= least).unwrap_or(10.0 * decade)
}

fn grid_line(svg: &mut String, [x1, y1, x2, y2]: [f64; 4], is_axis: bool) {
    let colour = if is_axis { "#444" } else { "#ddd" };
    put(svg, format_args!("<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{colour}\"/>\n"));
}

fn number(svg: &mut String, x: f64, y: f64, anchor: &str, text: &str) {
    put(svg, format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"#444\">{text}</text>\n"));
}

/// A polyline for every run of finite points.
fn curve(svg: &mut String, colour: &str, points: impl Iterator<Item = (f64, f64)>) {
    let mut path = String::new();
    let mut pen_is_down = false;
    for (x, y) in points {
        if y.is_finite() {
            put(&mut path, format_args!("{}{x:.2} {y:.2}", if pen_is_down { "L" } else { "M" }));
        }
        pen_is_down = y.is_finite();
    }
    put(svg, format_args!("<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\n"));
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn put(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).unwrap_or_else(|_| unreachable!("a string takes any text"));
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: ProfilePlot = ProfilePlot { width: 480.0, height: 300.0 };

    #[test]
    fn steps_are_one_two_or_five() {
        for (least, step) in [(0.13, 0.2), (0.2, 0.2), (0.9, 1.0), (3.0, 5.0), (70.0, 100.0)] {
            assert!((nice_step(least) / step - 1.0).abs() < 1e-12, "{least}: {}", nice_step(least));
        }
    }

    #[test]
    fn curves_pass_through_their_values_and_gaps_lift_the_pen() {
        let f = |theta: f64| if (theta - 1.0).abs() < 0.1 { f64::NAN } else { theta.cos() };
        let svg = PLOT.svg(&[Profile { label: "a < b & c", colour: "red", f: &f }]);
        // From +1 at 0° (top) to -1 at 180° (bottom).
        assert!(svg.contains("M52.00 14.00L"), "the first point");
        assert!(svg.contains("L466.00 266.00\""), "the last point");
        assert_eq!(svg.matches('M').count(), 2, "the gap splits the curve in two");
        assert!(svg.contains("a &lt; b &amp; c") && svg.ends_with("</svg>\n"), "escaped and closed");
    }

    #[test]
    fn nothing_to_plot_is_an_empty_frame() {
        let svg = PLOT.svg(&[]);
        assert!(svg.contains("180°") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
