//! The figures of the chapter: a scene by an earlier program, by this one and by paths, beside each other.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::workspace;

/// The folder of the figures.
const FIGURES: &str = "docs/figures/bakes";

/// The quality at which a figure takes less than 150 kB.
const QUALITY: &str = "85";

/// Writes the figure of a row from the pictures of both programs and both halves of the reference. It needs `cjpeg` of
/// libjpeg-turbo.
pub(super) fn write(name: &str, [before, after]: [&Path; 2], halves: &[PathBuf; 2]) -> Result<(), String> {
    let folder = workspace::root().join(FIGURES);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let plain = before.with_extension("ppm");
    let mut example = Command::new(workspace::cargo());
    example.args(["run", "--quiet", "--package", "lobe-image", "--example", "beside_each_other", "--"]);
    example.args([before, after, &halves[0], &halves[1], &plain]);
    let mut encoder = Command::new("cjpeg");
    encoder.args(["-quality", QUALITY, "-optimize", "-outfile"]);
    encoder.arg(folder.join(format!("{name}.jpg"))).arg(&plain);
    for (mut command, what) in [(example, "beside_each_other"), (encoder, "cjpeg")] {
        workspace::expect(&mut command, what).map_err(|faults| faults.join("\n"))?;
    }
    Ok(())
}
