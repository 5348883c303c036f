//! The points at which shadow fields are asked.

use crate::ShadowError;

/// Points with normals, in the frame in which the entities are placed. Albedo and visibility of their own are as the
/// caller has them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowReceivers<'a> {
    positions: &'a [[f32; 3]],
    normals: &'a [[f32; 3]],
    albedos: &'a [[f32; 3]],
    own: &'a [f32],
}

impl<'a> ShadowReceivers<'a> {
    /// White points with unit normals, all of the sky open to them but for other entities.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if positions and normals differ in number, or a number is not finite.
    pub fn new(positions: &'a [[f32; 3]], normals: &'a [[f32; 3]]) -> Result<Self, ShadowError> {
        same(positions.len(), "normal", normals.len())?;
        for vectors in [positions, normals] {
            finite("vector", vectors.as_flattened(), 3)?;
        }
        Ok(Self { positions, normals, albedos: &[], own: &[] })
    }

    /// The part of light that each sends back, red, green and blue.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] unless there is one for each, and finite.
    pub fn with_albedos(self, albedos: &'a [[f32; 3]]) -> Result<Self, ShadowError> {
        same(self.len(), "albedo", albedos.len())?;
        finite("albedo", albedos.as_flattened(), 3)?;
        Ok(Self { albedos, ..self })
    }

    /// What each sees of the sky past the entity it belongs to, `order²` numbers each, as
    /// [`bake_visibility`](crate::bake_visibility) finds it. That entity is then not among those that are asked.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] unless there is one for each, and finite.
    pub fn with_own_visibility(self, order: usize, own: &'a [f32]) -> Result<Self, ShadowError> {
        let width = order * order;
        if own.len() != self.len() * width {
            return invalid(format!(
                "expected visibility of {width} numbers for each of {}, found {}",
                self.len(),
                own.len()
            ));
        }
        finite("visibility", own, width)?;
        Ok(Self { own, ..self })
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The points.
    #[must_use]
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.positions
    }

    /// Their unit normals.
    #[must_use]
    pub fn normals(&self) -> &'a [[f32; 3]] {
        self.normals
    }

    /// The albedo of one: white if none were given.
    pub(crate) fn albedo(&self, receiver: usize) -> [f32; 3] {
        self.albedos.get(receiver).copied().unwrap_or([1.0; 3])
    }

    /// The visibility of its own; `None` if none was given.
    pub(crate) fn own(&self, receiver: usize, width: usize) -> Option<&'a [f32]> {
        self.own.get(receiver * width..(receiver + 1) * width)
    }

    /// Numbers of visibility for each; 0 if none were given.
    pub(crate) fn own_width(&self) -> usize {
        self.own.len() / self.len().max(1)
    }
}

fn same(expected: usize, what: &str, found: usize) -> Result<(), ShadowError> {
    if expected == found {
        Ok(())
    } else {
        invalid(format!("expected one {what} for each of {expected}, found {found}"))
    }
}

fn finite(what: &str, numbers: &[f32], width: usize) -> Result<(), ShadowError> {
    match numbers.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(at) => invalid(format!("the {what} of receiver {} holds {}, no finite number", at / width, numbers[at])),
    }
}

fn invalid<T>(message: String) -> Result<T, ShadowError> {
    Err(ShadowError::Invalid { place: "receivers".to_owned(), message })
}
