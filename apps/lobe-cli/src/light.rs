//! `lobe light`: analytic lights (directional, sphere, cone, polygon, gradients) as expansions.

use clap::{Args, Subcommand};
use lobe::sh::expansion::Quantity;
use lobe::sh::light::{Normalization, SphericalPolygon};
use lobe::sh::sh_json::ShFile;
use lobe::sh::{Dir, Light, Rgb};

use crate::args::names::names;
use crate::args::output::ShOutput;
use crate::args::values;

#[derive(Args)]
pub(crate) struct LightCommand {
    #[command(subcommand)]
    shape: Shape,
}

#[derive(Subcommand)]
enum Shape {
    /// Light from one direction, such as the sun's
    Directional {
        /// The direction towards the light, a vector of any length but 0 (+z is up)
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
        dir: Dir,
        #[command(flatten)]
        color: Color,
        #[command(flatten)]
        common: Common,
    },
    /// A luminous ball
    Sphere {
        /// The direction towards its center, a vector of any length but 0 (+z is up)
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
        dir: Dir,
        #[command(flatten)]
        size: SphereSize,
        /// With --distance: its radius
        #[arg(long, value_name = "R", requires = "distance", allow_hyphen_values = true, value_parser = values::finite)]
        radius: Option<f64>,
        #[command(flatten)]
        color: Color,
        #[command(flatten)]
        common: Common,
    },
    /// A disc of the sky with a sharp edge
    Cone(Disc),
    /// A disc of the sky that fades towards its edge
    SoftCone(Disc),
    /// A polygon, which shines to both sides
    Polygon {
        /// Its vertices as seen from the place that is lit, with blanks between them
        #[arg(long, value_name = "X,Y,Z X,Y,Z ...", allow_hyphen_values = true, value_parser = vertices)]
        vertices: Vertices,
        /// Keep only what a surface that faces this way can see
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
        horizon: Option<Dir>,
        #[command(flatten)]
        color: Color,
        #[command(flatten)]
        common: Common,
    },
    /// One color above, one below, and all between
    Hemisphere {
        /// The zenith
        #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", allow_hyphen_values = true, value_parser = values::dir)]
        up: Dir,
        /// The color of the zenith
        #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = values::color)]
        sky: Rgb<f64>,
        /// The color of the nadir
        #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = values::color)]
        ground: Rgb<f64>,
        #[command(flatten)]
        common: Common,
    },
    /// A sky of three colors: zenith, horizon and ground, all of them radiance
    Gradient {
        /// The zenith
        #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", allow_hyphen_values = true, value_parser = values::dir)]
        up: Dir,
        /// The color of the zenith
        #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = values::color)]
        zenith: Rgb<f64>,
        /// The color of the horizon
        #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = values::color)]
        horizon: Rgb<f64>,
        /// The color of the nadir
        #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = values::color)]
        ground: Rgb<f64>,
        #[command(flatten)]
        common: Common,
    },
    /// The same light from everywhere
    Ambient {
        #[command(flatten)]
        color: Color,
        #[command(flatten)]
        common: Common,
    },
}

#[derive(Args)]
struct Disc {
    /// The direction towards its center, a vector of any length but 0 (+z is up)
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
    dir: Dir,
    /// From the center to the edge, above 0 and up to 180 degrees
    #[arg(long, visible_alias = "angle", value_name = "DEG", allow_hyphen_values = true, value_parser = values::finite)]
    half_angle: f64,
    #[command(flatten)]
    color: Color,
    #[command(flatten)]
    common: Common,
}

/// How large the ball looks.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct SphereSize {
    /// From its center to its edge as it is seen, above 0 and up to 90 degrees
    #[arg(long, visible_alias = "angle", value_name = "DEG", allow_hyphen_values = true, value_parser = values::finite)]
    half_angle: Option<f64>,
    /// The distance of its center, in the unit of --radius
    #[arg(long, value_name = "D", requires = "radius", allow_hyphen_values = true, value_parser = values::finite)]
    distance: Option<f64>,
}

#[derive(Args)]
struct Color {
    /// The color, in the unit of --normalize
    #[arg(long, value_name = "R,G,B", default_value = "1,1,1", allow_hyphen_values = true, value_parser = values::color)]
    color: Rgb<f64>,
}

#[derive(Args)]
struct Common {
    /// The unit of colors
    #[arg(long, value_enum, default_value = "projected")]
    normalize: Normalize,
    /// The order (number of bands), 1 to 256: n² coefficients
    #[arg(long, value_name = "N", default_value = "3", value_parser = values::order)]
    order: usize,
    /// The expansion of the light, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "P")]
    output: ShOutput,
}

names! {
    enum Normalize for Normalization {
        /// A white surface that faces the light, lit by the expansion, sends back exactly 1
        Projected,
        /// A white surface that faces the light itself sends back exactly 1
        Analytic,
        /// Radiance 1 inside the shape; irradiance 1 for a directional light
        None,
    }
}

/// The vertices of one polygon; a type of its own, so that they are one value of the option.
#[derive(Clone)]
struct Vertices(Vec<[f64; 3]>);

fn vertices(text: &str) -> Result<Vertices, String> {
    text.split_whitespace().map(values::numbers::<3>).collect::<Result<_, _>>().map(Vertices)
}

impl LightCommand {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let (light, common) = self.shape.light()?;
        common.output.check()?;
        let f = light.project(common.order, common.normalize.into())?;
        common.output.write(&ShFile::new(Quantity::Radiance, f))
    }
}

impl Shape {
    fn light(&self) -> anyhow::Result<(Light, &Common)> {
        Ok(match self {
            Self::Directional { dir, color, common } => (Light::Directional { dir: *dir, color: color.color }, common),
            Self::Sphere { dir, size, radius, color, common } => {
                let light = match (size, radius) {
                    (SphereSize { distance: Some(distance), .. }, Some(radius)) => {
                        Light::sphere(*dir, *distance, *radius, color.color)?
                    }
                    (SphereSize { half_angle: Some(degrees), .. }, None) if *degrees <= 90.0 => {
                        Light::Cone { dir: *dir, half_angle: degrees.to_radians(), color: color.color }
                    }
                    (SphereSize { half_angle: Some(degrees), .. }, None) => {
                        anyhow::bail!(
                            "--half-angle: from outside a ball is seen under 90 degrees at most, not {degrees}"
                        )
                    }
                    (SphereSize { half_angle: Some(_), .. }, Some(_)) => {
                        anyhow::bail!(
                            "--radius: only with --distance; --half-angle says by itself how large the ball looks"
                        )
                    }
                    _ => anyhow::bail!("no size given: --half-angle, or --distance with --radius, says how large"),
                };
                (light, common)
            }
            Self::Cone(Disc { dir, half_angle, color, common }) => {
                (Light::Cone { dir: *dir, half_angle: half_angle.to_radians(), color: color.color }, common)
            }
            Self::SoftCone(Disc { dir, half_angle, color, common }) => {
                (Light::SoftCone { dir: *dir, half_angle: half_angle.to_radians(), color: color.color }, common)
            }
            Self::Polygon { vertices, horizon, color, common } => {
                let whole = SphericalPolygon::new(vertices.0.clone())?;
                let polygon = horizon.map_or_else(|| whole.clone(), |up| whole.above(up));
                (Light::Polygon { polygon, color: color.color }, common)
            }
            Self::Hemisphere { up, sky, ground, common } => {
                (Light::Hemisphere { up: *up, sky: *sky, ground: *ground }, common)
            }
            Self::Gradient { up, zenith, horizon, ground, common } => {
                (Light::Gradient { up: *up, zenith: *zenith, horizon: *horizon, ground: *ground }, common)
            }
            Self::Ambient { color, common } => (Light::Ambient { color: color.color }, common),
        })
    }
}
