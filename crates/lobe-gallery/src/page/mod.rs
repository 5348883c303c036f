//! The page: what sections draw on, and what they share.
//!
//! Read `canvas` first, on which a section writes words and pictures. It makes the page by `html` in a `size`. `sky` is a
//! photograph with its expansion, `plots` are figures of lines, `numbers` are those of tables. Uses no other room.

mod canvas;
mod html;
mod numbers;
mod plots;
mod size;
mod sky;

pub(crate) use canvas::{Canvas, sheet};
pub(crate) use html::State;
pub(crate) use numbers::{digits, percent};
pub(crate) use plots::{BLACK, BLUE, GRAY, GREEN, ORANGE, RED};
pub use size::Size;
pub(crate) use sky::{BACKDROP, SWEEP, Sky, ball_from, energy, relative, values_like};
