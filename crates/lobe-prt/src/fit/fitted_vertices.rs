//! The vertices whose transfer is fitted, and the triangles around them, seen from one side.

use std::borrow::Cow;

use lobe_io::Fingerprint;
use lobe_scene::Scene;

use crate::bake::options::{AlbedoMode, BakeOptions};
use crate::error::PrtError;
use crate::fit::face::{Face, Side};
use crate::job::fingerprint::fingerprint_scene;
use crate::receivers::receivers::Receivers;
use crate::transfer::transfer::Channels;

/// Rings of triangles around some vertices to which they are fitted. Each one more divides by about four what is missed
/// of a fit to all triangles.
const RINGS: usize = 2;

/// Vertices of a scene whose transfer is fitted, see [`bake_vertices`](crate::bake_vertices): all of them, or some,
/// from the front or from the back.
///
/// What some of them have is fitted to the triangles that touch them, and to those that touch these. So they have the
/// values of a fit of all vertices but for a part of its noise. Light is hidden and reflected by the whole scene.
///
/// ```
/// use lobe_io::Job;
/// use lobe_prt::{BakeOptions, FittedVertices};
/// use lobe_scene::{Bvh, built_in};
///
/// let scene = built_in::ball_over_ground(4);
/// let options = BakeOptions::default().order(2).samples(64);
/// let (below, _) = FittedVertices::backs(&scene, &[0, 1])?.bake(&Bvh::new(&scene), &options, Job::default())?;
/// assert_eq!(below.receivers(), 2);
/// # Ok::<(), lobe_prt::PrtError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FittedVertices<'a> {
    scene: &'a Scene,
    receivers: Cow<'a, Receivers>,
    /// The vertices that are asked for, among those of all meshes.
    vertices: Vec<usize>,
    /// The triangles that are fitted, among those of all meshes.
    triangles: Vec<u32>,
    /// The corners of each of them, among the vertices of all meshes.
    corners: Vec<[u32; 3]>,
    side: Side,
}

impl<'a> FittedVertices<'a> {
    /// The fronts of all vertices.
    ///
    /// # Errors
    /// Those of [`Receivers::at_vertices`].
    pub fn all(scene: &'a Scene) -> Result<Self, PrtError> {
        Ok(Self::of_receivers(scene, Cow::Owned(Receivers::at_vertices(scene)?)))
    }

    /// The fronts of some vertices, in this order.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if there are none; those of [`Receivers::at_vertices`].
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn some(scene: &'a Scene, vertices: &[usize]) -> Result<Self, PrtError> {
        if vertices.is_empty() {
            return Err(PrtError::invalid("receivers", "expected at least one, found none".to_owned()));
        }
        let all = Self::all(scene)?;
        let mut is_near = vec![false; scene.vertex_count()];
        vertices.iter().for_each(|&vertex| is_near[vertex] = true);
        let touches = |is_near: &[bool], corners: &[u32; 3]| corners.iter().any(|&vertex| is_near[vertex as usize]);
        for _ in 1..RINGS {
            let inner = is_near.clone();
            let ring = all.corners.iter().filter(|corners| touches(&inner, corners));
            ring.flatten().for_each(|&vertex| is_near[vertex as usize] = true);
        }
        let near = all.triangles.iter().zip(&all.corners).filter(|(_, corners)| touches(&is_near, corners));
        let (triangles, corners) = near.unzip();
        Ok(Self { vertices: vertices.to_vec(), triangles, corners, ..all })
    }

    /// The backs of some vertices, in this order.
    ///
    /// # Errors
    /// Those of [`FittedVertices::some`].
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn backs(scene: &'a Scene, vertices: &[usize]) -> Result<Self, PrtError> {
        Ok(Self { side: Side::Back, ..Self::some(scene, vertices)? })
    }

    /// The fronts of all vertices, which are these receivers.
    pub(crate) fn of_receivers(scene: &'a Scene, receivers: Cow<'a, Receivers>) -> Self {
        let (mut first, mut corners) = (0, Vec::with_capacity(scene.triangle_count()));
        for mesh in scene.meshes() {
            corners.extend(mesh.triangles().iter().map(|t| t.map(|v| first + v)));
            first += mesh.positions().len() as u32;
        }
        let (vertices, triangles) = ((0..receivers.len()).collect(), (0..corners.len() as u32).collect());
        Self { scene, receivers, vertices, triangles, corners, side: Side::Front }
    }

    /// The scene that they are of.
    pub(crate) fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The vertices that are asked for.
    pub(crate) fn vertices(&self) -> &[usize] {
        &self.vertices
    }

    /// The corners of each triangle that is fitted, among the vertices of all meshes.
    pub(crate) fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// The side of a triangle that is fitted.
    pub(crate) fn face(&self, number: usize) -> Face<'a> {
        Face::new(self.scene, self.triangles[number] as usize, self.side)
    }

    /// The channels of transfer with albedo.
    pub(crate) fn channels(&self, options: &BakeOptions) -> Channels {
        let is_gray = self.vertices.iter().all(|&vertex| {
            let [r, g, b] = self.receivers.albedos()[vertex];
            r == g && g == b
        });
        options.channels_for(self.scene, is_gray)
    }

    /// The albedo of a vertex.
    pub(crate) fn albedo(&self, vertex: usize, options: &BakeOptions) -> [f32; 3] {
        match options.albedo {
            AlbedoMode::Vertex => self.receivers.albedos()[vertex],
            AlbedoMode::None => [1.0; 3],
        }
    }

    /// Writes all that decides what is fitted into a fingerprint.
    pub(crate) fn write_into(&self, fingerprint: &mut Fingerprint) {
        fingerprint_scene(fingerprint, self.scene);
        if self.side == Side::Back || self.triangles.len() < self.scene.triangle_count() {
            fingerprint.word(self.side as u64);
            fingerprint.words(self.triangles.iter().map(|&triangle| u64::from(triangle)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::built_in;

    #[test]
    fn some_vertices_are_fitted_to_two_rings_of_triangles() {
        let scene = built_in::ball_over_ground(12);
        let all = FittedVertices::all(&scene).unwrap();
        let last = scene.vertex_count() - 1;
        let some = FittedVertices::backs(&scene, &[last, 0]).unwrap();
        assert_eq!(some.vertices(), [last, 0], "in the order asked for");
        let mut near = vec![0, last as u32];
        for _ in 0..RINGS {
            let touching = all.corners().iter().filter(|t| t.iter().any(|v| near.contains(v)));
            near = touching.flatten().copied().collect();
        }
        let mut found: Vec<u32> = some.corners().iter().flatten().copied().collect();
        [&mut near, &mut found].into_iter().for_each(|vertices| {
            vertices.sort_unstable();
            vertices.dedup();
        });
        assert_eq!(found, near, "the vertices of both rings");
        assert!(some.corners().len() < all.corners().len(), "not of all");
        assert_eq!(some.face(1).corners(), all.face(some.triangles[1] as usize).corners(), "where triangles are");
        assert!(FittedVertices::some(&scene, &[]).is_err(), "none");
    }
}
