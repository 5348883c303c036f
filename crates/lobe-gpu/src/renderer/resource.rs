//! Buffers and textures, and how a pass binds them.

use crate::context::context::Context;
use crate::error::GpuError;
use crate::renderer::kernel::Slot;
use crate::renderer::pass::Use;

/// A buffer or a texture with its name among those of a renderer.
#[derive(Debug)]
pub(crate) struct Resource {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// Uploaded, or written by a pass.
    pub(crate) has_content: bool,
}

#[derive(Debug)]
pub(crate) enum Kind {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture),
}

impl Resource {
    pub(crate) fn buffer(&self) -> Result<&wgpu::Buffer, GpuError> {
        match &self.kind {
            Kind::Buffer(buffer) => Ok(buffer),
            Kind::Texture(_) => Err(self.is_another("a buffer", "a texture")),
        }
    }

    pub(crate) fn texture(&self) -> Result<&wgpu::Texture, GpuError> {
        match &self.kind {
            Kind::Texture(texture) => Ok(texture),
            Kind::Buffer(_) => Err(self.is_another("a texture", "a buffer")),
        }
    }

    fn is_another(&self, expected: &str, found: &str) -> GpuError {
        GpuError::Options(format!("expected {} to be {expected}, found {found}", self.name))
    }

    pub(crate) fn bytes(&self) -> u64 {
        match &self.kind {
            Kind::Buffer(buffer) => buffer.size(),
            Kind::Texture(texture) => {
                let texel = texture.format().block_copy_size(None).unwrap_or(4);
                let samples = u64::from(texture.sample_count());
                samples * u64::from(texel) * u64::from(texture.width()) * u64::from(texture.height())
            }
        }
    }
}

/// A resource, or a part of it, in a place of a bind group.
pub(crate) struct Bound<'a> {
    pub(crate) bytes: u64,
    kind: BoundKind<'a>,
}

enum BoundKind<'a> {
    Texture(wgpu::TextureView),
    Buffer(&'a wgpu::Buffer, u64),
}

impl<'a> Bound<'a> {
    pub(crate) fn new(context: &Context, resource: &'a Resource, used: &Use, slot: Slot) -> Result<Self, GpuError> {
        if slot == Slot::Texture {
            let view = resource.texture()?.create_view(&wgpu::TextureViewDescriptor::default());
            return Ok(Self { bytes: resource.bytes(), kind: BoundKind::Texture(view) });
        }
        let buffer = resource.buffer()?;
        let range = used.bytes.clone().unwrap_or(0..buffer.size());
        let bytes = range.end - range.start;
        let most = context.max_storage_binding();
        if slot != Slot::Uniform && bytes > most {
            let message = format!(
                "expected at most {most} bytes, which one binding of this device holds, found {bytes}; make it smaller, or take another \
                 device"
            );
            return Err(GpuError::Unsupported { place: used.name.clone(), message });
        }
        Ok(Self { bytes, kind: BoundKind::Buffer(buffer, range.start) })
    }

    pub(crate) fn entry(&self, binding: usize) -> wgpu::BindGroupEntry<'_> {
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
