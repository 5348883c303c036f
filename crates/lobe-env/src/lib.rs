//! Environment maps: pictures of everything around a point, read, written, projected and reconstructed.
//!
//! # Examples
//!
//! Read a map and ask what it shows:
//!
//! ```no_run
//! use lobe_env::{ReadOptions, read_env};
//! use lobe_sh::Dir;
//!
//! let (sky, report) = read_env("sky.exr", &ReadOptions::default())?;
//! println!("{} x {}, straight up: {:?}", report.width, report.height, sky.radiance(Dir::Z));
//! # Ok::<(), lobe_env::EnvError>(())
//! ```
//!
//! Nine numbers for each colour tell how much light falls on a surface, whichever way it faces:
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
//! Turn the light of a photograph by a quarter turn without its picture, and look at what the expansion keeps of it:
//!
//! ```
//! use lobe_env::{WriteOptions, bundled, project_env, reconstruct, write_env};
//! use lobe_sh::{Dir, Expansion, Rotation};
//!
//! let light = project_env(&bundled::sunset().map(), 6);
//! let turned = Rotation::from_axis_angle(Dir::Z, std::f64::consts::FRAC_PI_2).rotated(&light);
//! // Seen towards +y is what was towards +x.
//! assert!((turned.eval(Dir::Y) - light.eval(Dir::X)).to_array().iter().all(|d| d.abs() < 1e-12));
//! let picture = reconstruct(&turned, 64, 32);
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("turned.exr");
//! write_env(path, &picture, &WriteOptions::default())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where to find what
//!
//! | purpose | item |
//! |---|---|
//! | files | [`read_env`], [`read_env_bytes`], [`ReadOptions`], [`ReadReport`]; [`write_env`], [`WriteOptions`], [`WriteReport`] |
//! | cube maps as files | [`read_cube()`], [`write_cube()`], [`CubeWriteOptions`], [`TexelFormat`]; whichever the file holds: [`read_env_file`] |
//! | pictures of any shape | [`read_raster`] |
//! | any mapping to any other | [`resample()`], [`Resample`], [`rotate_map`]; brighter and darker: [`expose_in_place`], [`clamp_in_place`] |
//! | cubes in pictures and in six files | [`CubeLayout`], [`CubeHandedness`]; [`read_cube_faces`], [`write_cube_faces`] |
//! | cubes | [`CubeMap`], [`CubeMipChain`], [`cube`] |
//! | the picture | [`EnvMap`]; two that come along: [`bundled`] |
//! | where a direction lies in it | [`lat_long`] |
//! | to expansions and back | [`project_env`], [`project_map()`], [`reconstruct()`] |
//! | what a matte surface sees | [`irradiance_sh`], [`irradiance_map`]; by brute force [`irradiance_at`], [`irradiance_map_brute_force`] |
//! | the net flow of light | [`vector_irradiance()`], [`VectorIrradiance`] |
//! | lights of finite size | [`AreaLight`]: [`SphereLight`], [`DiscLight`], [`PolygonLight`]; [`PointLight`], [`DirectionalLight`], [`compare_approximations`] |
//! | skies | [`Sky`]: [`PreethamSky`], [`CieSky`]; [`Ground`], [`sky_sh`], [`sky_map`]; [`PreethamFit`], [`damp_zonal_in_place`] |
//! | what a glossy surface sees | [`prefilter_ggx`], [`PrefilterOptions`], [`PrefilterMethod`], [`RoughnessLevels`]; [`filter_lobe`], [`filter_lobe_lat_long`], [`SpecularLobe`], [`filter_zonal`] |
//! | the sun as a light of its own | [`extract_sun`], [`SunOptions`], [`SunReport`], [`Sun`] |
//! | what of even light a surface reflects | [`Brdf`]: [`Lambert`], [`Phong`], [`Ggx`]; [`dfg()`], [`Dfg`], [`DfgTable`] |
//!
//! # A map is constant over each texel
//!
//! The texels of a file can be read as samples at their centres, or as a function that is constant over each of them.
//! Wherever a map is integrated, here it is the second, and that function is integrated exactly.
//!
//! Point samples would cost less: one evaluation of the basis for each row instead of five or so. But their error
//! depends on the picture. The usual weights `sin θ Δθ Δφ` do not sum to `4π`, a constant sky leaks into the zonal
//! coefficients of higher bands, and what a sun of one texel leaves depends on where in its texel the basis is looked
//! at: with few rows or high orders, anything. Exact integrals leave none of this at any size, down to a map of a
//! single texel; energy is kept, and a test can ask for equality up to rounding instead of for a tolerance. The cost
//! is that of the rows alone, and vanishes beside the sum over the texels. What remains is that a texel is not the
//! world: a smooth sky that was sampled at centres is projected with an error of the square of the texel's size (see
//! [`reconstruct()`]).
//!
//! Looked at in one direction, by [`EnvMap::radiance`], a map is interpolated instead, because there steps would show.

mod adjust;
pub mod angular;
mod area_light;
mod atan;
mod azimuth;
mod balance;
mod bc6h;
mod brdf;
mod brightness;
pub mod bundled;
mod cie_sky;
pub mod cube;
mod cube_average;
mod cube_faces;
mod cube_layout;
mod cube_map;
mod cube_mip_chain;
mod dds;
mod dfg;
mod disc;
mod disc_light;
pub mod dual_paraboloid;
mod env_map;
pub mod equal_area;
mod error;
mod even_light;
mod exr_envmap;
mod extras;
mod filter_cut;
mod filter_tree;
mod horizon;
mod importance;
mod interpolate;
mod irradiance;
mod jpeg_end;
pub mod lat_long;
mod mapped_map;
mod mapping;
pub mod mirror_ball;
pub mod octahedral;
mod patch;
mod polar;
mod polygon;
mod polygon_light;
mod preetham;
mod prefilter;
mod project;
mod project_map;
mod raster;
mod read;
mod read_cube;
mod read_dds;
mod read_exr;
mod read_hdr;
mod read_ktx2;
mod read_ldr;
mod read_pfm;
mod reconstruct;
mod resample;
mod rgb9e5;
mod rgbe;
mod sample_points;
mod sky;
mod sky_fit;
mod solid_angles;
mod sparse_sum;
mod specular_lobe;
mod sphere_light;
mod sun;
mod taps;
mod texel;
mod texel_format;
mod vec3;
mod vector_irradiance;
mod view;
mod weights;
mod window;
mod write;
mod write_cube;
mod write_dds;
mod write_exr;
mod write_ktx2;
mod zonal_filter;

pub use adjust::{
    BlackenReport, ClampReport, blacken_negative_in_place, clamp_in_place, expose_in_place, scale_in_place,
};
pub use area_light::{Approximations, AreaLight, DirectionalLight, PointLight, compare_approximations};
pub use brdf::{Brdf, Ggx, Lambert, Phong};
pub use cie_sky::CieSky;
pub use cube_faces::{FACE_NAMES, cube_face_paths, read_cube_faces, write_cube_faces};
pub use cube_layout::{CubeHandedness, CubeLayout};
pub use cube_map::CubeMap;
pub use cube_mip_chain::CubeMipChain;
pub use dfg::{Dfg, DfgTable, dfg};
pub use disc_light::DiscLight;
pub use env_map::EnvMap;
pub use error::{EnvError, ReadOption};
pub use irradiance::{irradiance_at, irradiance_map, irradiance_map_brute_force, irradiance_sh};
pub use mapped_map::MappedMap;
pub use mapping::Mapping;
pub use polygon_light::PolygonLight;
pub use preetham::PreethamSky;
pub use prefilter::{
    PrefilterMethod, PrefilterOptions, RoughnessLevels, filter_lobe, filter_lobe_lat_long, filter_zonal, prefilter_ggx,
};
pub use project::project_env;
pub use project_map::project_map;
pub use raster::{Raster, read_raster, read_raster_bytes};
pub use read::{FileFormat, Nonfinite, ReadOptions, ReadReport, read_env, read_env_bytes};
pub use read_cube::{EnvFile, read_cube, read_cube_bytes, read_env_file, read_env_file_bytes};
pub use reconstruct::reconstruct;
pub use resample::{Resample, resample, rotate_map};
pub use sky::{Ground, Sky, sky_map, sky_sh};
pub use sky_fit::{PreethamFit, SkyFitOptions, damp_zonal_in_place};
pub use specular_lobe::SpecularLobe;
pub use sphere_light::SphereLight;
pub use sun::{Sun, SunOptions, SunReport, extract_sun};
pub use texel_format::TexelFormat;
pub use vector_irradiance::{VectorIrradiance, vector_irradiance};
pub use write::{WriteOptions, WriteReport, write_env};
pub use write_cube::{CubeWriteOptions, write_cube};
