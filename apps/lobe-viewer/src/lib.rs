//! The window of Lobe: see and steer spherical-harmonic lighting and precomputed radiance transfer in real time.
//!
//! Four rooms behind a bar: a baked **scene** under a turning sky, the **sky** itself and its expansions, **functions** on the
//! sphere, and what is in **motion**. Everything they show is computed by the library; a room decides what is asked for and shows
//! the answer. Rooms draw into any [`egui::Ui`](eframe::egui::Ui), with a device or without, so that tests press their controls by
//! name and compare the numbers on the screen with the library's.
//!
//! | purpose | item |
//! |---|---|
//! | the program | [`main`] |
//! | the application | [`ViewerApp`], [`RoomName`], [`Kept`], [`UserFolder`], [`Gpu`] |
//! | the room of scenes | [`SceneRoom`], [`SceneEdits`], [`SceneLamp`], [`Comparison`], [`vertex_under`], [`transfer_of`] |
//! | the rooms of skies, functions and motion | [`SkyRoom`], [`Shelf`], [`FunctionsRoom`], [`MotionRoom`], [`MotionEdits`], [`MotionView`] |
//! | what is shown of a scene | [`Mode`], [`Surfaces`](lobe::render::Surfaces), [`Taming`], [`Orbit`] |
//! | what is computed | [`Formula`] |
//! | reading and baking off the thread of the window | [`ReadLimits`], [`Task`], [`open_scene`], [`open_moving`], [`open_sky`], [`bake_scene`], [`moving_bake_options`] |
//! | pictures as files | [`ExportPlan`], [`SceneExport`] |

mod app;
#[cfg(not(target_arch = "wasm32"))]
mod cli;
mod loading;
mod rooms;
mod widgets;

use std::process::ExitCode;

#[cfg(not(target_arch = "wasm32"))]
use clap::Parser as _;

pub use app::kept::{Kept, Theme};
pub use app::viewer_app::ViewerApp;
pub use loading::bake::{GlossyBake, SceneData, bake_options, bake_scene};
pub use loading::cache::UserFolder;
pub use loading::export::{ExportPlan, SceneExport};
pub use loading::limits::ReadLimits;
pub use loading::mode::Mode;
pub use loading::moving_bakes::moving_bake_options;
pub use loading::moving_source::open_moving;
pub use loading::places::Places;
pub use loading::scene_source::{OpenedScene, open_scene};
pub use loading::sky_source::{OpenedSky, open_sky};
pub use loading::task::{Control, Task, TaskEvent};
pub use rooms::formulas::Formula;
pub use rooms::functions::edits::{FunctionsEdits, OpenedFunction, Section, Shape, Study};
pub use rooms::functions::functions_room::FunctionsRoom;
pub use rooms::motion::edits::{MotionEdits, MotionView};
pub use rooms::motion::motion_room::MotionRoom;
pub use rooms::rooms::{KeptRooms, RoomName};
pub use rooms::scene::edits::{Comparison, SceneEdits, SceneLamp};
pub use rooms::scene::probe::{Vertex, transfer_of, vertex_under};
pub use rooms::scene::scene_room::SceneRoom;
pub use rooms::sky::edits::{OwnCoefficient, Shelf, SkyEdits};
pub use rooms::sky::sky_room::SkyRoom;
pub use rooms::taming::Taming;
pub use widgets::gpu::Gpu;
pub use widgets::history::Step;
pub use widgets::orbit::Orbit;

/// The program in a page of a browser, where it has no command line.
#[cfg(target_arch = "wasm32")]
#[must_use]
pub fn main() -> ExitCode {
    app::page::open();
    ExitCode::SUCCESS
}

/// The program: reads the command line, and opens a window or works without one. Errors are one line, and exit code 2.
#[cfg(not(target_arch = "wasm32"))]
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match cli::args::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return cli::failure::usage(&error),
    };
    if let Err(error) = cli::environment::check() {
        return cli::failure::say(&error);
    }
    let ended = match (&arguments.headless, &arguments.output) {
        (Some(scene), Some(output)) => cli::headless::run(&arguments, scene, output),
        _ if arguments.bench => cli::bench::run(&arguments),
        _ => app::window::open(&arguments.files, arguments.limits, (&arguments.suns, arguments.surfaces)),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => cli::failure::say(&error.to_string()),
    }
}
