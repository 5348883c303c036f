//! One row measured: a bake by default, a picture of it, and its error against paths.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::bakes::rows::Row;

/// Columns and rows of the pictures.
const SIZE: &str = "480x360";

/// Rays through each pixel of a picture of what was baked.
const RAYS: &str = "64";

/// The light of all pictures: an expansion of the order of the bake, so that order is no excuse.
const LIGHT: &str = "light.sh.json";
const LIGHT_OF: &str = "project bundled:sunset --order 4 -o light.sh.json";

/// What was found of a scene.
pub(super) struct Found {
    pub(super) vertices: u64,
    /// Of processors, which do not depend on what else a machine does.
    pub(super) seconds: f64,
    /// The errors over surfaces, as `lobe compare --half` prints them.
    surfaces: Value,
}

impl Found {
    /// A number of the comparison; NaN for what is infinite.
    pub(super) fn number(&self, name: &str) -> f64 {
        self.surfaces[name].as_f64().unwrap_or(f64::NAN)
    }
}

/// The command, and the folder that it works in.
pub(super) struct Bench<'a> {
    pub(super) program: &'a Path,
    pub(super) folder: &'a Path,
}

impl Bench<'_> {
    /// Writes the light that all rows have.
    pub(super) fn prepare(&self) -> Result<(), String> {
        let words: Vec<String> = LIGHT_OF.split(' ').map(Into::into).collect();
        self.run(&words).map(drop)
    }

    /// Bakes by default, shows what was baked, and compares it with both halves of the reference.
    pub(super) fn row(&self, row: &Row, judge: &Self) -> Result<Found, String> {
        let scene = row.scene(self.folder)?;
        let scene = scene.to_string_lossy();
        let halves = judge.halves(row)?;
        let (baked, picture) = (format!("baked-{}.glb", row.file_name()), self.picture(row));
        let start = seconds_of_children();
        let report = self.run(&words(&["bake", &scene, "-o", &baked, "--json", "--fresh"], ""))?;
        let seconds = seconds_of_children() - start;
        let show = ["render", &baked, "--mode", "interreflected", "--env", LIGHT, "--size", SIZE, "--samples", RAYS];
        let show = words(&show, row.view);
        let picture = picture.to_string_lossy();
        self.run(&[show, words(&["-o", &picture], "")].concat())?;
        let [a, b] = halves.map(|path| path.to_string_lossy().into_owned());
        let compared = judge.run(&words(&["compare", &picture, &a, "--half", &b, "--json"], ""))?;
        let vertices = json(&report)?["vertices"].as_u64().unwrap_or(0);
        Ok(Found { vertices, seconds, surfaces: json(&compared)?["surfaces"].take() })
    }

    /// The picture of what was baked last of a row.
    pub(super) fn picture(&self, row: &Row) -> PathBuf {
        self.folder.join(format!("baked-{}.exr", row.file_name()))
    }

    /// Both halves of the reference.
    pub(super) fn halves(&self, row: &Row) -> Result<[PathBuf; 2], String> {
        let scene = row.scene(self.folder)?;
        let scene = scene.to_string_lossy();
        Ok([self.half(row, &scene, 1)?, self.half(row, &scene, 2)?])
    }

    /// Half of the reference, which is kept: it depends on the scene and the view, and not on any bake.
    fn half(&self, row: &Row, scene: &str, seed: u32) -> Result<PathBuf, String> {
        let mut hasher = DefaultHasher::new();
        (std::fs::read(scene).unwrap_or_default(), row.view, row.paths, SIZE, LIGHT_OF).hash(&mut hasher);
        let path = self.folder.join(format!("paths-{}-{:016x}-{seed}.exr", row.file_name(), hasher.finish()));
        if !path.exists() {
            let (paths, seed, out) = (row.paths.to_string(), seed.to_string(), path.to_string_lossy().into_owned());
            let trace = ["render", "trace", scene, "--env", LIGHT, "--size", SIZE];
            let rest = ["--samples", &paths, "--seed", &seed, "-o", &out];
            self.run(&[words(&trace, row.view), words(&rest, "")].concat())?;
        }
        Ok(path)
    }

    /// Runs the command; what it prints.
    fn run(&self, arguments: &[String]) -> Result<String, String> {
        let output = Command::new(self.program)
            .arg("--quiet")
            .args(arguments)
            .current_dir(self.folder)
            .output()
            .map_err(|error| format!("{} did not start: {error}", self.program.display()))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        Err(format!("lobe {} failed ({}): {}", arguments.join(" "), output.status, said.trim()))
    }
}

/// The seconds of processors that all children have taken so far; NaN where the system does not say.
fn seconds_of_children() -> f64 {
    /// Clock ticks of Linux in a second.
    const TICKS: f64 = 100.0;
    /// The places of user and system time of children that were waited for, counted after the name.
    const PLACES: [usize; 2] = [13, 14];
    let found = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let numbers: Vec<&str> = found.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |place: usize| numbers.get(place)?.parse::<f64>().ok();
    PLACES.iter().map(|&place| ticks(place).unwrap_or(f64::NAN)).sum::<f64>() / TICKS
}

/// Words of a command line, with those of a text at the end.
fn words(first: &[&str], rest: &str) -> Vec<String> {
    first.iter().copied().chain(rest.split_whitespace()).map(Into::into).collect()
}

fn json(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| format!("expected JSON, found {text:?}: {error}"))
}
