//! Numbers from files.

use std::ops::RangeInclusive;

/// A number from a file in the range that its control has; one that is none is as at the first start.
pub(crate) fn within(value: f64, range: RangeInclusive<f64>, first: f64) -> f64 {
    if value.is_finite() { value.clamp(*range.start(), *range.end()) } else { first }
}
