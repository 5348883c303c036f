//! The passes that depend on the size of the picture: maps of suns, surfaces, what is behind them, and display.

use crate::context::context::Context;
use crate::error::GpuError;
use crate::lookup::environment::Environment;
use crate::renderer::drawing::{DEPTH, Depth, Drawing, Meets};
use crate::renderer::kernel::Slot;
use crate::renderer::pass::Pass;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::options::{SceneViewOptions, ViewOutput};
use crate::scene_view::sun_maps::{DEPTHS, SunMaps};
use crate::scene_view::suns_apart::MAPS;
use crate::scene_view::surface_pass::{Corners, SurfacePass};

/// The format of the display.
const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The textures whose sizes are those of the picture.
const TEXTURES: [&str; 5] = ["samples", "depth", "picture", "display", "drawn"];

/// Bytes from vertex to vertex of the attributes, of which positions are fetched first.
const STRIDES: &[u64] = &[32, 16, 16, 16, 16];

/// What is drawn in every frame.
#[derive(Clone, Debug)]
pub(crate) struct FramePasses {
    /// Of so many suns, drawn before all else.
    pub(crate) shadows: (usize, Vec<SurfacePass>),
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
    /// Of each texel that is drawn into.
    samples: u32,
    strides: &'static [u64],
}

/// What surfaces are drawn into.
#[derive(Clone, Copy)]
struct Target {
    name: &'static str,
    shown: Shown,
    /// With several samples of each texel, their means are in another texture.
    samples: u32,
    means: Option<&'static str>,
}

impl Target {
    fn written_by(self, pass: Pass) -> Pass {
        let pass = self.shown.read(pass).write(self.name).write("depth");
        self.means.into_iter().fold(pass, Pass::write)
    }
}

impl Program<'_> {
    fn drawing(mut self, context: &Context, shown: Shown) -> Result<Drawing, GpuError> {
        let shader = shown.finish(self.shader, &mut self.slots);
        let (target, depth) = (shown.format(context), self.depth);
        let meets = Meets { target, depth, samples: self.samples, strides: self.strides };
        Drawing::new(context, self.name, &shader, &self.slots, &meets)
    }
}

impl FramePasses {
    /// Makes the textures, and adds the passes.
    pub(crate) fn add_to(&self, renderer: &mut Renderer, options: &SceneViewOptions) -> Result<(), GpuError> {
        let (samples, size) = (options.samples()?, [options.width, options.height]);
        let format = renderer.context().light_format();
        let has_light = options.output == ViewOutput::LightAndDisplay;
        let of_shade = options.samples_of_shade();
        renderer.target_of_samples("depth", samples, DEPTH, of_shade)?;
        renderer.target("display", size, DISPLAY)?;
        if options.rays > 1 {
            renderer.target("samples", samples, format)?;
        }
        if has_light {
            renderer.target("picture", size, format)?;
        }
        if of_shade > 1 {
            renderer.target_of_samples("drawn", size, DISPLAY, of_shade)?;
        }
        // One sample a pixel is the picture itself.
        let (name, shown, means) = match (options.rays, has_light) {
            (1, true) => ("picture", Shown::Light, None),
            (1, false) if of_shade > 1 => ("drawn", Shown::Display, Some("display")),
            (1, false) => ("display", Shown::Display, None),
            _ => ("samples", Shown::Light, None),
        };
        self.add_shadows(renderer, options.shadow_side)?;
        let target = Target { name, shown, samples: of_shade, means };
        for (number, surface) in self.surfaces.iter().enumerate() {
            add_surface(renderer, surface, target, number == 0)?;
        }
        if let Some(shader) = &self.backdrop {
            add_backdrop(renderer, shader, target)?;
        }
        add_display(renderer, options.rays, has_light)
    }

    /// Adds the maps of suns.
    fn add_shadows(&self, renderer: &mut Renderer, side: u32) -> Result<(), GpuError> {
        let (maps, passes) = &self.shadows;
        let Some(size) = SunMaps::texture(*maps, side)? else { return Ok(()) };
        renderer.target(MAPS, size, DISPLAY)?;
        renderer.target_of_samples(DEPTHS, size, DEPTH, 1)?;
        for (number, surface) in passes.iter().enumerate() {
            let slots: Vec<Slot> = surface.reads.iter().map(|(_, slot)| *slot).collect();
            let meets = Meets { target: DISPLAY, depth: Depth::Tested, samples: 1, strides: strides(surface) };
            let drawing = Drawing::new(renderer.context(), &surface.name, &surface.shader, &slots, &meets)?;
            let pass = surface
                .reads
                .iter()
                .fold(drawn(surface, &drawing, number == 0), |pass, (used, _)| pass.read_use(used.clone()));
            renderer.add(pass.write(MAPS).write(DEPTHS))?;
        }
        Ok(())
    }

    /// Takes out the passes and the textures that [`FramePasses::add_to`] makes; the others remain.
    pub(crate) fn remove_from(renderer: &mut Renderer) -> Result<(), GpuError> {
        let before = renderer.take_passes();
        TEXTURES.iter().chain(&[MAPS, DEPTHS]).for_each(|name| renderer.forget(name));
        before.into_iter().filter(|pass| !pass.is_draw()).try_for_each(|pass| renderer.add(pass))
    }
}

fn add_surface(renderer: &mut Renderer, surface: &SurfacePass, target: Target, is_first: bool) -> Result<(), GpuError> {
    let slots = std::iter::once(Slot::Uniform).chain(surface.reads.iter().map(|(_, slot)| *slot)).collect();
    let (name, shader, strides) = (surface.name.as_str(), surface.shader.clone(), strides(surface));
    let program = Program { name, shader, slots, depth: Depth::Tested, samples: target.samples, strides };
    let drawing = program.drawing(renderer.context(), target.shown)?;
    let pass = drawn(surface, &drawing, is_first).read("camera");
    let pass = surface.reads.iter().fold(pass, |pass, (used, _)| pass.read_use(used.clone()));
    renderer.add(target.written_by(pass))
}

fn strides(surface: &SurfacePass) -> &'static [u64] {
    match &surface.corners {
        Corners::Indexed(_, _, attributes) => &STRIDES[..attributes.len()],
        Corners::Numbered(_) => &[],
    }
}

/// A pass that draws the corners of triangles, without what it reads and writes.
fn drawn(surface: &SurfacePass, drawing: &Drawing, is_first: bool) -> Pass {
    match &surface.corners {
        Corners::Indexed(range, indices, attributes) => {
            Pass::draw(&surface.name, drawing, range.clone(), is_first).by_indices(indices, attributes)
        }
        Corners::Numbered(range) => Pass::draw(&surface.name, drawing, range.clone(), is_first),
    }
}

/// The shader of what is behind all surfaces.
pub(crate) fn backdrop_shader(environment: &Environment) -> Shader {
    environment.constants(Shader::new(&["backdrop"]))
}

fn add_backdrop(renderer: &mut Renderer, shader: &Shader, target: Target) -> Result<(), GpuError> {
    let slots = vec![Slot::Uniform, Slot::Texture, Slot::Uniform];
    let (shader, depth, samples) = (shader.clone(), Depth::Behind, target.samples);
    let program = Program { name: "backdrop", shader, slots, depth, samples, strides: &[] };
    let drawing = program.drawing(renderer.context(), target.shown)?;
    // After the surfaces: most of its pixels are hidden, and a look into the environment costs more than a surface.
    let pass = Pass::draw("backdrop", &drawing, 0..3, false).read("camera").read("sky").read("sky shape");
    renderer.add(target.written_by(pass))
}

/// The passes from what was drawn to the display.
fn add_display(renderer: &mut Renderer, rays: u32, has_light: bool) -> Result<(), GpuError> {
    let whole = |name: &'static str, module: &str, slots: Vec<Slot>| {
        let (shader, depth, strides) = (Shader::new(&[module]), Depth::None, &[][..]);
        Program { name, shader, slots, depth, samples: 1, strides }
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
