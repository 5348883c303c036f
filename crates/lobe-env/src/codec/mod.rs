//! TODO room codec.

pub(crate) mod bc6h;
pub(crate) mod dds;
pub(crate) mod jpeg_end;
pub(crate) mod raster;
pub(crate) mod read_dds;
pub(crate) mod read_exr;
pub(crate) mod read_hdr;
pub(crate) mod read_ktx2;
pub(crate) mod read_ldr;
pub(crate) mod read_pfm;
pub(crate) mod rgb9e5;
pub(crate) mod rgbe;
pub(crate) mod texel_format;
pub(crate) mod write_dds;
pub(crate) mod write_exr;
pub(crate) mod write_ktx2;
