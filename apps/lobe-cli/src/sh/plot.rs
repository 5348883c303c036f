//! `lobe sh plot`: balloon, cube-cross and polar plots of an expansion, and its graph over an angle.

use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::figures::{Balloon, CrossSection, CubeCross, Curve2d, LinePlot, PolarPlot};
use lobe::image::{Picture, Tone};
use lobe::io::{IoError, write_atomically};
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient as _, Dir, Expansion as _, ShVec};

use crate::args::input::ShInput;
use crate::args::output;
use crate::args::values;

/// The largest figure: a balloon of that size takes half a minute.
const MAX_SIZE: usize = 8192;

/// The smallest graph: below it the numbers and the legend leave no room for the curves.
const MIN_GRAPH: usize = 256;

/// The height of a graph, as a part of its width.
const GRAPH_HEIGHT: f64 = 0.625;

/// The colors of the curves of a graph, in turn.
const CURVES: [[u8; 3]; 4] = [[200, 30, 30], [34, 34, 34], [31, 79, 209], [20, 130, 70]];

#[derive(Args)]
pub(crate) struct ShPlot {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The figure: .png, or .svg (polar and profile as lines; the other styles as a picture inside)
    #[arg(short, long, value_name = "F")]
    output: Figure,
    /// What to draw; but for a profile red is positive and blue negative, always
    #[arg(long, value_enum, default_value = "balloon")]
    style: Style,
    /// Which channel of a colored expansion
    #[arg(long, value_enum, default_value = "luminance")]
    channel: Channel,
    /// With --style polar: the plane of the cross-section; with --style profile: the side of it on which θ runs, xz from +z
    /// by +x to -z, yz by +y
    #[arg(long, value_enum)]
    plane: Option<Plane>,
    /// With --style polar or profile: another expansion to draw beside it, dashed; may be given many times
    #[arg(long = "beside", value_name = "Q")]
    beside: Vec<ShInput>,
    /// The value that reaches the rim of a balloon or the outermost ring, or that has the full color on a cube [default: the
    /// largest magnitude that occurs]
    #[arg(long, value_name = "V", value_parser = values::positive)]
    extent: Option<f64>,
    /// The width in pixels, 16 to 8192; of a profile 256 or more
    #[arg(long, value_name = "N", default_value = "512", value_parser = size)]
    size: usize,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Style {
    /// The surface at the distance |f| from the middle
    Balloon,
    /// The unfolded cube, with lines of equal values; the green one is zero
    Cross,
    /// A cross-section, at the distance |f| from the middle
    Polar,
    /// A graph over the angle θ from +z, 0° to 180°
    Profile,
}

#[derive(Clone, Copy, ValueEnum)]
enum Channel {
    Luminance,
    Red,
    Green,
    Blue,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Plane {
    /// +x to the right, +z upwards; the default
    Xz,
    /// +y to the right, +z upwards
    Yz,
    /// +x to the right, +y upwards
    Xy,
}

/// A file of a figure.
#[derive(Clone, Debug)]
struct Figure {
    path: PathBuf,
    is_svg: bool,
}

impl FromStr for Figure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self { path, is_svg: false }),
            Some("svg") => Ok(Self { path, is_svg: true }),
            _ => Err("expected a figure's name that ends in .png or .svg".to_owned()),
        }
    }
}

fn size(text: &str) -> Result<usize, String> {
    values::whole(text, 16, MAX_SIZE, "a width in pixels")
}

impl ShPlot {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        self.check_options()?;
        output::prepare_file(&self.output.path, output::NO_INPUTS)?;
        let f = self.function(&self.input)?;
        let others = self.beside.iter().map(|input| self.function(input)).collect::<anyhow::Result<Vec<_>>>()?;
        let bytes = self.figure(&f, &others)?;
        let name = self.output.path.display().to_string();
        write_atomically(&self.output.path, |file| file.write_all(&bytes))
            .map_err(|source| IoError::Io { place: name, source })?;
        Ok(())
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        let is_profile = self.style == Style::Profile;
        let is_section = is_profile || self.style == Style::Polar;
        if self.plane.is_some() && !is_section {
            bail!("--plane: only --style polar and profile lie in a plane; choose one, or leave the plane out");
        }
        if !self.beside.is_empty() && !is_section {
            bail!(
                "--beside: only --style polar and profile draw several functions; choose one, or leave the others out"
            );
        }
        if is_profile {
            self.check_profile()?;
        }
        if [&self.input].into_iter().chain(&self.beside).filter(|input| **input == ShInput::Stdin).count() > 1 {
            bail!("stdin: several inputs are -, but stdin can be read only once; name files for the others");
        }
        Ok(())
    }

    /// Refuses options that make no graph.
    fn check_profile(&self) -> anyhow::Result<()> {
        if self.plane == Some(Plane::Xy) {
            bail!("--plane xy: --style profile begins at +z, which is not in it; choose xz or yz");
        }
        if self.extent.is_some() {
            bail!(
                "--extent: --style profile has all values on its axis; choose another style, or leave the extent out"
            );
        }
        if self.size < MIN_GRAPH {
            bail!("--size: expected {MIN_GRAPH} or more with --style profile, for its numbers, found {}", self.size);
        }
        Ok(())
    }

    /// The channel that is drawn.
    fn function(&self, input: &ShInput) -> anyhow::Result<ShVec<f64>> {
        Ok(match input.read_to_search()?.coefficients {
            FileCoefficients::Scalar(f) => f,
            FileCoefficients::Rgb(f) => f.map(|c| match self.channel {
                Channel::Luminance => c.luminance(),
                Channel::Red => c.channel(0),
                Channel::Green => c.channel(1),
                Channel::Blue => c.channel(2),
            }),
        })
    }

    fn figure(&self, f: &ShVec<f64>, others: &[ShVec<f64>]) -> anyhow::Result<Vec<u8>> {
        let value = |s: Dir| f.eval(s);
        let picture = match self.style {
            Style::Balloon => Balloon { extent: self.extent, ..Balloon::new(self.size) }.picture(value),
            Style::Cross => CubeCross { full_scale: self.extent, ..CubeCross::new(self.size / 4) }.picture(value),
            Style::Polar => {
                let plot = PolarPlot { extent: self.extent, ..PolarPlot::new(self.size as f64, self.section()) };
                let others: Vec<_> = others.iter().map(|g| move |s: Dir| g.eval(s)).collect();
                let others: Vec<&dyn Fn(Dir) -> f64> = others.iter().map(|g| g as &dyn Fn(Dir) -> f64).collect();
                if self.output.is_svg {
                    return Ok(plot.svg(&value, &others).into_bytes());
                }
                plot.picture(&value, &others)
            }
            Style::Profile => return self.graph(f, others),
        };
        self.encoded(&picture)
    }

    /// The values from +z to -z over their angle, those of the others dashed.
    fn graph(&self, f: &ShVec<f64>, others: &[ShVec<f64>]) -> anyhow::Result<Vec<u8>> {
        let section = self.section();
        let names: Vec<String> = match others {
            [] => vec![String::new()],
            _ => [&self.input].into_iter().chain(&self.beside).map(ToString::to_string).collect(),
        };
        let functions = [f].into_iter().chain(others).zip(&names).enumerate();
        let curves: Vec<Curve2d<'_>> = functions
            .map(|(k, (f, name))| {
                Curve2d::of_angle(name, CURVES[k % CURVES.len()], k > 0, |theta| f.eval(section.dir(FRAC_PI_2 - theta)))
            })
            .collect();
        let width = self.size as f64;
        // Pictures have no sign for degrees.
        let unit = if self.output.is_svg { "°" } else { "" };
        let plot = LinePlot { width, height: GRAPH_HEIGHT * width, ends: [0.0, 180.0], step: 30.0, unit };
        if self.output.is_svg { Ok(plot.svg(&curves).into_bytes()) } else { self.encoded(&plot.picture(&curves)) }
    }

    fn section(&self) -> CrossSection {
        match self.plane {
            None | Some(Plane::Xz) => CrossSection::XZ,
            Some(Plane::Yz) => CrossSection::YZ,
            Some(Plane::Xy) => CrossSection::XY,
        }
    }

    fn encoded(&self, picture: &Picture) -> anyhow::Result<Vec<u8>> {
        Ok(if self.output.is_svg {
            picture.to_svg(&Tone::PLAIN)?.into_bytes()
        } else {
            picture.to_png(&Tone::PLAIN)?
        })
    }
}
