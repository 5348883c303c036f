//! Arguments that several commands share: inputs, outputs, numbers and limits, with their checks.
//!
//! `values` parses numbers, `exponential` names of exponentials. `job_args` makes options of the table of a job. `input`,
//! `map_input`, `scene_input` (which `open_scene` opens) and `transfer_input` open files. `output`, `map_output` and
//! `picture` check and write them; `fisheye` is how `map_input` reads some. `compression`, `field_storage`, `memory`,
//! `scene_limits`, `sharing` and `turn` are options, `names` declares the values of others. Uses `run`.

pub(crate) mod compression;
pub(crate) mod exponential;
pub(crate) mod field_storage;
pub(crate) mod fisheye;
pub(crate) mod input;
pub(crate) mod job_args;
pub(crate) mod map_input;
pub(crate) mod map_output;
pub(crate) mod memory;
pub(crate) mod names;
pub(crate) mod open_scene;
pub(crate) mod output;
pub(crate) mod picture;
pub(crate) mod scene_input;
pub(crate) mod scene_limits;
pub(crate) mod scene_pose;
pub(crate) mod sharing;
pub(crate) mod transfer_input;
pub(crate) mod turn;
pub(crate) mod values;
pub(crate) mod vertex_budget;
