//! Sphere sets as safetensors.

use std::path::Path;

use lobe_io::{Numbers, Tensor, TensorFile, TensorFormat, read_file, write_tensors};
use serde::{Deserialize, Serialize};

use crate::error::ShadowError;
use crate::spheres::morphs::NUMBERS;
use crate::spheres::morphs::SphereMorphs;
use crate::spheres::skeleton::Skeleton;
use crate::spheres::skin::Skin;
use crate::spheres::sphere_set::SphereSet;
use crate::spheres::sphere_set::check;

/// The most bytes of a file: those of the most spheres of a set, and many times the names that joints have.
const MOST_BYTES: u64 = 1 << 26;

const SPHERES: TensorFormat = TensorFormat { name: "lobe-spheres", version: 1, if_older: "make the spheres anew" };

/// Of spheres that follow morph targets, which must not be taken for others.
const MORPHED: TensorFormat = TensorFormat { name: "lobe-morphed-spheres", ..SPHERES };

#[derive(Serialize, Deserialize)]
struct Header {
    #[serde(default)]
    origin: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    skeleton: Option<Skeleton>,
    /// The weights of morph targets in the shape that spheres were fitted to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    morph_weights: Vec<f64>,
}

/// Writes a set: tensors `centers` of `[n, 3]` and `radii` of `[n]` floats, and of a set with a [`Skin`] also
/// `joints`, 16-bit numbers, and `weights`, floats, both of `[n, 4]`. Of one that follows `t` morph targets `morphs`,
/// floats of
/// `[n, t, 12]`.
///
/// The metadata's entry `lobe` is JSON: format `lobe-spheres`, or `lobe-morphed-spheres` if they follow morph targets,
/// version 1, `origin`, the point of the mesh's own frame from which the centers count, and of a set that is bound to
/// an entity its [`Skeleton`]: `skeleton`, an object of `entity`, `node` and
/// `joints`; `morph_weights` are those of the shape that spheres that follow morph targets were fitted to. Until all is
/// written, nothing has the file's name.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses.
pub fn write_spheres(path: impl AsRef<Path>, set: &SphereSet) -> Result<(), ShadowError> {
    let n = set.len();
    let mut tensors = vec![
        Tensor::new("centers", [n, 3], Numbers::F32(set.centers().as_flattened())),
        Tensor::new("radii", [n], Numbers::F32(set.radii())),
    ];
    if let Some(skin) = set.skin() {
        tensors.push(Tensor::new("joints", [n, 4], Numbers::U16(skin.joints().as_flattened())));
        tensors.push(Tensor::new("weights", [n, 4], Numbers::F32(skin.weights().as_flattened())));
    }
    let morph_weights = set.morphs().map(|morphs| morphs.weights().to_vec()).unwrap_or_default();
    if let Some(morphs) = set.morphs() {
        let shape = [n, morph_weights.len(), NUMBERS];
        tensors.push(Tensor::new("morphs", shape, Numbers::F32(morphs.changes().as_flattened())));
    }
    let header = Header { origin: set.origin(), skeleton: set.skeleton().cloned(), morph_weights };
    let format = if set.morphs().is_some() { MORPHED } else { SPHERES };
    Ok(write_tensors(path.as_ref(), format, &header, &tensors)?)
}

/// Reads what [`write_spheres`] wrote. A set without spheres and spheres of radius 0 are read as they are.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours, contradicts
/// itself, is longer than 64 MiB, or has more spheres than [a set](SphereSet::new).
pub fn read_spheres(path: impl AsRef<Path>) -> Result<SphereSet, ShadowError> {
    let path = path.as_ref();
    // What cannot be a set is not read.
    if let Some(found) = std::fs::metadata(path).ok().map(|file| file.len()).filter(|found| *found > MOST_BYTES) {
        let message = format!("expected spheres in a file of at most {MOST_BYTES} bytes, found {found}");
        return Err(ShadowError::Invalid { place: path.display().to_string(), message });
    }
    read_spheres_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_spheres`] from the bytes of a file, whose name stands in messages. Nothing is allocated that is larger than
/// they are.
///
/// # Errors
/// As [`read_spheres`].
pub fn read_spheres_bytes(bytes: &[u8], name: &str) -> Result<SphereSet, ShadowError> {
    let file = TensorFile::parse(bytes, name, &[SPHERES, MORPHED])?;
    let within = |error: ShadowError| file.invalid(error.to_string());
    let Header { origin, skeleton, morph_weights } = file.header()?;
    let centers = file.f32("centers", &[None, Some(3)])?.as_chunks().0.to_vec();
    let radii = file.f32("radii", &[None])?;
    check(&centers, &radii).map_err(|message| file.invalid(message))?;
    let mut set = SphereSet::new(centers, radii).and_then(|set| set.with_origin(origin)).map_err(within)?;
    if file.has("joints") || file.has("weights") {
        let joints = file.u16("joints", &[None, Some(4)])?.as_chunks().0.to_vec();
        let weights = file.f32("weights", &[None, Some(4)])?.as_chunks().0.to_vec();
        let skin = Skin::from_normalized(joints, weights).map_err(within)?;
        set = set.with_skin(skin).map_err(within)?;
    }
    if file.has("morphs") || !morph_weights.is_empty() {
        let changes = file.f32("morphs", &[None, Some(morph_weights.len()), Some(NUMBERS)])?.as_chunks().0.to_vec();
        let morphs = SphereMorphs::new(morph_weights, changes).map_err(within)?;
        set = set.with_morphs(Some(morphs)).map_err(within)?;
    }
    if let Some(skeleton) = skeleton {
        set = set.with_skeleton(skeleton).map_err(within)?;
    }
    Ok(set)
}
