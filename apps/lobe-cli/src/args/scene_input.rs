//! Scenes as inputs: files and built-in scenes.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::scene::{DefaultMaterial, MissingNormals, SceneReadOptions, SceneReadReport, Up, built_in, is_gltf};

use crate::args::memory::MemoryLimit;
use crate::args::scene_limits::SceneLimits;
use crate::args::scene_pose::PoseInput;
use crate::run::talk::Talk;

/// The prefix of the names of built-in scenes.
pub(crate) const BUILT_IN: &str = "built-in:";

/// Where a scene is.
#[derive(Args)]
pub(crate) struct SceneInput {
    /// The scene: a .glb, .gltf, .vrm, .obj or .ply file, or built-in:NAME with ball (over a ground), columns (a hall), cave, terrain,
    /// still-life (a knot between colored screens), cornell (a room that is unfolded for --texels) or furnace (a closed white box,
    /// which no light enters: for tests); of
    /// lobe render also three-objects and walking-figure, which move
    #[arg(value_name = "SCENE")]
    path: PathBuf,
    /// Which axis points up in an .obj or .ply file [default: y]
    #[arg(long, value_enum)]
    up: Option<UpAxis>,
    #[command(flatten)]
    limits: SceneLimits,
    /// Trust the file: it may name buffers, materials and pictures outside of its folder, which are read and may be copied into
    /// the output
    #[arg(long)]
    allow_outside: bool,
    /// The normals of meshes without any: of their triangles, which takes more vertices, or smooth [default: flat of glTF, as it
    /// asks, smooth of .ply, and of .obj as its smoothing groups say, or else smooth]
    #[arg(long, value_enum)]
    missing_normals: Option<NormalsName>,
    /// The material of glTF meshes without any: white, matte and double-sided, or glTF's, a single-sided white metal, on which
    /// transfer is black [default: white]
    #[arg(long, value_enum)]
    default_material: Option<MaterialName>,
    /// Let light straight through blended surfaces of a glTF file, by their alpha, and through glass, by its transmission;
    /// without this they are opaque
    #[arg(long)]
    transparency: bool,
    #[command(flatten)]
    pub(crate) pose: PoseInput,
}

#[derive(Clone, Copy, ValueEnum)]
enum NormalsName {
    Flat,
    Smooth,
}

#[derive(Clone, Copy, ValueEnum)]
enum MaterialName {
    White,
    Gltf,
}

#[derive(Clone, Copy, ValueEnum)]
enum UpAxis {
    Y,
    Z,
}

impl SceneInput {
    pub(crate) fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// The file, or the name of a built-in scene with its prefix.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether light goes straight through glass and blended surfaces.
    pub(crate) fn is_see_through(&self) -> bool {
        self.transparency
    }

    /// The name without its folders, which says the same on every machine.
    pub(crate) fn file_name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Whether the scene is one of the program that moves.
    pub(crate) fn is_built_in_motion(&self) -> bool {
        self.name().strip_prefix(BUILT_IN).is_some_and(|name| built_in::MOVING_NAMES.contains(&name))
    }

    /// Whether the scene is read from a glTF file.
    pub(crate) fn is_gltf(&self) -> bool {
        is_gltf(&self.path)
    }

    /// Refuses options of files for scenes that are made by a formula.
    pub(crate) fn check_built_in_options(&self) -> anyhow::Result<()> {
        let flags = [
            (self.allow_outside, "--allow-outside"),
            (self.missing_normals.is_some(), "--missing-normals"),
            (self.transparency, "--transparency"),
        ];
        let flag = flags.into_iter().find_map(|(is_given, option)| is_given.then_some(option));
        match self.limits.given().or(flag) {
            Some(option) => bail!("{option}: only of scenes in files; leave the option out"),
            None => Ok(()),
        }
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        if self.up.is_some() && !self.has_extension(&["obj", "ply"]) {
            bail!("--up: only .obj and .ply files leave open which axis points up; leave the option out");
        }
        if self.default_material.is_some() && !self.is_gltf() {
            bail!(
                "--default-material: only of glTF files, which say what a mesh without a material is; leave the option out"
            );
        }
        Ok(())
    }

    /// The options of reading a file.
    pub(crate) fn checked_options(&self, memory: &MemoryLimit) -> anyhow::Result<SceneReadOptions> {
        self.check_options()?;
        let mut options = self.limits.options(memory);
        options.up = if matches!(self.up, Some(UpAxis::Z)) { Up::Z } else { Up::Y };
        options.allow_outside = self.allow_outside;
        options.missing_normals = match self.missing_normals {
            None => MissingNormals::AsFormat,
            Some(NormalsName::Flat) => MissingNormals::Flat,
            Some(NormalsName::Smooth) => MissingNormals::Smooth,
        };
        if matches!(self.default_material, Some(MaterialName::Gltf)) {
            options.default_material = DefaultMaterial::AsFormat;
        }
        Ok(options.straight_through(self.transparency).pose(self.pose.pose()))
    }

    /// Refuses times of scenes that stand still.
    pub(crate) fn expect_no_time_unless_gltf(&self) -> anyhow::Result<()> {
        match self.pose.asked().filter(|_| !self.is_gltf()) {
            Some(option) => bail!("{option}: only what a glTF file moves stands elsewhere then; leave the option out"),
            None => Ok(()),
        }
    }

    pub(crate) fn has_extension(&self, extensions: &[&str]) -> bool {
        let found = self.path.extension().unwrap_or_default();
        extensions.iter().any(|extension| found.eq_ignore_ascii_case(extension))
    }
}

/// Notes the findings of reading a file.
pub(crate) fn tell(report: &SceneReadReport, name: &str, talk: Talk) {
    let assumed = report.assumed_pose();
    for text in report.remarks() {
        if assumed.as_ref() == Some(&text) {
            talk.note(name, &format!("{text}; --time and --animation choose another"));
        } else {
            talk.note(name, &text);
        }
    }
}
