//! A scene as a job names it: its file or a built-in one, how it is read, and what was read.

use std::path::PathBuf;

use lobe_io::{Given, GivenPaths, JobOptions, NumberRange, OptionError, OptionField, OptionKind, options};

use crate::built_in;
use crate::error::SceneError;
use crate::files::gltf::document::GltfDocument;
use crate::files::read_options::{DefaultMaterial, MissingNormals, ScenePose, SceneReadOptions};
use crate::files::scene_format::{SceneFormat, all_scene_endings, is_gltf};
use crate::reading::gltf_reader::GltfReader;
use crate::reading::read_scene::read_scene;
use crate::scene::scene::Scene;
use crate::scene::up::Up;

/// The prefix of the names of built-in scenes.
pub const BUILT_IN: &str = "built-in:";

/// Options that only files have a use for.
const OF_FILES: [&str; 5] = ["max_triangles", "max_texels", "allow_outside", "missing_normals", "transparency"];

options! {
    /// Where a scene is, and how it is read.
    pub struct SceneSource {
        #[doc = concat!(" The scene: a ", all_scene_endings!(), " file, or built-in:NAME with ball (over a ground), columns (a")]
        /// hall), cave, terrain, still-life (a knot between colored screens), cornell (a room that is unfolded for
        /// `texels`) or furnace (a closed white box, which no light enters: for tests); of lobe render also
        /// three-objects and walking-figure, which move
        #[serde(serialize_with = "lobe_io::as_text")]
        scene: PathBuf = PathBuf::new(), OptionKind::File, "SCENE", "";
        /// Which axis points up in a file that leaves it open, as .obj and .ply do
        up: Up = Up::Y, OptionKind::Name(&[("y", ""), ("z", "")]), "AXIS", "";
        /// The most triangles, and the most vertices, that a file may hold, its instances counted
        max_triangles: usize = SceneReadOptions::default().max_triangles,
            OptionKind::Whole { least: 1, most: SceneReadOptions::MOST_TRIANGLES as u64, what: "a number of triangles" },
            "N", "";
        /// The most texels that all textures of a file together may have
        max_texels: usize = SceneReadOptions::default().max_texels,
            OptionKind::Whole { least: 1, most: SceneReadOptions::MOST_TEXELS as u64, what: "a number of texels" },
            "N", "";
        /// Trust the file: it may name buffers, materials and pictures outside of its folder, which are read and may
        /// be copied into the output
        allow_outside: bool = false, OptionKind::Flag, "", "";
        /// The normals of meshes without any: of their triangles, which takes more vertices, or smooth
        missing_normals: Option<MissingNormals> = None, OptionKind::Name(&[("flat", ""), ("smooth", "")]), "KIND",
            "flat of glTF, as it asks, smooth of .ply, and of .obj as its smoothing groups say, or else smooth";
        /// The material of glTF meshes without any: white, matte and double-sided, or glTF's, a single-sided white
        /// metal, on which transfer is black
        default_material: DefaultMaterial = DefaultMaterial::White,
            OptionKind::Name(&[("white", ""), ("gltf", "")]), "KIND", "";
        /// Let light straight through blended surfaces of a glTF file, by their alpha, and through glass, by its
        /// transmission; without this they are opaque
        transparency: bool = false, OptionKind::Flag, "", "";
        /// Take a glTF file that moves, by animations, skins or morph targets, as it stands at this time; of lobe
        /// render also a scene description (.json) and the built-in scenes that move
        time: Option<f64> = None, OptionKind::Number(NumberRange::Finite), "SECONDS", "0";
        /// The animation of a glTF file, by name or number
        animation: Option<String> = None, OptionKind::Text, "NAME", "the first";
        unasked {
            /// [`SceneReadOptions::finish`], for programs whose surfaces are not matte.
            finish: bool = false;
        }
    }
}

impl JobOptions for SceneSource {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }

    fn heading_of(name: &str) -> Option<&'static str> {
        (name != "scene").then_some("Reading the scene")
    }

    fn set_paths(&mut self, given: GivenPaths<'_>) {
        if let Some(scene) = given("scene").and_then(|paths| paths.into_iter().next()) {
            self.scene = scene;
        }
    }

    /// Refuses options of files that the scene has no use for.
    fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
        let refused = |option: &str, why: &str| Err(OptionError::new(option, format!("{why}; leave the option out")));
        if let Some(option) = given.first_of(&OF_FILES).filter(|_| self.built_in_name().is_some()) {
            return refused(option, "only of scenes in files");
        }
        if given.has("up") && !SceneFormat::of_name(&self.scene).is_some_and(SceneFormat::leaves_up_open) {
            let open = SceneFormat::names(SceneFormat::leaves_up_open);
            return refused("up", &format!("only {open} files leave open which axis points up"));
        }
        if given.has("default_material") && !self.is_gltf() {
            return refused("default_material", "only of glTF files, which say what a mesh without a material is");
        }
        Ok(())
    }
}

/// A scene that was read, and what a user should know of it.
#[derive(Debug)]
#[non_exhaustive]
pub struct ReadScene {
    /// The scene.
    pub scene: Scene,
    /// All that its glTF file holds, if it is to be kept.
    pub document: Option<GltfDocument>,
    /// The pose of the scene, if its file poses it.
    pub pose: Option<ScenePose>,
    /// What a user should know, each in one line. Options have `@` before their names.
    pub remarks: Vec<String>,
}

impl SceneSource {
    /// A scene that is read by the defaults.
    #[must_use]
    pub fn of(scene: impl Into<PathBuf>) -> Self {
        Self::default().scene(scene.into())
    }

    /// The path, or the name of a built-in scene with its prefix.
    #[must_use]
    pub fn name(&self) -> String {
        self.scene.display().to_string()
    }

    /// The name without its folders, which says the same on every machine.
    #[must_use]
    pub fn file_name(&self) -> String {
        self.scene.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The name of a built-in scene, if it is one, without its prefix.
    #[must_use]
    pub fn built_in_name(&self) -> Option<&str> {
        self.scene.to_str()?.strip_prefix(BUILT_IN)
    }

    /// Whether the scene is a built-in one that moves.
    #[must_use]
    pub fn is_built_in_motion(&self) -> bool {
        self.built_in_name().is_some_and(|name| built_in::MOVING_NAMES.contains(&name))
    }

    /// Whether the scene is in a glTF file.
    #[must_use]
    pub fn is_gltf(&self) -> bool {
        is_gltf(&self.scene)
    }

    /// Whether the file's name ends so, in letters of any case.
    #[must_use]
    pub fn has_extension(&self, extensions: &[&str]) -> bool {
        let found = self.scene.extension().unwrap_or_default();
        extensions.iter().any(|extension| found.eq_ignore_ascii_case(extension))
    }

    /// The option that asks for a time, if one does.
    #[must_use]
    pub fn option_of_pose(&self) -> Option<&'static str> {
        self.time.map(|_| "time").or(self.animation.as_ref().map(|_| "animation"))
    }

    /// The pose that is asked for.
    #[must_use]
    pub fn pose(&self) -> ScenePose {
        ScenePose::asked(self.animation.clone(), self.time)
    }

    /// The options of reading, with at most so many bytes.
    #[must_use]
    pub fn read_options(&self, max_bytes: u64) -> SceneReadOptions {
        SceneReadOptions {
            up: self.up,
            max_triangles: self.max_triangles,
            max_texels: self.max_texels,
            max_bytes,
            allow_outside: self.allow_outside,
            missing_normals: self.missing_normals.unwrap_or_default(),
            default_material: self.default_material,
            straight_through: self.transparency,
            pose: self.pose(),
            finish: self.finish,
            ..SceneReadOptions::default()
        }
    }

    /// Reads or makes the scene as it stands at the time that is asked for, and with it all that a glTF file holds, if
    /// that is to be kept.
    ///
    /// # Errors
    /// [`SceneError::OfJob`] for what is no scene that stands still, and options that it has no use for; else those of
    /// reading.
    pub fn read(&self, max_bytes: u64, keeps_document: bool) -> Result<ReadScene, SceneError> {
        self.read_with(&self.read_options(max_bytes), keeps_document)
    }

    /// [`SceneSource::read`] with other options of reading.
    pub(crate) fn read_with(&self, options: &SceneReadOptions, keeps_document: bool) -> Result<ReadScene, SceneError> {
        self.check()?;
        if self.has_extension(&["json"]) {
            let text =
                concat!("only lobe render reads descriptions of scenes; expected a file named ", all_scene_endings!());
            return Err(OptionError::new("", format!("{}: {text}", self.name())).into());
        }
        if let Some(name) = self.built_in_name() {
            self.expect_no_time()?;
            let scene = self.built_in(name)?;
            return Ok(ReadScene { scene, document: None, pose: None, remarks: Vec::new() });
        }
        if !self.is_gltf() {
            self.expect_no_time()?;
            let (scene, report) = read_scene(&self.scene, options)?;
            return Ok(ReadScene { scene, document: None, pose: None, remarks: report.remarks_with_options() });
        }
        let gltf = GltfReader::open(&self.scene, options)?;
        let pose = gltf.has_poses().then(|| self.pose());
        let (scene, report, document) = if keeps_document {
            let (scene, report, document) = gltf.into_scene_and_document()?;
            (scene, report, Some(document))
        } else {
            let (scene, report) = gltf.scene()?;
            (scene, report, None)
        };
        Ok(ReadScene { scene, document, pose, remarks: report.remarks_with_options() })
    }

    /// Refuses times of scenes that stand still.
    fn expect_no_time(&self) -> Result<(), OptionError> {
        match self.option_of_pose() {
            Some(option) => {
                let text = "only what a glTF file moves stands elsewhere then; leave the option out";
                Err(OptionError::new(option, text))
            }
            None => Ok(()),
        }
    }

    /// A built-in scene that stands still.
    fn built_in(&self, name: &str) -> Result<Scene, SceneError> {
        let refused = |message: String| OptionError::new("", format!("{}: {message}", self.name()));
        if self.is_built_in_motion() {
            let text = "moves; lobe render moving and lobe render trace show it, and fields and spheres take one \
                        @entity NAME of it";
            return Err(refused(text.to_owned()).into());
        }
        built_in::named(name).ok_or_else(|| {
            let prefixed = |known: &str| format!("{BUILT_IN}{known}");
            let (known, moving) = (built_in::NAMES.map(prefixed), built_in::MOVING_NAMES.map(prefixed));
            refused(format!(
                "there is no such scene in the program; there are {}; of lobe render also {}, which move",
                known.join(", "),
                moving.join(" and ")
            ))
            .into()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_a_scene_has_no_use_for_are_refused() {
        let source = |path: &str| SceneSource::of(path);
        for (source, expected) in [
            (source("a.glb").up(Up::Z), "up: only .obj or .ply files leave open"),
            (source("a.obj").default_material(DefaultMaterial::AsFormat), "default_material: only of glTF files"),
            (source("built-in:cave").transparency(true), "transparency: only of scenes in files"),
            (source("built-in:cave").max_texels(1), "max_texels: only of scenes in files"),
            (source("built-in:cave").time(Some(1.0)), "time: only what a glTF file moves"),
            (source("built-in:walking-figure"), "built-in:walking-figure: moves; "),
            (source("built-in:nowhere"), "built-in:nowhere: there is no such scene"),
        ] {
            let error = source.read(u64::MAX, false).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        assert!(source("a.obj").up(Up::Z).check().is_ok(), "an axis of an .obj");
    }

    #[test]
    fn every_built_in_scene_is_read_by_its_name() {
        for name in built_in::NAMES {
            let read = SceneSource::of(format!("{BUILT_IN}{name}")).read(u64::MAX, true).unwrap();
            assert!(read.scene.triangle_count() > 0 && read.document.is_none(), "{name}");
        }
    }

    #[test]
    fn names_in_files_are_those_of_options() {
        let asked = r#"{"scene": "a.ply", "up": "z", "missing_normals": "flat"}"#;
        let source = SceneSource::from_values(serde_json::from_str(asked).unwrap()).unwrap();
        let options = source.read_options(7);
        assert_eq!((options.up, options.missing_normals, options.max_bytes), (Up::Z, MissingNormals::Flat, 7));
        assert_eq!(SceneSource::default().read_options(u64::MAX), SceneReadOptions::default(), "defaults");
    }
}
