//! Programs that draw triangles.

use crate::context::context::Context;
use crate::context::programs::Program;
use crate::error::GpuError;
use crate::renderer::kernel::{Slot, bind_group_layout, module, pipeline_layout};
use crate::renderer::shader::Shader;

/// The format of depth.
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A program of a vertex and a fragment shader, `vertex` and `fragment`.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub(crate) slots: Vec<Slot>,
    pub(crate) program: Program<wgpu::RenderPipeline>,
}

/// How a [`Drawing`] meets its targets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Meets {
    /// The format of what it draws into.
    pub(crate) target: wgpu::TextureFormat,
    pub(crate) depth: Depth,
    /// Samples of each texel of its targets.
    pub(crate) samples: u32,
    /// Bytes from vertex to vertex in each buffer of attributes: attribute k is the first three `f32` of a vertex in buffer k.
    pub(crate) strides: &'static [u64],
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
    /// Compiles a shader, once for a device.
    pub(crate) fn new(
        context: &Context,
        name: &str,
        shader: &Shader,
        slots: &[Slot],
        meets: &Meets,
    ) -> Result<Self, GpuError> {
        let key = format!("{slots:?} {meets:?}\n{}", shader.source());
        let program = context.drawings().get(key, || compile(context, name, shader, slots, meets))?;
        Ok(Self { slots: slots.to_vec(), program })
    }
}

fn compile(
    context: &Context,
    name: &str,
    shader: &Shader,
    slots: &[Slot],
    meets: &Meets,
) -> Result<Program<wgpu::RenderPipeline>, GpuError> {
    let device = context.device();
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let layout = bind_group_layout(context, name, slots, wgpu::ShaderStages::VERTEX_FRAGMENT);
    let module = module(context, name, shader);
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    let attributes: Vec<[wgpu::VertexAttribute; 1]> = (0..meets.strides.len()).map(attribute).collect();
    let buffers: Vec<Option<wgpu::VertexBufferLayout<'_>>> =
        meets.strides.iter().zip(&attributes).map(buffer).collect();
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(name),
        layout: Some(&pipeline_layout(context, name, &layout)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: compilation_options.clone(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: depth_state(meets.depth),
        multisample: wgpu::MultisampleState { count: meets.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options,
            targets: &[Some(meets.target.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(GpuError::device(name, error));
    }
    context.check()?;
    Ok(Program { pipeline, layout })
}

fn attribute(location: usize) -> [wgpu::VertexAttribute; 1] {
    let shader_location = location as u32;
    [wgpu::VertexAttribute { format: wgpu::VertexFormat::Float32x3, offset: 0, shader_location }]
}

fn buffer<'a>((stride, attributes): (&u64, &'a [wgpu::VertexAttribute; 1])) -> Option<wgpu::VertexBufferLayout<'a>> {
    let step_mode = wgpu::VertexStepMode::Vertex;
    Some(wgpu::VertexBufferLayout { array_stride: *stride, step_mode, attributes })
}

fn depth_state(depth: Depth) -> Option<wgpu::DepthStencilState> {
    (depth != Depth::None).then_some(wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(depth == Depth::Tested),
        // Depth is reversed: nearer is larger, which keeps the precision of numbers near 0 for what is far.
        depth_compare: Some(match depth {
            Depth::Behind => wgpu::CompareFunction::GreaterEqual,
            _ => wgpu::CompareFunction::Greater,
        }),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    })
}
