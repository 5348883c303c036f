//! Tone mapping of the rooms.

use lobe::image::{Curve, Exposure, Picture, Tone};
use lobe::sh::{Coefficient as _, Rgb};

/// The light that a tone mapping of a fixed exposure shows as this display light, linear and within the gamut.
///
/// Reinhard's curve has `y' = y (1 + y/w²) / (1 + y)`, of which this is the root of `y²/w² + (1 - y') y - y' = 0`.
pub(crate) fn shown_as(tone: &Tone, display: Rgb<f64>) -> Rgb<f64> {
    let exposure = if let Exposure::Fixed(factor) = tone.exposure { factor } else { 1.0 };
    let shown = display.luminance();
    let compressed = match tone.curve {
        Curve::Clip => 1.0,
        // Black is black before and after.
        Curve::Reinhard { .. } if shown <= 0.0 => 1.0,
        Curve::Reinhard { white } => {
            let (a, b) = (1.0 / (white * white), 1.0 - shown);
            // Without cancellation for small shown, and for a small a.
            let y = 2.0 * shown / (b + (b * b + 4.0 * a * shown).sqrt());
            y / shown
        }
    };
    display.scale(compressed / exposure)
}

/// The exposure that fits a picture of light.
pub(crate) fn fitting(picture: &Picture) -> f64 {
    Tone::PHOTOGRAPH.exposure.factor(picture)
}

/// The curve of photographs at `stops` stops above the exposure that fits the picture it is applied to.
pub(crate) fn photograph_of_any(stops: f64) -> Tone {
    let Exposure::LogAverage { key } = Tone::PHOTOGRAPH.exposure else { return Tone::PHOTOGRAPH };
    Tone { exposure: Exposure::LogAverage { key: key * stops.exp2() }, ..Tone::PHOTOGRAPH }
}

/// The curve of photographs at an exposure, `stops` stops above one that fits.
pub(crate) fn photograph(fitting: f64, stops: f64) -> Tone {
    Tone { exposure: Exposure::Fixed(fitting * stops.exp2()), ..Tone::PHOTOGRAPH }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_display_color_made_light_is_shown_as_itself_by_every_tone() {
        let tones = [photograph(0.3, 0.0), photograph(20.0, -4.0), photograph(1e-3, 6.0), Tone::PLAIN];
        for tone in tones {
            for bytes in [[27_u8; 3], [248; 3], [0; 3], [255; 3], [30, 60, 90]] {
                let display = bytes.map(|byte| lobe::image::srgb_decode(f64::from(byte) / 255.0));
                let light = <[f64; 3]>::from(shown_as(&tone, Rgb::from(display))).map(|c| c as f32);
                let shown = tone.to_bytes(&Picture::filled(1, 1, light));
                assert_eq!(shown, bytes, "{tone:?}");
            }
        }
    }
}
