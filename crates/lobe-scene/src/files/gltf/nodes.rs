//! glTF nodes: the meshes of the default scene and their transforms, composed in `f64`.

use glam::{DMat4, DQuat, DVec3};

use crate::SceneError;
use crate::files::gltf::root::{GltfNode, Root};
use crate::files::source::Source;

/// An instance of a mesh by a node.
pub(crate) struct Shown {
    pub(crate) node: usize,
    pub(crate) mesh: usize,
    /// The transform from the mesh's space to the file's world, which is y-up, or to its origin there.
    pub(crate) world_from_mesh: DMat4,
}

/// The point of the file's world, y-up, from which transforms count.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Origin {
    pub(crate) point: DVec3,
    /// The node it was taken from. What is below that node is composed as if the node were near the origin of the
    /// world, so that its place makes no difference, not in the last digit either.
    pub(crate) node: Option<usize>,
}

/// The mesh instances of the default scene, and the places of all its nodes, in depth-first order from its roots.
pub(crate) struct Walk {
    pub(crate) shown: Vec<Shown>,
    pub(crate) places: Vec<(usize, DVec3)>,
}

/// Walks the nodes of the default scene.
///
/// glTF allows trees only. A node that is reached twice has two parents or is its own ancestor, and is refused.
pub(crate) fn walk(root: &Root, origin: &Origin, source: &Source<'_>) -> Result<Walk, SceneError> {
    let mut reached = vec![false; root.nodes.len()];
    let roots = roots(root, source)?.into_iter().rev();
    // Nodes with the transform of their parent, and whether that counts from the origin already.
    let mut stack: Vec<(usize, DMat4, bool)> = roots.map(|n| (n, DMat4::IDENTITY, false)).collect();
    let mut walk = Walk { shown: Vec::new(), places: Vec::new() };
    while let Some((index, world_from_parent, is_moved)) = stack.pop() {
        let Some(node) = root.nodes.get(index) else {
            return Err(source.invalid(format!("names node {index}, but there are {}", root.nodes.len())));
        };
        if std::mem::replace(&mut reached[index], true) {
            return Err(source.invalid(format!("node {index} is its own ancestor or has two parents")));
        }
        let mut world_from_node = world_from_parent * parent_from_node(node);
        if !world_from_node.is_finite() {
            return Err(source.invalid(format!("node {index} has a transform that is not finite")));
        }
        let mut from_origin = world_from_node;
        if !is_moved {
            from_origin.w_axis -= origin.point.extend(0.0);
        }
        if origin.node == Some(index) {
            world_from_node = from_origin;
        }
        let is_moved = is_moved || origin.node == Some(index);
        walk.places.push((index, world_from_node.w_axis.truncate()));
        if let Some(mesh) = node.mesh {
            walk.shown.push(Shown { node: index, mesh, world_from_mesh: from_origin });
        }
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|&child| (child, world_from_node, is_moved)));
    }
    Ok(walk)
}

/// The roots of the default scene; without a default, of the first scene; without any, the nodes without parent.
fn roots(root: &Root, source: &Source<'_>) -> Result<Vec<usize>, SceneError> {
    let index = root.scene;
    match (index, root.scenes.get(index.unwrap_or(0))) {
        (_, Some(scene)) => Ok(scene.nodes.clone()),
        (Some(index), None) => Err(source.invalid(format!("shows scene {index}, but there are {}", root.scenes.len()))),
        (None, None) => {
            let mut has_parent = vec![false; root.nodes.len()];
            for &child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
                if let Some(flag) = has_parent.get_mut(child) {
                    *flag = true;
                }
            }
            Ok((0..root.nodes.len()).filter(|&node| !has_parent[node]).collect())
        }
    }
}

fn parent_from_node(node: &GltfNode) -> DMat4 {
    if let Some(columns) = &node.matrix {
        return DMat4::from_cols_array(columns);
    }
    let vector = |v: Option<[f64; 3]>, default| v.map_or(default, DVec3::from);
    let turn = node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
    let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
    let (scale, shift) = (vector(node.scale, DVec3::ONE), vector(node.translation, DVec3::ZERO));
    DMat4::from_scale_rotation_translation(scale, turn, shift)
}
