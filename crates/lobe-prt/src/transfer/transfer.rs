//! Transfer vectors of matte receivers.

use lobe_sh::Rgb;

use crate::error::PrtError;
use crate::transfer::dot_rows::exit_radiance;

/// The channels of transfer: one vector or three for each receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum Channels {
    /// One vector for all colors: everything the light met is gray.
    Gray,
    /// One each for red, green and blue.
    Rgb,
}

impl Channels {
    /// 1 or 3.
    #[must_use]
    pub const fn count(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::Rgb => 3,
        }
    }
}

/// The transfer vectors of many receivers, points with a normal that send light back.
///
/// ```text
/// B = Σᵢ Lᵢ Tᵢ,    unshadowed:  Tᵢ = ρ/π ∫ max(n·s, 0) yᵢ(s) ds
/// ```
///
/// The albedo ρ is part of T, or 1 in demodulated transfer ([`AlbedoMode::None`](crate::AlbedoMode::None)); L and T are
/// expansions in the same world frame. Coefficients are finite and stored receiver by receiver, channel by channel, in
/// index order.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    order: usize,
    channels: Channels,
    coefficients: Vec<f32>,
}

impl Transfer {
    /// The highest order.
    pub const MAX_ORDER: usize = 8;

    /// Transfer of `coefficients.len() / (order² · channels)` receivers.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the order is not 1 to 8; [`PrtError::Invalid`] if the coefficients are not a whole
    /// number of receivers or not all finite.
    pub fn new(order: usize, channels: Channels, coefficients: Vec<f32>) -> Result<Self, PrtError> {
        check_order(order)?;
        check_rows("transfer", "receiver", order * order * channels.count(), &coefficients)?;
        Ok(Self { order, channels, coefficients })
    }

    /// Of an order and of finite coefficients of whole receivers.
    pub(crate) fn of_checked(order: usize, channels: Channels, coefficients: Vec<f32>) -> Self {
        Self { order, channels, coefficients }
    }

    /// Number of bands n; each vector has n² coefficients.
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
        self.coefficients.len() / self.row()
    }

    /// All coefficients: receiver by receiver, channel by channel, in index order.
    #[must_use]
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// The vector of one receiver for a channel, 0 for red; gray transfer has one for all.
    ///
    /// # Panics
    /// If there is no such receiver or the channel is above 2.
    #[must_use]
    pub fn vector(&self, receiver: usize, channel: usize) -> &[f32] {
        assert!(channel < 3, "channel {channel} of 3");
        let bands = self.order * self.order;
        let start = receiver * self.row() + channel.min(self.channels.count() - 1) * bands;
        &self.coefficients[start..start + bands]
    }

    /// The exit radiance of every receiver under a light: `B = Σᵢ Lᵢ Tᵢ` over the bands both have.
    ///
    /// `light` is the radiance of the surroundings, in the world frame, of any order. Negative values, which ringing
    /// makes, are kept. The sums are `f32`, in an order that neither the machine nor its threads change.
    ///
    /// # Panics
    /// If the light has no coefficients.
    #[must_use]
    pub fn exit_radiance(&self, light: &[Rgb<f64>]) -> Vec<Rgb<f32>> {
        let mut out = vec![Rgb::new(0.0, 0.0, 0.0); self.receivers()];
        self.exit_radiance_into(light, &mut out);
        out
    }

    /// [`Transfer::exit_radiance`] without an allocation.
    ///
    /// # Panics
    /// If the light has no coefficients, or `out` has not one place for each receiver.
    pub fn exit_radiance_into(&self, light: &[Rgb<f64>], out: &mut [Rgb<f32>]) {
        assert!(!light.is_empty(), "a light has at least one coefficient");
        exit_radiance(&self.coefficients, self.order, self.channels.count(), light, out);
    }

    /// The difference of two transfers of the same receivers, channel by channel: what lights them in `self` and not in `other`, such
    /// as the light that surfaces send each other, of [interreflected](crate::BakeMode::Interreflected) and
    /// [shadowed](crate::BakeMode::Shadowed) transfer. Its order is the lower one; it has three channels if either has.
    ///
    /// ```
    /// use lobe_prt::{Channels, Transfer};
    ///
    /// let (all, direct) = (Transfer::new(1, Channels::Rgb, vec![0.5, 0.25, 0.125])?, Transfer::new(1, Channels::Gray, vec![0.125])?);
    /// assert_eq!(all.minus(&direct)?.coefficients(), [0.375, 0.125, 0.0]);
    /// # Ok::<(), lobe_prt::PrtError>(())
    /// ```
    ///
    /// # Errors
    /// [`PrtError::Options`] unless both have as many receivers.
    pub fn minus(&self, other: &Self) -> Result<Self, PrtError> {
        if self.receivers() != other.receivers() {
            let (expected, found) = (self.receivers(), other.receivers());
            return Err(PrtError::Options(format!("expected transfer of {expected} receivers, found {found}")));
        }
        let order = self.order.min(other.order);
        let is_rgb = self.channels.count().max(other.channels.count()) == 3;
        let channels = if is_rgb { Channels::Rgb } else { Channels::Gray };
        let mut differences = Vec::with_capacity(self.receivers() * channels.count() * order * order);
        for receiver in 0..self.receivers() {
            for channel in 0..channels.count() {
                let (ours, theirs) = (self.vector(receiver, channel), other.vector(receiver, channel));
                differences.extend(ours.iter().zip(theirs).take(order * order).map(|(a, b)| a - b));
            }
        }
        Self::new(order, channels, differences)
    }

    fn row(&self) -> usize {
        self.order * self.order * self.channels.count()
    }
}

/// Refuses an order that transfer cannot have.
pub(crate) fn check_order(order: usize) -> Result<(), PrtError> {
    if (1..=Transfer::MAX_ORDER).contains(&order) {
        return Ok(());
    }
    Err(PrtError::Options(format!("expected an order of 1 to {}, found {order}", Transfer::MAX_ORDER)))
}

/// Refuses numbers that are not `row` for each of the things named `each`, or not all finite.
pub(crate) fn check_rows<T: Copy + Into<f32>>(
    place: &str,
    each: &str,
    row: usize,
    numbers: &[T],
) -> Result<(), PrtError> {
    if !numbers.len().is_multiple_of(row) {
        let message = format!("expected {row} coefficients for each {each}, found {} in all", numbers.len());
        return Err(PrtError::invalid(place, message));
    }
    if let Some(at) = numbers.iter().position(|c| !(*c).into().is_finite()) {
        let message = format!("expected finite coefficients, found {} at {each} {}", numbers[at].into(), at / row);
        return Err(PrtError::invalid(place, message));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_radiance_is_the_scalar_product_of_each_channel() {
        let transfer = Transfer::new(2, Channels::Rgb, (0..24).map(|i| i as f32).collect()).unwrap();
        let light: Vec<_> = (0..4).map(|i| Rgb::new(f64::from(i), 1.0, 0.0)).collect();
        let found = transfer.exit_radiance(&light);
        assert_eq!(found, [Rgb::new(14.0, 22.0, 0.0), Rgb::new(86.0, 70.0, 0.0)], "two receivers");
        let brief = transfer.exit_radiance(&light[..1]);
        assert_eq!(brief[1], Rgb::new(0.0, 16.0, 0.0), "a light of order 1 leaves the other bands dark");
    }

    #[test]
    fn gray_transfer_serves_all_channels() {
        let transfer = Transfer::new(1, Channels::Gray, vec![2.0]).unwrap();
        assert_eq!(transfer.exit_radiance(&[Rgb::new(1.0, 2.0, 3.0)]), [Rgb::new(2.0, 4.0, 6.0)], "one vector");
    }

    #[test]
    fn what_is_no_transfer_is_refused_in_one_line() {
        let refusal = |order, coefficients| Transfer::new(order, Channels::Gray, coefficients).unwrap_err().to_string();
        assert_eq!(refusal(9, vec![]), "expected an order of 1 to 8, found 9", "order");
        assert_eq!(
            refusal(2, vec![0.0; 5]),
            "transfer: expected 4 coefficients for each receiver, found 5 in all",
            "count"
        );
        let found = refusal(1, vec![0.0, f32::NAN]);
        assert_eq!(found, "transfer: expected finite coefficients, found NaN at receiver 1", "NaN");
    }
}
