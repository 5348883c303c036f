//! Options of the tone mapping of pictures for display.

use lobe_image::{Curve, Exposure, Picture, Tone};
use lobe_io::{Given, JobOptions, NumberRange, OptionError, OptionField, OptionKind, options};
use serde::{Deserialize, Deserializer, Serializer};

/// The most stops of an exposure, of either sign: single precision, in which devices compute, has 126.
const MOST_STOPS: f64 = 100.0;

options! {
    /// How light becomes a .png.
    pub struct ToneOptions {
        /// The exposure of a .png in stops, -100 to 100: light is multiplied by 2^STOPS before it is tone-mapped
        exposure: Option<f64> = None, OptionKind::Number(NumberRange::Finite), "STOPS",
            "as suits the picture, of several the first one";
        /// The tone curve of a .png
        #[serde(serialize_with = "by_name", deserialize_with = "of_name")]
        tone: Curve = Curve::default(), OptionKind::Name(&Curve::NAMES), "CURVE", "";
    }
}

fn by_name<S: Serializer>(curve: &Curve, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(curve.name())
}

fn of_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Curve, D::Error> {
    let name = String::deserialize(deserializer)?;
    Curve::from_name(&name).ok_or_else(|| serde::de::Error::custom(format!("no tone curve is named {name:?}")))
}

impl JobOptions for ToneOptions {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }

    fn check_together(&self, _given: &Given<'_>) -> Result<(), OptionError> {
        match self.exposure {
            Some(stops) if stops.abs() > MOST_STOPS => Err(OptionError::new(
                "exposure",
                format!("expected -{MOST_STOPS} to {MOST_STOPS} stops, found {stops}"),
            )),
            _ => Ok(()),
        }
    }
}

impl ToneOptions {
    /// The tone mapping, whose exposure suits the picture that it is applied to unless one was asked for.
    #[must_use]
    pub fn of_any(&self) -> Tone {
        let curve = Tone { curve: self.tone, ..Tone::PHOTOGRAPH };
        match self.exposure {
            Some(stops) => Tone { exposure: Exposure::Fixed(stops.exp2()), ..curve },
            None => curve,
        }
    }

    /// The tone mapping of all pictures, given the first one.
    #[must_use]
    pub fn of_first(&self, first: &Picture) -> Tone {
        self.of_any().fixed_for(first)
    }
}
