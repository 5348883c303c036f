//! Transfer vectors kept in 16 bits.

use half::f16;
use half::slice::HalfFloatSliceExt as _;
use lobe_sh::Rgb;

use crate::error::PrtError;
use crate::transfer::dot_rows::exit_radiance;
use crate::transfer::transfer::{Channels, Transfer};
use crate::transfer::transfer::{check_order, check_rows};

/// [`Transfer`] whose coefficients are rounded to 16 bits: half of the memory, on disk and in use. Where 32 bits take 3.1 ns for each gray
/// receiver of order 4 these take 3.4, in color 7.0 and 7.0 (one thread, AVX2 on a machine that reads 31 GB/s; `lobe-bench transfer transfer-rgb
/// transfer-f16 transfer-f16-rgb`).
///
/// ```text
///   |T' - T| <= 2⁻¹¹ |T| + 2⁻²⁵
/// ```
///
/// for each coefficient: IEEE 754's binary16 has 11 binary digits, below 2⁻¹⁴ fewer.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfTransfer {
    order: usize,
    channels: Channels,
    coefficients: Vec<f16>,
}

impl HalfTransfer {
    /// Each coefficient rounded to the nearest, and what that lost and saved.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if one is 65520 or larger, which is rounded to infinity.
    pub fn new(transfer: &Transfer) -> Result<(Self, HalfReport), PrtError> {
        let mut coefficients = vec![f16::ZERO; transfer.coefficients().len()];
        coefficients.convert_from_f32_slice(transfer.coefficients());
        if let Some(at) = coefficients.iter().position(|c| c.is_infinite()) {
            let row = transfer.order() * transfer.order() * transfer.channels().count();
            let found = transfer.coefficients()[at];
            let message = format!("expected coefficients below 65520 in size, found {found} at receiver {}", at / row);
            return Err(PrtError::invalid("transfer of 16 bits", message));
        }
        let halves = Self::from_coefficients(transfer.order(), transfer.channels(), coefficients)?;
        let report = HalfReport::new(&halves.coefficients, transfer.coefficients());
        Ok((halves, report))
    }

    /// Of coefficients in the order of [`Transfer`].
    ///
    /// # Errors
    /// As [`Transfer::new`].
    pub fn from_coefficients(order: usize, channels: Channels, coefficients: Vec<f16>) -> Result<Self, PrtError> {
        check_order(order)?;
        check_rows("transfer of 16 bits", "receiver", order * order * channels.count(), &coefficients)?;
        Ok(Self { order, channels, coefficients })
    }

    /// Number of bands n.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The channels: one vector or three for each receiver.
    #[must_use]
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// Number of receivers.
    #[must_use]
    pub fn receivers(&self) -> usize {
        self.coefficients.len() / (self.order * self.order * self.channels.count())
    }

    /// All coefficients, in the order of [`Transfer::coefficients`].
    #[must_use]
    pub fn coefficients(&self) -> &[f16] {
        &self.coefficients
    }

    /// The same numbers in 32 bits.
    #[must_use]
    pub fn to_transfer(&self) -> Transfer {
        Transfer::of_checked(self.order, self.channels, self.coefficients.to_f32_vec())
    }

    /// The exit radiance of every receiver under a light, to the bit that of [`HalfTransfer::to_transfer`]; see [`Transfer::exit_radiance`].
    ///
    /// # Panics
    /// If the light has no coefficients.
    #[must_use]
    pub fn exit_radiance(&self, light: &[Rgb<f64>]) -> Vec<Rgb<f32>> {
        let mut out = vec![Rgb::new(0.0, 0.0, 0.0); self.receivers()];
        self.exit_radiance_into(light, &mut out);
        out
    }

    /// [`HalfTransfer::exit_radiance`] without room for all of its results.
    ///
    /// # Panics
    /// If the light has no coefficients, or `out` has not one place for each receiver.
    pub fn exit_radiance_into(&self, light: &[Rgb<f64>], out: &mut [Rgb<f32>]) {
        assert!(!light.is_empty(), "a light has at least one coefficient");
        exit_radiance(&self.coefficients, self.order, self.channels.count(), light, out);
    }
}

/// What rounding transfer to 16 bits lost and saved.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct HalfReport {
    /// The RMS of what changed over that of the coefficients; 0 where both are 0.
    pub relative_error: f64,
    /// Bytes before, four a number.
    pub bytes_before: usize,
    /// Bytes after.
    pub bytes: usize,
    /// Bytes before for each byte after.
    pub ratio: f64,
}

impl HalfReport {
    fn new(halves: &[f16], exact: &[f32]) -> Self {
        let (mut error, mut all) = (0.0, 0.0);
        for (found, exact) in halves.iter().zip(exact) {
            let exact = f64::from(*exact);
            error += (f64::from(*found) - exact).powi(2);
            all += exact * exact;
        }
        let relative_error = if all > 0.0 { (error / all).sqrt() } else { 0.0 };
        let (bytes_before, bytes) = (size_of_val(exact), size_of_val(halves));
        Self { relative_error, bytes_before, bytes, ratio: bytes_before as f64 / bytes as f64 }
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn coefficients_are_rounded_within_their_bound_and_zero_stays_zero() {
        let mut random = Random::new(1);
        let mut numbers: Vec<f32> = random.signed_vec(3 * 16 * 500).iter().map(|x| *x as f32).collect();
        for (k, number) in numbers.iter_mut().enumerate() {
            *number *= [1.0, 1e-3, 1e-6, 6e4, 0.0][k % 5];
        }
        let transfer = Transfer::new(4, Channels::Rgb, numbers).unwrap();
        let (halves, report) = HalfTransfer::new(&transfer).unwrap();
        for (found, exact) in halves.to_transfer().coefficients().iter().zip(transfer.coefficients()) {
            let bound = 2.0_f32.powi(-11) * exact.abs() + 2.0_f32.powi(-25);
            assert!((found - exact).abs() <= bound, "{exact} became {found}");
        }
        let error = report.relative_error;
        assert!(error > 1e-5 && error < 2.0_f64.powi(-11), "the error of all is {error}");
        let bytes = 2 * transfer.coefficients().len();
        assert_eq!((report.bytes_before, report.bytes, report.ratio), (2 * bytes, bytes, 2.0));
        let black = Transfer::new(1, Channels::Gray, vec![0.0; 3]).unwrap();
        assert_eq!(HalfTransfer::new(&black).unwrap().1.relative_error, 0.0, "of nothing");
    }

    #[test]
    fn it_is_lit_as_its_numbers_in_32_bits_are() {
        let mut random = Random::new(2);
        for order in 1..=8 {
            for (channels, count) in
                [(Channels::Gray, 0), (Channels::Gray, 5000), (Channels::Rgb, 1), (Channels::Rgb, 4100)]
            {
                let width = order * order * channels.count();
                let numbers = random.signed_vec(width * count).iter().map(|x| *x as f32).collect();
                let (halves, _) = HalfTransfer::new(&Transfer::new(order, channels, numbers).unwrap()).unwrap();
                let light: Vec<Rgb<f64>> =
                    (0..order * order).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect();
                let expected = halves.to_transfer().exit_radiance(&light);
                assert!(halves.exit_radiance(&light) == expected, "order {order}, {channels:?}, {count} receivers");
            }
        }
    }

    #[test]
    fn what_has_no_place_in_16_bits_is_refused_in_one_line() {
        let large = Transfer::new(1, Channels::Gray, vec![0.5, -70000.0]).unwrap();
        let message = HalfTransfer::new(&large).unwrap_err().to_string();
        assert_eq!(
            message,
            "transfer of 16 bits: expected coefficients below 65520 in size, found -70000 at receiver 1"
        );
        let largest = Transfer::new(1, Channels::Gray, vec![65519.0]).unwrap();
        assert_eq!(HalfTransfer::new(&largest).unwrap().0.to_transfer().coefficients(), [65504.0], "the largest");
        assert!(HalfTransfer::from_coefficients(9, Channels::Gray, Vec::new()).is_err(), "an order of 9");
        assert!(HalfTransfer::from_coefficients(2, Channels::Gray, vec![f16::ONE; 5]).is_err(), "not whole receivers");
    }
}
