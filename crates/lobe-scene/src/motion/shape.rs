//! Shapes: vertices in the own frame of their mesh, and what deforms them.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use rayon::prelude::IndexedParallelIterator as _;

use crate::error::SceneError;
use crate::motion::rig::Rig;
use crate::motion::skin::Influences;
use crate::scene::mesh::Mesh;
use crate::scene::split_edges::push_mean;
use crate::scene::transform::Affine;

/// The vertices of a mesh where nothing has moved them, without those in the middles of [halved](Mesh::halved) edges.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    /// Three coordinates for each vertex.
    pub(crate) positions: Arc<[f32]>,
    /// Three for each vertex, or nothing: normals are then made of the triangles of each pose.
    pub(crate) normals: Arc<[f32]>,
    /// Four for each vertex, or nothing where the scene has no use for them.
    pub(crate) tangents: Arc<[f32]>,
    pub(crate) targets: Vec<Target>,
    /// The joints that carry the vertices, those in the middles of edges too, where there is a skin.
    pub(crate) influences: Option<Influences>,
}

/// A morph target: what a weight of one adds to the vertices; an empty array adds nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Target {
    pub(crate) positions: Arc<[f32]>,
    pub(crate) normals: Arc<[f32]>,
}

/// A mesh of the scene with its shape.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) shape: Arc<Shape>,
    /// The node that shows it.
    pub(crate) node: usize,
    /// The skin that carries it: then its node does not move it.
    pub(crate) skin: Option<usize>,
    /// Whether the triangles of the scene's mesh run around the other way than those of the shape.
    pub(crate) is_mirrored: bool,
}

/// What carries the vertices of a mesh.
#[derive(Clone, Copy)]
pub(crate) enum Carrier<'a> {
    Node(DMat4),
    /// From where the mesh was bound to the scene, by joints.
    Joints(&'a [DMat4]),
}

/// Vertices that one thread takes at once.
const PIECE: usize = 2048;

impl Shape {
    fn of(mesh: &Mesh) -> Self {
        let [positions, normals] = [mesh.positions(), mesh.normals()].map(|v| v.as_flattened().into());
        Self { positions, normals, ..Self::default() }
    }

    /// The same for a mesh with one vertex more halfway along each of these edges, in their order. They follow the
    /// joints of both ends, by halves of their weights. Tangents are dropped. None if that takes too many weights.
    pub(crate) fn halved(&self, edges: &[[u32; 2]]) -> Option<Self> {
        let mut halved = Self { tangents: Arc::default(), ..self.clone() };
        if let Some(influences) = &mut halved.influences
            && !edges.iter().all(|ends| influences.push_mean(ends.map(|end| end as usize)))
        {
            return None;
        }
        Some(halved)
    }

    /// The number of vertices, without those in the middles of edges.
    pub(crate) fn len(&self) -> usize {
        self.positions.len() / 3
    }

    /// The position and the normal of a vertex, with the morph targets of weights other than zero.
    ///
    /// ```text
    ///   p = p_0 + Σ w_k Δp_k,      n = n_0 + Σ w_k Δn_k
    /// ```
    fn morphed(&self, vertex: usize, weights: &[(usize, f64)]) -> [DVec3; 2] {
        let at = |numbers: &[f32]| match numbers.get(3 * vertex..3 * vertex + 3) {
            Some(v) => DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])),
            None => DVec3::ZERO,
        };
        let mut both = [at(&self.positions), at(&self.normals)];
        for &(target, weight) in weights {
            both[0] += weight * at(&self.targets[target].positions);
            both[1] += weight * at(&self.targets[target].normals);
        }
        both
    }

    /// The tangent of a vertex, which morph targets leave as it is, and its sign; zero without one.
    fn tangent(&self, vertex: usize) -> (DVec3, f32) {
        match self.tangents.get(4 * vertex..4 * vertex + 4) {
            Some(v) => (DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])), v[3]),
            None => (DVec3::ZERO, 1.0),
        }
    }

    /// The joint matrix of a vertex, `Σ w_j M_j` with weights that sum to one.
    fn blended(&self, vertex: usize, joints: &[DMat4]) -> DMat4 {
        let influences = self.influences.iter().flat_map(|influences| influences.of(vertex));
        influences.fold(DMat4::ZERO, |sum, (joint, weight)| sum + joints[joint] * weight)
    }
}

impl Part {
    /// A mesh as it is, shown by a node.
    pub(crate) fn rigid(mesh: &Mesh, node: usize) -> Self {
        Self { shape: Arc::new(Shape::of(mesh)), node, skin: None, is_mirrored: false }
    }

    /// A mesh as it is, carried by joints.
    pub(crate) fn skinned(mesh: &Mesh, node: usize, influences: Influences) -> Self {
        let shape = Shape { influences: Some(influences), ..Shape::of(mesh) };
        Self { shape: Arc::new(shape), node, skin: Some(0), is_mirrored: false }
    }

    /// The mesh of a pose: the same vertices and triangles, elsewhere.
    ///
    /// ```text
    ///   p' = M p,      n' ∝ M⁻ᵀ n,      M = the node's transform, or Σ w_j J_j B_j for a skin
    /// ```
    ///
    /// with the place `J_j` of a joint and its inverse bind matrix `B_j`; the transform of the node that shows a skinned mesh
    /// does not count. Each vertex by itself, in `f64`: the same for any number of threads. The middle of a halved edge
    /// stays the mean of its ends, so that a surface of more triangles is the same in every pose.
    pub(crate) fn posed(
        &self,
        mesh: &Mesh,
        rig: &Rig,
        carrier: Carrier<'_>,
        weights: &[f64],
    ) -> Result<Mesh, SceneError> {
        let shape = &*self.shape;
        let weights: Vec<(usize, f64)> = weights.iter().copied().enumerate().filter(|&(_, w)| w != 0.0).collect();
        let whole = match carrier {
            Carrier::Node(matrix) => Some(Affine::new(matrix)),
            Carrier::Joints(_) => None,
        };
        let place = |vertex: usize| {
            let map = match (carrier, &whole) {
                (Carrier::Joints(joints), _) => Affine::new(shape.blended(vertex, joints)),
                (Carrier::Node(matrix), None) => Affine::new(matrix),
                (_, Some(whole)) => *whole,
            };
            let [p, n] = shape.morphed(vertex, &weights);
            let world = |v: DVec3| rig.up.to_world(v.as_vec3().into());
            let (tangent, sign) = shape.tangent(vertex);
            let [x, y, z] = world(map.tangent(tangent));
            ((world(map.point(p)), world(map.normal(n))), ([x, y, z, sign], map.is_mirror()))
        };
        let (vertices, tangents): (Vec<_>, Vec<_>) =
            (0..shape.len()).into_par_iter().with_min_len(PIECE).map(place).unzip();
        let (mut positions, mut normals): (Vec<_>, Vec<_>) = vertices.into_iter().unzip();
        let (mut tangents, mirrored): (Vec<_>, Vec<bool>) = tangents.into_iter().unzip();
        if shape.normals.is_empty() {
            normals = Vec::new();
        }
        if shape.tangents.is_empty() {
            tangents = Vec::new();
        }
        let middles = mesh.positions().len() - shape.len();
        for ends in &mesh.halved()[mesh.halved().len() - middles..] {
            let [a, b] = ends.map(|end| end as usize);
            push_mean(&mut positions, a, b);
            push_mean(&mut normals, a, b);
        }
        // Joints may mirror some vertices and others not: the most decide, as triangles have one outside.
        let is_mirrored = 2 * mirrored.iter().filter(|&&is_mirrored| is_mirrored).count() > shape.len();
        if is_mirrored {
            tangents.iter_mut().for_each(|[.., sign]| *sign = -*sign);
        }
        mesh.posed(positions, normals, &tangents, is_mirrored != self.is_mirrored)
    }

    /// The mesh in its own frame, z up, as nothing has moved it, with these weights of its morph targets.
    pub(crate) fn own(&self, mesh: &Mesh, rig: &Rig, weights: &[f64]) -> Result<Mesh, SceneError> {
        self.posed(mesh, rig, Carrier::Node(DMat4::IDENTITY), weights)
    }
}
