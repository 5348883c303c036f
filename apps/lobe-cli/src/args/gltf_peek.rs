//! A look at what kind of scene a glTF file holds, before it is read.

use std::fs::File;
use std::io::{self, BufReader, Read as _};
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

/// What begins a .glb file, and the kind of its first chunk.
const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";

/// The few members of a glTF file that say what to read it for. Nothing else is kept; a file that is none has none of them.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(crate) struct GltfPeek {
    asset: Asset,
    animations: Vec<IgnoredAny>,
    skins: Vec<IgnoredAny>,
    meshes: Vec<Weighted>,
    nodes: Vec<Weighted>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Asset {
    extras: Value,
}

/// What may have weights of morph targets.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Weighted {
    weights: Vec<f64>,
}

impl GltfPeek {
    /// Of a glTF file: text if it is named .gltf.
    pub(crate) fn at(path: &Path) -> Self {
        Self::read(path).unwrap_or_default()
    }

    fn read(path: &Path) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(path)?);
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gltf")) {
            return Ok(serde_json::from_reader(file)?);
        }
        // Magic number, version and length; then the length and the kind of the first chunk.
        let mut header = [0; 20];
        file.read_exact(&mut header)?;
        if &header[..4] != MAGIC || &header[16..] != JSON {
            return Ok(Self::default());
        }
        let length = u32::from_le_bytes([header[12], header[13], header[14], header[15]]);
        Ok(serde_json::from_reader(file.take(u64::from(length)))?)
    }

    /// Whether the file carries transfer.
    pub(crate) fn is_baked(&self) -> bool {
        !self.asset.extras["lobe"].is_null()
    }

    /// Whether a pose differs from how the nodes stand.
    pub(crate) fn has_poses(&self) -> bool {
        let mut weighted = self.meshes.iter().chain(&self.nodes);
        !self.animations.is_empty()
            || !self.skins.is_empty()
            || weighted.any(|weighted| weighted.weights.iter().any(|w| *w != 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_seen_in_both_kinds_of_files() {
        let folder = tempfile::tempdir().unwrap();
        for (json, expected) in [
            (r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}]}"#, false),
            (r#"{"animations":[{"channels":[]}]}"#, true),
            (r#"{"skins":[{"joints":[0]}]}"#, true),
            (r#"{"meshes":[{"weights":[0,0.5]}]}"#, true),
            (r#"{"meshes":[{"weights":[0,0]}]}"#, false),
            ("no JSON", false),
        ] {
            let (text, binary) = (folder.path().join("a.gltf"), folder.path().join("a.glb"));
            std::fs::write(&text, json).unwrap();
            let length = (json.len() as u32).to_le_bytes();
            let header = [MAGIC, &2_u32.to_le_bytes(), &[0; 4], &length, JSON].concat();
            std::fs::write(&binary, [header, json.as_bytes().to_vec(), vec![0; 8]].concat()).unwrap();
            for path in [text, binary] {
                assert_eq!(GltfPeek::at(&path).has_poses(), expected, "{json} in {}", path.display());
            }
        }
        assert!(!GltfPeek::at(&folder.path().join("none.glb")).has_poses(), "no file");
    }
}
