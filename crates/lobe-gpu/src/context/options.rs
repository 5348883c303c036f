//! The choice of a device.

use derive_setters::Setters;

/// Which adapter of the machine to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum AdapterChoice {
    /// The fastest; a program that emulates one if there is no other.
    #[default]
    Fastest,
    /// A program on the processor, such as Mesa's llvmpipe: slow, and the same on every machine.
    Software,
}

/// Options of [`Context::new`](crate::Context::new).
#[derive(Clone, Debug, Default, PartialEq, Setters)]
#[setters(strip_option)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct ContextOptions {
    /// The adapter. Default: [`AdapterChoice::Fastest`].
    pub adapter: AdapterChoice,
    /// The most bytes of one storage binding, where fewer than the device's limit: what is larger is split over several
    /// dispatches. For tests, and to leave memory to others. Default: the limit of the device.
    pub max_storage_binding: Option<u64>,
    /// The most texels along a side of a texture, where fewer than the device's limit. For tests. Default: the limit of the device.
    pub max_texture_side: Option<u32>,
    /// Do without storage buffers and compute shaders, as WebGL 2 has to: surfaces are lit by transfer in textures. For tests; devices
    /// that have none are used so in any case. Default: false.
    pub without_storage: bool,
}
