//! Places on surfaces at which shadows are asked for.

use crate::error::ShadowError;

/// Bits of each coordinate along the curve.
const CURVE_BITS: u32 = 10;

/// How far a normal's length may be from 1.
const UNIT: f32 = 1e-3;

/// Points with unit normals, in the frame in which the occluders are placed. Albedo and visibility of their own are as the
/// caller has them; shadow fields use them.
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
    /// [`ShadowError::Invalid`] if positions and normals differ in number, a number is not finite, or a normal's length differs
    /// from 1 by more than a thousandth.
    pub fn new(positions: &'a [[f32; 3]], normals: &'a [[f32; 3]]) -> Result<Self, ShadowError> {
        same(positions.len(), "normal", normals.len())?;
        for vectors in [positions, normals] {
            finite("vector", vectors.as_flattened(), 3)?;
        }
        let is_unit = |n: &[f32; 3]| (n.iter().map(|c| c * c).sum::<f32>().sqrt() - 1.0).abs() <= UNIT;
        if let Some(k) = normals.iter().position(|n| !is_unit(n)) {
            return invalid(format!("expected normals of length 1, found {:?} at receiver {k}", normals[k]));
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
    /// [`ShadowError::Invalid`] unless there is one for each, finite, and of an order from 1 to 8.
    pub fn with_own_visibility(self, order: usize, own: &'a [f32]) -> Result<Self, ShadowError> {
        if !(1..=8).contains(&order) {
            return invalid(format!("expected visibility of an order of 1 to 8, found {order}"));
        }
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

    /// Their numbers along Morton's curve through their box, so that neighbors in the list are neighbors in space.
    pub(crate) fn coherent_order(&self) -> Vec<u32> {
        let corner = |of: fn(f32, f32) -> f32, start: f32| {
            self.positions.iter().fold([start; 3], |corner, p| [0, 1, 2].map(|c| of(corner[c], p[c])))
        };
        let (low, high) = (corner(f32::min, f32::INFINITY), corner(f32::max, f32::NEG_INFINITY));
        let side = (0..3).map(|c| high[c] - low[c]).fold(f32::MIN_POSITIVE, f32::max);
        let scale = ((1 << CURVE_BITS) - 1) as f32 / side;
        let key = |(k, p): (usize, &[f32; 3])| {
            let [x, y, z] = [0, 1, 2].map(|c| u64::from(spread(((p[c] - low[c]) * scale) as u32)));
            (x | y << 1 | z << 2) << 32 | k as u64
        };
        let mut keys: Vec<u64> = self.positions.iter().enumerate().map(key).collect();
        keys.sort_unstable();
        keys.into_iter().map(|key| key as u32).collect()
    }

    /// What each sees past the entity it belongs to, `order²` numbers each; empty if none were given.
    #[must_use]
    pub fn own_visibility(&self) -> &'a [f32] {
        self.own
    }

    /// The albedo of one: white if none were given.
    #[must_use]
    pub fn albedo(&self, receiver: usize) -> [f32; 3] {
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

/// Two zeros between any two of the ten lowest bits (Morton's curve).
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00FF;
    let x = (x | x << 8) & 0x0300_F00F;
    let x = (x | x << 4) & 0x030C_30C3;
    (x | x << 2) & 0x0924_9249
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
