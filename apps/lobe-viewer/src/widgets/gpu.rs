//! The graphics device of the window.

use std::fmt;

use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use lobe_gpu::{Context, ContextOptions, GpuError, SceneViewOptions, ViewOutput};

/// Samples of a pixel along each axis at rest.
const RAYS_AT_REST: u32 = 2;

/// The device of the window, for rooms to draw on.
#[derive(Clone)]
pub struct Gpu {
    context: Context,
    state: RenderState,
}

impl Gpu {
    /// The device that the window opened.
    #[must_use]
    pub fn of_window(state: &RenderState) -> Self {
        let (device, queue) = (state.device.clone(), state.queue.clone());
        let context = Context::of_device(&state.adapter, device, queue, &ContextOptions::default());
        Self { context, state: state.clone() }
    }

    /// For passes.
    #[must_use]
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The options of a picture of so many columns and rows: at rest with its light, for comparisons, and more samples;
    /// in motion by multisampling.
    pub(crate) fn options(&self, size: [u32; 2], is_at_rest: bool) -> SceneViewOptions {
        let (rays, output) = match is_at_rest {
            true => (rays_at_rest(size, self.context.max_texture_side()), ViewOutput::LightAndDisplay),
            false => (1, ViewOutput::Display),
        };
        SceneViewOptions::default().width(size[0]).height(size[1]).rays(rays).output(output)
    }

    /// Forgets a texture that was shown.
    pub(crate) fn forget(&self, id: TextureId) {
        self.state.renderer.write().free_texture(&id);
    }

    /// Shows a texture under the number of one that was shown before, or under a new one.
    #[must_use]
    pub fn show(&self, before: Option<TextureId>, view: &wgpu::TextureView) -> TextureId {
        let mut renderer = self.state.renderer.write();
        match before {
            Some(id) => {
                renderer.update_egui_texture_from_wgpu_texture(&self.state.device, view, wgpu::FilterMode::Linear, id);
                id
            }
            None => renderer.register_native_texture(&self.state.device, view, wgpu::FilterMode::Linear),
        }
    }
}

impl fmt::Debug for Gpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Gpu").field("context", &self.context).finish_non_exhaustive()
    }
}

/// Samples of a pixel along each axis at rest: one where more would be beyond the textures of the device.
fn rays_at_rest([width, height]: [u32; 2], most: u32) -> u32 {
    if width.max(height).saturating_mul(RAYS_AT_REST) <= most { RAYS_AT_REST } else { 1 }
}

/// What is said in place of a picture that was not drawn.
pub(crate) fn failure(error: &GpuError) -> String {
    match error {
        GpuError::Device { .. } => {
            format!("The graphics device failed: {error}. Restart the viewer; what you changed is kept.")
        }
        // Another start would meet it again.
        _ => format!("No picture: {error}."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_that_are_wide_for_a_device_have_one_sample_at_rest() {
        for (size, expected) in [([4096, 10], 2), ([10, 4097], 1), ([8192, 8192], 1), ([u32::MAX, 1], 1)] {
            assert_eq!(rays_at_rest(size, 8192), expected, "{size:?}");
        }
    }

    #[test]
    fn only_a_device_that_fails_asks_for_a_restart() {
        let (place, message) = ("picture".to_owned(), "expected at most 8192 samples".to_owned());
        let unsupported = GpuError::Unsupported { place: place.clone(), message: message.clone() };
        for (error, expected) in [(GpuError::Device { place, message }, true), (unsupported, false)] {
            let told = failure(&error);
            assert!(told.contains("8192") && told.contains("Restart") == expected, "{told}");
        }
    }
}
