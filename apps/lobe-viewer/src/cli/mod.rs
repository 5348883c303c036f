//! The command line: what opens a window, and what renders and measures without one.
//!
//! Read `args`, then `shown`, what lights the surfaces, and `prepared`, which makes a scene ready for a device, `headless` and `moving`,
//! `bench` and `exponentials`, `progress`, `environment` and `failure`. Uses `loading`.

pub(crate) mod args;
pub(crate) mod bench;
pub(crate) mod environment;
pub(crate) mod exponentials;
pub(crate) mod failure;
pub(crate) mod headless;
pub(crate) mod moving;
pub(crate) mod prepared;
pub(crate) mod progress;
pub(crate) mod shown;
