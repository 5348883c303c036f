//! The nodes of a scene: how they hang together, and where they stand.

use glam::{DMat4, DVec3};

use crate::files::gltf::nodes::{Origin, Tree};
use crate::motion::animation::{Animation, Property, State};
use crate::scene::transform::{Local, Trs};
use crate::scene::up::Up;

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

/// What animations change.
pub(crate) struct Moves {
    /// Whether each node moves, itself or below a node that does.
    pub(crate) moved: Vec<bool>,
    /// Whether the mesh of each node is morphed.
    pub(crate) morphed: Vec<bool>,
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

    /// What one of these animations moves or morphs.
    pub(crate) fn moves(&self, animations: &[Animation]) -> Moves {
        let count = self.rest.locals.len();
        let mut moves = Moves { moved: vec![false; count], morphed: vec![false; count] };
        let channels = animations.iter().flat_map(|animation| &animation.channels);
        for channel in channels.filter(|channel| !channel.is_idle(&self.rest)) {
            let changed = if channel.property == Property::Weights { &mut moves.morphed } else { &mut moves.moved };
            changed[channel.node] = true;
        }
        for (node, parent) in self.tree.with_parents() {
            moves.moved[node] |= parent.is_some_and(|parent| moves.moved[parent]);
        }
        moves
    }
}
