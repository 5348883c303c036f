//! Pictures: decoding, encoding, tone mapping and comparison, without any notion of directions.
//!
//! A [`Picture`] holds linear light, a [`Pixel`] is three `f32`. Any `Into<[f32; 3]>` is accepted; any `From<[f32; 3]>`
//! can be returned.
//!
//! # Examples
//!
//! Tone map a picture of high dynamic range to PNG:
//!
//! ```
//! use lobe_image::{Picture, Tone};
//!
//! let picture = Picture::from_fn(64, 32, |x, y| [0.1 * x as f32, 0.2 * y as f32, 1.0]);
//! let png = picture.resized(32, 16).to_png(&Tone::PHOTOGRAPH)?;
//! assert_eq!(&png[1..4], b"PNG");
//! # Ok::<(), lobe_image::ImageError>(())
//! ```
//!
//! Compare two pictures by error metrics and by perception:
//!
//! ```
//! use lobe_image::{FLIP_PIXELS_PER_DEGREE, Picture, compare, flip};
//!
//! let reference = Picture::filled(16, 16, [0.5; 3]);
//! let image = Picture::filled(16, 16, [0.5, 0.5, 0.6]);
//! let report = compare(image.pixels(), reference.pixels());
//! assert!((report.max_abs - 0.1).abs() < 1e-6);
//! assert!(flip(&image, &reference, FLIP_PIXELS_PER_DEGREE)?.mean() > 0.0);
//! # Ok::<(), lobe_image::ImageError>(())
//! ```
//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | pictures | [`Picture`], [`Sheet`], [`Label`], [`color_bar()`]; colors for numbers: [`sequential`], [`diverging`] |
//! | reading | [`read_picture`], [`read_picture_bytes`], [`PictureReadOptions`], [`PictureReadReport`]; by rows: [`PictureRows`]; OpenEXR of any channels: [`ExrLayers`]; what a file is: [`FileFormat`] |
//! | writing light | [`write_picture`], [`encode_picture`], [`PictureWriteOptions`], [`PictureWriteReport`]; OpenEXR of any channels: [`ExrLayers`] |
//! | writing for display | [`Picture::write_png`], [`AnimatedPng`], [`FrameSequence`], [`Tone`], [`Exposure`], [`Curve`]; [`srgb_encode`], [`srgb_decode`] |
//! | cube textures | [`read_cube_texture`], [`write_cube_texture`], [`encode_cube_texture`], [`CubeTexture`], [`TexelFormat`]; the light beside it [`ktx_sh`]; a face as an 8-bit picture [`encode_rgbd`] |
//! | differences | [`compare()`], [`relative_mse`], [`error_map`]; perceptual [`flip()`], [`hdr_flip()`]; statistical [`ZTest`], [`HalvesReport`] |
//!
//! # Linear light until the last step
//!
//! A [`Picture`] holds linear light in `f32`, and everything but writing a file for display works on it: resizing,
//! error maps. The cost is twelve bytes a pixel and a transfer function for each pixel written; in return a
//! half-covered pixel has half the light, a smaller picture has the mean of the larger one, and two pictures can be
//! compared in the unit of the light and shown with one exposure ([`Tone::fixed_for`]).
//!
//! Pixel `(0, 0)` is the top left one, pixel centers lie at +½. Results do not depend on the number of threads.

mod codec;
mod compare;
mod error;
mod header;
mod picture;
mod pixel;
mod texture;

pub use codec::encode::{PictureWriteOptions, PictureWriteReport, encode_picture, write_picture, write_pixels};
pub use codec::exr_layers::{ExrAttribute, ExrLayers};
pub use codec::file_format::FileFormat;
pub use codec::frames::FrameSequence;
pub use codec::picture_rows::PictureRows;
pub use codec::read::{
    Nonfinite, PictureReadOptions, PictureReadReport, picture_file_bytes, read_picture, read_picture_bytes,
};
pub use compare::compare::{ErrorReport, compare, error_map, error_of, relative_mse};
pub use compare::flip::{FLIP_PIXELS_PER_DEGREE, Flip, flip};
pub use compare::halves::HalvesReport;
pub use compare::hdr_flip::hdr_flip;
pub use compare::z_test::{Measured, ZTest};
pub use error::{ImageError, ReadOption};
pub use header::decoded::{EnvmapAttribute, RowStrip};
pub use picture::animated_png::{AddFrame, AnimatedPng, animated_png, write_animated_png};
pub use picture::color_bar::color_bar;
pub use picture::colormap::{diverging, sequential};
pub use picture::picture::Picture;
pub use picture::sheet::Sheet;
pub use picture::srgb::{srgb_decode, srgb_encode};
pub use picture::text::{Label, distance_to_segment, draw_lines};
pub use picture::tone::{Exposure, Tone};
pub use picture::tone_curve::Curve;
pub use pixel::{IntoPixel, Pixel, mix};
pub use texture::cube_texture::{CubeTexture, mip_level_count, mip_level_size};
pub use texture::rgbd::{RGBD_MAX, encode_rgbd};
pub use texture::texel_format::TexelFormat;
pub use texture::texture::{
    TextureNotes, encode_cube_texture, is_cube_texture_bytes, ktx_sh, read_cube_texture, read_cube_texture_bytes,
    read_texture_picture_bytes, write_cube_texture,
};
