//! Samplers: a value over time, given at keys.

use std::sync::Arc;

use glam::{DQuat, DVec4};

use crate::scene::transform::unit;

/// What a sampler does between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
        let (keys, found) = (times.len(), values.len());
        let per_key = if interpolation == Interpolation::CubicSpline { 3 * width } else { width };
        if keys.checked_mul(per_key) != Some(found) {
            return Err(format!("expected {per_key} numbers for each of {keys} keys, found {found}"));
        }
        if let Some(place) = values.iter().position(|value| !value.is_finite()) {
            return Err(format!("expected finite values, found {} at key {}", values[place], place / per_key.max(1)));
        }
        Ok(Self { times, values, interpolation, width })
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

    /// The time of the last key.
    pub(crate) fn end(&self) -> f64 {
        self.times.last().copied().map_or(0.0, f64::from)
    }

    /// Whether it always has this value, to the last digit of `f32`.
    pub(crate) fn is_always(&self, value: &[f64]) -> bool {
        let is_spline = self.interpolation == Interpolation::CubicSpline;
        let is_value = |numbers: &[f32]| numbers.iter().zip(value).all(|(&a, &b)| a == b as f32);
        let holds = |(k, numbers): (usize, &[f32])| match is_spline && k % 3 != 1 {
            true => numbers.iter().all(|&tangent| tangent == 0.0),
            false => is_value(numbers),
        };
        self.values.chunks(self.width.max(1)).enumerate().all(holds)
    }

    /// The components at a time.
    pub(crate) fn at(&self, t: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.width];
        match self.place(t) {
            At::Key(key) => out.iter_mut().zip(self.value(key)).for_each(|(o, &v)| *o = f64::from(v)),
            At::Between { key, part, length } => {
                for (k, o) in out.iter_mut().enumerate() {
                    *o = self.between(key, part, length, k);
                }
            }
        }
        out
    }

    /// The vector at a time; of three components.
    pub(crate) fn vector_at(&self, t: f64) -> [f64; 3] {
        let value = self.at(t);
        std::array::from_fn(|k| value.get(k).copied().unwrap_or(0.0))
    }

    /// The unit quaternion at a time; of four components.
    pub(crate) fn rotation_at(&self, t: f64) -> DQuat {
        let quaternion = |v: &[f64]| unit(DQuat::from_vec4(DVec4::from_array(std::array::from_fn(|k| v[k]))));
        let at_key = |key: usize| {
            let value = self.value(key);
            quaternion(&[0, 1, 2, 3].map(|k| f64::from(value[k])))
        };
        match self.place(t) {
            At::Key(key) => at_key(key),
            At::Between { key, part, .. } if self.interpolation == Interpolation::Linear => {
                at_key(key).slerp(at_key(key + 1), part).normalize()
            }
            At::Between { .. } => quaternion(&self.at(t)),
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

/// Keys are at finite times from 0 on, each later than the one before it.
fn check_times(times: &[f32]) -> Result<(), String> {
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
