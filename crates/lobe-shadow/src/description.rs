//! Descriptions of scenes whose entities are files of their own: a `.json` file that names them, with their places over time.
//!
//! ```json
//! { "format": "lobe-scene", "version": 1,
//!   "still": "room.glb",
//!   "entities": [
//!     { "name": "ball", "mesh": "ball.glb", "field": "ball.field.safetensors", "spheres": "ball.spheres.safetensors",
//!       "keys": [ { "time": 0, "translation": [0, 0, 1], "rotation": [0, 0, 0, 1], "scale": 1 } ] } ] }
//! ```
//!
//! What may be left out: `still`, the files of an entity but its mesh, and of a key all but what differs from resting at the
//! origin at time 0. Translations and rotations, unit quaternions x, y, z, w, are in Lobe's frame, z up; files are named
//! relative to the description.

use std::path::{Path, PathBuf};
use std::{fs, io};

use lobe_scene::referenced_file;
use lobe_sh::Rotation;
use serde::Deserialize;

use crate::{Key, Placement, ShadowError, Track};

/// The format that a description names, and the version that is read.
const FORMAT: &str = "lobe-scene";
const VERSION: u32 = 1;

/// The most bytes of a description: a thousand entities with a hundred keys each take a tenth of that.
const MAX_BYTES: u64 = 1 << 28;

/// A scene whose entities are files of their own.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneDescription {
    /// What does not move, if there is such a thing.
    pub still: Option<PathBuf>,
    /// What moves.
    pub entities: Vec<EntityDescription>,
}

/// A rigid entity of a [`SceneDescription`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EntityDescription {
    /// The name in messages.
    pub name: String,
    /// The file of its triangles, or `built-in:NAME`.
    pub mesh: PathBuf,
    /// The file of its occlusion field.
    pub field: Option<PathBuf>,
    /// The file of its sphere set.
    pub spheres: Option<PathBuf>,
    /// Its place over time.
    pub track: Track,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneJson {
    format: String,
    version: u32,
    #[serde(default)]
    still: Option<String>,
    #[serde(default)]
    entities: Vec<EntityJson>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntityJson {
    name: String,
    mesh: String,
    #[serde(default)]
    field: Option<String>,
    #[serde(default)]
    spheres: Option<String>,
    #[serde(default)]
    keys: Vec<KeyJson>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct KeyJson {
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

impl SceneDescription {
    /// Reads a description. The files that it names are not opened, but they must be there, and within its folder unless
    /// `allow_outside`.
    ///
    /// # Errors
    /// [`ShadowError::Io`] if a file is not there, [`ShadowError::Invalid`] if the description contradicts itself,
    /// [`ShadowError::Scene`] if it names a file outside of its folder.
    pub fn read(path: impl AsRef<Path>, allow_outside: bool) -> Result<Self, ShadowError> {
        let path = path.as_ref();
        let place = path.display().to_string();
        let io = |source: io::Error| ShadowError::Io { place: place.clone(), source };
        let length = fs::metadata(path).map_err(io)?.len();
        if length > MAX_BYTES {
            return Err(invalid(
                &place,
                format!("expected a description of at most {MAX_BYTES} bytes, found {length}"),
            ));
        }
        let json = parse(&fs::read(path).map_err(io)?, &place)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let file = |name: &str| match is_built_in(name) {
            true => Ok(PathBuf::from(name)),
            false => referenced_file(folder, name, allow_outside, &place),
        };
        let optional = |name: &Option<String>| name.as_deref().map(file).transpose();
        let entities = json.entities.iter().map(|entity| {
            let within = |error: String| invalid(&place, format!("entity `{}`: {error}", one_line(&entity.name)));
            Ok(EntityDescription {
                name: one_line(&entity.name),
                mesh: file(&entity.mesh)?,
                field: optional(&entity.field)?,
                spheres: optional(&entity.spheres)?,
                track: track_of(&entity.keys).map_err(within)?,
            })
        });
        let entities = entities.collect::<Result<_, ShadowError>>()?;
        Ok(Self { still: optional(&json.still)?, entities })
    }
}

/// Whether a name stands for a scene in the program.
fn is_built_in(name: &str) -> bool {
    name.starts_with("built-in:")
}

fn parse(bytes: &[u8], place: &str) -> Result<SceneJson, ShadowError> {
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let json: SceneJson = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
        let at = error.path().to_string();
        let at = if at == "." { String::new() } else { format!("{at}: ") };
        invalid(place, one_line(&format!("expected a description of a scene, found at {at}{}", error.inner())))
    })?;
    reader.end().map_err(|error| invalid(place, format!("expected the end of the description: {error}")))?;
    if json.format != FORMAT {
        let found = one_line(&json.format);
        return Err(invalid(place, format!("expected the format `{FORMAT}`, found `{found}`")));
    }
    if json.version != VERSION {
        return Err(invalid(place, format!("expected version {VERSION}, found {}; update Lobe", json.version)));
    }
    if json.still.is_none() && json.entities.is_empty() {
        return Err(invalid(place, "expected something that stands still or moves, found neither".to_owned()));
    }
    Ok(json)
}

fn track_of(keys: &[KeyJson]) -> Result<Track, String> {
    let mut checked = Vec::with_capacity(keys.len().max(1));
    for (index, key) in keys.iter().enumerate() {
        let at = |message: String| format!("key {index}: {message}");
        if !key.translation.iter().all(|t| t.is_finite()) {
            return Err(at(format!("expected a finite translation, found {:?}", key.translation)));
        }
        if !(key.scale.is_finite() && key.scale > 0.0) {
            return Err(at(format!("expected a positive scale, found {}", key.scale)));
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

fn invalid(place: &str, message: String) -> ShadowError {
    ShadowError::Invalid { place: place.to_owned(), message }
}

/// A name of a file in a message: control characters do not break the line.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"{ "format": "lobe-scene", "version": 1, "entities": [ { "name": "ball", "mesh": "built-in:ball",
        "keys": [ { "translation": [0, 0, 1] }, { "time": 2, "translation": [4, 0, 1], "scale": 2 } ] } ] }"#;

    fn read(text: &str) -> Result<SceneDescription, ShadowError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.json");
        fs::write(&path, text).unwrap();
        SceneDescription::read(path, false)
    }

    #[test]
    fn what_is_left_out_rests_at_the_origin() {
        let entity = read(GOOD).unwrap().entities.remove(0);
        assert_eq!(entity.track.at(1.0).translation(), [2.0, 0.0, 1.0], "halfway");
        assert!((entity.track.at(1.0).scale() - 1.5).abs() < 1e-15, "{}", entity.track.at(1.0).scale());
        let resting = read(r#"{"format":"lobe-scene","version":1,"entities":[{"name":"a","mesh":"built-in:ball"}]}"#);
        assert_eq!(resting.unwrap().entities[0].track.at(7.0).translation(), [0.0; 3], "no keys");
    }

    #[test]
    fn bad_descriptions_are_one_line_that_says_where() {
        let with = |from: &str, to: &str| GOOD.replace(from, to);
        for (text, expected) in [
            (String::new(), "expected a description"),
            (GOOD[..GOOD.len() - 3].to_owned(), "expected a description"),
            (with("lobe-scene", "lobe-sh"), "found `lobe-sh`"),
            (with("\"version\": 1", "\"version\": 2"), "expected version 1, found 2"),
            (with("\"scale\": 2", "\"scale\": 0"), "entity `ball`: key 1: expected a positive scale, found 0"),
            (with("\"scale\": 2", "\"rotation\": [0, 0, 0, 0]"), "entity `ball`: key 1"),
            (with("\"time\": 2", "\"time\": 0"), "entity `ball`: expected times that rise, found 0 after 0"),
            (with("\"time\": 2", "\"when\": 2"), "unknown field `when`"),
            (with("[4, 0, 1]", "[4, 0]"), "entities[0].keys[1].translation"),
            (with("built-in:ball", "../ball.obj"), "outside of its folder"),
            (with("built-in:ball", "/etc/hostname"), "outside of its folder"),
            (with("built-in:ball", "nothing.obj"), "nothing.obj"),
            (r#"{"format":"lobe-scene","version":1}"#.to_owned(), "found neither"),
            (format!("{GOOD} x"), "the end"),
        ] {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.contains(expected), "expected {expected:?} in: {message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }
}
