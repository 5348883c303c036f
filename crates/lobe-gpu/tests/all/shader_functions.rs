//! The functions that `lobe export shader` writes, run on a device beside the library.

use std::fmt::Write as _;

use lobe_shaders::ShaderFunction;

use crate::device;
use crate::shader_cases::{Row, rows};

/// What single precision leaves of numbers of at most 1 and their products, over the largest of a row or 1.
const OFF: f64 = 1e-5;

/// The variable that names a file in which the cases are kept, for the programs in `peers/shaders`.
const CASES: &str = "LOBE_SHADER_CASES";

#[test]
fn every_shader_function_has_the_numbers_of_the_library() {
    if let Some(path) = std::env::var_os(CASES) {
        std::fs::write(path, cases()).unwrap();
    }
    if device("every_shader_function_has_the_numbers_of_the_library").is_none() {
        return;
    }
    let (device, queue) = opened();
    for function in ShaderFunction::ALL {
        let rows = rows(function.name);
        let given: Vec<f32> = rows.iter().flat_map(|row| row.arguments.iter().copied()).collect();
        assert_eq!(given.len(), rows.len() * function.argument_numbers(), "arguments of {}", function.name);
        let found = ran(&device, &queue, &function.compute_program(), &given, rows.len() * function.result_numbers());
        for (k, row) in rows.iter().enumerate() {
            let count = function.result_numbers();
            compare(function.name, k, row, &found[k * count..][..count]);
        }
    }
}

fn compare(name: &str, k: usize, row: &Row, found: &[f32]) {
    assert_eq!(row.expected.len(), found.len(), "{name}, row {k}: numbers of a result");
    let scale = row.expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    for (i, (expected, found)) in row.expected.iter().zip(found).enumerate() {
        let off = (expected - f64::from(*found)).abs() / scale;
        assert!(off < OFF, "{name}, row {k}, number {i}: {found} on the device, {expected} by the library");
    }
}

/// The cases as JSON: for each function its rows, each of arguments and results.
fn cases() -> String {
    let mut text = String::from("{\n");
    for (k, function) in ShaderFunction::ALL.iter().enumerate() {
        let list: Vec<String> =
            rows(function.name).iter().map(|row| format!("[{:?}, {:?}]", row.arguments, row.expected)).collect();
        let end = if k + 1 < ShaderFunction::ALL.len() { "," } else { "" };
        let _ = writeln!(text, "\"{}\": [{}]{end}", function.name, list.join(",\n"));
    }
    text + "}\n"
}

/// A device without anything of `lobe-gpu`: the software one where there is one.
fn opened() -> (wgpu::Device, wgpu::Queue) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = |force_fallback_adapter| {
        let options = wgpu::RequestAdapterOptions { force_fallback_adapter, ..Default::default() };
        pollster::block_on(instance.request_adapter(&options))
    };
    let adapter = adapter(true).or_else(|_| adapter(false)).unwrap();
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    pollster::block_on(adapter.request_device(&descriptor)).unwrap()
}

/// The first `count` numbers that a program writes for these.
fn ran(device: &wgpu::Device, queue: &wgpu::Queue, program: &str, given: &[f32], count: usize) -> Vec<f32> {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(program.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let buffer = |size: usize, usage| {
        let size = 4 * size as u64;
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    };
    let arguments = buffer(given.len(), wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST);
    let results = buffer(count, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = buffer(count, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    queue.write_buffer(&arguments, 0, bytemuck::cast_slice(given));
    let entries = [&arguments, &results].map(wgpu::Buffer::as_entire_binding);
    let entries: Vec<wgpu::BindGroupEntry<'_>> =
        (0..).zip(entries).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    let layout = &pipeline.get_bind_group_layout(0);
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        // No row has fewer numbers than one.
        pass.dispatch_workgroups(count.div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&results, 0, &read, 0, 4 * count as u64);
    queue.submit([encoder.finish()]);
    let slice = read.slice(..);
    slice.map_async(wgpu::MapMode::Read, |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = slice.get_mapped_range().unwrap();
    bytemuck::pod_collect_to_vec(&bytes)
}
