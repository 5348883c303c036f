//! Posed scenes: an animated scene at one time.

use glam::DMat4;

use crate::bvh::bvh::Bvh;
use crate::motion::entity::Entity;
use crate::motion::place::Place;
use crate::scene::scene::Scene;
use crate::scene::up::Up;

/// An animated scene at one time: all vertices where they are then, and the places of nodes and joints.
#[derive(Clone, Debug)]
pub struct PosedScene {
    pub(crate) scene: Scene,
    pub(crate) up: Up,
    /// From the space of each node to the scene.
    pub(crate) worlds: Vec<DMat4>,
    /// For each skin the nodes of its joints, and from where the mesh was bound to the scene.
    pub(crate) skins: Vec<(Vec<usize>, Vec<DMat4>)>,
    /// The weights of the morph targets of each node's meshes.
    pub(crate) weights: Vec<Vec<f64>>,
}

impl PosedScene {
    /// The scene, with the same meshes, vertices and triangles in the same order at all times.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene, owned.
    #[must_use]
    pub fn into_scene(self) -> Scene {
        self.scene
    }

    /// The BVH of the scene, built anew. Between poses of a scene, [`Bvh::update`] takes a small part of that time.
    #[must_use]
    pub fn bvh(&self) -> Bvh {
        Bvh::new(&self.scene)
    }

    /// The place of an entity's own frame, in which [`AnimatedScene::own_scene`](crate::AnimatedScene::own_scene) has its
    /// shape. One that a skin carries is elsewhere: its joints have places.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more nodes.
    #[must_use]
    pub fn place(&self, entity: &Entity) -> Place {
        Place::new(self.worlds[entity.node], self.up)
    }

    /// The places of the joints of a skin: from the own frame of each joint to the scene.
    ///
    /// # Panics
    /// If there is no such skin.
    #[must_use]
    pub fn joints(&self, skin: usize) -> Vec<Place> {
        self.skins[skin].0.iter().map(|&joint| Place::new(self.worlds[joint], self.up)).collect()
    }

    /// Where each joint of a skin takes the shape that was bound to it: from the entity's own frame to the scene. What is
    /// bound to joints by weights, vertices or spheres, is at `Σ w_j M_j p`.
    ///
    /// # Panics
    /// If there is no such skin.
    #[must_use]
    pub fn joint_maps(&self, skin: usize) -> Vec<Place> {
        self.skins[skin].1.iter().map(|&matrix| Place::new(matrix, self.up)).collect()
    }
}
