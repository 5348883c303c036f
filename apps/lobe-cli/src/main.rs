//! The command `lobe`: verbs on files of light.
//!
//! Each sub-command is a file of its own with its arguments, its work and, where they need it, its parsers with their
//! tests. Nothing here is a library: what others could use lives in the crates.

mod cli;
mod demo;
mod env_ambient;
mod env_area_light;
mod env_dfg;
mod env_info;
mod env_irradiance;
mod env_reconstruct;
mod env_sky;
mod env_vector_irradiance;
mod failure;
mod input;
mod light;
mod output;
mod picture;
mod project;
mod sh_convolve;
mod sh_encodings;
mod sh_eval;
mod sh_info;
mod sh_lights;
mod sh_plot;
mod sh_product;
mod sh_rotate;
mod talk;
mod turn;
mod values;

use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::parse().and_then(cli::run) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
