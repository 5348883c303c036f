//! Skins of glTF files.

use glam::{DMat4, DVec4};
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index};
use serde::Deserialize;

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::GltfFile;
use crate::files::source::Source;
use crate::motion::numbers::{Numbers, members};
use crate::motion::rig::Rig;
use crate::motion::skin::{Influences, Skin};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct GltfSkin {
    name: Option<String>,
    #[serde(default)]
    joints: Vec<usize>,
    inverse_bind_matrices: Option<Index<Accessor>>,
}

/// The skins of a file. They are read when a mesh of the scene is carried by them; others need not be right.
pub(crate) struct Skins<'a> {
    file: &'a GltfFile,
    json: Vec<GltfSkin>,
    read: Vec<Option<Skin>>,
    is_in_scene: Vec<bool>,
}

impl<'a> Skins<'a> {
    pub(crate) fn of(file: &'a GltfFile, rig: &Rig, source: &Source<'_>) -> Result<Self, SceneError> {
        let json = members::<GltfSkin>(file, "skins", source)?;
        let mut is_in_scene = vec![false; rig.rest.locals.len()];
        rig.tree.nodes().for_each(|node| is_in_scene[node] = true);
        Ok(Self { file, read: vec![None; json.len()], json, is_in_scene })
    }

    /// The number of joints of the skin of a node, which is read and checked.
    pub(crate) fn joints(
        &mut self,
        (index, node): (usize, usize),
        numbers: &mut Numbers,
        source: &mut Source<'_>,
    ) -> Result<usize, SceneError> {
        let count = self.json.len();
        let Some(json) = self.json.get(index) else {
            return Err(source.invalid(format!("node {node} has skin {index}, but there are {count}")));
        };
        if self.read[index].is_none() {
            self.read[index] = Some(skin(self.file, (index, json), &self.is_in_scene, numbers, source)?);
        }
        Ok(json.joints.len())
    }

    /// All skins in their order; those that were not read have no joints.
    pub(crate) fn into_all(self) -> Vec<Skin> {
        let empty = |json: GltfSkin| Skin { name: json.name, joints: Vec::new(), inverse_binds: Vec::new() };
        self.read.into_iter().zip(self.json).map(|(skin, json)| skin.unwrap_or_else(|| empty(json))).collect()
    }
}

fn skin(
    file: &GltfFile,
    (index, json): (usize, &GltfSkin),
    is_in_scene: &[bool],
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Skin, SceneError> {
    let place = match &json.name {
        Some(name) => format!("skin `{name}`"),
        None => format!("skin {index}"),
    };
    if json.joints.is_empty() {
        return Err(source.invalid(format!("{place}: expected joints, found none")));
    }
    for &joint in &json.joints {
        let fault = match is_in_scene.get(joint) {
            Some(true) => continue,
            Some(false) => format!("its joint node {joint} is not in the scene"),
            None => format!("names joint node {joint}, but there are {} nodes", is_in_scene.len()),
        };
        return Err(source.invalid(format!("{place}: {fault}")));
    }
    // A matrix of 128 bytes for each joint.
    numbers.add(json.joints.len().saturating_mul(32), source)?;
    let inverse_binds = match json.inverse_bind_matrices {
        Some(accessor) => inverse_binds(file, accessor, json.joints.len(), &place, numbers, source)?,
        None => vec![DMat4::IDENTITY; json.joints.len()],
    };
    Ok(Skin { name: json.name.clone(), joints: json.joints.clone(), inverse_binds })
}

fn inverse_binds(
    file: &GltfFile,
    accessor: Index<Accessor>,
    joints: usize,
    place: &str,
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Vec<DMat4>, SceneError> {
    let values = numbers.of::<16>(("inverse bind matrices", place), (file, accessor), source)?;
    let (matrices, _) = values.as_chunks::<16>();
    // glTF allows more than are used.
    if matrices.len() < joints {
        let found = matrices.len();
        return Err(source.invalid(format!("{place}: expected {joints} inverse bind matrices, found {found}")));
    }
    let mut all = Vec::with_capacity(joints);
    for (joint, columns) in matrices[..joints].iter().enumerate() {
        let mut matrix = DMat4::from_cols_array(&columns.map(f64::from)).transpose();
        // The last row is 0, 0, 0, 1 in glTF; what rounding has made of it does not count.
        matrix.w_axis = DVec4::W;
        let matrix = matrix.transpose();
        if !matrix.is_finite() {
            return Err(source.invalid(format!("{place}: the inverse bind matrix of joint {joint} is not finite")));
        }
        all.push(matrix);
    }
    Ok(all)
}

/// The joints and weights of a primitive's vertices, of all sets; `None` if it has no set.
pub(crate) fn influences(
    (file, place): (&GltfFile, &str),
    primitive: &Primitive,
    vertices: usize,
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Option<Influences>, SceneError> {
    let accessors = Accessors { file, place: place.to_owned() };
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for set in 0.. {
        let pair = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)));
        let (of_joints, of_weights) = match pair {
            (None, None) => break,
            (Some(of_joints), Some(of_weights)) => (of_joints, of_weights),
            (Some(_), None) => return Err(source.invalid(format!("{place}: has JOINTS_{set}, but no WEIGHTS_{set}"))),
            (None, Some(_)) => return Err(source.invalid(format!("{place}: has WEIGHTS_{set}, but no JOINTS_{set}"))),
        };
        for (what, index) in [("JOINTS", of_joints), ("WEIGHTS", of_weights)] {
            let found = accessors.count(index, source)?;
            if found != vertices {
                return Err(
                    source.invalid(format!("{place}: expected {vertices} elements of {what}_{set}, found {found}"))
                );
            }
        }
        // Joints and weights as they are read, and as pairs: 8, 16, 32 and 4 bytes.
        numbers.add(vertices.saturating_mul(15), source)?;
        joints.push(accessors.joints(&format!("JOINTS_{set}"), of_joints, source)?);
        weights.push(accessors.vectors::<4>(&format!("WEIGHTS_{set}"), of_weights, source)?);
    }
    if joints.is_empty() {
        return Ok(None);
    }
    let of_vertex = |vertex: usize| {
        let sets = joints.iter().zip(&weights);
        sets.flat_map(move |(joints, weights)| joints[vertex].into_iter().zip(weights[vertex]))
    };
    let found = Influences::new((0..vertices).map(of_vertex));
    let found = found.map_err(|message| source.invalid(format!("{place}: {message}")))?;
    let vertices = |count: usize| if count == 1 { "1 vertex".to_owned() } else { format!("{count} vertices") };
    let (off, most) = found.off_one;
    if off > 0 {
        source.note(format!(
            "{place} has {} whose weights do not sum to one, by up to {most:.2e}: they are divided by their sum",
            vertices(off)
        ));
    }
    if found.without > 0 {
        let count = vertices(found.without);
        source.note(format!("{place} has {count} whose weights are all zero, which follow the first joint named"));
    }
    Ok(Some(found))
}
