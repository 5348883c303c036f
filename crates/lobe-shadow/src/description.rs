//! Descriptions of scenes whose entities are files of their own: a `.json` file that names them, with their places over time.
//!
//! ```json
//! { "format": "lobe-scene", "version": 1,
//!   "still": ["room.glb", { "mesh": "table.glb", "field": "table.field.safetensors" }],
//!   "entities": [
//!     { "name": "ball", "mesh": "ball.glb", "field": "ball.field.safetensors", "spheres": "ball.spheres.safetensors",
//!       "keys": [ { "time": 0, "translation": [0, 0, 1], "rotation": [0, 0, 0, 1], "scale": 1 } ] },
//!     { "name": "fox", "mesh": "fox.glb", "animation": "Walk", "loop": true, "keys": [ { "translation": [2, 0, 0] } ] } ],
//!   "lamps": [ { "name": "bulb", "radius": 0.2, "radiance": [9, 8, 7], "keys": [ { "translation": [0, 0, 3] } ] } ] }
//! ```
//!
//! What stands still is the name of a file, an object with `mesh` and `field`, or a list of such. What may be left out: `still`, `lamps`,
//! all of an entity but its name and mesh, and of a key all but what differs from resting at the origin at time 0. An
//! `animation` is that of a glTF file, by name or number; the keys then move the animated whole, and `spheres` may be a list, each of
//! a part that the animation moves. Translations and rotations, unit
//! quaternions x, y, z, w, are in Lobe's frame, z up; files are named relative to the description.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use lobe_io::{IoError, expect_file, one_line};
use lobe_scene::referenced_file;
use serde::Deserialize;

use crate::error::ShadowError;
use crate::lamp_description::LampDescription;
use crate::lamp_description::{LampJson, MAX_LAMPS};
use crate::track::Track;
use crate::track_json::{KeyJson, track_of};

/// The format that a description names, and the version that is read.
const FORMAT: &str = "lobe-scene";
const VERSION: u32 = 1;

/// The most bytes of a description: a thousand entities with a hundred keys each take about half of that.
const MAX_BYTES: u64 = 1 << 24;

/// The most parts: still ones, entities, and those of an animated one that files of spheres are for. Each is read from a file of its own, and hides the sky from all others.
const MAX_PARTS: usize = 1 << 14;

/// A scene whose entities are files of their own.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneDescription {
    /// What does not move.
    pub still: Vec<StillDescription>,
    /// What moves.
    pub entities: Vec<EntityDescription>,
    /// What shines near by.
    pub lamps: Vec<LampDescription>,
}

/// What stands still in a [`SceneDescription`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StillDescription {
    /// The file of its triangles, or `built-in:NAME`.
    pub mesh: PathBuf,
    /// The file of its occlusion field.
    pub field: Option<PathBuf>,
}

/// An entity of a [`SceneDescription`] that moves.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EntityDescription {
    /// The name in messages.
    pub name: String,
    /// The file of its triangles, or `built-in:NAME`.
    pub mesh: PathBuf,
    /// The file of its occlusion field.
    pub field: Option<PathBuf>,
    /// The files of its sphere sets: one at most of what moves as a whole, one for each part of what an animation moves.
    pub spheres: Vec<PathBuf>,
    /// The animation of a glTF file that is played.
    pub animation: Option<AnimationChoice>,
    /// Whether the animation begins anew when it has ended; else it rests.
    pub is_looped: bool,
    /// Its place over time.
    pub track: Track,
}

/// An animation of a file.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "expected the name or the number of an animation")]
pub enum AnimationChoice {
    /// By its name; where none has it, by the number that it may be.
    Name(String),
    /// By its number, whatever names there are.
    Number(u32),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneJson {
    format: String,
    version: u32,
    #[serde(default)]
    still: Option<StillsJson>,
    #[serde(default)]
    entities: Vec<EntityJson>,
    #[serde(default)]
    lamps: Vec<LampJson>,
}

/// One or several.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected the name of a file, an object with `mesh` and perhaps `field`, or a list of such"
)]
enum StillsJson {
    Several(Vec<StillJson>),
    One(StillJson),
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the name of a file, or an object with `mesh` and perhaps `field`")]
enum StillJson {
    Name(String),
    Files(StillFilesJson),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StillFilesJson {
    mesh: String,
    #[serde(default)]
    field: Option<String>,
}

/// One file or several.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the name of a file, or a list of such")]
enum NamesJson {
    One(String),
    Several(Vec<String>),
}

impl NamesJson {
    fn names(&self) -> &[String] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Several(several) => several,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntityJson {
    name: String,
    mesh: String,
    #[serde(default)]
    field: Option<String>,
    #[serde(default)]
    spheres: Option<NamesJson>,
    #[serde(default)]
    animation: Option<AnimationChoice>,
    #[serde(default, rename = "loop")]
    is_looped: bool,
    #[serde(default)]
    keys: Vec<KeyJson>,
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
        let json = parse(&read_bytes(path, &place)?, &place)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let named = |name: &str| -> Result<PathBuf, ShadowError> {
            let file = referenced_file(folder, name, allow_outside, &place)?;
            expect_file(&file)?;
            Ok(file)
        };
        let file = |name: &str| match is_built_in(name) {
            true => Ok(PathBuf::from(name)),
            false => named(name),
        };
        let optional = |name: &Option<String>| name.as_deref().map(file).transpose();
        let still = json.stills().map(|still| match still {
            StillJson::Name(mesh) => Ok(StillDescription { mesh: file(mesh)?, field: None }),
            StillJson::Files(StillFilesJson { mesh, field }) => {
                Ok(StillDescription { mesh: file(mesh)?, field: optional(field)? })
            }
        });
        let still = still.collect::<Result<_, ShadowError>>()?;
        let entities = json.entities.iter().map(|entity| {
            let within = |error: String| invalid(&place, format!("entity `{}`: {error}", one_line(&entity.name)));
            if entity.is_looped && entity.animation.is_none() {
                return Err(within("expected `loop` beside an `animation`, found it alone".to_owned()));
            }
            let spheres = entity.spheres.as_ref().map(NamesJson::names).unwrap_or_default();
            if spheres.len() > 1 && entity.animation.is_none() {
                let found = spheres.len();
                return Err(within(format!("expected one file of `spheres` without an `animation`, found {found}")));
            }
            Ok(EntityDescription {
                name: one_line(&entity.name),
                mesh: file(&entity.mesh)?,
                field: optional(&entity.field)?,
                spheres: spheres.iter().map(|name| file(name)).collect::<Result<_, _>>()?,
                animation: entity.animation.clone(),
                is_looped: entity.is_looped,
                track: track_of(&entity.keys).map_err(within)?,
            })
        });
        let entities = entities.collect::<Result<_, ShadowError>>()?;
        let lamps = json.lamps.iter().map(|lamp| {
            let name = one_line(&lamp.name);
            let within = |error: String| invalid(&place, format!("lamp `{name}`: {error}"));
            lamp.described(name.clone(), named, within)
        });
        let lamps = lamps.collect::<Result<_, ShadowError>>()?;
        Ok(Self { still, entities, lamps })
    }
}

impl SceneJson {
    fn stills(&self) -> impl ExactSizeIterator<Item = &StillJson> {
        match &self.still {
            None => [].iter(),
            Some(StillsJson::One(one)) => std::slice::from_ref(one).iter(),
            Some(StillsJson::Several(several)) => several.iter(),
        }
    }
}

/// The bytes of a description, whatever the system says of their number.
fn read_bytes(path: &Path, place: &str) -> Result<Vec<u8>, ShadowError> {
    let io = |source| IoError::io(path, source);
    let mut bytes = Vec::new();
    File::open(path).map_err(io)?.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(invalid(place, format!("expected a description of at most {MAX_BYTES} bytes, found more")));
    }
    Ok(bytes)
}

/// Whether a name stands for a scene in the program.
fn is_built_in(name: &str) -> bool {
    name.starts_with("built-in:")
}

fn parse(bytes: &[u8], place: &str) -> Result<SceneJson, ShadowError> {
    // Some editors put a byte order mark in front.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let json: SceneJson = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
        // The path of the whole is a dot, and that of a name that is cut off ends in a question mark.
        let path = error.path().to_string();
        let path = path.trim_end_matches(['.', '?']);
        let at = if path.is_empty() { String::new() } else { format!(" at {path}") };
        invalid(place, one_line(&format!("expected a description of a scene, found{at}: {}", error.inner())))
    })?;
    reader.end().map_err(|error| invalid(place, format!("expected the end of the description: {error}")))?;
    if json.format != FORMAT {
        let found = one_line(&json.format);
        return Err(invalid(place, format!("expected the format `{FORMAT}`, found `{found}`")));
    }
    if json.version != VERSION {
        return Err(invalid(place, format!("expected version {VERSION}, found {}; update Lobe", json.version)));
    }
    if json.stills().len() + json.entities.len() == 0 {
        return Err(invalid(place, "expected `still` or `entities`, found neither".to_owned()));
    }
    // Each file of spheres is for another part.
    let parts = |entity: &EntityJson| entity.spheres.as_ref().map_or(1, |spheres| spheres.names().len().max(1));
    let parts = json.stills().len() + json.entities.iter().map(parts).sum::<usize>();
    if parts > MAX_PARTS {
        return Err(invalid(place, format!("expected at most {MAX_PARTS} parts, found {parts}")));
    }
    if json.lamps.len() > MAX_LAMPS {
        return Err(invalid(place, format!("expected at most {MAX_LAMPS} lamps, found {}", json.lamps.len())));
    }
    Ok(json)
}

fn invalid(place: &str, message: String) -> ShadowError {
    ShadowError::Invalid { place: place.to_owned(), message }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use lobe_sh::Rgb;

    use super::*;
    use crate::field::lamp_surface::LampSurface;
    use crate::lamp_description::LampSource;

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
    fn a_byte_order_mark_in_front_is_no_part_of_a_description() {
        assert_eq!(read(&format!("\u{feff}{GOOD}")).unwrap(), read(GOOD).unwrap(), "with and without");
    }

    #[test]
    fn one_or_several_things_stand_still() {
        let stills = |text: &str| {
            let text = format!(r#"{{"format":"lobe-scene","version":1,"still":{text}}}"#);
            read(&text).unwrap().still.into_iter().map(|still| still.mesh.display().to_string()).collect::<Vec<_>>()
        };
        assert_eq!(stills(r#""built-in:cave""#), ["built-in:cave"], "a name");
        assert_eq!(stills(r#"{"mesh":"built-in:cave"}"#), ["built-in:cave"], "an object");
        let both = stills(r#"["built-in:ball",{"mesh":"built-in:cave"}]"#);
        assert_eq!(both, ["built-in:ball", "built-in:cave"], "a list");
    }

    #[test]
    fn animations_have_names_or_numbers() {
        let named = |name: &str| AnimationChoice::Name(name.to_owned());
        for (given, expected) in [("\"Walk\"", named("Walk")), ("\"3\"", named("3")), ("3", AnimationChoice::Number(3))]
        {
            let text = GOOD.replace("\"keys\"", &format!("\"animation\": {given}, \"loop\": true, \"keys\""));
            let entity = read(&text).unwrap().entities.remove(0);
            assert_eq!((entity.animation, entity.is_looped), (Some(expected), true), "{given}");
        }
    }

    #[test]
    fn lamps_are_shapes_or_files() {
        let lamps = |text: &str| {
            let text = GOOD.replace("\"entities\"", &format!("\"lamps\": [{text}], \"entities\""));
            read(&text).map(|scene| scene.lamps)
        };
        let lamp = lamps(r#"{"name":"a","radius":0.5,"radiance":[1,2,3],"keys":[{"translation":[0,0,4]}]}"#)
            .unwrap()
            .remove(0);
        assert_eq!(lamp.source, LampSource::Surface(LampSurface::ball(0.5, Rgb::new(1.0, 2.0, 3.0))), "a ball");
        assert_eq!(lamp.track.at(3.0).translation(), [0.0, 0.0, 4.0], "its place");
        let lamp = lamps(r#"{"name":"a","size":[2,1],"two_sided":true}"#).unwrap().remove(0);
        let panel = LampSurface::rectangle(crate::Rectangle::upright([2.0, 1.0], true), Rgb::new(1.0, 1.0, 1.0));
        assert_eq!(lamp.source, LampSource::Surface(panel), "a panel");
        for (text, expected) in [
            (r#"{"name":"a"}"#, "lamp `a`: expected one of `file`, `radius` and `size`"),
            (r#"{"radius":1}"#, "missing field `name`"),
            (r#"{"name":"a","radius":1,"size":[1,1]}"#, "expected one of `file`, `radius` and `size`, found several"),
            (r#"{"name":"a","radius":1,"file":"scene.json"}"#, "expected one of `file`, `radius` and `size`"),
            (r#"{"name":"a","radius":0}"#, "lamp `a`: expected a radius from 1e-15 to 1e15, found 0e0"),
            (r#"{"name":"a","radius":-1}"#, "found -1e0"),
            (r#"{"name":"a","radius":NaN}"#, "expected a description"),
            (r#"{"name":"a","radius":1e999}"#, "expected a description"),
            (r#"{"name":"a","size":[1,0]}"#, "a height from 1e-15"),
            (r#"{"name":"a","size":[1]}"#, "lamps[0].size"),
            (r#"{"name":"a","radius":1,"two_sided":true}"#, "a sphere, which has one side"),
            (r#"{"name":"a","radius":1,"radiance":[1,-1,1]}"#, "expected a radiance from 0 to 1e15"),
            (r#"{"name":"a","file":"scene.json","radiance":[1,1,1]}"#, "beside a `radius` or a `size`"),
            (r#"{"name":"a","radius":1,"keys":[{"scale":0}]}"#, "lamp `a`: key 0: expected a positive scale"),
            (r#"{"name":"a","file":"none.safetensors"}"#, "none.safetensors"),
            (r#"{"name":"a","file":"../x.safetensors"}"#, "outside of its folder"),
        ] {
            let message = lamps(text).unwrap_err().to_string();
            assert!(message.contains(expected) && !message.contains('\n'), "expected {expected:?} in: {message}");
        }
        let many = vec![r#"{"name":"a","radius":1}"#; MAX_LAMPS + 1].join(",");
        let message = lamps(&many).unwrap_err().to_string();
        assert!(message.ends_with("expected at most 256 lamps, found 257"), "{message}");
    }

    #[test]
    fn more_parts_than_any_scene_has_are_refused() {
        let stills = vec![r#""built-in:ball""#; MAX_PARTS + 1].join(",");
        let message =
            read(&format!(r#"{{"format":"lobe-scene","version":1,"still":[{stills}]}}"#)).unwrap_err().to_string();
        assert!(message.ends_with("expected at most 16384 parts, found 16385"), "{message}");
        let spheres = vec![r#""a""#; MAX_PARTS + 1].join(",");
        let entity = GOOD.replace("\"keys\"", &format!("\"animation\": 0, \"spheres\": [{spheres}], \"keys\""));
        let message = read(&entity).unwrap_err().to_string();
        assert!(message.ends_with("expected at most 16384 parts, found 16385"), "{message}");
    }

    #[test]
    fn bad_descriptions_are_one_line_that_says_where() {
        let with = |from: &str, to: &str| GOOD.replace(from, to);
        for (text, expected) in [
            (String::new(), "expected a description of a scene, found: EOF while parsing a value at line 1 column 0"),
            (
                "{".to_owned(),
                "expected a description of a scene, found: EOF while parsing an object at line 1 column 1",
            ),
            (GOOD[..14].to_owned(), "found at format: EOF while parsing"),
            (
                r#"{"entities":[{"name":"a""#.to_owned(),
                "found at entities[0]: EOF while parsing an object at line 1 column 24",
            ),
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
            (with("\"keys\"", "\"loop\": true, \"keys\""), "entity `ball`: expected `loop` beside an `animation`"),
            (with("\"keys\"", "\"animation\": [], \"keys\""), "entities[0].animation: expected the name or the number"),
            (
                with("\"keys\"", "\"spheres\": {}, \"keys\""),
                "entities[0].spheres: expected the name of a file, or a list",
            ),
            (
                with("\"keys\"", "\"spheres\": [\"a\", \"b\"], \"keys\""),
                "entity `ball`: expected one file of `spheres` without an `animation`, found 2",
            ),
            (with("\"entities\"", "\"still\": {}, \"entities\""), "still: expected the name of a file"),
            (
                with("[4, 0, 1]", "[4, 0, 1e16]"),
                "key 1: expected a translation of at most 1e15, found [4.0, 0.0, 1e16]",
            ),
            (with("\"time\": 2", "\"time\": -1e308"), "key 1: expected a time of at most 1e15 seconds, found -1e308"),
            (with("\"scale\": 2", "\"scale\": 1e-200"), "key 1: expected a scale from 1e-15 to 1e15, found 1e-200"),
        ] {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.contains(expected), "expected {expected:?} in: {message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }
}
