//! The graphics device of the window.

use std::fmt;

use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use lobe_gpu::{Context, ContextOptions};

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
        let context = Context::of_device(state.device.clone(), state.queue.clone(), &ContextOptions::default());
        Self { context, state: state.clone() }
    }

    /// For passes.
    #[must_use]
    pub fn context(&self) -> &Context {
        &self.context
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
