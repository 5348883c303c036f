//! Figures of functions on the sphere: balloons, maps, curves, lit balls, and the techniques of environment mapping on
//! shapes before a camera.
//!
//! Whatever draws takes a closure `Fn(Dir) -> value`: an expansion, an environment and a formula are drawn alike.
//!
//! ```
//! use lobe_figures::Balloon;
//! use lobe_image::Tone;
//!
//! let balloon = Balloon::new(64).picture(|s| s.x() * s.y());
//! assert!(balloon.to_png(&Tone::PLAIN)?.len() > 500);
//! # Ok::<(), lobe_image::ImageError>(())
//! ```
//!
//! A white ball under a photograph, by nine coefficients and by the sum over all texels, and how far they differ:
//!
//! ```
//! use lobe_env::{bundled, irradiance_at, irradiance_sh};
//! use lobe_figures::Ball;
//! use lobe_image::{compare, error_map};
//! use lobe_sh::{Dir, Rgb};
//!
//! let sky = bundled::sunset().map();
//! let (ball, black) = (Ball::new(32), Rgb::new(0.0, 0.0, 0.0));
//! let normals: Vec<Dir> = ball.normals().into_iter().map(|(_, n)| n).collect();
//! let truth = ball.lit_by_values(black, &irradiance_at(&sky, &normals));
//! let fast = ball.lit_by_sh(black, &irradiance_sh(&sky, 3));
//! let report = compare(fast.pixels(), truth.pixels());
//! assert!(report.relative_rmse < 0.05, "{report:?}");
//! let _map = error_map(&fast, &truth, report.max_abs)?;
//! # Ok::<(), lobe_image::ImageError>(())
//! ```
//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | functions on the sphere | [`Balloon`], [`CubeCross`], [`lat_long_picture`] |
//! | the basis functions | [`basis_balloons`], [`basis_crosses`] |
//! | functions of one variable | [`LinePlot`], [`Curve2d`]; of the angle to an axis [`ProfilePlot`], [`Profile`] |
//! | cross-sections of functions on the sphere | [`PolarPlot`], [`CrossSection`] |
//! | lit objects | [`Ball`], seen from a [`View`](lobe_render::View) |
//! | shapes before a camera | [`Exhibit`], [`ExhibitSolid`], [`Torus`], [`Camera`](lobe_render::Camera); what shades them: [`Shading`] |
//! | mirrors | [`BlinnNewell`], [`SphereMapped`], [`CubeMapped`], [`Paraboloids`]; reference [`TracedMirror`] |
//! | glossy reflection | [`Glossy`], [`HighlightMap`], [`ReflectionSpace`]; reference [`BruteForceReflection`] |
//! | diffuse reflection | [`MatteByMap`], [`MatteBySh`] with [`IrradiancePolynomial`](lobe_sh::encoding::IrradiancePolynomial) |
//! | bump mapping | [`Bumped`], [`bumped_normal`], [`bumps`] |
//! | figures of mappings | [`mapping_figure()`] |
//! | all techniques on one sheet | [`environment_mapping_sheet`], [`environment_panels`] |
//!
//! Errors are those of `lobe-render`. Results do not depend on the number of threads.

mod gallery;
mod plot;

pub use gallery::bump::{Bumped, bumped_normal, bumps};
pub use gallery::environment_sheet::{
    EnvironmentPanel, EnvironmentSheetOptions, EnvironmentSheetSource, environment_mapping_sheet, environment_panels,
};
pub use gallery::exhibit::{Exhibit, Shading, SurfacePoint, compare_shadings};
pub use gallery::glossy::{Glossy, between_levels};
pub use gallery::highlight_map::{HighlightMap, highlights_of_lights, irradiance_of_lights};
pub use gallery::matte::{MatteByMap, MatteBySh};
pub use gallery::mirror_maps::{BlinnNewell, CubeMapped, SphereMapped};
pub use gallery::paraboloids::Paraboloids;
pub use gallery::reflection_space::{BruteForceReflection, ReflectionSpace};
pub use gallery::solid::ExhibitSolid;
pub use gallery::torus::Torus;
pub use gallery::traced_mirror::TracedMirror;
pub use plot::ball::Ball;
pub use plot::balloon::Balloon;
pub use plot::cube_cross::{CubeCross, dir_on_cross};
pub use plot::iso_lines::IsoLines;
pub use plot::lat_long::{lat_long_picture, lat_long_picture_of};
pub use plot::line_plot::{Curve2d, LinePlot};
pub use plot::mapping_figure::mapping_figure;
pub use plot::polar_plot::{CrossSection, PolarPlot};
pub use plot::profile_plot::{Profile, ProfilePlot};
pub use plot::pyramid::{Pyramid, basis_balloons, basis_crosses};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
