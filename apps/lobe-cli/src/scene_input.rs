//! Scenes to work on.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::scene::{ReadOptions, ReadReport, Scene, Up, built_in, read_scene};

use crate::talk::Talk;

/// What stands before the name of a scene that is part of the program.
const BUILT_IN: &str = "built-in:";

/// Where a scene is.
#[derive(Args)]
pub(crate) struct SceneInput {
    /// The scene: a .glb, .gltf, .obj or .ply file, or built-in:NAME with ball, columns, cave, terrain, cornell or furnace
    #[arg(value_name = "SCENE")]
    path: PathBuf,
    /// Which axis points up in an .obj or .ply file [default: y]
    #[arg(long, value_enum)]
    up: Option<UpAxis>,
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

    /// The name without its folders, which says the same on every machine.
    pub(crate) fn file_name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The glTF file that the scene is read from, if it is one.
    pub(crate) fn gltf_file(&self) -> Option<&Path> {
        self.has_extension(&["glb", "gltf"]).then_some(self.path.as_path())
    }

    /// Reads or makes the scene, and tells what was found remarkable.
    pub(crate) fn read(&self, talk: Talk) -> anyhow::Result<Scene> {
        let name = self.name();
        if self.up.is_some() && !self.has_extension(&["obj", "ply"]) {
            bail!("--up: only .obj and .ply files leave open which axis points up; leave the option out");
        }
        if let Some(built_in_name) = name.strip_prefix(BUILT_IN) {
            let Some(scene) = built_in::named(built_in_name) else {
                let known = built_in::NAMES.map(|known| format!("{BUILT_IN}{known}")).join(", ");
                bail!("{name}: there is no such scene in the program; there are {known}");
            };
            return Ok(scene);
        }
        let up = if matches!(self.up, Some(UpAxis::Z)) { Up::Z } else { Up::Y };
        let (scene, report) = read_scene(&self.path, &ReadOptions { up, ..ReadOptions::default() })?;
        tell(&report, &name, talk);
        Ok(scene)
    }

    fn has_extension(&self, extensions: &[&str]) -> bool {
        let found = self.path.extension().unwrap_or_default();
        extensions.iter().any(|extension| found.eq_ignore_ascii_case(extension))
    }
}

/// Notes what was found remarkable in a file.
fn tell(report: &ReadReport, name: &str, talk: Talk) {
    for note in &report.notes {
        talk.note(name, note);
    }
    if report.dropped_triangles > 0 {
        let (count, kept) = (report.dropped_triangles, report.triangles);
        talk.note(name, &format!("triangles without area: {count}, dropped; {kept} are left"));
    }
    if report.made_normals > 0 {
        let (made, all) = (report.made_normals, report.vertices);
        talk.note(
            name,
            &format!("normals missing or zero: {made} of {all}, made from the triangles around each vertex"),
        );
    }
}
