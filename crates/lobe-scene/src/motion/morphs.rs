//! Morph targets of an entity: its shape at any weights, and that in which its surface is largest.

use crate::error::SceneError;
use crate::motion::animated_scene::AnimatedScene;
use crate::motion::animation::Property;
use crate::motion::entity::Entity;
use crate::motion::posed_scene::PosedScene;
use crate::scene::scene::Scene;

/// The most keys of an animation at which a shape is measured.
const MOST_KEYS: usize = 64;

/// A surface that is larger by less than this part is no larger.
const LARGER: f64 = 0.1;

impl AnimatedScene {
    /// The weights of an entity's morph targets without animation; none if it has no such targets.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more nodes.
    #[must_use]
    pub fn morph_weights(&self, entity: &Entity) -> &[f64] {
        &self.rig.rest.weights[entity.node]
    }

    /// An entity by itself as [`Self::own_scene`] has it, but with these weights of its morph targets; targets without
    /// one count nothing.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if a coordinate is out of range.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more meshes.
    pub fn morphed_scene(&self, entity: &Entity, weights: &[f64]) -> Result<Scene, SceneError> {
        let own = |mesh: usize| {
            let part = &self.parts[mesh];
            let known = weights.len().min(part.shape.targets.len());
            part.own(&self.rest.meshes()[mesh], &self.rig, &weights[..known])
        };
        let meshes = entity.meshes().map(own).collect::<Result<Vec<_>, _>>()?;
        self.rest.of_meshes(meshes)
    }

    /// The weights at which an entity has the largest surface, of those without animation and at the keys of all
    /// animations, 64 of each at most: what stands for the shape there can shrink with it, and lacks no detail. Those
    /// without animation if no surface is larger by a tenth.
    ///
    /// # Errors
    /// As [`Self::morphed_scene`].
    ///
    /// # Panics
    /// As [`Self::morphed_scene`].
    pub fn widest_weights(&self, entity: &Entity) -> Result<Vec<f64>, SceneError> {
        let rest = self.morph_weights(entity);
        if entity.meshes().all(|mesh| self.parts[mesh].shape.targets.is_empty()) {
            return Ok(rest.to_vec());
        }
        let mut widest = (rest.to_vec(), (1.0 + LARGER) * surface_of(&self.own_scene(entity)?));
        let channels = self.animations.iter().flat_map(|animation| &animation.channels);
        for channel in channels.filter(|channel| channel.node == entity.node && channel.property == Property::Weights) {
            let times: Vec<f64> = channel.sampler.times().collect();
            for &time in times.iter().step_by(times.len().div_ceil(MOST_KEYS).max(1)).chain(times.last()) {
                let weights = channel.sampler.at(time);
                let surface = surface_of(&self.morphed_scene(entity, &weights)?);
                if surface > widest.1 {
                    widest = (weights, surface);
                }
            }
        }
        Ok(widest.0)
    }
}

impl PosedScene {
    /// The weights of an entity's morph targets; none if it has no such targets.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more nodes.
    #[must_use]
    pub fn morph_weights(&self, entity: &Entity) -> &[f64] {
        &self.weights[entity.node]
    }
}

/// Twice the area of all triangles.
fn surface_of(scene: &Scene) -> f64 {
    scene.corners().map(crate::scene::mesh::double_area).sum()
}
