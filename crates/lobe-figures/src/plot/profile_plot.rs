//! Profile plots: functions of the angle to an axis.

use crate::plot::line_plot::{Curve2d, LinePlot};

/// One line of a plot.
pub struct Profile<'a> {
    /// Its name in the legend.
    pub label: &'a str,
    /// Its color in sRGB.
    pub color: [u8; 3],
    /// Whether it is dashed, as the truth is beside its approximations.
    pub dashed: bool,
    /// The function of the angle `θ` in radians.
    pub f: &'a dyn Fn(f64) -> f64,
}

impl<'a> Curve2d<'a> {
    /// A function of the angle `θ` in radians as a line over degrees, a point for every half of one from 0° to 180°.
    #[must_use]
    pub fn of_angle(label: &'a str, color: [u8; 3], dashed: bool, f: impl Fn(f64) -> f64) -> Self {
        let degrees = |i: usize| 180.0 * i as f64 / (POINTS - 1) as f64;
        let points = (0..POINTS).map(|i| [degrees(i), f(degrees(i).to_radians())]).collect();
        Self { label, color, dashed, points }
    }
}

/// A plot of functions of the angle `θ` from an axis, 0° to 180°, with a legend.
#[derive(Clone, Copy, Debug)]
pub struct ProfilePlot {
    /// The width of the picture in pixels of the page.
    pub width: f64,
    /// The height of the picture.
    pub height: f64,
}

/// Points on each line: one for every half degree.
const POINTS: usize = 361;

impl ProfilePlot {
    /// The plot as a complete SVG document. Values that are not finite leave a gap.
    #[must_use]
    pub fn svg(&self, profiles: &[Profile<'_>]) -> String {
        let curves: Vec<Curve2d<'_>> =
            profiles.iter().map(|p| Curve2d::of_angle(p.label, p.color, p.dashed, p.f)).collect();
        let Self { width, height } = *self;
        LinePlot { width, height, ends: [0.0, 180.0], step: 30.0, unit: "°" }.svg(&curves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_runs_from_the_axis_to_its_opposite_and_gaps_lift_the_pen() {
        let f = |theta: f64| if (theta - 1.0).abs() < 0.1 { f64::NAN } else { theta.cos() };
        let profile = Profile { label: "cos", color: [255, 0, 0], dashed: false, f: &f };
        let svg = ProfilePlot { width: 480.0, height: 300.0 }.svg(&[profile]);
        assert!(svg.contains("M52.00 14.00L"), "+1 at 0° is at the top: {svg}");
        assert!(svg.contains("L466.00 266.00\""), "-1 at 180° is at the bottom: {svg}");
        assert_eq!(svg.matches("#ff0000").count(), 3, "the two parts of the curve and the legend: {svg}");
        assert!(svg.contains("180°"), "degrees: {svg}");
    }
}
