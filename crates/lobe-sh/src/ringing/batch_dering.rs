//! Dering of many functions of three bands at once.

use alloc::vec::Vec;

use crate::basis::index::{band_range, coefficient_count};
use crate::ringing::lane_dering::Factors;
use crate::ringing::quadratic_dering::QuadraticDeringReport;
use crate::simd::{LANES, Machine};
use crate::{DeringOutcome, ShBatch};

/// Makes each function of a batch non-negative, as [`dering_order_3_in_place`](crate::dering_order_3_in_place) does one: a batch of numbers, or
/// three of the channels of colors, which share their factors. What it says of each function comes back in their order.
///
/// What is left of a function agrees with that to rounding, or to 1e-7 of it where one of the two searches takes a step more, and does not depend on what lies beside it.
/// A function that needs no change keeps every bit.
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
    let (order, count) = (channels[0].order(), channels[0].len());
    assert!(order <= 3, "three bands, not {order}");
    for channel in &channels[1..] {
        assert_eq!((channel.order(), channel.len()), (order, count), "orders and numbers of functions of the channels");
    }
    let blocks = coefficient_count(order);
    let mut reports = Vec::with_capacity(count);
    for first in (0..count).step_by(LANES) {
        let place = first / LANES * blocks..(first / LANES + 1) * blocks;
        let of = |c: usize| &channels[c.min(channels.len() - 1)].blocks()[place.clone()];
        let sixteen = [of(0), of(1), of(2)];
        Machine::detect().run(Factors {
            channels: &sixteen[..channels.len()],
            count: LANES.min(count - first),
            reports: &mut reports,
        });
    }
    for channel in channels {
        scale(channel, order, &reports);
    }
    reports
}

/// Applies the factors to one channel.
fn scale(channel: &mut ShBatch, order: usize, reports: &[QuadraticDeringReport]) {
    let count = coefficient_count(order);
    if count == 0 {
        return;
    }
    for (blocks, reports) in channel.blocks_mut().chunks_exact_mut(count).zip(reports.chunks(LANES)) {
        if reports.iter().all(|report| report.outcome != DeringOutcome::Windowed) {
            continue;
        }
        for band in 1..order {
            let mut factors = [1.0; LANES];
            for (factor, report) in factors.iter_mut().zip(reports) {
                *factor = report.factors[band];
            }
            for block in &mut blocks[band_range(band)] {
                for (f, factor) in block.0.iter_mut().zip(factors) {
                    *f = (f64::from(*f) * factor) as f32;
                }
            }
        }
    }
}
