//! How an attempt to remove ringing ends.

/// How far below zero, relative to the mean, a function may be and still count as non-negative: rounding of
/// coefficients to `f32` does as much to a function whose minimum is exactly 0.
pub const DERING_ALLOWED: f64 = 5e-7;

/// Whether a function was changed, and if not, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DeringOutcome {
    /// It was not negative (down to [`DERING_ALLOWED`]), and is bit for bit what it was.
    Unchanged,
    /// It was negative somewhere and is not any more.
    Windowed,
    /// The mean of a channel is not positive though the channel is not zero: no window makes such a function
    /// non-negative. It is bit for bit what it was.
    MeanNotPositive {
        /// The first such channel.
        channel: usize,
    },
    /// A coefficient is not a finite number. The function is bit for bit what it was.
    NotFinite,
    /// [`DeringMethod::Table`](crate::DeringMethod::Table) was asked for a function of more than three bands, or one that the strongest window of
    /// the table does not suffice for (no light does that). The function is bit for bit what it was.
    BeyondTable,
}
