//! The rooms of the application, each with its controls beside what they change.
//!
//! Read `background`, what is behind a scene, `curve`, which shows light, `taming`, what ends the ringing of an expansion, `light`, what all rooms
//! do to a light, `steer`, how a hand changes it and the camera, `truth_light` and `truth`, what pictures are compared
//! with, and `formulas`, a table of what is computed, then `room`, what a room can, and `rooms`, the list of them:
//! `scene`, a baked scene under a turning sky; `sky`, an environment and its expansions; `functions`, functions on the sphere; `motion`,
//! what moves. Uses `loading` and `widgets`.

pub(crate) mod background;
pub(crate) mod curve;
pub(crate) mod formulas;
pub(crate) mod functions;
pub(crate) mod light;
pub(crate) mod motion;
pub(crate) mod room;
pub(crate) mod rooms;
pub(crate) mod scene;
pub(crate) mod sky;
pub(crate) mod steer;
pub(crate) mod taming;
pub(crate) mod truth;
pub(crate) mod truth_light;
