//! Samplers: a value over time, given at keys.

use std::sync::Arc;

use glam::{DQuat, DVec4};

use crate::motion::place::ROUNDING;
use crate::scene::transform::unit;

/// What a sampler does between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Interpolation {
    /// Keep the value of the earlier key.
    Step,
    /// A straight line; rotations take the shortest arc at constant speed (slerp).
    Linear,
    /// Cubic Hermite splines: each key has a tangent in, a value and a tangent out.
    CubicSpline,
}

/// A value of some components over time.
///
/// Between the keys `t_k ≤ t < t_{k+1}`, with `d = t_{k+1} - t_k` and `s = (t - t_k) / d`,
///
/// ```text
///   step     v_k
///   linear   (1 - s) v_k + s v_{k+1},      rotations   slerp(v_k, v_{k+1}, s)
///   cubic    (2s³ - 3s² + 1) v_k + d (s³ - 2s² + s) b_k + (3s² - 2s³) v_{k+1} + d (s³ - s²) a_{k+1}
/// ```
///
/// where `a` and `b` are the tangents in and out; rotations are made unit quaternions. Before the first key it is the first
/// value, after the last one the last. glTF 2.0, appendix C.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sampler {
    times: Arc<[f32]>,
    /// For each key its values; for cubic splines its tangents in, its values and its tangents out.
    values: Arc<[f32]>,
    interpolation: Interpolation,
    /// The number of components.
    width: usize,
    /// Whether all keys have the same value, and no tangents.
    is_constant: bool,
}

/// A point of time among the keys.
enum At {
    Key(usize),
    /// From the key of this index on, by a part of the time to the next, which is `length`.
    Between {
        key: usize,
        part: f64,
        length: f64,
    },
}

impl Sampler {
    /// A sampler of `width` components, or the fault of its keys.
    pub(crate) fn new(
        times: Arc<[f32]>,
        values: Arc<[f32]>,
        interpolation: Interpolation,
        width: usize,
    ) -> Result<Self, String> {
        check_times(&times)?;
        let per_key = check_count(times.len(), values.len(), interpolation, width)?;
        check_values(&values, per_key)?;
        let is_constant = is_constant(&values, interpolation, width);
        Ok(Self { times, values, interpolation, width, is_constant })
    }

    /// A sampler of keys that were checked already, as [`Sampler::new`] checks them.
    pub(crate) fn of_checked(
        times: Arc<[f32]>,
        values: Arc<[f32]>,
        interpolation: Interpolation,
        width: usize,
        is_constant: bool,
    ) -> Self {
        Self { times, values, interpolation, width, is_constant }
    }

    /// A sampler of values that a formula gives at `keys + 1` times from 0 to `end`, evenly spaced.
    pub(crate) fn of_formula<const N: usize>(
        (end, keys): (f64, usize),
        interpolation: Interpolation,
        values: impl Fn(f64) -> [f64; N],
    ) -> Self {
        let times: Vec<f64> = (0..=keys).map(|k| end * k as f64 / keys as f64).collect();
        let values = times.iter().flat_map(|&t| values(t)).map(|v| v as f32).collect();
        let per_key = if interpolation == Interpolation::CubicSpline { N / 3 } else { N };
        match Self::new(times.iter().map(|&t| t as f32).collect(), values, interpolation, per_key) {
            Ok(sampler) => sampler,
            Err(message) => unreachable!("formulas give finite numbers in the order of time: {message}"),
        }
    }

    /// The times of the keys, in rising order.
    pub(crate) fn times(&self) -> impl Iterator<Item = f64> {
        self.times.iter().copied().map(f64::from)
    }

    /// The time of the last key.
    pub(crate) fn end(&self) -> f64 {
        self.times.last().copied().map_or(0.0, f64::from)
    }

    /// Whether it always has this value, to the last digit of `f32`.
    pub(crate) fn is_always(&self, value: &[f64]) -> bool {
        self.is_constant && self.value(0).iter().zip(value).all(|(&a, &b)| a == b as f32)
    }

    /// Tells samplers apart: those of the same numbers in memory are alike.
    pub(crate) fn identity(&self) -> (*const f32, *const f32, Interpolation) {
        (self.times.as_ptr(), self.values.as_ptr(), self.interpolation)
    }

    /// The sign of all components, 1 or -1, if they are equal at all times and none changes its sign, but for rounding; zeros
    /// have both.
    ///
    /// That holds if it holds for all values `v_k`, and of splines, which lie within the hull of their control points, also
    /// for `v_k + d b_k / 3` and `v_{k+1} - d a_{k+1} / 3`.
    pub(crate) fn even_sign(&self) -> Option<f32> {
        let points = (0..self.times.len()).flat_map(|key| self.control_points(key));
        let (mut least, mut largest, mut uneven) = (0.0_f64, 0.0_f64, 0.0_f64);
        for point in points {
            let [low, high] =
                point.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &c| [low.min(c), high.max(c)]);
            (least, largest, uneven) = (least.min(low), largest.max(high), uneven.max(high - low));
        }
        let small = ROUNDING * largest.max(-least);
        match (uneven <= small, least >= -small, largest <= small) {
            (true, true, _) => Some(1.0),
            (true, _, true) => Some(-1.0),
            _ => None,
        }
    }

    /// The value of a key, and of a spline the two control points between it and the next.
    fn control_points(&self, key: usize) -> Vec<Vec<f64>> {
        let of = |place: usize, k: usize| f64::from(self.values[place * self.width + k]);
        let mut points = vec![self.value(key).iter().copied().map(f64::from).collect()];
        if self.interpolation == Interpolation::CubicSpline && key + 1 < self.times.len() {
            let third = (f64::from(self.times[key + 1]) - f64::from(self.times[key])) / 3.0;
            let after = |k| of(3 * key + 1, k) + third * of(3 * key + 2, k);
            let before = |k| of(3 * key + 4, k) - third * of(3 * key + 3, k);
            points.push((0..self.width).map(after).collect());
            points.push((0..self.width).map(before).collect());
        }
        points
    }

    /// The components at a time.
    pub(crate) fn at(&self, t: f64) -> Vec<f64> {
        let at = self.place(t);
        (0..self.width).map(|k| self.component(&at, k)).collect()
    }

    /// The vector at a time; of `N` components.
    pub(crate) fn vector_at<const N: usize>(&self, t: f64) -> [f64; N] {
        let at = self.place(t);
        std::array::from_fn(|k| self.component(&at, k))
    }

    fn component(&self, at: &At, k: usize) -> f64 {
        match *at {
            At::Key(key) => f64::from(self.value(key)[k]),
            At::Between { key, part, length } => self.between(key, part, length, k),
        }
    }

    /// The unit quaternion at a time; of four components.
    pub(crate) fn rotation_at(&self, t: f64) -> DQuat {
        let quaternion = |v: [f64; 4]| unit(DQuat::from_vec4(DVec4::from_array(v)));
        let at_key = |key: usize| quaternion([0, 1, 2, 3].map(|k| f64::from(self.value(key)[k])));
        match self.place(t) {
            At::Key(key) => at_key(key),
            At::Between { key, part, .. } if self.interpolation == Interpolation::Linear => {
                at_key(key).slerp(at_key(key + 1), part).normalize()
            }
            At::Between { .. } => quaternion(self.vector_at(t)),
        }
    }

    fn place(&self, t: f64) -> At {
        let after = self.times.partition_point(|&key| f64::from(key) <= t);
        if after == 0 {
            return At::Key(0);
        }
        let key = after - 1;
        if after == self.times.len() || self.interpolation == Interpolation::Step {
            return At::Key(key);
        }
        let (from, to) = (f64::from(self.times[key]), f64::from(self.times[after]));
        At::Between { key, part: (t - from) / (to - from), length: to - from }
    }

    /// A component between two keys.
    fn between(&self, key: usize, s: f64, length: f64, k: usize) -> f64 {
        let (from, to) = (f64::from(self.value(key)[k]), f64::from(self.value(key + 1)[k]));
        if self.interpolation != Interpolation::CubicSpline {
            return (1.0 - s) * from + s * to;
        }
        let out = f64::from(self.values[(3 * key + 2) * self.width + k]);
        let into = f64::from(self.values[3 * (key + 1) * self.width + k]);
        let (s2, s3) = (s * s, s * s * s);
        (2.0 * s3 - 3.0 * s2 + 1.0) * from
            + length * (s3 - 2.0 * s2 + s) * out
            + (3.0 * s2 - 2.0 * s3) * to
            + length * (s3 - s2) * into
    }

    /// The value of a key, without its tangents.
    fn value(&self, key: usize) -> &[f32] {
        let first = if self.interpolation == Interpolation::CubicSpline { 3 * key + 1 } else { key };
        &self.values[first * self.width..][..self.width]
    }
}

/// Checks that there are as many values as keys need; returns how many numbers that is for each.
pub(crate) fn check_count(
    keys: usize,
    found: usize,
    interpolation: Interpolation,
    width: usize,
) -> Result<usize, String> {
    let per_key = if interpolation == Interpolation::CubicSpline { 3 * width } else { width };
    if keys.checked_mul(per_key) != Some(found) {
        return Err(format!("expected {per_key} numbers for each of {keys} keys, found {found}"));
    }
    Ok(per_key)
}

/// Checks that values are finite.
pub(crate) fn check_values(values: &[f32], per_key: usize) -> Result<(), String> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(place) => {
            Err(format!("expected finite values, found {} at key {}", values[place], place / per_key.max(1)))
        }
    }
}

/// Whether all keys have the same value, and no tangents.
pub(crate) fn is_constant(values: &[f32], interpolation: Interpolation, width: usize) -> bool {
    let width = width.max(1);
    match interpolation {
        Interpolation::CubicSpline => {
            let tangents = |key: &[f32]| key[..width].iter().chain(&key[2 * width..]).all(|&tangent| tangent == 0.0);
            let keys = || values.chunks_exact(3 * width);
            keys().all(tangents) && keys().zip(keys().skip(1)).all(|(a, b)| a[width..2 * width] == b[width..2 * width])
        }
        _ => values.iter().zip(values.iter().skip(width)).all(|(a, b)| a == b),
    }
}

/// Keys are at finite times from 0 on, each later than the one before it.
pub(crate) fn check_times(times: &[f32]) -> Result<(), String> {
    if times.is_empty() {
        return Err("expected keys, found none".to_string());
    }
    if let Some(key) = times.iter().position(|t| !t.is_finite() || *t < 0.0) {
        return Err(format!("expected times from 0 on, found {} at key {key}", times[key]));
    }
    match times.windows(2).position(|pair| pair[0] >= pair[1]) {
        None => Ok(()),
        Some(key) => {
            let (before, after) = (times[key], times[key + 1]);
            Err(format!("expected keys in the order of time, found {after} after {before} at key {}", key + 1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampler(times: &[f32], values: &[f32], interpolation: Interpolation, width: usize) -> Result<Sampler, String> {
        Sampler::new(times.into(), values.into(), interpolation, width)
    }

    #[test]
    fn steps_lines_and_splines_pass_through_their_keys_and_stay_beyond_them() {
        let plain = [1.0, 5.0, 2.0];
        let with_tangents = [9.0, 1.0, 0.5, -2.0, 5.0, 3.0, 1.0, 2.0, 9.0];
        for (interpolation, values) in [
            (Interpolation::Step, &plain[..]),
            (Interpolation::Linear, &plain),
            (Interpolation::CubicSpline, &with_tangents),
        ] {
            let sampler = sampler(&[0.5, 1.0, 3.0], values, interpolation, 1).unwrap();
            for (t, expected) in [(0.5, 1.0), (1.0, 5.0), (3.0, 2.0), (-1.0, 1.0), (0.0, 1.0), (99.0, 2.0)] {
                assert_eq!(sampler.at(t), [expected], "{interpolation:?} at {t}");
            }
        }
    }

    #[test]
    fn between_keys_steps_stay_and_lines_are_straight() {
        let at = |interpolation, t| sampler(&[0.0, 2.0], &[1.0, 5.0], interpolation, 1).unwrap().at(t);
        assert_eq!(at(Interpolation::Step, 1.999), [1.0], "step");
        assert_eq!(at(Interpolation::Linear, 0.5), [2.0], "linear");
    }

    /// A cubic through its own values and slopes at two keys is the spline between them.
    #[test]
    fn a_spline_reproduces_any_cubic() {
        let cubic = |t: f64| 0.5 * t * t * t - 2.0 * t * t + 0.25 * t + 3.0;
        let slope = |t: f64| 1.5 * t * t - 4.0 * t + 0.25;
        let times = [0.5_f32, 2.0, 2.5];
        let key = |&t: &f32| [slope(t.into()), cubic(t.into()), slope(t.into())].map(|v| v as f32);
        let values: Vec<f32> = times.iter().flat_map(key).collect();
        let sampler = sampler(&times, &values, Interpolation::CubicSpline, 1).unwrap();
        for t in [0.5, 0.6, 1.0, 1.7, 2.0, 2.2, 2.499] {
            let (found, expected) = (sampler.at(t)[0], cubic(t));
            assert!((found - expected).abs() < 1e-6, "{found} at {t}, expected {expected}");
        }
    }

    #[test]
    fn rotations_turn_along_the_shortest_arc_at_constant_speed() {
        let turn = |angle: f64| DQuat::from_rotation_y(angle).to_array().map(|c| c as f32);
        // The second key is the same rotation as 1.5 about y, written by the opposite quaternion.
        let values = [turn(0.0), turn(1.5).map(|c| -c)].concat();
        let sampler = sampler(&[0.0, 3.0], &values, Interpolation::Linear, 4).unwrap();
        for (t, angle) in [(0.0, 0.0), (1.0, 0.5), (2.5, 1.25)] {
            let off = sampler.rotation_at(t).angle_between(DQuat::from_rotation_y(angle));
            assert!(off < 1e-6, "{off} off at {t}");
        }
    }

    #[test]
    fn one_key_is_a_constant() {
        let spline = sampler(&[1.0], &[7.0, 2.0, 7.0], Interpolation::CubicSpline, 1).unwrap();
        assert_eq!([spline.at(0.0), spline.at(1.0), spline.at(2.0)].concat(), [2.0; 3], "always its value");
        let zero = sampler(&[0.0], &[0.0; 4], Interpolation::Linear, 4).unwrap();
        assert_eq!(zero.rotation_at(0.0), DQuat::IDENTITY, "a quaternion without length turns nothing");
    }

    #[test]
    fn what_never_changes_is_recognized_with_its_tangents() {
        let of = |values: &[f32], interpolation| sampler(&[0.0, 1.0], values, interpolation, 1).unwrap();
        assert!(of(&[0.1, 0.1], Interpolation::Linear).is_always(&[0.1]), "0.1 of f64 is 0.1 of f32");
        assert!(!of(&[0.1, 0.2], Interpolation::Linear).is_always(&[0.1]), "it changes");
        assert!(of(&[0.0, 1.0, 0.0, 0.0, 1.0, 0.0], Interpolation::CubicSpline).is_always(&[1.0]), "flat");
        assert!(!of(&[0.0, 1.0, 0.5, 0.0, 1.0, 0.0], Interpolation::CubicSpline).is_always(&[1.0]), "it swings out");
    }

    #[test]
    fn components_are_equal_at_all_times_or_they_are_not() {
        use Interpolation::{CubicSpline, Linear, Step};
        let sign = |values: &[f32], interpolation| {
            let keys = values.len() / if interpolation == CubicSpline { 9 } else { 3 };
            let times: Vec<f32> = (0..keys).map(|k| k as f32).collect();
            sampler(&times, values, interpolation, 3).unwrap().even_sign()
        };
        assert_eq!(sign(&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0], Linear), Some(1.0), "to nothing");
        assert_eq!(sign(&[-1.0, -1.0, -1.0, 0.0, 0.0, 0.0], Step), Some(-1.0), "in a mirror");
        assert_eq!(sign(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.000_001], Linear), Some(1.0), "but for rounding");
        assert_eq!(sign(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.1], Step), None, "uneven");
        assert_eq!(sign(&[1.0, 1.0, 1.0, -1.0, -1.0, -1.0], Linear), None, "through nothing into a mirror");
        let spline = |out: [f32; 3]| {
            let keys = [[0.0; 3], [1.0; 3], out, [0.0; 3], [0.5; 3], [0.0; 3]];
            sign(keys.as_flattened(), CubicSpline)
        };
        assert_eq!(spline([-2.9; 3]), Some(1.0), "it stays above zero");
        assert_eq!(spline([-9.0; 3]), None, "it swings below zero");
        assert_eq!(spline([0.0, 1.0, 0.0]), None, "it is uneven between even keys");
    }

    #[test]
    fn keys_that_cannot_be_are_refused() {
        let refusal = |times: &[f32], values: &[f32]| sampler(times, values, Interpolation::Linear, 1).unwrap_err();
        for (found, expected) in [
            (refusal(&[], &[]), "expected keys, found none"),
            (refusal(&[0.0, 2.0, 1.0], &[0.0; 3]), "expected keys in the order of time, found 1 after 2 at key 2"),
            (refusal(&[0.0, 0.0], &[0.0; 2]), "expected keys in the order of time, found 0 after 0 at key 1"),
            (refusal(&[0.0, f32::NAN], &[0.0; 2]), "expected times from 0 on, found NaN at key 1"),
            (refusal(&[-1.0], &[0.0]), "expected times from 0 on, found -1 at key 0"),
            (refusal(&[0.0, 1.0], &[0.0, f32::NAN]), "expected finite values, found NaN at key 1"),
            (refusal(&[0.0, 1.0], &[0.0]), "expected 1 numbers for each of 2 keys, found 1"),
        ] {
            assert_eq!(found, expected, "refusal");
        }
    }
}
