//! Lamps in descriptions of scenes: a sphere, a rectangle, or a file of `lobe lamp`, with its place over time.
//!
//! ```json
//! { "name": "bulb", "radius": 0.2, "radiance": [9, 8, 7], "keys": [ { "translation": [0, 0, 3] } ] }
//! { "name": "panel", "size": [2, 1], "radiance": [5, 5, 5], "two_sided": true }
//! { "name": "screen", "file": "screen.safetensors" }
//! ```

use std::path::PathBuf;

use lobe_sh::Rgb;
use serde::Deserialize;

use crate::error::ShadowError;
use crate::field::lamp_surface::{LampSurface, Rectangle};
use crate::track::Track;
use crate::track_json::{KeyJson, LARGEST, SCALES, track_of};

/// The most lamps: each lights every receiver by itself, and one of a rectangle takes a table of a megabyte or more.
pub(crate) const MAX_LAMPS: usize = 256;

/// A lamp of a [`SceneDescription`](crate::SceneDescription).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LampDescription {
    /// The name in messages.
    pub name: String,
    /// What shines.
    pub source: LampSource,
    /// Its place over time.
    pub track: Track,
}

/// What shines.
#[derive(Clone, Debug, PartialEq)]
pub enum LampSource {
    /// A file of [`write_lamp`](crate::write_lamp).
    File(PathBuf),
    /// A surface of one radiance.
    Surface(LampSurface),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LampJson {
    pub(crate) name: String,
    #[serde(default)]
    file: Option<String>,
    #[serde(default)]
    radius: Option<f64>,
    #[serde(default)]
    size: Option<[f64; 2]>,
    #[serde(default)]
    radiance: Option<[f64; 3]>,
    #[serde(default)]
    two_sided: bool,
    #[serde(default)]
    keys: Vec<KeyJson>,
}

impl LampJson {
    /// The lamp of that name, whose file `file` finds.
    pub(crate) fn described(
        &self,
        name: String,
        file: impl Fn(&str) -> Result<PathBuf, ShadowError>,
        invalid: impl Fn(String) -> ShadowError,
    ) -> Result<LampDescription, ShadowError> {
        let track = track_of(&self.keys).map_err(&invalid)?;
        let source = match (&self.file, self.surface().map_err(&invalid)?) {
            (Some(given), None) => LampSource::File(file(given)?),
            (None, Some(surface)) => LampSource::Surface(surface),
            _ => return Err(invalid("expected one of `file`, `radius` and `size`, found none or several".to_owned())),
        };
        Ok(LampDescription { name, source, track })
    }

    /// The surface that is given by its numbers.
    fn surface(&self) -> Result<Option<LampSurface>, String> {
        let length = |what: &str, length: f64| match (SCALES[0]..=SCALES[1]).contains(&length) {
            true => Ok(length),
            false => Err(format!("expected a {what} from {:e} to {:e}, found {length:e}", SCALES[0], SCALES[1])),
        };
        let radiance = self.radiance.unwrap_or([1.0; 3]);
        let color = Rgb::from(radiance);
        let surface = match (self.radius, self.size) {
            (None, None) => match self.radiance.is_some() || self.two_sided {
                true => return Err("expected `radiance` and `two_sided` beside a `radius` or a `size`".to_owned()),
                false => return Ok(None),
            },
            (Some(_), Some(_)) => {
                return Err("expected one of `file`, `radius` and `size`, found several".to_owned());
            }
            (Some(_), None) if self.two_sided => {
                return Err("expected `two_sided` beside a `size`, found a sphere, which has one side".to_owned());
            }
            (Some(radius), None) => LampSurface::ball(length("radius", radius)?, color),
            (None, Some([width, height])) => {
                let size = [length("width", width)?, length("height", height)?];
                LampSurface::rectangle(Rectangle::upright(size, self.two_sided), color)
            }
        };
        match radiance.iter().all(|c| (0.0..=LARGEST).contains(c)) {
            true => Ok(Some(surface)),
            false => Err(format!("expected a radiance from 0 to {LARGEST:e} in each channel, found {radiance:?}")),
        }
    }
}
