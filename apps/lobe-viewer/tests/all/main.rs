//! The viewer without a window: controls pressed by their names, and the numbers on the screen against the library's.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod command;
mod device;
mod drops;
mod exports;
mod functions;
mod kept;
mod motion;
mod moving_pictures;
mod orbit;
mod scene;
mod sky;
mod task;
mod wait;
