//! Files: every format that is read and written, and damaged files.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod cube_malformed;
mod cubes;
mod delivery;
mod exr_files;
mod ktx2_rules;
mod ktx2_written;
mod malformed;
mod pfm_headers;
mod picture_rows;
mod read_exr;
mod read_hdr;
mod read_pictures;
mod textures;
mod write;
