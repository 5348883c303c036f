//! Devices, and what goes wrong on them.

use lobe_gpu::{Context, ContextOptions, GpuError, SceneView, Storage, SurfaceShading};
use lobe_prt::{Channels, Transfer};
use lobe_scene::built_in;

use crate::scene_view::options;
use crate::{device, pass_names};

/// A view of a scene by transfer of two bands.
fn view(context: &Context) -> SceneView {
    let scene = built_in::ball_over_ground(8);
    let transfer = Transfer::new(2, Channels::Gray, vec![0.5; 4 * scene.vertex_count()]).unwrap();
    let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
    SceneView::new(context, &scene, &shading, None, &options().rays(1)).unwrap()
}

#[test]
fn a_device_that_is_lost_is_an_error_and_no_panic() {
    if device("a_device_that_is_lost_is_an_error_and_no_panic").is_none() {
        return;
    }
    // Opened here, as by a window, to be destroyed.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = |force_fallback_adapter| {
        let options = wgpu::RequestAdapterOptions { force_fallback_adapter, ..Default::default() };
        pollster::block_on(instance.request_adapter(&options))
    };
    let adapter = adapter(true).or_else(|_| adapter(false)).unwrap();
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let (opened, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let context = Context::of_device(&adapter, opened.clone(), queue, &ContextOptions::default());
    let view = view(&context);
    assert!(!context.is_lost(), "it is there");
    opened.destroy();
    // What it still does comes to its end before the loss is reported.
    assert!(context.wait().is_err() || context.is_lost(), "it was destroyed");
    let error = view.render().expect_err("the device is gone");
    assert!(matches!(error, GpuError::Device { .. }), "{error}");
    assert_eq!(error.to_string().lines().count(), 1, "one line: {error}");
}

#[test]
fn the_order_of_passes_is_a_table() {
    let Some(context) = device("the_order_of_passes_is_a_table") else { return };
    let view = view(&context);
    let expected = "\
pass       | reads                                | writes
transfer 0 | transfer shape 0, light, transfer 0 | radiance
surfaces | camera, vertices, radiance, indices | picture, depth
tone | picture, tone | display
";
    let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(squeezed(&view.renderer().to_string()), squeezed(expected), "the table");
    assert_eq!(pass_names(view.renderer()), ["transfer 0", "surfaces", "tone"], "one time for each pass");
    let times = view.renderer().run_timed().unwrap();
    assert!(times.iter().all(|time| time.milliseconds.is_none_or(|ms| (0.0..1e6).contains(&ms))), "{times:?}");
}
