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
struct Moments {
    count: f64,
    first: Rgb<f64>,
    sum: Rgb<f64>,
    squares: Rgb<f64>,
}

impl Moments {
    fn add(&mut self, value: Rgb<f64>) {
        if self.count == 0.0 {
            self.first = value;
        }
        let d = value - self.first;
        self.count += 1.0;
        self.sum += d;
        self.squares += d * d;
    }

    fn estimate(&self) -> PathEstimate {
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

/// Means over sets of values that come one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetMeans {
    per_set: usize,
    in_set: usize,
    sum: Rgb<f64>,
    moments: Moments,
}

impl SetMeans {
    pub(crate) fn new(count: &SampleCount) -> Self {
        Self { per_set: count.per_set, in_set: 0, sum: Rgb::ZERO, moments: Moments::default() }
    }

    pub(crate) fn add(&mut self, value: Rgb<f64>) {
        self.sum += value;
        self.in_set += 1;
        if self.in_set == self.per_set {
            self.moments.add(self.sum.scale((self.per_set as f64).recip()));
            (self.in_set, self.sum) = (0, Rgb::ZERO);
        }
    }

    /// The mean over all; its variance is that between sets.
    pub(crate) fn estimate(&self) -> PathEstimate {
        self.moments.estimate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(per_set: usize, values: &[f64]) -> PathEstimate {
        let mut means = SetMeans::new(&SampleCount { sets: values.len() / per_set, per_set });
        values.iter().for_each(|&value| means.add(Rgb::splat(value)));
        means.estimate()
    }

    #[test]
    fn mean_and_variance_are_those_of_a_hand_computed_case() {
        let values = [1.0, 2.0, 6.0, 7.0];
        let found = estimate(2, &values);
        // Means of sets 1.5 and 6.5: their variance is 12.5, that of the mean half of it.
        assert_eq!((found.mean.g, found.variance.g), (4.0, 6.25), "{found:?}");
        let alone = estimate(4, &values);
        assert_eq!((alone.mean.g, alone.variance.g), (4.0, f64::INFINITY), "{alone:?}");
    }

    #[test]
    fn the_error_of_what_is_not_finite_is_not_zero() {
        for value in [f64::INFINITY, f64::NAN, 1e200] {
            let found = estimate(1, &[1.0, value, 1.0, 1.0]);
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
