//! Kinds of files, by their names and first bytes.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use lobe::image::FileFormat;
use lobe::scene::SceneFormat;
use lobe::sh::expansion::Quantity;
use serde_json::Value;

use crate::loading::place::given;
use crate::loading::scene_source::has_ending;
use crate::loading::sky_source;

/// The ending of descriptions of scenes.
pub(crate) const DESCRIPTION: &str = "json";

/// The ending of files of transfer, fields and spheres.
pub(crate) const TENSORS: &str = "safetensors";

/// The most bytes at the begin of a file of tensors or of an OpenEXR file that are looked at. Those of names of joints take most.
const HEAD: u64 = 1 << 20;

/// Formats of tensors, as files name them.
const FORMATS: [(&str, FileKind); 7] = [
    ("lobe-transfer-matrices", FileKind::Matrices),
    ("lobe-compressed-transfer", FileKind::Transfer),
    ("lobe-zonal-transfer", FileKind::Transfer),
    ("lobe-transfer", FileKind::Transfer),
    ("lobe-occlusion-field", FileKind::Field),
    ("lobe-spheres", FileKind::Spheres),
    ("lobe-morphed-spheres", FileKind::Spheres),
];

/// Formats that are shown as parts of something else, and how.
const PARTS: [(&str, &str); 3] = [
    ("lobe-lamp", "a lamp is placed by a description of a scene that moves (.json); open that"),
    (
        "lobe-neighbourhood-transfer",
        "transfer around an object lights what enters it; lobe sh incident takes the light at a point of it",
    ),
    ("lobe-visibility", "the visibility of an entity itself is for programs; the room of motion bakes its own"),
];

/// The format of lightmaps, in an attribute of an OpenEXR file.
const LIGHTMAP: &str = r#""format":"lobe-lightmap""#;

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    Scene,
    /// A description of a scene that moves.
    Description,
    Sky,
    /// An expansion of anything but radiance.
    Function,
    /// Of the vertices of a scene, or of the texels of its lightmap.
    Transfer,
    /// Transfer matrices of the vertices of a scene.
    Matrices,
    /// What a part of a moving scene hides around it.
    Field,
    /// The spheres that stand for a part.
    Spheres,
}

impl FileKind {
    /// The kind of a file.
    ///
    /// # Errors
    /// One line that says what can be opened, or what is wrong with a file of tensors or of an expansion.
    pub(crate) fn of(path: &Path) -> Result<Self, String> {
        if SceneFormat::of_name(path).is_some() {
            return Ok(Self::Scene);
        }
        if sky_source::is_expansion(path) {
            let file = sky_source::read_expansion(path).map_err(|error| error.to_string())?;
            return Ok(if file.quantity == Quantity::Radiance { Self::Sky } else { Self::Function });
        }
        if sky_source::is_sky(path) {
            return Ok(if Self::is_lightmap(path) { Self::Transfer } else { Self::Sky });
        }
        if has_ending(path, &[DESCRIPTION]) {
            return Ok(Self::Description);
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if has_ending(path, &[TENSORS]) {
            let head = head_of(path).map_err(|error| format!("{name}: {error}"))?;
            let format = format_of(&head).unwrap_or_default();
            if let Some((_, advice)) = PARTS.into_iter().find(|(known, _)| *known == format) {
                return Err(format!("{name}: {advice}"));
            }
            let found = FORMATS.into_iter().find(|(known, _)| *known == format);
            return found.map(|(_, kind)| kind).ok_or_else(|| {
                format!(
                    "{name}: expected transfer, transfer matrices, an occlusion field or spheres of Lobe, found other tensors"
                )
            });
        }
        let (scenes, skies) = (SceneFormat::names(|_| true), FileFormat::names(|_| true));
        Err(format!(
            "{name}: nothing to show by itself; this opens scenes ({scenes}), descriptions (.{DESCRIPTION}), skies ({skies}), .sh.json and .{TENSORS}"
        ))
    }
}

impl FileKind {
    /// Whether a file is a lightmap of transfer; what cannot be read is none.
    pub(crate) fn is_lightmap(path: &Path) -> bool {
        let is_named = |head: Vec<u8>| head.windows(LIGHTMAP.len()).any(|text| text == LIGHTMAP.as_bytes());
        has_ending(path, &["exr"]) && head_of(path).is_ok_and(is_named)
    }
}

/// The format that a file of tensors names: eight bytes are the length of a header of JSON, of whose metadata `lobe` is again JSON.
fn format_of(head: &[u8]) -> Option<String> {
    let (length, rest) = head.split_first_chunk()?;
    let header = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    let header: Value = serde_json::from_slice(header).ok()?;
    let about: Value = serde_json::from_str(header["__metadata__"]["lobe"].as_str()?).ok()?;
    Some(about["format"].as_str()?.to_owned())
}

fn head_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    match given(path) {
        Some(all) => bytes.extend(all.iter().take(HEAD as usize)),
        None => drop(File::open(path)?.take(HEAD).read_to_end(&mut bytes)?),
    }
    Ok(bytes)
}
