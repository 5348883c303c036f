//! Number formats on the device.

/// How numbers are stored on the device; shaders compute with single precision in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Storage {
    /// Single precision.
    #[default]
    F32,
    /// Half precision: half of the memory and of the bytes that are moved, eleven bits. Transfer of order 4 stored so changes
    /// the exit radiance by up to 3e-4 of its largest value (test `half_precision_costs_what_is_said`); numbers above
    /// 65504 become 65504. No feature of the device is needed.
    F16,
}
