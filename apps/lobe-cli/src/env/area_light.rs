//! `lobe env area-light`: the irradiance of an area light, exactly and in the point and directional approximations.

use anyhow::bail;
use clap::{Args, Subcommand};
use lobe::env::{AreaLight, DiscLight, PolygonLight, SphereLight, compare_approximations};
use lobe::sh::Dir;
use serde::Serialize;

use crate::args::output;
use crate::args::values;

#[derive(Args)]
pub(crate) struct EnvAreaLight {
    #[command(subcommand)]
    light: Shape,
}

#[derive(Subcommand)]
enum Shape {
    /// A luminous ball
    Sphere {
        /// Its center
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
        center: [f64; 3],
        /// Its radius
        #[arg(long, value_name = "R", allow_hyphen_values = true, value_parser = values::positive)]
        radius: f64,
        #[command(flatten)]
        receiver: Receiver,
    },
    /// A disc that shines to one side
    Disc {
        /// Its center
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
        center: [f64; 3],
        /// The direction it shines in
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
        shines: Dir,
        /// Its radius
        #[arg(long, value_name = "R", allow_hyphen_values = true, value_parser = values::positive)]
        radius: f64,
        #[command(flatten)]
        receiver: Receiver,
    },
    /// A rectangle, or a parallelogram: center ± u ± v, which shines towards u × v
    Rectangle {
        /// Its center
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
        center: [f64; 3],
        /// Half of one side
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
        u: [f64; 3],
        /// Half of the other side
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
        v: [f64; 3],
        #[command(flatten)]
        receiver: Receiver,
    },
    /// A plane polygon that shines to the side from which its vertices run counterclockwise
    Polygon {
        /// A vertex; give three or more, in order
        #[arg(
            long = "vertex",
            value_name = "X,Y,Z",
            required = true,
            allow_hyphen_values = true,
            value_parser = values::numbers::<3>
        )]
        vertices: Vec<[f64; 3]>,
        #[command(flatten)]
        receiver: Receiver,
    },
}

/// The surface that is lit.
#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
struct Receiver {
    /// The place that is lit
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
    at: [f64; 3],
    /// The direction that the surface there faces
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", allow_hyphen_values = true, value_parser = values::dir)]
    normal: Dir,
    /// The place where the directional approximation is made to agree [default: the place that is lit]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
    reference: Option<[f64; 3]>,
    /// Print {"irradiance", "vector", "point", "point_error", "directional", "directional_error"} instead of text; an error
    /// is relative, and null where no light arrives
    #[arg(long)]
    json: bool,
}

/// The JSON of `--json`; all for a light of radiance 1.
#[derive(Serialize)]
struct Found {
    irradiance: f64,
    vector: [f64; 3],
    point: f64,
    point_error: Option<f64>,
    directional: f64,
    directional_error: Option<f64>,
}

impl EnvAreaLight {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        match &self.light {
            Shape::Sphere { center, radius, receiver } => {
                for (name, place) in receiver.places() {
                    let squared: f64 = place.iter().zip(center).map(|(a, b)| (a - b).powi(2)).sum();
                    if squared.sqrt() <= *radius {
                        bail!("{name}: the place lies in the ball; move it away, or make --radius smaller");
                    }
                }
                receiver.print(&SphereLight { center: *center, radius: *radius })
            }
            Shape::Disc { center, shines, radius, receiver } => {
                receiver.print(&DiscLight { center: *center, normal: *shines, radius: *radius })
            }
            Shape::Rectangle { center, u, v, receiver } => receiver.print(&PolygonLight::rectangle(*center, *u, *v)?),
            Shape::Polygon { vertices, receiver } => {
                receiver.print(&PolygonLight::new(vertices.clone()).map_err(|e| anyhow::anyhow!("--vertex: {e}"))?)
            }
        }
    }
}

impl Receiver {
    /// The places at which light arrives, with the names of their options.
    fn places(&self) -> impl Iterator<Item = (&'static str, [f64; 3])> {
        [("--at", self.at)].into_iter().chain(self.reference.map(|place| ("--reference", place)))
    }

    fn print(&self, light: &impl AreaLight) -> anyhow::Result<()> {
        let both = compare_approximations(light, self.reference.unwrap_or(self.at), self.at, self.normal);
        if !(both.exact.is_finite() && both.point.is_finite() && both.directional.is_finite()) {
            bail!("--at: the place lies on the light; move it away");
        }
        let known = |error: f64| error.is_finite().then_some(error);
        let found = Found {
            irradiance: both.exact,
            vector: light.vector_irradiance(self.at).to_array(),
            point: both.point,
            point_error: known(both.point_error()),
            directional: both.directional,
            directional_error: known(both.directional_error()),
        };
        if self.json {
            return output::print_json(&found);
        }
        let error = |e: Option<f64>| e.map_or("no light arrives".to_owned(), |e| format!("{:+.4} %", 100.0 * e));
        let [x, y, z] = found.vector;
        output::print(&format!(
            "irradiance         {:?}\nvector irradiance  {x:?} {y:?} {z:?}\nas a point         {:?} ({})\n\
             as a parallel beam {:?} ({})\n",
            found.irradiance,
            found.point,
            error(found.point_error),
            found.directional,
            error(found.directional_error)
        ))
    }
}
