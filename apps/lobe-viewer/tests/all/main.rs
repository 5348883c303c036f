//! The viewer without a window: controls pressed by their names, and the numbers on the screen against the library's.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod command;
mod device;
mod drops;
mod exports;
mod formulas;
mod functions;
mod kept;
mod looks;
mod motion;
mod motion_numbers;
mod mouse;
mod moving_pictures;
mod orbit;
mod pace;
mod press;
mod scene;
mod sky;
mod sky_numbers;
mod still_pictures;
mod task;
mod wait;
