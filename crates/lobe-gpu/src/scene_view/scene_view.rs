//! A scene in a picture: passes from its light to the display.

use derive_setters::Setters;
use lobe_image::{Curve, Exposure, Picture, Tone};
use lobe_scene::{Material, Scene};
use lobe_sh::{Rgb, Rotation, ShVec};

use crate::lookup::environment::{Environment, EnvironmentShape};
use crate::renderer::drawing::{DEPTH, Depth, Drawing};
use crate::renderer::kernel::Slot;
use crate::renderer::pass::Pass;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::scene_buffers::{SURFACE, add_scene, vertices_of};
use crate::scene_view::surface_shading::{Prepared, expect_values, vectors};
use crate::{Context, GpuCamera, GpuError, SurfaceShading};

/// The format of the display.
const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The passes after the last that draws surfaces.
const DISPLAY_PASSES: [&str; 2] = ["resolve", "tone"];

/// The textures whose sizes are those of the picture.
const FRAME_TEXTURES: [&str; 4] = ["samples", "depth", "picture", "display"];

/// The size and the sampling of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[non_exhaustive]
pub struct SceneViewOptions {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Samples per pixel and axis, at least 1, on the regular grid on which `lobe-render` has its rays. Default: 2.
    pub rays: u32,
}

impl Default for SceneViewOptions {
    fn default() -> Self {
        Self { width: 512, height: 384, rays: 2 }
    }
}

/// A scene on a device, ready to be seen under any light by any camera.
///
/// It shows what `lobe-render` shows: `light_by_irradiance`, `light_baked_scene`, or a scene of microfacets. Surfaces that are not
/// double-sided are black from behind; so are the backs of others where transfer lights them, which is known of fronts
/// only. Pixels differ where an edge passes within a 256th of a pixel of a sample: devices snap corners to such a grid (test
/// `pictures_by_transfer_are_those_of_the_processor`).
///
/// The passes: those of the shading, `surfaces`, `backdrop`, `resolve` unless a pixel is one sample, `tone`. Turning the light uploads `n²` colors.
#[derive(Debug)]
pub struct SceneView {
    renderer: Renderer,
    shading: Prepared,
    backdrop: Option<EnvironmentShape>,
    origin: [f64; 3],
    vertices: usize,
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
        let samples = samples_of(options)?;
        let mut renderer = Renderer::new(context);
        let origin = scene.origin();
        let camera = GpuCamera::framing(scene.world_bounds(), -lobe_sh::Dir::X, 0.35);
        let camera = camera.unwrap_or_else(|| unreachable!("the angle is in range"));
        renderer.uniform("camera", &camera.shape(origin, samples))?;
        add_scene(&mut renderer, scene)?;
        let shading = shading.prepare(&mut renderer, scene)?;
        renderer.uniform("tone", &[0.0_f32; 4])?;
        renderer.uniform("rays", &[0_u32; 4])?;
        let target = target_of(options);
        add_targets(&mut renderer, options)?;
        add_surfaces(&mut renderer, &shading, scene, target)?;
        if let Some(environment) = backdrop {
            add_backdrop(&mut renderer, environment, target)?;
        }
        add_display(&mut renderer, options)?;
        let backdrop = backdrop.map(Environment::shape);
        let vertices = scene.vertex_count();
        let view = Self { renderer, shading, backdrop, origin, vertices, options: *options };
        view.set_tone(&Tone::PLAIN)?;
        Ok(view)
    }

    /// The passes, and the textures `picture` and `display` that they draw.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The size and the sampling of the picture.
    #[must_use]
    pub fn options(&self) -> &SceneViewOptions {
        &self.options
    }

    /// Gives the picture another size or another sampling, such as a finer one while nothing moves. The camera has to be
    /// [set](SceneView::set_camera) again. What is refused, such as the size of a window that is minimized, leaves the view as it was.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the picture would have no pixels; [`GpuError::Unsupported`] if it is too large for the device;
    /// [`GpuError::Device`] if the device fails.
    pub fn resize(&mut self, options: &SceneViewOptions) -> Result<(), GpuError> {
        let samples = samples_of(options)?;
        let most = self.renderer.context().device().limits().max_texture_dimension_2d;
        if samples[0].max(samples[1]) > most {
            let [width, height] = samples;
            let message = format!("expected at most {most} samples along each side, found {width} x {height}");
            return Err(GpuError::Unsupported { place: "picture".into(), message });
        }
        let was = target_of(&self.options);
        self.options = *options;
        let target = target_of(options);
        let kept = self.renderer.take_passes().into_iter().filter(|pass| !DISPLAY_PASSES.contains(&pass.name()));
        let kept: Vec<Pass> = kept.map(|pass| pass.writing_instead(was, target)).collect();
        FRAME_TEXTURES.iter().for_each(|name| self.renderer.forget(name));
        add_targets(&mut self.renderer, options)?;
        kept.into_iter().try_for_each(|pass| self.renderer.add(pass))?;
        add_display(&mut self.renderer, options)
    }

    /// Sets the camera, in the world of the scene.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn set_camera(&self, camera: &GpuCamera) -> Result<(), GpuError> {
        let SceneViewOptions { width, height, rays } = self.options;
        self.renderer.update("camera", &[camera.shape(self.origin, [width * rays, height * rays])])
    }

    /// Sets the light, an expansion of the radiance of the surroundings in the world frame; bands above the order of the shading
    /// are cut off. Microfacets reflect their environment instead.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn set_light(&self, light: &ShVec<Rgb<f64>>) -> Result<(), GpuError> {
        self.shading.light(&self.renderer, light)
    }

    /// Sets the radiance of all vertices, of a view that shows [`SurfaceShading::Radiance`].
    ///
    /// # Errors
    /// [`GpuError::Options`] if the view shows something else, or there are not as many values as vertices.
    pub fn set_radiance(&self, values: &[Rgb<f32>]) -> Result<(), GpuError> {
        if !self.shading.is_given() {
            return Err(GpuError::Options("expected a view of radiance, found one that computes it".into()));
        }
        expect_values(self.vertices, values.len())?;
        self.renderer.update("radiance", &vectors(values))
    }

    /// Moves the vertices to those of another scene, such as another moment of one that moves. All else remains.
    ///
    /// # Errors
    /// [`GpuError::Options`] if it has not as many vertices, or counts them from another origin.
    pub fn set_vertices(&self, scene: &Scene) -> Result<(), GpuError> {
        if scene.vertex_count() != self.vertices || scene.origin() != self.origin {
            let (expected, found) = (self.vertices, scene.vertex_count());
            let message = format!("expected another moment of the same scene of {expected} vertices, found {found}");
            return Err(GpuError::Options(message));
        }
        self.renderer.update("vertices", &vertices_of(scene))
    }

    /// Turns the backdrop from where its environment has it: what was seen towards s is then towards R s.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn turn_backdrop(&self, turn: &Rotation) -> Result<(), GpuError> {
        match &self.backdrop {
            Some(shape) => self.renderer.update("sky shape", &[shape.turned(turn)]),
            None => Ok(()),
        }
    }

    /// Sets the tone mapping of the display. An exposure that depends on a picture is that of black: fix it with
    /// [`Tone::fixed_for`] first.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn set_tone(&self, tone: &Tone) -> Result<(), GpuError> {
        let exposure = if let Exposure::Fixed(factor) = tone.exposure { factor } else { 1.0 };
        let [reinhard, white] = match tone.curve {
            Curve::Clip => [0.0, 0.0],
            Curve::Reinhard { white } => [1.0, 1.0 / (white * white)],
        };
        self.renderer.update("tone", &[exposure as f32, reinhard as f32, white as f32, 0.0])
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
    /// As [`SceneView::render`].
    pub fn picture(&self) -> Result<Picture, GpuError> {
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

/// The samples of a picture along its sides.
fn samples_of(options: &SceneViewOptions) -> Result<[u32; 2], GpuError> {
    let SceneViewOptions { width, height, rays } = *options;
    if width > 0 && height > 0 && rays > 0 {
        return Ok([width.saturating_mul(rays), height.saturating_mul(rays)]);
    }
    let found = format!("{width} x {height} with {rays} rays along an axis");
    Err(GpuError::Options(format!("expected a picture with pixels and rays, found {found}")))
}

/// What surfaces are drawn into: one sample a pixel is the picture itself.
fn target_of(options: &SceneViewOptions) -> &'static str {
    if options.rays == 1 { "picture" } else { "samples" }
}

/// The textures whose sizes are those of the picture.
fn add_targets(renderer: &mut Renderer, options: &SceneViewOptions) -> Result<(), GpuError> {
    let (samples, size, format) =
        (samples_of(options)?, [options.width, options.height], renderer.context().light_format());
    if options.rays > 1 {
        renderer.target("samples", samples, format)?;
    }
    renderer.target("depth", samples, DEPTH)?;
    renderer.target("picture", size, format)?;
    renderer.target("display", size, DISPLAY)
}

fn add_backdrop(renderer: &mut Renderer, environment: &Environment, target: &str) -> Result<(), GpuError> {
    environment.add_to(renderer, "sky")?;
    let slots = [Slot::Uniform, Slot::Texture, Slot::Uniform];
    let shader = environment.constants(Shader::new(&["backdrop"]));
    let format = renderer.context().light_format();
    let drawing = Drawing::new(renderer.context(), "backdrop", &shader, &slots, format, Depth::Behind)?;
    // After the surfaces: most of its pixels are hidden, and a look into the environment costs more than a surface.
    let pass = Pass::draw("backdrop", &drawing, 3, false).read("camera").read("sky").read("sky shape");
    renderer.add(pass.write(target).write("depth"))
}

fn add_surfaces(renderer: &mut Renderer, shading: &Prepared, scene: &Scene, target: &str) -> Result<(), GpuError> {
    let (corners, format) = (3 * scene.triangle_count() as u32, renderer.context().light_format());
    let draw = |drawing: &Drawing| Pass::draw("surfaces", drawing, corners, true).read("camera");
    let has_holes = scene.materials().iter().any(Material::has_holes);
    let pass = if shading.is_of_vertices && !has_holes {
        let slots = [Slot::Uniform, Slot::Read, Slot::Read];
        let shader = Shader::new(&["draw_vertices"]);
        let drawing = Drawing::new(renderer.context(), "surfaces", &shader, &slots, format, Depth::Tested)?;
        renderer.upload_indices("indices", &indices(scene))?;
        draw(&drawing).read("vertices").read("radiance").by_indices("indices")
    } else {
        let shader = shading.shader.clone().module("draw_surface");
        let mut slots = vec![Slot::Uniform];
        slots.extend([Slot::Read; SURFACE.len()]);
        slots.extend(shading.reads.iter().map(|(_, slot)| *slot));
        let drawing = Drawing::new(renderer.context(), "surfaces", &shader, &slots, format, Depth::Tested)?;
        let names = SURFACE.into_iter().chain(shading.reads.iter().map(|(name, _)| *name));
        names.fold(draw(&drawing), Pass::read)
    };
    renderer.add(pass.write(target).write("depth"))
}

/// The corners of all triangles, by their numbers among all vertices.
fn indices(scene: &Scene) -> Vec<u32> {
    let (mut first, mut indices) = (0, Vec::with_capacity(3 * scene.triangle_count()));
    for mesh in scene.meshes() {
        indices.extend(mesh.triangles().iter().flatten().map(|i| first + i));
        first += mesh.positions().len() as u32;
    }
    indices
}

/// Passes from what was drawn to the display: [`DISPLAY_PASSES`].
fn add_display(renderer: &mut Renderer, options: &SceneViewOptions) -> Result<(), GpuError> {
    let (rays, format) = (options.rays, renderer.context().light_format());
    let slots = [Slot::Uniform, Slot::Texture];
    if rays > 1 {
        renderer.update("rays", &[rays, 0, 0, 0])?;
        let shader = Shader::new(&["resolve"]);
        let resolve = Drawing::new(renderer.context(), "resolve", &shader, &slots, format, Depth::None)?;
        renderer.add(Pass::draw("resolve", &resolve, 3, true).read("rays").read("samples").write("picture"))?;
    }
    let tone = Drawing::new(renderer.context(), "tone", &Shader::new(&["tone"]), &slots, DISPLAY, Depth::None)?;
    renderer.add(Pass::draw("tone", &tone, 3, true).read("tone").read("picture").write("display"))
}
