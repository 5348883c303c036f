//! Pictures on the CPU: scenes lit by transfer, path traced references, the techniques of environment mapping, and
//! plots of functions on the sphere.
//!
//! # Examples
//!
//! A baked scene under a photographed sky: see [`light_baked_scene`]. An environment as a picture, tone mapped:
//!
//! ```
//! use lobe_image::{Picture, Tone};
//!
//! let sky = Picture::from(&lobe_env::bundled::sunset().map());
//! let png = sky.resized(256, 128).to_png(&Tone::PHOTOGRAPH)?;
//! assert_eq!(&png[1..4], b"PNG");
//! # Ok::<(), lobe_render::RenderError>(())
//! ```
//!
//! Whatever draws takes a closure `Fn(Dir) -> value`, so an expansion, an environment or a formula can be drawn alike:
//!
//! ```
//! use lobe_image::Tone;
//! use lobe_render::Balloon;
//!
//! let balloon = Balloon::new(64).picture(|s| s.x() * s.y());
//! assert!(balloon.to_png(&Tone::PLAIN)?.len() > 500);
//! # Ok::<(), lobe_render::RenderError>(())
//! ```
//!
//! A white ball under a photograph, by nine coefficients and by the sum over all texels, and how far they differ:
//!
//! ```
//! use lobe_env::{bundled, irradiance_at, irradiance_sh};
//! use lobe_image::{compare, error_map};
//! use lobe_render::Ball;
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
//! # Ok::<(), lobe_render::RenderError>(())
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
//! | lit objects | [`Ball`], seen from a [`View`] |
//! | shapes before a camera | [`Exhibit`], [`ExhibitSolid`], [`Torus`], [`Camera`]; what shades them: [`Shading`] |
//! | cameras of scenes | [`ViewPoint`], [`CameraOptions`] |
//! | mirrors | [`BlinnNewell`], [`SphereMapped`], [`CubeMapped`], [`Paraboloids`]; reference [`TracedMirror`] |
//! | glossy reflection | [`Glossy`], [`HighlightMap`], [`ReflectionSpace`]; reference [`BruteForceReflection`] |
//! | diffuse reflection | [`MatteByMap`], [`MatteBySh`] with [`IrradiancePolynomial`](lobe_sh::encoding::IrradiancePolynomial) |
//! | bump mapping | [`Bumped`], [`bumped_normal`], [`bumps`] |
//! | environment mapping of scenes | [`light_by_environment_maps`], [`EnvironmentMaps`], [`TurnedMaps`], [`EnvironmentMapOptions`] |
//! | figures of mappings | [`mapping_figure()`] |
//! | all techniques on one sheet | [`environment_mapping_sheet`], [`environment_panels`] |
//! | scenes of triangles | [`render_truth`], [`render_truth_shard`], [`Truth`], [`TruthOptions`]; [`fn@scene_picture`], [`SceneHit`] |
//! | scenes with baked transfer | [`BakedScene`], [`light_baked_scene`], [`LitPicture`] |
//! | what is asked of transfer for a picture as one value | [`TransferSource`], [`SceneTransfer`], [`PictureBake`] |
//! | what is asked of a scene that moves as one value | [`MovingJob`], [`ReadMoving`] |
//! | scenes that move | [`MovingScene`], its [`MovingPart`]s and [`MovingLamp`]s, [`Moment`], [`Moments`]; [`light_moving_scene`] by [`MovingShading`] |
//! | what is baked of them | [`MovingBakeOptions`], [`PartBake`], [`KeptVertices`]; what stands still in a room [`VisibilityGrid`] |
//! | scenes without transfer | [`light_by_irradiance`] |
//! | what is behind scenes | [`Background`], [`Backdrop`], [`DistantLight::seen`] |
//! | lamps for paths | [`Emitter`], [`render_truth_with_emitters`] |
//! | paths from receivers | [`PathTracer`], [`PathOptions`], [`DistantLight`], [`SampleCount`], [`PathEstimate`] |
//! | a traced picture from its file, with its variance | [`read_traced_picture`], [`TracedPicture`] |
//!
//! Pictures themselves, tone mapping, files and comparison are in `lobe-image`. Results do not depend on the number of
//! threads.

mod camera;
mod environment_mapping;
mod error;
mod mapping_gallery;
mod moving;
mod path_tracer;
mod plot;
mod progressive;
mod scene_view;

pub use camera::camera::Camera;
pub use camera::camera_options::CameraOptions;
pub use camera::view::View;
pub use camera::view_point::ViewPoint;
pub use environment_mapping::environment_maps::{EnvironmentMaps, TurnedMaps};
pub use environment_mapping::light_by_maps::light_by_environment_maps;
pub use environment_mapping::options::EnvironmentMapOptions;
pub use error::RenderError;
pub use mapping_gallery::bump::{Bumped, bumped_normal, bumps};
pub use mapping_gallery::environment_sheet::{
    EnvironmentPanel, EnvironmentSheetOptions, EnvironmentSheetSource, environment_mapping_sheet, environment_panels,
};
pub use mapping_gallery::exhibit::{Exhibit, Shading, SurfacePoint, compare_shadings};
pub use mapping_gallery::glossy::{Glossy, between_levels};
pub use mapping_gallery::highlight_map::{HighlightMap, highlights_of_lights, irradiance_of_lights};
pub use mapping_gallery::matte::{MatteByMap, MatteBySh};
pub use mapping_gallery::mirror_maps::{BlinnNewell, CubeMapped, SphereMapped};
pub use mapping_gallery::paraboloids::Paraboloids;
pub use mapping_gallery::reflection_space::{BruteForceReflection, ReflectionSpace};
pub use mapping_gallery::solid::ExhibitSolid;
pub use mapping_gallery::torus::Torus;
pub use mapping_gallery::traced_mirror::TracedMirror;
pub use moving::keep_transfer::KeptVertices;
pub use moving::moment::Moment;
pub use moving::moments::Moments;
pub use moving::moving_bake::{MovingBakeOptions, PartBake, PartBakeKind};
pub use moving::moving_job::{BakeOne, MovingJob, OneBake, ReadMoving};
pub use moving::moving_lamp::MovingLamp;
pub use moving::moving_options::{MovingMethod, MovingOptions};
pub use moving::moving_part::{Motion, MovingPart};
pub use moving::moving_picture::light_moving_scene;
pub use moving::moving_scene::MovingScene;
pub use moving::moving_shading::MovingShading;
pub use moving::part_obstacles::{PartObstacles, PartReceivers};
pub use moving::split_parts::{MovingSplitOptions, MovingSplitReport, SplitCounts};
pub use moving::visibility_grid::{VisibilityGrid, VisibilityGridOptions};
pub use path_tracer::background::Background;
pub use path_tracer::distant_light::{Backdrop, DistantLight};
pub use path_tracer::emitter::Emitter;
pub use path_tracer::estimate::{PathEstimate, SampleCount};
pub use path_tracer::path_tracer::{LightStrategy, PathOptions, PathReceiver, PathTracer, Surfaces};
pub use path_tracer::reference::{Truth, TruthOptions, render_truth, render_truth_shard, render_truth_with_emitters};
pub use path_tracer::truth_exr::{TracedPicture, read_traced_picture, read_traced_picture_bytes};
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
pub use scene_view::baked_scene::{BakedScene, LitScene, transfer_bytes};
pub use scene_view::light_scene::{LitPicture, light_baked_scene, light_by_irradiance};
pub use scene_view::picture_bake::PictureBake;
pub use scene_view::scene_picture::{SceneHit, ViewOptions, scene_picture};
pub use scene_view::transfer_source::{SceneTransfer, TransferSource};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
