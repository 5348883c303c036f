//! A file of an export, before it is written.

use lobe_image::PictureWriteReport;

/// A file of an export.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ExportedFile {
    /// Its name in the folder of the engine.
    pub name: String,
    /// What it is.
    pub what: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Texels that its format clamps, and the share of the light that is lost so.
    pub report: PictureWriteReport,
}

impl ExportedFile {
    pub(crate) fn new(name: &str, what: &str, (bytes, report): (Vec<u8>, PictureWriteReport)) -> Self {
        Self { name: name.to_owned(), what: what.to_owned(), bytes, report }
    }

    pub(crate) fn text(name: &str, what: &str, text: String) -> Self {
        Self::new(name, what, (text.into_bytes(), PictureWriteReport::default()))
    }
}
