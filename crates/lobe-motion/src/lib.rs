//! Scenes that move, lit at any moment: rigid parts, parts that bend, and lamps, over what stands still.
//!
//! Each part hides the sky from the others by a field of visibility around it or by a few spheres that follow it.
//! What stands still is baked once, as transfer; `lobe-shadow` accumulates the shadows over it.
//!
//! | purpose | item |
//! |---|---|
//! | what is asked of a scene that moves as one value | [`MovingJob`], [`ReadMoving`] |
//! | scenes that move | [`MovingScene`], its [`MovingPart`]s and [`MovingLamp`]s, [`Moment`], [`Moments`] |
//! | what is baked of them | [`MovingBakeOptions`], [`PartBake`], [`KeptVertices`]; what stands still in a room [`VisibilityGrid`] |
//! | finer triangles for shadows | [`MovingSplitOptions`], [`MovingSplitReport`] |
//! | light of a moment | [`MovingShading`] by [`MovingOptions`] and a [`MovingMethod`]; its picture by [`light_moving_scene`] |
//! | receivers of a part and what hides the sky from them | [`PartReceivers`], [`PartObstacles`] |
//!
//! The reference of a moment is [`render_truth`](lobe_render::render_truth) of [`Moment::scene`]. Errors are those of
//! `lobe-render`. Results do not depend on the number of threads.

mod bake;
mod baked;
mod files;
mod light;
mod moving_job;
mod moving_options;
mod scene;
mod split;

pub use bake::keep_transfer::KeptVertices;
pub use bake::moving_bake::{MovingBakeOptions, PartBake, PartBakeKind};
pub use baked::visibility_grid::{VisibilityGrid, VisibilityGridOptions};
pub use light::moving_picture::{light_moving_scene, light_moving_surfaces};
pub use light::moving_shading::MovingShading;
pub use light::part_obstacles::{PartObstacles, PartReceivers};
pub use moving_job::{BakeOne, MovingJob, OneBake, ReadMoving};
pub use moving_options::{MovingMethod, MovingOptions};
pub use scene::moment::Moment;
pub use scene::moments::Moments;
pub use scene::moving_lamp::MovingLamp;
pub use scene::moving_part::{Motion, MovingPart};
pub use scene::moving_scene::MovingScene;
pub use split::split_parts::{MovingSplitOptions, MovingSplitReport, SplitCounts};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
