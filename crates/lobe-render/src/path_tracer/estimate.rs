//! Monte Carlo estimates: sample counts, means and the variance of means.

use lobe_sh::{Coefficient as _, Rgb};

/// A number of paths, in independent sets.
///
/// Within a set the random numbers of paths are stratified, which lowers the error of the mean; between sets they are
/// independent, which allows that error to be estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SampleCount {
    /// Independent sets, at least 2: the variance has one degree of freedom less.
    pub sets: usize,
    /// Paths in each set, best a power of two.
    pub per_set: usize,
}

impl SampleCount {
    /// Sets of a usual count: the variance is known to a third.
    const SETS: usize = 16;

    /// At least `samples` paths in 16 sets of a power of two, or as many sets as paths if they are few.
    #[must_use]
    pub fn of(samples: usize) -> Self {
        let samples = samples.max(2);
        if samples < Self::SETS {
            return Self { sets: samples, per_set: 1 };
        }
        let per_set = samples.div_ceil(Self::SETS).next_power_of_two();
        Self { sets: samples.div_ceil(per_set), per_set }
    }

    /// All paths, each independent of the others.
    #[must_use]
    pub fn independent(samples: usize) -> Self {
        Self { sets: samples, per_set: 1 }
    }

    /// The number of paths.
    #[must_use]
    pub fn total(&self) -> usize {
        self.sets * self.per_set
    }
}

/// A mean, and the variance of that mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathEstimate {
    /// The mean over all paths.
    pub mean: Rgb<f64>,
    /// The square of its standard error, estimated from the differences of sets; infinite for a single set, and where values
    /// are not finite.
    pub variance: Rgb<f64>,
}

/// Sums of values and of their squares about a first value, which takes the cancellation out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    count: f64,
    first: Rgb<f64>,
    sum: Rgb<f64>,
    squares: Rgb<f64>,
}

impl Moments {
    pub(crate) fn add(&mut self, value: Rgb<f64>) {
        if self.count == 0.0 {
            self.first = value;
        }
        let d = value - self.first;
        self.count += 1.0;
        self.sum += d;
        self.squares += d * d;
    }

    pub(crate) fn estimate(&self) -> PathEstimate {
        let n = self.count;
        if n == 0.0 {
            return PathEstimate::default();
        }
        let mean = self.sum.scale(n.recip());
        let of = |s: f64, m: f64| {
            let variance = (s / n - m * m) / (n - 1.0);
            if n < 2.0 || variance.is_nan() { f64::INFINITY } else { variance.max(0.0) }
        };
        let (s, m) = (self.squares.to_array(), mean.to_array());
        PathEstimate { mean: self.first + mean, variance: Rgb::from(std::array::from_fn(|c| of(s[c], m[c]))) }
    }
}

/// The mean of `value(set, path)`; its variance is that between sets.
pub(crate) fn estimate(count: &SampleCount, mut value: impl FnMut(usize, usize) -> Rgb<f64>) -> PathEstimate {
    let mut moments = Moments::default();
    for set in 0..count.sets {
        let mut sum = Rgb::<f64>::ZERO;
        for path in 0..count.per_set {
            sum += value(set, path);
        }
        moments.add(sum.scale((count.per_set as f64).recip()));
    }
    moments.estimate()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_are_those_of_a_hand_computed_case() {
        let values = [1.0, 2.0, 6.0, 7.0];
        let found = estimate(&SampleCount { sets: 2, per_set: 2 }, |set, path| Rgb::splat(values[2 * set + path]));
        // Means of sets 1.5 and 6.5: their variance is 12.5, that of the mean half of it.
        assert_eq!((found.mean.g, found.variance.g), (4.0, 6.25), "{found:?}");
        let alone = estimate(&SampleCount { sets: 1, per_set: 4 }, |_, path| Rgb::splat(values[path]));
        assert_eq!((alone.mean.g, alone.variance.g), (4.0, f64::INFINITY), "{alone:?}");
    }

    #[test]
    fn the_error_of_what_is_not_finite_is_not_zero() {
        for value in [f64::INFINITY, f64::NAN, 1e200] {
            let count = SampleCount::independent(4);
            let found = estimate(&count, |set, _| Rgb::splat(if set == 1 { value } else { 1.0 }));
            assert_eq!(found.variance.g, f64::INFINITY, "{value} among ones: {found:?}");
        }
    }

    #[test]
    fn counts_are_at_least_what_was_asked_for() {
        for (samples, sets, per_set) in [(1, 2, 1), (5, 5, 1), (16, 16, 1), (17, 9, 2), (64, 16, 4), (1000, 16, 64)] {
            let count = SampleCount::of(samples);
            assert_eq!((count.sets, count.per_set), (sets, per_set), "{samples} samples");
            assert!(count.total() >= samples, "{samples} samples: {count:?}");
        }
    }
}
