//! The Python module `lobe._lobe`: kernels of Lobe over numpy arrays, which the package `lobe` wraps.
//!
//! Read `rows` first: how an array becomes rows of coefficients, numbers or colors in single or double precision, and how work is done
//! on all of them without the interpreter's lock. `eval` and `functions` are what is done to functions on the sphere, `files` where they
//! are kept, `search` what is found in them, `encodings` irradiance in a few numbers, `conventions` numbers of other
//! libraries, `lights` functions from lights. `area_lights` and
//! `reflection` are closed forms. `maps` are environment maps, `map_filters` integrals over them, `techniques` pictures by them. `bakes` and
//! `matrices` are what scenes do to light, by `job`, `compression` that in fewer numbers, `pictures` what they look like, `motion` and
//! `shadows` what moves, `outputs` the files that are written, `forked` work in children of a process. The package checks shapes and has the words for users.

#![expect(clippy::needless_pass_by_value, reason = "Python hands arguments over by value")]

mod area_lights;
mod bakes;
mod batches;
mod compression;
mod conventions;
mod encodings;
mod eval;
mod files;
mod forked;
mod functions;
mod job;
mod lights;
mod map_filters;
mod maps;
mod matrices;
mod motion;
mod options;
mod outputs;
mod pictures;
mod reflection;
mod rows;
mod scenes;
mod search;
mod shadows;
mod sharing;
mod techniques;

use std::alloc::System;

use lobe::io::{HugePages, choose_huge_pages, parallel};
use lobe::sh::simd::Machine;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

#[global_allocator]
static ALLOCATOR: HugePages<System> = HugePages::new(System).growing_by_remapping();

/// Refuses instructions and numbers of threads that do not exist, which would be ignored, or take minutes.
fn check_environment() -> Result<(), String> {
    Machine::check_limit().map_err(|error| error.to_string())?;
    choose_huge_pages().map_err(|error| error.to_string())?;
    parallel::check_environment().map_err(|error| error.to_string())
}

/// Kernels over arrays whose shapes the package `lobe` has checked.
#[pymodule]
mod _lobe {
    use super::*;

    #[pymodule_export]
    use crate::area_lights::AreaLight;
    #[pymodule_export]
    use crate::bakes::{Bake, Transfer, bake, bake_like, check_bake, is_bake_split, load_transfer};
    #[pymodule_export]
    use crate::compression::{compress, compress_f16, error_curve, fit_lobes};
    #[pymodule_export]
    use crate::conventions::{
        convention_axes, conventions, engine_forms, from_convention, import_coefficients, to_convention,
    };
    #[pymodule_export]
    use crate::encodings::{Encoded, encode, encoding_errors};
    #[pymodule_export]
    use crate::eval::eval;
    #[pymodule_export]
    use crate::files::{load_sh, save_sh};
    #[pymodule_export]
    use crate::forked::after_fork;
    #[pymodule_export]
    use crate::functions::{
        content_window, damp_zonal, dering, exp, kernel_factors, log, mirror_signs, product, rotate, scale_bands,
        width_of_peak, window_factors, window_keep,
    };
    #[pymodule_export]
    use crate::lights::{irradiance_of_light, light};
    #[pymodule_export]
    use crate::map_filters::{export_light, filter_lobe, irradiance, irradiance_at, prefilter, sun, vector_irradiance};
    #[pymodule_export]
    use crate::maps::{Map, bundled, cie_sky, load, mappings, project_lat_long, reconstruct, sky, texels};
    #[pymodule_export]
    use crate::matrices::{Matrices, load_matrices};
    #[pymodule_export]
    use crate::motion::Moving;
    #[pymodule_export]
    use crate::motion::check_moving;
    #[pymodule_export]
    use crate::options::{bake_fields, moving_fields};
    #[pymodule_export]
    use crate::outputs::{clear_abandoned, write_whole};
    #[pymodule_export]
    use crate::pictures::{compare, compare_halves, render_still, render_traced, tone_mapped, z_test};
    #[pymodule_export]
    use crate::reflection::{dfg, dfg_table, directional_albedo};
    #[pymodule_export]
    use crate::scenes::check_scene;
    #[pymodule_export]
    use crate::search::{lights, minimum, minimum_bound, peaks};
    #[pymodule_export]
    use crate::shadows::{field, lamp, sphere_table, spheres};
    #[pymodule_export]
    use crate::techniques::{show, techniques};

    /// The version of Lobe.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        check_environment().map_err(PyValueError::new_err)?;
        // numpy's table of functions is looked up with the first array: Ctrl-C in the middle of that would be a panic.
        drop(PyArray1::<f64>::zeros(module.py(), 0, false));
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
