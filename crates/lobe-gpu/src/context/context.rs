//! A device without a window.

use std::sync::{Arc, Mutex};

use crate::context::locked;
use crate::context::options::{AdapterChoice, ContextOptions};
use crate::context::programs::Programs;
use crate::error::GpuError;

/// A graphics device, its queue, its limits, and what went wrong on it.
///
/// Nothing here panics when a device is lost or refuses work: what it reports is kept, and the next call that returns a
/// [`GpuError`] returns it. Clones share the device, and the programs that were compiled for it.
///
/// ```no_run
/// use lobe_gpu::{Context, ContextOptions};
///
/// let context = Context::new(&ContextOptions::default())?;
/// println!("textures of up to {} texels a side", context.max_texture_side());
/// # Ok::<(), lobe_gpu::GpuError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Context {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    max_storage_binding: u64,
    max_texture_side: u32,
    /// Whether shaders of the adapter read buffers, and compute.
    is_whole: bool,
    has_storage: bool,
    light_format: wgpu::TextureFormat,
    faults: Arc<Mutex<Faults>>,
    kernels: Programs<wgpu::ComputePipeline>,
    drawings: Programs<wgpu::RenderPipeline>,
}

/// What the device reported.
#[derive(Debug, Default)]
struct Faults {
    /// That it was lost, which it remains.
    lost: Option<String>,
    /// The first work that it refused since [`Context::check`] was called last.
    refused: Option<String>,
}

impl Context {
    /// Opens a device.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] if no adapter fits, [`GpuError::Device`] if it cannot be opened.
    pub fn new(options: &ContextOptions) -> Result<Self, GpuError> {
        pollster::block_on(Self::open(options))
    }

    async fn open(options: &ContextOptions) -> Result<Self, GpuError> {
        let adapter = adapter(options).await?;
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("lobe"),
            required_features: adapter.features() & Self::optional_features(),
            required_limits: adapter.limits(),
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|error| GpuError::device(&info.name, error))?;
        let single = adapter.get_texture_format_features(wgpu::TextureFormat::Rgba32Float).allowed_usages;
        let is_single = single.contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
        Ok(Self::watch((device, queue, info), is_whole(&adapter), is_single, options))
    }

    /// A context around a device of this adapter that another library opened, such as the one of a window.
    ///
    /// [`Context::optional_features`] are used where they are on. Errors that the device reports go to this context from now on.
    #[must_use]
    pub fn of_device(
        adapter: &wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
        options: &ContextOptions,
    ) -> Self {
        let info = device.adapter_info();
        // Only OpenGL does not draw single precision everywhere.
        let is_single = info.backend != wgpu::Backend::Gl;
        Self::watch((device, queue, info), is_whole(adapter), is_single, options)
    }

    fn watch(
        (device, queue, info): (wgpu::Device, wgpu::Queue, wgpu::AdapterInfo),
        is_whole: bool,
        is_single: bool,
        options: &ContextOptions,
    ) -> Self {
        let faults = Arc::new(Mutex::new(Faults::default()));
        let kept = faults.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            locked(&kept).refused.get_or_insert(error.to_string());
        }));
        let kept = faults.clone();
        device.set_device_lost_callback(move |reason, message| {
            locked(&kept).lost.get_or_insert(format!("device lost, {reason:?}: {message}"));
        });
        let light_format = if is_single { wgpu::TextureFormat::Rgba32Float } else { wgpu::TextureFormat::Rgba16Float };
        let (kernels, drawings) = Default::default();
        let (max_storage_binding, max_texture_side, has_storage) = limits(&device, is_whole, options);
        Self {
            device,
            queue,
            info,
            max_storage_binding,
            max_texture_side,
            is_whole,
            has_storage,
            light_format,
            faults,
            kernels,
            drawings,
        }
    }

    /// The same device with the limits of these options, for tests; what it reports goes to both contexts.
    #[must_use]
    pub fn limited(&self, options: &ContextOptions) -> Self {
        let (max_storage_binding, max_texture_side, has_storage) = limits(&self.device, self.is_whole, options);
        Self { max_storage_binding, max_texture_side, has_storage, ..self.clone() }
    }

    /// What this crate uses where a device has it: times of passes.
    #[must_use]
    pub fn optional_features() -> wgpu::Features {
        wgpu::Features::TIMESTAMP_QUERY
    }

    /// The device.
    #[must_use]
    pub(crate) fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue of the device.
    #[must_use]
    pub(crate) fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// One line for people: the adapter, its kind, the interface, the driver.
    #[must_use]
    pub(crate) fn describe(&self) -> String {
        let wgpu::AdapterInfo { name, device_type, backend, driver_info, .. } = &self.info;
        format!("{name} ({device_type:?}, {backend:?}, {driver_info})")
    }

    /// Whether a program on the processor emulates the device.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// The most bytes that one storage binding can have.
    #[must_use]
    pub(crate) fn max_storage_binding(&self) -> u64 {
        self.max_storage_binding
    }

    /// The most texels along a side of a texture.
    #[must_use]
    pub fn max_texture_side(&self) -> u32 {
        self.max_texture_side
    }

    /// Whether shaders read storage buffers, and compute. Where they do not, as in WebGL 2, scenes are lit by [transfer vectors at
    /// vertices](crate::SurfaceShading::Vertices), irradiance or given radiance, and everything else is [`GpuError::Unsupported`].
    #[must_use]
    pub fn has_storage(&self) -> bool {
        self.has_storage
    }

    /// Refuses work that needs storage buffers where there are none.
    pub(crate) fn expect_storage(&self, name: &str) -> Result<(), GpuError> {
        if self.has_storage {
            return Ok(());
        }
        let message =
            "expected storage buffers and compute shaders, found none: take another adapter or interface".into();
        Err(GpuError::Unsupported { place: name.into(), message })
    }

    /// The format in which pictures of light are drawn: `Rgba32Float`, or `Rgba16Float` on devices that cannot draw that, as OpenGL
    /// often. Light above 65504 is infinite there, and colors have eleven bits.
    #[must_use]
    pub fn light_format(&self) -> wgpu::TextureFormat {
        self.light_format
    }

    /// What went wrong on the device: its loss at any time, or work it refused since this was asked last.
    ///
    /// # Errors
    /// [`GpuError::Device`] with the first thing that the device reported.
    pub fn check(&self) -> Result<(), GpuError> {
        let mut faults = locked(&self.faults);
        let refused = faults.refused.take();
        let fault = faults.lost.clone().or(refused);
        fault.map_or(Ok(()), |message| Err(GpuError::device(&self.info.name, message)))
    }

    /// Whether the device was lost, which it remains: everything on it is gone, and a program opens another. Does not wait.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        // Reports come when the device is asked; that it cannot be asked any more is said below.
        let asked = self.device.poll(wgpu::PollType::Poll);
        drop(asked);
        locked(&self.faults).lost.is_some()
    }

    /// The compute programs.
    pub(crate) fn kernels(&self) -> &Programs<wgpu::ComputePipeline> {
        &self.kernels
    }

    /// The programs that draw triangles.
    pub(crate) fn drawings(&self) -> &Programs<wgpu::RenderPipeline> {
        &self.drawings
    }

    /// Waits until the device has done all that was submitted.
    ///
    /// # Errors
    /// As [`Context::check`].
    pub fn wait(&self) -> Result<(), GpuError> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited.map(drop).map_err(|error| GpuError::device(&self.info.name, error))
    }
}

/// The most bytes of a storage binding and texels along a side of a texture, and whether shaders read buffers.
fn limits(device: &wgpu::Device, is_whole: bool, options: &ContextOptions) -> (u64, u32, bool) {
    let limits = device.limits();
    let bytes = limits.max_storage_buffer_binding_size;
    let side = limits.max_texture_dimension_2d;
    (
        options.max_storage_binding.map_or(bytes, |most| most.min(bytes)),
        options.max_texture_side.map_or(side, |most| most.min(side)),
        is_whole && !options.without_storage && limits.max_compute_workgroups_per_dimension > 0,
    )
}

/// Whether shaders of an adapter compute, and those of vertices and pixels read buffers: some of OpenGL ES only compute.
fn is_whole(adapter: &wgpu::Adapter) -> bool {
    let needed = wgpu::DownlevelFlags::COMPUTE_SHADERS
        | wgpu::DownlevelFlags::VERTEX_STORAGE
        | wgpu::DownlevelFlags::FRAGMENT_STORAGE;
    adapter.get_downlevel_capabilities().flags.contains(needed)
}

/// Interfaces that are asked for an adapter, one after the other: Vulkan, Metal or Direct3D 12 before OpenGL. OpenGL is
/// not even opened where another has a device that no program emulates: NVIDIA's driver 580 came to a halt where it was
/// closed in one thread and a Vulkan device in another.
const INTERFACES: [wgpu::Backends; 2] = [wgpu::Backends::PRIMARY, wgpu::Backends::GL];

/// The adapter that is asked for: of the first interface that has one, but rather a device of another than a program that emulates one.
async fn adapter(options: &ContextOptions) -> Result<wgpu::Adapter, GpuError> {
    let is_software = options.adapter == AdapterChoice::Software;
    let (mut emulated, mut refusals) = (None, Vec::new());
    for backends in INTERFACES {
        match adapter_of(backends, is_software).await {
            Ok(adapter) if is_software || adapter.get_info().device_type != wgpu::DeviceType::Cpu => {
                return Ok(adapter);
            }
            Ok(adapter) => {
                emulated.get_or_insert(adapter);
            }
            Err(error) => refusals.push(error.to_string()),
        }
    }
    emulated.ok_or_else(|| GpuError::NoAdapter(refusals.join("; ")))
}

async fn adapter_of(backends: wgpu::Backends, is_software: bool) -> Result<wgpu::Adapter, wgpu::RequestAdapterError> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    let wanted = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        force_fallback_adapter: is_software,
        compatible_surface: None,
        ..Default::default()
    };
    wgpu::Instance::new(descriptor).request_adapter(&wanted).await
}
