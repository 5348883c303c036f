//! Nodes that stay similarities: an animation may move, turn and scale them, but alike in all directions.
//!
//! The transform of a node is a product along the chain from the root, `M = M_1 M_2 … M_n`. It keeps angles if each factor
//! does; factors that nothing moves are multiplied first, as a mirror in one often undoes that in the next. A factor
//! `T R S` that is animated keeps angles at all times if `S = s 1` at all times, and its side if `s` keeps its sign.

use std::collections::HashMap;

use glam::DMat3;

use crate::motion::animation::{Animation, Property};
use crate::motion::place::is_conformal;
use crate::motion::rig::Rig;
use crate::motion::sampler::Sampler;
use crate::scene::transform::{Local, Trs};

/// What is known of the chain down to a node.
#[derive(Clone, Copy)]
struct Chain {
    /// Whether all factors but the last keep angles.
    is_even: bool,
    is_mirrored: bool,
    /// The last factor: the product of those below the last animated node.
    last: DMat3,
}

/// How an animation scales a node at all times.
#[derive(Clone, Copy)]
enum Scaling {
    Uneven,
    /// By one number, not above zero if it mirrors, else not below.
    Even {
        mirrors: bool,
    },
}

/// Whether the transform of each node is a similarity at all times of an animation, or for a while scales by zero.
pub(crate) fn similar_nodes(rig: &Rig, animation: &Animation) -> Vec<bool> {
    let scalings = scalings(rig, animation);
    let start = Chain { is_even: true, is_mirrored: false, last: DMat3::IDENTITY };
    let mut chains = vec![start; rig.rest.locals.len()];
    for (node, parent) in rig.tree.with_parents() {
        let above = parent.map_or(start, |parent| chains[parent]);
        chains[node] = match scalings.get(&node) {
            None => Chain { last: above.last * DMat3::from_mat4(rig.rest.locals[node].matrix()), ..above },
            Some(Scaling::Uneven) => Chain { is_even: false, ..above },
            Some(Scaling::Even { mirrors }) => Chain {
                is_even: above.is_even && is_conformal(above.last),
                is_mirrored: above.is_mirrored ^ is_mirror(above.last) ^ mirrors,
                last: DMat3::IDENTITY,
            },
        };
    }
    let is_similar =
        |chain: &Chain| chain.is_even && is_conformal(chain.last) && chain.is_mirrored == is_mirror(chain.last);
    chains.iter().map(is_similar).collect()
}

fn is_mirror(linear: DMat3) -> bool {
    linear.determinant() < 0.0
}

/// How each node that the animation moves is scaled.
fn scalings(rig: &Rig, animation: &Animation) -> HashMap<usize, Scaling> {
    let mut all = HashMap::new();
    // Many channels may share a sampler of many keys.
    let mut known: HashMap<_, Scaling> = HashMap::new();
    for channel in animation.channels.iter().filter(|channel| channel.property != Property::Weights) {
        let Local::Trs(Trs { scale, .. }) = rig.rest.locals[channel.node] else { continue };
        if channel.property == Property::Scale {
            let found = *known.entry(channel.sampler.identity()).or_insert_with(|| scaling_of(&channel.sampler));
            all.insert(channel.node, found);
        } else {
            all.entry(channel.node).or_insert_with(|| match is_conformal(DMat3::from_diagonal(scale)) {
                true => Scaling::Even { mirrors: scale.x * scale.y * scale.z < 0.0 },
                false => Scaling::Uneven,
            });
        }
    }
    all
}

fn scaling_of(sampler: &Sampler) -> Scaling {
    match sampler.even_sign() {
        Some(sign) => Scaling::Even { mirrors: sign < 0.0 },
        None => Scaling::Uneven,
    }
}
