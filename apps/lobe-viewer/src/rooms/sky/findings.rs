//! Numbers of the sky's expansion: errors, minimum, lights.

use std::sync::Arc;

use lobe::env::MappedMap;
use lobe::figures::{lat_long_picture, lat_long_picture_of};
use lobe::image::{Picture, compare};
use lobe::sh::extrema::{Extremum, certified_minimum};
use lobe::sh::light_extraction::{LightFit, LightFitOptions, extract_lights};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal};

use crate::loading::sky_source::OpenedSky;
use crate::rooms::sky::edits::{OwnCoefficient, SkyEdits};
use crate::rooms::taming::Taming;

/// Columns and rows of the pictures that are compared.
pub(crate) const SIZE: [usize; 2] = [256, 128];

/// The part of the largest value within which a minimum is found.
const TOLERANCE: f64 = 1e-6;

/// The sky, its expansion, and what follows from it; made again where the sky or the edits changed.
pub(crate) struct Findings {
    map: Arc<MappedMap>,
    whole: Arc<ShVec<Rgb<f64>>>,
    key: Key,
    /// By which sky and expansion are turned.
    turn: Rotation,
    back: Rotation,
    /// The expansion, tamed, with what was typed, turned.
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
    pub(crate) fn of(before: Option<Self>, sky: &OpenedSky, edits: &SkyEdits, turn: Rotation) -> Self {
        let (map, key) = (&sky.map, Key::of(edits));
        let (is_same_map, version) = match &before {
            Some(found) => (Arc::ptr_eq(&found.map, map), found.version + 1),
            None => (false, 0),
        };
        match before {
            Some(found) if is_same_map && found.key == key && found.turn == turn => found,
            Some(found) if is_same_map && found.turn == turn => Self::find(sky, found.picture, (edits, turn), version),
            _ => Self::find(sky, seen(map, turn), (edits, turn), version),
        }
    }

    fn find(sky: &OpenedSky, picture: Picture, (edits, turn): (&SkyEdits, Rotation), version: u64) -> Self {
        let light = edits.replaced(edits.taming.tamed(&sky.light.resized(edits.order))).rotated(&turn);
        let luminance = light.map(Rgb::luminance);
        let reconstruction = lat_long_picture_of(SIZE[0], SIZE[1], &light);
        let options = LightFitOptions::default().count(edits.lights);
        let mean = picture.mean().iter().sum::<f64>() / 3.0;
        Self {
            map: sky.map.clone(),
            whole: sky.light.clone(),
            key: Key::of(edits),
            turn,
            back: turn.inverse(),
            irradiance: light.convolved(&Zonal::clamped_cosine(edits.order)),
            minimum: certified_minimum(luminance.coefficients(), TOLERANCE),
            lights: if edits.lights > 0 { extract_lights(&light, &options).ok() } else { None },
            error: compare(reconstruction.pixels(), picture.pixels()).rmse / mean.max(1e-12),
            light,
            luminance,
            picture,
            reconstruction,
            version,
        }
    }

    /// The expansion of the sky to the highest order, turned and nothing else.
    pub(crate) fn whole_light(&self) -> ShVec<Rgb<f64>> {
        self.whole.rotated(&self.turn)
    }

    /// The radiance of the sky, turned.
    pub(crate) fn radiance(&self, s: Dir) -> Rgb<f64> {
        self.map.radiance(self.back.rotate_dir(s)).widen()
    }

    /// From the world to the frame of the sky.
    pub(crate) fn back(&self) -> Rotation {
        self.back
    }
}

/// The edits from which the findings follow.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    order: usize,
    taming: Taming,
    lights: usize,
    own: Vec<OwnCoefficient>,
}

impl Key {
    fn of(edits: &SkyEdits) -> Self {
        let SkyEdits { order, taming, lights, .. } = *edits;
        Self { order, taming, lights, own: edits.own.clone() }
    }
}

/// A turned sky, lat-long.
fn seen(map: &MappedMap, turn: Rotation) -> Picture {
    let back = turn.inverse();
    lat_long_picture(SIZE[0], SIZE[1], |s| map.radiance(back.rotate_dir(s)).widen())
}
