//! Splitting edges of a scene that moves: light at vertices is then resolved at all times.

use std::collections::HashMap;
use std::sync::Arc;

use crate::error::SceneError;
use crate::motion::animated_scene::AnimatedScene;
use crate::motion::animation::Animation;
use crate::motion::posed_scene::PosedScene;
use crate::motion::shape::Part;
use crate::scene::mesh::Mesh;
use crate::scene::scene::Scene;
use crate::scene::split_edges::{MOST_TRIANGLES, check_count, goal_of, split_longer, squared, too_many};

/// The most keys of an animation at which edges are measured: each takes a pose of the whole scene.
const MOST_KEYS: usize = 64;

impl AnimatedScene {
    /// Splits edges until none is longer than `max_edge` at the keys of an animation, or as the scene stands without
    /// one. Where there are more than 64 keys, as many of them count, spread evenly.
    ///
    /// New vertices lie halfway between two in every pose, whatever moves these: the surface stays as it is. An edge is
    /// split alike in all meshes in which it has the same ends, as [`Scene::split_edges`] does. The first vertices of
    /// each mesh are the old ones, in their order. The scene has no normal maps.
    ///
    /// # Errors
    /// [`SceneError::Options`] if `max_edge` is not above zero, if there is no such animation, or if the scene would
    /// have more than 2²⁶ triangles. [`SceneError::Invalid`] as [`Self::pose`].
    pub fn split_edges(&self, animation: Option<usize>, max_edge: f32) -> Result<Self, SceneError> {
        self.split_edges_of(animation, &vec![max_edge; self.parts.len()], &goal_of(max_edge))
    }

    /// Splits edges until none is longer than the length that is given for its mesh, as [`Self::split_edges`] does. An
    /// infinite length leaves a mesh as it is. Of meshes that have vertices at the same places the shortest length
    /// counts.
    ///
    /// # Errors
    /// As [`Self::split_edges`]; `goal` describes the lengths in them.
    ///
    /// # Panics
    /// If there are not as many lengths as meshes.
    pub fn split_edges_of(&self, animation: Option<usize>, longest: &[f32], goal: &str) -> Result<Self, SceneError> {
        assert_eq!(longest.len(), self.parts.len(), "lengths, one for each mesh");
        let mut limits = longest
            .iter()
            .map(|&length| if length == f32::INFINITY { Ok(f64::INFINITY) } else { squared(length) })
            .collect::<Result<Vec<_>, _>>()?;
        let mut finer = self.clone();
        finer.rest = finer.rest.without_normal_maps();
        // The last key, which may be between two of these, is where most animations come to rest.
        let keys = animation.and_then(|k| self.animations.get(k)).map_or_else(|| vec![0.0], Animation::key_times);
        let every = keys.len().div_ceil(MOST_KEYS).max(1);
        let times = keys.iter().step_by(every).chain(keys.last().filter(|_| every > 1));
        let pose = |scene: &Self, time: f64| animation.map_or_else(|| scene.rest_pose(), |k| scene.pose(k, time));
        // A scene that is small at first is not split for long before it is found too large.
        for &time in times.clone() {
            let posed = pose(&finer, time)?;
            equalize(posed.scene().meshes(), &mut limits);
            check_count(posed.scene().meshes().iter().zip(limits.iter().copied()), goal)?;
        }
        for &time in times {
            let posed = pose(&finer, time)?;
            finer = finer.split_pose(&posed, &limits, goal)?;
        }
        Ok(finer)
    }

    /// Splits the edges that are longer in a pose of this scene.
    fn split_pose(self, posed: &PosedScene, limits: &[f64], goal: &str) -> Result<Self, SceneError> {
        let mut budget = MOST_TRIANGLES;
        let (mut meshes, mut parts) = (Vec::new(), Vec::new());
        for (k, (rest, posed)) in self.rest.meshes().iter().zip(posed.scene().meshes()).enumerate() {
            let (split, edges) = split_longer(posed, limits[k], &mut budget).ok_or_else(|| too_many(goal))?;
            let is_mirrored = rest.triangles().first() != posed.triangles().first();
            meshes.push(halved_mesh(rest, split.triangles, &edges, is_mirrored)?);
            parts.push(halved_part(&self.parts[k], &edges, goal)?);
        }
        let rest = Scene::new(meshes, self.rest.materials().to_vec(), self.rest.textures().to_vec())?;
        Ok(Self::new(rest.moved(self.rest.origin()), self.rig, parts, self.skins, self.animations))
    }
}

/// Gives meshes with vertices at the same places, of which edges are to be split, the smallest of their limits: they
/// are then split alike where they meet.
fn equalize(meshes: &[Mesh], limits: &mut [f64]) {
    let mut first = HashMap::new();
    let mut group: Vec<usize> = (0..meshes.len()).collect();
    for (k, mesh) in meshes.iter().enumerate().filter(|&(k, _)| limits[k].is_finite()) {
        for place in mesh.positions().iter().map(|p| p.map(|x| (x + 0.0).to_bits())) {
            let other = group[*first.entry(place).or_insert(k)];
            if other != group[k] {
                let (from, to) = (group[k].max(other), group[k].min(other));
                group.iter_mut().filter(|own| **own == from).for_each(|own| *own = to);
            }
        }
    }
    let mut least = vec![f64::INFINITY; limits.len()];
    group.iter().zip(&*limits).for_each(|(&own, &limit)| least[own] = least[own].min(limit));
    group.iter().zip(limits).for_each(|(&own, limit)| *limit = least[own]);
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

fn halved_part(part: &Part, edges: &[[u32; 2]], goal: &str) -> Result<Part, SceneError> {
    let shape = part
        .shape
        .halved(edges)
        .ok_or_else(|| SceneError::Options(format!("{goal} take too many weights of joints: allow longer ones")))?;
    Ok(Part { shape: Arc::new(shape), ..part.clone() })
}
