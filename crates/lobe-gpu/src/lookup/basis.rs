//! The basis on the device.

use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::{Context, GpuError};

/// The highest order that shaders evaluate, that of [`lobe_prt::Transfer`].
pub const MAX_SHADER_ORDER: usize = lobe_prt::Transfer::MAX_ORDER;

/// The values of all basis functions of orders 1 to `order` towards unit vectors, as
/// [`eval_basis`](lobe_sh::eval_basis): direction by direction, in index order.
///
/// The code is written by `cargo xtask tables` from the constants of [`lobe_sh::Basis`]; within 2e-6 of it in double precision
/// (test `basis_is_that_of_the_processor`).
///
/// # Errors
/// [`GpuError::Options`] if the order is not 1 to 8; [`GpuError::Unsupported`] if there are more values than one binding of
/// the device holds; [`GpuError::Device`] if the device fails.
pub fn basis_towards(context: &Context, order: usize, dirs: &[[f32; 3]]) -> Result<Vec<f32>, GpuError> {
    check_order(order)?;
    if dirs.is_empty() {
        return Ok(Vec::new());
    }
    let count = order * order * dirs.len();
    let mut renderer = Renderer::new(context);
    let padded: Vec<[f32; 4]> = dirs.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
    renderer.upload("directions", &padded)?;
    renderer.allocate("values", 4 * count as u64)?;
    let shader = Shader::new(&["dispatch"]).order(order).with(MAIN);
    let kernel = Kernel::new(context, "basis", &shader, &[Slot::Read, Slot::Write])?;
    let pass = Pass::compute("basis", &kernel, dirs.len() as u32);
    renderer.add(pass.read("directions").write("values"))?;
    renderer.run()?;
    renderer.read("values", count)
}

/// Refuses an order without code.
pub(crate) fn check_order(order: usize) -> Result<(), GpuError> {
    if (1..=MAX_SHADER_ORDER).contains(&order) {
        return Ok(());
    }
    Err(GpuError::Options(format!("expected an order of 1 to {MAX_SHADER_ORDER}, found {order}")))
}

const MAIN: &str = "
@group(0) @binding(0) var<storage, read> directions: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> values: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = item_of(id, groups);
    if i >= arrayLength(&directions) {
        return;
    }
    let y = basis(directions[i].xyz);
    for (var k = 0u; k < COEFFICIENTS; k++) {
        values[i * COEFFICIENTS + k] = y[k];
    }
}
";
