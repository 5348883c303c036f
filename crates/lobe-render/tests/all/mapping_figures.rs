//! The figures in the documents are those that the code draws.

use std::path::Path;

use lobe_env::Mapping;
use lobe_image::Tone;
use lobe_render::mapping_figure;

use crate::png::pixels_of;

#[test]
fn the_figures_in_the_documents_are_drawn_by_this_code() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/figures/mappings");
    for mapping in Mapping::ALL {
        let path = folder.join(format!("{mapping}.png"));
        let (kept_size, kept) = pixels_of(&path);
        let drawn = mapping_figure(mapping, if mapping.height_for(2) == 2 { 200 } else { 320 });
        let size = (drawn.width() as u32, drawn.height() as u32);
        assert_eq!(kept_size, size, "{mapping}: write the figures anew with the example mapping_figures");
        let bytes = Tone::PLAIN.to_bytes(&drawn);
        // The sine of another machine's library may put a sample on the other side of a line.
        let differing = kept.iter().zip(&bytes).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        assert!(differing * 500 < bytes.len(), "{mapping}: {differing} of {} bytes differ", bytes.len());
        let length = std::fs::metadata(&path).unwrap().len();
        assert!(length <= 40 * 1024, "{mapping}: {length} bytes");
    }
}
