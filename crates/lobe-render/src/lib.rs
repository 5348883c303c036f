//! Pictures of scenes on the CPU: lit by transfer, by irradiance or by environment maps, and path traced for reference.
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
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | cameras of scenes | [`ViewPoint`], [`CameraOptions`] |
//! | pictures for display | [`ToneOptions`] |
//! | environment mapping of scenes | [`light_by_environment_maps`], [`EnvironmentMaps`], [`TurnedMaps`], [`EnvironmentMapOptions`] |
//! | scenes of triangles | [`render_truth`], [`render_truth_shard`], [`Truth`], [`TruthOptions`]; [`fn@scene_picture`], [`SceneHit`] |
//! | scenes with baked transfer | [`BakedScene`], [`light_baked_scene`], [`LitPicture`] |
//! | what is asked of transfer for a picture as one value | [`TransferSource`], [`SceneTransfer`], [`PictureBake`] |
//! | scenes without transfer | [`light_by_irradiance`]; by shading of one's own [`light_scene_by`] |
//! | vertices that a view shows from behind | [`vertex_backs_in_view`] |
//! | what is behind scenes | [`Background`], [`Backdrop`], [`DistantLight::seen`] |
//! | lamps for paths | [`Emitter`], [`render_truth_with_emitters`] |
//! | paths from receivers | [`PathTracer`], [`PathOptions`], [`DistantLight`], [`SampleCount`], [`PathEstimate`] |
//! | a traced picture from its file, with its variance | [`read_traced_picture`], [`TracedPicture`] |
//!
//! Scenes that move are in `lobe-motion`, plots and lit balls in `lobe-figures`; pictures themselves, tone mapping, files
//! and comparison in `lobe-image`. Results do not depend on the number of threads.

mod camera;
mod environment_mapping;
mod error;
mod path_tracer;
mod progressive;
mod scene_view;

pub use camera::camera::Camera;
pub use camera::camera_options::CameraOptions;
pub use camera::tone_options::ToneOptions;
pub use camera::view::View;
pub use camera::view_point::ViewPoint;
pub use environment_mapping::environment_maps::{EnvironmentMaps, TurnedMaps};
pub use environment_mapping::gltf_surfaces::{GltfSurfaces, Reflections};
pub use environment_mapping::light_by_maps::light_by_environment_maps;
pub use environment_mapping::options::EnvironmentMapOptions;
pub use error::RenderError;
pub use path_tracer::background::Background;
pub use path_tracer::distant_light::{Backdrop, DistantLight};
pub use path_tracer::emitter::Emitter;
pub use path_tracer::estimate::{PathEstimate, SampleCount};
pub use path_tracer::path_tracer::{LightStrategy, PathOptions, PathReceiver, PathTracer};
pub use path_tracer::reference::{Truth, TruthOptions, render_truth, render_truth_shard, render_truth_with_emitters};
pub use path_tracer::surfaces::Surfaces;
pub use path_tracer::truth_exr::{TracedPicture, read_traced_picture, read_traced_picture_bytes};
pub use scene_view::baked_scene::{BakedScene, transfer_bytes};
pub use scene_view::light_scene::{
    LitPicture, light_baked_scene, light_baked_surfaces, light_by_irradiance, light_scene_by, light_surfaces_by,
};
pub use scene_view::lit_scene::LitScene;
pub use scene_view::openness::Openness;
pub use scene_view::picture_bake::PictureBake;
pub use scene_view::placed_transfer::vertex_backs_in_view;
pub use scene_view::scene_picture::{SceneHit, ViewOptions, scene_picture};
pub use scene_view::sun_rays::{SunRays, SurfacePoint};
pub use scene_view::surface_model::{LitSurfaces, MatteSurfaces, SurfaceLight, SurfaceModel, Surroundings};
pub use scene_view::transfer_source::{SceneTransfer, TransferSource};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
