//! Input of the scene readers: a file's name for messages, its limits, and the files it references.

use std::path::{Path, PathBuf};
use std::{fs, io};

use lobe_io::one_line;

use crate::error::{SceneError, SceneReadOption};
use crate::files::folder::referenced_file;
use crate::files::read_options::{DefaultMaterial, MissingNormals, SceneReadOptions, SceneReadReport};
use crate::scene::flat::FlatMesh;
use crate::scene::mesh::{Mesh, MeshParts};
use crate::scene::scene::Scene;

/// Bytes of a vertex: position, normal, color, two pairs of texture coordinates, and room for an edge list.
const VERTEX: u64 = 64;

/// Bytes of a triangle while a tree is built, which is the most: 36 for its corners, 24 for its box, 96 for the nodes of the
/// binary tree, 108 for clusters and their partners, 64 for costs, or instead of those 100 for the wide tree.
const TRIANGLE: u64 = 320;

/// The most notes of a report: each new one is compared with all of them, and somebody is to read them.
const MOST_NOTES: usize = 100;

/// The file being read.
#[derive(Clone)]
pub(crate) struct Source<'a> {
    pub(crate) name: &'a str,
    /// The folder of the files it references; `None` if only its bytes are known.
    folder: Option<PathBuf>,
    pub(crate) options: SceneReadOptions,
    /// Vertices and triangles so far.
    unfolded: (usize, usize),
    /// Texels so far.
    texels: usize,
    /// Bytes read and decoded beside the scene so far.
    bytes: u64,
    /// Notes that were not kept.
    more_notes: usize,
    report: SceneReadReport,
}

impl<'a> Source<'a> {
    pub(crate) fn new(name: &'a str, folder: Option<PathBuf>, options: &SceneReadOptions) -> Self {
        let report = SceneReadReport::default();
        Self { name, folder, options: options.clone(), unfolded: (0, 0), texels: 0, bytes: 0, more_notes: 0, report }
    }

    /// The source of a file that was read, whose bytes are held while it is.
    pub(crate) fn of_file(
        name: &'a str,
        path: &Path,
        bytes: &[u8],
        options: &SceneReadOptions,
    ) -> Result<Self, SceneError> {
        let mut source = Self::new(name, folder_of(path), options);
        source.count_bytes(bytes.len() as u64)?;
        Ok(source)
    }

    /// The same under a name that lives longer or shorter.
    pub(crate) fn named<'b>(&self, name: &'b str) -> Source<'b> {
        let Self { folder, options, unfolded, texels, bytes, more_notes, report, .. } = self.clone();
        Source { name, folder, options, unfolded, texels, bytes, more_notes, report }
    }

    /// The report of the finished scene.
    pub(crate) fn into_report(self, scene: &Scene) -> SceneReadReport {
        let mut report = self.report;
        let [x, y, z] = scene.origin();
        if [x, y, z] != [0.0; 3] {
            report.notes.push(format!(
                "is far from the origin of its coordinates, where f32 is coarse: moved by {:?} for the work",
                [-x, -y, -z].map(|c| c + 0.0)
            ));
        }
        if self.more_notes > 0 {
            report.notes.push(format!("and {} more notes", self.more_notes));
        }
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

    pub(crate) fn refused(&self, message: String, option: SceneReadOption) -> SceneError {
        SceneError::Refused { place: one_line(self.name), message, option }
    }

    /// Adds a note on an ignored feature, once. Of many notes the first are kept, and the rest is counted.
    pub(crate) fn note(&mut self, note: impl Into<String>) {
        let note = one_line(&note.into());
        if self.report.notes.contains(&note) {
            return;
        }
        if self.report.notes.len() < MOST_NOTES {
            self.report.notes.push(note);
        } else {
            self.more_notes += 1;
        }
    }

    /// Tells at the beginning of which animation the scene stands, though nobody asked for it.
    pub(crate) fn assume_animation(&mut self, name: &str) {
        self.report.assumed_animation = Some(one_line(name));
    }

    /// Counts a mesh against the limits. Call it before the mesh is allocated.
    pub(crate) fn count(&mut self, vertices: usize, triangles: usize) -> Result<(), SceneError> {
        let (v, t) = (self.unfolded.0.saturating_add(vertices), self.unfolded.1.saturating_add(triangles));
        self.unfolded = (v, t);
        self.check_limit(v, t)?;
        self.check_bytes(0)
    }

    /// Counts bytes that are held beside the scene while it is read: of buffers, of what they are decoded to, of nodes
    /// made of instances. What is dropped again stays counted. Call it before they are allocated.
    pub(crate) fn count_bytes(&mut self, bytes: u64) -> Result<(), SceneError> {
        self.bytes = self.bytes.saturating_add(bytes);
        self.check_bytes(0)
    }

    /// The bytes that may still be taken.
    pub(crate) fn bytes_left(&self) -> u64 {
        self.options.max_bytes.saturating_sub(self.bytes_taken())
    }

    fn bytes_taken(&self) -> u64 {
        let (vertices, triangles) = self.unfolded;
        let times = |count: usize, bytes: u64| (count as u64).saturating_mul(bytes);
        let scene = times(vertices, VERTEX).saturating_add(times(triangles, TRIANGLE));
        scene.saturating_add(times(self.texels, 4)).saturating_add(self.bytes)
    }

    /// The most triangles, and the most vertices.
    pub(crate) fn limit(&self) -> usize {
        self.options.max_triangles
    }

    /// Refuses numbers that are above the limits by themselves. Call it before as much is allocated.
    pub(crate) fn check_limit(&self, vertices: usize, triangles: usize) -> Result<(), SceneError> {
        if vertices.max(triangles) <= self.options.max_triangles {
            return Ok(());
        }
        let limit = self.options.max_triangles;
        let found = format!("found {triangles} and {vertices} or more");
        let message = format!("expected at most {limit} triangles and vertices, {found}");
        Err(self.refused(message, SceneReadOption::MaxTriangles))
    }

    pub(crate) fn default_material(&self) -> DefaultMaterial {
        self.options.default_material
    }

    /// Whether triangles of meshes without normals are flat, as glTF asks.
    pub(crate) fn is_flat(&self, is_gltf: bool) -> bool {
        match self.options.missing_normals {
            MissingNormals::AsFormat => is_gltf,
            MissingNormals::Flat => true,
            MissingNormals::Smooth => false,
        }
    }

    /// Refuses what would take more memory than allowed, with the bytes that are held for a moment only.
    pub(crate) fn check_bytes(&self, bytes: u64) -> Result<(), SceneError> {
        let (taken, limit) = (self.bytes_taken().saturating_add(bytes), self.options.max_bytes);
        if taken <= limit {
            return Ok(());
        }
        let ((vertices, triangles), texels) = (self.unfolded, self.texels);
        let beside = self.bytes.saturating_add(bytes);
        let message = format!(
            "expected a scene of at most {limit} bytes, found {triangles} triangles, {vertices} vertices and {texels} \
             texels or more, each instance counted, and {beside} bytes read beside them, which take {taken}"
        );
        Err(self.refused(message, SceneReadOption::MaxBytes))
    }

    /// Refuses vertices that are held for a moment only, if they would take more memory than allowed.
    pub(crate) fn check_vertices(&self, vertices: usize) -> Result<(), SceneError> {
        self.check_bytes(VERTEX.saturating_mul(vertices as u64))
    }

    /// Counts a texture against the limits. Call it before the texture is allocated.
    pub(crate) fn count_texels(&mut self, width: u32, height: u32) -> Result<(), SceneError> {
        self.texels = (width as usize).saturating_mul(height as usize).saturating_add(self.texels);
        if self.texels > self.options.max_texels {
            let (limit, found) = (self.options.max_texels, self.texels);
            let message = format!("expected textures of at most {limit} texels, found {found} or more");
            return Err(self.refused(message, SceneReadOption::MaxTexels));
        }
        self.check_bytes(0)
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
        self.mesh_keeping(parts, |_| false)
    }

    /// The same, but triangles without area stay that are to be kept; indices may be out of range.
    pub(crate) fn mesh_keeping(
        &mut self,
        parts: MeshParts,
        is_kept: impl Fn([u32; 3]) -> bool,
    ) -> Result<Option<Mesh>, SceneError> {
        let in_file = parts.triangles.len();
        let has_area = |t: &[u32; 3]| {
            // Indices out of range are refused by `Mesh::new`.
            let corner = |i: u32| parts.positions.get(i as usize).copied().unwrap_or([f32::NAN; 3]);
            crate::scene::mesh::double_area(t.map(corner)) != 0.0
        };
        if !parts.triangles.iter().any(|t| has_area(t) || is_kept(*t)) {
            self.report.dropped_triangles += in_file;
            let what = if in_file == 0 { "no triangles" } else { "only triangles without area" };
            self.note(format!("mesh `{}` has {what} and was left out", parts.name));
            return Ok(None);
        }
        let mut parts = self.with_colors_in_range(parts);
        // The vertices of a glTF file were split when it was read.
        if parts.source.is_none() && parts.normals.is_empty() && self.is_flat(false) {
            let flat = FlatMesh::new(&parts.positions, &parts.triangles);
            self.count(flat.added.len(), 0)?;
            flat.apply(&mut parts);
        }
        let mesh = Mesh::keeping(parts, is_kept).map_err(|error| error.within(self.name))?;
        self.report.dropped_triangles += mesh.dropped_triangles();
        Ok(Some(mesh))
    }

    /// A mesh without the triangles that have lost their area in a pose; one that has no others is noted and dropped.
    pub(crate) fn with_area(&mut self, mesh: Mesh) -> Option<Mesh> {
        let (mesh, flat) = mesh.without_flat_triangles();
        self.report.dropped_triangles += flat;
        if mesh.triangles().is_empty() {
            self.note(format!("mesh `{}` has only triangles without area and was left out", mesh.name()));
            return None;
        }
        Some(mesh)
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

    /// The bytes of a referenced file, relative to the file's own folder, which it may not leave unless that is allowed.
    pub(crate) fn referenced_file(&mut self, relative: &str) -> Result<Vec<u8>, SceneError> {
        let Some(folder) = &self.folder else {
            return Err(
                self.unsupported(format!("names the file `{relative}`, but only bytes were given: read the file"))
            );
        };
        let file = referenced_file(folder, relative, self.options.allow_outside, self.name)?;
        let place = one_line(&format!("{}, named by {}", file.display(), self.name));
        let refused = |source: io::Error| SceneError::Io { place: place.clone(), source };
        self.count_bytes(length_of(&file).map_err(refused)?)?;
        fs::read(&file).map_err(refused)
    }
}

/// The name of a file for messages, and its bytes. One that is longer than allowed is refused before it is read.
pub(crate) fn read_file(path: &Path, options: &SceneReadOptions) -> Result<(String, Vec<u8>), SceneError> {
    let name = path.display().to_string();
    let refused = |source: io::Error| SceneError::Io { place: one_line(&name), source };
    let (length, limit) = (length_of(path).map_err(refused)?, options.max_bytes);
    if length > limit {
        let message = format!("expected a file of at most {limit} bytes, found {length}");
        return Err(SceneError::Refused { place: one_line(&name), message, option: SceneReadOption::MaxBytes });
    }
    let bytes = fs::read(path).map_err(refused)?;
    Ok((name, bytes))
}

/// The length of a regular file: devices and pipes may be endless.
fn length_of(path: &Path) -> io::Result<u64> {
    let found = fs::metadata(path)?;
    if !(found.is_file() || found.is_dir()) {
        return Err(io::Error::other("expected a file, found a device or a pipe"));
    }
    Ok(found.len())
}

/// The folder of referenced files.
fn folder_of(path: &Path) -> Option<PathBuf> {
    path.parent().map(Path::to_path_buf)
}
/// The note about an emissive material where a finish is not read.
pub(crate) fn emission_unused(name: &str) -> String {
    format!("material `{name}` is emissive, which is not used: light comes from the environment")
}
