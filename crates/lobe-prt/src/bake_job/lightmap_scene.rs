//! The scene of a lightmap: with its own texture coordinates, or unwrapped into others.

use lobe_io::{Job, OptionError};
use lobe_scene::{GltfDocument, Scene, UnwrapOptions};

use crate::bake_job::bake_job::{BakeJob, UnwrapMode};
use crate::error::PrtError;
use crate::files::lightmap_glb::LightmapGlb;
use crate::receivers::texel_receivers::TexelReceivers;

/// The lightmap that is baked, if one is.
#[derive(Debug, Default)]
pub(crate) struct LightmapScene {
    /// How the scene was unwrapped, if it was.
    pub(crate) options: Option<UnwrapOptions>,
    /// The .glb that waits for its texels, if that is the output.
    pub(crate) glb: Option<LightmapGlb>,
    /// What came of unwrapping, if the scene was.
    pub(crate) note: Option<String>,
}

/// The scene with texture coordinates for a lightmap of `width` texels. For a .glb, that which waits for its texels:
/// all that the file holds, or the scene alone.
pub(crate) fn lightmap_scene(
    job: &BakeJob,
    (scene, document): (Scene, Option<GltfDocument>),
    width: usize,
    mut work: Job<'_>,
) -> Result<(Scene, LightmapScene), PrtError> {
    let whole =
        |unwrapped: &Scene| document.and_then(|document| LightmapGlb::of_document(document, &scene, unwrapped, width));
    let (found, options, note) = match unwrapped(job, &scene, width, work.reborrow())? {
        Some((found, options, note)) => (Some(found), Some(options), Some(note)),
        None => (None, None, None),
    };
    let unwrapped = found.as_ref().unwrap_or(&scene);
    // Without an output nobody knows yet.
    let glb = (job.is_glb() || job.output.is_none()).then(|| whole(unwrapped));
    if let Some(None) = glb
        && job.source.is_gltf()
    {
        let text = "unwrapped, so what the file holds beside its triangles and their materials is left out";
        work.note(&job.source.name(), text);
    }
    let glb = glb.map(|glb| glb.unwrap_or_else(|| LightmapGlb::of_scene(unwrapped, width)));
    Ok((found.unwrap_or(scene), LightmapScene { options, glb, note }))
}

/// A scene that was unwrapped, how, and what came of it.
type Unwrapped = (Scene, UnwrapOptions, String);

/// The scene unwrapped, if it is to be.
fn unwrapped(job: &BakeJob, scene: &Scene, width: usize, mut work: Job<'_>) -> Result<Option<Unwrapped>, PrtError> {
    let name = job.source.name();
    job.memory().check(&format!("@texels {width}"), TexelReceivers::bytes_for(width), "fewer @texels")?;
    let own = TexelReceivers::check(scene, width);
    let why = match (job.unwrap, own) {
        (UnwrapMode::Never, Ok(())) => return Ok(None),
        (UnwrapMode::Never, Err(error)) => {
            return Err(OptionError::new("", format!("{error}; @unwrap auto makes others")).into());
        }
        (UnwrapMode::Auto, Ok(())) if !job.shapes_charts() => return Ok(None),
        (UnwrapMode::Auto, Err(error)) => format!("its own coordinates hold no lightmap ({error})"),
        _ => "as asked for".to_owned(),
    };
    let options = job.unwrapping(width);
    let bytes = scene.bytes_to_unwrap(&options);
    job.memory().check(&format!("unwrapping {name}"), bytes, "a scene of fewer triangles")?;
    let (unwrapped, report) = scene.unwrapped(&options, work.step("unwrap"))?;
    // What is wrong with coordinates that were just made is no fault of the scene.
    TexelReceivers::check(&unwrapped, width)?;
    let text = format!(
        "unwrapped into {} charts, {why}; a texel is {} wide and {:.0} % of them show surfaces; vertices: {}, {} before",
        report.charts,
        three_digits(report.texel_size),
        100.0 * report.coverage,
        report.vertices,
        report.vertices_before
    );
    Ok(Some((unwrapped, options, text)))
}

/// A length with three digits that count.
fn three_digits(length: f64) -> String {
    let before = length.log10().floor();
    if before.abs() > 6.0 { format!("{length:.2e}") } else { format!("{length:.*}", (2.0 - before).max(0.0) as usize) }
}
