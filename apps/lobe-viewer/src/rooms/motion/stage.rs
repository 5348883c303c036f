//! The picture of a moment.

use std::sync::Arc;

use eframe::egui::TextureId;
use lobe::env::MappedMap;
use lobe_gpu::{Environment, GpuError, SceneView, SceneViewOptions, SurfaceShading};

use crate::rooms::motion::player::Shown;
use crate::widgets::gpu::Gpu;
use crate::widgets::orbit::Orbit;
use crate::widgets::tone::{fitting, photograph};

/// Samples of a pixel along each axis.
const RAYS: u32 = 1;

/// A view on the device and what it shows.
#[derive(Default)]
pub(crate) struct Stage {
    view: Option<SceneView>,
    texture: Option<TextureId>,
    sky: Option<Arc<MappedMap>>,
    shown: Option<(Shown, Orbit, [u32; 2])>,
    exposure: Option<f64>,
}

impl Stage {
    /// Forgets the scene, for another one.
    pub(crate) fn clear(&mut self) {
        (self.view, self.shown, self.exposure) = (None, None, None);
    }

    /// The texture that shows a moment.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        lit: &Shown,
        sky: Option<&Arc<MappedMap>>,
        orbit: &Orbit,
        size: [u32; 2],
    ) -> Result<Option<TextureId>, GpuError> {
        gpu.context().check()?;
        if size.contains(&0) {
            return Ok(None);
        }
        let is_same_sky = match (&self.sky, sky) {
            (Some(before), Some(sky)) => Arc::ptr_eq(before, sky),
            (before, sky) => before.is_none() && sky.is_none(),
        };
        if !is_same_sky {
            self.clear();
            self.sky = sky.cloned();
        }
        let options = SceneViewOptions::default().width(size[0]).height(size[1]).rays(RAYS);
        if self.view.is_none() {
            let environment = sky.map(|sky| Environment::from(&**sky));
            let shading = SurfaceShading::Radiance(&lit.radiance);
            let view = SceneView::new(gpu.context(), &lit.scene, &shading, environment.as_ref(), &options)?;
            self.texture = Some(gpu.show(self.texture, &view.renderer().view("display")?));
            self.view = Some(view);
        }
        let Some(view) = &mut self.view else { return Ok(None) };
        if let Some((shown, before, at)) = &self.shown
            && Arc::ptr_eq(shown, lit)
            && before == orbit
            && *at == size
        {
            return Ok(self.texture);
        }
        if *view.options() != options {
            view.resize(&options)?;
            self.texture = Some(gpu.show(self.texture, &view.renderer().view("display")?));
        }
        view.set_vertices(&lit.scene)?;
        view.set_radiance(&lit.radiance)?;
        if let Some(camera) = orbit.on_device() {
            view.set_camera(&camera)?;
        }
        let exposure = match self.exposure {
            Some(exposure) => exposure,
            None => {
                view.render()?;
                *self.exposure.insert(fitting(&view.picture()?))
            }
        };
        view.set_tone(&photograph(exposure, 0.0))?;
        view.render()?;
        self.shown = Some((lit.clone(), *orbit, size));
        Ok(self.texture)
    }
}
