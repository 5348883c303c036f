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
use crate::scene_view::scene_buffers::{SURFACE, add_scene};
use crate::scene_view::surface_shading::Prepared;
use crate::{Context, GpuCamera, GpuError, SurfaceShading};

/// The format of the display.
const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

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
/// The passes: those of the shading, `backdrop`, `surfaces`, `resolve` unless a pixel is one sample, `tone`. Turning the light uploads `n²` colors.
#[derive(Debug)]
pub struct SceneView {
    renderer: Renderer,
    shading: Prepared,
    backdrop: Option<EnvironmentShape>,
    origin: [f64; 3],
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
        let SceneViewOptions { width, height, rays } = *options;
        if width == 0 || height == 0 || rays == 0 {
            let found = format!("{width} x {height} with {rays} rays along an axis");
            return Err(GpuError::Options(format!("expected a picture with pixels and rays, found {found}")));
        }
        let mut renderer = Renderer::new(context);
        let samples = [width.saturating_mul(rays), height.saturating_mul(rays)];
        let origin = scene.origin();
        let camera = GpuCamera::framing(scene.world_bounds(), -lobe_sh::Dir::X, 0.35);
        let camera = camera.unwrap_or_else(|| unreachable!("the angle is in range"));
        renderer.uniform("camera", &camera.shape(origin, samples))?;
        add_scene(&mut renderer, scene)?;
        let shading = shading.prepare(&mut renderer, scene)?;
        // One sample a pixel is the picture itself.
        let target = if rays == 1 { "picture" } else { "samples" };
        renderer.target(target, samples, context.light_format())?;
        renderer.target("depth", samples, DEPTH)?;
        if let Some(environment) = backdrop {
            add_backdrop(&mut renderer, environment, target)?;
        }
        add_surfaces(&mut renderer, &shading, scene, (target, backdrop.is_none()))?;
        add_display(&mut renderer, [width, height], rays)?;
        let backdrop = backdrop.map(Environment::shape);
        let view = Self { renderer, shading, backdrop, origin, options: *options };
        view.set_tone(&Tone::PLAIN)?;
        Ok(view)
    }

    /// The passes, and the textures `picture` and `display` that they draw.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
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

fn add_backdrop(renderer: &mut Renderer, environment: &Environment, target: &str) -> Result<(), GpuError> {
    environment.add_to(renderer, "sky")?;
    let slots = [Slot::Uniform, Slot::Texture, Slot::Uniform];
    let shader = environment.constants(Shader::new(&["backdrop"]));
    let format = renderer.context().light_format();
    let drawing = Drawing::new(renderer.context(), "backdrop", &shader, &slots, format, Depth::None)?;
    let pass = Pass::draw("backdrop", &drawing, 3, true).read("camera").read("sky").read("sky shape");
    renderer.add(pass.write(target))
}

fn add_surfaces(
    renderer: &mut Renderer,
    shading: &Prepared,
    scene: &Scene,
    (target, clear): (&str, bool),
) -> Result<(), GpuError> {
    let (corners, format) = (3 * scene.triangle_count() as u32, renderer.context().light_format());
    let draw = |drawing: &Drawing| Pass::draw("surfaces", drawing, corners, clear).read("camera");
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

fn add_display(renderer: &mut Renderer, size: [u32; 2], rays: u32) -> Result<(), GpuError> {
    let format = renderer.context().light_format();
    renderer.uniform("tone", &[0.0_f32; 4])?;
    renderer.target("display", size, DISPLAY)?;
    let slots = [Slot::Uniform, Slot::Texture];
    if rays > 1 {
        renderer.uniform("rays", &[rays, 0, 0, 0])?;
        renderer.target("picture", size, format)?;
        let shader = Shader::new(&["resolve"]);
        let resolve = Drawing::new(renderer.context(), "resolve", &shader, &slots, format, Depth::None)?;
        renderer.add(Pass::draw("resolve", &resolve, 3, true).read("rays").read("samples").write("picture"))?;
    }
    let tone = Drawing::new(renderer.context(), "tone", &Shader::new(&["tone"]), &slots, DISPLAY, Depth::None)?;
    renderer.add(Pass::draw("tone", &tone, 3, true).read("tone").read("picture").write("display"))
}
