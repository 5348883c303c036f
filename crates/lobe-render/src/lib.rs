//! Pictures on the CPU: plots of functions on the sphere, lit balls, error maps, tone mapping and PNG files.
//!
//! A [`Picture`] holds linear light. Everything that draws takes a closure `Fn(Dir) -> value`, so an expansion, an
//! environment map or a formula can be drawn alike:
//!
//! ```
//! use lobe_render::{Ball, Picture, Tone};
//! use lobe_sh::Rgb;
//!
//! // A white ball under a sky of radiance 1: its irradiance is π everywhere, it leaves radiance 1.
//! let ball = Ball::new(64).picture(Rgb::new(0.0, 0.0, 0.0), |_| Rgb::new(1.0, 1.0, 1.0));
//! assert_eq!(ball.pixel(32, 32), Rgb::new(1.0, 1.0, 1.0));
//! let png = ball.to_png(&Tone::PLAIN)?;
//! assert_eq!(&png[1..4], b"PNG");
//! # Ok::<(), lobe_render::RenderError>(())
//! ```
//!
//! Pixel `(0, 0)` is the top left one, pixel centres lie at +½. Results do not depend on the number of threads.

mod axes;
mod ball;
mod balloon;
mod colormap;
mod colour_bar;
mod compare;
mod cube;
mod cube_cross;
mod error;
mod iso_lines;
mod lat_long;
mod mesh;
mod picture;
mod png;
mod profile_plot;
mod pyramid;
mod raster;
mod resize;
mod sheet;
mod srgb;
mod text;
mod tone;
mod vector;
mod view;

pub use ball::Ball;
pub use balloon::Balloon;
pub use colormap::{diverging, sequential};
pub use colour_bar::colour_bar;
pub use compare::{ErrorReport, compare, error_map, error_of};
pub use cube_cross::{CubeCross, dir_on_cross};
pub use error::RenderError;
pub use iso_lines::IsoLines;
pub use lat_long::{lat_long_picture, lat_long_picture_of};
pub use picture::Picture;
pub use profile_plot::{Profile, ProfilePlot};
pub use pyramid::{Pyramid, basis_balloons, basis_crosses};
pub use sheet::Sheet;
pub use srgb::{srgb_decode, srgb_encode};
pub use text::Label;
pub use tone::{Curve, Exposure, Tone};
pub use view::View;
