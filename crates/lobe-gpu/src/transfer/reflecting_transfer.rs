//! Transfer with its part without reflections, row by row.

use lobe_prt::Transfer;

use crate::error::GpuError;
use crate::lookup::basis::check_order;

/// Transfer, and if there is any, its part without reflections of the same receivers. For shaders a row of both is
/// one vector of twice the length, lit by two expansions behind each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReflectingTransfer<'a> {
    whole: &'a Transfer,
    direct: Option<&'a Transfer>,
}

impl<'a> ReflectingTransfer<'a> {
    pub(crate) fn new(whole: &'a Transfer, direct: Option<&'a Transfer>) -> Result<Self, GpuError> {
        check_order(whole.order())?;
        let shape = |transfer: &Transfer| (transfer.receivers(), transfer.order());
        match direct.map(shape).filter(|found| *found != shape(whole)) {
            None => Ok(Self { whole, direct }),
            Some((receivers, order)) => Err(GpuError::Options(format!(
                "expected transfer without reflections of {} receivers and order {}, found {receivers} of order {order}",
                whole.receivers(),
                whole.order()
            ))),
        }
    }

    pub(crate) fn receivers(&self) -> usize {
        self.whole.receivers()
    }

    /// The coefficients of a channel.
    pub(crate) fn coefficients(&self) -> usize {
        self.parts().count() * self.whole.order().pow(2)
    }

    pub(crate) fn channels(&self) -> usize {
        self.parts().map(|part| part.channels().count()).max().unwrap_or(1)
    }

    /// Appends the coefficients of a channel of a receiver.
    pub(crate) fn append(&self, receiver: usize, channel: usize, out: &mut Vec<f32>) {
        for part in self.parts() {
            let (channels, count) = (part.channels().count(), part.order().pow(2));
            let first = (receiver * channels + channel.min(channels - 1)) * count;
            out.extend(&part.coefficients()[first..][..count]);
        }
    }

    fn parts(&self) -> impl Iterator<Item = &'a Transfer> {
        std::iter::once(self.whole).chain(self.direct)
    }
}
