//! How the rooms map tones.

use lobe::image::{Exposure, Picture, Tone};

/// The exposure that fits a picture of light.
pub(crate) fn fitting(picture: &Picture) -> f64 {
    Tone::PHOTOGRAPH.exposure.factor(picture)
}

/// The curve of photographs at so many stops above the exposure that fits the picture it is applied to.
pub(crate) fn photograph_of_any(stops: f64) -> Tone {
    let Exposure::LogAverage { key } = Tone::PHOTOGRAPH.exposure else { return Tone::PHOTOGRAPH };
    Tone { exposure: Exposure::LogAverage { key: key * stops.exp2() }, ..Tone::PHOTOGRAPH }
}

/// The curve of photographs at an exposure, so many stops above one that fits.
pub(crate) fn photograph(fitting: f64, stops: f64) -> Tone {
    Tone { exposure: Exposure::Fixed(fitting * stops.exp2()), ..Tone::PHOTOGRAPH }
}
