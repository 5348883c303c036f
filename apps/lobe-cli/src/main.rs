//! The command `lobe`: verbs on files of light.
//!
//! Each sub-command is a file of its own with its arguments, its work and, where they need it, its parsers with their
//! tests. Nothing here is a library: what others could use lives in the crates.

mod bake;
mod bake_report;
mod bake_split;
mod bake_watch;
mod bake_write;
mod cli;
mod compare;
mod compress;
mod compression;
mod ctrl_c;
mod demo;
mod env_adjust;
mod env_ambient;
mod env_area_light;
mod env_convert;
mod env_dfg;
mod env_info;
mod env_irradiance;
mod env_prefilter;
mod env_reconstruct;
mod env_rotate;
mod env_show;
mod env_sky;
mod env_sun;
mod env_vector_irradiance;
mod failure;
mod fit_lobes;
mod input;
mod light;
mod map_input;
mod map_output;
mod memory;
mod output;
mod picture;
mod project;
mod render;
mod render_backs;
mod render_light;
mod render_transfer;
mod render_view;
mod scene_input;
mod sh_convolve;
mod sh_dering;
mod sh_encode;
mod sh_encodings;
mod sh_eval;
mod sh_info;
mod sh_lights;
mod sh_min;
mod sh_peaks;
mod sh_plot;
mod sh_product;
mod sh_rotate;
mod sh_window;
mod talk;
mod transfer_input;
mod turn;
mod values;

use std::panic::catch_unwind;
use std::process::ExitCode;

/// Maps are many large arrays, each used once: memory that is kept, in large pages, spares the system's work for every
/// page of them (`cargo run --release -p lobe-env --example convert_large`: a quarter of the time).
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    failure::keep_panics_quiet();
    match catch_unwind(|| cli::parse().and_then(cli::run)) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(failure)) => failure.report(),
        Err(_) => failure::report_panic(),
    }
}
