//! The renderer: buffers and textures by name, and passes over them in an order that is data.

use std::collections::BTreeMap;
use std::fmt;

use bytemuck::{NoUninit, Pod};
use lobe_image::Picture;

use crate::renderer::drawing::Drawing;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::{Pass, Use, Work};
use crate::{Context, GpuError};

/// Passes over named buffers and textures of one device.
///
/// Modules of this crate add their passes to it, in the order in which they run. Printed, it is a table of them: what each
/// reads and what it writes. A pass that reads what nothing wrote is refused when it is added.
///
/// Resources are uploaded, or made for a pass to write; the content of an uploaded one can be replaced between two runs
/// ([`Renderer::update`]), which is how light turns without anything else being done again.
#[derive(Debug)]
pub struct Renderer {
    context: Context,
    resources: BTreeMap<String, Resource>,
    steps: Vec<Step>,
}

#[derive(Debug)]
struct Resource {
    kind: Kind,
    /// Uploaded, or written by a pass.
    has_content: bool,
}

#[derive(Debug)]
enum Kind {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture),
}

#[derive(Debug)]
struct Step {
    pass: Pass,
    bindings: wgpu::BindGroup,
    /// What a draw pass draws into: light, and depth if any.
    targets: Vec<wgpu::TextureView>,
    indices: Option<wgpu::Buffer>,
    bytes: u64,
}

/// What one pass took; see [`Renderer::run_timed`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PassTime {
    /// The name of the pass.
    pub name: String,
    /// On the device; `None` where it measures no times.
    pub milliseconds: Option<f64>,
    /// The bytes of everything the pass binds or draws into, each once: a floor of what it moves if it needs all of
    /// them.
    pub bytes: u64,
}

impl Renderer {
    /// A renderer without passes.
    #[must_use]
    pub fn new(context: &Context) -> Self {
        Self { context: context.clone(), resources: BTreeMap::new(), steps: Vec::new() }
    }

    /// The device.
    #[must_use]
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The passes in the order in which they run.
    pub fn passes(&self) -> impl Iterator<Item = &Pass> {
        self.steps.iter().map(|step| &step.pass)
    }

    /// Runs all passes. Does not wait for the device.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device was lost or refused work before.
    pub fn run(&self) -> Result<(), GpuError> {
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
        for (i, step) in self.steps.iter().enumerate() {
            step.encode(&mut encoder, times.map(|queries| (queries, 2 * i as u32)));
        }
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
    pub fn read<T: Pod>(&self, name: &str, count: usize) -> Result<Vec<T>, GpuError> {
        self.context.read(self.buffer(name)?, count)
    }

    /// The picture in a texture of light, after the passes. Waits for the device.
    ///
    /// # Errors
    /// As [`Renderer::read`].
    pub fn picture(&self, name: &str) -> Result<Picture, GpuError> {
        self.context.picture(self.texture(name)?)
    }

    /// The texels of a texture, after the passes, each as a `T` of the size of its format. Waits for the device.
    ///
    /// # Errors
    /// As [`Renderer::read`].
    pub fn texels<T: Pod>(&self, name: &str) -> Result<Vec<T>, GpuError> {
        self.context.read_texture(self.texture(name)?)
    }

    /// Replaces the first numbers of an uploaded buffer, for the runs after this.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there is no such buffer or it is shorter.
    pub fn update<T: NoUninit>(&self, name: &str, numbers: &[T]) -> Result<(), GpuError> {
        let (buffer, bytes) = (self.buffer(name)?, bytemuck::cast_slice(numbers));
        if bytes.len() as u64 > buffer.size() {
            let message = format!("expected at most {} bytes for {name}, found {}", buffer.size(), bytes.len());
            return Err(GpuError::Options(message));
        }
        self.context.queue().write_buffer(buffer, 0, bytes);
        Ok(())
    }

    pub(crate) fn upload<T: NoUninit>(&mut self, name: &str, numbers: &[T]) -> Result<(), GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
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

    /// A storage buffer for passes to write.
    pub(crate) fn allocate(&mut self, name: &str, bytes: u64) -> Result<(), GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer = self.context.empty(name, bytes, usage)?;
        self.insert(name, Kind::Buffer(buffer), false)
    }

    /// A texture for passes to draw into and to read.
    pub(crate) fn target(&mut self, name: &str, size: [u32; 2], format: wgpu::TextureFormat) -> Result<(), GpuError> {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let texture = self.new_texture(name, size, format, usage)?;
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
        let texture = self.new_texture(name, size, format, usage)?;
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
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> Result<wgpu::Texture, GpuError> {
        let most = self.context.device().limits().max_texture_dimension_2d;
        if width == 0 || height == 0 || width.max(height) > most {
            let message = format!("expected a texture of 1 to {most} texels along each side, found {width} x {height}");
            return Err(GpuError::Unsupported { place: name.into(), message });
        }
        Ok(self.context.device().create_texture(&wgpu::TextureDescriptor {
            label: Some(name),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
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
        self.resources.insert(name.into(), Resource { kind, has_content });
        self.context.check()
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.resources.contains_key(name)
    }

    fn resource(&self, name: &str) -> Result<&Resource, GpuError> {
        let found = self.resources.get(name);
        found.ok_or_else(|| GpuError::Options(format!("expected a resource named {name}, found none")))
    }

    fn buffer(&self, name: &str) -> Result<&wgpu::Buffer, GpuError> {
        match &self.resource(name)?.kind {
            Kind::Buffer(buffer) => Ok(buffer),
            Kind::Texture(_) => Err(GpuError::Options(format!("expected {name} to be a buffer, found a texture"))),
        }
    }

    fn texture(&self, name: &str) -> Result<&wgpu::Texture, GpuError> {
        match &self.resource(name)?.kind {
            Kind::Texture(texture) => Ok(texture),
            Kind::Buffer(_) => Err(GpuError::Options(format!("expected {name} to be a texture, found a buffer"))),
        }
    }

    /// A view of a texture, for a program that shows it in a window. A texture that gets [another size](crate::SceneView::resize)
    /// is another texture.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there is no such texture.
    pub fn view(&self, name: &str) -> Result<wgpu::TextureView, GpuError> {
        Ok(self.texture(name)?.create_view(&wgpu::TextureViewDescriptor::default()))
    }

    /// The bytes of all buffers and textures.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let bytes = |resource: &Resource| match &resource.kind {
            Kind::Buffer(buffer) => buffer.size(),
            Kind::Texture(texture) => texture_bytes(texture),
        };
        self.resources.values().map(bytes).sum()
    }

    /// The passes that draw triangles; the others compute.
    #[must_use]
    pub fn draw_calls(&self) -> usize {
        self.passes().filter(|pass| matches!(pass.work, Work::Draw { .. })).count()
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
        for used in &pass.reads {
            if !self.resource(&used.name)?.has_content {
                let message = format!("pass {} reads {}, which no pass before it writes", pass.name, used.name);
                return Err(GpuError::Options(message));
            }
        }
        let (slots, layout, is_draw) = match &pass.work {
            Work::Compute { kernel, .. } => (&kernel.slots, &kernel.program.layout, false),
            Work::Draw { drawing, .. } => (&drawing.slots, &drawing.layout, true),
        };
        let scope = self.context.device().push_error_scope(wgpu::ErrorFilter::Validation);
        let bound: Vec<&Use> =
            if is_draw { pass.reads.iter().collect() } else { pass.reads.iter().chain(&pass.writes).collect() };
        if bound.len() != slots.len() {
            let message = format!("pass {} binds {} resources, its program {}", pass.name, bound.len(), slots.len());
            return Err(GpuError::Options(message));
        }
        let views =
            bound.iter().zip(slots).map(|(used, slot)| self.binding(used, *slot)).collect::<Result<Vec<_>, _>>()?;
        let mut bytes: u64 = views.iter().map(|view| view.bytes).sum();
        let entries: Vec<wgpu::BindGroupEntry<'_>> = views.iter().enumerate().map(|(k, view)| view.entry(k)).collect();
        let descriptor = wgpu::BindGroupDescriptor { label: Some(&pass.name), layout, entries: &entries };
        let bindings = self.context.device().create_bind_group(&descriptor);
        let mut targets = Vec::new();
        if is_draw {
            for used in &pass.writes {
                let texture = self.texture(&used.name)?;
                bytes += texture_bytes(texture);
                targets.push(texture.create_view(&wgpu::TextureViewDescriptor::default()));
            }
        }
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(GpuError::device(&pass.name, error));
        }
        let indices = match &pass.work {
            Work::Draw { indices: Some(name), .. } => {
                let buffer = self.buffer(name)?.clone();
                bytes += buffer.size();
                Some(buffer)
            }
            _ => None,
        };
        for used in &pass.writes {
            if let Some(resource) = self.resources.get_mut(&used.name) {
                resource.has_content = true;
            }
        }
        self.steps.push(Step { pass, bindings, targets, indices, bytes });
        Ok(())
    }

    fn binding(&self, used: &Use, slot: Slot) -> Result<Bound<'_>, GpuError> {
        if slot == Slot::Texture {
            let texture = self.texture(&used.name)?;
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            return Ok(Bound { bytes: texture_bytes(texture), kind: BoundKind::Texture(view) });
        }
        let buffer = self.buffer(&used.name)?;
        let range = used.bytes.clone().unwrap_or(0..buffer.size());
        let bytes = range.end - range.start;
        let most = self.context.max_storage_binding();
        if slot != Slot::Uniform && bytes > most {
            let message = format!("expected a binding of at most {most} bytes, found {bytes}");
            return Err(GpuError::Unsupported { place: used.name.clone(), message });
        }
        Ok(Bound { bytes, kind: BoundKind::Buffer(buffer, range.start) })
    }
}

struct Bound<'a> {
    kind: BoundKind<'a>,
    bytes: u64,
}

enum BoundKind<'a> {
    Texture(wgpu::TextureView),
    Buffer(&'a wgpu::Buffer, u64),
}

impl Bound<'_> {
    fn entry(&self, binding: usize) -> wgpu::BindGroupEntry<'_> {
        let resource = match &self.kind {
            BoundKind::Texture(view) => wgpu::BindingResource::TextureView(view),
            BoundKind::Buffer(buffer, offset) => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: *offset,
                size: std::num::NonZeroU64::new(self.bytes),
            }),
        };
        wgpu::BindGroupEntry { binding: binding as u32, resource }
    }
}

fn texture_bytes(texture: &wgpu::Texture) -> u64 {
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    u64::from(texel) * u64::from(texture.width()) * u64::from(texture.height())
}

impl Step {
    fn encode(&self, encoder: &mut wgpu::CommandEncoder, times: Option<(&wgpu::QuerySet, u32)>) {
        match &self.pass.work {
            Work::Compute { kernel, items } => self.encode_compute(encoder, times, kernel, *items),
            Work::Draw { drawing, vertices, clear, .. } => self.encode_draw(encoder, times, drawing, *vertices, *clear),
        }
    }

    fn encode_compute(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        times: Option<(&wgpu::QuerySet, u32)>,
        kernel: &Kernel,
        items: u32,
    ) {
        let timestamp_writes = times.map(|(query_set, first)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        let label = Some(self.pass.name.as_str());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        let [x, y] = kernel.groups(items);
        pass.set_pipeline(&kernel.program.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }

    fn encode_draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        times: Option<(&wgpu::QuerySet, u32)>,
        drawing: &Drawing,
        vertices: u32,
        clear: bool,
    ) {
        let timestamp_writes = times.map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
        let color = |view| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        };
        // Depth is reversed: 0 is infinitely far.
        let depths = if clear { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        let depth = |view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: depths, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&self.pass.name),
            color_attachments: &[self.targets.first().map(color)],
            depth_stencil_attachment: self.targets.get(1).map(depth),
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(&drawing.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        match &self.indices {
            Some(indices) => {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..vertices, 0, 0..1);
            }
            None => pass.draw(0..vertices, 0..1),
        }
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
