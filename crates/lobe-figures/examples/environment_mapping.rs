//! Writes the contact sheet of environment mapping for both bundled maps into a folder.
//!
//! `cargo run --release -p lobe-render --example environment_mapping -- FOLDER`

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use lobe_figures::{EnvironmentSheetOptions, environment_mapping_sheet};
use lobe_image::Tone;
use lobe_io::Job;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: environment_mapping FOLDER")?);
    std::fs::create_dir_all(&folder)?;
    for bundled in lobe_env::bundled::all() {
        let (map, start) = (bundled.map(), Instant::now());
        let sheet = environment_mapping_sheet(&map, &EnvironmentSheetOptions::default(), Job::default())?;
        println!("{}: {:.2} s", bundled.name, start.elapsed().as_secs_f64());
        sheet.write_png(folder.join(format!("environment-mapping-{}.png", bundled.name)), &Tone::PLAIN)?;
    }
    Ok(())
}
