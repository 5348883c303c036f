//! Triangles that one program draws, before it is known what they are drawn into.

use std::ops::Range;

use crate::renderer::kernel::Slot;
use crate::renderer::pass::Use;
use crate::renderer::shader::Shader;

/// Triangles that one program draws.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePass {
    pub(crate) name: String,
    pub(crate) shader: Shader,
    /// What it binds, of a surface that is seen after the camera.
    pub(crate) reads: Vec<(Use, Slot)>,
    pub(crate) corners: Corners,
}

/// Which corners of triangles are drawn.
#[derive(Clone, Debug)]
pub(crate) enum Corners {
    /// Vertices by these indices of a buffer of them, with these buffers as attributes.
    Indexed(Range<u32>, &'static str, &'static [&'static str]),
    /// Corners by their numbers among those of the piece.
    Numbered(Range<u32>),
}

/// A resource that is bound as it is.
pub(crate) fn whole(name: &str) -> Use {
    Use { name: name.into(), bytes: None }
}
