//! Codecs of picture files.
//!
//! [`read`] detects the format from the first bytes, checks the caller's limits before memory is allocated, and calls
//! the reader of the format (`read_*`); [`decoded`] is shared by those; [`picture_rows`] decodes row by row what is too large for memory, of
//! whose file a [`lookahead`] holds what comes next; [`encode`] chooses the writer, [`frames`] writes several. Cube textures
//! (KTX2, DDS) hold the six faces of each level as pictures ([`texture`]), whose texels are stored in a
//! [`texel_format`].
//!
//! Read `read` first, then the reader of a format. Uses `picture`.

pub(crate) mod bc6h;
#[cfg(any(test, not(feature = "bc6h")))]
pub(crate) mod bc6h_encode;
pub(crate) mod dds;
pub(crate) mod decoded;
pub(crate) mod encode;
pub(crate) mod exr_layers;
pub(crate) mod frames;
pub(crate) mod jpeg_end;
pub(crate) mod lookahead;
pub(crate) mod packed_float;
pub(crate) mod picture_rows;
pub(crate) mod png_color;
pub(crate) mod read;
pub(crate) mod read_exr;
pub(crate) mod read_hdr;
pub(crate) mod read_ktx2;
pub(crate) mod read_ldr;
pub(crate) mod read_pfm;
pub(crate) mod rgb9e5;
pub(crate) mod rgbe;
pub(crate) mod texel_format;
pub(crate) mod texture;
pub(crate) mod write_exr;
pub(crate) mod write_ktx1;
pub(crate) mod write_ktx2;
