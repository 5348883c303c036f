//! Compute programs.

use crate::context::context::Context;
use crate::context::programs::Program;
use crate::error::GpuError;
use crate::renderer::shader::Shader;

/// Invocations of a workgroup, as written in the WGSL modules.
pub(crate) const GROUP: u32 = 64;

/// What a program finds in a place of its bind group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// A few constants.
    Uniform,
    /// A storage buffer that is read.
    Read,
    /// A storage buffer that is written.
    Write,
    /// A texture whose texels are loaded without a filter.
    Texture,
}

/// A compute program and what it binds, in the order of its bindings: what it reads, then what it writes.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    pub(crate) slots: Vec<Slot>,
    pub(crate) program: Program<wgpu::ComputePipeline>,
}

impl Kernel {
    /// Compiles the entry point `main` of a shader, once for a device.
    pub(crate) fn new(context: &Context, name: &str, shader: &Shader, slots: &[Slot]) -> Result<Self, GpuError> {
        context.expect_storage(name)?;
        let key = format!("{slots:?}\n{}", shader.source());
        let program = context.kernels().get(key, || compile(context, name, shader, slots))?;
        Ok(Self { slots: slots.to_vec(), program })
    }

    /// Workgroups for this many items, in rows where one row would be too long.
    pub(crate) fn groups(&self, items: u32) -> [u32; 2] {
        let groups = items.div_ceil(GROUP).max(1);
        let most = wgpu::Limits::downlevel_defaults().max_compute_workgroups_per_dimension;
        let rows = groups.div_ceil(most);
        [groups.div_ceil(rows), rows]
    }
}

fn compile(
    context: &Context,
    name: &str,
    shader: &Shader,
    slots: &[Slot],
) -> Result<Program<wgpu::ComputePipeline>, GpuError> {
    let device = context.device();
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let layout = bind_group_layout(context, name, slots, wgpu::ShaderStages::COMPUTE);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&pipeline_layout(context, name, &layout)),
        module: &module(context, name, shader),
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(GpuError::device(name, error));
    }
    context.check()?;
    Ok(Program { pipeline, layout })
}

pub(crate) fn module(context: &Context, name: &str, shader: &Shader) -> wgpu::ShaderModule {
    context.device().create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(shader.source().into()),
    })
}

pub(crate) fn pipeline_layout(context: &Context, name: &str, layout: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
    context.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    })
}

pub(crate) fn bind_group_layout(
    context: &Context,
    name: &str,
    slots: &[Slot],
    visibility: wgpu::ShaderStages,
) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let entry = |(binding, slot): (usize, &Slot)| wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility,
        ty: match slot {
            Slot::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            Slot::Read => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            Slot::Write => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
            Slot::Texture => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
        },
        count: None,
    };
    let entries: Vec<wgpu::BindGroupLayoutEntry> = slots.iter().enumerate().map(entry).collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries };
    context.device().create_bind_group_layout(&descriptor)
}
