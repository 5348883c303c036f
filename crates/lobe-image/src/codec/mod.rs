//! Codecs of picture files.
//!
//! [`file_format`] is the table of formats. [`read`] detects the format from the first bytes, checks the caller's limits before memory is allocated, and calls
//! the reader of the format (`read_*`; of OpenEXR, block by block: [`exr_block`]). [`gain_map`] is the light above white of a JPEG.
//! [`picture_rows`] decodes row by row what is too large for memory; a [`lookahead`] holds what comes next in its file. [`encode`] chooses the
//! writer, [`frames`] writes several.
//!
//! Read `file_format` and `read` first, then the reader of a format. Uses `header` and `picture`.

pub(crate) mod encode;
pub(crate) mod exr_block;
pub(crate) mod exr_layers;
pub(crate) mod file_format;
pub(crate) mod frames;
pub(crate) mod gain_map;
pub(crate) mod jpeg_end;
pub(crate) mod lookahead;
pub(crate) mod picture_rows;
pub(crate) mod read;
pub(crate) mod read_exr;
pub(crate) mod read_hdr;
pub(crate) mod read_jpeg;
#[cfg(feature = "jxl")]
pub(crate) mod read_jxl;
pub(crate) mod read_ldr;
pub(crate) mod read_pfm;
pub(crate) mod read_tiff;
pub(crate) mod rgbe;
pub(crate) mod write_exr;
