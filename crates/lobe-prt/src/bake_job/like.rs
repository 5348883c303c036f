//! The job that made a baked file, by its recipe.

use std::path::{Path, PathBuf};

use lobe_io::{OptionError, read_file};
use lobe_scene::{BUILT_IN, GltfReader, SceneReadOptions, SceneSource, is_gltf};

use crate::bake::options::{AlbedoMode, BakeMode};
use crate::bake_job::bake_job::{BakeJob, UnwrapMode, ends_in};
use crate::compression::compression_options::CompressionOptions;
use crate::error::PrtError;
use crate::files::baked_extras::said;
use crate::files::compressed_file::COMPRESSED;
use crate::files::lightmap_file::read_lightmap;
use crate::files::matrix_file::{MATRICES, NEIGHBORHOOD};
use crate::files::tensor_file::TransferFile;
use crate::files::transfer_file::TRANSFER;
use crate::recipe::Recipe;

impl Recipe {
    /// The recipe of a baked .glb, of a .safetensors file of transfer, or of an .exr picture of texels.
    ///
    /// # Errors
    /// [`PrtError::Scene`] and [`PrtError::Io`] if the file cannot be read, [`PrtError::Invalid`] if it is none of these.
    pub fn of_file(path: impl AsRef<Path>) -> Result<Self, PrtError> {
        let path = path.as_ref();
        let place = path.display().to_string();
        if ends_in(path, "exr") {
            return read_lightmap(path).map(|(_, recipe)| recipe);
        }
        if !is_gltf(path) {
            let bytes = read_file(path)?;
            let formats = [TRANSFER, COMPRESSED, MATRICES, NEIGHBORHOOD];
            return Ok(TransferFile::parse(&bytes, &place, &formats)?.header.recipe);
        }
        let gltf = GltfReader::open(path, &SceneReadOptions::default())?;
        match said(&gltf, "recipe").clone() {
            recipe if recipe.is_object() => Ok(recipe.into()),
            _ => Err(PrtError::invalid(&place, "expected a baked scene, found one without transfer")),
        }
    }
}

impl BakeJob {
    /// The job that made a baked file: all that decides the numbers of its transfer, without an output. The scene is
    /// looked for in the folder of the file; where it is not, `scene` is its name alone.
    ///
    /// # Errors
    /// Those of [`Recipe::of_file`]; [`PrtError::OfJob`] for results that a bake alone does not give, such as lobes.
    pub fn like(path: impl AsRef<Path>) -> Result<Self, PrtError> {
        let path = path.as_ref();
        let recipe = Recipe::of_file(path)?;
        let is_rounded = recipe.compressed_by.is_some() && recipe.clusters.is_none();
        let made = recipe.lobes.map(|_| "lobes").or(is_rounded.then_some("numbers of 16 bits"));
        if let Some(made) = made {
            let message = format!("{}: expected what a bake writes, found {made} that were made of it", path.display());
            return Err(OptionError::new("", message).into());
        }
        Ok(Self::of_recipe(&recipe, path))
    }

    /// The job of a recipe in a file, whose scene may be beside it.
    fn of_recipe(recipe: &Recipe, baked: &Path) -> Self {
        let defaults = Self::default();
        let mut source = SceneSource::of(scene_of(recipe, baked));
        source.up = recipe.up.unwrap_or(source.up);
        source.missing_normals = recipe.missing_normals;
        source.default_material = recipe.default_material.unwrap_or(source.default_material);
        source.transparency = recipe.straight_through == Some(true);
        (source.time, source.animation) = (recipe.time, recipe.animation.clone());
        let mode = recipe.mode.unwrap_or(defaults.mode);
        let is_at_vertices = recipe.texels.is_none() && recipe.grid.is_none();
        let is_split = recipe.adaptive.is_some();
        let has_matrices = mode == BakeMode::Glossy || recipe.grid.is_some();
        let albedo = match recipe.albedo.as_deref() {
            _ if has_matrices => None,
            Some(_) => Some(AlbedoMode::None),
            None => Some(AlbedoMode::Vertex),
        };
        let unwrap = recipe.unwrap.clone().unwrap_or_default();
        Self {
            source,
            mode,
            order: recipe.order.unwrap_or(defaults.order),
            samples: recipe.samples,
            bounces: recipe.bounces.filter(|_| mode.reflects()).unwrap_or(defaults.bounces),
            energy_stop: recipe.energy_stop.filter(|_| mode.reflects()).unwrap_or(defaults.energy_stop),
            seed: recipe.seed.unwrap_or(defaults.seed),
            albedo,
            backs: recipe.backs == Some(true),
            parts: recipe.parts.unwrap_or_default(),
            max_edge: recipe.max_edge,
            adaptive: recipe.adaptive,
            min_edge: recipe.min_edge,
            max_vertices: recipe.max_vertices.filter(|_| is_split),
            no_split: is_at_vertices && !is_split && mode != BakeMode::Glossy,
            texels: recipe.texels,
            unwrap: if recipe.unwrap.is_some() { UnwrapMode::Always } else { UnwrapMode::Auto },
            padding: unwrap.padding,
            texel_size: unwrap.texel_size,
            chart_angle: unwrap.chart_angle,
            denoise: if recipe.texels.is_some() { recipe.denoised == Some(true) } else { defaults.denoise },
            grid: recipe.grid,
            grid_box: recipe.grid_box,
            packing: CompressionOptions::default()
                .clusters(recipe.clusters)
                .components(recipe.components)
                .weights(recipe.weights),
            ..defaults
        }
    }
}

/// The scene of a recipe: a built-in one, its file beside the baked one if that is another, or else the name alone. A
/// recipe names no folder.
fn scene_of(recipe: &Recipe, baked: &Path) -> PathBuf {
    let name = recipe.scene.clone().unwrap_or_default();
    if name.starts_with(BUILT_IN) {
        return name.into();
    }
    let Some(name) = Path::new(&name).file_name() else { return PathBuf::new() };
    let beside = baked.with_file_name(name);
    if beside != baked && beside.exists() { beside } else { name.into() }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use lobe_io::{Job, JobOptions as _};
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn a_job_like_a_baked_file_gives_its_bytes_again() {
        let folder = tempfile::tempdir().unwrap();
        for (asked, ending) in [
            (json!({"max_vertices": 7100}), "glb"),
            (json!({"no_split": true, "mode": "shadowed", "albedo": "none"}), "glb"),
            (json!({"clusters": 3, "weights": 8, "no_split": true}), "safetensors"),
            (json!({"mode": "glossy"}), "safetensors"),
            (json!({"grid": [2, 3, 2], "grid_box": [0, 0, 0, 1, 1, 1], "seed": 7}), "safetensors"),
            (json!({"texels": 24, "padding": 1}), "exr"),
            (json!({"texels": 24, "unwrap": "always", "denoise": false}), "glb"),
        ] {
            let Value::Object(mut values) = asked.clone() else { panic!("expected a table") };
            values.extend([("scene".to_owned(), json!("built-in:cornell")), ("order".to_owned(), json!(2))]);
            values.insert("samples".to_owned(), json!(4));
            let [first, again] = ["first", "again"].map(|name| folder.path().join(format!("{name}.{ending}")));
            BakeJob::from_values(values).unwrap().output(Some(first.clone())).run(Job::default()).unwrap();
            let job = BakeJob::like(&first).unwrap().output(Some(again.clone()));
            job.check().unwrap();
            assert_eq!(BakeJob::from_values(job.values()).as_ref(), Ok(&job), "{asked}: as a file");
            job.run(Job::default()).unwrap();
            assert!(fs::read(&again).unwrap() == fs::read(&first).unwrap(), "{asked}: other bytes by {job:?}");
        }
    }
}
