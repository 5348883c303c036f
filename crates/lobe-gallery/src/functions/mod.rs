//! Sections about functions on the sphere, a file for each topic.
//!
//! `basis` shows the functions themselves, `lights` lights with closed forms and `skies` those of the sky. `ringing` is light
//! below zero, `windows` what calms it. Uses `page`.

pub(crate) mod basis;
pub(crate) mod lights;
pub(crate) mod ringing;
pub(crate) mod skies;
pub(crate) mod windows;
