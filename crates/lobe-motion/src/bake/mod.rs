//! Baking of what parts lack (`moving_bake`), what is taken over from files (`keep_transfer`), and the space that the
//! others pass through (`swept_box`). Uses `baked` and `scene`.

pub(crate) mod keep_transfer;
pub(crate) mod moving_bake;
pub(crate) mod swept_box;
