//! Figures of lines: curves and polar plots, in the colors that they share. The reader's program draws them, so that their size
//! is the same for small and large pictures.

use lobe::figures::{CrossSection, Curve2d, LinePlot, PolarPlot};
use lobe::sh::Dir;

use super::canvas::Canvas;
use crate::error::Drawn;

/// The size of plots of lines.
const PLOT: [f64; 2] = [480.0, 300.0];
/// The width of polar plots.
const POLAR: f64 = 300.0;

pub(crate) const RED: [u8; 3] = [200, 30, 30];
pub(crate) const BLUE: [u8; 3] = [30, 60, 200];
pub(crate) const GREEN: [u8; 3] = [20, 140, 60];
pub(crate) const ORANGE: [u8; 3] = [214, 126, 0];
pub(crate) const BLACK: [u8; 3] = [40, 40, 40];
pub(crate) const GRAY: [u8; 3] = [130, 130, 130];

impl Canvas<'_> {
    /// Lines over the angle from an axis.
    pub(crate) fn profiles(&mut self, file: &str, curves: &[Curve2d<'_>], caption: &str) -> Drawn {
        self.line_plot(file, ([0.0, 180.0], 30.0, "°"), curves, caption)
    }

    /// Lines over a horizontal axis with ends, a step and a unit.
    pub(crate) fn line_plot(
        &mut self,
        file: &str,
        (ends, step, unit): ([f64; 2], f64, &str),
        curves: &[Curve2d<'_>],
        caption: &str,
    ) -> Drawn {
        let [width, height] = PLOT;
        self.svg(file, &LinePlot { width, height, ends, step, unit }.svg(curves), width as usize, caption)
    }

    /// A function in a plane, its values as distances up to an extent, and dashed what it is compared with.
    pub(crate) fn polar(
        &mut self,
        file: &str,
        (section, extent): (CrossSection, f64),
        f: &dyn Fn(Dir) -> f64,
        beside: &dyn Fn(Dir) -> f64,
        caption: &str,
    ) -> Drawn {
        let plot = PolarPlot { extent: Some(extent), ..PolarPlot::new(POLAR, section) };
        self.svg(file, &plot.svg(f, &[beside]), POLAR as usize, caption)
    }

    /// The same in the plane of x and z.
    pub(crate) fn polar_xz(
        &mut self,
        file: &str,
        extent: f64,
        f: &dyn Fn(Dir) -> f64,
        beside: &dyn Fn(Dir) -> f64,
        caption: &str,
    ) -> Drawn {
        self.polar(file, (CrossSection::XZ, extent), f, beside, caption)
    }
}
