//! Spherical-harmonic lighting: the one crate to depend on.
//!
//! A few numbers can say how light arrives from everywhere. Lobe turns functions on the sphere into such numbers and
//! works on them: [`sh`] is the mathematics, [`mod@env`] the pictures of everything around a point,
//! [`scene`] the triangles that stand in the light, [`prt`] what they do to it, [`shadow`] what they do where they move.
//! [`render`] makes pictures of scenes, [`motion`] of scenes that move, and [`figures`] of the functions themselves.
//!
//! Directions are right-handed with +z up. "Order n" means n bands and n² coefficients. Radiance L is what arrives
//! along one direction; irradiance E is what a surface receives in all and never includes 1/π, so a white surface sends
//! E/π back. `CONVENTIONS.md` at the root of the repository shows all of this on one page.
//!
//! # From a function to nine numbers
//!
//! [`project`](sh::project) integrates exactly when it is told the degree of the function, as a polynomial in x, y, z.
//!
//! ```
//! use lobe::sh::{Dir, Expansion as _, project};
//!
//! let sky = project(3, 1, |s: Dir| 1.0 + 0.5 * s.z());
//! assert_eq!(sky.coefficients().len(), 9);
//! assert!((sky.eval(Dir::Z) - 1.5).abs() < 1e-14);
//! ```
//!
//! # From light to what a surface receives
//!
//! Convolved with the clamped cosine, light becomes irradiance for every normal at once. Coefficients may be colors.
//!
//! ```
//! use lobe::sh::{Dir, Expansion as _, Rgb, Zonal, project};
//!
//! let sky = project(3, 1, |s: Dir| Rgb::new(0.4, 0.5 + 0.1 * s.z(), 0.6 + 0.4 * s.z()));
//! let irradiance = sky.convolved(&Zonal::clamped_cosine(3));
//!
//! let (up, down) = (irradiance.eval(Dir::Z), irradiance.eval(-Dir::Z));
//! assert!(up.b > down.b, "the sky is bluer than the ground");
//! assert!((up.r - 0.4 * std::f64::consts::PI).abs() < 1e-14, "a constant sky gives E = π L");
//! ```
//!
//! # From a photograph to a lit ball, beside the truth
//!
//! The same from a picture of a real sky. A sun is no polynomial, so what lies above band 2 is cut off, and a diffuse
//! surface hardly notices: the ball lit by nine coefficients is 2.4 % off the ball lit by every texel.
//!
//! ```
//! use lobe::env::{bundled, irradiance_at, project_env};
//! use lobe::image::{Tone, compare};
//! use lobe::figures::Ball;
//! use lobe::sh::{Dir, Rgb, Zonal};
//!
//! let sky = bundled::sunset().map();
//! let irradiance = project_env(&sky, 3).convolved(&Zonal::clamped_cosine(3));
//!
//! let black = Rgb::new(0.0, 0.0, 0.0);
//! let ball = Ball::new(48);
//! let claim = ball.lit_by_sh(black, &irradiance);
//!
//! let normals: Vec<Dir> = ball.normals().into_iter().map(|(_, n)| n).collect();
//! let truth = ball.lit_by_values(black, &irradiance_at(&sky, &normals));
//!
//! let error = compare(claim.pixels(), truth.pixels());
//! assert!(error.relative_rmse < 0.03, "{error:?}");
//! let png: Vec<u8> = claim.to_png(&Tone::PLAIN)?;
//! # assert!(png.len() > 1000, "{} bytes", png.len());
//! # Ok::<(), lobe::render::RenderError>(())
//! ```
//!
//! # From a light to numbers, and back
//!
//! Lights with a shape have closed forms of any order. Few bands ring: the irradiance of a sun is negative below its
//! horizon, until the least change takes that away. A window calms radiance at the price of contrast, or, where the content
//! decides, away from the light only. And what lights there are can be read from an expansion.
//!
//! ```
//! use lobe::sh::encoding::{IrradianceEncoding, PackedIrradiance};
//! use lobe::sh::light::Normalization;
//! use lobe::sh::light_extraction::extract_light;
//! use lobe::sh::ringing::{ContentWindow, DeringOptions};
//! use lobe::sh::{Coefficient as _, Dir, Expansion as _, Light, Rgb, Rotation, Window, Zonal};
//!
//! let sun = Light::Directional { dir: Dir::X, color: Rgb::new(3.0, 2.0, 1.0) };
//! let sky = Light::Ambient { color: Rgb::splat(0.1) };
//! let light = &sun.project(3, Normalization::Projected)? + &sky.project(3, Normalization::Projected)?;
//! let found = extract_light(&light)?;
//! assert!(found.lights[0].dir.angle_to(Dir::X) < 1e-9 && (found.ambient.g - 0.1).abs() < 1e-12);
//!
//! let irradiance = light.convolved(&Zonal::clamped_cosine(3));
//! let (calm, report) = irradiance.deringed_with(&DeringOptions::default());
//! assert!(report.before[0].hi < 0.0 && report.after[0].lo > -1e-6 * calm.mean().r, "{report:?}");
//!
//! let window = Window::Hanning { width: 3.0 };
//! let content = ContentWindow::of(&light, window);
//! assert!((content.eval(&light, Dir::X).r - light.eval(Dir::X).r).abs() < 1e-12);
//! assert!((content.eval(&light, -Dir::X).r - light.windowed(&window).eval(-Dir::X).r).abs() < 1e-12);
//!
//! // Seven vectors for a shader, or six colors for a cube.
//! let constants = PackedIrradiance::from_irradiance_sh(&calm);
//! let cube = IrradianceEncoding::AmbientCubeFitted.encode(&calm, Rotation::IDENTITY);
//! assert!((constants.eval(Dir::X).r - calm.eval(Dir::X).r).abs() < 1e-12);
//! assert!((cube.eval(Dir::X).r / calm.eval(Dir::X).r - 1.0).abs() < 0.15);
//! # Ok::<(), lobe::sh::ShError>(())
//! ```
//!
//! # From a scene to what it does to light
//!
//! Shadows and light from surface to surface depend on the scene, not on the light: they are baked once, as an expansion at
//! each vertex, and any light is applied to them by a scalar product.
//!
//! ```
//! use lobe::env::{bundled, project_env};
//! use lobe::io::Job;
//! use lobe::prt::{BakeOptions, Receivers, bake};
//! use lobe::scene::{Bvh, built_in};
//! use lobe::sh::Expansion as _;
//!
//! let scene = built_in::ball_over_ground(8);
//! let receivers = Receivers::at_vertices(&scene)?;
//! let options = BakeOptions::default().samples(64);
//! let (transfer, _) = bake(&scene, &Bvh::new(&scene), &receivers, &options, Job::default())?;
//!
//! let light = project_env(&bundled::sunset().map(), transfer.order());
//! let colors = transfer.exit_radiance(light.coefficients());
//! assert_eq!(colors.len(), scene.vertex_count());
//! # Ok::<(), lobe::prt::PrtError>(())
//! ```

pub use lobe_env as env;
pub use lobe_figures as figures;
pub use lobe_image as image;
pub use lobe_io as io;
pub use lobe_motion as motion;
pub use lobe_prt as prt;
pub use lobe_render as render;
pub use lobe_scene as scene;
pub use lobe_sh as sh;
pub use lobe_shaders as shaders;
pub use lobe_shadow as shadow;

/// The Rust blocks of the documents at the root of the repository, compiled and run as documentation tests.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../../../README.md")]
    mod readme {}

    #[doc = include_str!("../README.md")]
    mod readme_of_the_crate {}

    #[doc = include_str!("../../../ARCHITECTURE.md")]
    mod architecture {}

    #[doc = include_str!("../../../CONVENTIONS.md")]
    mod conventions {}

    #[doc = include_str!("../../../CONTRIBUTING.md")]
    mod contributing {}
}

/// The Rust blocks of the guide, `docs/guide`, chapter by chapter.
#[cfg(doctest)]
mod guide {
    #[doc = include_str!("../../../docs/guide/src/introduction.md")]
    mod introduction {}

    #[doc = include_str!("../../../docs/guide/src/expansions.md")]
    mod expansions {}

    #[doc = include_str!("../../../docs/guide/src/projection.md")]
    mod projection {}

    #[doc = include_str!("../../../docs/guide/src/irradiance.md")]
    mod irradiance {}

    #[doc = include_str!("../../../docs/guide/src/rotation.md")]
    mod rotation {}

    #[doc = include_str!("../../../docs/guide/src/products.md")]
    mod products {}

    #[doc = include_str!("../../../docs/guide/src/exponentials.md")]
    mod exponentials {}

    #[doc = include_str!("../../../docs/guide/src/speed.md")]
    mod speed {}

    #[doc = include_str!("../../../docs/guide/src/ringing.md")]
    mod ringing {}

    #[doc = include_str!("../../../docs/guide/src/lights.md")]
    mod lights {}

    #[doc = include_str!("../../../docs/guide/src/environment-maps.md")]
    mod environment_maps {}

    #[doc = include_str!("../../../docs/guide/src/mappings.md")]
    mod mappings {}

    #[doc = include_str!("../../../docs/guide/src/prefiltering.md")]
    mod prefiltering {}

    #[doc = include_str!("../../../docs/guide/src/skies.md")]
    mod skies {}

    #[doc = include_str!("../../../docs/guide/src/area-lights.md")]
    mod area_lights {}

    #[doc = include_str!("../../../docs/guide/src/baking.md")]
    mod baking {}

    #[doc = include_str!("../../../docs/guide/src/compression.md")]
    mod compression {}

    #[doc = include_str!("../../../docs/guide/src/glossy.md")]
    mod glossy {}

    #[doc = include_str!("../../../docs/guide/src/rendering.md")]
    mod rendering {}

    #[doc = include_str!("../../../docs/guide/src/moving.md")]
    mod moving {}

    #[doc = include_str!("../../../docs/guide/src/shaders.md")]
    mod shaders {}

    #[doc = include_str!("../../../docs/guide/src/sharing.md")]
    mod sharing {}

    #[doc = include_str!("../../../docs/guide/src/shipping.md")]
    mod shipping {}

    #[doc = include_str!("../../../docs/guide/src/viewer.md")]
    mod viewer {}

    #[doc = include_str!("../../../docs/guide/src/python.md")]
    mod python {}

    #[doc = include_str!("../../../docs/guide/src/command-line.md")]
    mod command_line {}

    #[doc = include_str!("../../../docs/guide/src/formats.md")]
    mod formats {}

    #[doc = include_str!("../../../docs/guide/src/conventions.md")]
    mod conventions {}
}
