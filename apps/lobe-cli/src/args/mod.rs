//! Arguments that several commands share: inputs, outputs, numbers and limits, with their checks.
//!
//! `values` parses numbers. `asked_job` takes the options of a job from a file or the command line. `input`,
//! `map_input`, `scene_input` and `transfer_input` open files. `output`, `map_output` and
//! `picture` check and write them; `fisheye` is how `map_input` reads some. `number_file` and `npy` are numbers of
//! other libraries. `memory`, `scene_limits`, `sharing` and `turn` are options, `names` declares the values of others.
//! Uses `run`.

pub(crate) mod asked_job;
pub(crate) mod fisheye;
pub(crate) mod input;
pub(crate) mod map_input;
pub(crate) mod map_output;
pub(crate) mod memory;
pub(crate) mod names;
mod npy;
pub(crate) mod number_file;
pub(crate) mod output;
pub(crate) mod picture;
pub(crate) mod scene_input;
pub(crate) mod scene_limits;
pub(crate) mod scene_pose;
pub(crate) mod sharing;
pub(crate) mod transfer_input;
pub(crate) mod turn;
pub(crate) mod values;
