//! Passes with what they bind, and how a device is told of them.

use std::ops::Range;

use crate::renderer::drawing::Drawing;
use crate::renderer::kernel::Kernel;
use crate::renderer::pass::{Pass, Work};

/// A pass that is ready to run.
#[derive(Debug)]
pub(crate) struct Step {
    pub(crate) pass: Pass,
    pub(crate) bindings: wgpu::BindGroup,
    /// What a draw pass draws into: light; depth if any; with several samples a texel, the texture of their means.
    pub(crate) targets: Vec<wgpu::TextureView>,
    pub(crate) attributes: Vec<wgpu::Buffer>,
    pub(crate) indices: Option<wgpu::Buffer>,
    /// Of everything that it binds or draws into.
    pub(crate) bytes: u64,
}

/// Queries for the times of a step, and the number of the first of its two.
type Times<'a> = Option<(&'a wgpu::QuerySet, u32)>;

/// Encodes steps in their order. With `queries`, each step by itself, between two of them; else those that draw into the
/// same targets are one pass of the device, which so keeps what they draw at hand.
pub(crate) fn encode(steps: &[Step], encoder: &mut wgpu::CommandEncoder, queries: Option<&wgpu::QuerySet>) {
    let mut first = 0;
    while first < steps.len() {
        let times = queries.map(|queries| (queries, 2 * first as u32));
        let step = &steps[first];
        let following = if times.is_some() { 0 } else { step.followers(&steps[first + 1..]) };
        match &step.pass.work {
            Work::Compute { kernel, items } => step.compute(encoder, times, kernel, *items),
            Work::Draw { clear, .. } => draw(&steps[first..=first + following], encoder, times, *clear),
        }
        first += 1 + following;
    }
}

/// Draws steps of the same targets.
fn draw(steps: &[Step], encoder: &mut wgpu::CommandEncoder, times: Times<'_>, clear: bool) {
    let timestamp_writes = times.map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
        query_set,
        beginning_of_pass_write_index: Some(first),
        end_of_pass_write_index: Some(first + 1),
    });
    let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
    let targets = steps.first().map(|step| step.targets.as_slice()).unwrap_or_default();
    let color = |view| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: targets.get(2),
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
        label: steps.first().map(|step| step.pass.name.as_str()),
        color_attachments: &[targets.first().map(color)],
        depth_stencil_attachment: targets.get(1).map(depth),
        timestamp_writes,
        ..Default::default()
    });
    for step in steps {
        if let Work::Draw { drawing, vertices, .. } = &step.pass.work {
            step.draw_into(&mut pass, drawing, vertices.clone());
        }
    }
}

impl Step {
    /// How many of the next steps draw over what this one draws.
    fn followers(&self, next: &[Self]) -> usize {
        let follows = |step: &&Self| {
            matches!(step.pass.work, Work::Draw { clear: false, .. }) && step.pass.writes == self.pass.writes
        };
        if matches!(self.pass.work, Work::Draw { .. }) { next.iter().take_while(follows).count() } else { 0 }
    }

    fn draw_into(&self, pass: &mut wgpu::RenderPass<'_>, drawing: &Drawing, vertices: Range<u32>) {
        pass.set_pipeline(&drawing.program.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        for (slot, buffer) in self.attributes.iter().enumerate() {
            pass.set_vertex_buffer(slot as u32, buffer.slice(..));
        }
        match &self.indices {
            Some(indices) => {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(vertices, 0, 0..1);
            }
            None => pass.draw(vertices, 0..1),
        }
    }

    fn compute(&self, encoder: &mut wgpu::CommandEncoder, times: Times<'_>, kernel: &Kernel, items: u32) {
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
}
