//! Headers of picture files: what they say besides the texels, and limits that hold before memory is allocated.
//!
//! [`decoded`] is what every reader hands on, the head of a picture with its notes. [`orientation`] turns what is stored turned. [`icc`] and
//! [`png_color`] tell primaries and curves, [`exr_unused`] what OpenEXR says and Lobe leaves out, [`xmp`] panoramas, [`hdr_header`] the lines of a Radiance picture.
//!
//! Read `decoded` first. Uses `picture`.

pub(crate) mod decoded;
pub(crate) mod exr_unused;
pub(crate) mod hdr_header;
pub(crate) mod icc;
pub(crate) mod orientation;
pub(crate) mod png_color;
pub(crate) mod xmp;
