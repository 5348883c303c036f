//! The parameters of the room of skies, which a user changes.

use lobe::env::Mapping;
use lobe::prt::Transfer;
use lobe::sh::{Expansion as _, Rgb, ShVec};
use serde::{Deserialize, Serialize};

use crate::rooms::light::Taming;
use crate::widgets::coefficient_table::MOST;
use crate::widgets::within::within;

/// The most lights that are looked for.
pub(crate) const MOST_LIGHTS: usize = 4;

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
    /// Lights that are looked for in the expansion.
    pub lights: usize,
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
        self.exposure = within(self.exposure, -8.0..=8.0, first.exposure);
        if Mapping::from_name(&self.mapping).is_none() {
            self.mapping = first.mapping;
        }
        self.own.retain(|own| {
            own.number < Transfer::MAX_ORDER * Transfer::MAX_ORDER && own.value.iter().all(|c| c.abs() <= MOST)
        });
        self.own.sort_by_key(|own| own.number);
        self.own.dedup_by_key(|own| own.number);
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
        Self { order: 4, taming: Taming::None, mapping: "octahedral".into(), exposure: 0.0, lights: 2, own: Vec::new() }
    }
}
