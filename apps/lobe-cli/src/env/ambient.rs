//! `lobe env ambient`: the reflection of uniform light by a BRDF (its directional albedo).

use std::str::FromStr;

use clap::Args;
use lobe::env::{Brdf, Ggx, Lambert, Phong};
use lobe::sh::{Coefficient as _, Rgb};
use serde::Serialize;

use crate::args::output;
use crate::args::values;

#[derive(Args)]
pub(crate) struct EnvAmbient {
    /// The radiance L from everywhere
    #[arg(long, value_name = "R,G,B", default_value = "1,1,1", allow_hyphen_values = true, value_parser = values::color)]
    radiance: Rgb<f64>,
    /// How the surface reflects: matte of albedo RHO, 0 to 1; the Phong lobe of exponent E, 0 or more; or the rough mirror of
    /// GGX with slopes of width ALPHA, above 0 to 1, and reflectance F0 along the normal, 0 to 1
    #[arg(long, value_name = "lambert:RHO|phong:E|ggx:ALPHA,F0")]
    brdf: Reflection,
    /// Seen at this angle from the normal in degrees, 0 to 90; may be given many times
    #[arg(long = "view", value_name = "DEG", default_values = ["0", "30", "60", "80"], value_parser = values::quarter_turn)]
    views: Vec<f64>,
    /// Print {"radiance", "irradiance", "views": [{"angle", "reflectance", "radiance"}]} instead of text
    #[arg(long)]
    json: bool,
}

/// A reflectance function as it is named on the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reflection {
    Lambert(Lambert),
    Phong(Phong),
    Ggx(Ggx),
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Ambient {
    radiance: Rgb<f64>,
    irradiance: Rgb<f64>,
    views: Vec<View>,
}

#[derive(Serialize)]
struct View {
    angle: f64,
    reflectance: f64,
    radiance: Rgb<f64>,
}

impl FromStr for Reflection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let share = |what: &str, x: f64| match x {
            x if (0.0..=1.0).contains(&x) => Ok(x),
            x => Err(format!("{what} lies between 0 and 1, it is not {x}")),
        };
        match text.split_once(':') {
            Some(("lambert", albedo)) => {
                Ok(Self::Lambert(Lambert { albedo: share("an albedo", values::finite(albedo)?)? }))
            }
            Some(("phong", exponent)) => match values::finite(exponent)? {
                exponent if exponent >= 0.0 => Ok(Self::Phong(Phong { exponent })),
                exponent => Err(format!("a Phong exponent is 0 or more, not {exponent}")),
            },
            Some(("ggx", parameters)) => {
                let [alpha, f0] = values::numbers(parameters)?;
                if alpha <= 0.0 {
                    return Err(format!("the width of the slopes is above 0, it is not {alpha}"));
                }
                Ok(Self::Ggx(Ggx { alpha: share("the width of the slopes", alpha)?, f0: share("F0", f0)? }))
            }
            _ => Err("expected lambert:RHO, phong:E or ggx:ALPHA,F0".to_owned()),
        }
    }
}

impl Reflection {
    fn directional_albedo(self, cos_v: f64) -> f64 {
        match self {
            Self::Lambert(brdf) => brdf.directional_albedo(cos_v),
            Self::Phong(brdf) => brdf.directional_albedo(cos_v),
            Self::Ggx(brdf) => brdf.directional_albedo(cos_v),
        }
    }
}

impl EnvAmbient {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let view = |&angle: &f64| {
            let reflectance = self.brdf.directional_albedo(angle.to_radians().cos());
            View { angle, reflectance, radiance: self.radiance.scale(reflectance) }
        };
        let irradiance = self.radiance.scale(std::f64::consts::PI);
        let found = Ambient { radiance: self.radiance, irradiance, views: self.views.iter().map(view).collect() };
        if self.json {
            return output::print_json(&found);
        }
        let channels = |c: Rgb<f64>| format!("{:?} {:?} {:?}", c.r, c.g, c.b);
        let mut text =
            format!("radiance    {}\nirradiance  {}\n", channels(found.radiance), channels(found.irradiance));
        for View { angle, reflectance, radiance } in found.views {
            text += &format!("seen at {angle:?}°: reflectance {reflectance:?}, radiance {}\n", channels(radiance));
        }
        output::print(&text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflections_are_named_with_their_parameters() {
        let matte = Reflection::Lambert(Lambert { albedo: 0.5 });
        assert_eq!("lambert:0.5".parse(), Ok(matte), "matte");
        assert_eq!("phong:20".parse(), Ok(Reflection::Phong(Phong { exponent: 20.0 })), "phong");
        assert_eq!("ggx:0.25,0.04".parse(), Ok(Reflection::Ggx(Ggx { alpha: 0.25, f0: 0.04 })), "ggx");
        for bad in [
            "lambert",
            "lambert:2",
            "lambert:-0.1",
            "phong:-1",
            "ggx:0.5",
            "ggx:0,1",
            "ggx:2,1",
            "ggx:1,1.5",
            "x:1",
            "",
        ] {
            assert!(bad.parse::<Reflection>().is_err(), "{bad:?} was taken");
        }
    }
}
