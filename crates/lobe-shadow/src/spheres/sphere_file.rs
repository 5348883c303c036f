//! Sphere sets and their hierarchies as safetensors.

use std::path::Path;

use crate::spheres::sphere_set::check;
use crate::spheres::tensors::{Tensor, TensorFile, load, write};
use crate::{ShadowError, Skin, SphereHierarchy, SphereNode, SphereSet};

const SPHERES: &str = "lobe-spheres";
const HIERARCHY: &str = "lobe-sphere-hierarchy";

/// Writes a set: tensors `centers` of `[n, 3]` and `radii` of `[n]` floats, and of a set with a [`Skin`] also
/// `joints`, 16-bit numbers, and `weights`, floats, both of `[n, 4]`.
///
/// The metadata's entry `lobe` is JSON: format `lobe-spheres`, version 1, and `origin`, the point of the mesh's own frame from
/// which the centers count. Until all is written, nothing has the file's
/// name.
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

/// Writes a hierarchy: tensors `balls` of `[nodes, 4]` floats (center, radius), `links` of `[nodes, 4]` 32-bit numbers
/// (first child, children, first leaf, leaves) and `leaves` of `[n]`, the order of the spheres.
///
/// The metadata's entry `lobe` is JSON: format `lobe-sphere-hierarchy`, version 1, and `origin`, that of the set.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses.
pub fn write_sphere_hierarchy(path: impl AsRef<Path>, hierarchy: &SphereHierarchy) -> Result<(), ShadowError> {
    let nodes = hierarchy.nodes();
    let balls: Vec<f32> = nodes.iter().flat_map(|n| [n.center[0], n.center[1], n.center[2], n.radius]).collect();
    let links: Vec<u32> = nodes.iter().flat_map(|n| [n.first_child, n.children, n.first_leaf, n.leaf_count]).collect();
    let tensors = [
        Tensor::f32("balls", vec![nodes.len(), 4], &balls),
        Tensor::u32("links", vec![nodes.len(), 4], &links),
        Tensor::u32("leaves", vec![hierarchy.leaves().len()], hierarchy.leaves()),
    ];
    write(path.as_ref(), HIERARCHY, hierarchy.origin(), &tensors)
}

/// Reads what [`write_sphere_hierarchy`] wrote.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours or contradicts
/// itself.
pub fn read_sphere_hierarchy(path: impl AsRef<Path>) -> Result<SphereHierarchy, ShadowError> {
    let path = path.as_ref();
    read_sphere_hierarchy_bytes(&load(path)?, &path.display().to_string())
}

/// [`read_sphere_hierarchy`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_sphere_hierarchy`].
pub fn read_sphere_hierarchy_bytes(bytes: &[u8], name: &str) -> Result<SphereHierarchy, ShadowError> {
    let file = TensorFile::parse(bytes, name, HIERARCHY)?;
    let (balls, links, leaves) = (file.f32("balls", 4)?, file.u32("links", 4)?, file.u32("leaves", 0)?);
    if balls.len() != links.len() {
        let message = format!("expected as many links as balls, found {} and {}", links.len() / 4, balls.len() / 4);
        return Err(file.invalid(message));
    }
    let node = |(ball, link): (&[f32; 4], &[u32; 4])| SphereNode {
        center: [ball[0], ball[1], ball[2]],
        radius: ball[3],
        first_child: link[0],
        children: link[1],
        first_leaf: link[2],
        leaf_count: link[3],
    };
    let nodes = balls.as_chunks().0.iter().zip(links.as_chunks().0).map(node).collect();
    let hierarchy = SphereHierarchy::from_parts(nodes, leaves).and_then(|tree| tree.with_origin(file.origin));
    hierarchy.map_err(|error| file.invalid(error.to_string()))
}
