//! Options and report of the scene readers.

use crate::Up;

/// Options of reading a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneReadOptions {
    /// The up axis of OBJ and PLY files. glTF is always y-up.
    pub up: Up,
    /// The most triangles, and the most vertices, to which a file may expand. A small file can hold a mesh with a
    /// thousand instances.
    pub limit: usize,
    /// The most texels to which all textures together may expand, four bytes each. A small file can hold a large
    /// picture of one color.
    pub texel_limit: usize,
    /// The most bytes that the scene may take with its tree for tracing rays, about 64 for each vertex and 320 for each
    /// triangle of all instances, and four for each texel.
    pub memory_limit: u64,
    /// Whether light goes straight through blended materials, by their alpha, and through glass, by its transmission.
    pub straight_through: bool,
}

impl Default for SceneReadOptions {
    /// y up, up to 2²⁶ triangles and vertices, up to 2²⁸ texels, 1 GiB, and no limit for all together.
    fn default() -> Self {
        Self { up: Up::Y, limit: 1 << 26, texel_limit: 1 << 28, memory_limit: u64::MAX, straight_through: false }
    }
}

impl SceneReadOptions {
    /// Sets the up axis.
    #[must_use]
    pub fn up(mut self, up: Up) -> Self {
        self.up = up;
        self
    }

    /// Sets the limit of triangles and vertices.
    #[must_use]
    pub fn limit(mut self, limit: usize) -> Self {
        self.limit = limit;
        self
    }

    /// Sets the limit of texels.
    #[must_use]
    pub fn texel_limit(mut self, texel_limit: usize) -> Self {
        self.texel_limit = texel_limit;
        self
    }

    /// Lets light straight through, or not.
    #[must_use]
    pub fn straight_through(mut self, straight_through: bool) -> Self {
        self.straight_through = straight_through;
        self
    }

    /// Sets the limit of bytes.
    #[must_use]
    pub fn memory_limit(mut self, memory_limit: u64) -> Self {
        self.memory_limit = memory_limit;
        self
    }
}

/// The report of reading a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneReadReport {
    /// Number of meshes of the scene.
    pub meshes: usize,
    /// Number of vertices, as many as in the file for each instance of a mesh.
    pub vertices: usize,
    /// Number of triangles that were kept.
    pub triangles: usize,
    /// Triangles without area, dropped.
    pub dropped_triangles: usize,
    /// Triangles at the place of others, kept: see [`Scene::coincident_triangles`](crate::Scene::coincident_triangles).
    pub coincident_triangles: usize,
    /// Vertices whose normal was missing or zero and was computed.
    pub made_normals: usize,
    /// Features of the file that Lobe ignores, a line each.
    pub notes: Vec<String>,
}
