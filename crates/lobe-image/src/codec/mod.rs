//! Codecs of picture files.
//!
//! [`read`] detects the format from the first bytes, checks the caller's limits before memory is allocated, and calls
//! the reader of the format (`read_*`; of OpenEXR, block by block: [`exr_block`]); [`decoded`] is shared by those; [`picture_rows`] decodes row by row what is too large for memory, of
//! whose file a [`lookahead`] holds what comes next; [`encode`] chooses the writer, [`frames`] writes several.
//!
//! Read `read` first, then the reader of a format. Uses `picture`.

pub(crate) mod decoded;
pub(crate) mod encode;
pub(crate) mod exr_block;
pub(crate) mod exr_layers;
pub(crate) mod frames;
pub(crate) mod gain_map;
pub(crate) mod hdr_header;
pub(crate) mod icc;
pub(crate) mod jpeg_end;
pub(crate) mod lookahead;
pub(crate) mod orientation;
pub(crate) mod picture_rows;
pub(crate) mod png_color;
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
pub(crate) mod xmp;
