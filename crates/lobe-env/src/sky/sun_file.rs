//! Files of suns: JSON, as `lobe env sun --json` prints it.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use lobe_io::{IoError, expect_file};
use lobe_sh::Dir;
use serde::{Deserialize, Serialize};

use crate::error::EnvError;
use crate::sky::sun_choice::SunChoice;
use crate::sky::sun_extraction::Sun;

/// The most bytes of a file: a thousand for each sun, of which a printed one has a quarter.
const MAX_BYTES: u64 = 1000 * SunChoice::MAX as u64;

/// Some editors begin a text with it.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The angular diameter of the sun, in degrees, as seen from the Earth at its mean distance: 1919 arc seconds.
const SUN: f64 = 1919.0 / 3600.0;

/// A sun in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SunRecord {
    /// Towards it, of any length.
    pub direction: [f64; 3],
    /// The irradiance of a surface that faces it, without 1/π.
    pub irradiance: [f64; 3],
    /// The radiance of its disc; it follows from the others.
    #[serde(default)]
    pub radiance: [f64; 3],
    /// The diameter of its disc in degrees; that of the sun unless a file says otherwise.
    #[serde(default = "diameter_of_the_sun")]
    pub diameter: f64,
    /// The texels that were changed in the map from which it was taken.
    #[serde(default)]
    pub texels: usize,
}

/// A list of suns.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Records {
    suns: Vec<SunRecord>,
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
    /// A sun in this direction, whose disc has this diameter in degrees.
    #[must_use]
    pub fn new(direction: [f64; 3], irradiance: [f64; 3], diameter: f64) -> Self {
        Self { direction, irradiance, radiance: [0.0; 3], diameter, texels: 0 }
    }

    /// The sun, by its direction, irradiance and diameter.
    ///
    /// # Errors
    /// [`EnvError::Options`] without a direction, with an irradiance below 0, or with a diameter that is not above 0
    /// and below 180 degrees.
    pub fn sun(&self) -> Result<Sun, EnvError> {
        self.checked().map_err(EnvError::Options)
    }

    fn checked(&self) -> Result<Sun, String> {
        let direction = Dir::new(self.direction).ok_or_else(|| {
            let [x, y, z] = self.direction;
            format!("expected a direction, found {x},{y},{z}")
        })?;
        let [r, g, b] = self.irradiance;
        if ![r, g, b].iter().all(|c| c.is_finite() && *c >= 0.0) {
            return Err(format!("expected an irradiance of at least 0, found {r},{g},{b}"));
        }
        if !(self.diameter > 0.0 && self.diameter < 180.0) {
            return Err(format!("expected a diameter above 0 and below 180 degrees, found {}", self.diameter));
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
    let form = "{\"direction\": [x, y, z], \"irradiance\": [r, g, b]}, or {\"suns\": [..]} of such";
    let other = |error: serde_json::Error| fault(format!("expected {form}; {error}"));
    let found: serde_json::Value =
        serde_json::from_slice(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes)).map_err(other)?;
    let records = match found.get("suns") {
        Some(_) => serde_json::from_value::<Records>(found).map_err(other)?.suns,
        None => vec![serde_json::from_value(found).map_err(other)?],
    };
    if records.len() > SunChoice::MAX {
        let most = SunChoice::MAX;
        return Err(fault(format!("expected at most {most} suns, found {}", records.len())).into());
    }
    let sun = |(k, record): (usize, &SunRecord)| record.checked().map_err(|text| fault(format!("sun {k}: {text}")));
    Ok(records.iter().enumerate().map(sun).collect::<Result<_, _>>()?)
}
