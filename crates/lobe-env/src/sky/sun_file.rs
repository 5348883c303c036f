//! Files of suns: JSON, as `lobe env sun --json` prints it.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use lobe_io::{IoError, expect_file};
use lobe_sh::Dir;
use serde::{Deserialize, Serialize};

use crate::error::EnvError;
use crate::sky::sun_extraction::Sun;

/// The most suns of a file.
const MAX_SUNS: usize = 1024;

/// The most bytes of a file: a thousand for each sun, of which a printed one has a quarter.
const MAX_BYTES: u64 = 1000 * MAX_SUNS as u64;

/// The angular diameter of the sun, in degrees, as seen from the Earth at its mean distance: 1919 arc seconds.
const SUN: f64 = 1919.0 / 3600.0;

/// A sun in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SunRecord {
    /// Towards it, of any length.
    pub direction: [f64; 3],
    /// The irradiance of a surface that faces it, without 1/π.
    pub irradiance: [f64; 3],
    /// The radiance of its disc; it follows from the others and is not read.
    #[serde(default, skip_deserializing)]
    pub radiance: [f64; 3],
    /// The diameter of its disc in degrees; that of the sun unless a file says otherwise.
    #[serde(default = "diameter_of_the_sun")]
    pub diameter: f64,
    /// The texels that were changed in the map from which it was taken; not read.
    #[serde(default, skip_deserializing)]
    pub texels: usize,
}

/// One sun, or a list of them.
#[derive(Deserialize)]
#[serde(untagged)]
enum Records {
    Many { suns: Vec<SunRecord> },
    One(SunRecord),
}

fn diameter_of_the_sun() -> f64 {
    SUN
}

impl From<Sun> for SunRecord {
    fn from(sun: Sun) -> Self {
        Self {
            direction: sun.direction.to_array(),
            irradiance: sun.irradiance.to_array(),
            radiance: sun.radiance().to_array(),
            diameter: sun.angular_diameter.to_degrees(),
            texels: sun.texels,
        }
    }
}

impl SunRecord {
    /// The sun, or what cannot be.
    fn sun(&self) -> Result<Sun, String> {
        let direction = Dir::new(self.direction).ok_or_else(|| {
            let [x, y, z] = self.direction;
            format!("expected a direction, found {x},{y},{z}")
        })?;
        let [r, g, b] = self.irradiance;
        if ![r, g, b].iter().all(|c| c.is_finite() && *c >= 0.0) {
            return Err(format!("expected an irradiance of at least 0, found {r},{g},{b}"));
        }
        if !(self.diameter > 0.0 && self.diameter <= 180.0) {
            return Err(format!("expected a diameter above 0 and up to 180 degrees, found {}", self.diameter));
        }
        Ok(Sun {
            direction,
            irradiance: self.irradiance.into(),
            angular_diameter: self.diameter.to_radians(),
            texels: 0,
        })
    }
}

/// Reads suns from a .json file: `{"direction": [x, y, z], "irradiance": [r, g, b], "diameter": degrees}`, or
/// `{"suns": [..]}` of up to 1024 of them. The diameter may be left out, as of the sun.
///
/// # Errors
/// [`EnvError::File`] if the file cannot be read or holds no suns.
pub fn read_suns(path: impl AsRef<Path>) -> Result<Vec<Sun>, EnvError> {
    let path = path.as_ref();
    let fault = |message: String| IoError::Invalid { place: path.display().to_string(), message };
    let io = |source| IoError::io(path, source);
    expect_file(path)?;
    let mut bytes = Vec::new();
    File::open(path).map_err(io)?.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(fault(format!("expected at most {MAX_BYTES} bytes")).into());
    }
    let records: Records = serde_json::from_slice(&bytes).map_err(|error| {
        let form = "{\"direction\": [x, y, z], \"irradiance\": [r, g, b]}, or {\"suns\": [..]} of such";
        fault(format!("expected {form}; {error}"))
    })?;
    let records = match records {
        Records::Many { suns } => suns,
        Records::One(sun) => vec![sun],
    };
    if records.len() > MAX_SUNS {
        return Err(fault(format!("expected at most {MAX_SUNS} suns, found {}", records.len())).into());
    }
    let sun = |(k, record): (usize, &SunRecord)| record.sun().map_err(|text| fault(format!("sun {k}: {text}")));
    Ok(records.iter().enumerate().map(sun).collect::<Result<_, _>>()?)
}
