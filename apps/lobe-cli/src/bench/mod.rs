//! `lobe bench`: the kernels on the user's own machine, each beside the time that its arithmetic or its bytes need at least.
//!
//! Read `floors` first, what the machine does at most, and `cost`, what a job needs of that; `measure` times a job by the `clock`, `functions`,
//! `pictures`, `lights`, `receivers` and `paths` are the jobs, and `bench` is the command. Uses `args` and `run`.

#[expect(clippy::module_inception, reason = "a room is named for its topic, and its main file too")]
pub(crate) mod bench;
pub(crate) mod clock;
pub(crate) mod cost;
pub(crate) mod floors;
pub(crate) mod functions;
pub(crate) mod lights;
pub(crate) mod measure;
pub(crate) mod paths;
pub(crate) mod pictures;
pub(crate) mod receivers;
