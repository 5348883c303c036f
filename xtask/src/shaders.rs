//! `shaders`: the files of `lobe-shaders`, by its test, which has naga.

use std::process::Command;

use crate::outcome::Outcome;
use crate::workspace;

/// The variable under which the test writes files; see `lobe-shaders/src/generate`.
const WRITE: &str = "LOBE_WRITE_SHADERS";

/// Writes the files, or with `--check` only compares, as the tests of the workspace do.
pub(crate) fn run(arguments: &[String]) -> Outcome {
    let mut command = Command::new(workspace::cargo());
    command.args(["test", "--quiet", "--package", "lobe-shaders", "--lib", "generate"]);
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => command.env(WRITE, "1"),
        ["--check"] => command.env_remove(WRITE),
        _ => return Err(vec![format!("expected --check or nothing, found {}", arguments.join(" "))]),
    };
    workspace::expect(&mut command, "lobe-shaders")
}
