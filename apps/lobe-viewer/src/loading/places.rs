//! Receivers of transfer that is shown: vertices or texels, with or without albedo.

use std::mem::discriminant;
use std::sync::Arc;

use lobe::prt::{AlbedoMode, Lightmap, Recipe, Transfer};
use lobe_gpu::{GlossyMesh, Storage, SurfaceShading};

/// What the rows of a transfer are of, and whether they hold the albedo.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Places {
    /// Vertices.
    #[default]
    Vertices,
    /// Vertices; each pixel multiplies by its own albedo.
    WithoutAlbedo,
    /// Texels of a lightmap.
    Texels(Arc<Lightmap>),
}

impl Places {
    /// Vertices by a bake of this recipe.
    pub(crate) fn vertices(recipe: &Recipe) -> Self {
        if recipe.bake_options().albedo == AlbedoMode::None { Self::WithoutAlbedo } else { Self::Vertices }
    }

    /// Whether two transfers of these can be subtracted.
    pub(crate) fn is_alike(&self, other: &Self) -> bool {
        discriminant(self) == discriminant(other)
    }

    /// How a device shows transfer of these; meshes shine only among vertices with albedo.
    pub(crate) fn shading<'a>(
        &'a self,
        transfer: &'a Transfer,
        glossy: &'a [GlossyMesh<'a>],
        storage: Storage,
    ) -> SurfaceShading<'a> {
        match self {
            Self::Vertices => SurfaceShading::Vertices(transfer, glossy, storage),
            Self::WithoutAlbedo => SurfaceShading::Demodulated(transfer, storage),
            Self::Texels(lightmap) => SurfaceShading::Lightmap(transfer, lightmap, storage),
        }
    }
}
