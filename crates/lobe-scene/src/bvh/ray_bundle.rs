//! Ray bundles: rays from one point that are traversed together, and bit sets of them.

/// The most rays of a bundle: the bits of a set.
pub(crate) const BUNDLE: usize = 64;

/// A ray in a bundle.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct BundledRay {
    /// As in [`RayFrame`](crate::bvh::ray_frame::RayFrame).
    pub(crate) reciprocal: [f32; 3],
    /// With its longest component scaled to ±1.
    pub(crate) direction: [f32; 3],
    /// The index in its batch.
    pub(crate) place: u32,
    pub(crate) key: u32,
}

/// The numbers in a set.
#[inline(always)]
pub(crate) fn numbers(set: u64) -> impl Iterator<Item = usize> {
    let mut rest = set;
    std::iter::from_fn(move || {
        let number = (rest != 0).then(|| rest.trailing_zeros() as usize);
        rest &= rest.wrapping_sub(1);
        number
    })
}
