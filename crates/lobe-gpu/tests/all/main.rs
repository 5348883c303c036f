//! The GPU against the CPU on the same data. Without an adapter every test says that it is skipped.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod context;
mod gltf;
mod lookup;
mod moving;
mod multisampling;
mod pieces;
mod scene_view;
mod shader_cases;
mod shader_functions;
mod suns;
mod textures;
mod traced;
mod transfer;
mod values;
mod without_storage;

use std::sync::OnceLock;

use lobe_gpu::{AdapterChoice, Context, ContextOptions, GpuError, Renderer, SceneView};
use lobe_sh::Rgb;

/// The relative difference to the CPU that the shaders keep, of the largest value.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// The relative difference to the processor that a picture keeps.
pub(crate) fn tolerance(view: &SceneView) -> f64 {
    // Half precision rounds twice, by a 2048th each time.
    let is_half = view.renderer().context().light_format() == wgpu::TextureFormat::Rgba16Float;
    if is_half { 2e-3 } else { TOLERANCE }
}

/// The device of all tests: the software one where there is one, so that results are the same everywhere. `None`, and one
/// line that says so, if this machine has no adapter.
pub(crate) fn device(test: &str) -> Option<Context> {
    static DEVICE: OnceLock<Option<Context>> = OnceLock::new();
    let open = || {
        let software = Context::new(&ContextOptions::default().adapter(AdapterChoice::Software));
        match software.or_else(|_| Context::new(&ContextOptions::default())) {
            Ok(context) => Some(context),
            Err(GpuError::NoAdapter(_)) => None,
            Err(error) => panic!("the adapter does not open: {error}"),
        }
    };
    let context = DEVICE.get_or_init(open).clone();
    if context.is_none() {
        lobe_testkit::skipped(&format!("{test} of lobe-gpu: no graphics adapter"));
    }
    context
}

/// The same device with options of its own, such as smaller limits.
pub(crate) fn with(context: &Context, options: &ContextOptions) -> Context {
    context.limited(options)
}

/// The names of the passes, which are run.
pub(crate) fn pass_names(renderer: &Renderer) -> Vec<String> {
    renderer.run_timed().unwrap().into_iter().map(|time| time.name).collect()
}

/// The largest difference of two lists of numbers over the largest expected one.
pub(crate) fn relative_difference(
    found: impl IntoIterator<Item = f64>,
    expected: impl IntoIterator<Item = f64>,
) -> f64 {
    let (found, expected): (Vec<f64>, Vec<f64>) = (found.into_iter().collect(), expected.into_iter().collect());
    assert_eq!(found.len(), expected.len(), "as many numbers");
    let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // NaN is the largest difference.
    let difference = |(f, e): (&f64, &f64)| if f.is_finite() { (f - e).abs() } else { f64::INFINITY };
    found.iter().zip(&expected).map(difference).fold(0.0, f64::max) / largest
}

pub(crate) fn flat3(colors: &[[f32; 3]]) -> Vec<f64> {
    colors.iter().flatten().map(|c| f64::from(*c)).collect()
}

pub(crate) fn flat(colors: &[Rgb<f32>]) -> Vec<f64> {
    colors.iter().flat_map(|c| [f64::from(c.r), f64::from(c.g), f64::from(c.b)]).collect()
}
