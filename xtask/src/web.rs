//! `web`: the viewer as a page for any static host, and a look at it in a browser.

use std::path::Path;
use std::process::Command;

use crate::outcome::Outcome;
use crate::{toolchain, workspace};

/// The page, in the folder of the repository.
const PAGE: &str = "target/web";

/// What the page is made of. Each has a target folder of its own, as the profiles and targets differ.
const STEPS: [&str; 3] = [
    "build --release --package lobe-viewer --target wasm32-unknown-unknown --target-dir target/web-build",
    "run --release --manifest-path apps/lobe-viewer/web/Cargo.toml --target-dir target/web-tool -- \
     target/web-build/wasm32-unknown-unknown/release/lobe-viewer.wasm target/web",
    // Of the bakes of the window, with as many paths as a few seconds allow.
    "run --release --package lobe-cli -- bake built-in:still-life --samples 1024 --bounces 3 -o target/web/still-life.glb",
];

/// Makes the page; with `--check` it is opened in headless Chromium, and pictures of its rooms are written beside it. What
/// is missing on this machine is named, and no fault.
pub(crate) fn run(arguments: &[String]) -> Outcome {
    if let Err(reason) = can_build() {
        println!("SKIPPED web: {reason}");
        return Ok(());
    }
    for step in STEPS {
        println!("==> cargo {step}");
        workspace::expect(Command::new(workspace::cargo()).args(step.split_whitespace()), step)?;
    }
    println!("{PAGE} is a page for any static host, such as: python3 -m http.server --directory {PAGE}");
    if !arguments.iter().any(|argument| argument == "--check") {
        return Ok(());
    }
    if let Err(reason) = can_look() {
        println!("SKIPPED web --check: {reason}");
        return Ok(());
    }
    let arguments = ["apps/lobe-viewer/web/check.mjs", PAGE, "target/web-pictures"];
    workspace::expect(Command::new("node").args(arguments), "check.mjs")
}

/// Whether the viewer can be compiled for browsers: Zstandard, which is C, by clang.
fn can_build() -> Result<(), String> {
    toolchain::has_target("wasm32-unknown-unknown")?;
    toolchain::has_program("clang", "apt-get install clang")
}

/// Whether a browser can be asked.
fn can_look() -> Result<(), String> {
    toolchain::has_program("node", "apt-get install nodejs npm")?;
    toolchain::has_program("npm", "apt-get install npm")?;
    let browsers = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
    let is_there = std::env::var_os("CHROMIUM").is_some() || browsers.iter().any(|path| Path::new(path).exists());
    is_there
        .then_some(())
        .ok_or_else(|| "there is no Chromium; apt-get install chromium, or name one in CHROMIUM".into())
}
