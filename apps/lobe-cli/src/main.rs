//! The command `lobe`: sub-commands that project, bake, render and compare light in files.
//!
//! Each sub-command is a file of its own with its arguments, its work and, where they need it, its parsers with their
//! tests. Code that others could use is in the crates.

mod args;
mod bake;
mod cli;
mod compare;
mod demo;
mod env;
mod export;
mod import;
mod light;
mod manual;
mod project;
mod render;
mod run;
mod sh;
mod shadow;

use std::panic::catch_unwind;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: run::system::Allocator = run::system::Allocator;

fn main() -> ExitCode {
    run::system::tell_refused_memory();
    run::system::let_writes_fail();
    lobe::io::before_writing(run::ctrl_c::listen);
    run::failure::keep_panics_quiet();
    match catch_unwind(|| cli::parse().and_then(cli::run)) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(failure)) => failure.report(),
        Err(_) => run::failure::report_panic(),
    }
}
