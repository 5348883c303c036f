//! Sphere sets that move with the joints of their mesh.
//!
//! A sphere moves like the place of the surface nearest to its center: with its four strongest joints, by linear
//! blending, and with the mean scale of these,
//!
//! ```text
//!   c' = Σ_j w_j M_j c        R' = R Σ_j w_j |det M_j|^{1/3}
//! ```
//!
//! of a sphere that first [followed its morph targets](crate::SphereMorphs), where `M_j` takes points of the mesh's own
//! frame, where it was bound, to the world. The scales are blended, not the scale of the blended matrix taken: that
//! falls to 0 where joints turn against each other.

use glam::{DMat3, DVec3};
use lobe_io::parallel;

use crate::error::ShadowError;
use crate::spheres::morphs::SphereMorphs;
use crate::spheres::near_triangle::{nearest_on_triangle, place};
use crate::spheres::skin::Skin;
use crate::spheres::sphere_set::SphereSet;

/// A mesh in the pose that it was bound in, with the joints of its vertices.
#[derive(Clone, Copy, Debug)]
pub struct SkinnedMesh<'a> {
    /// The positions, from the origin of the spheres.
    pub positions: &'a [[f32; 3]],
    /// Three indices of `positions` for each triangle.
    pub triangles: &'a [[u32; 3]],
    /// Four joints for each position; of more the four strongest.
    pub joints: &'a [[u16; 4]],
    /// Their weights, at least 0.
    pub weights: &'a [[f32; 4]],
}

/// A sphere in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldSphere {
    /// The center.
    pub center: [f64; 3],
    /// The radius, at least 0.
    pub radius: f64,
}

impl SphereSet {
    /// The set bound to the joints of a mesh. Takes time proportional to spheres times triangles.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the mesh has no triangles, an index is out of range, its attributes are not as long
    /// as its positions, a weight is not finite or negative, or no joint moves a place.
    pub fn bind(self, mesh: &SkinnedMesh<'_>) -> Result<Self, ShadowError> {
        check(mesh)?;
        let centers = self.centers();
        let four = |k: usize| joints_at(mesh, DVec3::from_array(centers[k].map(f64::from)));
        let (joints, weights) = parallel::map(centers.len(), &four).into_iter().unzip();
        self.with_skin(Skin::new(joints, weights)?)
    }

    /// The spheres in the world, as joints are now: the rows of a matrix for each, which takes points of the mesh's own
    /// frame, where it was bound, to the world. Without a [`Skin`], all spheres move with the first.
    ///
    /// ```
    /// use lobe_shadow::SphereSet;
    ///
    /// let set = SphereSet::new(vec![[1.0, 0.0, 0.0]], vec![1.0])?;
    /// let twice_as_large = [[2.0, 0.0, 0.0, 5.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]];
    /// let spheres = set.posed(&[twice_as_large])?;
    /// assert_eq!(spheres[0].center, [7.0, 0.0, 0.0]);
    /// assert!((spheres[0].radius - 2.0).abs() < 1e-12);
    /// # Ok::<(), lobe_shadow::ShadowError>(())
    /// ```
    ///
    /// # Errors
    /// [`ShadowError::Options`] if a joint has no matrix, or a matrix is not finite.
    pub fn posed(&self, matrices: &[[[f64; 4]; 3]]) -> Result<Vec<WorldSphere>, ShadowError> {
        self.posed_at(self.morphs().map_or(&[][..], SphereMorphs::weights), matrices)
    }

    /// The same at weights of the morph targets that it follows, if any.
    pub(crate) fn posed_at(
        &self,
        morphed: &[f64],
        matrices: &[[[f64; 4]; 3]],
    ) -> Result<Vec<WorldSphere>, ShadowError> {
        if let Some(j) = matrices.iter().position(|m| m.as_flattened().iter().any(|x| !x.is_finite())) {
            return Err(ShadowError::Options(format!(
                "expected finite matrices, found {:?} at joint {j}",
                matrices[j]
            )));
        }
        let scales: Vec<f64> = matrices.iter().map(scale).collect();
        let posed = |k: usize| {
            let (joints, weights) = match self.skin() {
                Some(skin) => (skin.joints()[k], skin.weights()[k]),
                None => ([0; 4], [1.0, 0.0, 0.0, 0.0]),
            };
            let (center, factor) = match self.morphs() {
                Some(morphs) => morphs.at(k, self.center(k), morphed),
                None => (self.center(k), 1.0),
            };
            let (own_radius, mut sphere) = (factor * f64::from(self.radii()[k]), WorldSphere::default());
            for (&joint, &weight) in joints.iter().zip(&weights).filter(|pair| *pair.1 > 0.0) {
                let Some(matrix) = matrices.get(usize::from(joint)) else {
                    let message =
                        format!("expected a matrix for joint {joint} of sphere {k}, found {}", matrices.len());
                    return Err(ShadowError::Options(message));
                };
                let weight = f64::from(weight);
                for (row, x) in matrix.iter().zip(&mut sphere.center) {
                    let moved: f64 = row.iter().zip(center).map(|(m, c)| m * c).sum();
                    *x += weight * (moved + row[3]);
                }
                sphere.radius += weight * scales[usize::from(joint)] * own_radius;
            }
            Ok(sphere)
        };
        (0..self.len()).map(posed).collect()
    }
}

/// The cube root of the volume that a matrix makes of a unit cube.
fn scale(matrix: &[[f64; 4]; 3]) -> f64 {
    let [x, y, z] = matrix.map(|row| DVec3::new(row[0], row[1], row[2]));
    DMat3::from_cols(x, y, z).determinant().abs().cbrt()
}

fn check(mesh: &SkinnedMesh<'_>) -> Result<(), ShadowError> {
    let SkinnedMesh { positions, triangles, joints, weights } = mesh;
    let refuse = |message: String| Err(ShadowError::Options(message));
    if triangles.is_empty() {
        return refuse("expected a mesh with triangles to bind to, found none".to_owned());
    }
    if joints.len() != positions.len() || weights.len() != positions.len() {
        let (expected, joints, weights) = (positions.len(), joints.len(), weights.len());
        return refuse(format!("expected joints and weights of {expected} vertices, found {joints} and {weights}"));
    }
    if let Some(t) = triangles.iter().position(|t| t.iter().any(|&v| v as usize >= positions.len())) {
        let message = format!("expected vertices below {}, found {:?} at triangle {t}", positions.len(), triangles[t]);
        return refuse(message);
    }
    if let Some(v) = weights.iter().position(|four| four.iter().any(|w| !(w.is_finite() && *w >= 0.0))) {
        return refuse(format!("expected weights of at least 0, found {:?} at vertex {v}", weights[v]));
    }
    Ok(())
}

/// The four strongest joints of the place of a mesh nearest to a point, and their weights.
fn joints_at(mesh: &SkinnedMesh<'_>, point: DVec3) -> ([u16; 4], [f32; 4]) {
    let corners = |t: &[u32; 3]| t.map(|v| DVec3::from_array(mesh.positions[v as usize].map(f64::from)));
    let mut nearest = (f64::INFINITY, mesh.triangles[0], [1.0, 0.0, 0.0]);
    for t in mesh.triangles {
        let shares = nearest_on_triangle(point, corners(t));
        let square = place(corners(t), shares).distance_squared(point);
        if square < nearest.0 {
            nearest = (square, *t, shares);
        }
    }
    let (_, triangle, shares) = nearest;
    let mut sums: Vec<(u16, f64)> = Vec::with_capacity(12);
    for (&v, share) in triangle.iter().zip(shares) {
        for (&joint, &weight) in mesh.joints[v as usize].iter().zip(&mesh.weights[v as usize]) {
            let added = share * f64::from(weight);
            match sums.iter_mut().find(|(j, _)| *j == joint) {
                Some((_, sum)) => *sum += added,
                None => sums.push((joint, added)),
            }
        }
    }
    sums.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let strongest = |k: usize| sums.get(k).filter(|pair| pair.1 > 0.0).copied().unwrap_or_default();
    (std::array::from_fn(|k| strongest(k).0), std::array::from_fn(|k| strongest(k).1 as f32))
}
