//! Pictures and times without a window: what a program needs that renders to files.
//!
//! Read `turntable`, then `bench`. Uses `scene_view` and `renderer`.

pub(crate) mod bench;
pub(crate) mod turntable;
