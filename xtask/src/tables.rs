//! `tables`: the generated code, by `lobe-tables`, which links `lobe-sh` and is compiled when it is asked for.

use std::process::Command;

use crate::outcome::Outcome;
use crate::workspace;

/// Writes the generated code, or with `--check` only compares.
pub(crate) fn run(arguments: &[String]) -> Outcome {
    let mut command = Command::new(workspace::cargo());
    command.args(["run", "--quiet", "--package", "lobe-tables", "--"]).args(arguments);
    workspace::expect(&mut command, "lobe-tables")
}
