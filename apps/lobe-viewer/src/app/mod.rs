//! The window: the bar above the rooms, what it remembers, and the keys.
//!
//! Read `kept`, then `bar` and `help`, `exports`, `viewer_app`, and `window`, which opens it. Uses `loading`, `rooms` and `widgets`.

pub(crate) mod bar;
pub(crate) mod exports;
pub(crate) mod help;
pub(crate) mod kept;
pub(crate) mod viewer_app;
pub(crate) mod window;
