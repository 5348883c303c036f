//! Writes the figures of docs/guide/src/mappings.md: the square ones 200 pixels wide, the others 320.
//!
//! `cargo run -p lobe-render --example mapping_figures -- docs/figures/mappings`

use std::error::Error;
use std::path::PathBuf;

use lobe_env::Mapping;
use lobe_image::Tone;
use lobe_render::mapping_figure;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: mapping_figures FOLDER")?);
    std::fs::create_dir_all(&folder)?;
    for mapping in Mapping::ALL {
        let width = if mapping.height_for(2) == 2 { 200 } else { 320 };
        mapping_figure(mapping, width).write_png(folder.join(format!("{mapping}.png")), &Tone::PLAIN)?;
    }
    Ok(())
}
