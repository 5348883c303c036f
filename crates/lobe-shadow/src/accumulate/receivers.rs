//! Places on surfaces from which the sky is seen.

use crate::ShadowError;
use crate::accumulate::aim::ReceiverBlock;
use crate::accumulate::lanes::BLOCK;

/// Places on surfaces with their unit normals.
#[derive(Clone, Copy, Debug)]
pub struct SphereReceivers<'a> {
    positions: &'a [[f32; 3]],
    normals: &'a [[f32; 3]],
}

/// How far a normal's length may be from 1.
const UNIT: f32 = 1e-3;

impl<'a> SphereReceivers<'a> {
    /// Checks places and normals.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if there are not as many of both, a number is not finite, or a normal has not length 1.
    pub fn new(positions: &'a [[f32; 3]], normals: &'a [[f32; 3]]) -> Result<Self, ShadowError> {
        let invalid = |place: String, message: String| Err(ShadowError::Invalid { place, message });
        if positions.len() != normals.len() {
            let message =
                format!("expected a normal for each of {} positions, found {}", positions.len(), normals.len());
            return invalid("receivers".to_owned(), message);
        }
        if let Some(k) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return invalid(format!("receiver {k}"), format!("expected a finite position, found {:?}", positions[k]));
        }
        let is_unit = |n: &[f32; 3]| (n.iter().map(|c| c * c).sum::<f32>().sqrt() - 1.0).abs() <= UNIT;
        if let Some(k) = normals.iter().position(|n| !is_unit(n)) {
            return invalid(format!("receiver {k}"), format!("expected a normal of length 1, found {:?}", normals[k]));
        }
        Ok(Self { positions, normals })
    }

    /// The number of receivers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    pub(crate) fn position(&self, k: u32) -> [f32; 3] {
        self.positions[k as usize]
    }

    pub(crate) fn normal(&self, k: u32) -> [f32; 3] {
        self.normals[k as usize]
    }

    /// Those of up to sixteen numbers; the last one fills up.
    pub(crate) fn block(&self, members: &[u32]) -> ReceiverBlock {
        let mut block = ReceiverBlock { position: [[0.0; BLOCK]; 3], normal: [[0.0; BLOCK]; 3] };
        for k in 0..BLOCK {
            let member = members[k.min(members.len() - 1)] as usize;
            let (position, normal) = (self.positions[member], self.normals[member]);
            for axis in 0..3 {
                block.position[axis][k] = position[axis];
                block.normal[axis][k] = normal[axis];
            }
        }
        block
    }
}
