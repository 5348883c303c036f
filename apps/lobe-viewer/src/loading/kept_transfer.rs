//! Files of transfer for a scene: of its vertices in any form, of the texels of its lightmap, or matrices.

use std::path::Path;
use std::sync::Arc;

use lobe::image::ExrLayers;
use lobe::io::read_file;
use lobe::prt::{
    AnyTransfer, Lightmap, PrtError, Recipe, Transfer, TransferMatrices, read_any_transfer_bytes, read_matrices_bytes,
};

use crate::loading::bake::SceneData;
use crate::loading::file_kind::FileKind;
use crate::loading::limits::ReadLimits;
use crate::loading::place::given;
use crate::loading::places::Places;

/// Bytes in memory for each of a file of numbers while it is read: it, its numbers, and what is made of them.
const COPIES: u64 = 3;

/// What a file holds for a scene, with as many receivers as that has.
pub(crate) enum KeptTransfer {
    /// Transfer of what diffuses light, and what its rows are of.
    Vectors(AnyTransfer, Box<Recipe>, Places),
    /// Transfer matrices of all vertices.
    Matrices(TransferMatrices),
}

impl KeptTransfer {
    /// Reads a file for a scene.
    ///
    /// # Errors
    /// One line that names the file, and says what is wrong with it or why it is not of this scene.
    pub(crate) fn read(data: &SceneData, path: &Path, limits: &ReadLimits) -> Result<Self, String> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let kind = FileKind::of(path)?;
        if !matches!(kind, FileKind::Matrices | FileKind::Transfer) {
            return Err(format!(
                "{name}: expected transfer or transfer matrices of {}, found another kind of file",
                data.name
            ));
        }
        let bytes = match given(path) {
            Some(bytes) => bytes,
            None => {
                let length = std::fs::metadata(path).map_or(0, |file| file.len());
                limits.check_memory(&name, COPIES.saturating_mul(length))?;
                Arc::from(read_file(path).map_err(|error| error.to_string())?)
            }
        };
        let line = |error: PrtError| error.to_string();
        if kind == FileKind::Matrices {
            let (matrices, _) = read_matrices_bytes(&bytes, &name).map_err(line)?;
            expect_vertices(data, &format!("{name}: transfer matrices"), matrices.points())?;
            return Ok(Self::Matrices(matrices));
        }
        let is_lightmap = FileKind::is_lightmap(path);
        if is_lightmap {
            let numbers = ExrLayers::bytes_in_memory(&bytes, &name).map_err(|error| error.to_string())?;
            limits.check_memory(&name, COPIES.saturating_mul(numbers))?;
        }
        let (transfer, recipe) = read_any_transfer_bytes(&bytes, &name).map_err(line)?;
        let places = if is_lightmap {
            texels(data, &name, &transfer, &recipe)?
        } else {
            expect_vertices(data, &format!("{name}: transfer"), transfer.receivers())?;
            Places::vertices(&recipe)
        };
        Ok(Self::Vectors(transfer, Box::new(recipe), places))
    }
}

/// Vectors of any form, unless they take too much memory: a small file can hold clusters or lobes of many.
///
/// # Errors
/// One line that names the file and the limit.
pub(crate) fn to_vectors(transfer: AnyTransfer, name: &str, limits: &ReadLimits) -> Result<Transfer, String> {
    let numbers = 3 * transfer.receivers() * transfer.order().pow(2);
    let bytes = (size_of::<f32>() * numbers) as u64;
    match transfer {
        AnyTransfer::Plain(transfer) => Ok(transfer),
        AnyTransfer::Half(halves) => {
            let bytes = (2 * size_of_val(halves.coefficients())) as u64;
            limits.check_memory(name, bytes).map(|()| halves.to_transfer())
        }
        AnyTransfer::Compressed(compressed) => limits.check_memory(name, bytes).map(|()| compressed.to_transfer()),
        AnyTransfer::Zonal(lobes) => limits.check_memory(name, bytes).map(|()| lobes.to_transfer()),
    }
}

fn expect_vertices(data: &SceneData, what: &str, found: usize) -> Result<(), String> {
    let expected = data.scene.vertex_count();
    if found == expected {
        return Ok(());
    }
    let advice = "open the scene that it was baked from first";
    Err(format!("{what} of {found} receivers, but {} has {expected} vertices; {advice}", data.name))
}

/// The texels of a lightmap in a scene.
fn texels(data: &SceneData, name: &str, transfer: &AnyTransfer, recipe: &Recipe) -> Result<Places, String> {
    if matches!(Places::vertices(recipe), Places::WithoutAlbedo) {
        return Err(format!(
            "{name}: a lightmap without albedo; lobe render --transfer shows it, or bake it with albedo"
        ));
    }
    if recipe.unwrap.is_some() {
        return Err(format!(
            "{name}: the scene was unwrapped for it; bake it to .glb, which holds the scene with its coordinates"
        ));
    }
    let lightmap = Lightmap::new(&data.scene, transfer.receivers().isqrt());
    let lightmap = lightmap.map_err(|error| format!("{name}, on {}: {error}", data.name))?;
    Ok(Places::Texels(Arc::new(lightmap)))
}
