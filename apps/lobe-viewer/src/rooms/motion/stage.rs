//! The picture of a moment by one way.

use std::sync::Arc;

use eframe::egui::TextureId;
use lobe::env::{MappedMap, SceneLight};
use lobe::image::Picture;
use lobe::motion::MovingMethod;
use lobe::sh::{Rotation, ShVec};
use lobe_gpu::{GpuError, SceneView, SunsApart, SurfaceShading};

use crate::loading::backdrop::Behind;
use crate::rooms::motion::player::Shown;
use crate::widgets::gpu::Gpu;
use crate::widgets::orbit::Orbit;
use crate::widgets::tone::{Look, fitting};

/// What changes from frame to frame beside the moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) orbit: Orbit,
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// How the sky is turned.
    pub(crate) turn: Rotation,
    /// How light is shown.
    pub(crate) look: Look,
    /// Whether nothing moves, for more samples and the light of the picture.
    pub(crate) is_still: bool,
}

/// A view on the device and what it shows.
#[derive(Default)]
pub(crate) struct Stage {
    view: Option<SceneView>,
    texture: Option<TextureId>,
    behind: Behind,
    sky: Option<Arc<MappedMap>>,
    /// For how many suns the view is made.
    suns: usize,
    shown: Option<(Shown, Frame)>,
}

/// What was drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drawn {
    pub(crate) texture: TextureId,
    /// Whether it is another picture than before.
    pub(crate) is_new: bool,
}

impl Stage {
    /// Forgets the scene, for another one.
    pub(crate) fn clear(&mut self) {
        (self.view, self.shown) = (None, None);
    }

    /// Forgets all that is on the device.
    pub(crate) fn forget(&mut self, gpu: &Gpu) {
        self.clear();
        self.texture.take().into_iter().for_each(|texture| gpu.forget(texture));
    }

    /// The texture that shows a moment by a way that it was lit by. `fits` is the exposure that fits, which the first picture says.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        (lit, method): (&Shown, MovingMethod),
        (behind, sky): (&Behind, Option<&Arc<MappedMap>>),
        frame: &Frame,
        fits: &mut Option<f64>,
    ) -> Result<Option<Drawn>, GpuError> {
        gpu.context().check()?;
        let Some(way) = lit.way(method).filter(|_| !frame.size.contains(&0)) else { return Ok(None) };
        let is_same_sky = match (&self.sky, sky) {
            (Some(before), Some(sky)) => Arc::ptr_eq(before, sky),
            (before, sky) => before.is_none() && sky.is_none(),
        };
        if !is_same_sky || self.behind != *behind {
            self.clear();
            (self.sky, self.behind) = (sky.cloned(), behind.clone());
        }
        let suns = &lit.asked.suns;
        if self.suns != suns.len() {
            self.clear();
            self.suns = suns.len();
        }
        // The exposure fits light, which a picture in motion does not keep.
        let options = gpu.options(frame.size, frame.is_still || fits.is_none());
        if self.view.is_none() {
            let environment = behind.on_device(gpu.context(), sky.map(|sky| &**sky));
            let shading = SurfaceShading::Radiance(&way.radiance);
            let apart = if suns.is_empty() { SunsApart::No } else { SunsApart::Shadowed(suns.len()) };
            let (scene, environment) = (&lit.data.scene, environment.as_ref());
            let view = SceneView::with_suns(gpu.context(), scene, (&shading, apart), environment, &options)?;
            self.texture = Some(gpu.show(self.texture, &view.renderer().view("display")?));
            self.view = Some(view);
        }
        let (Some(view), Some(texture)) = (&mut self.view, self.texture) else { return Ok(None) };
        if self.shown.as_ref().is_some_and(|(shown, at)| Arc::ptr_eq(shown, lit) && at == frame) {
            return Ok(Some(Drawn { texture, is_new: false }));
        }
        if *view.options() != options {
            view.resize(&options)?;
            self.texture = Some(gpu.show(self.texture, &view.renderer().view("display")?));
        }
        view.set_vertices(&lit.data.scene)?;
        view.set_radiance(&way.radiance)?;
        view.set_scene_light(&SceneLight::new(ShVec::zero(1), suns.clone()))?;
        if let Some(camera) = frame.orbit.on_device() {
            view.set_camera(&camera)?;
        }
        view.turn_backdrop(&frame.turn)?;
        let factor = match *fits {
            Some(factor) => factor,
            None => {
                view.render()?;
                *fits.insert(fitting(&view.picture()?))
            }
        };
        view.set_tone(&frame.look.of(factor))?;
        view.render()?;
        self.shown = Some((lit.clone(), *frame));
        Ok(Some(Drawn { texture: self.texture.unwrap_or(texture), is_new: true }))
    }

    /// The picture in linear light, which waits for the device; none before one was drawn at rest.
    pub(crate) fn picture(&self) -> Option<Picture> {
        self.shown.as_ref()?;
        self.view.as_ref()?.picture().ok()
    }

    /// Milliseconds on the device, which is waited for; none where it measures no times.
    pub(crate) fn milliseconds(&self) -> Option<f64> {
        let times = self.view.as_ref()?.renderer().run_timed().ok()?;
        times.iter().map(|pass| pass.milliseconds).sum()
    }

    /// Passes that draw, and bytes on the device.
    pub(crate) fn load(&self) -> (usize, u64) {
        self.view.as_ref().map_or((0, 0), |view| (view.renderer().draw_calls(), view.renderer().bytes()))
    }
}
