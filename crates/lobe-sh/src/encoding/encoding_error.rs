//! How far an encoding is from the truth.

use super::{IrradianceEncoding, tangent_frame};
use crate::{Coefficient, Dir, Expansion, Rotation, even_directions};

/// Surfaces over which the error of a hemispherical encoding is averaged.
const SURFACES: usize = 32;

/// The error of an encoding over all normals and channels. The first three in units of the mean irradiance, that of
/// all channels and normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodingError {
    /// The mean of `|found - true|`.
    pub mean: f64,
    /// The root of the mean of `(found - true)²`.
    pub rms: f64,
    /// The largest `|found - true|`.
    pub max: f64,
    /// The lowest irradiance found, in the unit of the values: below zero where the encoding rings.
    pub lowest: f64,
}

/// Encodes `irradiance` and compares with its true values towards normals that cover the sphere evenly.
///
/// A hemispherical encoding is made for 32 surfaces that face evenly everywhere, and compared towards the normals within 90° of
/// each. Without values the errors are NaN; where the mean irradiance is 0 they are NaN or infinite.
#[must_use]
pub fn encoding_error<T: Coefficient>(
    encoding: IrradianceEncoding,
    irradiance: &impl Expansion<T>,
    truth: &[(Dir, T)],
) -> EncodingError {
    let channels = |value: T| (0..T::CHANNELS).map(move |c| value.widen().channel(c));
    let count = (truth.len() * T::CHANNELS) as f64;
    let unit = truth.iter().flat_map(|(_, e)| channels(*e)).sum::<f64>() / count;
    let frames = match encoding.is_hemispherical() {
        true => even_directions(SURFACES).map(|normal| Some((normal, tangent_frame(normal)))).collect(),
        false => vec![None],
    };
    let (mut sum, mut squares, mut terms) = (0.0, 0.0, 0_usize);
    let (mut max, mut lowest) = (0.0, f64::INFINITY);
    for surface in frames {
        let encoded = encoding.encode(irradiance, surface.map_or(Rotation::IDENTITY, |(_, frame)| frame));
        for (n, expected) in truth.iter().filter(|(n, _)| surface.is_none_or(|(normal, _)| n.dot(normal) >= 0.0)) {
            for (a, b) in channels(encoded.eval(*n)).zip(channels(*expected)) {
                let error = (a - b).abs();
                sum += error;
                squares += error * error;
                terms += 1;
                // NaN is larger than anything.
                max = if error.is_nan() || error > max { error } else { max };
                lowest = if a.is_nan() || a < lowest { a } else { lowest };
            }
        }
    }
    let terms = terms as f64;
    EncodingError { mean: sum / terms / unit, rms: (squares / terms).sqrt() / unit, max: max / unit, lowest }
}
