//! Scenes from files, whatever their format.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::files::read_gltf;
use crate::files::read_obj;
use crate::files::read_ply;
use crate::{Mesh, MeshParts, Scene, SceneError, Up};

/// The version of the attributes that Lobe writes into a baked glTF file and names in `asset.extras.lobe.version`.
/// Files with a higher one are refused.
pub const LOBE_EXTRAS_VERSION: u64 = 1;

/// How a file is to be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Which axis points up in OBJ and PLY files. glTF is always y-up.
    pub up: Up,
    /// The most triangles, and the most vertices, that a file may unfold to. A small file can hold a mesh that a
    /// thousand nodes show.
    pub limit: usize,
    /// The most texels that all textures together may unfold to, four bytes each. A small file can hold a large picture of
    /// one color.
    pub texel_limit: usize,
}

impl Default for ReadOptions {
    /// y up, up to 2²⁶ triangles and vertices, and up to 2²⁸ texels: 1 GiB.
    fn default() -> Self {
        Self { up: Up::Y, limit: 1 << 26, texel_limit: 1 << 28 }
    }
}

/// What was read, and what was done to it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadReport {
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

/// Reads a scene from a .gltf, .glb, .obj or .ply file, with the files it names: z up, in the file's unit of length.
///
/// # Errors
/// [`SceneError::Io`] if a file cannot be read, [`SceneError::Unsupported`] if it is of another kind or needs what
/// Lobe does not read, [`SceneError::Invalid`] if it contradicts itself or holds no triangle with an area,
/// [`SceneError::TooLarge`] if it unfolds to more than [`ReadOptions::limit`], [`SceneError::Options`] if to more than
/// [`ReadOptions::texel_limit`].
pub fn read_scene(path: impl AsRef<Path>, options: &ReadOptions) -> Result<(Scene, ReadReport), SceneError> {
    let path = path.as_ref();
    let (name, bytes) = read_file(path)?;
    read(&bytes, Source::new(&name, folder_of(path), options), options.up)
}

/// Reads a scene from the bytes of a file that names no other files; `name` decides the format and stands in messages.
///
/// # Errors
/// As [`read_scene`], and [`SceneError::Unsupported`] if the bytes name other files.
pub fn read_scene_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<(Scene, ReadReport), SceneError> {
    read(bytes, Source::new(name, None, options), options.up)
}

/// The name of a file for messages, and its bytes.
pub(crate) fn read_file(path: &Path) -> Result<(String, Vec<u8>), SceneError> {
    let name = path.display().to_string();
    match read_regular(path) {
        Ok(bytes) => Ok((name, bytes)),
        Err(source) => Err(SceneError::Io { place: name, source }),
    }
}

/// The bytes of a file that ends: devices and pipes need not.
fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let kind = fs::metadata(path)?;
    if !(kind.is_file() || kind.is_dir()) {
        return Err(io::Error::other("expected a file, found a device or a pipe"));
    }
    fs::read(path)
}

/// Where the files lie that a file names.
pub(crate) fn folder_of(path: &Path) -> Option<PathBuf> {
    path.parent().map(Path::to_path_buf)
}

fn read(bytes: &[u8], source: Source<'_>, up: Up) -> Result<(Scene, ReadReport), SceneError> {
    let mut source = source;
    let extension = Path::new(source.name).extension().map(|e| e.to_string_lossy().to_lowercase());
    let scene = match extension.as_deref() {
        Some("gltf" | "glb") => read_gltf::read(bytes, &mut source)?.0,
        Some("obj") => read_obj::read(bytes, &mut source, up)?,
        Some("ply") => read_ply::read(bytes, &mut source, up)?,
        _ => return Err(source.unsupported("expected a file named .gltf, .glb, .obj or .ply")),
    };
    let report = source.into_report(&scene);
    Ok((scene, report))
}

/// A file that is being read.
pub(crate) struct Source<'a> {
    pub(crate) name: &'a str,
    /// Where the files it names lie; none if only its bytes are known.
    folder: Option<PathBuf>,
    limit: usize,
    texel_limit: usize,
    /// Vertices and triangles so far.
    unfolded: (usize, usize),
    /// Texels so far.
    texels: usize,
    report: ReadReport,
}

impl<'a> Source<'a> {
    pub(crate) fn new(name: &'a str, folder: Option<PathBuf>, options: &ReadOptions) -> Self {
        let ReadOptions { limit, texel_limit, .. } = *options;
        Self { name, folder, limit, texel_limit, unfolded: (0, 0), texels: 0, report: ReadReport::default() }
    }

    /// What was read and done, once the scene is there.
    pub(crate) fn into_report(self, scene: &Scene) -> ReadReport {
        let mut report = self.report;
        report.meshes = scene.meshes().len();
        report.vertices = scene.vertex_count();
        report.triangles = scene.triangle_count();
        report.made_normals = scene.meshes().iter().map(Mesh::made_normals).sum();
        report
    }

    pub(crate) fn invalid(&self, message: impl Into<String>) -> SceneError {
        SceneError::invalid(self.name, message)
    }

    pub(crate) fn unsupported(&self, message: impl Into<String>) -> SceneError {
        SceneError::unsupported(self.name, message)
    }

    /// Says once that something in the file is not used.
    pub(crate) fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.report.notes.contains(&note) {
            self.report.notes.push(note);
        }
    }

    /// To be called before the memory for a mesh is taken.
    pub(crate) fn count(&mut self, vertices: usize, triangles: usize) -> Result<(), SceneError> {
        let (v, t) = (self.unfolded.0.saturating_add(vertices), self.unfolded.1.saturating_add(triangles));
        self.unfolded = (v, t);
        if v.max(t) > self.limit {
            let (name, limit) = (self.name, self.limit);
            let message = format!("{name}: expected at most {limit} triangles and vertices, found {t} and {v} or more");
            return Err(SceneError::TooLarge { message });
        }
        Ok(())
    }

    /// To be called before the memory for a texture is taken.
    pub(crate) fn count_texels(&mut self, width: u32, height: u32) -> Result<(), SceneError> {
        self.texels = (width as usize).saturating_mul(height as usize).saturating_add(self.texels);
        if self.texels > self.texel_limit {
            let (name, limit, found) = (self.name, self.texel_limit, self.texels);
            let advice = "make the textures smaller, or raise the limit";
            return Err(SceneError::Options(format!(
                "{name}: expected textures of at most {limit} texels, found {found} or more: {advice}"
            )));
        }
        Ok(())
    }

    /// A number that its format keeps from 0 to 1; what lies outside is moved there and noted.
    pub(crate) fn unit(&mut self, value: f32, what: &str) -> f32 {
        let inside = value.clamp(0.0, 1.0);
        if inside != value {
            self.note(format!("{what} of {value} is outside of 0 to 1, and taken as {inside}"));
        }
        inside
    }

    /// Makes a mesh; one whose triangles all lack area is noted and left out.
    pub(crate) fn mesh(&mut self, parts: MeshParts) -> Result<Option<Mesh>, SceneError> {
        let in_file = parts.triangles.len();
        let has_area = |t: &[u32; 3]| {
            // Indices out of range are `Mesh::new`'s to refuse.
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

    /// Moves colors into the range from 0 to 1, as glTF wants it; those that are no numbers are `Mesh::new`'s to refuse.
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

    /// The bytes of a file that the file names, relative to its own folder.
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
