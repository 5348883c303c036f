//! Sections about scenes, at rest and moving, beside paths of light.
//!
//! Read `look` first, what a camera sees of a scene, by transfer and by paths. `hall` is a scene at rest, that `transfer`
//! shows under a sky that turns and `transfer_ringing` under one that rings. `stage` holds what moves, for `motion` and
//! `walking`. Uses `page`.

pub(crate) mod hall;
pub(crate) mod look;
pub(crate) mod motion;
pub(crate) mod stage;
pub(crate) mod transfer;
pub(crate) mod transfer_ringing;
pub(crate) mod walking;
