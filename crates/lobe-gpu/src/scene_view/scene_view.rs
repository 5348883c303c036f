//! A scene in a picture: passes from its light to the display.

use lobe_env::SceneLight;
use lobe_image::{Curve, Exposure, Picture, Tone};
use lobe_scene::Scene;
use lobe_sh::{Rgb, Rotation, ShVec};

use crate::context::context::Context;
use crate::error::GpuError;
use crate::lookup::environment::{Environment, EnvironmentShape};
use crate::moving::gpu_moving_part::GpuMovingPart;
use crate::renderer::pieces::VALUE;
use crate::renderer::renderer::Renderer;
use crate::scene_view::camera::GpuCamera;
use crate::scene_view::expected::{expect_values, vectors};
use crate::scene_view::frame_passes::{FramePasses, backdrop_shader};
use crate::scene_view::lights::Lights;
use crate::scene_view::options::{SceneViewOptions, ViewOutput};
use crate::scene_view::scene_buffers::{check_scene, vertices_of};
use crate::scene_view::sun_maps::SunMaps;
use crate::scene_view::sunlit_vertices::{NORMALS, normals_of};
use crate::scene_view::suns_apart::{SunsApart, limited};
use crate::scene_view::surface_pieces::{PlaceOrder, SurfacePieces};
use crate::scene_view::surface_shading::SurfaceShading;

/// The shape of the environment that is reflected.
const REFLECTED: &str = "reflected shape";

/// A scene on a device, ready to be seen under any light by any camera.
///
/// It shows what `lobe-render` shows: `light_by_irradiance`, `light_baked_scene`, or a scene of microfacets. Surfaces that are not
/// double-sided are black from behind; so are the backs of others where transfer lights them, which is known of fronts
/// only. Pixels differ where an edge passes within a 256th of a pixel of a sample: devices snap corners to such a grid (test
/// `pictures_by_transfer_are_those_of_the_processor`).
///
/// The passes: those of suns that cast shadows, those of the shading, `surfaces`, `backdrop`, `resolve` unless a
/// pixel is one sample, `tone` unless only the display is kept. Turning the light uploads `n²` colors. A scene beyond
/// the bindings of the device is drawn in pieces, each pass for one of them, with vertices that several pieces share
/// in each; of a lightmap that is too large in another order, which shows only where surfaces coincide. A picture, an
/// environment, and one texture have to fit as they are.
#[derive(Debug)]
pub struct SceneView {
    renderer: Renderer,
    lights: Lights,
    frame: FramePasses,
    /// What turns with the light: uniforms of the backdrop and of what microfacets reflect, as they were uploaded.
    skies: Vec<(&'static str, EnvironmentShape)>,
    origin: [f64; 3],
    order: PlaceOrder,
    vertices: usize,
    suns: SunMaps,
    options: SceneViewOptions,
}

impl SceneView {
    /// Uploads a scene and what lights it. Behind it is `backdrop`, or black. The camera looks along +x from far until it is
    /// [set](SceneView::set_camera), the light is none until it is [set](SceneView::set_light).
    ///
    /// # Errors
    /// [`GpuError::Options`] if the picture has no pixels, or the transfer does not fit the scene; [`GpuError::Unsupported`] if
    /// anything is too large for the device, or light goes straight through surfaces; [`GpuError::Device`] if the device fails.
    pub fn new(
        context: &Context,
        scene: &Scene,
        shading: &SurfaceShading<'_>,
        backdrop: Option<&Environment>,
        options: &SceneViewOptions,
    ) -> Result<Self, GpuError> {
        Self::with_suns(context, scene, (shading, SunsApart::No), backdrop, options)
    }

    /// The same with suns that light the scene beside the expansion, each with a pass `shadows of sun k` before the
    /// others, if they cast shadows: from a map of what it sees, at the resolution of
    /// [`SceneViewOptions::shadow_side`] over the whole scene, by percentage-closer soft shadows [Fernando 2005].
    ///
    /// # Errors
    /// [`GpuError::Options`] if the shading has all light in an expansion, or the transfer without reflections is of
    /// other receivers or of another order than that which is shown; else as [`SceneView::new`].
    pub fn with_suns(
        context: &Context,
        scene: &Scene,
        (shading, suns): (&SurfaceShading<'_>, SunsApart<'_>),
        backdrop: Option<&Environment>,
        options: &SceneViewOptions,
    ) -> Result<Self, GpuError> {
        let samples = options.samples()?;
        let mut renderer = Renderer::new(context);
        let origin = scene.origin();
        let camera = GpuCamera::framing(scene.world_bounds(), -lobe_sh::Dir::X, 0.35);
        let beyond = || {
            let message = format!("expected a finite box around the scene, found {:?}", scene.world_bounds());
            GpuError::Unsupported { place: "scene".into(), message }
        };
        let camera = camera.ok_or_else(beyond)?;
        renderer.uniform("camera", &camera.shape(origin, samples))?;
        check_scene(scene)?;
        if !context.has_storage() && scene.has_holes() {
            // Vertices and indices are all that is drawn by.
            context.expect_storage("surfaces with holes")?;
        }
        let pieces = SurfacePieces::new(scene, &shading.most(context, scene, &suns))?;
        renderer.upload("vertices", &pieces.order.placed(vertices_of(scene)))?;
        let (surfaces, lights) = shading.prepare(&mut renderer, scene, &pieces, suns)?;
        let maps = SunMaps::add_to(&mut renderer, scene, &suns, options.shadow_side)?;
        let shadows = (suns.maps(), maps.passes(&mut renderer, scene, &pieces)?);
        renderer.uniform("tone", &[0.0_f32; 4])?;
        renderer.uniform("rays", &[0_u32; 4])?;
        if let Some(environment) = backdrop {
            environment.add_to(&mut renderer, "sky")?;
        }
        let frame = FramePasses { shadows, surfaces, backdrop: backdrop.map(backdrop_shader) };
        frame.add_to(&mut renderer, options)?;
        let skies = [("sky shape", backdrop), (REFLECTED, shading.reflected())];
        let skies = skies.into_iter().filter_map(|(name, sky)| Some((name, sky?.shape()))).collect();
        let vertices = scene.vertex_count();
        let order = pieces.order;
        let options = *options;
        let view = Self { renderer, lights, frame, skies, origin, order, vertices, suns: maps, options };
        view.set_tone(&Tone::PLAIN)?;
        Ok(view)
    }

    /// The passes, and the textures `picture`, if light is kept, and `display` that they draw.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The size and the sampling of the picture.
    #[must_use]
    pub fn options(&self) -> &SceneViewOptions {
        &self.options
    }

    /// Gives the picture another size or another sampling, such as a finer one while nothing moves, or another output. The camera has to be
    /// [set](SceneView::set_camera) again. What is refused, such as the size of a window that is minimized, leaves the view as it was.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the picture would have no pixels; [`GpuError::Unsupported`] if it is too large for the device;
    /// [`GpuError::Device`] if the device fails.
    pub fn resize(&mut self, options: &SceneViewOptions) -> Result<(), GpuError> {
        let samples = options.samples()?;
        let most = self.renderer.context().max_texture_side();
        let maps = SunMaps::texture(self.frame.shadows.0, options.shadow_side)?.unwrap_or_default();
        if samples.into_iter().chain(maps).any(|side| side > most) {
            let [width, height] = samples;
            let message = format!(
                "expected at most {most} samples along each side, and of the maps of suns, found {width} x {height}"
            );
            return Err(GpuError::Unsupported { place: "picture".into(), message });
        }
        FramePasses::remove_from(&mut self.renderer)?;
        self.frame.add_to(&mut self.renderer, options)?;
        self.suns.resize(&self.renderer, options.shadow_side)?;
        self.options = *options;
        Ok(())
    }

    /// Sets the camera, in the world of the scene.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn set_camera(&self, camera: &GpuCamera) -> Result<(), GpuError> {
        let SceneViewOptions { width, height, rays, .. } = self.options;
        self.renderer.update("camera", &[camera.shape(self.origin, [width * rays, height * rays])])
    }

    /// Sets the light, an expansion of the radiance of the surroundings in the world frame; bands above the order of the shading
    /// are cut off. Microfacets reflect their environment instead, which is [turned](SceneView::turn_backdrop).
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn set_light(&self, light: &ShVec<Rgb<f64>>) -> Result<(), GpuError> {
        self.set_scene_light(&light.clone().into())
    }

    /// Sets a light of suns and an expansion of the rest. Of a view that is not made for so many suns the expansion
    /// holds the others.
    ///
    /// # Errors
    /// As [`SceneView::set_light`].
    pub fn set_scene_light(&self, light: &SceneLight) -> Result<(), GpuError> {
        let light = limited(light, self.suns.most());
        self.suns.light(&self.renderer, &light)?;
        self.lights.update(&self.renderer, &light)
    }

    /// Sets the radiance of all vertices, of a view that shows [`SurfaceShading::Radiance`].
    ///
    /// # Errors
    /// [`GpuError::Options`] if the view shows something else, or there are not as many values as vertices.
    pub fn set_radiance(&self, values: &[Rgb<f32>]) -> Result<(), GpuError> {
        if !self.lights.is_given() {
            return Err(GpuError::Options("expected a view of radiance, found one that computes it".into()));
        }
        expect_values(self.vertices, values.len())?;
        self.renderer.update("radiance", &self.order.placed(vectors(values)))
    }

    /// Sets the radiance of the vertices from `first` on to that of a part which was shaded on the same device, of a view that shows
    /// [`SurfaceShading::Radiance`]. Nothing is read back, unless the scene had to be cut into pieces.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the view shows something else, or has not as many vertices; [`GpuError::Device`] if the device fails.
    pub fn take_radiance(&self, first: usize, part: &GpuMovingPart) -> Result<(), GpuError> {
        if !self.lights.is_given() {
            return Err(GpuError::Options("expected a view of radiance, found one that computes it".into()));
        }
        let end = first + part.receivers();
        if end > self.vertices {
            let message = format!("expected receivers of {} vertices at most, found {end}", self.vertices);
            return Err(GpuError::Options(message));
        }
        if self.order.is_as_given() {
            let at = VALUE * first as u64;
            return self.renderer.copy_from(part.renderer(), "radiance", VALUE * part.receivers() as u64, at);
        }
        let values = part.radiance()?;
        for (place, vertex) in self.order.places_of(first..end) {
            self.renderer.update_at("radiance", place, &vectors(&values[vertex - first..=vertex - first]))?;
        }
        Ok(())
    }

    /// Moves the vertices to those of another scene, such as another moment of one that moves. All else remains.
    ///
    /// # Errors
    /// [`GpuError::Options`] if it has not as many vertices.
    pub fn set_vertices(&self, scene: &Scene) -> Result<(), GpuError> {
        if scene.vertex_count() != self.vertices {
            let (expected, found) = (self.vertices, scene.vertex_count());
            let message = format!("expected another moment of the same scene of {expected} vertices, found {found}");
            return Err(GpuError::Options(message));
        }
        let mut vertices = vertices_of(scene);
        // Where nothing stands still, moments count from origins of their own.
        let [from, to] = [scene.origin(), self.origin];
        if from != to {
            for vertex in &mut vertices {
                for axis in 0..3 {
                    vertex.position[axis] = (f64::from(vertex.position[axis]) + (from[axis] - to[axis])) as f32;
                }
            }
        }
        self.suns.bound(&self.renderer, scene.world_bounds())?;
        if self.renderer.has(NORMALS) {
            self.renderer.update(NORMALS, &self.order.placed(normals_of(scene)))?;
        }
        self.renderer.update("vertices", &self.order.placed(vertices))
    }

    /// Turns the backdrop, and the environment that microfacets reflect, from where they were given: what was seen towards s is then
    /// towards R s.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn turn_backdrop(&self, turn: &Rotation) -> Result<(), GpuError> {
        for (name, shape) in &self.skies {
            self.renderer.update(name, &[shape.turned(turn)])?;
        }
        Ok(())
    }

    /// Sets a factor of what shiny surfaces reflect, such as that of the light: 1 before it is set. It shows when the
    /// backdrop is [turned](SceneView::turn_backdrop) next.
    pub fn set_reflection_strength(&mut self, strength: f64) {
        for (name, shape) in &mut self.skies {
            if *name == REFLECTED {
                *shape = shape.with_strength(strength);
            }
        }
    }

    /// Sets the tone mapping of the display. An exposure that depends on a picture is that of black: fix it with
    /// [`Tone::fixed_for`] first.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn set_tone(&self, tone: &Tone) -> Result<(), GpuError> {
        let exposure = if let Exposure::Fixed(factor) = tone.exposure { factor } else { 1.0 };
        // Numbers of `tone.wgsl`.
        let (curve, white) = match tone.curve {
            Curve::Reinhard { white } => (1.0, 1.0 / (white * white)),
            Curve::Aces => (2.0, 0.0),
            Curve::AgX => (3.0, 0.0),
            Curve::Neutral => (4.0, 0.0),
            Curve::Clip => (0.0, 0.0),
        };
        self.renderer.update("tone", &[exposure as f32, curve, white as f32, 0.0])
    }

    /// Runs all passes. Does not wait for the device.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device was lost or refused work.
    pub fn render(&self) -> Result<(), GpuError> {
        self.renderer.run()
    }

    /// The picture in linear light that was rendered last. Waits for the device.
    ///
    /// # Errors
    /// [`GpuError::Options`] if only the [display](ViewOutput::Display) is kept; else as [`SceneView::render`].
    pub fn picture(&self) -> Result<Picture, GpuError> {
        if self.options.output != ViewOutput::LightAndDisplay {
            return Err(GpuError::Options(
                "expected a view that keeps its light, found one of the display alone".into(),
            ));
        }
        self.renderer.picture("picture")
    }

    /// The display bytes that were rendered last, three for each pixel, as [`Tone::to_bytes`]. Waits for the device.
    ///
    /// # Errors
    /// As [`SceneView::render`].
    pub fn display(&self) -> Result<Vec<u8>, GpuError> {
        let texels: Vec<[u8; 4]> = self.renderer.texels("display")?;
        Ok(texels.into_iter().flat_map(|[r, g, b, _]| [r, g, b]).collect())
    }
}
