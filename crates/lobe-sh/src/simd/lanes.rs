//! Sixteen numbers side by side.

use core::ops::{Index, IndexMut};

/// Numbers in one block: an AVX-512 register of `f32`, two of AVX2, four of NEON.
pub const LANES: usize = 16;

/// A number for each of sixteen items, one line of the cache.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// Zero in every lane.
    pub const ZERO: Self = Self::splat(0.0);

    /// One number in every lane.
    #[must_use]
    pub const fn splat(value: f32) -> Self {
        Self([value; LANES])
    }
}

impl Index<usize> for Lanes {
    type Output = f32;

    #[inline]
    fn index(&self, lane: usize) -> &f32 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Lanes {
    #[inline]
    fn index_mut(&mut self, lane: usize) -> &mut f32 {
        &mut self.0[lane]
    }
}

impl Default for Lanes {
    fn default() -> Self {
        Self::ZERO
    }
}
