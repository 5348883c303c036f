//! Input of the scene readers: a file's name for messages, its limits, and the files it references.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::{Mesh, MeshParts, Scene, SceneError, SceneLimit, SceneReadOptions, SceneReadReport};

/// Bytes of a vertex: position, normal, color, two pairs of texture coordinates, and room for an edge list.
const VERTEX: u64 = 64;

/// Bytes of a triangle while a tree is built, which is the most: 36 for its corners, 24 for its box, 96 for the nodes of the
/// binary tree, 108 for clusters and their partners, 64 for costs, or instead of those 100 for the wide tree.
const TRIANGLE: u64 = 320;

/// The file being read.
pub(crate) struct Source<'a> {
    pub(crate) name: &'a str,
    /// The folder of the files it references; `None` if only its bytes are known.
    folder: Option<PathBuf>,
    limit: usize,
    texel_limit: usize,
    memory_limit: u64,
    pub(crate) straight_through: bool,
    /// Vertices and triangles so far.
    unfolded: (usize, usize),
    /// Texels so far.
    texels: usize,
    report: SceneReadReport,
}

impl<'a> Source<'a> {
    pub(crate) fn new(name: &'a str, folder: Option<PathBuf>, options: &SceneReadOptions) -> Self {
        let SceneReadOptions { limit, texel_limit, memory_limit, straight_through, .. } = *options;
        let report = SceneReadReport::default();
        let unfolded = (0, 0);
        Self { name, folder, limit, texel_limit, memory_limit, straight_through, unfolded, texels: 0, report }
    }

    /// The report of the finished scene.
    pub(crate) fn into_report(self, scene: &Scene) -> SceneReadReport {
        let mut report = self.report;
        report.meshes = scene.meshes().len();
        report.vertices = scene.vertex_count();
        report.triangles = scene.triangle_count();
        report.coincident_triangles = scene.coincident_triangles();
        report.made_normals = scene.meshes().iter().map(Mesh::made_normals).sum();
        report
    }

    pub(crate) fn invalid(&self, message: impl Into<String>) -> SceneError {
        SceneError::invalid(self.name, message)
    }

    pub(crate) fn unsupported(&self, message: impl Into<String>) -> SceneError {
        SceneError::unsupported(self.name, message)
    }

    /// Adds a note on an ignored feature, once.
    pub(crate) fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.report.notes.contains(&note) {
            self.report.notes.push(note);
        }
    }

    /// Whether a mesh of so many vertices is within the limits, whatever else there is.
    pub(crate) fn has_room(&self, vertices: usize) -> bool {
        vertices <= self.limit
    }

    /// Counts a mesh against the limits. Call it before the mesh is allocated.
    pub(crate) fn count(&mut self, vertices: usize, triangles: usize) -> Result<(), SceneError> {
        let (v, t) = (self.unfolded.0.saturating_add(vertices), self.unfolded.1.saturating_add(triangles));
        self.unfolded = (v, t);
        if v.max(t) > self.limit {
            let (name, limit) = (self.name, self.limit);
            let message = format!("{name}: expected at most {limit} triangles and vertices, found {t} and {v} or more");
            return Err(SceneError::TooLarge { message, limit: SceneLimit::Triangles });
        }
        self.check_memory()
    }

    /// Refuses what would take more memory than allowed.
    fn check_memory(&self) -> Result<(), SceneError> {
        let (vertices, triangles) = self.unfolded;
        let times = |count: usize, bytes: u64| (count as u64).saturating_mul(bytes);
        let bytes = times(vertices, VERTEX).saturating_add(times(triangles, TRIANGLE));
        let bytes = bytes.saturating_add(times(self.texels, 4));
        if bytes <= self.memory_limit {
            return Ok(());
        }
        let (name, limit) = (self.name, self.memory_limit);
        let message = format!(
            "{name}: expected a scene of at most {limit} bytes, found {triangles} triangles, {vertices} vertices and {} texels \
             or more, each instance counted, which take {bytes}",
            self.texels
        );
        Err(SceneError::TooLarge { message, limit: SceneLimit::Memory })
    }

    /// Counts a texture against the limits. Call it before the texture is allocated.
    pub(crate) fn count_texels(&mut self, width: u32, height: u32) -> Result<(), SceneError> {
        self.texels = (width as usize).saturating_mul(height as usize).saturating_add(self.texels);
        if self.texels > self.texel_limit {
            let (name, limit, found) = (self.name, self.texel_limit, self.texels);
            let message = format!("{name}: expected textures of at most {limit} texels, found {found} or more");
            return Err(SceneError::TooLarge { message, limit: SceneLimit::Texels });
        }
        self.check_memory()
    }

    /// Clamps a number to the format's range of 0 to 1, with a note.
    pub(crate) fn unit(&mut self, value: f32, what: &str) -> f32 {
        let inside = value.clamp(0.0, 1.0);
        if inside != value {
            self.note(format!("{what} of {value} is outside of 0 to 1, and taken as {inside}"));
        }
        inside
    }

    /// Creates a mesh; one whose triangles all lack area is noted and dropped.
    pub(crate) fn mesh(&mut self, parts: MeshParts) -> Result<Option<Mesh>, SceneError> {
        let in_file = parts.triangles.len();
        let has_area = |t: &[u32; 3]| {
            // Indices out of range are refused by `Mesh::new`.
            let corner = |i: u32| parts.positions.get(i as usize).copied().unwrap_or([f32::NAN; 3]);
            crate::scene::mesh::double_area(t.map(corner)) != 0.0
        };
        if !parts.triangles.iter().any(has_area) {
            self.report.dropped_triangles += in_file;
            let what = if in_file == 0 { "no triangles" } else { "only triangles without area" };
            self.note(format!("mesh `{}` has {what} and was left out", parts.name));
            return Ok(None);
        }
        let parts = self.with_colors_in_range(parts);
        let mesh = Mesh::new(parts).map_err(|error| error.within(self.name))?;
        self.report.dropped_triangles += mesh.dropped_triangles();
        Ok(Some(mesh))
    }

    /// Clamps colors to the range of glTF, 0 to 1; non-finite ones are refused by `Mesh::new`.
    fn with_colors_in_range(&mut self, mut parts: MeshParts) -> MeshParts {
        let mut moved = 0;
        for color in &mut parts.colors {
            let inside = color.map(|c| c.clamp(0.0, 1.0));
            if color.iter().all(|c| c.is_finite()) && inside != *color {
                *color = inside;
                moved += 1;
            }
        }
        if moved > 0 {
            self.note(format!("mesh `{}` has colors outside of 0 to 1 at {moved} vertices, moved there", parts.name));
        }
        parts
    }

    /// The error of a file without any triangle that has an area.
    pub(crate) fn no_triangles(&self) -> SceneError {
        match self.report.dropped_triangles {
            0 => self.invalid("expected triangles, found none"),
            count => self.invalid(format!("expected triangles with an area, found {count} without")),
        }
    }

    /// The bytes of a referenced file, relative to the file's own folder.
    pub(crate) fn neighbor(&self, relative: &str) -> Result<Vec<u8>, SceneError> {
        let Some(folder) = &self.folder else {
            return Err(
                self.unsupported(format!("names the file `{relative}`, but only bytes were given: read the file"))
            );
        };
        let path = folder.join(relative);
        read_regular(&path)
            .map_err(|source| SceneError::Io { place: format!("{}, named by {}", path.display(), self.name), source })
    }
}

/// The name of a file for messages, and its bytes.
pub(crate) fn read_file(path: &Path) -> Result<(String, Vec<u8>), SceneError> {
    let name = path.display().to_string();
    match read_regular(path) {
        Ok(bytes) => Ok((name, bytes)),
        Err(source) => Err(SceneError::Io { place: name, source }),
    }
}

/// The bytes of a regular file: devices and pipes may be endless.
fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let kind = fs::metadata(path)?;
    if !(kind.is_file() || kind.is_dir()) {
        return Err(io::Error::other("expected a file, found a device or a pipe"));
    }
    fs::read(path)
}

/// The folder of referenced files.
pub(crate) fn folder_of(path: &Path) -> Option<PathBuf> {
    path.parent().map(Path::to_path_buf)
}
