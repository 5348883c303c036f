//! Picture files and the bytes in them.
//!
//! [`read`] tells what a file is from its first bytes, holds it to the caller's limits before memory is taken for it, and
//! calls the reader of its kind (`read_*`); [`decoded`] is what those have in
//! common; [`encode`] goes the other way. Cube textures (KTX2, DDS) have the six faces of
//! each level as pictures ([`texture`]), whose texels lie in the file as a [`texel_format`] says.
//!
//! Read first: `read`, then the reader of a format. Uses nothing of the other rooms but the picture itself.

pub(crate) mod bc6h;
pub(crate) mod dds;
pub(crate) mod decoded;
pub(crate) mod encode;
pub(crate) mod jpeg_end;
pub(crate) mod read;
pub(crate) mod read_dds;
pub(crate) mod read_exr;
pub(crate) mod read_hdr;
pub(crate) mod read_ktx2;
pub(crate) mod read_ldr;
pub(crate) mod read_pfm;
pub(crate) mod rgb9e5;
pub(crate) mod rgbe;
pub(crate) mod texel_format;
pub(crate) mod texture;
pub(crate) mod write_dds;
pub(crate) mod write_exr;
pub(crate) mod write_ktx2;
