//! `suns [PROGRAM] [--scene SCENE]... [--surfaces MODEL] MAP..`: pictures under photographed skies, with suns in the
//! expansion and apart, against path traced ones of the same surfaces.
//!
//! Each scene is lit by each map at order 4 with `--suns none`, at order 4 and at order 6 with suns apart. The error
//! is that over surfaces, the noise of two halves of the reference subtracted. It prints a table; what is baked or
//! traced is kept in target/suns.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::outcome::{self, Outcome};
use crate::workspace;

/// Columns and rows of the pictures.
const SIZE: &str = "320x240";

/// Paths of each half of the reference.
const PATHS: &str = "128";

/// Paths from each vertex: noise of transfer is less than what the order leaves out.
const SAMPLES: &str = "512";

/// Scenes without an option: two that stand still and two that move.
const SCENES: [&str; 4] =
    ["built-in:still-life", "built-in:columns", "built-in:three-objects", "built-in:walking-figure"];

/// Columns of the table: order, suns.
const COLUMNS: [[&str; 2]; 3] = [["4", "none"], ["4", "auto"], ["6", "auto"]];

/// Of what moves direct light alone: light that is reflected between parts is not in those pictures.
const DIRECT: [&str; 2] = ["--bounces", "0"];

/// The command, its scenes and maps.
struct Bench {
    program: PathBuf,
    folder: PathBuf,
    surfaces: String,
    maps: Vec<PathBuf>,
}

pub(crate) fn run(arguments: &[String]) -> Outcome {
    let root = workspace::root();
    let (mut scenes, mut paths, mut words) = (Vec::new(), Vec::new(), arguments.iter());
    let mut surfaces = "matte".to_owned();
    while let Some(word) = words.next() {
        match &**word {
            "--scene" => scenes.extend(words.next().map(|scene| absolute(scene))),
            "--surfaces" => words.next().into_iter().for_each(|word| surfaces.clone_from(word)),
            path => paths.push(PathBuf::from(absolute(path))),
        }
    }
    let is_map = |path: &PathBuf| path.extension().is_some();
    let (maps, programs): (Vec<PathBuf>, Vec<PathBuf>) = paths.into_iter().partition(is_map);
    if maps.is_empty() {
        return outcome::of(vec![
            "expected maps: suns [PROGRAM] [--scene SCENE].. [--surfaces MODEL] MAP..".to_owned(),
        ]);
    }
    let program = programs.into_iter().next().unwrap_or_else(|| root.join("target/release/lobe"));
    let bench = Bench { program, folder: root.join("target/suns"), surfaces, maps };
    let scenes = if scenes.is_empty() { SCENES.map(str::to_owned).to_vec() } else { scenes };
    outcome::of(bench.table(&scenes).err().into_iter().collect())
}

impl Bench {
    fn table(&self, scenes: &[String]) -> Result<(), String> {
        std::fs::create_dir_all(&self.folder).map_err(|error| format!("{}: {error}", self.folder.display()))?;
        let of = |[order, suns]: &[&str; 2]| format!(" order {order}, suns {suns} |");
        println!("| scene | sky |{}", COLUMNS.iter().map(of).collect::<String>());
        println!("|---|---|{}", "---|".repeat(COLUMNS.len()));
        for scene in scenes {
            for map in &self.maps {
                let row = self.row(scene, map)?;
                println!("| {} | {} |{row}", name(scene), stem(map));
            }
        }
        Ok(())
    }

    /// The errors of a scene under a map.
    fn row(&self, scene: &str, map: &Path) -> Result<String, String> {
        let (light, surfaces) = (map.display().to_string(), &*self.surfaces);
        let [a, b] = [1, 2].map(|seed| self.half(scene, &light, stem(map), seed));
        let (a, b) = (a?, b?);
        let mut row = String::new();
        for [order, suns] in COLUMNS {
            let picture = format!("{}-{}-{order}-{suns}-{surfaces}.exr", name(scene), stem(map));
            let lit = ["--env", &light, "--order", order, "--suns", suns, "--size", SIZE, "--surfaces", surfaces];
            let lit = [&lit[..], &["-o", &picture]].concat();
            if moves(scene) {
                self.lobe(&[&["render", "moving", scene], &lit[..], &DIRECT].concat())?;
            } else {
                let baked = self.baked(scene)?;
                self.lobe(&[&["render", "baked", &baked], &lit[..]].concat())?;
            }
            let compared = self.lobe(&["compare", &picture, &a, "--half", &b, "--json"])?;
            let found: Value = serde_json::from_str(&compared).map_err(|error| format!("{picture}: {error}"))?;
            let error = found["surfaces"]["relative_rms"].as_f64().unwrap_or(f64::NAN);
            row += &format!(" {:.1} % |", 100.0 * error);
        }
        Ok(row)
    }

    /// The scene with both parts of its transfer at the highest order of the table, baked once.
    fn baked(&self, scene: &str) -> Result<String, String> {
        let file = format!("{}.glb", name(scene));
        if !self.folder.join(&file).exists() {
            let bake = ["bake", scene, "--order", COLUMNS[2][0], "--samples", SAMPLES, "-o", &file];
            self.lobe(&[&bake[..], &["--parts", "direct,reflected"]].concat())?;
        }
        Ok(file)
    }

    /// Half of the reference, traced once.
    fn half(&self, scene: &str, light: &str, sky: &str, seed: u32) -> Result<String, String> {
        let (file, seed) = (format!("{}-{sky}-{}-{seed}.exr", name(scene), self.surfaces), seed.to_string());
        if !self.folder.join(&file).exists() {
            let trace = ["render", "trace", scene, "--env", light, "--size", SIZE, "--samples", PATHS];
            let trace = [&trace[..], &["--surfaces", &self.surfaces]].concat();
            let bounces = if moves(scene) { &DIRECT[..] } else { &[] };
            self.lobe(&[&trace[..], &["--seed", &seed, "-o", &file], bounces].concat())?;
        }
        Ok(file)
    }

    /// Runs the command; what it prints.
    fn lobe(&self, words: &[&str]) -> Result<String, String> {
        let run = Command::new(&self.program).arg("--quiet").args(words).current_dir(&self.folder).output();
        let output = run.map_err(|error| format!("{} did not start: {error}", self.program.display()))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        Err(format!("lobe {} failed ({}): {}", words.join(" "), output.status, said.trim()))
    }
}

/// A path as other folders have it: the command works in another one. Scenes of the program have none.
fn absolute(path: &str) -> String {
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| PathBuf::from(path));
    if path.starts_with("built-in:") { path.to_owned() } else { absolute().display().to_string() }
}

/// Whether `lobe render moving` shows a scene.
fn moves(scene: &str) -> bool {
    ["three-objects", "walking-figure"].iter().any(|name| scene.ends_with(name))
}

/// A scene in names of files.
fn name(scene: &str) -> &str {
    let scene = scene.strip_prefix("built-in:").unwrap_or(scene);
    stem(Path::new(scene))
}

fn stem(path: &Path) -> &str {
    path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default()
}
