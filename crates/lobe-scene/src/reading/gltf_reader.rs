//! glTF reader: a file that is opened once, for all that is asked of it.

use std::borrow::Cow;
use std::path::Path;

use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index, buffer};
use serde_json::Value;

use crate::error::SceneError;
use crate::files::gltf::accessor::{Accessors, view_bytes};
use crate::files::gltf::document::GltfDocument;
use crate::files::gltf::document::embed_images;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::plain;
use crate::files::read_options::{ScenePose, SceneReadOptions, SceneReadReport};
use crate::files::source::{Source, read_file};
use crate::motion::animated_scene::AnimatedScene;
use crate::motion::read::animated_scene_of;
use crate::motion::read_animations::Wanted;
use crate::reading::posed;
use crate::scene::mesh::{Mesh, MeshSource};
use crate::scene::scene::Scene;

/// A .gltf or .glb file that has been read, with the buffers that it references: its scene, its
/// [animations](crate::AnimatedScene::from_gltf), and its application-specific attributes, whose names begin with `_`.
pub struct GltfReader {
    name: String,
    pub(crate) file: GltfFile,
    /// What reading has counted and noted so far; it has no name.
    begun: Source<'static>,
}

impl GltfReader {
    /// Opens a file.
    ///
    /// # Errors
    /// As [`read_scene`](crate::read_scene), and [`SceneError::Invalid`] if the file is no glTF.
    pub fn open(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let (name, bytes) = read_file(path, options)?;
        let source = Source::of_file(&name, path, &bytes, options)?;
        Self::of(bytes.into(), source)
    }

    /// Opens the bytes of a file that references no other; `name` stands in messages.
    ///
    /// # Errors
    /// As [`Self::open`], and [`SceneError::Unsupported`] if the bytes reference other files.
    pub fn open_bytes(bytes: &[u8], name: &str, options: &SceneReadOptions) -> Result<Self, SceneError> {
        Self::of(bytes.into(), Source::new(name, None, options))
    }

    fn of(bytes: Cow<'_, [u8]>, mut source: Source<'_>) -> Result<Self, SceneError> {
        let file = plain::read(bytes, &mut source)?;
        Ok(Self { name: source.name.to_owned(), file, begun: source.named("") })
    }

    /// The name of the file in messages.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file as a source from which reading goes on.
    pub(crate) fn source(&self) -> Source<'_> {
        self.begun.named(&self.name)
    }

    /// The scene, as [`read_scene`](crate::read_scene) gives it: in the pose of [`SceneReadOptions::pose`].
    ///
    /// # Errors
    /// As [`read_scene`](crate::read_scene).
    pub fn scene(&self) -> Result<(Scene, SceneReadReport), SceneError> {
        self.scene_in(&self.begun.options.pose)
    }

    /// The scene in another pose than that of the options.
    ///
    /// # Errors
    /// As [`read_scene`](crate::read_scene).
    pub fn scene_in(&self, pose: &ScenePose) -> Result<(Scene, SceneReadReport), SceneError> {
        let mut source = self.source();
        let scene = posed::scene_of(&self.file, pose, &mut source)?;
        let report = source.into_report(&scene);
        Ok((scene, report))
    }

    /// The scene, and the whole file: they belong together whatever happens to the file on the disk. The report notes each picture
    /// that could not be embedded.
    ///
    /// # Errors
    /// As [`Self::scene`]. A missing picture that the scene does not use is no error: its URI is kept.
    pub fn into_scene_and_document(mut self) -> Result<(Scene, SceneReadReport, GltfDocument), SceneError> {
        let mut source = self.begun.named(&self.name);
        embed_images(&mut self.file, &mut source)?;
        let scene = posed::scene_of(&self.file, &self.begun.options.pose, &mut source)?;
        let document = GltfDocument::of_file(self.file, &source)?;
        let report = source.into_report(&scene);
        Ok((scene, report, document))
    }

    /// Whether a pose may differ from how the nodes stand: there are animations, skins, or weights of morph targets.
    #[must_use]
    pub fn has_poses(&self) -> bool {
        posed::has_poses(&self.file.json)
    }

    /// The members of this name in the `extras` of the file: of its asset, of the scene that it shows, and of its
    /// meshes in their order. Programs that write the file anew keep some of these places, and drop others.
    pub fn extras(&self, name: &str) -> impl Iterator<Item = &Value> {
        let json = &self.file.json;
        let scene = &json["scenes"][self.file.root.scene.unwrap_or(0)];
        let meshes = json["meshes"].as_array().into_iter().flatten();
        [&json["asset"], scene].into_iter().chain(meshes).filter_map(move |object| object.get("extras")?.get(name))
    }

    /// Whether the primitive from which a mesh comes has an attribute of this name.
    #[must_use]
    pub fn has(&self, mesh: &Mesh, name: &str) -> bool {
        mesh.source().is_some_and(|at| self.accessor(at, name).is_some_and(|found| found.is_some()))
    }

    /// Whether the numbers of an attribute are fractions of their largest whole number.
    #[must_use]
    pub fn is_normalized(&self, mesh: &Mesh, name: &str) -> bool {
        let accessor = mesh.source().and_then(|at| self.accessor(at, name).flatten());
        accessor.and_then(|index| self.file.root.accessors.get(index.value())).is_some_and(|found| found.normalized)
    }

    /// The attribute of this name, with `N` floats for each vertex, of the primitive from which a mesh comes; `None`
    /// without one.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if it does not hold vectors of `N` floats, or its numbers are not in the file.
    pub fn vectors<const N: usize>(&self, at: MeshSource, name: &str) -> Result<Option<Vec<[f32; N]>>, SceneError> {
        let source = self.source();
        let Some(found) = self.accessor(at, name) else {
            let message = format!("mesh {} has no primitive {}", at.mesh, at.primitive);
            return Err(source.invalid(message));
        };
        let Some(index) = found else { return Ok(None) };
        let place = format!("mesh {}, primitive {}", at.mesh, at.primitive);
        Accessors { file: &self.file, place }.vectors(name, index, &source).map(Some)
    }

    /// The accessor of an attribute, if there is one; nothing if there is no such primitive.
    fn accessor(&self, at: MeshSource, name: &str) -> Option<Option<Index<Accessor>>> {
        let primitive = self.file.root.meshes.get(at.mesh)?.primitives.get(at.primitive)?;
        let semantic = Semantic::Extras(name.trim_start_matches('_').to_string());
        Some(primitive.attributes.get(&Checked::Valid(semantic)).copied())
    }

    /// The bytes of a buffer view.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if there is no such view, or its bytes are not in the file.
    pub fn buffer_view(&self, index: u32) -> Result<&[u8], SceneError> {
        let view: Index<buffer::View> = Index::new(index);
        view_bytes(&self.file, view).map_err(|message| SceneError::invalid(&self.name, message))
    }
}

impl AnimatedScene {
    /// The scene with its animations of an open file.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_gltf(gltf: &GltfReader) -> Result<(Self, SceneReadReport), SceneError> {
        let mut source = gltf.source();
        let scene = animated_scene_of(&gltf.file, &Wanted::All, false, &mut source)?;
        let report = source.into_report(scene.rest());
        Ok((scene, report))
    }
}
