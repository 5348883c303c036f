//! Programs that draw triangles.

use crate::renderer::kernel::{Slot, bind_group_layout, module, pipeline_layout};
use crate::renderer::shader::Shader;
use crate::{Context, GpuError};

/// The format of depth.
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A program of a vertex and a fragment shader, `vertex` and `fragment`.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub(crate) slots: Vec<Slot>,
    pub(crate) pipeline: wgpu::RenderPipeline,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// How a [`Drawing`] meets what was drawn before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// Drawn over everything.
    None,
    /// Nearer surfaces hide farther ones.
    Tested,
    /// Only where nothing was drawn: infinitely far.
    Behind,
}

impl Drawing {
    pub(crate) fn new(
        context: &Context,
        name: &str,
        shader: &Shader,
        slots: &[Slot],
        target: wgpu::TextureFormat,
        depth: Depth,
    ) -> Result<Self, GpuError> {
        let device = context.device();
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let layout = bind_group_layout(context, name, slots, wgpu::ShaderStages::VERTEX_FRAGMENT);
        let module = module(context, name, shader);
        let compilation_options = wgpu::PipelineCompilationOptions::default();
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(name),
            layout: Some(&pipeline_layout(context, name, &layout)),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: compilation_options.clone(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: (depth != Depth::None).then_some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(depth == Depth::Tested),
                // Depth is reversed: nearer is larger, which keeps the precision of numbers near 0 for what is far.
                depth_compare: Some(match depth {
                    Depth::Behind => wgpu::CompareFunction::GreaterEqual,
                    _ => wgpu::CompareFunction::Greater,
                }),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options,
                targets: &[Some(target.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(GpuError::device(name, error));
        }
        context.check()?;
        Ok(Self { slots: slots.to_vec(), pipeline, layout })
    }
}
