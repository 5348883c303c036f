//! Environment maps: reading, writing, resampling, projection onto spherical harmonics, prefiltering; lights and skies.
//!
//! # Examples
//!
//! Read a map and look up a direction:
//!
//! ```no_run
//! use lobe_env::EnvMap;
//! use lobe_sh::Dir;
//!
//! let sky = EnvMap::load("sky.exr")?;
//! println!("{} x {}, straight up: {:?}", sky.width(), sky.height(), sky.radiance(Dir::Z));
//! # Ok::<(), lobe_env::EnvError>(())
//! ```
//!
//! Nine coefficients for each color give the irradiance of a surface for every normal:
//!
//! ```
//! use lobe_env::{bundled, irradiance_at, irradiance_sh};
//! use lobe_sh::{Dir, Expansion};
//!
//! let sky = bundled::sunset().map();
//! let irradiance = irradiance_sh(&sky, 3);
//! let fast = irradiance.eval(Dir::Z);
//! // Within a few percent of the sum over all texels.
//! let exact = irradiance_at(&sky, &[Dir::Z])[0];
//! assert!((fast.g / exact.g - 1.0).abs() < 0.05);
//! ```
//!
//! Rotate the expansion of a photograph by a quarter turn and reconstruct a picture of it:
//!
//! ```
//! use lobe_env::{PictureWriteOptions, bundled, project_env, reconstruct, write_env};
//! use lobe_sh::{Dir, Expansion, Rotation};
//!
//! let light = project_env(&bundled::sunset().map(), 6);
//! let turned = light.rotated(&Rotation::from_axis_angle(Dir::Z, std::f64::consts::FRAC_PI_2));
//! // Seen towards +y is what was towards +x.
//! assert!((turned.eval(Dir::Y) - light.eval(Dir::X)).to_array().iter().all(|d| d.abs() < 1e-12));
//! let picture = reconstruct(&turned, 64, 32);
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("turned.exr");
//! write_env(path, &picture, &PictureWriteOptions::default())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | any map from any file | [`EnvMap::load`], [`MappedMap::load`], [`read_map`], [`LoadedMap`], [`MapReadOptions`], [`MapReadReport`]; fisheye pictures [`FisheyeOptions`], [`FisheyeProjection`] |
//! | maps as files | [`write_env`], or its bytes [`encode_env`]; cubes with levels [`write_cube()`], [`CubeWriteOptions`], [`TexelFormat`]; in six files [`FaceFiles`], [`write_cube_faces`] |
//! | any mapping to any other | [`resample()`], [`Resample`], [`rotate_map`]; brighter and darker: [`expose_in_place`], [`clamp_in_place`] |
//! | cubes in pictures | [`CubeLayout`], [`CubeHandedness`] |
//! | cubes | [`CubeMap`], [`CubeMipChain`], [`cube`] |
//! | lat-long maps | [`EnvMap`]; two in the library: [`bundled`] |
//! | directions and points of a lat-long map | [`lat_long`] |
//! | to expansions and back | [`project_env`], [`project_map()`], [`reconstruct()`] |
//! | irradiance | [`irradiance_sh`], [`irradiance_map`]; by brute force [`irradiance_at`], [`irradiance_map_brute_force`] |
//! | net flux of light | [`vector_irradiance()`], [`VectorIrradiance`] |
//! | area lights | [`AreaLight`]: [`SphereLight`], [`DiscLight`], [`PolygonLight`]; [`PointLight`], [`ParallelBeam`], [`compare_approximations`] |
//! | skies | [`Sky`]: [`PreethamSky`], [`CieSky`]; [`Ground`], [`sky_sh`], [`sky_map`]; [`PreethamFit`], [`damp_zonal_in_place`] |
//! | prefiltering for glossy reflection | [`cube_source`], [`prefilter_ggx`], [`PrefilterOptions`], [`RoughnessLevels`]; [`filter_lobe`], [`filter_lobe_lat_long`], [`SpecularLobe`], [`filter_zonal`] |
//! | sun extraction | [`extract_sun`], [`SunOptions`], [`SunReport`], [`Sun`], [`read_suns`] |
//! | a light for an engine | [`export_light`], [`Engine`], [`ExportOptions`]; its coefficients back [`import_coefficients`]; files of Babylon.js [`encode_babylon_env`] |
//! | suns and the rest of the light | [`SceneLight`] by a [`SunChoice`] |
//! | reflectance and its directional albedo | [`Brdf`]: [`Lambert`], [`Phong`], [`Ggx`]; [`dfg()`], [`dfg_separable`], [`Dfg`], [`DfgTable`]; [`LobeTable`], [`LobeFactors`] |
//!
//! # A map is constant over each texel
//!
//! The texels of a file can be read as samples at their centers, or as a function that is constant over each of them.
//! Wherever a map is integrated, Lobe takes it as the second, and integrates that function exactly.
//!
//! Point samples would cost less: one evaluation of the basis for each row instead of about five. But their error
//! depends on the picture. The usual weights `sin θ Δθ Δφ` do not sum to `4π`, a constant sky leaks into the zonal
//! coefficients of higher bands, and the coefficients of a sun of one texel depend on where in its texel the basis is
//! evaluated: with few rows or high orders the error is unbounded. Exact integrals have none of this at any size, down
//! to a map of a single texel; energy is conserved, and a test can ask for equality up to rounding instead of a
//! tolerance. The additional cost is that of the rows alone, and vanishes beside the sum over the texels. The remaining
//! error is that of sampling: a smooth sky that was sampled at centers is projected with an error of the square of the
//! texel's size (see [`reconstruct()`]).
//!
//! A lookup in one direction, [`MappedMap::radiance`], interpolates instead, because there steps would show.
//!
//! # Watching and stopping
//!
//! Functions that may take longer than seconds take a [`Job`](lobe_io::Job) as their last argument: [`prefilter_ggx`],
//! [`filter_lobe`], [`filter_zonal`], [`filter_lobe_lat_long`], [`irradiance_map_brute_force`], [`resample()`] and what is
//! built on it. All others, projections among them, take about as long as reading the file.

mod area_light;
mod engines;
mod error;
mod files;
mod map;
mod mapping;
mod prefilter;
mod projection;
mod reflection;
mod resample;
mod sky;

pub use area_light::area_light::{Approximations, AreaLight, ParallelBeam, PointLight, compare_approximations};
pub use area_light::disc_light::DiscLight;
pub use area_light::polygon_light::PolygonLight;
pub use area_light::sphere_light::SphereLight;
pub use area_light::vector_irradiance::{VectorIrradiance, vector_irradiance};
pub use engines::engine::{Engine, EngineFacts, Tried};
pub use engines::export::{ExportReport, export_light, exported_files};
pub use engines::export_options::ExportOptions;
pub use engines::exported_file::ExportedFile;
pub use engines::import::import_coefficients;
pub use error::{EnvError, MapReadOption};
pub use files::babylon_env::encode_babylon_env;
pub use files::bundled;
pub use files::cropped::Padding;
pub use files::cube_faces::{FaceFiles, write_cube_faces};
pub use files::fisheye::FisheyeOptions;
pub use files::project_map_file::project_map_file;
pub use files::read_map::{LoadedMap, read_map, read_map_bytes};
pub use files::read_options::{FaceAssumption, MapReadOptions, MapReadReport};
pub use files::write::{CubeWriteOptions, encode_cube, encode_env, write_cube, write_env};
pub use lobe_image::{FileFormat, Nonfinite, PictureWriteOptions, TexelFormat};
pub use map::adjust::{
    BlackenReport, ClampReport, blacken_negative_in_place, clamp_in_place, expose_in_place, scale_in_place,
};
pub use map::cube_handedness::CubeHandedness;
pub use map::cube_layout::CubeLayout;
pub use map::cube_map::CubeMap;
pub use map::cube_mip_chain::CubeMipChain;
pub use map::env_map::EnvMap;
pub use map::face_order::{FaceNames, FaceOrder};
pub use map::mapped_map::MappedMap;
pub use mapping::angular;
pub use mapping::cube;
pub use mapping::dual_paraboloid;
pub use mapping::equal_area;
pub use mapping::fisheye::FisheyeProjection;
pub use mapping::lat_long;
pub use mapping::mapping::Mapping;
pub use mapping::mirror_ball;
pub use mapping::octahedral;
pub use prefilter::options::PrefilterOptions;
pub use prefilter::prefilter::{filter_lobe, filter_lobe_lat_long, filter_zonal, prefilter_ggx};
pub use prefilter::roughness_levels::RoughnessLevels;
pub use projection::encoding_errors::{EncodingErrors, encoding_errors, irradiance_to_encode};
pub use projection::irradiance::{
    irradiance_at, irradiance_cube, irradiance_map, irradiance_map_brute_force, irradiance_sh,
};
pub use projection::lat_long_projector::LatLongProjector;
pub use projection::project::{project_env, project_env_as, project_lat_long};
pub use projection::project_map::project_map;
pub use projection::reconstruct::{reconstruct, reconstruct_into};
pub use reflection::brdf::{Brdf, Ggx, Lambert, Phong};
pub use reflection::dfg::{Dfg, DfgTable, dfg, dfg_separable};
pub use reflection::lobe_factors::LobeFactors;
pub use reflection::lobe_table::{LobeNode, LobeTable};
pub use reflection::specular_lobe::SpecularLobe;
pub use resample::cube_source::cube_source;
pub use resample::resample::{Resample, resample, rotate_map};
pub use sky::cie_sky::CieSky;
pub use sky::no_sun::NoSun;
pub use sky::preetham::PreethamSky;
pub use sky::scene_light::SceneLight;
pub use sky::sky::{Ground, Sky, sky_map, sky_sh};
pub use sky::sky_fit::{PreethamFit, SkyFitOptions, damp_zonal_in_place};
pub use sky::sun_choice::SunChoice;
pub use sky::sun_extraction::{Sun, SunOptions, SunReport, extract_sun, find_sun};
pub use sky::sun_file::{SunRecord, read_suns};
pub use sky::suns::{SunsReport, extract_suns};
