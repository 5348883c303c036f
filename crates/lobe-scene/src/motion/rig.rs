//! The nodes of a scene: how they hang together, and where they stand.

use glam::{DMat4, DVec3};

use crate::Up;
use crate::files::gltf::nodes::{Origin, Tree};
use crate::motion::animation::{Animation, Property, State};
use crate::scene::transform::{Local, Trs};

/// The nodes of a scene, as they are without animation.
#[derive(Clone, Debug)]
pub(crate) struct Rig {
    pub(crate) tree: Tree,
    pub(crate) rest: State,
    pub(crate) names: Vec<Option<String>>,
    /// The point from which places count.
    pub(crate) origin: Origin,
    /// What the origin of the scene adds to that, in the file's axes.
    pub(crate) shift: DVec3,
    /// The axis of the nodes and meshes that is up in the world.
    pub(crate) up: Up,
}

impl Rig {
    /// Nodes of these names, transforms and parents, z up, each parent before its children.
    pub(crate) fn upright(nodes: Vec<(String, Trs, Option<usize>)>) -> Self {
        let parents: Vec<_> = nodes.iter().map(|&(.., parent)| parent).collect();
        Self {
            tree: Tree::of_parents(&parents),
            rest: State {
                locals: nodes.iter().map(|&(_, trs, _)| Local::Trs(trs)).collect(),
                weights: vec![Vec::new(); nodes.len()],
            },
            names: nodes.into_iter().map(|(name, ..)| Some(name)).collect(),
            origin: Origin::default(),
            shift: DVec3::ZERO,
            up: Up::Z,
        }
    }

    /// The transforms from the spaces of all nodes to the scene, in the file's axes; those of nodes outside of the scene
    /// are the identity.
    pub(crate) fn worlds(&self, state: &State) -> Vec<DMat4> {
        let mut all = vec![DMat4::IDENTITY; state.locals.len()];
        for world in self.tree.worlds(&self.origin, |node| state.locals[node].matrix()) {
            let mut matrix = world.origin_from_node;
            matrix.w_axis -= self.shift.extend(0.0);
            all[world.node] = matrix;
        }
        all
    }

    /// Whether each node is moved by an animation, itself or below a node that is.
    pub(crate) fn moved_by(&self, animation: &Animation) -> Vec<bool> {
        let mut moved = vec![false; self.rest.locals.len()];
        let channels = animation.channels.iter().filter(|channel| channel.property != Property::Weights);
        channels.filter(|channel| !channel.is_idle(&self.rest)).for_each(|channel| moved[channel.node] = true);
        for (node, parent) in self.tree.with_parents() {
            moved[node] |= parent.is_some_and(|parent| moved[parent]);
        }
        moved
    }

    /// Whether the mesh of each node is morphed by an animation.
    pub(crate) fn morphed_by(&self, animation: &Animation) -> Vec<bool> {
        let mut morphed = vec![false; self.rest.locals.len()];
        let channels = animation.channels.iter().filter(|channel| channel.property == Property::Weights);
        channels.filter(|channel| !channel.is_idle(&self.rest)).for_each(|channel| morphed[channel.node] = true);
        morphed
    }
}
