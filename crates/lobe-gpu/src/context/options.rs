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
    /// The one that takes the least power.
    LeastPower,
    /// A program on the processor, such as Mesa's llvmpipe: slow, and the same on every machine.
    Software,
}

/// Which interface of the system to go through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Interface {
    /// What the system has: Vulkan, Metal or Direct3D 12 before OpenGL.
    #[default]
    Any,
    /// Vulkan.
    Vulkan,
    /// OpenGL or OpenGL ES.
    Gl,
    /// Metal.
    Metal,
    /// Direct3D 12.
    Dx12,
}

/// Options of [`Context::new`](crate::Context::new).
#[derive(Clone, Debug, Default, PartialEq, Setters)]
#[setters(strip_option)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct ContextOptions {
    /// The adapter. Default: [`AdapterChoice::Fastest`].
    pub adapter: AdapterChoice,
    /// The interface. Default: [`Interface::Any`].
    pub interface: Interface,
    /// The most bytes of one storage binding, where fewer than the device's limit: what is larger is split over several
    /// dispatches. For tests, and to leave memory to others. Default: the limit of the device.
    pub max_storage_binding: Option<u64>,
    /// The most texels along a side of a texture, where fewer than the device's limit. For tests. Default: the limit of the device.
    pub max_texture_side: Option<u32>,
    /// Do without storage buffers and compute shaders, as WebGL 2 has to: surfaces are lit by transfer in textures. For tests; devices
    /// that have none are used so in any case. Default: false.
    pub without_storage: bool,
}

impl Interface {
    /// What is asked for an adapter, one after the other. OpenGL is not even opened where another has a device that no program emulates:
    /// NVIDIA's driver 580 came to a halt where it was closed in one thread and a Vulkan device in another.
    pub(crate) fn backends(self) -> &'static [wgpu::Backends] {
        match self {
            Self::Any => &[wgpu::Backends::PRIMARY, wgpu::Backends::GL],
            Self::Vulkan => &[wgpu::Backends::VULKAN],
            Self::Gl => &[wgpu::Backends::GL],
            Self::Metal => &[wgpu::Backends::METAL],
            Self::Dx12 => &[wgpu::Backends::DX12],
        }
    }
}
