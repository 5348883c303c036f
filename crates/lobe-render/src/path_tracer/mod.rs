//! The path tracer: reference pictures, and radiance along paths from single receivers, by Monte Carlo alone.
//!
//! Read `path_tracer`, whose paths are estimated by next-event estimation and multiple importance sampling in
//! `paths_abreast`; then what they draw from: `bsdf` with the microfacets of `ggx`, `distant_light` with its
//! `sphere_table`, each `emitter` near by, and the Owen-scrambled Sobol' points of `sampler`. `background` names what is
//! behind a scene, `surfaces` how they reflect. `estimate` makes means and variances of paths, `reference` pictures,
//! `truth_checkpoint` keeps their pixels, `truth_exr` writes them. Uses `camera`.

pub(crate) mod background;
pub(crate) mod bsdf;
pub(crate) mod distant_light;
pub(crate) mod emitter;
pub(crate) mod estimate;
pub(crate) mod ggx;
pub(crate) mod path_tracer;
pub(crate) mod paths_abreast;
pub(crate) mod reference;
pub(crate) mod sampler;
pub(crate) mod sphere_table;
pub(crate) mod surfaces;
pub(crate) mod truth_checkpoint;
pub(crate) mod truth_exr;
