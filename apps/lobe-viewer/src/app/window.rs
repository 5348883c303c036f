//! Opens the window.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind, set_hook};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use anyhow::{anyhow, bail};
use eframe::egui::ViewportBuilder;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup};
use eframe::{NativeOptions, wgpu};
use lobe::env::SunChoice;
use lobe_gpu::Context;

use crate::app::kept::{Kept, LEAST};
use crate::app::viewer_app::ViewerApp;
use crate::loading::cache::UserFolder;
use crate::loading::limits::ReadLimits;
use crate::widgets::gpu::Gpu;
use lobe::render::Surfaces;

/// The size of the window at the first start, in points.
const SIZE: [f32; 2] = [1280.0, 800.0];

/// Devices that are lost, one after the other, before the window stays closed: one that is lost at once would be lost forever.
const MOST_LOSSES: usize = 3;

/// Opens the window on what was left open, or on these files, and returns when it is closed. One whose device is lost is opened again
/// on another device, as it was.
pub(crate) fn open(
    files: &[PathBuf],
    limits: ReadLimits,
    (suns, surfaces): (&SunChoice, Option<Surfaces>),
) -> anyhow::Result<()> {
    let said = keep_panics_quiet();
    for losses in 0..=MOST_LOSSES {
        let lost = Arc::new(AtomicBool::new(false));
        let files = if losses == 0 { files } else { &[] };
        let surfaces = surfaces.filter(|_| losses == 0);
        let device = Arc::new(OnceLock::new());
        let ended = catch_unwind(AssertUnwindSafe(|| run((files, limits, suns, surfaces), losses, &lost, &device)));
        match ended {
            Ok(Ok(())) if !lost.load(Ordering::Relaxed) => return Ok(()),
            Ok(Err(error)) if losses == 0 => return Err(error),
            // A device that goes away while its window is drawn makes the library of the window panic, which opens no other then.
            Err(_) if is_gone(&device) => bail!("the graphics device was lost: start again, what you changed is kept"),
            Err(panic) => {
                eprintln!("{}", said.lock().unwrap_or_else(PoisonError::into_inner));
                resume_unwind(panic)
            }
            Ok(_) => {}
        }
    }
    bail!("the graphics device was lost {} times: update its driver, or start with WGPU_BACKEND=gl", MOST_LOSSES + 1)
}

/// From now on a panic prints nothing by itself: that of a window whose device is lost is told in other words, and those of tasks
/// in the window. What the last one said is kept.
fn keep_panics_quiet() -> Arc<Mutex<String>> {
    let said = Arc::<Mutex<String>>::default();
    let last = said.clone();
    set_hook(Box::new(move |info| *last.lock().unwrap_or_else(PoisonError::into_inner) = info.to_string()));
    said
}

/// Whether the device is lost, once it has ended what it was given.
fn is_gone(device: &OnceLock<Context>) -> bool {
    device.get().is_some_and(|context| context.wait().is_err() || context.is_lost())
}

fn run(
    (files, limits, suns, surfaces): (&[PathBuf], ReadLimits, &SunChoice, Option<Surfaces>),
    losses: usize,
    lost: &Arc<AtomicBool>,
    device: &Arc<OnceLock<Context>>,
) -> anyhow::Result<()> {
    let viewport = ViewportBuilder::default()
        .with_title("Lobe")
        .with_app_id("lobe-viewer")
        .with_inner_size(Kept::read(&UserFolder::of_user()).size.unwrap_or(SIZE))
        .with_min_inner_size(LEAST)
        .with_drag_and_drop(true);
    let options = NativeOptions { viewport, wgpu_options: device_options(), ..NativeOptions::default() };
    let (files, suns, lost, device) = (files.to_vec(), suns.clone(), lost.clone(), device.clone());
    let create = Box::new(move |creation: &eframe::CreationContext<'_>| {
        let gpu = creation.wgpu_render_state.as_ref().map(Gpu::of_window);
        if let Some(gpu) = &gpu {
            device.get_or_init(|| gpu.context().clone());
        }
        let app = ViewerApp::new(gpu, UserFolder::of_user(), &files).reporting_loss_to(lost).reading_within(limits);
        let mut app = app.looking_for_suns(suns).reflecting_by(surfaces);
        if losses > 0 {
            app.complain("The graphics device was lost; the window was opened again with what was kept");
        }
        let app: Box<dyn eframe::App> = Box::new(app);
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
