//! The window: the bar above the rooms, what it remembers, and the keys.
//!
//! Read `kept`, then `bar` and `help`, `exports`, `drops`, `viewer_app`, and `window`, which opens it; in a browser `page` and `page_drops`
//! stand in for `window` and `drops`. Uses `loading`, `rooms` and `widgets`.

pub(crate) mod bar;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) mod drops;
pub(crate) mod exports;
pub(crate) mod help;
pub(crate) mod kept;
#[cfg(target_arch = "wasm32")]
pub(crate) mod page;
#[cfg(target_arch = "wasm32")]
pub(crate) mod page_drops;
pub(crate) mod viewer_app;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) mod window;
