//! Places over time in descriptions of scenes: keys of time, translation, rotation and scale.

use lobe_sh::Rotation;
use serde::Deserialize;

use crate::error::ShadowError;
use crate::placement::Placement;
use crate::track::{Key, Track};

/// The largest coordinate and time of a key, as of vertices, and the range of scales: what is taken to a place and back stays
/// in the range of `f32`.
pub(crate) const LARGEST: f64 = 1e15;
pub(crate) const SCALES: [f64; 2] = [1e-15, 1e15];

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct KeyJson {
    time: f64,
    translation: [f64; 3],
    rotation: [f64; 4],
    scale: f64,
}

impl Default for KeyJson {
    fn default() -> Self {
        Self { time: 0.0, translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: 1.0 }
    }
}

/// The track of keys, which rests at the origin without any.
pub(crate) fn track_of(keys: &[KeyJson]) -> Result<Track, String> {
    let mut checked = Vec::with_capacity(keys.len().max(1));
    for (index, key) in keys.iter().enumerate() {
        let at = |message: String| format!("key {index}: {message}");
        if !(-LARGEST..=LARGEST).contains(&key.time) {
            return Err(at(format!("expected a time of at most {LARGEST:e} seconds, found {:e}", key.time)));
        }
        if !key.translation.iter().all(|t| t.abs() <= LARGEST) {
            return Err(at(format!("expected a translation of at most {LARGEST:e}, found {:?}", key.translation)));
        }
        if key.scale <= 0.0 {
            return Err(at(format!("expected a positive scale, found {}", key.scale)));
        }
        if !(SCALES[0]..=SCALES[1]).contains(&key.scale) {
            return Err(at(format!("expected a scale from {:e} to {:e}, found {:e}", SCALES[0], SCALES[1], key.scale)));
        }
        let rotation = Rotation::from_quaternion(key.rotation).map_err(|error| at(error.to_string()))?;
        checked.push(Key { time: key.time, placement: Placement::new(key.translation, rotation, key.scale) });
    }
    if checked.is_empty() {
        return Ok(Track::resting(Placement::new([0.0; 3], Rotation::IDENTITY, 1.0)));
    }
    Track::new(checked).map_err(|error| match error {
        ShadowError::Invalid { message, .. } => message,
        other => other.to_string(),
    })
}
