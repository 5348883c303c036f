//! Opens the window.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::anyhow;
use eframe::egui::ViewportBuilder;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup};
use eframe::{NativeOptions, wgpu};
use lobe_gpu::Context;

use crate::app::viewer_app::ViewerApp;
use crate::loading::cache::UserFolder;
use crate::widgets::gpu::Gpu;

/// The size of the window at the first start, in points.
const SIZE: [f32; 2] = [1280.0, 800.0];

/// The least size.
const LEAST: [f32; 2] = [480.0, 320.0];

/// Opens the window on what was left open, or on these files, and returns when it is closed.
pub(crate) fn open(files: &[PathBuf]) -> anyhow::Result<()> {
    let viewport = ViewportBuilder::default()
        .with_title("Lobe")
        .with_app_id("lobe-viewer")
        .with_inner_size(SIZE)
        .with_min_inner_size(LEAST)
        .with_drag_and_drop(true);
    let options = NativeOptions { viewport, wgpu_options: device_options(), ..NativeOptions::default() };
    let files = files.to_vec();
    let create = Box::new(move |creation: &eframe::CreationContext<'_>| {
        let gpu = creation.wgpu_render_state.as_ref().map(Gpu::of_window);
        let app: Box<dyn eframe::App> = Box::new(ViewerApp::new(gpu, UserFolder::of_user(), &files));
        Ok(app)
    });
    eframe::run_native("lobe-viewer", options, create).map_err(|error| {
        anyhow!("no window: {error}; it needs a display and Vulkan, Metal, Direct3D 12 or OpenGL; --headless renders without")
    })
}

/// All of the adapter's limits, of which transfer needs large buffers, and times of passes where there are any.
fn device_options() -> WgpuConfiguration {
    let mut options = WgpuConfiguration::default();
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_setup {
        setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
            label: Some("lobe-viewer"),
            required_features: adapter.features() & Context::optional_features(),
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        });
    }
    options
}
