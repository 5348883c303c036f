//! The text beside the files of an engine: what each is, and for which frame, units and version.

use crate::engines::engine::{Engine, EngineFacts};
use crate::engines::exported_file::ExportedFile;

/// The text for these files.
pub(crate) fn text(engine: Engine, name: &str, files: &[ExportedFile], suns: usize) -> String {
    let EngineFacts { title, frame, units, panorama_turn, chain, .. } = engine.facts();
    let mut text = format!("# The light of {name} for {title}\n\n");
    text += &format!("Written by lobe {}; {}.\n\n", env!("CARGO_PKG_VERSION"), engine.tried());
    text += "| file | what it is |\n|---|---|\n";
    let program = files.last().map_or("the program", |file| &file.name);
    for ExportedFile { name, what, .. } in files {
        text += &format!("| {name} | {what} |\n");
    }
    text += &format!("\nThe first lines of {program} say how it is used. Its numbers are those of the other files.\n");
    text += &format!("\n- Frame: {}.\n- Units: {units}.\n", frame.description());
    if panorama_turn != 0 {
        text += "- Panoramas are turned by a quarter, as this engine reads them; do not put the map itself in their place.\n";
    }
    if let Some((roughness, _)) = chain {
        text += &format!("- The levels of the chain hold the roughness that this engine reads there: {roughness}.\n");
    }
    text += &match suns {
        0 => "- No sun stands apart: pictures and numbers hold all light.\n".to_owned(),
        _ => format!(
            "- Suns apart: {suns}. They are lights in the program; what lights the scene beside them is without them.\n"
        ),
    };
    text
}
