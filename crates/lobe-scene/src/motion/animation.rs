//! Animations: what moves nodes and morphs meshes over time.

use glam::DVec3;

use crate::motion::sampler::Sampler;
use crate::scene::transform::Local;

/// An animation of a scene: a set of values over time, from 0 to [`duration`](Self::duration).
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    pub(crate) name: Option<String>,
    pub(crate) channels: Vec<Channel>,
}

/// One value that is animated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Channel {
    pub(crate) node: usize,
    pub(crate) property: Property,
    pub(crate) sampler: Sampler,
}

/// What a channel animates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Property {
    Translation,
    Rotation,
    Scale,
    /// The weights of the morph targets of the node's mesh.
    Weights,
}

/// All that animations change: the transforms of nodes relative to their parents, and weights of morph targets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct State {
    pub(crate) locals: Vec<Local>,
    pub(crate) weights: Vec<Vec<f64>>,
}

impl Animation {
    /// The name in the file; many have none.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The time of the last key, in seconds. Before the first key everything is as there, after the last one as there.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.channels.iter().map(|channel| channel.sampler.end()).fold(0.0, f64::max)
    }

    /// The times at which anything has a key, in seconds, in rising order and each once: between two of them all that moves does so
    /// along one piece of its line, arc or spline.
    #[must_use]
    pub fn key_times(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.channels.iter().flat_map(|channel| channel.sampler.times()).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// The time within the animation when it is played over and over: `t` modulo the duration, from 0 to below the
    /// duration. Zero if the animation has no duration.
    ///
    /// Poses are [clamped](crate::AnimatedScene::pose) otherwise, as glTF says.
    #[must_use]
    pub fn looped(&self, t: f64) -> f64 {
        let duration = self.duration();
        let t = t.rem_euclid(duration);
        // Rounding can reach the duration from below zero; without a duration there is no number.
        if t < duration { t } else { 0.0 }
    }

    /// Changes what the animation animates to its values at a time.
    pub(crate) fn apply(&self, t: f64, state: &mut State) {
        for Channel { node, property, sampler } in &self.channels {
            match (property, &mut state.locals[*node]) {
                (Property::Weights, _) => state.weights[*node] = sampler.at(t),
                (Property::Translation, Local::Trs(trs)) => trs.translation = DVec3::from_array(sampler.vector_at(t)),
                (Property::Scale, Local::Trs(trs)) => trs.scale = DVec3::from_array(sampler.vector_at(t)),
                (Property::Rotation, Local::Trs(trs)) => trs.rotation = sampler.rotation_at(t),
                // A matrix is not animated.
                (_, Local::Matrix(_)) => {}
            }
        }
    }
}

impl Channel {
    /// Whether the value is always the one that it has without animation.
    pub(crate) fn is_idle(&self, rest: &State) -> bool {
        match (self.property, &rest.locals[self.node]) {
            (Property::Weights, _) => self.sampler.is_always(&rest.weights[self.node]),
            (Property::Translation, Local::Trs(rest)) => self.sampler.is_always(&rest.translation.to_array()),
            (Property::Scale, Local::Trs(rest)) => self.sampler.is_always(&rest.scale.to_array()),
            (Property::Rotation, Local::Trs(rest)) => self.sampler.is_always(&rest.rotation.to_array()),
            (_, Local::Matrix(_)) => true,
        }
    }
}
