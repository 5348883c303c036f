//! Numbers and pictures from the device.

use bytemuck::Pod;
use half::f16;
use lobe_image::Picture;

use crate::context::context::Context;
use crate::error::GpuError;

/// Bytes of a row of a texture copied to a buffer are a multiple of this.
const ROW_ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// A buffer of nothing still has room for one of what shaders read from it.
const LEAST_BYTES: u64 = 256;

impl Context {
    /// A buffer on the device with these bytes, padded with zeros to a multiple of four and at least 256 bytes.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if it is larger than a buffer of this device can be.
    pub(crate) fn upload(&self, name: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, GpuError> {
        let buffer = self.empty(name, bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST)?;
        let whole = bytes.len() / 4 * 4;
        self.queue().write_buffer(&buffer, 0, &bytes[..whole]);
        if whole < bytes.len() {
            let mut last = [0; 4];
            last[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
            self.queue().write_buffer(&buffer, whole as u64, &last);
        }
        Ok(buffer)
    }

    /// A buffer of zeros of at least this size on the device.
    ///
    /// # Errors
    /// As [`Context::upload`].
    pub(crate) fn empty(&self, name: &str, size: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, GpuError> {
        let size = size.max(LEAST_BYTES).next_multiple_of(4);
        let most = self.device().limits().max_buffer_size;
        if size > most {
            let message = format!("expected at most {most} bytes in a buffer of this device, found {size}");
            return Err(GpuError::Unsupported { place: name.into(), message });
        }
        let descriptor = wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
        Ok(self.device().create_buffer(&descriptor))
    }

    /// The first `count` numbers in a buffer, which can be copied from. Waits for the device.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the buffer is shorter; [`GpuError::Device`] if the device was lost or refused work.
    pub(crate) fn read<T: Pod>(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<T>, GpuError> {
        if count == 0 {
            // Nothing cannot be mapped.
            return self.wait().map(|()| Vec::new());
        }
        let bytes = (count * size_of::<T>()) as u64;
        let size = bytes.next_multiple_of(4);
        if size > buffer.size() {
            let message = format!("expected a buffer of at least {size} bytes, found {}", buffer.size());
            return Err(GpuError::Options(message));
        }
        let read = self.empty("readback", size, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)?;
        let mut encoder = self.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &read, 0, size);
        self.queue().submit([encoder.finish()]);
        let bytes = self.mapped(&read, bytes)?;
        Ok(bytemuck::pod_collect_to_vec::<u8, T>(&bytes))
    }

    /// The texels of a texture, row after row, each as a `T` of the size of its format. Waits for the device.
    ///
    /// # Errors
    /// [`GpuError::Options`] if texels have another size; [`GpuError::Device`] as [`Context::read`].
    pub(crate) fn read_texture<T: Pod>(&self, texture: &wgpu::Texture) -> Result<Vec<T>, GpuError> {
        let (format, texel) = (texture.format(), size_of::<T>() as u32);
        if format.block_copy_size(None) != Some(texel) {
            return Err(GpuError::Options(format!("expected texels of {texel} bytes, found a texture of {format:?}")));
        }
        let (width, height) = (texture.width(), texture.height());
        let row = (texel * width).next_multiple_of(ROW_ALIGNMENT);
        let size = u64::from(row) * u64::from(height);
        let read = self.empty("readback", size, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)?;
        let mut encoder = self.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &read, layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue().submit([encoder.finish()]);
        let bytes = self.mapped(&read, size)?;
        let rows = bytes.chunks_exact(row as usize);
        Ok(rows.flat_map(|row| bytemuck::pod_collect_to_vec::<u8, T>(&row[..(texel * width) as usize])).collect())
    }

    /// The picture in a texture of [light](Context::light_format), whose fourth channel is left out. Waits for the device.
    ///
    /// # Errors
    /// As [`Context::read_texture`].
    pub(crate) fn picture(&self, texture: &wgpu::Texture) -> Result<Picture, GpuError> {
        let (width, height) = (texture.width() as usize, texture.height() as usize);
        let pixels: Vec<[f32; 3]> = if texture.format() == wgpu::TextureFormat::Rgba16Float {
            let texels: Vec<[u16; 4]> = self.read_texture(texture)?;
            texels.into_iter().map(|[r, g, b, _]| [r, g, b].map(|c| f16::from_bits(c).to_f32())).collect()
        } else {
            let texels: Vec<[f32; 4]> = self.read_texture(texture)?;
            texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
        };
        Ok(Picture::new(width, height, pixels)?)
    }

    fn mapped(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        let slice = buffer.slice(..bytes.next_multiple_of(4));
        let (sender, receiver) = std::sync::mpsc::channel();
        // Of a receiver that is gone nobody waits for the answer.
        slice.map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
        self.wait()?;
        let answer = receiver.recv().map_err(|error| GpuError::device("readback", error))?;
        answer.map_err(|error| GpuError::device("readback", error))?;
        let range = slice.get_mapped_range().map_err(|error| GpuError::device("readback", error))?;
        Ok(range[..bytes as usize].to_vec())
    }
}
