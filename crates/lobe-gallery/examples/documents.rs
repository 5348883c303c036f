//! Draws the pictures of the documents anew, from the root of the repository: `cargo run -p lobe-gallery --example documents`

use lobe::image::Tone;
use lobe_gallery::{GalleryError, document_pictures};

fn main() -> Result<(), GalleryError> {
    for (path, picture) in document_pictures()? {
        picture.write_png(&path, &Tone::PLAIN)?;
        println!("{path}");
    }
    Ok(())
}
