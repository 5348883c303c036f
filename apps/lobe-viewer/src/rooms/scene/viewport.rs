//! The picture of the scene.

use std::sync::Arc;

use eframe::egui::TextureId;
use lobe::env::{MappedMap, SceneLight};
use lobe::image::{Picture, Tone};
use lobe::prt::{Transfer, TransferMatrices};
use lobe::scene::Scene;
use lobe::sh::{Expansion as _, Rotation};
use lobe_gpu::{GlossyMesh, GpuError, SceneView, SceneViewOptions, Storage, SurfaceShading};
use web_time::{Duration, Instant};

use crate::loading::backdrop::Behind;
use crate::loading::bake::{GlossyBake, SceneData};
use crate::loading::materials::Materials;
use crate::loading::place::IN_PAGE;
use crate::loading::places::Places;
use crate::loading::sky_source::OpenedSky;
use crate::loading::suns::{ShownSuns, same};
use crate::widgets::gpu::Gpu;
use crate::widgets::orbit::Orbit;
use crate::widgets::status::Status;
use crate::widgets::tone::{Look, fitting};

/// After so long without a change the picture is drawn again with more samples a pixel.
pub(crate) const REST: Duration = Duration::from_millis(250);

/// The exposure fits a picture with so many times fewer pixels along each axis: its average is nearly the same, and the first picture, which
/// waits for it, is there sooner.
const FITTING_SCALE: u32 = 4;

/// Pixels along each axis below which it is as large as the picture itself.
const LEAST_FITTING: u32 = 64;

/// How often times on the device are measured, which waits for it.
const MEASURE: Duration = Duration::from_secs(1);

/// What has to be on the device before a frame.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    pub(crate) data: &'a SceneData,
    /// Without one, the scene is lit by its normals.
    pub(crate) transfer: Option<&'a Arc<Transfer>>,
    /// What that is of.
    pub(crate) places: &'a Places,
    /// Meshes that shine among those lit by transfer.
    pub(crate) glossy: &'a [GlossyBake],
    /// What surfaces need that shine by their materials.
    pub(crate) materials: Option<&'a Materials>,
    /// The suns of the light, and what they need.
    pub(crate) suns: &'a ShownSuns,
    pub(crate) sky: Option<&'a OpenedSky>,
    pub(crate) behind: &'a Behind,
    pub(crate) order: usize,
}

/// What changes from frame to frame.
#[derive(Clone, PartialEq)]
pub(crate) struct Frame {
    pub(crate) size: [u32; 2],
    pub(crate) orbit: Orbit,
    pub(crate) light: SceneLight,
    pub(crate) turn: Rotation,
    /// Of the sky in reflections.
    pub(crate) strength: f64,
    /// How light is shown.
    pub(crate) look: Look,
}

/// A view on the device and the frame that it shows.
#[derive(Default)]
pub(crate) struct Viewport {
    view: Option<(ViewKey, SceneView)>,
    texture: Option<TextureId>,
    /// And whether it is at rest there.
    shown: Option<(Frame, bool)>,
    changed: Option<Instant>,
    measured: Option<Instant>,
    /// The factor that fits the scene under its sky.
    fitting: Option<f64>,
    pub(crate) status: Status,
}

/// What is on the device, kept as long as it is there.
struct ViewKey {
    scene: Arc<Scene>,
    transfer: Option<Arc<Transfer>>,
    glossy: Vec<Arc<TransferMatrices>>,
    materials: Option<Materials>,
    suns: ShownSuns,
    sky: Option<Arc<MappedMap>>,
    behind: Behind,
    /// Of light by normals alone.
    order: usize,
}

impl ViewKey {
    fn of(wanted: &Wanted<'_>) -> Self {
        Self {
            scene: wanted.data.scene.clone(),
            transfer: wanted.transfer.cloned(),
            glossy: wanted.glossy.iter().map(|glossy| glossy.matrices.clone()).collect(),
            materials: wanted.materials.cloned(),
            suns: wanted.suns.clone(),
            sky: wanted.sky.map(|sky| sky.map.clone()),
            behind: wanted.behind.clone(),
            order: if wanted.transfer.is_none() { wanted.order } else { 0 },
        }
    }

    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && same(self.transfer.as_ref(), other.transfer.as_ref())
            && self.glossy.len() == other.glossy.len()
            && self.glossy.iter().zip(&other.glossy).all(|(a, b)| Arc::ptr_eq(a, b))
            && match (&self.materials, &other.materials) {
                (Some(a), Some(b)) => a.is_same(b),
                (a, b) => a.is_none() && b.is_none(),
            }
            && self.suns.is_same(&other.suns)
            && same(self.sky.as_ref(), other.sky.as_ref())
            && self.behind == other.behind
            && self.order == other.order
    }
}

/// What lights the vertices, or where no transfer is known, the sky: a picture that a page need not wait for.
fn picture_of_vertices(key: &ViewKey, light: &SceneLight) -> Picture {
    let lit = key.transfer.as_ref().map(|transfer| transfer.exit_radiance(light.whole().coefficients()));
    let sky = || key.sky.as_ref().map(|sky| sky.texels().to_vec());
    let pixels: Vec<[f32; 3]> = lit.or_else(sky).unwrap_or_default().into_iter().map(<[f32; 3]>::from).collect();
    Picture::new(pixels.len(), 1, pixels).unwrap_or_else(|_| Picture::filled(1, 1, [1.0; 3]))
}

/// Sets what a picture of a frame depends on.
fn aim(view: &mut SceneView, frame: &Frame) -> Result<(), GpuError> {
    view.set_reflection_strength(frame.strength);
    if let Some(camera) = frame.orbit.on_device() {
        view.set_camera(&camera)?;
    }
    view.set_scene_light(&frame.light)?;
    view.turn_backdrop(&frame.turn)
}

/// The options of a picture of few pixels that an exposure fits.
fn small(size: [u32; 2]) -> SceneViewOptions {
    let [width, height] = size.map(|pixels| pixels.div_ceil(FITTING_SCALE).max(pixels.min(LEAST_FITTING)));
    SceneViewOptions::default().width(width).height(height).rays(1)
}

/// The light of a frame in few pixels.
fn small_picture(view: &mut SceneView, frame: &Frame) -> Result<Picture, GpuError> {
    if *view.options() != small(frame.size) {
        view.resize(&small(frame.size))?;
    }
    aim(view, frame)?;
    view.render()?;
    view.picture()
}

impl Viewport {
    /// The texture that shows the frame, which is drawn if anything differs from the last. A picture without pixels is none.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        wanted: &Wanted<'_>,
        frame: &Frame,
    ) -> Result<Option<TextureId>, GpuError> {
        gpu.context().check()?;
        let now = Instant::now();
        if frame.size.contains(&0) {
            return Ok(None);
        }
        let is_new = self.ensure_view(gpu, wanted, frame)?;
        let is_changed = is_new || self.shown.as_ref().is_none_or(|(shown, _)| shown != frame);
        if is_changed {
            self.changed = Some(now);
        }
        let is_at_rest = self.changed.is_none_or(|changed| now.duration_since(changed) >= REST);
        if is_changed || self.shown.as_ref().is_none_or(|(_, shown)| *shown != is_at_rest) {
            self.render(gpu, frame, is_at_rest)?;
            self.status.drew(now);
            self.shown = Some((frame.clone(), is_at_rest));
        }
        Ok(self.texture)
    }

    /// Whether it waits to draw the picture at rest.
    pub(crate) fn is_coarse(&self) -> bool {
        self.shown.as_ref().is_some_and(|(_, is_at_rest)| !is_at_rest)
    }

    /// The picture in linear light that is shown at rest, and the exposure that fits it.
    pub(crate) fn picture_at_rest(&self) -> Option<(Picture, f64)> {
        let (_, view) = self.view.as_ref().filter(|_| !self.is_coarse())?;
        Some((view.picture().ok()?, self.fitting?))
    }

    /// The tone mapping of what is shown; before anything was shown, that of the command line.
    pub(crate) fn tone(&self, look: Look) -> Tone {
        self.fitting.map_or_else(|| look.of_any(), |factor| look.of(factor))
    }

    /// Forgets all that is on the device.
    pub(crate) fn forget(&mut self, gpu: &Gpu) {
        (self.view, self.shown) = (None, None);
        self.texture.take().into_iter().for_each(|texture| gpu.forget(texture));
    }

    /// Forgets the exposure that fits, for another scene or sky.
    pub(crate) fn fit_exposure(&mut self) {
        self.fitting = None;
        self.shown = None;
    }

    fn ensure_view(&mut self, gpu: &Gpu, wanted: &Wanted<'_>, frame: &Frame) -> Result<bool, GpuError> {
        let key = ViewKey::of(wanted);
        if self.view.as_ref().is_some_and(|(kept, _)| kept.is_same(&key)) {
            return Ok(false);
        }
        // What is not shown any more makes room first.
        self.view = None;
        let has_storage = gpu.context().has_storage();
        let is_without = !has_storage && !wanted.glossy.is_empty();
        self.status.left_out = is_without.then_some("metals are matte: this device has no storage buffers");
        let glossy = if has_storage { wanted.glossy } else { &[] };
        let glossy: Vec<GlossyMesh<'_>> = glossy.iter().map(GlossyBake::on_device).collect();
        let of_materials = |transfer| wanted.materials?.shading(transfer, wanted.places, Storage::F32);
        let shading = match wanted.transfer {
            Some(transfer) => {
                let matte = || wanted.places.shading(transfer, &glossy, Storage::F32);
                of_materials(&**transfer).unwrap_or_else(matte)
            }
            None => SurfaceShading::Irradiance(wanted.order),
        };
        let environment = wanted.behind.on_device(gpu.context(), wanted.sky.map(|sky| &*sky.shown));
        // As it is rendered first: to give it other options is to compile its passes anew.
        let options = match self.fitting {
            None if !IN_PAGE => small(frame.size),
            _ => gpu.options(frame.size, false),
        };
        let view = SceneView::with_suns(
            gpu.context(),
            &wanted.data.scene,
            (&shading, wanted.suns.apart()),
            environment.as_ref(),
            &options,
        )?;
        self.status.vertices = wanted.data.scene.vertex_count();
        self.status.triangles = wanted.data.scene.triangle_count();
        self.texture = Some(gpu.show(self.texture, &view.renderer().view("display")?));
        self.view = Some((key, view));
        Ok(true)
    }

    fn render(&mut self, gpu: &Gpu, frame: &Frame, is_at_rest: bool) -> Result<(), GpuError> {
        let Some((key, view)) = &mut self.view else { return Ok(()) };
        let begin = Instant::now();
        let factor = match self.fitting {
            Some(factor) => factor,
            None if IN_PAGE => *self.fitting.insert(fitting(&picture_of_vertices(key, &frame.light))),
            None => *self.fitting.insert(fitting(&small_picture(view, frame)?)),
        };
        let options = gpu.options(frame.size, is_at_rest);
        if *view.options() != options {
            view.resize(&options)?;
            self.texture = Some(gpu.show(self.texture, &view.renderer().view("display")?));
        }
        aim(view, frame)?;
        view.set_tone(&frame.look.of(factor))?;
        let now = Instant::now();
        // First of a picture at rest: those before have no time to lose.
        let has_time = |at: Instant| now.duration_since(at) >= MEASURE;
        let is_due = !IN_PAGE && self.measured.map_or(is_at_rest, has_time);
        if is_due {
            let times = view.renderer().run_timed()?;
            self.status.gpu = times.iter().map(|pass| pass.milliseconds).sum();
            self.measured = Some(now);
        } else {
            view.render()?;
            self.status.cpu = 1e3 * begin.elapsed().as_secs_f64();
        }
        self.status.draw_calls = view.renderer().draw_calls();
        self.status.bytes = view.renderer().bytes();
        self.status.size = frame.size;
        Ok(())
    }
}
