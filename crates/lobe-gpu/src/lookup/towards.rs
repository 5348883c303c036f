//! Values of a WGSL function towards many directions.

use std::fmt::Write as _;

use crate::GpuError;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;

/// A function `value(i: u32, s: vec3f) -> vec4f` to be asked, where `i` is the number of the direction, and what it reads:
/// the name, kind and WGSL declaration of its resources, in bindings 1 and up.
pub(crate) struct Question<'a> {
    pub(crate) name: &'a str,
    pub(crate) shader: Shader,
    pub(crate) reads: &'a [(&'a str, Slot, &'a str)],
    pub(crate) function: &'a str,
}

impl Question<'_> {
    /// The answers, in the order of the directions. The renderer holds what the function reads.
    pub(crate) fn ask(self, mut renderer: Renderer, dirs: &[[f32; 3]]) -> Result<Vec<[f32; 4]>, GpuError> {
        if dirs.is_empty() {
            return Ok(Vec::new());
        }
        let padded: Vec<[f32; 4]> = dirs.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        renderer.upload("directions", &padded)?;
        renderer.allocate("values", 16 * dirs.len() as u64)?;
        let mut text = String::from("\n@group(0) @binding(0) var<storage, read> directions: array<vec4f>;\n");
        for (k, (_, _, declaration)) in self.reads.iter().enumerate() {
            let _ = writeln!(text, "@group(0) @binding({}) {declaration};", k + 1);
        }
        let last = self.reads.len() + 1;
        let _ = writeln!(text, "@group(0) @binding({last}) var<storage, read_write> values: array<vec4f>;");
        text.push_str(self.function);
        text.push_str(MAIN);
        let mut slots = vec![Slot::Read];
        slots.extend(self.reads.iter().map(|(_, slot, _)| *slot));
        slots.push(Slot::Write);
        let kernel = Kernel::new(renderer.context(), self.name, &self.shader.with(&text), &slots)?;
        let mut pass = Pass::compute(self.name, &kernel, dirs.len() as u32).read("directions");
        for (name, ..) in self.reads {
            pass = pass.read(name);
        }
        renderer.add(pass.write("values"))?;
        renderer.run()?;
        renderer.read("values", dirs.len())
    }
}

const MAIN: &str = "
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = item_of(id, groups);
    if i < arrayLength(&values) {
        values[i] = value(i, directions[i].xyz);
    }
}
";

/// The first three numbers of each answer.
pub(crate) fn colors(values: Vec<[f32; 4]>) -> Vec<[f32; 3]> {
    values.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
}
