//! Dering of many functions of three bands at once.

use alloc::vec::Vec;

use crate::basis::index::{band_range, coefficient_count};
use crate::ringing::lane_dering::SixteenFunctions;
use crate::ringing::quadratic_dering::QuadraticDeringReport;
use crate::simd::{LANES, Lanes, Machine};
use crate::{DeringOutcome, ShBatch};

/// Makes each function of a batch non-negative, as [`dering_order_3_in_place`](crate::dering_order_3_in_place) does one: a batch of numbers, or
/// three of the channels of colors, which share their factors. What it says of each function comes back in their order.
///
/// A function has the result that it has alone, whatever lies beside it: to rounding that of the code for one, or to 1e-7 of it where one of the two
/// searches takes a step more. Only where the minimum is within rounding of `-`[`DERING_ALLOWED`](crate::DERING_ALLOWED) times the mean may one of them
/// change it and the other not. A band of nothing has any factor. What is not changed keeps every bit: what is non-negative, zero,
/// not finite or without a positive mean.
///
/// ```
/// use lobe_sh::{Dir, Expansion as _, ShBatch, ShL2, dering_batch_order_3_in_place};
///
/// // The red, green and blue of a sun in a blue sky.
/// let channels = [5.0, 4.0, 2.5].map(|sun| {
///     let mut f = ShL2::<f32>::impulse(Dir::Z, sun);
///     f[0] += sun.recip();
///     f
/// });
/// let mut batches = channels.map(|f| ShBatch::from_functions(&[f]));
/// let reports = dering_batch_order_3_in_place(&mut batches);
/// assert!(reports[0].factors[2] < 0.8, "{reports:?}");
/// let red: ShL2<f32> = batches[0].function(0);
/// assert!(red.eval(Dir::from_angles(1.9, 0.0)) > -1e-6);
/// ```
///
/// # Panics
/// If there are neither one nor three batches, they differ in order or number, or the order is above 3.
pub fn dering_batch_order_3_in_place(channels: &mut [ShBatch]) -> Vec<QuadraticDeringReport> {
    assert!(matches!(channels.len(), 1 | 3), "a batch of numbers or three of colors, not {}", channels.len());
    let (order, functions) = (channels[0].order(), channels[0].len());
    assert!(order <= 3, "three bands, not {order}");
    for channel in &channels[1..] {
        let found = (channel.order(), channel.len());
        assert_eq!(found, (order, functions), "orders and numbers of functions of the channels");
    }
    let machine = Machine::detect();
    let mut reports = Vec::with_capacity(functions);
    for first in (0..functions).step_by(LANES) {
        let of = |c: usize| sixteen(&channels[c.min(channels.len() - 1)], first / LANES);
        machine.run(SixteenFunctions {
            channels: &[of(0), of(1), of(2)][..channels.len()],
            count: LANES.min(functions - first),
            reports: &mut reports,
            left: &mut 0,
        });
    }
    channels.iter_mut().for_each(|channel| scale(channel, &reports));
    reports
}

/// Blocks `b` of sixteen functions.
fn sixteen(batch: &ShBatch, b: usize) -> &[Lanes] {
    let count = coefficient_count(batch.order());
    &batch.blocks()[b * count..][..count]
}

/// Applies the factors to one channel.
fn scale(channel: &mut ShBatch, reports: &[QuadraticDeringReport]) {
    let (order, count) = (channel.order(), coefficient_count(channel.order()));
    if count == 0 {
        return;
    }
    for (blocks, reports) in channel.blocks_mut().chunks_exact_mut(count).zip(reports.chunks(LANES)) {
        for (k, report) in reports.iter().enumerate().filter(|(_, report)| report.outcome == DeringOutcome::Windowed) {
            for band in 1..order {
                for block in &mut blocks[band_range(band)] {
                    block.0[k] = (f64::from(block.0[k]) * report.factors[band]) as f32;
                }
            }
        }
    }
}
