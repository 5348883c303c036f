//! A bake as a job: all that is asked for as one value, which a file can hold, and all that is done for it.
//!
//! Read `bake_job` first, the options and what they exclude; then `open_bake`, the scene that is read, split along long
//! edges and, by `lightmap_scene`, unwrapped; `prepared_bake`, what is baked where and the file that waits for it; and
//! `run`, from the first to the last. `like` is the job of a file that was baked. Uses `bake`, `bake_work`, `compression`, `files`, `finishing`, `fit`, `receivers`, `recipe` and `transfer`.

#[expect(clippy::module_inception, reason = "the type of the room")]
pub(crate) mod bake_job;
pub(crate) mod lightmap_scene;
pub(crate) mod like;
pub(crate) mod open_bake;
pub(crate) mod prepared_bake;
pub(crate) mod run;
