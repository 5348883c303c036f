//! `corpus PROGRAM [--small] [FOLDER ..]`: the command on public models and maps.
//!
//! Packages are fetched by name into a cache outside the repository. Each model is baked, rendered as baked and path
//! traced, and what was baked is validated; each map is described, projected and filtered. All that within limits of time
//! and memory. A line on stderr with exit code 2 is a refusal and listed; any other end than success is a fault.
//!
//! This file goes through the files; `fetch` gets them, `step` runs the command on one. Uses no other room.

mod fetch;
mod step;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::outcome::Outcome;
use crate::workspace;
use fetch::{files, packages};
pub(crate) use fetch::{has_small_part, package_folder};
use step::{End, run as run_step};

const MODELS: &[&str] = &["glb", "gltf", "vrm", "obj", "ply"];
const MAPS: &[&str] = &["hdr", "exr", "ktx2", "dds", "pfm"];

/// The validator of glTF files, where npm has put it.
struct Validator(PathBuf);

/// Runs the command on all files, prints a table, and returns what failed.
pub(crate) fn run(arguments: &[String]) -> Outcome {
    let is_small = arguments.iter().any(|argument| argument == "--small");
    let mut paths = arguments.iter().filter(|argument| *argument != "--small").map(PathBuf::from);
    let program = paths
        .next()
        .map_or_else(workspace::command_of_tests, Ok)
        .and_then(|p| p.canonicalize().map_err(|e| format!("{}: {e}", p.display())));
    let program = program.map_err(|fault| vec![fault])?;
    let mut inputs = Vec::new();
    for package in packages().filter(|package| package.small > 0 || !is_small) {
        package.fetch().map_err(|fault| vec![fault])?;
        for kinds in [MODELS, MAPS] {
            let found = files(&package.folder(), kinds);
            inputs.extend(found.into_iter().take(if is_small { package.small } else { usize::MAX }));
        }
    }
    for folder in paths {
        inputs.extend([MODELS, MAPS].iter().flat_map(|kinds| files(&folder, kinds)));
    }
    let validator = packages().find(|package| package.name == "gltf-validator").map(|p| p.folder().join("package"));
    let validator =
        validator.filter(|folder| folder.exists() && Command::new("node").arg("--version").output().is_ok());
    if validator.is_none() {
        println!("SKIPPED validation: node is not installed");
    }
    let folder = std::env::temp_dir().join(format!("lobe-corpus-{}", std::process::id()));
    fs::create_dir_all(&folder).map_err(|error| vec![format!("{}: {error}", folder.display())])?;
    let faults = table(&program, &inputs, validator.map(Validator).as_ref(), &folder);
    // Remove the files; a failure to do so is no fault of the program.
    let _ = fs::remove_dir_all(&folder);
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Prints a line for each file, and returns the faults.
fn table(program: &Path, inputs: &[PathBuf], validator: Option<&Validator>, folder: &Path) -> Vec<String> {
    let mut faults = Vec::new();
    let mut refusals: BTreeMap<String, usize> = BTreeMap::new();
    println!("{:<60} {:>8}  result", "file", "seconds");
    for input in inputs {
        let (end, seconds) = all_steps(program, input, validator, folder);
        let name = input.strip_prefix(fetch::cache()).unwrap_or(input).display().to_string();
        let result = match &end {
            End::Done => "passed".into(),
            End::Refused(line) => {
                // Without the name of the file, so that alike refusals are counted together.
                let reason = line.replace(&*input.to_string_lossy(), "FILE");
                *refusals.entry(reason.clone()).or_default() += 1;
                format!("refused: {reason}")
            }
            End::Failed(how) => {
                faults.push(format!("{name}: {how}"));
                format!("FAILED: {how}")
            }
        };
        println!("{name:<60} {seconds:8.2}  {}", result.lines().next().unwrap_or_default());
    }
    let refused: usize = refusals.values().sum();
    let passed = inputs.len() - refused - faults.len();
    if passed == 0 {
        faults.push("no file of the corpus passed".into());
    }
    println!("\n{} files: {passed} passed, {refused} refused, {} failed", inputs.len(), faults.len());
    for (reason, count) in refusals {
        println!("{count:6} × {reason}");
    }
    faults
}

/// All that is done with a file, up to the first thing that is not; and the seconds it took.
fn all_steps(program: &Path, input: &Path, validator: Option<&Validator>, folder: &Path) -> (End, f64) {
    let input_name = input.to_string_lossy();
    let is_model = MODELS.iter().any(|known| input.extension().is_some_and(|e| e.eq_ignore_ascii_case(known)));
    let small_bake = ["--order", "3", "--samples", "4", "--bounces", "1", "--max-memory", "2"];
    let small_picture = ["--size", "32x24", "--samples", "2", "-o", "picture.exr"];
    let bake = |output: &[&'static str]| -> Vec<&str> {
        let words = ["--quiet", "bake", &input_name, "-o"].into_iter().chain(output.iter().copied());
        words.chain(small_bake).collect()
    };
    let render = |scene, method| -> Vec<&str> {
        let words = ["--quiet", "render", method, scene, "--env", "bundled:studio"];
        words.into_iter().chain(small_picture).collect()
    };
    let commands: Vec<Vec<&str>> = if is_model {
        // What moves is posed between two keys, by its skin if it has one.
        let mut posed = render(&*input_name, "trace");
        posed.extend(["--time", "0.37"]);
        let mapped = [bake(&["mapped.glb", "--texels", "256"]), render("mapped.glb", "baked")];
        // An error that few models need many rounds for.
        let split = bake(&["baked.glb", "--adaptive", "0.1"]);
        [split, render("baked.glb", "baked"), posed].into_iter().chain(mapped).collect()
    } else {
        vec![
            vec!["--quiet", "env", "info", &input_name],
            vec!["--quiet", "project", &input_name, "--order", "4", "-o", "map.sh.json"],
            vec!["--quiet", "env", "prefilter", &input_name, "--size", "16", "-o", "map.ktx2"],
        ]
    };
    let mut seconds = 0.0;
    for command in commands {
        let (end, time) = run_step(program, &command, folder);
        seconds += time.as_secs_f64();
        if end != End::Done {
            return (end, seconds);
        }
    }
    let judged = validator
        .filter(|_| is_model)
        .into_iter()
        .flat_map(|validator| ["baked.glb", "mapped.glb"].map(|file| validator.judge(input, &folder.join(file))));
    (judged.into_iter().find(|end| *end != End::Done).unwrap_or(End::Done), seconds)
}

impl Validator {
    /// The errors of a file that was baked, beyond those of the model.
    fn judge(&self, model: &Path, file: &Path) -> End {
        let output = Command::new("node")
            .args(["-e", include_str!("validate.cjs"), "--", "validate.cjs"])
            .args([&self.0, model, file])
            .output();
        match output {
            Ok(output) if output.status.success() && output.stdout.is_empty() => End::Done,
            Ok(output) if output.status.success() => End::Failed(String::from_utf8_lossy(&output.stdout).trim().into()),
            Ok(output) => {
                End::Failed(format!("the validator failed: {}", String::from_utf8_lossy(&output.stderr).trim()))
            }
            Err(error) => End::Failed(format!("node did not start: {error}")),
        }
    }
}
