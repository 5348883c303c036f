//! Files of transfer for the scene that is open.

use std::path::Path;
use std::sync::Arc;

use lobe::image::ExrLayers;
use lobe::io::read_file;
use lobe::prt::{
    AnyTransfer, Lightmap, PrtError, Recipe, Transfer, TransferMatrices, read_any_transfer_bytes, read_matrices_bytes,
};

use crate::loading::bake::{GlossyBake, SceneData, SceneNews, shining, vertices_of};
use crate::loading::file_kind::FileKind;
use crate::loading::limits::ReadLimits;
use crate::loading::place::given;
use crate::loading::places::Places;
use crate::loading::task::Control;

/// Bytes in memory for each of a file of numbers while it is read: it, its numbers, and what is made of them.
const COPIES: u64 = 3;

/// Reads a file of transfer or of transfer matrices for the scene that is open.
pub(crate) fn adopt(
    control: &Control<SceneNews>,
    data: &SceneData,
    path: &Path,
    limits: &ReadLimits,
) -> Result<(), String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    control.stage(name.clone());
    let bytes = match given(path) {
        Some(bytes) => bytes,
        None => {
            let length = std::fs::metadata(path).map_or(0, |file| file.len());
            limits.check_memory(&name, COPIES.saturating_mul(length))?;
            Arc::from(read_file(path).map_err(|error| error.to_string())?)
        }
    };
    let line = |error: PrtError| error.to_string();
    let news = if FileKind::of(path)? == FileKind::Matrices {
        let (matrices, _) = read_matrices_bytes(&bytes, &name).map_err(line)?;
        SceneNews::Glossy(meshes_of(data, &name, &matrices)?)
    } else {
        let is_lightmap = FileKind::is_lightmap(path);
        if is_lightmap {
            let numbers = ExrLayers::bytes_in_memory(&bytes, &name).map_err(|error| error.to_string())?;
            limits.check_memory(&name, COPIES.saturating_mul(numbers))?;
        }
        let (transfer, recipe) = read_any_transfer_bytes(&bytes, &name).map_err(line)?;
        if !is_lightmap {
            // Before clusters or lobes are made into vectors, of which a small file can hold many.
            expect_vertices(data, &format!("{name}: transfer"), transfer.receivers())?;
            let numbers = 3 * transfer.receivers() * transfer.order().pow(2);
            limits.check_memory(&name, (size_of::<f32>() * numbers) as u64)?;
        }
        let transfer = match transfer {
            AnyTransfer::Plain(transfer) => transfer,
            AnyTransfer::Compressed(compressed) => compressed.to_transfer(),
            AnyTransfer::Zonal(lobes) => lobes.to_transfer(),
        };
        let places = if is_lightmap { texels(data, &name, &transfer, &recipe)? } else { Places::vertices(&recipe) };
        SceneNews::of_file(transfer, &recipe, places)
    };
    control.send(news);
    Ok(())
}

fn expect_vertices(data: &SceneData, what: &str, found: usize) -> Result<(), String> {
    let expected = data.scene.vertex_count();
    if found == expected {
        return Ok(());
    }
    let advice = "open the scene that it was baked from first";
    Err(format!("{what} of {found} receivers, but {} has {expected} vertices; {advice}", data.name))
}

/// The texels of a lightmap in the scene that is open.
fn texels(data: &SceneData, name: &str, transfer: &Transfer, recipe: &Recipe) -> Result<Places, String> {
    if matches!(Places::vertices(recipe), Places::WithoutAlbedo) {
        return Err(format!(
            "{name}: a lightmap without albedo; lobe render --transfer shows it, or bake it with albedo"
        ));
    }
    let lightmap = Lightmap::new(&data.scene, transfer.receivers().isqrt());
    let lightmap = lightmap.map_err(|error| format!("{name}, on {}: {error}", data.name))?;
    Ok(Places::Texels(Arc::new(lightmap)))
}

/// The matrices of the meshes that shine, of those of all vertices.
fn meshes_of(data: &SceneData, name: &str, matrices: &TransferMatrices) -> Result<Vec<GlossyBake>, String> {
    expect_vertices(data, &format!("{name}: transfer matrices"), matrices.points())?;
    let meshes = shining(&data.scene);
    if meshes.is_empty() {
        return Err(format!(
            "{name}: no metal of {} shines here; lobe render --transfer shows all of it by one lobe",
            data.name
        ));
    }
    let numbers = matrices.coefficients().len() / matrices.points().max(1);
    let own = |mesh: usize| {
        let of = vertices_of(&data.scene, mesh);
        let rows = matrices.coefficients()[numbers * of.start..numbers * of.end].to_vec();
        TransferMatrices::new(matrices.order(), matrices.channels(), rows).map_err(|error| error.to_string())
    };
    let baked = |(mesh, lobe)| Ok(GlossyBake { mesh, lobe, matrices: Arc::new(own(mesh)?) });
    meshes.into_iter().map(baked).collect()
}
