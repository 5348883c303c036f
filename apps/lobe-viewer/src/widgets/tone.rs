//! How the rooms map tones.

use lobe::image::{Exposure, Picture, Tone};

/// The exposure that fits a picture of light.
pub(crate) fn fitting(picture: &Picture) -> f64 {
    Tone::PHOTOGRAPH.exposure.factor(picture)
}

/// The curve of photographs at an exposure, so many stops above one that fits.
pub(crate) fn photograph(fitting: f64, stops: f64) -> Tone {
    Tone { exposure: Exposure::Fixed(fitting * stops.exp2()), ..Tone::PHOTOGRAPH }
}
