//! Spherical-harmonic lighting: the one crate to depend on.
//!
//! A few numbers can say how light arrives from everywhere. Lobe turns functions on the sphere into such numbers and
//! works on them: [`sh`] is the mathematics, [`mod@env`] the pictures of everything around a point,
//! [`render`] the pictures that show whether the numbers are right.
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
//! Convolved with the clamped cosine, light becomes irradiance for every normal at once. Coefficients may be colours.
//!
//! ```
//! use lobe::sh::{Dir, Expansion as _, Rgb, Zonal, convolved, project};
//!
//! let sky = project(3, 1, |s: Dir| Rgb::new(0.4, 0.5 + 0.1 * s.z(), 0.6 + 0.4 * s.z()));
//! let irradiance = convolved(&sky, &Zonal::clamped_cosine(3));
//!
//! let (up, down) = (irradiance.eval(Dir::Z), irradiance.eval(-Dir::Z));
//! assert!(up.b > down.b, "the sky is bluer than the ground");
//! assert!((up.r - 0.4 * std::f64::consts::PI).abs() < 1e-14, "a constant sky gives E = π L");
//! ```
//!
//! # How wrong are nine numbers?
//!
//! A sun is no polynomial: [`project_to_accuracy`](sh::project_to_accuracy) refines until the coefficients stand still,
//! and what lies above band 2 is cut off. A diffuse surface hardly notices. This compares nine coefficients with the
//! integral itself, at a hundred normals.
//!
//! ```
//! use lobe::sh::{Dir, Expansion as _, SphereQuadrature, Zonal, convolved, project_to_accuracy};
//!
//! let sun = Dir::from_angles(0.6, 2.0);
//! let light = |s: Dir| 0.3 + 5.0 * (40.0 * (s.dot(sun) - 1.0)).exp();
//!
//! let projection = project_to_accuracy(3, 1e-9, light);
//! assert!(projection.converged, "the last refinement still changed {}", projection.error);
//! let irradiance = convolved(&projection.sh, &Zonal::clamped_cosine(3));
//!
//! let fine = SphereQuadrature::of_degree(200);
//! let truth = |n: Dir| fine.integrate(|s| light(s) * n.dot(s).max(0.0));
//! let mut worst = 0.0_f64;
//! for k in 0..100 {
//!     let n = Dir::from_angles((1.0 - (2 * k + 1) as f64 / 100.0).acos(), 2.4 * k as f64);
//!     worst = worst.max((irradiance.eval(n) - truth(n)).abs());
//! }
//! // Off by 2.3 % of the brightest value at most.
//! assert!(worst < 0.025 * truth(sun), "{worst} against {}", truth(sun));
//! ```

pub use lobe_env as env;
pub use lobe_render as render;
pub use lobe_sh as sh;

/// The Rust blocks of the documents at the root of the repository, compiled and run as documentation tests.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../../../README.md")]
    mod readme {}

    #[doc = include_str!("../../../ARCHITECTURE.md")]
    mod architecture {}

    #[doc = include_str!("../../../CONVENTIONS.md")]
    mod conventions {}

    #[doc = include_str!("../../../CONTRIBUTING.md")]
    mod contributing {}
}
