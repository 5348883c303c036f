//! Files of scenes that move: descriptions (`read_moving`) and the files that they name for a part (`part_files`). Uses
//! `scene`.

pub(crate) mod part_files;
pub(crate) mod read_moving;
