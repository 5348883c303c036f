//! Files of transfer for the scene that is open.

use std::path::Path;
use std::sync::Arc;

use lobe::prt::TransferMatrices;

use crate::loading::bake::{GlossyBake, SceneData, SceneNews, shining, vertices_of};
use crate::loading::kept_transfer::{KeptTransfer, to_vectors};
use crate::loading::limits::ReadLimits;
use crate::loading::task::Control;

/// Reads a file of transfer or of transfer matrices for the scene that is open.
pub(crate) fn adopt(
    control: &Control<SceneNews>,
    data: &SceneData,
    path: &Path,
    limits: &ReadLimits,
) -> Result<(), String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    control.stage(name.clone());
    let news = match KeptTransfer::read(data, path, limits)? {
        KeptTransfer::Matrices(matrices) => SceneNews::Glossy(meshes_of(data, &name, &matrices)?),
        KeptTransfer::Vectors(transfer, recipe, places) => {
            SceneNews::of_file(to_vectors(transfer, &name, limits)?, &recipe, places)
        }
    };
    control.send(news);
    Ok(())
}

/// The matrices of the meshes that shine, of those of all vertices.
fn meshes_of(data: &SceneData, name: &str, matrices: &TransferMatrices) -> Result<Vec<GlossyBake>, String> {
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
