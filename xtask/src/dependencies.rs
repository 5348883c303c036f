//! `dependencies`: the crates that `lobe-sh` brings along by default, which are none.

use std::process::Command;

use crate::outcome::{Outcome, of};
use crate::workspace;

/// What a program that asks for `lobe-sh` alone compiles beside it.
pub(crate) fn check() -> Outcome {
    let output = Command::new(workspace::cargo())
        .args(["tree", "--package", "lobe-sh", "--edges", "normal", "--prefix", "none"])
        .current_dir(workspace::root())
        .output()
        .map_err(|error| vec![format!("cargo tree did not start: {error}")])?;
    let tree = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() || !tree.starts_with("lobe-sh ") {
        return Err(vec![format!("cargo tree failed: {}", String::from_utf8_lossy(&output.stderr).trim())]);
    }
    of(others(&tree).map(|line| format!("lobe-sh depends on {line} by default: give it a feature")).collect())
}

/// The lines below the first, the crate itself.
fn others(tree: &str) -> impl Iterator<Item = &str> {
    tree.lines().skip(1).map(str::trim).filter(|line| !line.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_crate_below_the_first_is_another() {
        assert_eq!(others("lobe-sh v0.1.0 (/w)\n").count(), 0, "alone");
        let found: Vec<&str> = others("lobe-sh v0.1.0 (/w)\nlibm v0.2.16\n\n").collect();
        assert_eq!(found, ["libm v0.2.16"], "with another");
    }
}
