//! Refusals of what does not belong to a scene, and colors as shaders have them.

use lobe_sh::Rgb;

use crate::error::GpuError;

/// Colors as shaders have them.
pub(crate) fn vectors(values: &[Rgb<f32>]) -> Vec<[f32; 4]> {
    values.iter().map(|c| [c.r, c.g, c.b, 1.0]).collect()
}

/// Refuses another number of values than vertices.
pub(crate) fn expect_values(expected: usize, found: usize) -> Result<(), GpuError> {
    if expected == found {
        return Ok(());
    }
    Err(GpuError::Options(format!(
        "expected the radiance of the {expected} vertices of the scene, found {found} values"
    )))
}

/// Refuses meshes that the scene does not have, and one that is there twice.
pub(crate) fn check_meshes(count: usize, meshes: &[usize]) -> Result<(), GpuError> {
    for (k, mesh) in meshes.iter().enumerate() {
        if *mesh >= count {
            return Err(GpuError::Options(format!("expected one of the {count} meshes, found number {mesh}")));
        }
        if meshes[..k].contains(mesh) {
            return Err(GpuError::Options(format!("expected each mesh once, found number {mesh} twice")));
        }
    }
    Ok(())
}

/// Refuses transfer of another number of receivers than the scene has.
pub(crate) fn expect(what: &str, expected: usize, found: usize) -> Result<(), GpuError> {
    if expected == found {
        return Ok(());
    }
    Err(GpuError::Options(format!("expected transfer of the {expected} {what} of the scene, found {found} receivers")))
}
