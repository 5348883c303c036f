//! Morph targets of an entity, followed by its spheres: fitted to the surface next to each, see `morphs`.

use glam::{DMat3, DVec3};
use lobe_io::{Job, Progress, parallel};
use lobe_scene::{AnimatedScene, Entity, Mesh, Scene};

use crate::error::ShadowError;
use crate::spheres::morphs::{NUMBERS, SphereMorphs};
use crate::spheres::near_triangle::{nearest_on_triangle, place};
use crate::spheres::sphere_set::SphereSet;

/// Spheres times triangles between two looks at whether to stop: a fraction of a second.
const AT_ONCE: usize = 1 << 18;

/// Directions over the sphere with their weights: six along the axes and eight between them, exact to degree 5.
fn directions() -> [(DVec3, f64); 14] {
    std::array::from_fn(|k| match k {
        0..6 => {
            let mut axis = [0.0; 3];
            axis[k / 2] = if k % 2 == 0 { 1.0 } else { -1.0 };
            (DVec3::from_array(axis), 1.0 / 15.0)
        }
        _ => {
            let sign = |bit: usize| if (k - 6) >> bit & 1 == 0 { 1.0 } else { -1.0 };
            (DVec3::new(sign(0), sign(1), sign(2)).normalize(), 3.0 / 40.0)
        }
    })
}

/// What morph targets do to spheres that were fitted to the [widest shape](AnimatedScene::widest_weights) of an entity;
/// none if it has no targets.
pub(crate) fn morphs_of(
    scene: &AnimatedScene,
    entity: &Entity,
    set: &SphereSet,
    job: &mut Job<'_>,
) -> Result<Option<SphereMorphs>, ShadowError> {
    let weights = scene.widest_weights(entity)?;
    if weights.is_empty() || set.is_empty() {
        return Ok(None);
    }
    let surface = MorphedSurface::new(scene, entity, &weights, set.origin())?;
    let piece = (AT_ONCE / surface.triangles.len().max(1)).max(1);
    let mut changes = Vec::with_capacity(set.len() * weights.len());
    for first in (0..set.len()).step_by(piece) {
        let progress = Progress { done: first, total: set.len(), ..Progress::default() };
        if job.report(&progress).is_break() {
            return Err(ShadowError::Cancelled);
        }
        let count = piece.min(set.len() - first);
        let of_spheres = parallel::map(count, &|k| surface.changes_of(set, first + k));
        of_spheres.into_iter().for_each(|of_sphere| changes.extend(of_sphere));
    }
    SphereMorphs::new(weights, changes).map(Some)
}

/// The surface of an entity at some weights, and what each target adds to its vertices.
struct MorphedSurface {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    targets: Vec<Vec<DVec3>>,
}

impl MorphedSurface {
    fn new(scene: &AnimatedScene, entity: &Entity, weights: &[f64], origin: [f64; 3]) -> Result<Self, ShadowError> {
        let at = |weights: &[f64]| -> Result<Scene, ShadowError> { Ok(scene.morphed_scene(entity, weights)?) };
        let own = at(weights)?;
        let positions = positions_from(&own, origin);
        let (mut triangles, mut first) = (Vec::new(), 0);
        for mesh in own.meshes() {
            triangles.extend(mesh.triangles().iter().map(|t| t.map(|i| first + i)));
            first += mesh.positions().len() as u32;
        }
        let target = |k: usize| {
            let mut other = weights.to_vec();
            // From one end of the way to the other, so that rounding matters least.
            other[k] = if weights[k] == 0.0 { 1.0 } else { 0.0 };
            let by = (other[k] - weights[k]).recip();
            let there = positions_from(&at(&other)?, origin);
            Ok(there.iter().zip(&positions).map(|(there, here)| by * (*there - *here)).collect())
        };
        let targets = (0..weights.len()).map(target).collect::<Result<_, ShadowError>>()?;
        Ok(Self { positions, triangles, targets })
    }

    /// `D` and `A` of a sphere for each target.
    fn changes_of(&self, set: &SphereSet, sphere: usize) -> Vec<[f32; NUMBERS]> {
        let center = DVec3::from_array(set.centers()[sphere].map(f64::from));
        let radius = f64::from(set.radii()[sphere]);
        let near = directions().map(|(s, weight)| (s, weight, self.nearest(center + radius * s)));
        let change = |target: &Vec<DVec3>| {
            let (mut mean, mut columns) = (DVec3::ZERO, DMat3::ZERO);
            for (s, weight, (corners, shares)) in near {
                let moved = weight * place(corners.map(|v| target[v as usize]), shares);
                mean += moved;
                columns += DMat3::from_cols(moved * s.x, moved * s.y, moved * s.z);
            }
            let rows = if radius > 0.0 { (3.0 / radius * columns).transpose() } else { DMat3::ZERO };
            let mut numbers = [0.0; NUMBERS];
            let all = mean.to_array().into_iter().chain(rows.to_cols_array());
            numbers.iter_mut().zip(all).for_each(|(number, x)| *number = x as f32);
            numbers
        };
        self.targets.iter().map(change).collect()
    }

    /// The triangle nearest to a point, and its place there.
    fn nearest(&self, point: DVec3) -> ([u32; 3], [f64; 3]) {
        let mut nearest = (f64::INFINITY, ([0; 3], [1.0, 0.0, 0.0]));
        for t in &self.triangles {
            let corners = t.map(|v| self.positions[v as usize]);
            let shares = nearest_on_triangle(point, corners);
            let square = place(corners, shares).distance_squared(point);
            if square < nearest.0 {
                nearest = (square, (*t, shares));
            }
        }
        nearest.1
    }
}

/// The vertices of a scene, which count from a point of its own.
fn positions_from(scene: &Scene, origin: [f64; 3]) -> Vec<DVec3> {
    let offset = DVec3::from_array(scene.origin()) - DVec3::from_array(origin);
    let positions = scene.meshes().iter().flat_map(Mesh::positions);
    positions.map(|p| DVec3::from_array(p.map(f64::from)) + offset).collect()
}
