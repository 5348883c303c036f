//! One number for a coefficient of any kind.

use crate::{Coefficient, Rgb, ShVec};

/// What channel `c` contributes to the luminance: that of [`Rgb::luminance`], 1 if there is one channel.
pub(crate) fn luminance_weight<T: Coefficient>(c: usize) -> f64 {
    if T::CHANNELS == 1 {
        return 1.0;
    }
    Rgb::<f64>::from_channels(|k| f64::from(u8::from(k == c))).luminance()
}

/// A color's relative luminance; a number is its own.
pub(crate) fn luminance<W: Coefficient<Scalar = f64>>(value: W) -> f64 {
    (0..W::CHANNELS).map(|c| luminance_weight::<W>(c) * value.channel(c)).sum()
}

/// The luminance of every coefficient.
pub(crate) fn luminance_of<W: Coefficient<Scalar = f64>>(f: &ShVec<W>) -> ShVec<f64> {
    f.map(luminance)
}
