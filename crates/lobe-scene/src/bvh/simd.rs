//! Which vector instructions rays use.

/// The vector instructions of a machine that rays know to use. All find the same hits, bit by bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Simd {
    /// None: any machine.
    Scalar,
    /// AVX2 and FMA of x86-64.
    Avx2,
    /// AVX-512 of x86-64: F, VL and what comes with them.
    Avx512,
}

impl Simd {
    /// From narrow to wide.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Avx2, Self::Avx512];

    /// The widest that this machine has.
    #[must_use]
    pub fn widest() -> Self {
        Self::ALL.into_iter().rev().find(|simd| simd.is_available()).unwrap_or(Self::Scalar)
    }

    /// Whether this machine has them.
    #[must_use]
    pub fn is_available(self) -> bool {
        crate::bvh::lanes::Machine::new(self).is_some()
    }
}
