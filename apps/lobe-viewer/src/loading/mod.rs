//! Files, built-in scenes and bakes, off the thread of the window: with progress, to be cancelled, with errors in one line.
//!
//! Read `place`, which says whether there are threads and files at all, `task`, which runs work beside the window,
//! `limits`, what files may ask for, and `file_kind`, what they are, then `mode`, the ways to light a scene,
//! `scene_source`, `moving_source` and `sky_source`, which say where things are and read them, `shrunk`, skies for
//! devices of small textures, `backdrop`, what is behind a scene, `bake` with `places`, what transfer is of,
//! `kept_transfer`, which reads it, and `adopt`, which gives it to the scene that is open, `suns`, which stand beside
//! an expansion, `materials`, `moving_bakes` and `moving_light`, `cache`, where bakes of built-in scenes are kept, and
//! `export`, which goes the other way: pictures to files. Uses no other room.

pub(crate) mod adopt;
pub(crate) mod backdrop;
pub(crate) mod bake;
pub(crate) mod cache;
pub(crate) mod export;
pub(crate) mod file_kind;
pub(crate) mod kept_transfer;
pub(crate) mod limits;
pub(crate) mod materials;
pub(crate) mod mode;
pub(crate) mod moving_bakes;
pub(crate) mod moving_light;
pub(crate) mod moving_source;
pub(crate) mod place;
pub(crate) mod places;
pub(crate) mod scene_source;
pub(crate) mod shrunk;
pub(crate) mod sky_source;
pub(crate) mod suns;
pub(crate) mod task;
