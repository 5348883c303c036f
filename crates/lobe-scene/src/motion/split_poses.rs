//! Splitting edges of a scene that moves: light at vertices is then resolved at all times.

use std::sync::Arc;

use crate::motion::shape::Part;
use crate::scene::split_edges::{MOST_TRIANGLES, split_longer, squared_limit};
use crate::{AnimatedScene, Animation, Mesh, PosedScene, Scene, SceneError};

/// The most keys of an animation at which edges are measured: each takes a pose of the whole scene.
const MOST_KEYS: usize = 64;

impl AnimatedScene {
    /// Splits edges until none is longer than `max_edge` at the keys of an animation, or as the scene stands without
    /// one. Where there are more than 64 keys, as many of them count, spread evenly.
    ///
    /// New vertices lie halfway between two in the mesh, in each morph target and in the weights of joints. Morph
    /// targets and nodes keep them in the middle of the edge in every pose. Joints that turn against each other may
    /// not. An edge is split alike in all meshes in which it has the same ends, as [`Scene::split_edges`] does. The
    /// first vertices of each mesh are the old ones, in their order. The scene has no normal maps.
    ///
    /// # Errors
    /// [`SceneError::Options`] if `max_edge` is not above zero, if there is no such animation, or if the scene would
    /// have more than 2²⁶ triangles. [`SceneError::Invalid`] as [`Self::pose`].
    pub fn split_edges(&self, animation: Option<usize>, max_edge: f32) -> Result<Self, SceneError> {
        let mut finer = self.clone();
        finer.rest = finer.rest.without_normal_maps();
        let Some(animation) = animation else {
            return finer.split_pose(&self.rest_pose()?, max_edge);
        };
        let keys = self.animations.get(animation).map_or_else(|| vec![0.0], Animation::key_times);
        let every = keys.len().div_ceil(MOST_KEYS).max(1);
        // The last key, which may be between two of these, is where most animations come to rest.
        let times: Vec<f64> = keys.iter().step_by(every).chain(keys.last().filter(|_| every > 1)).copied().collect();
        // A scene that is small at first is not split for long before it is found too large.
        for &time in &times {
            squared_limit(finer.pose(animation, time)?.scene(), max_edge)?;
        }
        for time in times {
            let posed = finer.pose(animation, time)?;
            finer = finer.split_pose(&posed, max_edge)?;
        }
        Ok(finer)
    }

    /// Splits the edges that are longer in a pose of this scene.
    fn split_pose(self, posed: &PosedScene, max_edge: f32) -> Result<Self, SceneError> {
        let limit = squared_limit(posed.scene(), max_edge)?;
        let mut budget = MOST_TRIANGLES;
        let (mut meshes, mut parts) = (Vec::new(), Vec::new());
        for ((rest, part), posed) in self.rest.meshes().iter().zip(&self.parts).zip(posed.scene().meshes()) {
            let (split, edges) = split_longer(posed, (max_edge, limit), &mut budget)?;
            let is_mirrored = rest.triangles().first() != posed.triangles().first();
            meshes.push(halved_mesh(rest, split.triangles, &edges, is_mirrored)?);
            parts.push(halved_part(part, &edges, max_edge)?);
        }
        let rest = Scene::new(meshes, self.rest.materials().to_vec(), self.rest.textures().to_vec())?;
        Ok(Self::new(rest.moved(self.rest.origin()), self.rig, parts, self.skins, self.animations))
    }
}

/// The mesh at rest with the vertices and triangles of one that was split in a pose, whose triangles may run the
/// other way.
fn halved_mesh(
    rest: &Mesh,
    triangles: Vec<[u32; 3]>,
    edges: &[[u32; 2]],
    is_mirrored: bool,
) -> Result<Mesh, SceneError> {
    let mut parts = rest.clone().into_parts();
    for &[a, b] in edges {
        parts.middle(a, b);
    }
    parts.triangles = triangles;
    if is_mirrored {
        parts.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    // What has no area at rest may have one in a pose.
    Mesh::keeping(parts, |_| true)
}

fn halved_part(part: &Part, edges: &[[u32; 2]], max_edge: f32) -> Result<Part, SceneError> {
    let shape = part.shape.halved(edges).ok_or_else(|| {
        SceneError::Options(format!("edges of at most {max_edge} take too many weights of joints: allow longer ones"))
    })?;
    Ok(Part { shape: Arc::new(shape), ..part.clone() })
}
