//! Pictures and times without a window: what a program needs that renders to files.
//!
//! Read `turning_light`, then `turntable` and `bench`. Uses `context`, `renderer` and `scene_view`.

pub(crate) mod bench;
pub(crate) mod turning_light;
pub(crate) mod turntable;
