//! The workspace: its root, its packages, its files.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::outcome::Outcome;

/// A package of the workspace and what it depends on.
pub(crate) struct Package {
    pub(crate) name: String,
    /// The folder of its Cargo.toml.
    pub(crate) folder: PathBuf,
    /// Names of everything it is built with, members of the workspace or not.
    pub(crate) uses: Vec<String>,
    /// Names of what only its tests, examples and benches use.
    pub(crate) tests_with: Vec<String>,
}

/// The folder of the workspace.
pub(crate) fn root() -> &'static Path {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask)
}

/// The cargo that started this program, or the one on the path.
pub(crate) fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Runs this in the folder of the workspace; a fault where it does not start or fails.
pub(crate) fn expect(command: &mut Command, what: &str) -> Outcome {
    let status = command.current_dir(root()).status();
    let status = status.map_err(|error| vec![format!("{what} did not start: {error}")])?;
    if status.success() { Ok(()) } else { Err(vec![format!("`{what}` failed ({status})")]) }
}

/// The packages of the workspace, from `cargo metadata`.
pub(crate) fn packages() -> Result<Vec<Package>, String> {
    let output = Command::new(cargo())
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(root())
        .output()
        .map_err(|error| format!("cargo metadata did not start: {error}"))?;
    if !output.status.success() {
        return Err(format!("cargo metadata failed: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let metadata: Value =
        serde_json::from_slice(&output.stdout).map_err(|error| format!("cargo metadata is not JSON: {error}"))?;
    let Some(packages) = metadata["packages"].as_array() else {
        return Err("cargo metadata lists no packages".into());
    };
    Ok(packages.iter().map(package).collect())
}

fn package(metadata: &Value) -> Package {
    let of_kind = |wanted: fn(Option<&str>) -> bool| {
        let dependencies = metadata["dependencies"].as_array().into_iter().flatten();
        let mut names: Vec<String> = dependencies
            .filter(|d| wanted(d["kind"].as_str()))
            .filter_map(|d| d["name"].as_str())
            .map(Into::into)
            .collect();
        names.sort();
        names.dedup();
        names
    };
    Package {
        name: metadata["name"].as_str().unwrap_or_default().into(),
        folder: Path::new(metadata["manifest_path"].as_str().unwrap_or_default()).with_file_name(""),
        uses: of_kind(|kind| kind != Some("dev")),
        tests_with: of_kind(|kind| kind == Some("dev")),
    }
}

/// Every file of the workspace with this extension, in path order; build output and hidden folders left out.
pub(crate) fn files(extension: &str) -> Result<Vec<PathBuf>, String> {
    fn walk(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() && name != "target" && !name.starts_with('.') {
                walk(&path, extension, found)?;
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    walk(root(), extension, &mut found).map_err(|error| format!("cannot list the files: {error}"))?;
    found.sort();
    Ok(found)
}

/// The text of a file, named relative to the root in the error.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: cannot be read: {error}", relative(path)))
}

/// The path as people write it: from the root of the workspace.
pub(crate) fn relative(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// The command `lobe` as the tests of the workspace have it.
///
/// # Errors
/// If cargo fails.
pub(crate) fn command_of_tests() -> Result<PathBuf, String> {
    program_of_tests("cli", "lobe")
}

/// A program that a test starts, as the tests of the workspace have it: with other features most of the workspace would be compiled anew.
///
/// # Errors
/// If cargo fails.
pub(crate) fn program_of_tests(test: &str, program: &str) -> Result<PathBuf, String> {
    let build = format!("test --workspace --no-run --test {test}");
    let status = Command::new(cargo()).args(build.split(' ')).current_dir(root()).status();
    let status = status.map_err(|error| format!("cargo did not start: {error}"))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    if status.success() { Ok(target.join("debug").join(program)) } else { Err(format!("`cargo {build}` failed")) }
}
