//! glTF primitives: their corners as triangles, and their names in messages.

use gltf_json::mesh::{Mode, Primitive};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index, Mesh};

use crate::error::SceneError;
use crate::files::gltf::accessor::Accessors;
use crate::files::source::Source;

/// The name of a mesh, or its index.
pub(crate) fn name_of(mesh: &Mesh, index: usize) -> String {
    mesh.name.clone().unwrap_or_else(|| index.to_string())
}

/// A primitive in messages.
pub(crate) fn place_of(mesh: &Mesh, index: usize, primitive: usize) -> String {
    format!("mesh `{}`, primitive {primitive}", name_of(mesh, index))
}

/// The mode of a primitive, unless it has points or lines.
pub(crate) fn is_of_triangles(primitive: &Primitive) -> Option<Mode> {
    match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => Some(mode),
        _ => None,
    }
}

/// The indices of a primitive's corners; without any, its vertices in their order.
pub(crate) fn corners_of(
    accessors: &Accessors<'_>,
    primitive: &Primitive,
    positions: Index<Accessor>,
    source: &Source<'_>,
) -> Result<Vec<u32>, SceneError> {
    let corners = match primitive.indices {
        Some(indices) => accessors.indices(indices, source)?,
        None => (0..accessors.count(positions, source)? as u32).collect(),
    };
    if primitive.mode == Checked::Valid(Mode::Triangles) && !corners.len().is_multiple_of(3) {
        let (place, found) = (&accessors.place, corners.len());
        return Err(source.invalid(format!("{place}: expected three indices for each triangle, found {found}")));
    }
    Ok(corners)
}

/// The triangles of a list, a strip, in which every other one is reversed, or a fan.
pub(crate) fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            corners.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => match corners {
            [] => Vec::new(),
            [hub, rim @ ..] => rim.windows(2).map(|t| [*hub, t[0], t[1]]).collect(),
        },
        _ => corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_run_around_the_same_way_as_lists() {
        assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [2, 1, 3]], "strip");
        assert_eq!(triangles(Mode::TriangleFan, &[0, 1, 2, 3]), [[0, 1, 2], [0, 2, 3]], "fan");
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3, 4, 5]), [[0, 1, 2], [3, 4, 5]], "list");
        assert!(triangles(Mode::TriangleFan, &[]).is_empty(), "an empty fan");
    }
}
