//! Metals and plastics of glTF: what they reflect of a sky, and how a device shows them.

use std::sync::Arc;

use lobe::io::Job;
use lobe::prt::{AlbedoMode, Transfer};
use lobe::render::{EnvironmentMapOptions, Surfaces};
use lobe_gpu::{GltfShading, GpuError, SplitSum, Storage, SurfaceShading};

use crate::loading::mode::Mode;
use crate::loading::places::Places;
use crate::loading::sky_source::OpenedSky;
use crate::loading::suns::same;
use crate::loading::task::Control;

/// What is known for surfaces that shine.
#[derive(Clone, Debug)]
pub(crate) struct Materials {
    pub(crate) reflections: Arc<SplitSum>,
    /// The part of the transfer without reflections, if it is known.
    pub(crate) direct: Option<Arc<Transfer>>,
}

impl Materials {
    /// How a device shows transfer with them; none of texels.
    pub(crate) fn shading<'a>(
        &'a self,
        transfer: &'a Transfer,
        places: &Places,
        storage: Storage,
    ) -> Option<SurfaceShading<'a>> {
        gltf_shading((transfer, self.direct.as_deref()), places, &self.reflections, storage)
    }

    /// Whether a view that is made for these shows the others.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.reflections, &other.reflections) && same(self.direct.as_ref(), other.direct.as_ref())
    }
}

/// How a device shows transfer, with its part without reflections, by materials; none of texels.
pub(crate) fn gltf_shading<'a>(
    (transfer, direct): (&'a Transfer, Option<&'a Transfer>),
    places: &Places,
    reflections: &'a SplitSum,
    storage: Storage,
) -> Option<SurfaceShading<'a>> {
    let albedo = match places {
        Places::Vertices => AlbedoMode::Vertex,
        Places::WithoutAlbedo => AlbedoMode::None,
        Places::Texels(_) => return None,
    };
    Some(SurfaceShading::Gltf(GltfShading { transfer, albedo, direct, reflections, storage }))
}

/// Whether a mode has all light that surfaces reflect.
pub(crate) fn shines(mode: Mode) -> bool {
    matches!(mode, Mode::Shadowed | Mode::Interreflected)
}

/// Prefilters a sky, without its suns if they stand apart.
///
/// # Errors
/// As [`SplitSum::of_light`].
pub(crate) fn reflections_of(sky: &OpenedSky, has_suns: bool, job: Job<'_>) -> Result<SplitSum, GpuError> {
    let size = EnvironmentMapOptions::default().surfaces(Surfaces::MetallicRoughness).size;
    let rest = if has_suns { sky.without_suns()? } else { sky.map.clone() };
    SplitSum::of_light(&rest, size, job)
}

/// The same beside the window.
pub(crate) fn prefilter(control: &Control<Arc<SplitSum>>, sky: &OpenedSky, has_suns: bool) -> Result<(), String> {
    control.stage("prefiltering".to_owned());
    let mut watch = control.watch();
    match reflections_of(sky, has_suns, Job::default().watched_by(&mut watch)) {
        Err(_) if control.is_cancelled() => {}
        made => control.send(Arc::new(made.map_err(|error| error.to_string())?)),
    }
    Ok(())
}
