//! Lamps as files hold them: of one light, or of one that changes with time.

use std::borrow::Cow;

use lobe_sh::Rgb;

use crate::error::ShadowError;
use crate::field::patch_field::PatchField;
use crate::field::radiance_field::RadianceField;

/// The light of a lamp around it, which stands or changes.
#[derive(Clone, Debug)]
pub enum Lamp {
    /// One light.
    Still(RadianceField),
    /// A rectangle on which pictures follow each other.
    Sequence(LampSequence),
}

impl Lamp {
    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        match self {
            Self::Still(field) => field.order(),
            Self::Sequence(sequence) => sequence.patches().order(),
        }
    }

    /// Its light at a time in seconds. A sequence repeats, before 0 too.
    ///
    /// # Errors
    /// As [`LampSequence::at`].
    pub fn at(&self, time: f64) -> Result<Cow<'_, RadianceField>, ShadowError> {
        match self {
            Self::Still(field) => Ok(Cow::Borrowed(field)),
            Self::Sequence(sequence) => sequence.at(time).map(Cow::Owned),
        }
    }
}

/// A [`PatchField`] and the radiance of its patches in each picture of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct LampSequence {
    patches: PatchField,
    /// For each picture the radiance of each patch, row by row.
    pictures: Vec<Vec<Rgb<f32>>>,
    per_second: f64,
}

impl LampSequence {
    /// A sequence of `per_second` pictures, each as the radiance of the patches ([`PatchField::patch_colors`]).
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if there is no picture, one does not have a finite radiance for each patch, or the pictures in
    /// a second are not a finite number above 0.
    pub fn new(patches: PatchField, pictures: Vec<Vec<Rgb<f32>>>, per_second: f64) -> Result<Self, ShadowError> {
        let invalid = |message: String| Err(ShadowError::Invalid { place: "lamp".to_owned(), message });
        let [columns, rows] = patches.patches();
        if pictures.is_empty() {
            return invalid("expected one picture at least, found none".to_owned());
        }
        if !(per_second.is_finite() && per_second > 0.0) {
            return invalid(format!("expected a number of pictures in a second above 0, found {per_second}"));
        }
        for (k, colors) in pictures.iter().enumerate() {
            let expected = columns * rows;
            if colors.len() != expected {
                let found = colors.len();
                return invalid(format!("expected {expected} patches of picture {k}, found {found}"));
            }
            if let Some(bad) = colors.iter().find(|c| !c.to_array().iter().all(|c| c.is_finite())) {
                return invalid(format!("expected finite radiance of picture {k}, found {bad:?}"));
            }
        }
        Ok(Self { patches, pictures, per_second })
    }

    /// The rectangle.
    #[must_use]
    pub fn patches(&self) -> &PatchField {
        &self.patches
    }

    /// For each picture the radiance of each patch, row by row.
    #[must_use]
    pub fn pictures(&self) -> &[Vec<Rgb<f32>>] {
        &self.pictures
    }

    /// Pictures in a second.
    #[must_use]
    pub fn per_second(&self) -> f64 {
        self.per_second
    }

    /// The light at a time in seconds: that of picture `⌊time · per_second⌋`, counted on from the first after the last.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the time is not finite, [`ShadowError::Invalid`] if the light is not.
    pub fn at(&self, time: f64) -> Result<RadianceField, ShadowError> {
        let place = (time * self.per_second).floor();
        if !place.is_finite() {
            return Err(ShadowError::Options(format!("expected a finite time, found {time}")));
        }
        let k = place.rem_euclid(self.pictures.len() as f64) as usize % self.pictures.len();
        let colors: Vec<Rgb<f64>> = self.pictures[k].iter().map(|c| Rgb::from(c.to_array().map(f64::from))).collect();
        self.patches.with_colors(&colors)
    }
}
