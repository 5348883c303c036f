//! Sphere sets as safetensors.

use std::path::Path;

use crate::spheres::sphere_set::check;
use crate::spheres::tensors::{Tensor, TensorFile, load, write};
use crate::{ShadowError, Skin, SphereSet};

const SPHERES: &str = "lobe-spheres";

/// Writes a set: tensors `centers` of `[n, 3]` and `radii` of `[n]` floats, and of a set with a [`Skin`] also
/// `joints`, 16-bit numbers, and `weights`, floats, both of `[n, 4]`.
///
/// The metadata's entry `lobe` is JSON: format `lobe-spheres`, version 1, and `origin`, the point of the mesh's own frame from
/// which the centers count. Until all is written, nothing has the file's name.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses.
pub fn write_spheres(path: impl AsRef<Path>, set: &SphereSet) -> Result<(), ShadowError> {
    let n = set.len();
    let mut tensors = vec![
        Tensor::f32("centers", vec![n, 3], set.centers().as_flattened()),
        Tensor::f32("radii", vec![n], set.radii()),
    ];
    if let Some(skin) = set.skin() {
        tensors.push(Tensor::u16("joints", vec![n, 4], skin.joints().as_flattened()));
        tensors.push(Tensor::f32("weights", vec![n, 4], skin.weights().as_flattened()));
    }
    write(path.as_ref(), SPHERES, set.origin(), &tensors)
}

/// Reads what [`write_spheres`] wrote. A set without spheres and spheres of radius 0 are read as they are.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours or contradicts
/// itself.
pub fn read_spheres(path: impl AsRef<Path>) -> Result<SphereSet, ShadowError> {
    let path = path.as_ref();
    read_spheres_bytes(&load(path)?, &path.display().to_string())
}

/// [`read_spheres`] from the bytes of a file, whose name stands in messages. Nothing is allocated that is larger than
/// they are.
///
/// # Errors
/// As [`read_spheres`].
pub fn read_spheres_bytes(bytes: &[u8], name: &str) -> Result<SphereSet, ShadowError> {
    let file = TensorFile::parse(bytes, name, SPHERES)?;
    let within = |error: ShadowError| file.invalid(error.to_string());
    let centers = file.f32("centers", 3)?.as_chunks().0.to_vec();
    let radii = file.f32("radii", 0)?;
    check(&centers, &radii).map_err(|message| file.invalid(message))?;
    let set = SphereSet::new(centers, radii).and_then(|set| set.with_origin(file.origin)).map_err(within)?;
    if !file.has("joints") && !file.has("weights") {
        return Ok(set);
    }
    let joints = file.u16("joints", 4)?.as_chunks().0.to_vec();
    let weights = file.f32("weights", 4)?.as_chunks().0.to_vec();
    set.with_skin(Skin::from_normalized(joints, weights).map_err(within)?).map_err(within)
}
