//! Suns beside the expansion of a light, and the transfer without reflections that they need.

use std::sync::Arc;

use lobe::io::Job;
use lobe::prt::{PrtError, Recipe, TexelReceivers, Transfer, bake, bake_vertices};
use lobe_gpu::SunsApart;

use crate::loading::bake::{SceneData, SceneNews};
use crate::loading::mode::Mode;
use crate::loading::places::Places;
use crate::loading::task::Control;

/// Suns of a picture, and what they need there.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShownSuns {
    count: usize,
    mode: Mode,
    is_lit_by_transfer: bool,
    direct: Option<Arc<Transfer>>,
}

impl ShownSuns {
    /// So many suns in a mode, if they can be apart from the expansion there; else none.
    pub(crate) fn new(count: usize, mode: Mode, is_lit_by_transfer: bool, direct: Option<&Arc<Transfer>>) -> Self {
        let suns = Self { count: count.min(SunsApart::MOST), mode, is_lit_by_transfer, direct: direct.cloned() };
        if matches!(suns.apart(), SunsApart::No) { Self::default() } else { suns }
    }

    /// Whether there are any.
    pub(crate) fn is_any(&self) -> bool {
        self.count > 0
    }

    /// How a device shows them.
    pub(crate) fn apart(&self) -> SunsApart<'_> {
        suns_apart(self.mode, self.is_lit_by_transfer, self.direct.as_deref(), self.count)
    }

    /// Whether a view that is made for these shows the others.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        (self.count, self.mode, self.is_lit_by_transfer) == (other.count, other.mode, other.is_lit_by_transfer)
            && same(self.direct.as_ref(), other.direct.as_ref())
    }
}

/// Whether both are one in memory, or none.
pub(crate) fn same<T>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// How so many suns are shown in a mode. Without what they need they are in the expansion: the part of the transfer
/// that is without reflections, where interreflections are shown. `is_lit_by_transfer` is false for a picture that
/// stands in for one by transfer, which is by normals alone.
pub(crate) fn suns_apart(
    mode: Mode,
    is_lit_by_transfer: bool,
    direct: Option<&Transfer>,
    suns: usize,
) -> SunsApart<'_> {
    match (mode, direct) {
        _ if suns == 0 => SunsApart::No,
        (Mode::Irradiance, _) => SunsApart::Unshadowed,
        _ if !is_lit_by_transfer => SunsApart::Unshadowed,
        (Mode::Shadowed, _) => SunsApart::Shadowed(suns),
        (Mode::Interreflected, Some(direct)) => SunsApart::Reflected(suns, direct),
        _ => SunsApart::No,
    }
}

/// Bakes the part without reflections of transfer of a file, in a window.
pub(crate) fn open_direct(
    control: &Control<SceneNews>,
    data: &SceneData,
    of: (&Recipe, usize),
    places: &Places,
) -> Result<(), String> {
    control.stage("direct transfer".to_owned());
    let mut watch = control.watch();
    match bake_direct(data, of, places, Job::default().watched_by(&mut watch)) {
        Err(PrtError::Cancelled) => {}
        direct => control.send(SceneNews::Direct(Arc::new(direct.map_err(|error| error.to_string())?))),
    }
    Ok(())
}

/// Bakes the part without reflections of transfer that was baked by a recipe, of this order, by the first parts of
/// its paths.
///
/// # Errors
/// As [`bake_vertices`].
pub(crate) fn bake_direct(
    data: &SceneData,
    (recipe, order): (&Recipe, usize),
    places: &Places,
    job: Job<'_>,
) -> Result<Transfer, PrtError> {
    let options = recipe.bake_options().order(order).of_direct_part(None);
    match places {
        Places::Vertices | Places::WithoutAlbedo => Ok(bake_vertices(&data.scene, &data.bvh, &options, job)?.0),
        Places::Texels(lightmap) => {
            let texels = TexelReceivers::new(&data.scene, lightmap.width())?;
            let (transfer, _) = bake(&data.scene, &data.bvh, texels.receivers(), &options, job)?;
            let finish = recipe.finish_options();
            let transfer = match finish.is_asked() {
                true => texels.finished(&data.scene, transfer, &finish)?.0,
                false => transfer,
            };
            texels.picture(&transfer)
        }
    }
}
