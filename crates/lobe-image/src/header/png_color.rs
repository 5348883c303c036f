//! The color of PNG pictures: how stored values become light, and whose primaries they are.
//!
//! Of the chunks that say so, `cICP` holds before `iCCP`, that before `sRGB`, and that before `gAMA` and `cHRM`, as the third edition of
//! PNG has it. The numbers of `cICP` are those of ITU-T H.273, tables 2 and 3.

use std::fmt;

use png::{CodingIndependentCodePoints, Info, ScaledFloat};

use crate::error::ImageError;
use crate::header::decoded::unsupported;
use crate::header::icc::Profile;
use crate::picture::primaries::Primaries;
use crate::picture::srgb::srgb_decode;

/// The parts of 1 in which `gAMA` and `cHRM` count.
const SCALE: f64 = 1e5;

/// The `gAMA` of sRGB, 1/2.2. It stands for the curve of sRGB and not for the power.
const SRGB_GAMMA: u32 = 45455;

/// Files round 1/2.2 to as few as two digits, 0.45.
const ROUNDING: u32 = 455;

/// The number of what is not specified, for primaries and for transfer functions.
const UNSPECIFIED: u8 = 2;

/// The luminance of diffuse white in pictures by PQ and HLG, in cd/m² [ITU 2023]. It becomes 1.
pub(crate) const DIFFUSE_WHITE: f64 = 203.0;

/// The command that makes linear light, in which diffuse white is 1, of a picture that is not read.
pub(crate) fn to_linear_light(picture: &str) -> String {
    format!("`ffmpeg -i {picture} -vf zscale=t=linear:npl={DIFFUSE_WHITE},format=gbrpf32le OUT.exr`")
}

const D65: [f64; 2] = [0.3127, 0.3290];

/// How a stored value, as a part of the largest, becomes light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Transfer {
    Srgb,
    /// The curve of cameras of Rec. 709, BT.601 and BT.2020, which is one.
    Rec709,
    /// A power, 1 for linear light, and the chunk that says so.
    Power {
        exponent: f64,
        chunk: &'static str,
    },
}

impl Transfer {
    /// What the chunks of a picture say; `name` stands for the file in messages.
    pub(crate) fn of_png(info: &Info<'_>, name: &str) -> Result<Self, ImageError> {
        if let Some(points) = info.coding_independent_code_points
            && let Some(transfer) = Self::of_code_points(points, name)?
        {
            return Ok(transfer);
        }
        // Of a picture with the chunk sRGB the library tells the gamma of sRGB. The one beside a profile is that of the profile.
        let gamma = info.gamma().filter(|_| info.icc_profile.is_none());
        Ok(match gamma.map(ScaledFloat::into_scaled) {
            Some(gamma) if gamma.abs_diff(SRGB_GAMMA) > ROUNDING => {
                Self::Power { exponent: SCALE / f64::from(gamma), chunk: "gAMA" }
            }
            _ => Self::Srgb,
        })
    }

    /// What `cICP` says; none if it leaves it open.
    fn of_code_points(points: CodingIndependentCodePoints, name: &str) -> Result<Option<Self>, ImageError> {
        if !points.is_video_full_range_image {
            let message = "the chunk cICP says that black and white have the values of video (narrow range), which is not read; \
                           save it with full range";
            return Err(unsupported(name, message.into()));
        }
        let power = |exponent| Self::Power { exponent, chunk: "cICP" };
        let curve = match points.transfer_function {
            UNSPECIFIED => return Ok(None),
            1 | 6 | 14 | 15 => return Ok(Some(Self::Rec709)),
            4 => return Ok(Some(power(2.2))),
            5 => return Ok(Some(power(2.8))),
            8 => return Ok(Some(power(1.0))),
            13 => return Ok(Some(Self::Srgb)),
            16 => "PQ".to_owned(),
            18 => "HLG".to_owned(),
            other => format!("the transfer function {other} of ITU-T H.273"),
        };
        let message = format!(
            "the chunk cICP says that light is encoded by {curve}, which is not read; convert it to linear light: {}",
            to_linear_light("IN.png")
        );
        Err(unsupported(name, message))
    }

    /// The light of a value, both of `[0, 1]`.
    ///
    /// ```text
    ///   Rec. 709   L = V / 4.5                            V < 0.081
    ///              L = ((V + 0.099) / 1.099)^(1/0.45)     otherwise
    /// ```
    pub(crate) fn light(self, value: f64) -> f64 {
        match self {
            Self::Srgb => srgb_decode(value),
            Self::Rec709 if value < 0.081 => value / 4.5,
            Self::Rec709 => ((value + 0.099) / 1.099).powf(1.0 / 0.45),
            Self::Power { exponent, .. } => value.powf(exponent),
        }
    }
}

impl fmt::Display for Transfer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Srgb => f.write_str("decoded from sRGB"),
            Self::Rec709 => f.write_str("decoded by the curve of Rec. 709 as the chunk cICP says"),
            Self::Power { exponent, chunk } => {
                if exponent == 1.0 {
                    return write!(f, "of linear light as the chunk {chunk} says");
                }
                // The inverse of five digits has no more.
                let exponent = (exponent * 1e4).round() / 1e4;
                write!(f, "decoded by the power {exponent} as the chunk {chunk} says")
            }
        }
    }
}

/// Whether `cICP` tells the transfer function.
pub(crate) fn has_coded_transfer(info: &Info<'_>) -> bool {
    info.coding_independent_code_points.is_some_and(|points| points.transfer_function != UNSPECIFIED)
}

/// What a picture says of its primaries: they, with what tells them in messages, or the name of what cannot be
/// understood. `cICP` holds before the profile, where it does not leave them open, and that before `cHRM`.
pub(crate) fn primaries_of_png(
    info: &Info<'_>,
    profile: Option<&Option<Profile>>,
) -> Option<Result<(&'static str, Primaries), String>> {
    let number = info.coding_independent_code_points.map_or(UNSPECIFIED, |points| points.color_primaries);
    if number == UNSPECIFIED {
        if let Some(profile) = profile {
            let known = profile.as_ref().map(|profile| ("the primaries of the color profile", profile.primaries));
            return Some(known.ok_or_else(|| "the color profile".to_owned()));
        }
        let chunk = info.chromaticities()?;
        let [red, green, blue, white] = [chunk.red, chunk.green, chunk.blue, chunk.white]
            .map(|(x, y)| [x, y].map(|coordinate| f64::from(coordinate.into_scaled()) / SCALE));
        let known =
            Primaries::new(red, green, blue, white).map(|primaries| ("the primaries of the chunk cHRM", primaries));
        return Some(known.ok_or_else(|| "the chunk cHRM".to_owned()));
    }
    let known = of_number(number).map(|primaries| ("the primaries of the chunk cICP", primaries));
    Some(known.ok_or_else(|| format!("the number {number} of primaries of the chunk cICP")))
}

/// Primaries by their number in ITU-T H.273.
fn of_number(number: u8) -> Option<Primaries> {
    let [red, green, blue, white] = match number {
        1 => return Some(Primaries::REC_709),
        // The television of half of the world, and of the other.
        5 => [[0.64, 0.33], [0.29, 0.60], [0.15, 0.06], D65],
        6 | 7 => [[0.630, 0.340], [0.310, 0.595], [0.155, 0.070], D65],
        // BT.2020.
        9 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65],
        // P3 of cinemas, and of displays.
        11 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.314, 0.351]],
        12 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65],
        _ => return None,
    };
    Primaries::new(red, green, blue, white)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_of_rec_709_is_continuous_and_reaches_one() {
        let (below, above) = (Transfer::Rec709.light(0.081_f64.next_down()), Transfer::Rec709.light(0.081));
        // The digits of the standard join to four places.
        assert!((below - above).abs() < 1e-4, "joint: {below} and {above}");
        assert!((Transfer::Rec709.light(1.0) - 1.0).abs() < 1e-15, "white: {}", Transfer::Rec709.light(1.0));
    }

    #[test]
    fn extreme_powers_stay_within_black_and_white() {
        for gamma in [1, u32::MAX] {
            let power = Transfer::Power { exponent: SCALE / f64::from(gamma), chunk: "gAMA" };
            let lights = [0.0, 1.0 / 65535.0, 0.5, 1.0].map(|value| power.light(value));
            assert!(lights[0] == 0.0 && lights[3] == 1.0, "{gamma}: {lights:?}");
            assert!(lights.is_sorted() && lights.iter().all(|light| light.is_finite()), "{gamma}: {lights:?}");
        }
    }
}
