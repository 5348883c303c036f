//! Tone mapping of the rooms.

use lobe::image::{Curve, Exposure, Picture, Tone};
use lobe::sh::{Coefficient as _, Rgb};

/// The most steps towards light that shows a color.
const MOST_STEPS: usize = 60;

/// A color that is shown so nearly is that color: a fifth of the least step of bytes.
const NEAR: f64 = 6e-5;

/// The light that a tone mapping of a fixed exposure shows as this display light, linear and within the gamut; light that is
/// shown nearly so where the curve has no such color, as of white by `AgX`.
pub(crate) fn shown_as(tone: &Tone, display: Rgb<f64>) -> Rgb<f64> {
    let exposure = if let Exposure::Fixed(factor) = tone.exposure { factor } else { 1.0 };
    let target = display.to_array();
    // Each channel rises with its own light most: brighten and dim each by what it lacks.
    let mut light = target.map(|c| c.max(1e-4));
    for _ in 0..MOST_STEPS {
        let shown = tone.curve.apply(light);
        if shown.iter().zip(&target).all(|(shown, target)| (shown - target).abs() < NEAR) {
            break;
        }
        let slope = |k: usize| {
            let mut brighter = light;
            brighter[k] *= 1.0 + 1e-4;
            ((tone.curve.apply(brighter)[k] - shown[k]) / (1e-4 * light[k])).max(1e-3)
        };
        light = [0, 1, 2].map(|k| {
            let step = (target[k] - shown[k]) / slope(k);
            (light[k] + step).clamp(0.25 * light[k], 4.0 * light[k]).min(1e4)
        });
    }
    Rgb::from(light).scale(1.0 / exposure)
}

/// The exposure that fits a picture of light.
pub(crate) fn fitting(picture: &Picture) -> f64 {
    Tone::PHOTOGRAPH.exposure.factor(picture)
}

/// How light is shown: stops above the exposure that fits it, and the tone curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Look {
    pub(crate) stops: f64,
    pub(crate) curve: Curve,
}

impl Look {
    /// The tone mapping of light that `fitting` fits.
    pub(crate) fn of(self, fitting: f64) -> Tone {
        Tone { exposure: Exposure::Fixed(fitting * self.stops.exp2()), curve: self.curve }
    }

    /// The tone mapping of any picture, which fits itself.
    pub(crate) fn of_any(self) -> Tone {
        match Tone::PHOTOGRAPH.exposure {
            Exposure::LogAverage { key } => {
                Tone { exposure: Exposure::LogAverage { key: key * self.stops.exp2() }, curve: self.curve }
            }
            exposure => Tone { exposure, curve: self.curve },
        }
    }

    /// Numbers that differ for different looks.
    pub(crate) fn key(self) -> Vec<u64> {
        vec![self.stops.to_bits(), Curve::ALL.iter().position(|curve| *curve == self.curve).unwrap_or(0) as u64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_display_color_made_light_is_shown_as_itself_by_every_tone() {
        let look = |stops: f64, curve: Curve| Look { stops, curve };
        let of_reinhard = [look(0.0, Curve::REINHARD).of(0.3), look(-4.0, Curve::REINHARD).of(20.0)];
        let tones = of_reinhard.into_iter().chain(Curve::ALL.map(|curve| look(6.0, curve).of(1e-3)));
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
