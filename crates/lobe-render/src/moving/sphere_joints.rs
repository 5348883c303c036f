//! Spheres that follow the joints of a part.

use lobe_io::{Job, Progress};
use lobe_scene::AnimatedScene;
use lobe_shadow::{Skin, SkinnedMesh, SphereSet};

use crate::{Motion, MovingPart, RenderError};

/// Spheres times triangles between two looks at whether to stop: a fraction of a second.
const AT_ONCE: usize = 1 << 22;

/// Spheres that follow the joints of their part, if it has any.
pub(crate) fn bound(
    spheres: SphereSet,
    part: &MovingPart,
    rig: Option<&AnimatedScene>,
    job: &mut Job<'_>,
) -> Result<SphereSet, RenderError> {
    let (Motion::Deformed(entity), Some(rig)) = (&part.motion, rig) else { return Ok(spheres) };
    if entity.skin().is_none() {
        return Ok(spheres);
    }
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for (mesh, part_mesh) in entity.meshes().zip(part.scene.meshes()) {
        let first = positions.len() as u32;
        positions.extend_from_slice(part_mesh.positions());
        triangles.extend(part_mesh.triangles().iter().map(|t| t.map(|i| first + i)));
        for vertex in 0..part_mesh.positions().len() {
            let (four, share) = strongest(rig, mesh, vertex);
            joints.push(four);
            weights.push(share);
        }
    }
    let mesh = SkinnedMesh { positions: &positions, triangles: &triangles, joints: &joints, weights: &weights };
    let skin = bound_in_pieces(&spheres, &mesh, job)?;
    Ok(spheres.with_skin(skin)?)
}

/// The joints of all spheres, found a few at a time.
fn bound_in_pieces(spheres: &SphereSet, mesh: &SkinnedMesh<'_>, job: &mut Job<'_>) -> Result<Skin, RenderError> {
    let (mut joints, mut weights) = (Vec::with_capacity(spheres.len()), Vec::with_capacity(spheres.len()));
    let piece = (AT_ONCE / mesh.triangles.len().max(1)).max(1);
    for (centers, radii) in spheres.centers().chunks(piece).zip(spheres.radii().chunks(piece)) {
        let progress = Progress { done: joints.len(), total: spheres.len(), ..Progress::default() };
        if job.report(&progress).is_break() {
            return Err(RenderError::Cancelled);
        }
        let few = SphereSet::new(centers.to_vec(), radii.to_vec())?.bind(mesh)?;
        if let Some(skin) = few.skin() {
            joints.extend_from_slice(skin.joints());
            weights.extend_from_slice(skin.weights());
        }
    }
    Ok(Skin::new(joints, weights)?)
}

/// The four joints that carry a vertex most. Vertices follow all of theirs, spheres these.
fn strongest(rig: &AnimatedScene, mesh: usize, vertex: usize) -> ([u16; 4], [f32; 4]) {
    let mut all: Vec<(usize, f64)> = rig.influences(mesh, vertex).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let (mut joints, mut weights) = ([0; 4], [0.0; 4]);
    for (k, (joint, weight)) in all.into_iter().take(4).enumerate() {
        (joints[k], weights[k]) = (joint as u16, weight as f32);
    }
    (joints, weights)
}
