//! glTF nodes: the meshes of the default scene and their transforms, composed in `f64`.

use glam::{DMat4, DQuat, DVec3};

use crate::error::SceneError;
use crate::files::gltf::root::{GltfNode, Root};
use crate::files::source::Source;
use crate::scene::transform::{Local, Trs};

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

/// The nodes of a scene in depth-first order from its roots: parents stand before their children.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// Each node, and the place of its parent in this list.
    order: Vec<(usize, Option<usize>)>,
}

/// The place of a node in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct World {
    pub(crate) node: usize,
    /// From the node's space to the world, y-up, or to its origin below the node that this was taken from.
    world_from_node: DMat4,
    /// From the node's space to the origin.
    pub(crate) origin_from_node: DMat4,
}

impl Tree {
    /// The nodes of the default scene.
    ///
    /// glTF allows trees only. A node that is reached twice has two parents or is its own ancestor, and is refused.
    pub(crate) fn of(root: &Root, source: &Source<'_>) -> Result<Self, SceneError> {
        let mut reached = vec![false; root.nodes.len()];
        let mut stack: Vec<_> = roots(root, source)?.into_iter().rev().map(|node| (node, None)).collect();
        let mut order = Vec::new();
        while let Some((index, parent)) = stack.pop() {
            let Some(node) = root.nodes.get(index) else {
                return Err(source.invalid(format!("names node {index}, but there are {}", root.nodes.len())));
            };
            if std::mem::replace(&mut reached[index], true) {
                return Err(source.invalid(format!("node {index} is its own ancestor or has two parents")));
            }
            let place = order.len();
            order.push((index, parent));
            stack.extend(node.children.iter().flatten().rev().map(|&child| (child, Some(place))));
        }
        Ok(Self { order })
    }

    /// Nodes in the order of their indices, of these parents, each of which stands before its children.
    pub(crate) fn of_parents(parents: &[Option<usize>]) -> Self {
        Self { order: parents.iter().copied().enumerate().collect() }
    }

    /// The nodes, parents before their children.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = usize> {
        self.order.iter().map(|&(node, _)| node)
    }

    /// Each node with its parent, parents before their children.
    pub(crate) fn with_parents(&self) -> impl Iterator<Item = (usize, Option<usize>)> {
        self.order.iter().map(|&(node, parent)| (node, parent.map(|place| self.order[place].0)))
    }

    /// Whether each node is seen, in the order of the nodes: one that is not visible hides all below it.
    fn seen(&self, root: &Root) -> Vec<bool> {
        let mut seen: Vec<bool> = Vec::with_capacity(self.order.len());
        for &(node, parent) in &self.order {
            seen.push(root.nodes[node].is_visible() && parent.is_none_or(|place| seen[place]));
        }
        seen
    }

    /// The places of all nodes, composed of their transforms relative to their parents, in the order of the nodes.
    pub(crate) fn worlds(&self, origin: &Origin, parent_from_node: impl Fn(usize) -> DMat4) -> Vec<World> {
        // With each node whether its transform counts from the origin already.
        let mut worlds: Vec<(World, bool)> = Vec::with_capacity(self.order.len());
        for &(node, parent) in &self.order {
            let (world_from_parent, is_moved) =
                parent.map_or((DMat4::IDENTITY, false), |place| (worlds[place].0.world_from_node, worlds[place].1));
            let mut world_from_node = world_from_parent * parent_from_node(node);
            let mut origin_from_node = world_from_node;
            if !is_moved {
                origin_from_node.w_axis -= origin.point.extend(0.0);
            }
            if origin.node == Some(node) {
                world_from_node = origin_from_node;
            }
            let is_moved = is_moved || origin.node == Some(node);
            worlds.push((World { node, world_from_node, origin_from_node }, is_moved));
        }
        worlds.into_iter().map(|(world, _)| world).collect()
    }
}

/// The mesh instances of the default scene that are visible, and the places of all its nodes, in depth-first order from
/// its roots.
pub(crate) struct Walk {
    pub(crate) shown: Vec<Shown>,
    pub(crate) places: Vec<(usize, DVec3)>,
}

/// Walks the nodes of the default scene as the file says that they stand.
pub(crate) fn walk(root: &Root, origin: &Origin, source: &Source<'_>) -> Result<Walk, SceneError> {
    let tree = Tree::of(root, source)?;
    let worlds = tree.worlds(origin, |node| local(&root.nodes[node]).matrix());
    let mut walk = Walk { shown: Vec::new(), places: Vec::new() };
    for (World { node, world_from_node, origin_from_node }, is_seen) in worlds.into_iter().zip(tree.seen(root)) {
        if !world_from_node.is_finite() {
            return Err(source.invalid(format!("node {node} has a transform that is not finite")));
        }
        walk.places.push((node, world_from_node.w_axis.truncate()));
        if let Some(mesh) = root.nodes[node].mesh.filter(|_| is_seen) {
            walk.shown.push(Shown { node, mesh, world_from_mesh: origin_from_node });
        }
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

/// The transform of a node relative to its parent, as the file says that it stands.
pub(crate) fn local(node: &GltfNode) -> Local {
    if let Some(columns) = &node.matrix {
        return Local::Matrix(DMat4::from_cols_array(columns));
    }
    let vector = |v: Option<[f64; 3]>, default| v.map_or(default, DVec3::from);
    Local::Trs(Trs {
        translation: vector(node.translation, DVec3::ZERO),
        rotation: node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array),
        scale: vector(node.scale, DVec3::ONE),
    })
}
