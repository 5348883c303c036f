//! The backs of `lobe bake --backs`: baked after the fronts, in a checkpoint of their own.

use lobe::prt::{BakeOptions, Channels, FittedVertices, Transfer, double_sided_vertices};
use lobe::scene::{Bvh, Scene};

use crate::run::bake_watch::Checkpoint;
use crate::run::talk::Talk;

/// The transfer of the backs of all double-sided vertices, and the file that it is fitted from; none of a scene without
/// any.
pub(super) fn baked_backs(
    scene: &Scene,
    options: &BakeOptions,
    channels: Channels,
    (fronts, is_fresh): (&Checkpoint, bool),
    talk: Talk,
) -> anyhow::Result<Option<(Transfer, Checkpoint)>> {
    let vertices = double_sided_vertices(scene);
    if vertices.is_empty() {
        return Ok(None);
    }
    let mut path = fronts.path().as_os_str().to_owned();
    path.push(".backs");
    let checkpoint = Checkpoint::at(path.into());
    if is_fresh {
        checkpoint.discard()?;
    }
    let (bvh, options) = (Bvh::new(scene), options.clone().channels(Some(channels)));
    let vertices = FittedVertices::backs(scene, &vertices)?;
    let (backs, _) = checkpoint.watched(talk, |job| vertices.bake(&bvh, &options, job))?;
    Ok(Some((backs, checkpoint)))
}
