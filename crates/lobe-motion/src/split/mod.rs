//! Splitting: of what stands still under shadows that move (`split_parts`), and of what moves (`split_moving`). Uses
//! `scene`.

pub(crate) mod split_moving;
pub(crate) mod split_parts;
