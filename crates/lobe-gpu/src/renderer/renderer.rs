//! The renderer: buffers and textures by name, and passes over them in an order that is data.

use std::collections::BTreeMap;
use std::fmt;

use bytemuck::{NoUninit, Pod};
use lobe_image::Picture;

use crate::context::context::Context;
use crate::error::GpuError;
use crate::renderer::kernel::Slot;
use crate::renderer::pass::{Pass, Use, Work};
use crate::renderer::resource::{Bound, Kind, Resource};
use crate::renderer::step::{Step, encode};

/// What shaders read and write may also be attributes of vertices.
const STORAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::VERTEX);

/// Passes over named buffers and textures of one device.
///
/// Modules of this crate add their passes to it, in the order in which they run. Printed, it is a table of them: what each
/// reads and what it writes. A pass that reads what nothing wrote is refused when it is added.
///
/// Resources are uploaded, or made for a pass to write; the content of an uploaded one can be replaced between two
/// runs, which is how light turns without anything else being done again.
#[derive(Debug)]
pub struct Renderer {
    context: Context,
    resources: BTreeMap<String, Resource>,
    steps: Vec<Step>,
}

/// What one pass took; see [`Renderer::run_timed`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PassTime {
    /// The name of the pass.
    pub name: String,
    /// On the device; `None` where it measures no times. A device that a program emulates (llvmpipe) takes the time of the pixels alone:
    /// compute and vertices have run before, and are in the time of a frame only.
    pub milliseconds: Option<f64>,
    /// The bytes of everything the pass binds or draws into, each once: a floor of what it moves if it needs all of
    /// them.
    pub bytes: u64,
}

impl Renderer {
    /// A renderer without passes.
    #[must_use]
    pub(crate) fn new(context: &Context) -> Self {
        Self { context: context.clone(), resources: BTreeMap::new(), steps: Vec::new() }
    }

    /// The device.
    #[must_use]
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The passes in the order in which they run.
    pub(crate) fn passes(&self) -> impl Iterator<Item = &Pass> {
        self.steps.iter().map(|step| &step.pass)
    }

    /// Runs all passes. Does not wait for the device.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device was lost or refused work before.
    pub(crate) fn run(&self) -> Result<(), GpuError> {
        self.submit(None)
    }

    /// Runs all passes, waits for them, and says what each took.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device was lost or refused work.
    pub fn run_timed(&self) -> Result<Vec<PassTime>, GpuError> {
        let device = self.context.device();
        let count = 2 * self.steps.len() as u32;
        let has_times = device.features().contains(wgpu::Features::TIMESTAMP_QUERY) && count > 0;
        let queries = has_times.then(|| {
            let descriptor = wgpu::QuerySetDescriptor { label: Some("times"), ty: wgpu::QueryType::Timestamp, count };
            device.create_query_set(&descriptor)
        });
        self.submit(queries.as_ref())?;
        let ticks: Option<Vec<u64>> = match &queries {
            Some(queries) => Some(self.ticks(queries, count)?),
            None => None,
        };
        self.context.wait()?;
        let period = f64::from(self.context.queue().get_timestamp_period());
        let time = |i: usize| ticks.as_ref().map(|t| 1e-6 * period * t[2 * i + 1].saturating_sub(t[2 * i]) as f64);
        let steps = self.steps.iter().enumerate();
        Ok(steps
            .map(|(i, step)| PassTime { name: step.pass.name.clone(), milliseconds: time(i), bytes: step.bytes })
            .collect())
    }

    fn ticks(&self, queries: &wgpu::QuerySet, count: u32) -> Result<Vec<u64>, GpuError> {
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = self.context.empty("times", 8 * u64::from(count), usage)?;
        let mut encoder = self.context.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.resolve_query_set(queries, 0..count, &resolved, 0);
        self.context.queue().submit([encoder.finish()]);
        self.context.read(&resolved, count as usize)
    }

    fn submit(&self, times: Option<&wgpu::QuerySet>) -> Result<(), GpuError> {
        let device = self.context.device();
        // What is refused here is this renderer's fault, and no other's.
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encode(&self.steps, &mut encoder, times);
        self.context.queue().submit([encoder.finish()]);
        if let Some(error) = pollster::block_on(scope.pop()) {
            // That of a device that is lost is a consequence.
            self.context.check()?;
            return Err(GpuError::device("passes", error));
        }
        self.context.check()
    }

    /// The first `count` numbers of a buffer, after the passes. Waits for the device.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there is no such buffer or it is shorter; [`GpuError::Device`] if the device was lost or refused
    /// work.
    pub(crate) fn read<T: Pod>(&self, name: &str, count: usize) -> Result<Vec<T>, GpuError> {
        self.context.read(self.resource(name)?.buffer()?, count)
    }

    /// The picture in a texture of light, after the passes. Waits for the device.
    ///
    /// # Errors
    /// As [`Renderer::read`].
    pub(crate) fn picture(&self, name: &str) -> Result<Picture, GpuError> {
        self.context.picture(self.resource(name)?.texture()?)
    }

    /// The texels of a texture, after the passes, each as a `T` of the size of its format. Waits for the device.
    ///
    /// # Errors
    /// As [`Renderer::read`].
    pub(crate) fn texels<T: Pod>(&self, name: &str) -> Result<Vec<T>, GpuError> {
        self.context.read_texture(self.resource(name)?.texture()?)
    }

    /// Replaces the first numbers of an uploaded buffer, for the runs after this.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there is no such buffer or it is shorter.
    pub(crate) fn update<T: NoUninit>(&self, name: &str, numbers: &[T]) -> Result<(), GpuError> {
        self.update_at(name, 0, numbers)
    }

    /// Replaces numbers of an uploaded buffer from the `first` on, for the runs after this.
    pub(crate) fn update_at<T: NoUninit>(&self, name: &str, first: usize, numbers: &[T]) -> Result<(), GpuError> {
        let (buffer, bytes) = (self.resource(name)?.buffer()?, bytemuck::cast_slice(numbers));
        let begin = (first * size_of::<T>()) as u64;
        if begin + bytes.len() as u64 > buffer.size() {
            let found = begin + bytes.len() as u64;
            return Err(GpuError::Options(format!(
                "expected at most {} bytes for {name}, found {found}",
                buffer.size()
            )));
        }
        self.context.queue().write_buffer(buffer, begin, bytes);
        Ok(())
    }

    /// Copies the first bytes of a buffer of another renderer of this device, after the passes of that one, to the buffer of the same
    /// name here, `at` so many bytes from its begin, for the runs after this.
    pub(crate) fn copy_from(&self, other: &Self, name: &str, bytes: u64, at: u64) -> Result<(), GpuError> {
        let (from, to) = (other.resource(name)?.buffer()?, self.resource(name)?.buffer()?);
        let scope = self.context.device().push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = self.context.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(from, 0, to, at, bytes);
        self.context.queue().submit([encoder.finish()]);
        if let Some(error) = pollster::block_on(scope.pop()) {
            self.context.check()?;
            return Err(GpuError::device(name, error));
        }
        self.context.check()
    }

    pub(crate) fn upload<T: NoUninit>(&mut self, name: &str, numbers: &[T]) -> Result<(), GpuError> {
        let usage = if self.context.has_storage() { STORAGE } else { wgpu::BufferUsages::VERTEX };
        let usage = usage | wgpu::BufferUsages::COPY_SRC;
        let buffer = self.context.upload(name, bytemuck::cast_slice(numbers), usage)?;
        self.insert(name, Kind::Buffer(buffer), true)
    }

    /// The indices of a draw pass.
    pub(crate) fn upload_indices(&mut self, name: &str, indices: &[u32]) -> Result<(), GpuError> {
        let buffer = self.context.upload(name, bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX)?;
        self.insert(name, Kind::Buffer(buffer), true)
    }

    pub(crate) fn uniform<T: NoUninit>(&mut self, name: &str, value: &T) -> Result<(), GpuError> {
        let bytes = bytemuck::bytes_of(value);
        let buffer = self.context.upload(name, bytes, wgpu::BufferUsages::UNIFORM)?;
        self.insert(name, Kind::Buffer(buffer), true)
    }

    /// Constants of which there are many, whole vectors of them.
    pub(crate) fn uniform_list(&mut self, name: &str, numbers: &[f32]) -> Result<(), GpuError> {
        let buffer = self.context.upload(name, bytemuck::cast_slice(numbers), wgpu::BufferUsages::UNIFORM)?;
        self.insert(name, Kind::Buffer(buffer), true)
    }

    /// A storage buffer for passes to write.
    pub(crate) fn allocate(&mut self, name: &str, bytes: u64) -> Result<(), GpuError> {
        self.context.expect_storage(name)?;
        let usage = STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer = self.context.empty(name, bytes, usage)?;
        self.insert(name, Kind::Buffer(buffer), false)
    }

    /// A texture for passes to draw into and to read.
    pub(crate) fn target(&mut self, name: &str, size: [u32; 2], format: wgpu::TextureFormat) -> Result<(), GpuError> {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let texture = self.new_texture(name, size, (format, 1), usage)?;
        self.insert(name, Kind::Texture(texture), false)
    }

    /// A texture of so many samples a texel, for passes to draw into.
    pub(crate) fn target_of_samples(
        &mut self,
        name: &str,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        samples: u32,
    ) -> Result<(), GpuError> {
        let texture = self.new_texture(name, size, (format, samples), wgpu::TextureUsages::RENDER_ATTACHMENT)?;
        self.insert(name, Kind::Texture(texture), false)
    }

    /// A texture with these texels, row after row.
    pub(crate) fn upload_texture<T: NoUninit>(
        &mut self,
        name: &str,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        texels: &[T],
    ) -> Result<(), GpuError> {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = self.new_texture(name, size, (format, 1), usage)?;
        let [width, height] = size;
        let row = width * size_of::<T>() as u32;
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let bytes = bytemuck::cast_slice(texels);
        self.context.queue().write_texture(texture.as_image_copy(), bytes, layout, extent);
        self.insert(name, Kind::Texture(texture), true)
    }

    fn new_texture(
        &self,
        name: &str,
        [width, height]: [u32; 2],
        (format, sample_count): (wgpu::TextureFormat, u32),
        usage: wgpu::TextureUsages,
    ) -> Result<wgpu::Texture, GpuError> {
        let most = self.context.max_texture_side();
        if width == 0 || height == 0 || width.max(height) > most {
            let message = format!("expected a texture of 1 to {most} texels along each side, found {width} x {height}");
            return Err(GpuError::Unsupported { place: name.into(), message });
        }
        Ok(self.context.device().create_texture(&wgpu::TextureDescriptor {
            label: Some(name),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        }))
    }

    fn insert(&mut self, name: &str, kind: Kind, has_content: bool) -> Result<(), GpuError> {
        if self.resources.contains_key(name) {
            return Err(GpuError::Options(format!("there are two resources named {name}: give one another name")));
        }
        self.resources.insert(name.into(), Resource { name: name.into(), kind, has_content });
        self.context.check()
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.resources.contains_key(name)
    }

    fn resource(&self, name: &str) -> Result<&Resource, GpuError> {
        let found = self.resources.get(name);
        found.ok_or_else(|| GpuError::Options(format!("expected a resource named {name}, found none")))
    }

    /// A view of a texture, for a program that shows it in a window. A texture that gets [another size](crate::SceneView::resize)
    /// is another texture.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there is no such texture.
    pub fn view(&self, name: &str) -> Result<wgpu::TextureView, GpuError> {
        Ok(self.resource(name)?.texture()?.create_view(&wgpu::TextureViewDescriptor::default()))
    }

    /// The bytes of all buffers and textures.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.resources.values().map(Resource::bytes).sum()
    }

    /// The passes that draw triangles; the others compute.
    #[must_use]
    pub fn draw_calls(&self) -> usize {
        self.passes().filter(|pass| pass.is_draw()).count()
    }

    /// Takes all passes out, to be added again.
    pub(crate) fn take_passes(&mut self) -> Vec<Pass> {
        std::mem::take(&mut self.steps).into_iter().map(|step| step.pass).collect()
    }

    /// Forgets a resource that no pass uses.
    pub(crate) fn forget(&mut self, name: &str) {
        self.resources.remove(name);
    }

    /// Adds a pass after those that are there.
    pub(crate) fn add(&mut self, pass: Pass) -> Result<(), GpuError> {
        if let Some(name) = self.first_without_content(&pass)? {
            let message = format!("pass {} reads {name}, which no pass before it writes", pass.name);
            return Err(GpuError::Options(message));
        }
        let scope = self.context.device().push_error_scope(wgpu::ErrorFilter::Validation);
        let step = self.step(pass)?;
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(GpuError::device(&step.pass.name, error));
        }
        for used in &step.pass.writes {
            if let Some(resource) = self.resources.get_mut(&used.name) {
                resource.has_content = true;
            }
        }
        self.steps.push(step);
        Ok(())
    }

    fn first_without_content(&self, pass: &Pass) -> Result<Option<String>, GpuError> {
        for name in pass.reads() {
            if !self.resource(name)?.has_content {
                return Ok(Some(name.to_owned()));
            }
        }
        Ok(None)
    }

    /// A pass with what it binds.
    fn step(&self, pass: Pass) -> Result<Step, GpuError> {
        let (slots, layout, is_draw) = match &pass.work {
            Work::Compute { kernel, .. } => (&kernel.slots, &kernel.program.layout, false),
            Work::Draw { drawing, .. } => (&drawing.slots, &drawing.program.layout, true),
        };
        let (drawn, written): (&[Use], &[Use]) = if is_draw { (&pass.writes, &[]) } else { (&[], &pass.writes) };
        let bound: Vec<&Use> = pass.reads.iter().chain(written).collect();
        if bound.len() != slots.len() {
            let message = format!("pass {} binds {} resources, its program {}", pass.name, bound.len(), slots.len());
            return Err(GpuError::Options(message));
        }
        let bind = |(used, slot): (&&Use, &Slot)| Bound::new(&self.context, self.resource(&used.name)?, used, *slot);
        let views = bound.iter().zip(slots).map(bind).collect::<Result<Vec<_>, _>>()?;
        let entries: Vec<wgpu::BindGroupEntry<'_>> = views.iter().enumerate().map(|(k, view)| view.entry(k)).collect();
        let descriptor = wgpu::BindGroupDescriptor { label: Some(&pass.name), layout, entries: &entries };
        let bindings = self.context.device().create_bind_group(&descriptor);
        let mut bytes: u64 = views.iter().map(|view| view.bytes).sum();
        for name in pass.fetched().chain(drawn.iter().map(|used| used.name.as_str())) {
            bytes += self.resource(name)?.bytes();
        }
        let target = |used: &Use| self.view(&used.name);
        let targets = drawn.iter().map(target).collect::<Result<_, _>>()?;
        let buffer = |name: &String| -> Result<wgpu::Buffer, GpuError> { Ok(self.resource(name)?.buffer()?.clone()) };
        let (attributes, indices) = match &pass.work {
            Work::Compute { .. } => (Vec::new(), None),
            Work::Draw { attributes, indices, .. } => {
                (attributes.iter().map(buffer).collect::<Result<_, _>>()?, indices.as_ref().map(buffer).transpose()?)
            }
        };
        Ok(Step { pass, bindings, targets, attributes, indices, bytes })
    }
}

impl fmt::Display for Renderer {
    /// One line for each pass: its name, what it reads, what it writes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |names: &mut dyn Iterator<Item = &str>| names.collect::<Vec<_>>().join(", ");
        let lines: Vec<[String; 3]> = self
            .passes()
            .map(|pass| [pass.name().to_owned(), list(&mut pass.reads()), list(&mut pass.writes())])
            .collect();
        let width = |k: usize| lines.iter().map(|line| line[k].len()).max().unwrap_or(0).max(6);
        let (first, second) = (width(0), width(1));
        writeln!(f, "{:first$} | {:second$} | writes", "pass", "reads")?;
        for [name, reads, writes] in &lines {
            writeln!(f, "{name:first$} | {reads:second$} | {writes}")?;
        }
        Ok(())
    }
}
