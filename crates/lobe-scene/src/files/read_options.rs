//! Options and reports of reading scenes.

use crate::Up;

/// How a file is to be read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneReadOptions {
    /// Which axis points up in OBJ and PLY files. glTF is always y-up.
    pub up: Up,
    /// The most triangles, and the most vertices, that a file may unfold to. A small file can hold a mesh that a
    /// thousand nodes show.
    pub limit: usize,
    /// The most texels that all textures together may unfold to, four bytes each. A small file can hold a large picture of
    /// one color.
    pub texel_limit: usize,
}

impl Default for SceneReadOptions {
    /// y up, up to 2²⁶ triangles and vertices, and up to 2²⁸ texels: 1 GiB.
    fn default() -> Self {
        Self { up: Up::Y, limit: 1 << 26, texel_limit: 1 << 28 }
    }
}

impl SceneReadOptions {
    /// The same options with another axis that points up.
    #[must_use]
    pub fn up(mut self, up: Up) -> Self {
        self.up = up;
        self
    }

    /// The same options with another limit of triangles and vertices.
    #[must_use]
    pub fn limit(mut self, limit: usize) -> Self {
        self.limit = limit;
        self
    }

    /// The same options with another limit of texels.
    #[must_use]
    pub fn texel_limit(mut self, texel_limit: usize) -> Self {
        self.texel_limit = texel_limit;
        self
    }
}

/// What was read, and what was done to it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneReadReport {
    /// Number of meshes of the scene.
    pub meshes: usize,
    /// Number of vertices, as many as in the file for each time a mesh is shown.
    pub vertices: usize,
    /// Number of triangles that are left.
    pub triangles: usize,
    /// Triangles without area, dropped.
    pub dropped_triangles: usize,
    /// Vertices whose normal was missing or zero and was made.
    pub made_normals: usize,
    /// What the file holds and Lobe does not use, a line each.
    pub notes: Vec<String>,
}
