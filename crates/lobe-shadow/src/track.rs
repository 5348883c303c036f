//! Tracks: the place of a rigid entity over time.

use lobe_sh::Rotation;

use crate::error::ShadowError;
use crate::placement::Placement;

/// The place of an entity at one time, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Seconds.
    pub time: f64,
    /// The place at that time.
    pub placement: Placement,
}

/// The place of a rigid entity over time: between two keys linear in translation and scale, and along the shorter great
/// arc of rotations at constant speed (slerp, [Shoemake 1985]); before the first key that of the first, after the last that
/// of the last.
///
/// [Shoemake 1985]: https://doi.org/10.1145/325334.325242
///
/// ```
/// use lobe_sh::{Dir, Rotation};
/// use lobe_shadow::{Key, Placement, Track};
///
/// let quarter = Rotation::from_axis_angle(Dir::Z, 0.5 * std::f64::consts::PI);
/// let begin = Key { time: 0.0, placement: Placement::new([0.0; 3], Rotation::IDENTITY, 1.0) };
/// let end = Key { time: 2.0, placement: Placement::new([4.0, 0.0, 0.0], quarter, 1.0) };
/// let halfway = Track::new(vec![begin, end])?.at(1.0);
/// assert_eq!(halfway.translation(), [2.0, 0.0, 0.0]);
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    keys: Vec<Key>,
}

impl Track {
    /// A track through keys in rising order of time; one key alone stays where it is.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] without a key, or if times do not rise.
    pub fn new(keys: Vec<Key>) -> Result<Self, ShadowError> {
        let invalid = |message: String| Err(ShadowError::Invalid { place: "track".to_owned(), message });
        if keys.is_empty() {
            return invalid("expected a key, found none".to_owned());
        }
        if let Some(key) = keys.iter().find(|key| !key.time.is_finite()) {
            return invalid(format!("expected finite times, found {}", key.time));
        }
        if let Some(pair) = keys.windows(2).find(|pair| pair[1].time <= pair[0].time) {
            return invalid(format!("expected times that rise, found {} after {}", pair[1].time, pair[0].time));
        }
        Ok(Self { keys })
    }

    /// A track that stays at one place.
    #[must_use]
    pub fn resting(placement: Placement) -> Self {
        Self { keys: vec![Key { time: 0.0, placement }] }
    }

    /// The keys, in rising order of time.
    #[must_use]
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// The times of the first and the last key.
    #[must_use]
    pub fn span(&self) -> [f64; 2] {
        [self.keys[0].time, self.keys[self.keys.len() - 1].time]
    }

    /// The place at a time, in seconds; outside of [`Track::span`] that of the nearer end.
    #[must_use]
    pub fn at(&self, time: f64) -> Placement {
        let after = self.keys.partition_point(|key| key.time <= time);
        let (Some(low), Some(high)) = (after.checked_sub(1).map(|k| &self.keys[k]), self.keys.get(after)) else {
            return self.keys[after.min(self.keys.len() - 1)].placement;
        };
        // Differences of the largest numbers are not finite, those of their halves are; halves of the smallest numbers are zero.
        let half = if (high.time - low.time).is_finite() { 1.0 } else { 0.5 };
        let t = (half * time - half * low.time) / (half * high.time - half * low.time);
        between(&low.placement, &high.placement, t)
    }
}

fn between(a: &Placement, b: &Placement, t: f64) -> Placement {
    let (from, to) = (a.translation(), b.translation());
    let translation = std::array::from_fn(|k| blend(from[k], to[k], t));
    Placement::new(translation, slerp(a.rotation(), b.rotation(), t), blend(a.scale(), b.scale(), t))
}

/// `(1 - t) a + t b`, finite where both are and never beyond one of them, whatever the rounding.
fn blend(a: f64, b: f64, t: f64) -> f64 {
    ((1.0 - t) * a + t * b).clamp(a.min(b), a.max(b))
}

/// Rotations closer than this to each other, by the sine of half the angle, are blended linearly: the error is below its
/// square, and nothing is divided by zero.
const SAME: f64 = 1e-9;

/// `(sin((1-t)ω) p + sin(tω) q) / sin ω` of unit quaternions, on the hemisphere where the arc is shorter.
fn slerp(a: &Rotation, b: &Rotation, t: f64) -> Rotation {
    let (p, mut q) = (a.to_quaternion(), b.to_quaternion());
    let mut cos: f64 = (0..4).map(|k| p[k] * q[k]).sum();
    if cos < 0.0 {
        (q, cos) = (q.map(|c| -c), -cos);
    }
    let omega = cos.min(1.0).acos();
    let [low, high] = match omega.sin() {
        sin if sin < SAME => [1.0 - t, t],
        sin => [((1.0 - t) * omega).sin() / sin, (t * omega).sin() / sin],
    };
    let blend = std::array::from_fn(|k| low * p[k] + high * q[k]);
    Rotation::from_quaternion(blend).unwrap_or(*a)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use lobe_sh::Dir;

    use super::*;

    fn key(time: f64, angle: f64) -> Key {
        Key { time, placement: Placement::new([time, 0.0, 0.0], Rotation::from_axis_angle(Dir::Z, angle), 1.0 + time) }
    }

    fn angle(placement: &Placement) -> f64 {
        let turned = placement.rotation().rotate_dir(Dir::X);
        turned.y().atan2(turned.x())
    }

    #[test]
    fn rotations_turn_at_constant_speed_along_the_shorter_arc() {
        let track = Track::new(vec![key(0.0, 0.0), key(1.0, 0.9 * PI), key(2.0, -0.9 * PI)]).unwrap();
        for (time, expected) in [(0.0, 0.0), (0.25, 0.225 * PI), (0.5, 0.45 * PI), (1.0, 0.9 * PI), (1.25, 0.95 * PI)] {
            assert!((angle(&track.at(time)) - expected).abs() < 1e-12, "at {time}: {}", angle(&track.at(time)));
        }
        assert!((angle(&track.at(1.75)) + 0.95 * PI).abs() < 1e-12, "over the far side: {}", angle(&track.at(1.75)));
        assert!((track.at(1.5).scale() - 2.5).abs() < 1e-15, "{}", track.at(1.5).scale());
    }

    #[test]
    fn outside_of_its_keys_a_track_rests() {
        let track = Track::new(vec![key(1.0, 0.5), key(2.0, 0.6)]).unwrap();
        assert_eq!(track.at(-5.0), key(1.0, 0.5).placement, "before");
        assert_eq!(track.at(9.0), key(2.0, 0.6).placement, "after");
        let one = Track::new(vec![key(1.0, 0.5)]).unwrap();
        assert_eq!(one.at(0.0), one.at(3.0), "one key is one place");
        assert_eq!(one.span(), [1.0, 1.0], "its span is a point");
    }

    #[test]
    fn keys_at_one_place_stay_there() {
        let same = [key(0.0, 0.3), Key { time: 1.0, ..key(0.0, 0.3) }];
        let track = Track::new(same.to_vec()).unwrap();
        assert!((angle(&track.at(0.5)) - 0.3).abs() < 1e-15, "{}", angle(&track.at(0.5)));
    }

    #[test]
    fn between_the_largest_numbers_a_track_stays_finite() {
        let at =
            |time: f64, x: f64, scale: f64| Key { time, placement: Placement::new([x; 3], Rotation::IDENTITY, scale) };
        let most = f64::MAX;
        let track = Track::new(vec![at(-most, most, 5e-324), at(most, -most, 5e-324)]).unwrap();
        for time in [-most, -1.0, 0.0, 0.9 * most, most] {
            let placement = track.at(time);
            assert!(placement.translation().iter().all(|x| x.is_finite()), "{placement:?} at {time}");
            assert_eq!(placement.scale(), 5e-324, "at {time}");
        }
        assert!(track.at(0.0).translation()[0].abs() < 1e295, "halfway: {:?}", track.at(0.0).translation());
    }

    #[test]
    fn between_keys_as_near_as_numbers_are_a_track_stays_finite() {
        let least = f64::from_bits(1);
        for (first, last) in [(0.0, least), (-least, 0.0), (-least, least), (1.0, 1.0_f64.next_up())] {
            let at = |time, x| Key { time, placement: Placement::new([x; 3], Rotation::IDENTITY, 1.0) };
            let track = Track::new(vec![at(first, 1.0), at(last, 3.0)]).unwrap();
            assert_eq!(track.at(first).translation(), [1.0; 3], "at {first}");
            assert_eq!(track.at(last).translation(), [3.0; 3], "at {last}");
            let middle = track.at(0.5 * first + 0.5 * last).translation()[0];
            assert!((1.0..=3.0).contains(&middle), "{middle} between {first} and {last}");
        }
    }

    #[test]
    fn keys_without_order_are_refused_in_one_line() {
        for (keys, expected) in [
            (vec![], "expected a key"),
            (vec![key(1.0, 0.0), key(0.5, 0.0)], "found 0.5 after 1"),
            (vec![key(1.0, 0.0), key(1.0, 0.0)], "found 1 after 1"),
            (vec![Key { time: f64::NAN, ..key(1.0, 0.0) }], "finite"),
        ] {
            let message = Track::new(keys).unwrap_err().to_string();
            assert!(message.contains(expected) && !message.contains('\n'), "{message}");
        }
    }
}
