//! The pictures of the documents that are drawn here.

use lobe::env::{Mapping, bundled};
use lobe::figures::mapping_figure;
use lobe::image::Picture;

use crate::error::GalleryError;
use crate::page::{Size, Sky};
use crate::photographs::irradiance::Balls;
use crate::photographs::overview::overview;

/// The widths of the figures of mappings: of square ones, and of others.
const MAPPING_WIDTHS: [usize; 2] = [200, 320];

/// The pictures of the documents that are drawn here, by their paths from the root of the repository: what a photograph, its
/// expansions and the balls that it lights look like, and where the axes lie in each mapping.
///
/// They have all their colors, which [`Tone::PLAIN`](lobe::image::Tone::PLAIN) leaves as they are.
///
/// # Errors
/// If a picture is too large for the memory of the machine.
pub fn document_pictures() -> Result<Vec<(String, Picture)>, GalleryError> {
    let sky = Sky::new(bundled::sunset());
    let size = Size::FULL;
    let mut pictures = vec![("docs/demo.png".to_owned(), overview(&sky, size, &Balls::new(&sky, size)?.shown()))];
    let [square, wide] = MAPPING_WIDTHS;
    pictures.extend(Mapping::ALL.map(|mapping| {
        let width = if mapping.height_for(2) == 2 { square } else { wide };
        (format!("docs/figures/mappings/{mapping}.png"), mapping_figure(mapping, width))
    }));
    Ok(pictures)
}
