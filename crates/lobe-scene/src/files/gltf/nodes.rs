//! glTF nodes: the meshes of the default scene and their transforms.

use glam::{DMat4, DQuat, DVec3};
use gltf_json::Node;

use crate::SceneError;
use crate::files::gltf::root::Root;
use crate::files::source::Source;

/// An instance of a mesh by a node.
pub(crate) struct Shown {
    pub(crate) node: usize,
    pub(crate) mesh: usize,
    /// The transform from the mesh's space to the file's world, which is y-up.
    pub(crate) world_from_mesh: DMat4,
}

/// The mesh instances of the default scene, in depth-first order from its roots.
///
/// glTF allows trees only. A node that is reached twice has two parents or is its own ancestor, and is refused.
pub(crate) fn shown_meshes(root: &Root, source: &Source<'_>) -> Result<Vec<Shown>, SceneError> {
    let mut reached = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, DMat4)> = roots(root, source)?.into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
    let mut shown = Vec::new();
    while let Some((index, world_from_parent)) = stack.pop() {
        let Some(node) = root.nodes.get(index) else {
            return Err(source.invalid(format!("names node {index}, but there are {}", root.nodes.len())));
        };
        if std::mem::replace(&mut reached[index], true) {
            return Err(source.invalid(format!("node {index} is its own ancestor or has two parents")));
        }
        let world_from_node = world_from_parent * parent_from_node(node);
        if !world_from_node.is_finite() {
            return Err(source.invalid(format!("node {index} has a transform that is not finite")));
        }
        if let Some(mesh) = node.mesh {
            shown.push(Shown { node: index, mesh: mesh.value(), world_from_mesh: world_from_node });
        }
        stack.extend(node.children.iter().flatten().rev().map(|child| (child.value(), world_from_node)));
    }
    Ok(shown)
}

/// The roots of the default scene; without a default, of the first scene; without any, the nodes without parent.
fn roots(root: &Root, source: &Source<'_>) -> Result<Vec<usize>, SceneError> {
    let index = root.scene;
    match (index, root.scenes.get(index.unwrap_or(0))) {
        (_, Some(scene)) => Ok(scene.nodes.clone()),
        (Some(index), None) => Err(source.invalid(format!("shows scene {index}, but there are {}", root.scenes.len()))),
        (None, None) => {
            let mut has_parent = vec![false; root.nodes.len()];
            for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
                if let Some(flag) = has_parent.get_mut(child.value()) {
                    *flag = true;
                }
            }
            Ok((0..root.nodes.len()).filter(|&node| !has_parent[node]).collect())
        }
    }
}

fn parent_from_node(node: &Node) -> DMat4 {
    if let Some(columns) = node.matrix {
        return DMat4::from_cols_array(&columns.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, default| v.map_or(default, |v| DVec3::from(v.map(f64::from)));
    let turn = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
    let (scale, shift) = (vector(node.scale, DVec3::ONE), vector(node.translation, DVec3::ZERO));
    DMat4::from_scale_rotation_translation(scale, turn, shift)
}
