//! The parameters of the room of skies, which a user changes.

use lobe::env::Mapping;
use lobe::image::Curve;
use lobe::prt::Transfer;
use lobe::sh::{Expansion as _, Rgb, Rotation, ShVec};
use serde::{Deserialize, Serialize};

use crate::rooms::formulas::Formula;
use crate::rooms::light::{LightHand, MOST_STOPS, sky_rotation};
use crate::rooms::taming::Taming;
use crate::widgets::coefficient_table::MOST;
use crate::widgets::tone::Look;
use crate::widgets::within::within;

/// The most lights that are looked for.
pub(crate) const MOST_LIGHTS: usize = 4;

/// The most suns that are taken out.
pub(crate) const MOST_SUNS: usize = 8;

/// What is shown below the sky.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Shelf {
    /// The sky, its expansion and its mappings.
    #[default]
    Maps,
    /// Mirrors, glossy and matte balls by each technique.
    Techniques,
    /// Matte balls by each encoding of irradiance.
    Encodings,
}

impl Shelf {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Maps, Self::Techniques, Self::Encodings];

    /// The name in the window.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Maps => "Maps and expansion",
            Self::Techniques => "Balls by each technique",
            Self::Encodings => "Encodings of irradiance",
        }
    }
}

/// All that is kept from one start to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct SkyEdits {
    /// Number of bands.
    pub order: usize,
    /// What is done to the expansion.
    pub taming: Taming,
    /// The name of the mapping that is shown unfolded.
    pub mapping: String,
    /// Stops of exposure.
    pub exposure: f64,
    /// The tone curve.
    #[serde(with = "crate::rooms::curve")]
    pub tone: Curve,
    /// By which the sky is turned about +z, in radians.
    pub turn: f64,
    /// By which it is tilted about +x before that, in radians.
    pub tilt: f64,
    /// Lights that are looked for in the expansion.
    pub lights: usize,
    /// Suns that are taken out of the sky, by azimuth and height as it has them, in degrees.
    pub suns: Vec<[f64; 2]>,
    /// Whether the balls before the sky are lit by its expansion, and not by itself.
    pub has_expansion: bool,
    /// What is shown below the sky.
    pub shelf: Shelf,
    /// Coefficients that were typed, in the place of those of the sky.
    pub own: Vec<OwnCoefficient>,
}

/// A coefficient that was typed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OwnCoefficient {
    /// Its number, `l (l + 1) + m`.
    pub number: usize,
    /// Red, green and blue.
    pub value: [f64; 3],
}

impl SkyEdits {
    /// Brings its numbers into their ranges, and forgets what names nothing.
    pub(crate) fn check(&mut self) {
        let first = Self::default();
        self.order = self.order.clamp(1, Transfer::MAX_ORDER);
        self.lights = self.lights.min(MOST_LIGHTS);
        self.taming.check();
        self.exposure = within(self.exposure, -MOST_STOPS..=MOST_STOPS, first.exposure);
        self.turn = within(self.turn, 0.0..=std::f64::consts::TAU, first.turn);
        self.tilt = within(self.tilt, -std::f64::consts::PI..=std::f64::consts::PI, first.tilt);
        self.suns.truncate(MOST_SUNS);
        for [azimuth, height] in &mut self.suns {
            *azimuth = within(*azimuth, -180.0..=180.0, 0.0);
            *height = within(*height, -90.0..=90.0, 0.0);
        }
        if Mapping::from_name(&self.mapping).is_none() {
            self.mapping = first.mapping;
        }
        self.own.retain(|own| {
            own.number < Transfer::MAX_ORDER * Transfer::MAX_ORDER && own.value.iter().all(|c| c.abs() <= MOST)
        });
        self.own.sort_by_key(|own| own.number);
        self.own.dedup_by_key(|own| own.number);
    }

    /// Whether a ball that is shown is lit by a technique: those in their rows, or those before the sky.
    pub(crate) fn needs_techniques(&self) -> bool {
        self.shelf == Shelf::Techniques || !self.has_expansion
    }

    /// The rotation of the sky.
    #[must_use]
    pub fn rotation(&self) -> Rotation {
        sky_rotation(self.turn, self.tilt)
    }

    /// What is computed of the sky that is shown.
    pub(crate) fn formulas(&self) -> Vec<Formula> {
        let shelf = match self.shelf {
            Shelf::Maps => &[][..],
            Shelf::Techniques => {
                &[Formula::MIRROR, Formula::BUMPS, Formula::SPLIT_SUM, Formula::HIGHLIGHTS, Formula::IRRADIANCE]
            }
            Shelf::Encodings => &[Formula::IRRADIANCE, Formula::ZH3, Formula::AMBIENT_CUBE, Formula::H_BASIS],
        };
        let lights = (self.lights > 0).then_some(Formula::LIGHTS);
        let expansion = [Some(Formula::PROJECTION), self.taming.formula(), lights];
        expansion.into_iter().flatten().chain(shelf.iter().copied()).collect()
    }

    /// How light is shown.
    pub(crate) fn look(&self) -> Look {
        Look { stops: self.exposure, curve: self.tone }
    }

    /// Its light, to be changed.
    pub(crate) fn light(&mut self) -> LightHand<'_> {
        let Self { order, taming, turn, tilt, exposure, tone, .. } = self;
        let (taming, exposed) = (Some(taming), Some((exposure, tone)));
        LightHand { order, most_order: Transfer::MAX_ORDER, taming, turn, tilt, exposed }
    }

    /// Forgets what belongs to the sky that was there.
    pub(crate) fn forget_sky(&mut self) {
        self.own.clear();
        self.suns.clear();
    }

    /// Puts a coefficient in the place of that of the sky.
    pub fn replace(&mut self, number: usize, value: Rgb<f64>) {
        let value = value.into();
        match self.own.iter_mut().find(|own| own.number == number) {
            Some(own) => own.value = value,
            None => self.own.push(OwnCoefficient { number, value }),
        }
    }

    /// An expansion with the coefficients that were typed; those above its order have no place in it.
    #[must_use]
    pub fn replaced(&self, mut light: ShVec<Rgb<f64>>) -> ShVec<Rgb<f64>> {
        for own in &self.own {
            if let Some(coefficient) = light.coefficients_mut().get_mut(own.number) {
                *coefficient = own.value.into();
            }
        }
        light
    }
}

impl Default for SkyEdits {
    fn default() -> Self {
        Self {
            order: 4,
            taming: Taming::None,
            mapping: "octahedral".into(),
            exposure: 0.0,
            tone: Curve::default(),
            turn: 0.0,
            tilt: 0.0,
            lights: 2,
            suns: Vec::new(),
            has_expansion: false,
            shelf: Shelf::Maps,
            own: Vec::new(),
        }
    }
}
