//! Textures: KTX2, KTX and DDS hold the six faces of each level of a cube as pictures, or a single picture.
//!
//! [`cube_texture`] is what they hold, [`texture`] reads and writes it by the reader or writer of the format, whose
//! readers give a [`stored_texture`]; texels are stored in a [`texel_format`], or as channels side by side
//! ([`stored_format`]), small floating-point numbers ([`rgb9e5`], [`packed_float`]) and blocks ([`bc6h`]) among them.
//! Babylon.js has faces as pictures of their own ([`rgbd`]).
//!
//! Read `texture` first, then `texel_format`. Uses `codec`, `header` and `picture`.

pub(crate) mod bc6h;
#[cfg(any(test, not(feature = "bc6h")))]
pub(crate) mod bc6h_encode;
pub(crate) mod cube_texture;
pub(crate) mod dds;
pub(crate) mod packed_float;
pub(crate) mod read_ktx1;
pub(crate) mod read_ktx2;
pub(crate) mod rgb9e5;
pub(crate) mod rgbd;
pub(crate) mod stored_format;
pub(crate) mod stored_texture;
pub(crate) mod texel_format;
pub(crate) mod texture;
pub(crate) mod write_ktx1;
pub(crate) mod write_ktx2;
