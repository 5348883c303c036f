//! The tools of this machine: targets and versions of Rust that are installed, and the maker of books.

use std::path::PathBuf;
use std::process::Command;

use crate::workspace;

/// Whether the libraries of a target are there.
///
/// # Errors
/// The reason why not.
pub(crate) fn has_target(target: &str) -> Result<(), String> {
    let folder = PathBuf::from(answer("rustc", &["--print", "sysroot"])?).join("lib/rustlib").join(target);
    let missing = || format!("this Rust has no target {target}; rustup target add {target}");
    folder.is_dir().then_some(()).ok_or_else(missing)
}

/// Whether there is the oldest Rust that the workspace supports beside the one that checks everything.
///
/// # Errors
/// The reason why not: it may be the same.
pub(crate) fn has_oldest_rust() -> Result<(), String> {
    let oldest = oldest_rust()?;
    let running = answer("rustc", &["--version"])?;
    if is_version(&running, &oldest) {
        return Err(format!("{running} is the oldest supported Rust: every other step checks it"));
    }
    let toolchain = format!("{oldest}.0");
    answer("rustup", &["run", &toolchain, "rustc", "--version"])
        .map(drop)
        .map_err(|_| format!("Rust {oldest} is not installed; rustup toolchain install {oldest}.0"))
}

/// Whether there is `mdbook`, which makes a book of the guide.
///
/// # Errors
/// The reason why not.
pub(crate) fn has_mdbook() -> Result<(), String> {
    answer("mdbook", &["--version"])
        .map(drop)
        .map_err(|_| "mdbook is not installed; cargo install --locked mdbook".to_string())
}

/// What the compiler says of itself.
///
/// # Errors
/// If there is none.
pub(crate) fn compiler() -> Result<String, String> {
    answer("rustc", &["--version"])
}

/// Whether there is a program that says its version.
///
/// # Errors
/// The reason why not, and how to get it.
pub(crate) fn has_program(program: &str, how_to_get_it: &str) -> Result<(), String> {
    // One dash is FFmpeg's.
    let version = answer(program, &["--version"]).or_else(|_| answer(program, &["-version"]));
    version.map(drop).map_err(|_| format!("{program} is not installed; {how_to_get_it}"))
}

/// Whether Python has a module.
///
/// # Errors
/// The reason why not.
pub(crate) fn has_module(module: &str) -> Result<(), String> {
    answer("python3", &["-c", &format!("import {module}")])
        .map(drop)
        .map_err(|_| format!("python3 has no {module}; pip install {module}"))
}

/// `rust-version` of the workspace, as `1.95`.
fn oldest_rust() -> Result<String, String> {
    let manifest = workspace::read(&workspace::root().join("Cargo.toml"))?;
    let line = manifest.lines().find_map(|line| line.strip_prefix("rust-version = "));
    line.map(|version| version.trim_matches('"').to_string()).ok_or("Cargo.toml names no rust-version".into())
}

/// Whether what `rustc --version` prints is a version `1.95.x`.
fn is_version(printed: &str, version: &str) -> bool {
    printed.split_whitespace().nth(1).is_some_and(|found| found.starts_with(&format!("{version}.")))
}

/// The output of a program, without the end of the line.
fn answer(program: &str, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(workspace::root())
        .output()
        .map_err(|error| format!("{program} did not start: {error}"))?;
    if !output.status.success() {
        return Err(format!("{program} {} failed ({})", arguments.join(" "), output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_is_told_from_those_that_begin_alike() {
        assert!(is_version("rustc 1.95.0 (f2d3ce0bd 2026-03-21)", "1.95"), "1.95.0");
        assert!(!is_version("rustc 1.9.5 (abc 2016-01-01)", "1.95"), "1.9.5");
        assert!(!is_version("rustc 1.96.0-nightly (abc)", "1.95"), "1.96");
    }

    #[test]
    fn the_step_asks_for_the_version_that_the_workspace_names() {
        let oldest = oldest_rust().unwrap();
        assert!(include_str!("ci.rs").contains(&format!("\"run {oldest}.0 cargo check")), "{oldest} in ci.rs");
    }
}
