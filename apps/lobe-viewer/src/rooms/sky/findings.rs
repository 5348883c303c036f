//! What the library says of the sky's expansion.

use std::sync::Arc;

use lobe::env::{MappedMap, project_map};
use lobe::image::{Picture, compare};
use lobe::prt::Transfer;
use lobe::render::{lat_long_picture, lat_long_picture_of};
use lobe::sh::{
    Coefficient as _, Expansion as _, Extremum, LightFit, LightFitOptions, Rgb, ShVec, Zonal, certified_minimum,
    convolved, extract_lights,
};

use crate::rooms::sky::edits::SkyEdits;

/// Columns and rows of the pictures that are compared.
pub(crate) const SIZE: [usize; 2] = [256, 128];

/// The part of the largest value within which a minimum is found.
const TOLERANCE: f64 = 1e-6;

/// The sky, its expansion, and what follows from it; made again where the sky or the edits changed.
pub(crate) struct Findings {
    map: Arc<MappedMap>,
    whole: ShVec<Rgb<f64>>,
    order: usize,
    taming: crate::rooms::light::Taming,
    count: usize,
    /// The expansion, tamed.
    pub(crate) light: ShVec<Rgb<f64>>,
    /// Of the irradiance that it gives.
    pub(crate) irradiance: ShVec<Rgb<f64>>,
    /// The luminance of the expansion.
    pub(crate) luminance: ShVec<f64>,
    /// Where the luminance is least.
    pub(crate) minimum: Extremum,
    /// Lights that stand for it; none below order 2.
    pub(crate) lights: Option<LightFit<Rgb<f64>>>,
    /// The sky, lat-long.
    pub(crate) picture: Picture,
    /// The expansion, lat-long.
    pub(crate) reconstruction: Picture,
    /// The root mean square of the difference of both, relative to the mean of the sky.
    pub(crate) error: f64,
    /// Grows by one with every change.
    pub(crate) version: u64,
}

impl Findings {
    /// Those of before where nothing changed, or new ones.
    pub(crate) fn of(before: Option<Self>, map: &Arc<MappedMap>, edits: &SkyEdits) -> Self {
        let (is_same_map, version) = match &before {
            Some(found) => (Arc::ptr_eq(&found.map, map), found.version + 1),
            None => (false, 0),
        };
        match before {
            Some(found)
                if is_same_map
                    && (found.order, found.taming, found.count) == (edits.order, edits.taming, edits.lights) =>
            {
                found
            }
            Some(found) if is_same_map => Self::find(map, found.whole, found.picture, edits, version),
            _ => {
                let whole = project_map(map, Transfer::MAX_ORDER);
                let picture = lat_long_picture(SIZE[0], SIZE[1], |s| map.radiance(s).widen());
                Self::find(map, whole, picture, edits, version)
            }
        }
    }

    fn find(map: &Arc<MappedMap>, whole: ShVec<Rgb<f64>>, picture: Picture, edits: &SkyEdits, version: u64) -> Self {
        let light = edits.taming.tamed(&whole.resized(edits.order));
        let luminance = light.map(Rgb::luminance);
        let reconstruction = lat_long_picture_of(SIZE[0], SIZE[1], &light);
        let options = LightFitOptions::default().count(edits.lights);
        let mean = picture.mean().iter().sum::<f64>() / 3.0;
        Self {
            map: map.clone(),
            order: edits.order,
            taming: edits.taming,
            count: edits.lights,
            irradiance: convolved(&light, &Zonal::clamped_cosine(edits.order)),
            minimum: certified_minimum(luminance.coefficients(), TOLERANCE),
            lights: if edits.lights > 0 { extract_lights(&light, &options).ok() } else { None },
            error: compare(reconstruction.pixels(), picture.pixels()).rmse / mean.max(1e-12),
            whole,
            light,
            luminance,
            picture,
            reconstruction,
            version,
        }
    }

    /// The map.
    pub(crate) fn map(&self) -> &Arc<MappedMap> {
        &self.map
    }
}
