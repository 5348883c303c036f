//! The passes that depend on the size of the picture: surfaces, what is behind them, and display.

use crate::lookup::environment::Environment;
use crate::renderer::drawing::{DEPTH, Depth, Drawing, Meets};
use crate::renderer::kernel::Slot;
use crate::renderer::pass::Pass;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::surface_shading::{Corners, SurfacePass};
use crate::{Context, GpuError, SceneViewOptions, ViewOutput};

/// The format of the display.
const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The textures whose sizes are those of the picture.
const TEXTURES: [&str; 4] = ["samples", "depth", "picture", "display"];

/// Bytes from vertex to vertex of the attributes `vertices` and `radiance`, which are fetched in this order.
const STRIDES: &[u64] = &[32, 16];

/// What is drawn in every frame.
#[derive(Clone, Debug)]
pub(crate) struct FramePasses {
    pub(crate) surfaces: Vec<SurfacePass>,
    /// The shader of what is behind them.
    pub(crate) backdrop: Option<Shader>,
}

/// What a texture holds that is drawn into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    Light,
    Display,
}

impl Shown {
    fn format(self, context: &Context) -> wgpu::TextureFormat {
        if self == Self::Light { context.light_format() } else { DISPLAY }
    }

    /// A shader with function `shown`, which says light as it is or as a display shows it, and what that binds after all else.
    fn finish(self, shader: Shader, slots: &mut Vec<Slot>) -> Shader {
        if self == Self::Light {
            return shader.with("\nfn shown(light: vec3f) -> vec4f {\n    return vec4f(light, 1.0);\n}\n");
        }
        let binding = slots.len();
        slots.push(Slot::Uniform);
        shader.module("tone").with(&format!(
            "\n@group(0) @binding({binding}) var<uniform> tone: vec4f;\n\n\
            fn shown(light: vec3f) -> vec4f {{\n    return vec4f(displayed(tone, light), 1.0);\n}}\n"
        ))
    }

    fn read(self, pass: Pass) -> Pass {
        if self == Self::Light { pass } else { pass.read("tone") }
    }
}

/// A name, a shader without `shown`, and what it binds.
struct Program<'a> {
    name: &'a str,
    shader: Shader,
    slots: Vec<Slot>,
    depth: Depth,
    strides: &'static [u64],
}

impl Program<'_> {
    fn drawing(mut self, context: &Context, shown: Shown) -> Result<Drawing, GpuError> {
        let shader = shown.finish(self.shader, &mut self.slots);
        let meets = Meets { target: shown.format(context), depth: self.depth, strides: self.strides };
        Drawing::new(context, self.name, &shader, &self.slots, &meets)
    }
}

impl FramePasses {
    /// Makes the textures, and adds the passes.
    pub(crate) fn add_to(&self, renderer: &mut Renderer, options: &SceneViewOptions) -> Result<(), GpuError> {
        let (samples, size) = (options.samples()?, [options.width, options.height]);
        let format = renderer.context().light_format();
        let has_light = options.output == ViewOutput::LightAndDisplay;
        renderer.target("depth", samples, DEPTH)?;
        renderer.target("display", size, DISPLAY)?;
        if options.rays > 1 {
            renderer.target("samples", samples, format)?;
        }
        if has_light {
            renderer.target("picture", size, format)?;
        }
        // What surfaces are drawn into: one sample a pixel is the picture itself.
        let (target, shown) = match (options.rays, has_light) {
            (1, true) => ("picture", Shown::Light),
            (1, false) => ("display", Shown::Display),
            _ => ("samples", Shown::Light),
        };
        for (number, surface) in self.surfaces.iter().enumerate() {
            add_surface(renderer, surface, (target, shown), number == 0)?;
        }
        if let Some(shader) = &self.backdrop {
            add_backdrop(renderer, shader, (target, shown))?;
        }
        add_display(renderer, options.rays, has_light)
    }

    /// Takes out the passes and the textures that [`FramePasses::add_to`] makes; the others remain.
    pub(crate) fn remove_from(renderer: &mut Renderer) -> Result<(), GpuError> {
        let before = renderer.take_passes();
        TEXTURES.iter().for_each(|name| renderer.forget(name));
        before.into_iter().filter(|pass| !pass.is_draw()).try_for_each(|pass| renderer.add(pass))
    }
}

fn add_surface(
    renderer: &mut Renderer,
    surface: &SurfacePass,
    (target, shown): (&str, Shown),
    is_first: bool,
) -> Result<(), GpuError> {
    let slots = std::iter::once(Slot::Uniform).chain(surface.reads.iter().map(|(_, slot)| *slot)).collect();
    let strides =
        if let Corners::Indexed(_, attributes) = &surface.corners { &STRIDES[..attributes.len()] } else { &[] };
    let (name, shader) = (surface.name.as_str(), surface.shader.clone());
    let program = Program { name, shader, slots, depth: Depth::Tested, strides };
    let drawing = program.drawing(renderer.context(), shown)?;
    let pass = match &surface.corners {
        Corners::Indexed(range, attributes) => {
            Pass::draw(name, &drawing, range.clone(), is_first).by_indices("indices", attributes)
        }
        Corners::Numbered(range) => Pass::draw(name, &drawing, range.clone(), is_first),
    };
    let pass = surface.reads.iter().fold(pass.read("camera"), |pass, (used, _)| pass.read_use(used.clone()));
    renderer.add(shown.read(pass).write(target).write("depth"))
}

/// The shader of what is behind all surfaces.
pub(crate) fn backdrop_shader(environment: &Environment) -> Shader {
    environment.constants(Shader::new(&["backdrop"]))
}

fn add_backdrop(renderer: &mut Renderer, shader: &Shader, (target, shown): (&str, Shown)) -> Result<(), GpuError> {
    let slots = vec![Slot::Uniform, Slot::Texture, Slot::Uniform];
    let program = Program { name: "backdrop", shader: shader.clone(), slots, depth: Depth::Behind, strides: &[] };
    let drawing = program.drawing(renderer.context(), shown)?;
    // After the surfaces: most of its pixels are hidden, and a look into the environment costs more than a surface.
    let pass = Pass::draw("backdrop", &drawing, 0..3, false).read("camera").read("sky").read("sky shape");
    renderer.add(shown.read(pass).write(target).write("depth"))
}

/// The passes from what was drawn to the display.
fn add_display(renderer: &mut Renderer, rays: u32, has_light: bool) -> Result<(), GpuError> {
    let whole = |name: &'static str, module: &str, slots: Vec<Slot>| {
        let (shader, depth, strides) = (Shader::new(&[module]), Depth::None, &[][..]);
        Program { name, shader, slots, depth, strides }
    };
    if rays > 1 {
        renderer.update("rays", &[rays, 0, 0, 0])?;
        let (target, shown) = if has_light { ("picture", Shown::Light) } else { ("display", Shown::Display) };
        let program = whole("resolve", "resolve", vec![Slot::Uniform, Slot::Texture]);
        let drawing = program.drawing(renderer.context(), shown)?;
        let pass = Pass::draw("resolve", &drawing, 0..3, true).read("rays").read("samples");
        renderer.add(shown.read(pass).write(target))?;
    }
    if has_light {
        let drawing = whole("tone", "display", vec![Slot::Texture]).drawing(renderer.context(), Shown::Display)?;
        let pass = Pass::draw("tone", &drawing, 0..3, true).read("picture");
        renderer.add(Shown::Display.read(pass).write("display"))?;
    }
    Ok(())
}
