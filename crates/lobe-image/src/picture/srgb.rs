//! sRGB transfer function.

/// Encodes linear light in `[0, 1]` for display.
///
/// ```text
///   V = 12.92 L                     L <= 0.0031308
///   V = 1.055 L^(1/2.4) - 0.055     otherwise
/// ```
///
/// IEC 61966-2-1. The two pieces differ by 2e-8 at the joint. Outside `[0, 1]` the formula is extended; the
/// writer of files clamps.
#[must_use]
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Decodes a display value in `[0, 1]` to linear light: the inverse of [`srgb_encode`].
///
/// ```text
///   L = V / 12.92                      V <= 0.04045
///   L = ((V + 0.055) / 1.055)^2.4      otherwise
/// ```
#[must_use]
pub fn srgb_decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_bit_value_survives_the_round_trip() {
        for v in 0..=255_u8 {
            let back = (srgb_encode(srgb_decode(f64::from(v) / 255.0)) * 255.0).round() as u8;
            assert_eq!(back, v, "decoded and encoded");
        }
    }

    #[test]
    fn the_transfer_function_is_continuous_and_reaches_one() {
        let (below, above) = (srgb_encode(0.0031308), srgb_encode(0.0031308_f64.next_up()));
        assert!((below - above).abs() < 1e-7, "joint: {below} and {above}");
        assert!((srgb_encode(1.0) - 1.0).abs() < 1e-15, "white: {}", srgb_encode(1.0));
        // Middle gray of 8-bit displays: 128 is 21.586 % light.
        assert!((srgb_decode(128.0 / 255.0) - 0.215861).abs() < 1e-6, "{}", srgb_decode(128.0 / 255.0));
    }
}
