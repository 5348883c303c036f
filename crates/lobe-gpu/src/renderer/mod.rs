//! Everything that a device is asked to do: shaders put together from modules, and named passes in an order that can be
//! printed.
//!
//! Read `shader`, `kernel` and `drawing`, which become programs on the device, then `pass`, `resource` and `step`, a pass with what it
//! binds, `renderer`, which holds buffers and textures by name and runs the passes, and `pieces`, which cuts passes over many items where
//! a device binds too little at once. Uses `context`.

pub(crate) mod drawing;
pub(crate) mod kernel;
pub(crate) mod pass;
pub(crate) mod pieces;
pub(crate) mod renderer;
pub(crate) mod resource;
pub(crate) mod shader;
pub(crate) mod step;
